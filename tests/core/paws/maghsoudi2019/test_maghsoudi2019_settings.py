"""Settings: the paper's defaults, and what is refused."""

from __future__ import annotations

import pytest

from pawnb.core.paws.maghsoudi2019.settings import Maghsoudi2019Settings, lengths_in_view
from pawnb.errors import InputError
from pawnb.schema import build_settings


def test_defaults_are_the_paper_s():
    settings = Maghsoudi2019Settings()
    # sections 3.2 and 4.3, Eq. 5
    assert (settings.window_u_px, settings.window_v_px) == (70, 40)
    assert settings.weights("FR") == settings.weights("FL") == (2, 0, 4, 2, 2, 0, 1, 4)
    assert settings.weights("HR") == settings.weights("HL") == (2, 0, 4, 1, 2, 0, 2, 4)
    assert settings.min_paw_area_px == 50
    assert settings.n_best == 3


def test_names_decide_between_front_and_hind_unless_they_are_listed():
    settings = Maghsoudi2019Settings(hind=("paw3", "Fluke"), front=("hand",))
    kinds = {name: settings.kind(name) for name in ("FL", "HR", "nose", "paw3", "Fluke", "hand")}
    assert kinds == {
        "FL": "front",
        "HR": "hind",
        "nose": "other",
        "paw3": "hind",
        "Fluke": "hind",
        "hand": "front",
    }
    assert settings.weights("nose") == (2, 0, 4, 2, 2, 0, 0, 4)


def test_landmarks_are_no_paws():
    """Only names of paws are; a paw that was named otherwise is listed."""
    settings = Maghsoudi2019Settings()
    paws = {"fr": "front", "HL": "hind", "FR_paw": "front", "HRtoe": "hind", "F": "front",
            "h2": "hind", "frontleft": "front", "forepaw": "front", "Hind_R": "hind", "LF": "front",
            "rh": "hind", "left_front": "front", "Right-Hind": "hind"}  # fmt: skip
    assert {name: settings.kind(name) for name in paws} == paws
    for name in (
        "head",
        "forehead",
        "hip",
        "flank",
        "fluke",
        "ear_L",
        "tail_base",
        "Hump",
        "leftear",
        "L3",
    ):
        assert settings.kind(name) == "other", name


@pytest.mark.parametrize(
    ("width", "scale", "expected"),
    [
        (2048, None, (70.0, 40.0, 5, 50.0)),
        (1024, None, (35.0, 20.0, 3, 12.5)),
        (396, 0.75, (52.5, 30.0, 3, 28.125)),
        (200, 0.1, (7.0, 4.0, 1, 0.5)),
    ],
)
def test_lengths_go_with_the_scale_and_areas_with_its_square(width, scale, expected):
    lengths = lengths_in_view(Maghsoudi2019Settings(scale=scale), width)
    found = (lengths.half_u, lengths.half_v, lengths.median, lengths.paw_area)
    assert found == pytest.approx(expected)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (
            {"window_u_px": 0},
            "setting 'window_u_px' is 0.0; expected a number above 0.",
        ),
        ({"slic_sigma_px": -1}, "setting 'slic_sigma_px' is -1.0; expected a number, 0 or more."),
        (
            {"weights_front": [1, 2, 3]},
            "setting 'weights_front' is [1.0, 2.0, 3.0]; expected 8 numbers, none below 0 and "
            "not all 0.",
        ),
        (
            {"weights_hind": [0] * 8},
            "setting 'weights_hind' is [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]; expected 8 "
            "numbers, none below 0 and not all 0.",
        ),
        (
            {"front": ["A"], "hind": ["A"]},
            "setting 'front' and setting 'hind' both name A; keep each point in one.",
        ),
        ({"scale": 0}, "setting 'scale' is 0.0; expected a number above 0."),
        ({"n_superpixels": -5}, "setting 'n_superpixels' is -5; expected a number above 0."),
    ],
)
def test_values_out_of_range_are_refused(values, message):
    with pytest.raises(InputError) as error:
        build_settings(Maghsoudi2019Settings, values, where="here")
    assert str(error.value) == message


def test_text_from_the_command_line_is_understood():
    settings = build_settings(
        Maghsoudi2019Settings,
        {"scale": "0.5", "hidden": "wait", "weights_front": "[1, 1, 1, 1, 1, 1, 1, 1]"},
        where="--set",
    )
    assert settings.scale == 0.5
    assert settings.hidden == "wait"
    assert settings.weights_front == (1,) * 8
