"""Other programs' predictions: named in a trial, read, brought into the pixels of a view."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from pawnb.core.lens import Lens
from pawnb.core.video.views import ViewReader
from pawnb.errors import InputError
from pawnb.trial import Animal, Trial, View
from pawnb.workflow.checking.check import check_trial
from pawnb.workflow.provenance.record import trial_checksums, trial_fingerprint
from pawnb.workflow.tracking.predicted import doubt_predictions, match_points, read_predictions

POINTS = ("FR", "HR", "FL", "HL")


def source(width=640, height=480):
    """A video of which only the size matters."""
    picture = SimpleNamespace(width=width, height=height, is_colour=False)
    return SimpleNamespace(
        name="v.avi", n_frames=60, width=width, height=height, notes=[], stamps_s=None,
        is_variable_rate=False, grab=lambda index, partly=False: picture, close=lambda: None,
    )  # fmt: skip


def opened(*views, lens=None):
    """Views of a trial as far as predictions need them."""
    return SimpleNamespace(readers={v.name: ViewReader(v, source(), lens=lens) for v in views})


def trial_of(folder, views, detections, **more):
    return Trial(
        kind="paws", name="t", fps=100.0, animal=Animal(id="m1"), folder=folder,
        views=views, detections=detections, **more,
    )  # fmt: skip


def place(point, frame):
    """Where the README of the peer files says point k is: their formula, typed again."""
    k = POINTS.index(point)
    u = 200 + 60 * np.sin(2 * np.pi * 3 * frame / 100 + 1.5 * k) + 40 * k
    return np.array([u, 300 + 5 * np.cos(2 * np.pi * 3 * frame / 100 + k)])


@pytest.mark.parametrize(
    "name", ["dlc_single.csv", "dlc_single.h5", "dlc_multi.csv", "sleap.analysis.h5", "sleap.slp"]
)
def test_files_of_the_programs_themselves(real_data, name):
    """Of several animals the one is taken that is called as the trial's."""
    folder = real_data("peer-files")
    view = View(name="side", video="v.avi")
    trial = trial_of(folder, (view,), {"side": name})
    if name == "dlc_multi.csv":
        trial = dataclasses.replace(trial, animal=Animal(id="mouse1"))
    found = read_predictions(trial, opened(view), points=POINTS, frames=(5, 30))["side"]
    assert found.file == name
    assert found.points == POINTS
    assert found.uv.shape == (25, 4, 2)
    for row in (0, 24):
        for k, point in enumerate(POINTS):
            np.testing.assert_allclose(found.uv[row, k], place(point, row + 5), atol=1e-3)
    # HR is missing in frames 10 to 12
    assert np.flatnonzero(np.isnan(found.uv[:, 1, 0])).tolist() == [5, 6, 7]
    assert (found.likelihood[5:8, 1] == 0).all()
    there = np.isfinite(found.uv[..., 0])
    assert ((found.likelihood[there] > 0) & (found.likelihood[there] <= 1)).all()


def write_csv(path, points=("FR", "HR"), n=20):
    """Write what DeepLabCut would: point k of frame i at u = 100 + 10 i + 60 k, v = 50 + i."""
    lines = [
        ",".join(["scorer"] + ["net"] * 3 * len(points)),
        ",".join(["bodyparts", *(p for p in points for _ in range(3))]),
        ",".join(["coords", *["x", "y", "likelihood"] * len(points)]),
    ]
    for i in range(n):
        cells = [f"{100 + 10 * i + 60 * k},{50 + i},0.9" for k in range(len(points))]
        lines.append(",".join([str(i), *cells]))
    path.write_text("\n".join(lines) + "\n")


def test_frames_and_pixels_are_those_of_the_video(tmp_path):
    """A file's frame is the trial's plus the offset; then the crop, then the mirror."""
    write_csv(tmp_path / "a.csv")
    view = View(name="a", video="v.avi", crop=(90, 20, 390, 220), mirror=True, offset=3)
    trial = trial_of(tmp_path, (view,), {"a": "a.csv"})
    found = read_predictions(trial, opened(view), points=("HR", "FR"), frames=(2, 30))["a"]
    assert found.points == ("HR", "FR")
    # frame 2 is frame 5 of the file: FR at (150, 55); the crop is 300 px wide
    np.testing.assert_allclose(found.uv[0, 1], (299 - (150 - 90), 55 - 20))
    np.testing.assert_allclose(found.uv[0, 0], (299 - (210 - 90), 55 - 20))
    # the file ends with frame 19, which is 16 of the trial: row 14
    assert np.isfinite(found.uv[14]).all()
    assert np.isnan(found.uv[15:]).all()
    assert (found.likelihood[15:] == 0).all()


