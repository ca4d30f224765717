"""C3D whose unit and frame rate are others than those asked for, and of many points."""

import warnings

import numpy as np
import pytest

from pawnb.errors import InputError, InputWarning
from pawnb.input_warnings import hearing_input_warnings, hide_warnings_of
from pawnb.io import read_c3d, write_c3d
from pawnb.io.points import build_tracks

pytest.importorskip("c3d")


def clip(path, *, unit="m", points=("FR", "HR")):
    """Two frames at 200 Hz, in the unit given."""
    place = np.full((2, len(points), 1, 3), 0.25)
    tracks = build_tracks(
        [0, 1], place, points=list(points), fps=200.0, unit=unit, program="a test", where="clip"
    )
    return write_c3d(tracks, path)


def test_lengths_come_in_the_unit_asked_for(tmp_path):
    path = clip(tmp_path / "clip.c3d")
    for unit, expected in (("mm", 250.0), ("cm", 25.0), ("m", 0.25), (None, 0.25)):
        tracks = read_c3d(path, unit=unit)
        assert tracks.attrs["units"] == (unit or "m")
        np.testing.assert_allclose(tracks["position"], expected)


def test_a_unit_that_is_not_known_is_not_put_on_other_lengths(tmp_path):
    path = clip(tmp_path / "clip.c3d")
    with pytest.raises(InputError, match=r"clip.c3d: positions are in 'm', and 'BL' is asked for"):
        read_c3d(path, unit="BL")


def test_units_written_out_and_those_that_lack(tmp_path):
    import c3d

    hide_warnings_of("c3d")  # that it writes no analog data
    for said, expected in (("meters", "m"), ("Millimeters", "mm"), ("", "mm")):
        writer = c3d.Writer(point_rate=200.0, point_scale=-1.0)
        writer.set_point_labels(["FR", "HR"])
        writer.point_group.add_str("UNITS", "", said, len(said))
        writer.add_frames([(np.ones((2, 5)), np.zeros((0, 0)))])
        with (tmp_path / "clip.c3d").open("wb") as file:
            writer.write(file)
        told: list[InputWarning] = []
        with hearing_input_warnings(told.append, shown=False):
            assert read_c3d(tmp_path / "clip.c3d").attrs["units"] == expected
        assert len(told) == (said == "")
        assert all("clip.c3d: positions in space without a unit: le" in str(one) for one in told)


def test_another_frame_rate_is_said(tmp_path):
    path = clip(tmp_path / "clip.c3d")
    with pytest.warns(InputWarning, match=r"clip.c3d says 200 frames per second, and fps is given"):
        assert read_c3d(path, fps=100.0).attrs["fps"] == 100.0
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert read_c3d(path, fps=200.0).attrs["fps"] == 200.0


def test_a_subject_before_the_labels_is_the_animal(tmp_path):
    # Vicon's labels; m1:FR and m1:HR were taken for one middle leg
    tracks = read_c3d(clip(tmp_path / "clip.c3d", points=("m1:FR", "m1:HR")))
    assert tracks["keypoint"].to_numpy().tolist() == ["FR", "HR"]
    assert tracks["individual"].to_numpy().tolist() == ["m1"]


@pytest.mark.parametrize("subject", ["", "m1:"])
def test_outputs_of_models_and_points_without_a_label_are_no_feet(tmp_path, subject):
    # Vicon keeps them as points and lists them in POINT:ANGLES, FORCES ...; angles that came first
    # were taken for the feet
    import c3d

    hide_warnings_of("c3d")
    names = ["LHindPawAngles", "LHindPaw", "RHindPaw", "LHindPawForce", ""]
    labels = [subject * bool(name) + name for name in names]
    writer = c3d.Writer(point_rate=200.0, point_scale=-1.0)
    writer.set_point_labels(labels)
    for kind, label in (("ANGLES", labels[0]), ("FORCES", names[3])):
        writer.point_group.add_str(kind, "", label.ljust(24), 24, 1)
    writer.add_frames([(np.arange(5.0)[:, None].repeat(5, axis=1), np.zeros((0, 0)))])
    with (tmp_path / "clip.c3d").open("wb") as file:
        writer.write(file)
    tracks = read_c3d(tmp_path / "clip.c3d", unit="mm")
    assert tracks["keypoint"].to_numpy().tolist() == ["LHindPaw", "RHindPaw"]
    assert tracks["position"].isel(space=0).to_numpy().ravel().tolist() == [1.0, 2.0]


def test_a_file_with_one_analog_channel(tmp_path):
    # ezc3d 1.7.2 writes OFFSET and SCALE of a single channel, such as a trigger, as plain numbers
    import c3d

    writer = c3d.Writer(point_rate=200.0, analog_rate=400.0, point_scale=-1.0)
    writer.set_point_labels(["FR", "HR"])
    writer.set_analog_labels(["trigger"])
    row = np.array([[1.5, 2.5, 3.5, 0.0, 0.0], [4.5, 5.5, 6.5, 0.0, 0.0]])
    writer.add_frames([(row, np.zeros((1, 2)))] * 3)
    for name, kind, value in (("OFFSET", "<h", 0), ("SCALE", "<f", 1.0)):
        size = np.dtype(kind).itemsize
        writer.analog_group.add(name, "of the one channel", size, kind, value)
    writer.get_analog_transform = lambda: (1.0, 0.0)  # which cannot write it either
    with warnings.catch_warnings(), (tmp_path / "clip.c3d").open("wb") as file:
        warnings.simplefilter("ignore")
        writer.write(file)
    place = read_c3d(tmp_path / "clip.c3d")["position"]
    own = place.isel(individual=0).transpose("time", "keypoint", "space").to_numpy()
    np.testing.assert_allclose(own, [row[:, :3]] * 3)
