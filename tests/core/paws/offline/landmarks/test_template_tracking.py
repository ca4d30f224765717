"""Landmarks are followed by their picture; truth is where the picture was put."""

from collections.abc import Sequence
from types import SimpleNamespace

import cv2
import numpy as np
import pandas as pd
import pytest

from pawnb.core.paws.layout import Placement, make_layout
from pawnb.core.paws.maghsoudi2019.settings import Maghsoudi2019Settings
from pawnb.core.paws.offline.landmarks import template_tracking
from pawnb.core.paws.offline.landmarks.template_tracking import TemplateTracker, window_px
from pawnb.core.paws.offline.landmarks.tracks import check_landmarks, choose_landmarks, join_views
from pawnb.core.paws.request import TrackingRequest
from pawnb.core.rig import Rig
from pawnb.errors import InputError

SIZE = 160
N = 30
HIDDEN = range(12, 18)
WINDOW = window_px(SIZE)

# three cameras that look along z, y and x, 2 px a unit
RIG = Rig(
    ("top", "side", "front"),
    np.array(
        [
            [2, 0, 0, 80, 0, 2, 0, 80, 0, 0, 0],
            [2, 0, 0, 80, 0, 0, -2, 80, 0, 0, 0],
            [0, 2, 0, 80, 0, 0, -2, 80, 0, 0, 0],
        ],
        dtype=float,
    ).T,
)


class Still:
    """A picture that is there already."""

    def __init__(self, picture):
        self.picture = picture

    def crop(self, u0, v0, u1, v1):
        return self.picture[v0:v1, u0:u1]


class Readers:
    width = height = SIZE


class OpenViews:
    """As much of opened views as a layout needs."""

    def __init__(self, names: Sequence[str]):
        self.names = tuple(names)
        self.n_frames = N
        self.readers = dict.fromkeys(self.names, Readers)


def smooth_noise(seed, size=SIZE):
    """A texture without sharp edges, 0 to 255."""
    values = np.random.default_rng(seed).normal(size=(size, size))
    values = cv2.GaussianBlur(values, (0, 0), 2.0)
    return np.clip(128 + 60 * values / values.std(), 0, 255)


def draw(background, texture, at):
    """Put the middle 41 px of a texture at a position between pixels."""
    shift = np.array([[1, 0, at[0] - SIZE / 2], [0, 1, at[1] - SIZE / 2]], dtype=float)
    there = cv2.warpAffine(texture, shift, (SIZE, SIZE), flags=cv2.INTER_CUBIC)
    v, u = np.mgrid[:SIZE, :SIZE]
    mask = np.exp(-((np.hypot(u - at[0], v - at[1]) / 20.0) ** 8))
    return np.clip(there * mask + background * (1 - mask), 0, 255).astype(np.uint8)


def layout_of(names, *, rig=None, points=("nose",)):
    start = pd.DataFrame({"frame": 0, "view": names[0], "point": points, "u": 0.0, "v": 0.0})
    return make_layout(
        OpenViews(names),
        start,
        TrackingRequest(frames=(0, N), fps=200.0, rig=rig),
        settings=Maghsoudi2019Settings(),
    )


def circle(n=N):
    """Where the landmark is, px: about 2 px a frame."""
    angle = np.arange(n) / 12.0
    return np.stack([80 + 24 * np.cos(angle), 80 + 24 * np.sin(angle)], axis=1)


def test_a_patch_is_followed_between_pixels_and_found_again_after_hiding():
    background, texture, path = smooth_noise(0), smooth_noise(1), circle()
    follower = TemplateTracker(layout_of(["side"]), {0: [Placement(0, 0, path[0])]})
    for t, at in enumerate(path):
        picture = background.astype(np.uint8) if t in HIDDEN else draw(background, texture, at)
        follower.step(t, {"side": Still(picture)})
    uv = np.array(follower.uv)[:, 0, 0]
    away = np.linalg.norm(uv - path, axis=1)
    seen = np.isfinite(away)
    assert not seen[list(HIDDEN)].any()
    assert seen[: HIDDEN.start].all()
    # while it was occluded it went on; where it is in reach of the search it is found again
    assert seen[HIDDEN.stop :].any()
    assert np.nanmax(away) < 0.3
    assert (np.array(follower.likeness)[:, 0, 0] > 0).tolist() == seen.tolist()


@pytest.mark.slow
def test_the_clicked_patch_keeps_errors_from_adding_up():
    """A slow drift of brightness and 200 frames: flow alone goes astray by a pixel or more."""
    background, texture = smooth_noise(2), smooth_noise(3)
    path = circle(200)
    rng = np.random.default_rng(4)
    follower = TemplateTracker(layout_of(["side"]), {0: [Placement(0, 0, path[0])]})
    for t, at in enumerate(path):
        picture = draw(background, texture, at) * (1.0 - 0.3 * t / 200) + rng.normal(
            0, 4, (SIZE, SIZE)
        )
        follower.step(t, {"side": Still(np.clip(picture, 0, 255).astype(np.uint8))})
    away = np.linalg.norm(np.array(follower.uv)[:, 0, 0] - path, axis=1)
    assert np.isfinite(away).all()
    assert np.median(away[-50:]) < 0.3


