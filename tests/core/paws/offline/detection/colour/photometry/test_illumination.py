"""Light that drifts, flickers and changes its colour does not lose the paws."""

import dataclasses

import numpy as np
import pandas as pd
import pytest

from pawnb.core.paws.offline.detection.colour.photometry.background import estimate_background
from pawnb.core.paws.offline.detection.colour.photometry.illumination import (
    mean_illumination,
    normalise_illumination,
)
from pawnb.core.paws.offline.settings import OfflineSettings
from pawnb.core.paws.offline.treadmill.tracker import track_treadmill
from pawnb.core.paws.request import TrackingRequest
from pawnb.core.rig import load_rig
from pawnb.core.video import open_views
from pawnb.synthetic import render_mouse_trial
from pawnb.trial import load_trial


@pytest.mark.parametrize("shape", [(40, 60, 3), (40, 60)])
def test_a_picture_is_made_as_bright_and_of_the_colour_that_it_was(shape):
    before = np.random.default_rng(0).integers(20, 160, shape).astype(np.uint8)
    gain = np.array([0.5, 0.7, 1.4]) if len(shape) == 3 else 0.6
    after = np.round(before * gain).astype(np.uint8)
    again = normalise_illumination(after, mean_illumination(before))
    # half a level was lost, and as much is lost again
    assert np.abs(again.astype(float) - before).max() <= 0.5 / np.min(gain) + 1.0


def test_steady_light_changes_nothing():
    picture = np.random.default_rng(0).integers(20, 160, (40, 60, 3)).astype(np.uint8)
    slightly = tuple(1.05 * level for level in mean_illumination(picture))
    assert normalise_illumination(picture, slightly) is picture
    assert normalise_illumination(picture, None) is picture


@dataclasses.dataclass
class Lit:
    """A picture in other light."""

    picture: object
    gain: np.ndarray

    def __post_init__(self):
        self.width, self.height = self.picture.width, self.picture.height

    def crop(self, *box):
        pixels = self.picture.crop(*box)
        gain = self.gain if pixels.ndim == 3 else self.gain.mean()
        return np.clip(pixels * gain + 0.5, 0, 255).astype(np.uint8)


class LitViews:
    """Views of a recording whose light goes down to a half, and is redder in the end."""

    def __init__(self, views):
        self.views, self.names, self.readers = views, views.names, views.readers
        self.n_frames = views.n_frames

    def frame(self, index):
        gain = 1.0 - np.array([0.5, 0.6, 0.65]) * index / (self.n_frames - 1)
        return {name: Lit(picture, gain) for name, picture in self.views.frame(index).items()}

    def frames(self, first, last, *, partly=False):
        for index in range(first, last):
            yield index, self.frame(index)


class Wall:
    """One grey view of a wall of three shades, in which nothing moves."""

    names, n_frames, width, height = ("side",), 24, 60, 20

    def frame(self, _index):
        return {"side": self}

    def crop(self, u0, v0, u1, v1):
        return np.repeat(np.array([[60, 120, 180]], np.uint8), 20, axis=1).repeat(20, axis=0)[
            v0:v1, u0:u1
        ]


def test_what_stands_still_is_shown_in_the_light_of_the_clicks():
    wall = Wall()
    wall.readers = {}
    lit = LitViews(wall)
    shown = lit.frame(23)["side"].crop(0, 0, 60, 20)
    (still,) = estimate_background(lit, [(60, 20)], {0: shown})
    np.testing.assert_allclose(still, shown, atol=3)


@pytest.mark.slow
def test_paws_are_followed_while_the_light_goes_down_to_a_half(tmp_path):
    trial = load_trial(render_mouse_trial(tmp_path, frames=24, scale=0.35, seed=2))
    truth = pd.read_csv(trial.folder / "truth" / "tracks.csv")
    start = pd.read_csv(trial.folder / "start.csv")
    task = TrackingRequest(
        rig=load_rig(trial), points_by_view={view.name: view.points for view in trial.views},
        fps=trial.fps, unit="mm", frames=(0, 24),
    )  # fmt: skip
    with open_views(trial) as views:
        tracks = track_treadmill(LitViews(views), start, task, settings=OfflineSettings())
    rows = truth[truth["visible"] == 1]
    rows = rows[[row.point in task.points_by_view[row.view] for row in rows.itertuples()]]
    uv = tracks["image_position"].isel(individual=0)
    seen = uv.sel(
        view=rows["view"].to_xarray(), keypoint=rows["point"].to_xarray()
    ).isel(time=rows["frame"].to_xarray()).transpose("index", "image_space").to_numpy()  # fmt: skip
    away = np.linalg.norm(seen - rows[["u", "v"]].to_numpy(), axis=1)
    # 20 px in a picture 2048 px wide is the evaluation's limit of a wrong label
    assert np.mean(away < 20 * 0.35) > 0.95