def test_predictions_on_a_bent_picture_are_straightened(tmp_path):
    """The radial term of Brown (1966): a straight x is filmed at x (1 + k1 r^2)."""
    lens = Lens(
        matrix=((400.0, 0.0, 320.0), (0.0, 400.0, 240.0), (0.0, 0.0, 1.0)),
        distortion=(-0.2, 0.0, 0.0, 0.0),
    )
    view = View(name="a", video="v.avi")
    straight = np.array([[120.0, 90.0], [320.0, 240.0], [500.0, 400.0]])
    x = (straight - [320, 240]) / 400
    filmed = 400 * x * (1 - 0.2 * (x**2).sum(axis=1, keepdims=True)) + [320, 240]
    reader = opened(view, lens=lens).readers["a"]
    np.testing.assert_allclose(reader.uv_of_file(filmed), straight, atol=0.05)
    assert np.abs(filmed - straight).max() > 5
    both = reader.uv_of_file(np.stack([filmed, np.full((3, 2), np.nan)]))
    np.testing.assert_allclose(both[0], straight, atol=0.05)
    assert np.isnan(both[1]).all()


def test_points_are_matched_by_name_in_capitals_or_not():
    match = {"where": "a.csv"}
    assert match_points(["fr", "Tail", "hr"], POINTS, {}, **match) == {"fr": "FR", "hr": "HR"}
    assert match_points(["fr", "FR"], ("FR",), {}, **match) == {"FR": "FR"}
    # what the trial says goes first, and a name that it speaks of is nothing else
    said = {"paw": "FR", "fr": "HR"}
    assert match_points(["fr", "paw"], POINTS, said, **match) == {"paw": "FR", "fr": "HR"}


@pytest.mark.parametrize(
    ("names", "renamed", "message"),
    [
        (
            ["front paw", "tail"],
            {},
            "a.csv has points front paw, tail, and the trial has FR, HR, FL, HL: name them alike, "
            "or say which is which under [tracking.detections_points], for instance "
            '"front paw" = "FR".',
        ),
        (
            ["FR"],
            {"paw": "FRR"},
            "[tracking.detections_points] paw is 'FRR', and the trial has no such point (did you "
            "mean 'FR'?); its points are FR, HR, FL, HL.",
        ),
    ],
)
def test_names_that_do_not_match_are_one_sentence(names, renamed, message):
    with pytest.raises(InputError) as error:
        match_points(names, POINTS, renamed, where="a.csv")
    assert str(error.value) == message


def test_what_cannot_be_used_is_one_sentence(tmp_path, real_data):
    view = View(name="a", video="v.avi")
    write_csv(tmp_path / "a.csv")

    def read(name, folder=tmp_path, frames=(0, 20)):
        trial = trial_of(folder, (view,), {"a": name})
        trial = dataclasses.replace(trial, animal=Animal(id="other"))
        return read_predictions(trial, opened(view), points=POINTS, frames=frames)

    with pytest.raises(InputError, match=r"b\.csv: no such file .did you mean 'a\.csv'"):
        read("b.csv")
    with pytest.raises(InputError, match=r"a\.csv has frames 0 to 19, none of 40 to 59 that are"):
        read("a.csv", frames=(40, 60))
    peers = real_data("peer-files")
    with pytest.raises(InputError, match=r"dlc_multi\.h5 has 2 animals, .* as \[animal\] id"):
        read("dlc_multi.h5", peers)
    with pytest.raises(InputError, match=r"anipose_3d\.csv has points in space"):
        read("anipose_3d.csv", peers)


def test_predictions_far_from_clicks_are_doubted(tmp_path):
    write_csv(tmp_path / "a.csv", points=("FR", "HR"))
    view = View(name="a", video="v.avi")
    trial = trial_of(tmp_path, (view,), {"a": "a.csv"})
    views = opened(view)
    found = read_predictions(trial, views, points=("FR", "HR"), frames=(0, 20))
    clicks = pd.DataFrame(
        {"frame": [4, 4], "view": "a", "point": ["FR", "HR"], "u": [141.0, 201.0], "v": 54.0}
    )
    assert doubt_predictions(found, clicks, views=views, first=0) == []
    far = clicks.assign(u=clicks["u"] + 99)
    (words,) = doubt_predictions(found, far, views=views, first=0)
    assert words.startswith("a.csv: predictions lie 100 px from the clicks in view 'a' (median")


@pytest.mark.slow
def test_check_reads_predictions(small_trial):
    toml = small_trial / "trial.toml"
    write_csv(small_trial / "a.csv", n=40)
    toml.write_text(toml.read_text() + '\n[tracking]\ndetections = ["a.csv", "", "", ""]\n')
    report = check_trial(small_trial)
    assert report.faults == []
    assert "predictions of view cam1 in a.csv: FR, HR, there in 100 % of frames" in report.found
    assert any(words.startswith("a.csv: predictions lie") for words in report.doubts)
    (small_trial / "a.csv").unlink()
    (fault,) = check_trial(small_trial).faults
    assert "a.csv: no such file" in fault


def test_predictions_are_inputs_of_the_run(tmp_path):
    write_csv(tmp_path / "a.csv")
    (tmp_path / "v.avi").write_bytes(b"video")
    view = View(name="a", video="v.avi")
    trial = trial_of(tmp_path, (view,), {"a": "a.csv"})
    assert set(trial_checksums(trial)) == {"a.csv", "v.avi"}
    assert trial_fingerprint(trial) != trial_fingerprint(dataclasses.replace(trial, detections={}))
