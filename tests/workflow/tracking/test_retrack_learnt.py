"""Tracks by learnt evidence are corrected: honoured exactly, and nothing else is changed."""

from __future__ import annotations

import cv2
import numpy as np
import pandas as pd
import pytest

from pawnb.core.edits.log import EditLog, Move, Retrack
from pawnb.core.paws.offline.scene import stack
from pawnb.synthetic.grey_video import GreyVideoWriter
from pawnb.trial import load_trial
from pawnb.workflow.provenance.reproduce import reproduce
from pawnb.workflow.provenance.results import provenance_steps
from pawnb.workflow.tracking import kept_candidates
from pawnb.workflow.tracking.track import retrack, track

N, SIZE = 40, (200, 120)
POINTS = ("FR", "HR")
TRIAL = """
[trial]
kind = "paws"
name = "patches"
fps = 100.0
[animal]
id = "a1"
[[views]]
name = "side"
video = "side.avi"
points = ["FR", "HR"]
[start]
points = "start.csv"
[tracking]
evidence = "learnt"
"""


def way():
    swing = 15 * np.sin(2 * np.pi * np.arange(N) / 25)
    return np.stack(
        [np.stack([x + s * swing, np.full(N, 70.0)], -1) for x, s in ((135, 1), (60, -1))], axis=1
    )


def quiet(_done, _total):
    """No bar."""


@pytest.fixture(scope="module")
def trial(tmp_path_factory):
    """Two patches of noise swing over smooth ground; clicked in frames 3 and 30."""
    folder = tmp_path_factory.mktemp("patches")
    random = np.random.default_rng(0)

    def noise(width, height, low, high):
        grain = cv2.GaussianBlur(random.normal(size=(height, width)), (0, 0), 1.5)
        return (low + (high - low) * (0.5 + np.clip(grain / grain.std() / 4, -0.5, 0.5))).astype(
            np.uint8
        )

    ground, patches = noise(*SIZE, 60, 110), [noise(15, 15, 0, 255) for _ in POINTS]
    with GreyVideoWriter(folder / "side.avi", size=SIZE, fps=100.0) as video:
        for here in way().round().astype(int):
            picture = ground.copy()
            for patch, (u, v) in zip(patches, here, strict=True):
                picture[v - 7 : v + 8, u - 7 : u + 8] = patch
            video.write(picture)
    rows = [(t, "side", p, *way()[t, i]) for t in (3, 30) for i, p in enumerate(POINTS)]
    pd.DataFrame(rows, columns=["frame", "view", "point", "u", "v"]).to_csv(
        folder / "start.csv", index=False
    )
    (folder / "trial.toml").write_text(TRIAL)
    return load_trial(folder)


@pytest.fixture(scope="module")
def tracks(trial):
    return track(trial, progress=quiet)


def added(start):
    """The start with clicks in a frame more."""
    middle = [(16, "side", p, *way()[16, i]) for i, p in enumerate(POINTS)]
    return pd.concat([start, pd.DataFrame(middle, columns=start.columns)])


def positions(tracks, point):
    uv = tracks["image_position"].sel(view="side", keypoint=point).isel(individual=0)
    return uv.transpose("time", "image_space").to_numpy()


def correct(trial, tracks, frame, uv):
    log = EditLog(
        tracks, retrack=lambda t, f, **o: retrack(trial, t, f, progress=quiet, **o)
    )  # fmt: skip
    log.apply(Move(frame=frame, view="side", point="FR", u=uv[0], v=uv[1]))
    log.apply(Retrack(frame=frame))
    return log.tracks


@pytest.mark.slow
def test_a_correction_is_honoured_and_the_rest_is_unchanged(trial, tracks, monkeypatch):
    assert tracks.attrs["evidence"] == "learnt"
    place = way()[12, 0] + [0.0, 5.0]

    def refuse(*_, **__):
        raise AssertionError("it was kept")

    with monkeypatch.context() as patched:
        patched.setattr("pawnb.core.paws.offline.learnt_run.read_stacks", refuse)
        new = correct(trial, tracks, 12, place)
    uv, old = positions(new, "FR"), positions(tracks, "FR")
    np.testing.assert_array_equal(uv[12], place)
    assert (uv[13:16] != old[13:16]).any()
    for rows in (slice(0, 12), slice(30, N)):
        np.testing.assert_array_equal(uv[rows], old[rows])
    np.testing.assert_array_equal(positions(new, "HR"), positions(tracks, "HR"))
    kept_candidates._stacks.clear()  # another session
    fresh = correct(trial, tracks, 12, place)
    # the last digits of blurs differ, and learning makes them more
    np.testing.assert_allclose(positions(fresh, "FR"), uv, atol=0.2)
    np.testing.assert_allclose(fresh["image_confidence"], new["image_confidence"], atol=0.05)


@pytest.mark.slow
def test_of_another_recording_nothing_is_kept(trial, tracks, tmp_path, monkeypatch):
    """The same trial with a video of which one byte differs."""
    for name in ("trial.toml", "start.csv"):
        (tmp_path / name).write_bytes((trial.path(name)).read_bytes())
    (tmp_path / "side.avi").write_bytes(trial.path("side.avi").read_bytes() + b"\0")
    read = []
    plain = stack.read_stacks

    def counted(*args, **kept):
        read.append(1)
        return plain(*args, **kept)

    monkeypatch.setattr("pawnb.core.paws.offline.learnt_run.read_stacks", counted)
    start = pd.read_csv(trial.path("start.csv"))
    with kept_candidates.new_session():
        track(trial, start=start, progress=quiet)
        read.clear()
        track(trial, start=added(start), quick=True, progress=quiet)
        assert not read
        track(load_trial(tmp_path), start=added(start), quick=True, progress=quiet)
        assert read


@pytest.mark.slow
def test_a_run_from_all_clicks_does_not_depend_on_those_before_it(trial):
    """As is said of every result: equal inputs, equal bytes."""
    start = pd.read_csv(trial.path("start.csv"))
    with kept_candidates.new_session():
        alone = track(trial, start=added(start), progress=quiet)
    with kept_candidates.new_session():
        track(trial, start=start, progress=quiet)
        after = track(trial, start=added(start), progress=quiet)
        again = track(trial, start=added(start), quick=True, progress=quiet)  # nothing was added
    assert after.identical(alone)
    assert again.identical(alone)
    assert "gone_on_from_clicks" not in provenance_steps(after)[0]


@pytest.mark.slow
def test_a_run_that_went_on_from_another_is_made_again_from_both(trial, tmp_path):
    """The frames before the first click and after the last of the run before are of that run."""
    with kept_candidates.new_session():
        start = pd.read_csv(trial.path("start.csv"))
        first = track(trial, progress=quiet)
        out = tmp_path / "results"
        new = track(trial, start=added(start), out=out, quick=True, progress=quiet)
        np.testing.assert_array_equal(positions(new, "HR")[31:], positions(first, "HR")[31:])
        assert provenance_steps(new)[0]["gone_on_from_clicks"] == [start.to_dict("records")]
    found = reproduce(out / "tracks.csv", inputs=trial.folder)
    assert found.identical, found.difference