@pytest.mark.parametrize("n_views", [3, 2])
def test_a_view_that_the_others_contradict_is_left_out(n_views):
    """In one view the patch jumps away from where it belongs, and fades."""
    rig = RIG.subset(RIG.names[3 - n_views :])
    layout = layout_of(rig.names, rig=rig)
    background = [smooth_noise(seed) for seed in (5, 6, 7)]
    texture = smooth_noise(8)
    xyz = np.array([[0.5 * t, 3.0, 2.0] for t in range(8)])
    uv = rig.project(xyz)
    follower = TemplateTracker(layout, {0: [Placement(v, 0, uv[0, v]) for v in range(n_views)]})
    rng = np.random.default_rng(10)
    for t in range(8):
        pictures = {}
        for v, name in enumerate(rig.names):
            is_wrong = v == n_views - 1 and t >= 4
            picture = draw(background[v], texture, uv[t, v] + is_wrong * np.array([3.0, -12.0]))
            noise = rng.normal(0, 20 * is_wrong, picture.shape)
            pictures[name] = Still(np.clip(picture + noise, 0, 255).astype(np.uint8))
        follower.step(t, pictures)
    found = np.array(follower.uv)[:, :, 0]
    assert np.nanmax(np.linalg.norm(found[:, :-1] - uv[:, :-1], axis=-1)) < 0.4
    assert np.isfinite(found[:, :-1]).all()
    assert np.isfinite(found[:4, -1]).all()
    assert np.isnan(found[4, -1]).all()


def test_views_are_joined_and_long_gaps_stay_empty():
    layout = layout_of(RIG.names, rig=RIG)
    t = np.arange(N)
    xyz = np.stack([20 * np.sin(t / 9.0), 0.3 * t - 5, 2.0 + 0 * t], axis=1)
    uv = RIG.project(xyz)[:, None] + np.random.default_rng(9).normal(0, 0.3, (N, 1, 3, 2))
    uv[5:8], uv[15:25] = np.nan, np.nan
    uv[2, 0, 1] += 15.0  # one view was wrong once
    likeness = np.where(np.isfinite(uv[..., 0]), 0.9, 0.0)
    result = join_views(
        uv, likeness, by_hand=np.zeros(likeness.shape, bool), layout=layout, fps=200.0,
        max_occlusion_s=0.03,
    )  # fmt: skip
    x = result.x[:, 0]
    assert np.isnan(x[15:25]).all()
    rest = np.r_[0:15, 25:N]
    assert np.linalg.norm(x[rest] - xyz[rest], axis=1).max() < 0.5
    inside = np.abs(x - xyz)[rest] < 1.96 * result.sd[rest, 0]
    assert inside.mean() > 0.9
    # a single wrong view counts little in both passes
    assert np.nanmedian(result.forward_backward_distance) < 2.0
    assert np.isfinite(result.forward_backward_distance[3:-3]).all()
    assert np.isnan(result.association_log_odds).all()
    # what was not seen is known less well
    assert result.sd[6, 0].max() > result.sd[11, 0].max()


def test_which_points_are_landmarks():
    def chosen(names, named=()):
        kinds = [Maghsoudi2019Settings().kind(name) for name in names]
        return [n for n, is_one in zip(names, choose_landmarks(names, kinds, named), strict=True)
                if is_one]  # fmt: skip

    assert chosen(["FR", "HL", "nose", "P1"]) == ["nose", "P1"]
    # where no name tells a paw, only what is called after another part of the body
    assert chosen(["P1", "P2", "tail_base", "ear_L", "near"]) == ["tail_base", "ear_L"]
    assert chosen(["P1", "P2"], named=["P2"]) == ["P2"]
    assert chosen(["FR", "HL"]) == []
    with pytest.raises(InputError, match="setting 'landmarks' names 'nsoe'; the points are FR"):
        chosen(["FR"], named=["nsoe"])


def test_a_landmark_of_one_view_is_refused_in_space():
    layout = layout_of(RIG.names, rig=RIG)
    with pytest.raises(InputError, match="landmark 'nose' is clicked in view 'side' alone"):
        check_landmarks(layout, {0: [Placement(1, 0, np.zeros(2))]})
    check_landmarks(layout_of(["side"]), {0: [Placement(0, 0, np.zeros(2))]})


@pytest.mark.parametrize(("away", "place", "alike"), [(9.0, 39.0, 0.95), (11.0, 30.0, 0.0)])
def test_a_look_alike_beyond_half_a_patch_of_the_flow_is_not_believed(
    monkeypatch, away, place, alike
):
    """Flow ends at 30; what looks like the landmark is 9 or 11 px beyond, the patch 20 px wide."""
    flown = np.array([30.0, 5.0])
    monkeypatch.setattr(template_tracking, "_flow", lambda *_: flown)
    monkeypatch.setattr(
        template_tracking, "_align", lambda *_: (flown + np.array([away, 0.0]), 0.95)
    )
    monkeypatch.setattr(template_tracking, "_correlate", lambda *_: 1.0)
    state = SimpleNamespace(window=20, patches=[], is_seen=True, same=0.8, usual=0.9, on_flow=0)
    at, how = template_tracking._find(state, np.empty(0), np.empty(0), flown)
    assert (at[0], how) == (place, alike)
