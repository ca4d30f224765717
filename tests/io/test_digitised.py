"""What readers of points digitised by hand have in common."""

import numpy as np
import pytest

from pawnb.errors import InputError, InputWarning
from pawnb.io import read_kinovea
from pawnb.io.digitised import frames_of_times, read_xml, to_frames


@pytest.mark.parametrize("unit", [1.0, 1e3, 1e6, 120.0])
def test_times_become_frames_in_whatever_unit_and_however_rounded(unit):
    """s, ms, µs and frames, rounded up, down and to the nearest ms as one file that a user of
    Kinovea published has them (0.016, 0.041, 0.342, 0.684 s at 120 frames per second)."""
    number = np.arange(100)
    exact = number * 1000 / 120
    ms = np.where(
        number < 41, np.floor(exact), np.where(number < 82, np.rint(exact), np.ceil(exact))
    )
    seconds = (ms if unit in (1.0, 1e3) else exact) / 1000
    assert frames_of_times(seconds * unit, fps=120.0, where="f").tolist() == number.tolist()


def test_frames_that_last_one_or_two_rounded_steps_are_counted_rightly():
    number = np.array([*range(60), *range(64, 90)])
    times = np.floor(number * 1.5 + 1e-9) / 1000  # 1.5 ms a frame, in whole ms
    assert frames_of_times(times, fps=1000 / 1.5, where="f").tolist() == number.tolist()


@pytest.mark.parametrize("kept", [(7, 8, 9, 12, 13, 40, 41), (0, 1, 3), (0, 4, 5, 11)])
def test_frames_that_were_not_digitised_keep_their_numbers(kept):
    number = np.array(kept)
    assert frames_of_times(number / 250, fps=250.0, where="f").tolist() == number.tolist()


def test_times_before_the_origin_count_from_the_first():
    assert frames_of_times(np.arange(-3, 4) / 250, fps=250.0, where="f").tolist() == [*range(7)]


def test_a_film_that_plays_slowed_down_is_said():
    with pytest.warns(InputWarning, match=r"steps of 0.04, .* a frame lasts 0.004 s.*slowed down"):
        frames = frames_of_times(np.arange(5) / 25, fps=250.0, where="f")
    assert frames.tolist() == [0, 1, 2, 3, 4]


def test_times_that_are_rounded_too_coarsely_are_refused():
    times = np.array([0.0, 0.001, 0.01, 0.02, 0.03, 0.04])
    with pytest.raises(InputError, match=r"f: times 0 and 0.001 are those of one frame"):
        frames_of_times(times, fps=100.0, where="f")


def test_one_time_is_one_frame():
    assert frames_of_times(np.array([0.5]), fps=100.0, where="f").tolist() == [0]


def test_half_a_frame_is_none():
    with pytest.raises(InputError, match=r"f: 1.5 is no number of a frame"):
        to_frames([1.0, 1.5], where="f")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('<?xml version="1.0"?>\n<!DOCTYPE a [<!ENTITY b "c">]>\n<a>&b;</a>', "defines entities"),
        ('<?xml version="1.0" encoding="utf8-x"?>\n<a/>', "damaged XML .*unknown encoding"),
        ("<a><b></a>", "damaged XML .*mismatched tag"),
    ],
)
def test_xml_that_is_damaged_or_grows_by_itself_is_refused(tmp_path, text, message):
    path = tmp_path / "clip.kva"
    path.write_text(text)
    with pytest.raises(InputError, match=rf"clip.kva: .*{message}"):
        read_xml(path, expected="a .kva")


def test_no_point_is_said(tmp_path):
    path = tmp_path / "clip.txt"
    path.write_text("#Kinovea Trajectory data export\n#T X Y\n\n")
    with pytest.raises(InputError, match=r"clip.txt: no point that was digitised"):
        read_kinovea(path, fps=100.0, unit="cm")
