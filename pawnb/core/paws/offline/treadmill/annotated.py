"""What a person gave, checked: points, views, clicks and corrections."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import pandas as pd

from pawnb.arrays import BoolArray
from pawnb.core.paws.layout import Layout, Placement, Views, make_layout, only_points, read_start
from pawnb.core.paws.maghsoudi2019.settings import Maghsoudi2019Settings
from pawnb.core.paws.offline.treadmill.annotations import read_placements
from pawnb.core.paws.request import TrackingRequest
from pawnb.errors import InputError
from pawnb.schema import START_COLUMNS, check_columns


@dataclass(frozen=True)
class Annotated:
    """What a person gave.

    Attributes
    ----------
    layout : Layout
        Points and views.
    clicks, anchors : dict
        Frame to the clicks that say what paws look like, and to what tracks must pass through.
    first, begin : int
        First frame that is tracked, and that is looked at: clicks of an earlier run may lie
        before it.
    is_looked : bool
        Whether ``clicks`` are those of an earlier run.
    """

    layout: Layout
    clicks: Mapping[int, Sequence[Placement]]
    anchors: Mapping[int, Sequence[Placement]]
    first: int
    begin: int
    is_looked: bool

    def of(self, points: BoolArray) -> Annotated:
        """Return what concerns some of the points, a mask."""
        return dataclasses.replace(
            self,
            layout=self.layout.only(points),
            clicks=only_points(self.clicks, points),
            anchors=only_points(self.anchors, points),
        )

    def inside(self, n: int) -> dict[int, Sequence[Placement]]:
        """Return the anchors in the first n frames tracked, by row."""
        return {t - self.first: here for t, here in self.anchors.items() if t - self.first < n}


def read_request_and_annotations(
    views: Views, start: pd.DataFrame, task: TrackingRequest, *, looked: pd.DataFrame | None = None
) -> Annotated:
    """Return what a person gave, checked.

    Parameters
    ----------
    views : Views
        The opened views.
    start : DataFrame
        Clicks with columns frame, view, point, u, v (px).
    task : TrackingRequest
        What is to be tracked.
    looked : DataFrame, optional
        Earlier clicks by which the recording was searched.

    Returns
    -------
    Annotated
        Layout, clicks and what is certain.
    """
    check_columns(start, START_COLUMNS, where="the start points")
    task.check_frames(views.n_frames)
    frames = task.frames
    if task.rig is None and len(views.names) > 1:
        raise InputError(
            f"{len(views.names)} views and no calibration; this method joins views in space: "
            "calibrate them, or keep one view."
        )
    layout = make_layout(views, start, task, settings=Maghsoudi2019Settings())
    clicks, anchors = read_placements(start, layout, frames, tracks=task.tracks)
    begin, is_looked = frames[0], False
    if looked is not None and len(looked):
        is_looked = True
        clicks = read_start(looked, layout, (0, frames[1]))
        begin = min(begin, *clicks)
    return Annotated(layout, clicks, anchors, frames[0], begin, is_looked)
