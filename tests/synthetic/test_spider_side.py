"""The spider seen from above and, in a mirror, from the side: two views of one space."""

import av
import numpy as np
import pandas as pd
import pytest

from pawnb.core import dlt
from pawnb.schema import POINTS3D_COLUMNS
from pawnb.synthetic import render_spider_trial
from pawnb.synthetic.spider_scene import draw_individual, spider_scene
from pawnb.trial import load_trial

SCALE = 0.5


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Two views of an animal that stands still."""
    path = tmp_path_factory.mktemp("two")
    render_spider_trial(path, frames=20, scale=SCALE, seed=4, motion="still", views=2)
    return path


def table(folder, name):
    return pd.read_csv(folder / "truth" / f"{name}.csv")


def test_both_views_are_projections_of_the_points_in_space(folder):
    coefs = np.loadtxt(folder / "DLTcoefs.csv", delimiter=",")
    space, tracks = table(folder, "points3d"), table(folder, "tracks")
    assert list(space.columns) == list(POINTS3D_COLUMNS)
    trial = load_trial(folder)
    assert trial.calibration.dlt == "DLTcoefs.csv"
    for number, view in enumerate(trial.views):
        seen = tracks[tracks["view"] == view.name].merge(space, on=["frame", "point"])
        assert len(seen) == len(space)
        found = dlt.project(coefs[:, number], seen[["x", "y", "z"]].to_numpy())
        np.testing.assert_allclose(found[:, 0], seen[["u", "v"]], atol=1e-6)
        # the view is a crop of the file
        u0, v0, u1, v1 = view.crop
        assert seen["u"].between(0, u1 - u0).all()
        assert seen["v"].between(0, v1 - v0).all()


def test_segments_in_space_have_the_lengths_of_the_animal(folder):
    space = table(folder, "points3d").query("frame == 10").set_index("point")[["x", "y", "z"]]
    individual = draw_individual(spider_scene(seed=4))
    for leg in individual.animal.legs:
        names = [*(f"{leg.name}.{joint}" for joint in leg.joints), leg.name]
        lengths = np.linalg.norm(np.diff(space.loc[names].to_numpy(), axis=0), axis=1)
        np.testing.assert_allclose(lengths, individual.size * np.array(leg.lengths), atol=1e-6)
    # handedness: from above, with z towards the viewer, the left legs lie on the left
    ahead = space.loc["L1.BC"] + space.loc["R1.BC"] - space.loc["L4.BC"] - space.loc["R4.BC"]
    left = space.loc["L2"] - space.loc["R2"]
    assert ahead["x"] * left["y"] - ahead["y"] * left["x"] > 0


def test_the_animal_stands_on_the_ground_of_the_side_view(folder):
    with av.open(str(folder / "spider.avi")) as container:
        shots = np.stack([frame.to_ndarray() for frame in container.decode(video=0)]).astype(float)
    view = load_trial(folder).view("side")
    u0, v0, u1, v1 = view.crop
    shots = shots[:, v0:v1, u0:u1]
    share = shots[10:].mean(axis=0) / shots[:10].mean(axis=0)
    tracks = table(folder, "tracks").query("view == 'side' and frame == 10").set_index("point")
    assert (tracks["visible"] == 1).all()
    for leg in ("L1", "L4", "R1", "R4"):
        u, v = tracks.loc[[f"{leg}.PT", f"{leg}.TM"], ["u", "v"]].mean()  # middle of the tibia
        assert share[round(v) - 1 : round(v) + 2, round(u) - 1 : round(u) + 2].min() < 0.5
    dark = np.argwhere(share < 0.6)
    ground = tracks["v"].max()
    assert dark[:, 0].max() <= ground + 1.5
    assert dark[:, 0].min() > tracks["v"].min() - 6
