"""Tracking again from a corrected frame: every state is made anew from the tracks' rows.

Haji Maghsoudi et al. 2019, section 3.1: features, coordinates, Kalman filter and 3D
coordinates have to be reset when a person has edited a frame.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from pawnb.core.paws.layout import Layout, Placement, Views, read_start
from pawnb.core.paws.run import Run
from pawnb.errors import InputError
from pawnb.schema import ORIGIN_CODE, ORIGINS, Tracks

_FOUND = [ORIGIN_CODE[name] for name in ("measured", "resolved", "edited")]

_FOLLOWED_FRAMES = 50
"""The filter forgets: what is older than this moves a state by less than rounding does."""


@dataclass(frozen=True)
class _Rows:
    """Tracks as arrays in the order of the layout: n rows, V views, P points."""

    frames: np.ndarray  # (n,)
    uv: np.ndarray  # (n, V, P, 2), px
    origin: np.ndarray  # (n, V, P)
    confidence: np.ndarray  # (n, V, P)
    found: np.ndarray  # (n, V, P): not merely predicted
    by_hand: np.ndarray  # (n, V, P)

    def placements(self, row: int, which: np.ndarray) -> list[Placement]:
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


def prepare_again(
    run: Run, views: Views, start: pd.DataFrame, *, tracks: Tracks, first: int
) -> dict[int, list[Placement]]:
    """Bring a fresh run to the frame from which tracks are made again.

    Parameters
    ----------
    run : Run
        The run; its colours and filters are set.
    views : Views
        The opened views: colours are learnt where a person last put a point in place.
    start : DataFrame
        Clicks for points that the tracks lack.
    tracks : Tracks
        The tracks, corrections applied.
    first : int
        The frame to go on from.

    Returns
    -------
    dict
        Frame to placements: what the tracks have found in ``first``, and what was put in
        place by hand later.

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
    _learn_before(run, views, rows, here)
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
    return placements


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


def _learn_before(run: Run, views: Views, rows: _Rows, here: int) -> None:
    """Learn each point's colour where it was last put in place by hand before a row."""
    by_hand = rows.by_hand[:here]
    last = np.full(by_hand.shape[1:], -1)
    for v, p in np.argwhere(by_hand.any(axis=0)).tolist():
        last[v, p] = np.flatnonzero(by_hand[:, v, p])[-1]
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
