"""Landmarks are followed backwards from where they were placed; truth is where the picture was."""

import cv2
import numpy as np
import pandas as pd
import pytest

from pawnb.core.paws.layout import Placement, make_layout
from pawnb.core.paws.maghsoudi2019.settings import Maghsoudi2019Settings
from pawnb.core.paws.offline.landmarks.backward_tracking import frames_back, track_backwards
from pawnb.core.paws.offline.landmarks.template_tracking import TemplateTracker
from pawnb.core.paws.request import TrackingRequest

SIZE, N, BEGIN = 120, 24, 5


class Still:
    """A picture that is there already."""

    def __init__(self, picture):
        self.picture = picture
        self.height, self.width = picture.shape

    def crop(self, u0, v0, u1, v1):
        return self.picture[v0:v1, u0:u1]


class Views:
    """Two patches in one view, which go to and fro; frames are counted from ``BEGIN``."""

    names = ("side",)
    n_frames = BEGIN + N

    def __init__(self):
        angle = np.arange(N) / 12.0
        step = np.stack([14 * np.cos(angle), 14 * np.sin(angle)], axis=1)
        self.path = np.stack([np.array([38.0, 60.0]) + step, np.array([84.0, 60.0]) - step], axis=1)
        self.asked = []
        self.readers = {"side": Still(np.zeros((SIZE, SIZE)))}

    def frames(self, start, stop, *, step=1, partly=False):
        for t in range(start, stop, step):
            self.asked.append(t)
            yield t, {"side": self.draw(t - BEGIN)}

    def draw(self, row):
        picture = smooth_noise(0)
        v, u = np.mgrid[:SIZE, :SIZE]
        for p, at in enumerate(self.path[row]):
            shift = np.array([[1, 0, at[0] - SIZE / 2], [0, 1, at[1] - SIZE / 2]])
            there = cv2.warpAffine(smooth_noise(1 + p), shift, (SIZE, SIZE), flags=cv2.INTER_CUBIC)
            mask = np.exp(-((np.hypot(u - at[0], v - at[1]) / 15.0) ** 8))
            picture = there * mask + picture * (1 - mask)
        return Still(np.clip(picture, 0, 255).astype(np.uint8))


def smooth_noise(seed):
    """A texture without sharp edges, 0 to 255."""
    values = np.random.default_rng(seed).normal(size=(SIZE, SIZE))
    values = cv2.GaussianBlur(values, (0, 0), 2.0)
    return np.clip(128 + 60 * values / values.std(), 0, 255)


def followed(views, placed, stop=BEGIN + N):
    """Landmarks that were followed forwards."""
    start = pd.DataFrame({"frame": 0, "view": "side", "point": ["nose", "ear"], "u": 0.0, "v": 0.0})
    layout = make_layout(
        views, start, TrackingRequest(frames=(0, 99), fps=200.0), settings=Maghsoudi2019Settings()
    )  # fmt: skip
    follower = TemplateTracker(layout, placed)
    for t, pictures in views.frames(BEGIN, stop):
        follower.step(t, pictures)
    return follower


def at(views, point, row):
    return Placement(0, point, views.path[row, point])


def test_each_landmark_is_followed_back_from_where_it_was_first_placed():
    views = Views()
    placed = {BEGIN + 8: [at(views, 0, 8)], BEGIN + 16: [at(views, 0, 16), at(views, 1, 16)]}
    follower = followed(views, placed)
    ahead = [np.isfinite(uv[0, :, 0]).tolist() for uv in follower.uv]
    assert ahead == [[t >= 8, t >= 16] for t in range(N)]
    after = np.array(follower.uv)[8:, 0, 0].copy()
    views.asked.clear()
    done = []
    assert track_backwards(views, follower, BEGIN, progress=lambda *step: done.append(step))
    assert views.asked == list(range(BEGIN + 16, BEGIN - 1, -1))
    assert frames_back(placed, BEGIN) == 16
    assert done == [(N + k, N + 16) for k in range(1, 17)]
    away = np.linalg.norm(np.array(follower.uv)[:, 0] - views.path, axis=-1)
    assert away.max() < 0.5  # a patch is 15 px wide
    assert (np.array(follower.likeness)[:, 0] > 0.5).all()
    # what was followed forwards stays
    np.testing.assert_array_equal(np.array(follower.uv)[8:, 0, 0], after)


def test_nothing_is_looked_at_where_all_were_placed_at_once():
    views = Views()
    follower = followed(views, {BEGIN: [at(views, 0, 0), at(views, 1, 0)]})
    views.asked.clear()
    assert track_backwards(views, follower, BEGIN)
    assert views.asked == []


def test_a_click_that_an_interrupted_run_has_not_reached_says_nothing():
    views = Views()
    placed = {BEGIN + 4: [at(views, 0, 4)], BEGIN + 16: [at(views, 1, 16)]}
    follower = followed(views, placed, BEGIN + 10)
    assert track_backwards(views, follower, BEGIN)
    seen = np.isfinite(np.array(follower.uv)[:, 0, :, 0])
    assert seen[:, 0].all()
    assert not seen[:, 1].any()


@pytest.mark.parametrize("frames", [0, 5])
def test_a_stop_on_the_way_back_leaves_nothing_half_done(frames):
    views = Views()
    follower = followed(views, {BEGIN + 16: [at(views, 0, 16), at(views, 1, 16)]})
    asked = []
    stop = lambda: asked.append(None) or len(asked) > frames  # noqa: E731
    assert not track_backwards(views, follower, BEGIN, stop=stop)
    assert np.isnan(np.array(follower.uv)[:16]).all()
