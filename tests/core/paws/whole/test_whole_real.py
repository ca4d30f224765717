"""The whole-recording tracker on a real grey recording: one camera, a side view and a mirror."""

import numpy as np
import pandas as pd
import pytest

from pawnb.core.paws import Task
from pawnb.core.paws.whole import WholeSettings, track_whole
from pawnb.core.rig import load_rig
from pawnb.core.video import open_views
from pawnb.trial import Animal, Calibration, Trial, View

LEGS = {"LH": "HL", "LF": "FL", "RF": "FR", "RH": "HR"}

# read by eye from frames without tracks, in the view from below, to about 8 px; by
# then the animal has changed from running to creeping, and its tail lies where a hind paw was
LATE = {
    400: {"HL": (205, 48), "FL": (216, 91), "FR": (207, 131), "HR": (168, 155)},
    930: {"HL": (195, 62), "FL": (308, 88), "FR": (225, 196), "HR": (172, 190)},
    960: {"HL": (195, 63), "FL": (241, 107), "FR": (292, 175), "HR": (102, 200)},
}


def read_marks(path):
    """The hand marks as clicks."""
    table = pd.read_csv(path)
    parts = [
        table[["frame", "paw", f"{view}_x", f"{view}_y"]]
        .set_axis(["frame", "point", "u", "v"], axis=1)
        .assign(view=view)
        for view in ("cam1", "cam2")
    ]
    marks = pd.concat(parts).dropna().replace({"point": LEGS})
    return marks[["frame", "view", "point", "u", "v"]].reset_index(drop=True)


@pytest.mark.slow
def test_grey_paws_in_a_side_view_and_a_mirror(real_data):
    folder = real_data("mouse-side-bottom")
    trial = Trial(
        kind="paws", name="mouse", fps=250.0, animal=Animal(id="mouse"), folder=folder,
        views=(View(name="cam1", video="test_vid.mp4", crop=(0, 0, 396, 168)),
               View(name="cam2", video="test_vid.mp4", crop=(0, 168, 396, 406))),
        calibration=Calibration(dlt="DLT_affine_fitted_from_labels.csv", unit="px"),
    )  # fmt: skip
    marks = read_marks(folder / "manual_paws.csv")
    with open_views(trial) as views:
        task = Task(rig=load_rig(trial), frames=(0, views.n_frames), fps=250.0)
        tracks = track_whole(views, marks[marks["frame"] == 0], task, settings=WholeSettings())
    image = tracks["image_position"].isel(individual=0).swap_dims(time="frame")
    for mark in marks[marks["frame"] > 0].itertuples():
        uv = image.sel(frame=mark.frame, view=mark.view, keypoint=mark.point).to_numpy()
        # the aim of the marks, which are good to 3 px, is 12 px
        assert np.hypot(*(uv - [mark.u, mark.v])) < 12.0, mark
    for frame, paws in LATE.items():
        for point, at in paws.items():
            uv = image.sel(frame=frame, view="cam2", keypoint=point).to_numpy()
            assert np.hypot(*(uv - at)) < 20.0, (frame, point, uv)
