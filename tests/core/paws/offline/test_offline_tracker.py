"""Points of filmed patches whose way is known: through clicks, windows, views and predictions."""

from __future__ import annotations

import dataclasses

import numpy as np
import pandas as pd
import pytest

from pawnb.core.parameters import parameters_set
from pawnb.core.paws.offline import learnt_run
from pawnb.core.paws.offline.detection.evidence import Detections
from pawnb.core.paws.offline.learnt_run import track_learnt
from pawnb.core.paws.offline.parameters import OfflineParameters, SceneParameters
from pawnb.core.paws.offline.quality.measures import CALIBRATED
from pawnb.core.paws.request import TrackingRequest
from pawnb.errors import InputError
from pawnb.schema import ORIGIN_CODE

pytestmark = pytest.mark.slow

N = 24
POINTS = ("FR", "HR")
QUICK = OfflineParameters(
    scene=SceneParameters(extent=90.0, spacing=4),
    appearance=dataclasses.replace(
        OfflineParameters().appearance, networks=1, copies=2, epochs=8, folds=1
    ),
)


def way(n=N):
    """Two patches that swing against each other, (n, 2 points, 2) px."""
    t = np.arange(n)
    swing = 18 * np.sin(2 * np.pi * t / 30)
    return np.stack(
        [np.stack([110 + swing, 70 + 0 * t], -1), np.stack([50 - swing, 70 + 0 * t], -1)], axis=1
    )


def film(make_texture, truth, *, seed=0):
    """Textured squares of 13 px, each with a texture of its own, over a smooth ground."""
    ground = make_texture(110, 160, seed=seed, low=60, high=110)
    patches = [make_texture(13, 13, seed=5 + i, low=0, high=255) for i in range(len(POINTS))]
    pictures = np.repeat(ground[None], len(truth), axis=0)
    for t, here in enumerate(truth.round().astype(int)):
        for patch, (u, v) in zip(patches, here, strict=True):
            pictures[t, v - 6 : v + 7, u - 6 : u + 7] = patch
    return pictures


def clicks(truth, frames, *, view="side", points=POINTS):
    rows = [
        (t, view, name, *truth[t, i])
        for t in frames
        for i, name in enumerate(POINTS)
        if name in points
    ]
    return pd.DataFrame(rows, columns=["frame", "view", "point", "u", "v"])


def task(**kept):
    return TrackingRequest(frames=(0, N), fps=100.0, points_by_view={"side": POINTS}, **kept)


def off(tracks, truth, view="side"):
    uv = tracks["image_position"].sel(view=view).isel(individual=0)
    uv = uv.transpose("time", "keypoint", "image_space").to_numpy()
    return np.linalg.norm(uv - truth, axis=-1)


@pytest.fixture(scope="module")
def truth():
    return way()


@pytest.fixture(scope="module")
def views(array_views, make_texture, truth):
    return array_views({"side": film(make_texture, truth)})


@pytest.mark.parametrize(
    "frames",
    [
        pytest.param([0], marks=pytest.mark.slow),
        [3, 20],
        pytest.param([2, 9, 15, 22], marks=pytest.mark.slow),
    ],
)
def test_points_are_tracked_from_any_number_of_clicked_frames(views, truth, frames):
    tracks = track_learnt(views, clicks(truth, frames), task(), parameters=QUICK)
    assert off(tracks, truth).max() < 4
    origin = tracks["image_origin"].isel(view=0, individual=0).to_numpy()
    assert (origin[frames] == ORIGIN_CODE["edited"]).all()
    np.testing.assert_allclose(off(tracks, truth)[frames], 0, atol=1e-9)
    assert tracks["image_confidence"].attrs[CALIBRATED] == 1
    assert tracks["image_confidence"].min() > 0
    assert tracks.attrs["body_frame"].startswith("side: ")


def test_a_part_of_the_points_may_be_clicked_in_a_frame(views, truth):
    start = pd.concat([clicks(truth, [2], points=["FR"]), clicks(truth, [9], points=["HR"])])
    found = track_learnt(views, start, task(), parameters=QUICK)
    assert (off(found, truth) < 4).mean() > 0.85


def test_a_point_without_any_click_is_refused(views, truth):
    with pytest.raises(InputError, match="'HR' is clicked in no view"):
        track_learnt(views, clicks(truth, [2], points=["FR"]), task(), parameters=QUICK)


@pytest.mark.slow
def test_views_without_a_rig_are_tracked_each_by_itself(array_views, make_texture, truth):
    mirrored = truth * [-1, 1] + [159, 0]
    views = array_views(
        {"side": film(make_texture, truth), "other": film(make_texture, mirrored, seed=9)}
    )
    start = pd.concat([clicks(truth, [4]), clicks(mirrored, [4], view="other")])
    asked = TrackingRequest(frames=(0, N), fps=100.0)
    tracks = track_learnt(views, start, asked, parameters=QUICK)
    assert (off(tracks, truth) < 4).mean() > 0.9
    assert (off(tracks, mirrored, "other") < 4).mean() > 0.9
    # position is that of the first view
    x = tracks["position"].isel(individual=0).transpose("time", "keypoint", "space").to_numpy()
    np.testing.assert_allclose(np.linalg.norm(x - truth, axis=-1), off(tracks, truth))


@pytest.mark.slow
def test_long_recordings_go_on_from_window_to_window(views, truth):
    with parameters_set({"run": {"window_rows": 16, "window_overlap": 8}}):
        tracks = track_learnt(views, clicks(truth, [4]), task(), parameters=QUICK)
    assert (off(tracks, truth) < 4).mean() > 0.85


def test_where_it_is_stopped_there_is_nothing(views, truth):
    tracks = track_learnt(views, clicks(truth, [2]), task(stop=lambda: True), parameters=QUICK)
    assert tracks.sizes["time"] == 0


@pytest.mark.slow
def test_a_kind_of_evidence_of_another_package_is_taken(
    array_views, make_texture, truth, monkeypatch
):
    """In pictures of noise only it can tell where the points go."""
    noise = np.stack([make_texture(110, 160, seed=t, low=0, high=255) for t in range(N)])
    views = array_views({"side": noise})

    class Known:
        name = "known"

        def detect(self, view, stack, *, annotations, points):
            row, point = (a.ravel() for a in np.mgrid[:N, : len(points)])
            sure, sd_px = np.full(len(row), 6.0), np.full(len(row), 2.0)
            return Detections(row, point, truth[row, point], sure, sd_px)

    start = clicks(truth, [2, 10, 20])
    alone = track_learnt(views, start, task(), parameters=QUICK)
    monkeypatch.setattr(learnt_run, "installed_evidence", lambda: [Known()])
    helped = track_learnt(views, start, task(), parameters=QUICK)
    # where nothing looks like the points some are missing
    assert np.nanmedian(off(alone, truth)) > 4
    assert np.median(off(helped, truth)) < 3
