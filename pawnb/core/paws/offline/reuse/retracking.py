"""Tracking again after a correction or a further click: only between the clicks on either side.

Clicks close the model: what lies beyond the neighbouring clicks of a point bears on nothing
between them. What appearance is learnt from includes what was put in place, and how far kinds
are trusted stays as it was in the run before.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pandas as pd

from pawnb.arrays import FloatArray, IntArray
from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.parameters import APPEARANCE, RUN
from pawnb.core.paws.offline.scene.stack import BodyStack
from pawnb.core.paws.offline.self_training.learnt import Earlier, Learnt, learnt_of
from pawnb.core.paws.offline.self_training.weighing import Powers, Weighing
from pawnb.schema import ORIGIN_CODE, START_COLUMNS, Tracks

TRUST, MOTION_STATE, LEFT_OUT = "appearance_trust", "motion_trust", "left_out_offsets"
"""Attributes of tracks: how far appearance and motion were trusted beside the other kinds of
evidence, and what clicks that were left out say of each point (:class:`.weighing.Weighing`)."""


@dataclass(frozen=True)
class Again:
    """What is tracked again.

    Parameters
    ----------
    tracks : Tracks
        The tracks before, with corrections.
    frames : tuple of int
        First frame and one past the last.
    placed : sequence of int
        Frames in which points were put in place that were not before.
    closed : sequence of int
        Other frames in which they are put in place: those nearest to these ends, if any.
    """

    tracks: Tracks
    frames: tuple[int, int]
    placed: Sequence[int]
    closed: Sequence[int] = ()

    def rows_in(self, first: int, span: tuple[int, int]) -> tuple[int, int] | None:
        """Return the rows of a window, counted from its first; None where there is none.

        Parameters
        ----------
        first : int
            The frame that is row 0.
        span : tuple of int
            First row of the window and one past the last.
        """
        begin = max(self.frames[0] - first, span[0]) - span[0]
        end = min(self.frames[1] - first, span[1]) - span[0]
        return (begin, end) if begin < end else None

    def known(self, view: str, points: Sequence[str], first: int) -> Annotations:
        """Return where sure points of a view are at those ends that a click closes.

        Parameters
        ----------
        view : str
            The view.
        points : sequence of str
            Points, in the order of their numbers.
        first : int
            Frame of the first row.

        Returns
        -------
        Annotations
            Positions by row and number of the point.
        """
        uv, chance = self._of_view(view, points)
        places: dict[int, dict[int, np.ndarray]] = {}
        ends = {self.frames[0], self.frames[1] - 1} & {*self.placed, *self.closed}
        for t in np.flatnonzero(np.isin(self._frames, list(ends))):
            sure = np.flatnonzero(chance[t] >= RUN.retracking_sure)
            if len(sure):
                places[int(self._frames[t]) - first] = {int(p): uv[t, p] for p in sure}
        return Annotations(places)

    def earlier(
        self,
        view: str,
        points: Sequence[str],
        *,
        frames: tuple[int, int],
        stack: BodyStack,
        radius: float,
    ) -> Earlier | None:
        """Return the run before on a view, or None where it does not say what it has learnt.

        What it learnt from is left out where the tracks say something else by now, and in frames
        that are tracked again where what was put in place is nearer than any click before.

        Parameters
        ----------
        view : str
            The view.
        points : sequence of str
            Points, in the order of their numbers.
        frames : tuple of int
            First frame of the stack and one past its last.
        stack : BodyStack
            The view's pictures.
        radius : float
            About half a paw, working px.

        Returns
        -------
        Earlier or None
            Of the rows of the stack.
        """
        first, n = frames[0], frames[1] - frames[0]
        learnt = self._learnt(tuple(points), first).get(view)
        if learnt is None:
            return None
        uv, chance = np.full((n, len(points), 2), np.nan), np.zeros((n, len(points)))
        inside = (self._frames >= first) & (self._frames < frames[1])
        rows = self._frames[inside] - first
        uv[rows], chance[rows] = (own[inside] for own in self._of_view(view, points))
        training_frames = {
            row: own
            for row, own in learnt.part(0, n).training_frames.items()
            if not self._doubted(first + row)
            and all(
                np.linalg.norm(at - uv[row, p]) * stack.scale <= radius
                for p, at in own.points.items()
            )
        }
        return Earlier(Learnt(training_frames, learnt.agreement), uv, chance)

    @cached_property
    def _frames(self) -> IntArray:
        return np.asarray(self.tracks["frame"].to_numpy())

    def _learnt(self, points: tuple[str, ...], first: int) -> Mapping[str, Learnt]:
        return learnt_of(self.tracks, points, first)

    def _of_view(self, view: str, points: Sequence[str]) -> tuple[FloatArray, FloatArray]:
        """Return positions (n, P, 2) and how likely they are right (n, P); 0 where not seen."""
        own = self.tracks.isel(individual=0).sel(view=view, keypoint=list(points))
        uv = own["image_position"].transpose("time", "keypoint", "image_space").to_numpy()
        order = ("time", "keypoint")
        seen = own["image_origin"].transpose(*order).to_numpy() != ORIGIN_CODE["reprojected"]
        seen &= np.isfinite(uv).all(axis=-1)
        chance = own["image_confidence"].transpose(*order).to_numpy()
        return uv, np.where(seen, chance, 0.0)

    def _doubted(self, frame: int) -> bool:
        """Tell whether a frame is tracked again and was far from what was known before."""
        if not self.frames[0] <= frame < self.frames[1]:
            return False
        new = min(abs(frame - one) for one in self.placed)
        return all(abs(frame - one) > new for one in self.closed)


def weighing_as_attributes(weighing: Weighing, points: Sequence[str]) -> dict[str, float | str]:
    """Return what is to be known of a weighing when tracks are corrected, as their attributes.

    Attributes of files of tracks are numbers and text: offsets are written as JSON.
    """
    powers = {TRUST: float(weighing.powers.appearance), MOTION_STATE: float(weighing.powers.motion)}
    offsets = {points[p]: round(own, 4) for p, own in weighing.offsets.items()}
    return {**powers, LEFT_OUT: json.dumps(offsets)}


def weighing_of(tracks: Tracks, points: Sequence[str]) -> Weighing:
    """Return how far kinds were trusted in the run that made these tracks.

    Parameters
    ----------
    tracks : Tracks
        The tracks.
    points : sequence of str
        Points, in the order of their numbers.
    """
    powers = Powers(
        float(tracks.attrs.get(TRUST, APPEARANCE.trust)), float(tracks.attrs.get(MOTION_STATE, 1.0))
    )
    offsets = json.loads(tracks.attrs.get(LEFT_OUT, "{}"))
    return Weighing(powers, {p: offsets[name] for p, name in enumerate(points) if name in offsets})


def after_correction(tracks: Tracks, frame: int, points: Sequence[str]) -> Again:
    """Return what is tracked again after a correction: the frames up to the next click.

    Parameters
    ----------
    tracks : Tracks
        Tracks with the correction.
    frame : int
        The corrected frame.
    points : sequence of str
        The points that were put in place there.

    Returns
    -------
    Again
        From the frame to the next one in which each of the points is placed by hand in some
        view, or to the last of the tracks.
    """
    frames = tracks["frame"].to_numpy()
    by_hand = (tracks["image_origin"] == ORIGIN_CODE["edited"]).isel(individual=0).any("view")
    last, closed = frame, []
    for point in points:
        later = frames[by_hand.sel(keypoint=point).to_numpy() & (frames > frame)]
        last = max(last, int(later[0]) if len(later) else int(frames[-1]))
        closed += [int(later[0])] if len(later) else []
    return Again(tracks, (frame, last + 1), [frame], closed)


def after_clicks(
    tracks: Tracks, before: pd.DataFrame, clicks: pd.DataFrame, *, everywhere: bool = False
) -> Again | None:
    """Return what is tracked again after clicks were added: between those on either side.

    Parameters
    ----------
    tracks : Tracks
        Tracks from the clicks before.
    before, clicks : DataFrame
        Clicks before and now; columns frame, view, point, u, v (px).
    everywhere : bool
        Whether all frames are tracked again, as the pictures that they were found in are others.

    Returns
    -------
    Again or None
        None where clicks before are there no more or were moved, a point was not clicked at all,
        or nothing was added.
    """
    columns = list(START_COLUMNS)
    old = set(before[columns].itertuples(index=False, name=None))
    now = set(clicks[columns].itertuples(index=False, name=None))
    added = now - old
    if not old <= now or not added or {c[2] for c in added} - {c[2] for c in old}:
        return None
    frames = tracks["frame"].to_numpy()
    begin, end, closed = int(frames[-1]), int(frames[0]), set()
    for frame, _, point, *_ in added:
        others = {c[0] for c in old if c[2] == point}
        earlier, later = ([f for f in others if f < frame], [f for f in others if f > frame])
        begin = min(begin, max(earlier, default=int(frames[0])), frame)
        end = max(end, min(later, default=int(frames[-1])), frame)
        closed |= {*sorted(earlier)[-1:], *sorted(later)[:1]}
    placed = sorted({c[0] for c in added})
    if everywhere:
        whole = (int(frames[0]), int(frames[-1]) + 1)
        return Again(tracks, whole, placed, sorted({c[0] for c in old}))
    return Again(tracks, (begin, end + 1), placed, sorted(closed))
