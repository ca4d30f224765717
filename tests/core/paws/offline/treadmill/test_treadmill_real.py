"""The whole-recording tracker on a real grey recording: one camera, a side view and a mirror."""

from pathlib import Path

import numpy as np
import pytest

from pawnb.core.paws.offline.settings import OfflineSettings
from pawnb.core.paws.offline.treadmill.tracker import track_treadmill
from pawnb.core.paws.request import TrackingRequest
from pawnb.core.rig import load_rig
from pawnb.core.video import open_views

# read by eye from frames without tracks, in the view from below, to about 8 px; by
# then the animal has changed from running to creeping, and its tail lies where a hind paw was
LATE = {
    400: {"HL": (205, 48), "FL": (216, 91), "FR": (207, 131), "HR": (168, 155)},
    930: {"HL": (195, 62), "FL": (308, 88), "FR": (225, 196), "HR": (172, 190)},
    960: {"HL": (195, 63), "FL": (241, 107), "FR": (292, 175), "HR": (102, 200)},
}


@pytest.mark.slow
def test_grey_paws_in_a_side_view_and_a_mirror(real_data, monkeypatch):
    monkeypatch.syspath_prepend(str(Path(__file__).parents[5] / "benchmarks"))
    from real_clip import read_marks, real_clip

    folder = real_data("mouse-side-bottom")
    trial, marks = real_clip(folder), read_marks(folder / "manual_paws.csv")
    with open_views(trial) as views:
        task = TrackingRequest(rig=load_rig(trial), frames=(0, views.n_frames), fps=250.0)
        tracks = track_treadmill(
            views, marks[marks["frame"] == 0], task, settings=OfflineSettings()
        )
    image = tracks["image_position"].isel(individual=0).swap_dims(time="frame")
    for mark in marks[marks["frame"] > 0].itertuples():
        uv = image.sel(frame=mark.frame, view=mark.view, keypoint=mark.point).to_numpy()
        # the aim of the marks, which are good to 3 px, is 12 px
        assert np.hypot(*(uv - [mark.u, mark.v])) < 12.0, mark
    for frame, paws in LATE.items():
        for point, at in paws.items():
            uv = image.sel(frame=frame, view="cam2", keypoint=point).to_numpy()
            assert np.hypot(*(uv - at)) < 20.0, (frame, point, uv)
