"""Text of motion capture systems, laid out as their programs write it."""

import warnings

import numpy as np
import pytest

from pawnb.errors import InputError, InputWarning
from pawnb.io import read_any_tracks, read_qtm, read_trc, read_vicon, recognise_format
from pawnb.io.points import by_subject
from pawnb.workflow.gait.sources import read_source

PLACE = np.random.default_rng(5).uniform(1.0, 90.0, (4, 2, 3)).round(3)
PLACE[2, 1] = np.nan


def row(values, missing=""):
    return [missing if np.isnan(v) else f"{v:.3f}" for v in values.ravel()]


def trc(path, *, unit="mm", first=1, begin=0, n=4, missing="", markers="FR\t\t\tHR\t\t"):
    """The lines of Pose2Sim's make_trc (first=0) and of OpenSim's own (first=1, an empty line)."""
    lines = [
        f"PathFileType\t4\t(X/Y/Z)\t{path.name}",
        "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\t"
        "OrigNumFrames",
        f"200.00\t200.00\t{n}\t2\t{unit}\t200.00\t1\t{n}",
        f"Frame#\tTime\t{markers}",
        "\t\tX1\tY1\tZ1\tX2\tY2\tZ2" + ("\n" if first else ""),
    ]
    for i, place in enumerate(PLACE):
        at = [str(begin + i + first), f"{(begin + i) / 200:.5f}"]
        lines.append("\t".join([*at, *row(place, missing)]))
    path.write_text("\n".join(lines) + "\n")
    return path


def qtm(path, *, columns=False, missing="0.000", included="3D"):
    """As the manual of QTM describes its TSV export, without and with the header of columns."""
    names = ["FR", "HR"]
    lines = ["NO_OF_FRAMES\t4", "NO_OF_CAMERAS\t8", "NO_OF_MARKERS\t2", "FREQUENCY\t200",
             "NO_OF_ANALOG\t0", "ANALOG_FREQUENCY\t0", "DESCRIPTION\t--",
             "TIME_STAMP\t2025-01-01, 10:00:00.000\t12345.6", f"DATA_INCLUDED\t{included}",
             "MARKER_NAMES\t" + "\t".join(names)]  # fmt: skip
    if columns:
        lines += [
            "TRAJECTORY_TYPES\tMeasured\tMeasured",
            "Frame\tTime\t" + "\t".join(f"{k} {a}" for k in names for a in "XYZ"),
        ]
    for i, place in enumerate(PLACE):
        at = [str(i + 1), f"{i / 200:.5f}"] if columns else []
        lines.append("\t".join([*at, *row(place, missing)]))
    path.write_text("\n".join(lines) + "\n")
    return path


def vicon(path, *, subjects=("m07", "m07"), unit="mm", below=""):
    lines = ["Trajectories", "200", f",,{subjects[0]}:FR,,,{subjects[1]}:HR,,",
             "Frame,Sub Frame,X,Y,Z,X,Y,Z", ",,"+",".join([unit] * 6)]  # fmt: skip
    lines += [",".join([str(i + 11), "0", *row(place)]) for i, place in enumerate(PLACE)]
    path.write_text("\n".join(lines) + "\n" + below)
    return path


def check(tracks, *, first=0, factor=1.0):
    place = tracks["position"].transpose("time", "keypoint", "space", "individual")[..., 0]
    np.testing.assert_allclose(place, factor * PLACE)
    assert tracks["keypoint"].to_numpy().tolist() == ["FR", "HR"]
    assert tracks["frame"].to_numpy().tolist() == list(range(first, first + 4))
    assert tracks.attrs["fps"] == 200.0


@pytest.mark.parametrize("first", [0, 1])
@pytest.mark.parametrize("begin", [0, 30])
@pytest.mark.parametrize("missing", ["", "NaN", "0.0"])
def test_trc(tmp_path, first, begin, missing):
    path = trc(tmp_path / "walk.trc", first=first, begin=begin, missing=missing)
    assert recognise_format(path) == "trc"
    with pytest.warns(InputWarning, match="in OpenSim y is up, which is taken to be z"):
        check(read_any_tracks(path), first=begin)


