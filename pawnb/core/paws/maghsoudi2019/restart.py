"""Tracking again from a corrected frame: every state is made anew from the tracks' rows.

Haji Maghsoudi et al. 2019, section 3.1: features, coordinates, Kalman filter and 3D
coordinates have to be reset when a person has edited a frame.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from pawnb.arrays import BoolArray, FloatArray, IntArray, Points2D
from pawnb.core.paws.layout import Layout, Placement, Views, read_start
from pawnb.core.paws.maghsoudi2019.run import Run
from pawnb.core.paws.maghsoudi2019.settings import REFERENCE_WIDTH_PX
from pawnb.core.paws.retracked_span import TOLERANCE_PX, Stretch
from pawnb.errors import InputError
from pawnb.schema import ORIGIN_CODE, ORIGINS, Tracks

_FOUND = [ORIGIN_CODE[name] for name in ("measured", "resolved", "edited")]
"""Definition: origins of positions that a picture shows, or a person."""

_FOLLOWED_FRAMES = 50
"""Numerics: the filter forgets; what is older moves a state by less than rounding does."""


@dataclass(frozen=True)
class _Rows:
    """Tracks as arrays in the order of the layout: n rows, V views, P points."""

    frames: IntArray  # (n,)
    uv: Points2D  # (n, V, P, 2), px
    origin: IntArray  # (n, V, P)
    confidence: FloatArray  # (n, V, P)
    found: BoolArray  # (n, V, P): not merely predicted
    by_hand: BoolArray  # (n, V, P)

    def placements(self, row: int, which: BoolArray) -> list[Placement]:
        """Return the points that ``which`` (V, P) picks out of one row."""
        return [
            Placement(
                v,
                p,
                self.uv[row, v, p],
                ORIGINS[self.origin[row, v, p]],
                float(self.confidence[row, v, p]),
            )
            for v, p in np.argwhere(which).tolist()
        ]


@dataclass
class RestartPlan:
    """What is known of the frames to be tracked, and which points rest in them.

    Parameters
    ----------
    placements : dict
        Frame to what was put in place by hand, and in the corrected frame to what the
        tracks have found.
    stretch : Stretch, optional
        What is tracked again; without it, every point to the end.
    """

    placements: dict[int, list[Placement]]
    stretch: Stretch | None = None
    _rows: _Rows | None = None
    _of_frame: dict[int, int] = field(default_factory=dict)

    def enter(self, run: Run, frame: int) -> list[Placement] | None:
        """Return what is known in a frame, and let points rest; None when all do."""
        known = self.placements.get(frame, [])
        row = self._of_frame.get(frame)
        if self.stretch is None or self._rows is None or row is None:
            return known
        self.stretch.enter(row)
        if self.stretch.is_over:
            return None
        run.idle = self.stretch.idle.copy()
        have = {(p.view, p.point) for p in known}
        resting = self._rows.placements(row, self._rows.found[row] & run.idle)
        return known + [p for p in resting if (p.view, p.point) not in have]

    def leave(self, frame: int, uv: Points2D) -> None:
        """Take in where the points are in a frame, (V, P, 2)."""
        if self.stretch is not None and frame in self._of_frame:
            self.stretch.leave(self._of_frame[frame], uv)


def prepare_again(
    run: Run,
    views: Views,
    start: pd.DataFrame,
    *,
    tracks: Tracks,
    first: int,
    learn_at: Mapping[str, int] | None = None,
) -> RestartPlan:
    """Bring a fresh run to the frame from which tracks are made again.

    Parameters
    ----------
    run : Run
        The run; its colours and filters are set.
    views : Views
        The opened views.
    start : DataFrame
        Clicks for points that the tracks lack.
    tracks : Tracks
        The tracks, corrections applied.
    first : int
        The frame to go on from.
    learn_at : mapping, optional
        Point to the frame in which its initial colour was learnt anew. Default: where
        it was first put in place by hand, which is in the start frame.

    Returns
    -------
    RestartPlan
        What is known of the frames from ``first`` on, and what is tracked again.

    Raises
    ------
    InputError
        If the tracks have no such frame, or a click does not fit.
    """
    rows = _read_rows(tracks, run.layout)
    if first not in rows.frames:
        raise InputError(
            f"the tracks have no frame {first} to go on from; they have frames "
            f"{rows.frames.min()} to {rows.frames.max()}."
        )
    here = int(np.flatnonzero(rows.frames == first)[0])
    _learn_before(run, views, rows, here, learn_at or {})
    _follow_before(run, rows, here)
    clicks = read_start(start, run.layout, (0, views.n_frames))
    placements = {frame: placed for frame, placed in clicks.items() if frame > first}
    # what the tracks say in this frame goes before the clicks
    unknown = np.isnan(rows.uv[here, ..., 0])
    placements[first] = [p for p in clicks.get(first, []) if unknown[p.view, p.point]]
    for row in range(here, len(rows.frames)):
        known = rows.placements(row, rows.found[row] if row == here else rows.by_hand[row])
        if known:
            frame = int(rows.frames[row])
            keys = {(p.view, p.point) for p in known}
            clicked = placements.get(frame, [])
            placements[frame] = known + [p for p in clicked if (p.view, p.point) not in keys]
    widths = np.array([width for width, _ in run.layout.sizes])
    stretch = Stretch(
        rows.uv, rows.by_hand, here, tolerance_px=TOLERANCE_PX * widths / REFERENCE_WIDTH_PX
    )
    of_frame = {int(frame): row for row, frame in enumerate(rows.frames)}
    return RestartPlan(placements, stretch, rows, of_frame)


def _read_rows(tracks: Tracks, layout: Layout) -> _Rows:
    """Take tracks as arrays; views and points that they lack are missing."""
    aligned = tracks.reindex(
        view=list(layout.views),
        keypoint=list(layout.points),
        fill_value={"image_origin": ORIGIN_CODE["missing"], "image_confidence": 0.0},
    ).isel(individual=0)
    labels = ("time", "view", "keypoint")
    uv = aligned["image_position"].transpose(*labels, "image_space").to_numpy()
    uv = np.where(np.isfinite(uv).all(axis=-1, keepdims=True), uv, np.nan)
    origin = aligned["image_origin"].transpose(*labels).to_numpy()
    found = np.isin(origin, _FOUND) & np.isfinite(uv[..., 0]) & layout.tracked
    return _Rows(
        frames=tracks["frame"].to_numpy(),
        uv=uv,
        origin=origin,
        confidence=aligned["image_confidence"].transpose(*labels).to_numpy(),
        found=found,
        by_hand=found & (origin == ORIGIN_CODE["edited"]),
    )


def _learn_before(
    run: Run, views: Views, rows: _Rows, here: int, learn_at: Mapping[str, int]
) -> None:
    """Learn each point's initial colour where that belongs, and its last known one.

    The initial colour is that of the first frame, or two, in which the point was put in
    place by hand, or of the frame in which a person had it learnt anew; the other one that
    of the last placement before the row.
    """
    by_hand = rows.by_hand[: here + 1]
    shape = by_hand.shape[1:]
    begun, last = np.full(shape, -1), np.full(shape, -1)
    for v, p in np.argwhere(by_hand.any(axis=0)).tolist():
        placed = np.flatnonzero(by_hand[:, v, p])
        second = len(placed) > 1 and placed[1] == placed[0] + 1
        anew = placed[rows.frames[placed] == learn_at.get(run.layout.points[p])]
        begun[v, p] = anew[-1] if len(anew) else placed[1 if second else 0]
        last[v, p] = placed[-1]
    for row in np.unique(begun[begun >= 0]).tolist():
        run.learn(views.frame(int(rows.frames[row])), rows.placements(row, begun == row))
    run.settle()
    last[(last == begun) | (last == here)] = -1
    for row in np.unique(last[last >= 0]).tolist():
        run.learn(views.frame(int(rows.frames[row])), rows.placements(row, last == row))


def _follow_before(run: Run, rows: _Rows, here: int) -> None:
    """Take the filters over the frames just before a row, as far as none is left out."""
    begin = here
    while begin > max(here - _FOLLOWED_FRAMES, 0) and (
        rows.frames[begin] - rows.frames[begin - 1] == 1
    ):
        begin -= 1
    for row in range(begin, here):
        seen = np.where(rows.found[row][..., None], rows.uv[row], np.nan)
        run.follow(seen, rows.by_hand[row])
