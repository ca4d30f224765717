"""What was placed by hand, as positions: of points, of the frame with most, of rows of paws."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.paws.layout import Layout, Placement
from pawnb.core.paws.offline.scene.parameters import MOVEMENT


def frame_with_most_annotations(placed: Mapping[int, Sequence[Placement]]) -> int:
    """Return the frame in which most points are placed, in most views; the first of several.

    A recording may be corrected before it was clicked, one paw at a time.
    """

    def count(frame: int) -> tuple[int, int, int]:
        here = placed[frame]
        return len({place.point for place in here}), len(here), -frame

    return max(placed, key=count)


def shows_two_rows(
    placed: Mapping[int, FloatArray], kinds: Sequence[str], forward: FloatArray
) -> bool:
    """Tell whether a single picture shows left and right paws in two rows, as from below.

    Parameters
    ----------
    placed : mapping
        Point number to position (2,), px, in one frame.
    kinds : sequence of str
        Kind of each point.
    forward : ndarray, shape (2,)
        Unit vector along the animal.

    Returns
    -------
    bool
        True where two front and two hind paws lie in two rows well apart.
    """
    pairs = [
        np.array([x for p, x in placed.items() if kinds[p] == kind]) for kind in ("front", "hind")
    ]
    if any(len(pair) != 2 for pair in pairs):
        return False
    long = abs(float((pairs[0].mean(axis=0) - pairs[1].mean(axis=0)) @ forward))
    rows = np.sort([pair @ np.array([-forward[1], forward[0]]) for pair in pairs], axis=1)
    return bool(rows[:, 1].min() - rows[:, 0].max() > MOVEMENT.treadmill_rows * long)


def unlabelled_kinds(kinds: Sequence[str]) -> list[str]:
    """Return the kinds of paws of which an animal has one more than was clicked."""
    return [kind for kind in ("front", "hind") if list(kinds).count(kind) == 1]


def directions(layout: Layout) -> tuple[FloatArray, FloatArray]:
    """Return up and forward in space, or in the picture of a single view."""
    if layout.rig is not None:
        return np.array(layout.rig.up), np.array(layout.rig.forward)
    return np.array([0.0, -1.0]), np.array([float(layout.facing[0]), 0.0])


def clicked_positions(
    here: Sequence[Placement], layout: Layout, up: FloatArray
) -> dict[int, FloatArray]:
    """Return the position of every point placed in one frame.

    Parameters
    ----------
    here : sequence of Placement
        What was placed there.
    layout : Layout
        Points and views.
    up : ndarray, shape (d,)
        Unit vector.

    Returns
    -------
    dict
        Point number to position (d,). Of a point placed in one of several views it is where that
        view sees it, as high as the others.
    """
    uv = np.full((len(layout.points), len(layout.views), 2), np.nan)
    for place in here:
        uv[place.point, place.view] = place.uv
    n_views = np.isfinite(uv[..., 0]).sum(axis=1)
    if layout.rig is None:
        return {int(p): uv[p, 0] for p in np.flatnonzero(n_views)}
    xyz = layout.rig.triangulate(uv, refine=True).xyz
    known = xyz[n_views >= 2]
    height = float(np.median(known @ up)) if len(known) else 0.0
    for p in np.flatnonzero(n_views == 1):
        v = int(np.flatnonzero(np.isfinite(uv[p, :, 0]))[0])
        xyz[p] = _on_plane(layout.rig.coefs[:, v], uv[p, v], up, height)
    return {int(p): xyz[p] for p in np.flatnonzero(n_views)}


def _on_plane(L: np.ndarray, uv: np.ndarray, up: np.ndarray, height: float) -> np.ndarray:
    """Return the point of a plane at some height that one view sees at ``uv``."""
    A = np.stack([L[0:3] - uv[0] * L[8:11], L[4:7] - uv[1] * L[8:11], up])
    b = np.array([uv[0] - L[3], uv[1] - L[7], height])
    return np.linalg.lstsq(A, b, rcond=None)[0]