def test_trc_in_metres_comes_in_the_unit_of_its_trial(tmp_path):
    (tmp_path / "trial.toml").write_text(
        '[trial]\nkind = "tracks"\nname = "a"\nfps = 200.0\n[animal]\nid = "m07"\n'
        '[calibration]\nunit = "mm"\nup = [0, 1, 0]\n[tracks]\nfile = "walk.trc"\n'
    )
    trc(tmp_path / "walk.trc", unit="m")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        source = read_source(tmp_path / "trial.toml")
    check(source.tracks, factor=1000.0)
    assert source.tracks.attrs["units"] == "mm"


def test_times_of_a_trc_go_before_the_rate_in_its_header(tmp_path):
    # OpenSim's TRCFileAdapter takes the column Time; strides came out at a third of their frequency
    path = tmp_path / "walk.trc"
    path.write_text(long_trc(rate=60.0, step_s=1 / 200, decimals=3))
    with pytest.warns(InputWarning, match=r"walk.trc says 60 frames .* its times are those of 200"):
        tracks = read_trc(path, unit="mm")
    assert tracks.attrs["fps"] == 200.0
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert read_trc(path, unit="mm", fps=60.0).attrs["fps"] == 60.0  # as the warning advises
        for rate, step_s in ((59.94, 1 / 59.94), (200.0, 0.005), (30.0, 0.0), (200.0, 5.0)):
            path.write_text(long_trc(rate=rate, step_s=step_s))  # two decimals; none; ms
            assert read_trc(path, unit="mm").attrs["fps"] == rate


@pytest.mark.parametrize(("left_out", "decimals"), [(1, 3), (30, 3), (30, 2)])
def test_rows_left_out_of_a_trc_are_told_by_its_times(tmp_path, left_out, decimals):
    # as OpenSim writes it: TRCFileAdapter::extendWrite numbers rows 1, 2, 3 ... and keeps the times
    lines = long_trc(rate=100.0, step_s=0.01, decimals=decimals).splitlines()
    head, rows = lines[:5], [line.split("\t") for line in lines[5:]]
    kept = [*rows[:40], *rows[40 + left_out :]]
    text = ["\t".join([str(i), *cells[1:]]) for i, cells in enumerate(kept, start=1)]
    path = tmp_path / "walk.trc"
    path.write_text("\n".join([*head, *text]).replace("\t100\tmm", f"\t{len(kept)}\tmm") + "\n")
    tracks = read_trc(path, unit="mm")
    x = tracks["position"].isel(space=0).to_numpy().ravel()
    assert tracks.attrs["fps"] == 100.0
    assert np.isnan(x[40 : 40 + left_out]).all()
    seen = np.isfinite(x)
    np.testing.assert_array_equal(x[seen], tracks["frame"].to_numpy()[seen] + 1.0)
    assert seen.sum() == len(kept)


def long_trc(*, rate, step_s, unit="mm", decimals=2):
    """Text of 100 frames of one marker."""
    rows = [f"{i + 1}\t{i * step_s:.{decimals}f}\t{i + 1}\t2\t3" for i in range(100)]
    head = ["PathFileType\t4\t(X/Y/Z)\twalk.trc", "DataRate\tNumFrames\tUnits"]
    head += [f"{rate:g}\t100\t{unit}", "Frame#\tTime\tFR", "\t\tX1\tY1\tZ1"]
    return "\n".join([*head, *rows]) + "\n"


@pytest.mark.parametrize("unit", ["meters", "Meters", "M"])
def test_units_written_out_are_brought_to_that_of_the_trial(tmp_path, unit):
    # they were refused where the trial says mm, and beside files in m
    path = tmp_path / "walk.trc"
    path.write_text(long_trc(rate=100.0, step_s=0.01, unit=unit))
    assert read_trc(path, unit="mm")["position"].to_numpy().ravel()[:3].tolist() == [1e3, 2e3, 3e3]
    with pytest.warns(InputWarning, match="in OpenSim y is up"):
        assert read_trc(path).attrs["units"] == "m"


def test_a_trc_without_a_unit_is_said(tmp_path):
    path = tmp_path / "walk.trc"
    path.write_text(long_trc(rate=100.0, step_s=0.01, unit=""))
    with (
        pytest.warns(InputWarning, match=r"walk.trc: positions in space without a unit: lengths"),
        pytest.warns(InputWarning, match="in OpenSim y is up"),
    ):
        assert read_trc(path).attrs["units"] == "mm"


