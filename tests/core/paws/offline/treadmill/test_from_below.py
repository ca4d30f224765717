"""One view from below, without a calibration: four paws in two rows on a painted belly."""

import cv2
import numpy as np
import pandas as pd
import pytest

from pawnb.core.paws.offline.scene.clicks import shows_two_rows
from pawnb.core.paws.offline.settings import OfflineSettings
from pawnb.core.paws.offline.treadmill.tracker import track_treadmill
from pawnb.core.paws.request import TrackingRequest
from pawnb.core.video import open_views
from pawnb.trial import load_trial

KINDS = ("front", "hind", "front", "hind")
FORWARD = np.array([1.0, 0.0])
N = 30
HOME = {"FR": (300, 165), "HR": (180, 175), "FL": (300, 95), "HL": (180, 85)}
LAG = {"FR": 0.0, "HL": 0.1, "FL": 0.5, "HR": 0.6}
TOML = """
[trial]
kind = "paws"
name = "below"
fps = 120.0
[animal]
id = "m"
[[views]]
name = "below"
video = "*.png"
points = ["FR", "HR", "FL", "HL"]
[start]
points = "start.csv"
"""


def placed(front, hind):
    return dict(enumerate(map(np.array, (front[0], hind[0], front[1], hind[1]))))


def test_two_rows_are_told_from_a_view_from_the_side():
    below = placed([(300.0, 165), (285.0, 95)], [(190.0, 175), (170.0, 85)])
    assert shows_two_rows(below, KINDS, FORWARD)
    # the far paws of a view from the side are a little higher, and one is lifted
    side = placed([(300.0, 200), (280.0, 175)], [(190.0, 200), (170.0, 182)])
    assert not shows_two_rows(side, KINDS, FORWARD)
    crossed = placed([(300.0, 200), (280.0, 120)], [(190.0, 110), (170.0, 100)])
    assert not shows_two_rows(crossed, KINDS, FORWARD)
    assert not shows_two_rows({0: below[0], 1: below[1]}, KINDS, FORWARD)


def place(point, frame):
    phase = (frame / 15.0 + LAG[point]) % 1.0
    along = 20.0 - 40.0 * phase / 0.6 if phase < 0.6 else -20.0 - 40.0 * (0.6 - phase) / 0.4
    return HOME[point][0] + along, float(HOME[point][1])


def paint(frame, rng):
    picture = np.full((260, 480, 3), (70, 74, 80), np.uint8)
    cv2.ellipse(picture, (240, 130), (110, 42), 0, 0, 360, (205, 200, 190), -1, cv2.LINE_AA)
    cv2.ellipse(picture, (365, 130), (34, 18), 0, 0, 360, (200, 195, 185), -1, cv2.LINE_AA)
    cv2.circle(picture, (399, 130), 5, (232, 150, 142), -1, cv2.LINE_AA)  # the nose is pink too
    for point in HOME:
        u, v = (round(16 * x) for x in place(point, frame))
        size = (16 * (16 if point[0] == "H" else 10), 16 * 7)
        cv2.ellipse(picture, (u, v), size, 0, 0, 360, (232, 150, 142), -1, cv2.LINE_AA, 4)
    return np.clip(picture + rng.normal(0, 3, picture.shape), 0, 255).astype(np.uint8)


@pytest.fixture(scope="module")
def trial(tmp_path_factory):
    folder = tmp_path_factory.mktemp("below")
    rng = np.random.default_rng(3)
    for frame in range(N):
        cv2.imwrite(str(folder / f"{frame:03d}.png"), paint(frame, rng)[..., ::-1])
    (folder / "trial.toml").write_text(TOML, encoding="utf-8")
    return load_trial(folder)


def test_paws_seen_from_below_keep_to_their_sides(trial):
    start = pd.DataFrame(
        [(0, "below", point, *np.round(place(point, 0))) for point in HOME],
        columns=["frame", "view", "point", "u", "v"],
    )
    task = TrackingRequest(
        rig=None, points_by_view={"below": list(HOME)}, fps=trial.fps, unit="px", frames=(0, N)
    )
    with open_views(trial) as views:
        tracks = track_treadmill(views, start, task, settings=OfflineSettings())
    for point in HOME:
        uv = tracks["image_position"].sel(keypoint=point).isel(view=0, individual=0).to_numpy()
        true = np.array([place(point, frame) for frame in range(N)])
        assert np.hypot(*(uv - true).T).max() < 7.0  # a paw is 14 px wide