@pytest.mark.parametrize("columns", [False, True])
@pytest.mark.parametrize("missing", ["", "0.000", "NULL"])
def test_qtm(tmp_path, columns, missing):
    path = qtm(tmp_path / "walk.tsv", columns=columns, missing=missing)
    assert recognise_format(path) == "qtm"
    check(read_any_tracks(path))
    assert read_any_tracks(path).attrs["units"] == "mm"


def test_vicon(tmp_path):
    path = vicon(
        tmp_path / "walk.csv", below="\nModel Outputs\n200\n,,m07:Angle\nFrame\n,,deg\n1\n"
    )
    assert recognise_format(path) == "vicon"
    tracks = read_any_tracks(path)
    check(tracks, first=10)
    assert tracks["individual"].to_numpy().tolist() == ["m07"]


def test_vicon_with_force_plates_before_the_trajectories(tmp_path):
    # Nexus writes the parts that are chosen in this order, whose rows count sub frames
    path = vicon(tmp_path / "walk.csv")
    plates = "Devices\n1000\n,,Plate - Force,,\nFrame,Sub Frame,Fx,Fy,Fz\n,,N,N,N\n"
    plates += "".join(f"11,{i},0.1,0.2,9.8\n" for i in range(5)) + "\n"
    whole = path.read_text()
    path.write_text(plates + whole)
    assert recognise_format(path) == "vicon"
    check(read_any_tracks(path), first=10)
    path.write_text(plates)
    with pytest.raises(InputError, match=r"walk.csv: no part Trajectories; choose it as Nexus"):
        read_any_tracks(path)


def test_qtm_with_headings_of_the_axes_alone(tmp_path):
    path = qtm(tmp_path / "walk.tsv")
    names = "MARKER_NAMES\tFR\tHR\n"
    headings = "\t".join(f"{k} {a}" for k in ("FR", "HR") for a in "XYZ") + "\n"
    path.write_text(path.read_text().replace(names, names + headings))
    check(read_any_tracks(path))


def test_subjects_are_animals(tmp_path):
    tracks = read_vicon(vicon(tmp_path / "walk.csv", subjects=("m07", "m08")))
    assert tracks["individual"].to_numpy().tolist() == ["m07", "m08"]
    place = tracks["position"].transpose("time", "keypoint", "individual", "space").to_numpy()
    np.testing.assert_allclose(place[:, [0, 1], [0, 1]], PLACE)
    assert np.isnan(place[:, [0, 1], [1, 0]]).all()


@pytest.mark.parametrize(
    ("labels", "points", "animals"),
    [
        (["m1:FR", "m1:HR"], ["FR", "HR"], ["m1"]),
        (["m1:FR", "m2:FR"], ["FR"], ["m1", "m2"]),
        (["m1:FR", "*12"], ["FR", "*12"], ["m1"]),  # Vicon: a trajectory that nobody named
        (["m1:FR", "HR"], ["m1:FR", "HR"], ["animal"]),
        (["FR", "HR"], ["FR", "HR"], ["animal"]),
    ],
)
def test_labels_of_subjects_are_taken_apart(labels, points, animals):
    # m1:FR was taken for a middle leg by its m
    found = by_subject(labels, PLACE)
    assert found[:2] == (points, animals)
    assert np.isfinite(found[2]).sum() == np.isfinite(PLACE).sum()


def test_what_is_wrong_with_motion_capture_is_one_sentence(tmp_path):
    with pytest.raises(InputError, match=r"walk.tsv: it holds 6D data; expected .*choose 3D"):
        read_qtm(qtm(tmp_path / "walk.tsv", included="6D"))
    with pytest.raises(InputError, match=r"line 7 has more cells than the 1 markers need"):
        read_trc(trc(tmp_path / "walk.trc", markers="FR\t\t"), unit="mm")
    path = trc(tmp_path / "walk.trc")
    path.write_text(path.read_text().replace(f"{PLACE[1, 0, 2]:.3f}", "x"))
    with pytest.raises(InputError, match=r"walk.trc: line 8, cell 5 is 'x'; expected a number"):
        read_trc(path, unit="mm")
    with pytest.warns(InputWarning, match=r"says that it has 9 frames, and has 4"):
        read_trc(trc(tmp_path / "walk.trc", n=9), unit="mm")
    with pytest.warns(InputWarning, match=r"says 200 frames per second, and fps is given as 100"):
        assert read_qtm(qtm(tmp_path / "walk.tsv"), fps=100.0).attrs["fps"] == 100.0
