"""Looking for a point in a view where it was not clicked, because it was hidden there.

This is not in the paper, whose user clicks every paw in every camera. Where two
views or more have found the point in this frame, it is looked for around the
projection of its triangulated position. Where a single view has found it, only the
line of sight is known: it is looked for along that line, within the animal's size
of the other points. Its colour is taken from the views where it was clicked, so
views are expected to show a point alike; a superpixel that differs too much is
refused, and the search goes on in the next frame.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from pawnb.arrays import FloatArray, Points2D
from pawnb.core.paws.layout import Layout
from pawnb.core.paws.maghsoudi2019.parameters import MAGHSOUDI2019
from pawnb.core.paws.superpixels import (
    FramePixels,
    Look,
    Superpixels,
    Window,
    colour_difference,
    measure_superpixels,
    place_window,
)
from pawnb.core.rig import Rig


def find_hidden(
    layout: Layout,
    pictures: Mapping[str, FramePixels],
    key: tuple[int, int],
    *,
    looks: Sequence[Look],
    uv: Points2D,
) -> tuple[Superpixels, int, float] | None:
    """Look for one point in a view where it has not been seen.

    Parameters
    ----------
    layout : Layout
        The layout of the run; it must have a rig.
    pictures : mapping
        The frame of each view, by name.
    key : tuple of int
        View and point.
    looks : sequence of Look
        Colours of the point in the views where it is known.
    uv : ndarray, shape (V, P, 2)
        What has been found in this frame, px; NaN where nothing.

    Returns
    -------
    tuple or None
        Superpixels, the number of the one found, and its likeness in colour (0 to 1);
        None where there is nothing like it.
    """
    view, point = key
    rig = layout.rig
    if rig is None or not looks:
        return None
    path = _expected_path(rig, key, uv)
    window = _window_around(layout, view, path)
    if window is None:
        return None
    lengths = layout.lengths[view]
    superpixels = measure_superpixels(
        pictures[layout.views[view]], window, lengths, settings=layout.settings
    )
    away = np.linalg.norm(superpixels.uv[:, None] - path, axis=-1).min(axis=1)
    difference = np.min([colour_difference(superpixels, look) for look in looks], axis=0)
    # another point's superpixel is not this point's, however alike
    others = np.delete(uv[view], point, axis=0)
    others = others[np.isfinite(others[:, 0])]
    apart = np.linalg.norm(superpixels.uv[:, None] - others, axis=-1).min(axis=1, initial=np.inf)
    limit = layout.settings.hidden_difference
    fits = (away <= lengths.hidden_distance) & (difference <= limit)
    fits &= apart > lengths.half_v * MAGHSOUDI2019.search_apart
    if not fits.any():
        return None
    number = int(np.argmin(np.where(fits, difference, np.inf)))
    return superpixels, number, float(1.0 - difference[number])


def _expected_path(rig: Rig, key: tuple[int, int], uv: Points2D) -> FloatArray:
    """Return where the point may be in the view: one position, or several along a line."""
    view, point = key
    seen = np.flatnonzero(np.isfinite(uv[:, point, 0]))
    none = np.empty((0, 2))
    if len(seen) == 0:
        return none
    everything = rig.triangulate(np.swapaxes(uv, 0, 1)).xyz
    if len(seen) >= 2:
        return rig.project(everything[point][None])[:, view]
    others = np.delete(everything, point, axis=0)
    others = others[np.isfinite(others[:, 0])]
    if len(others) < 2:
        return none
    ends = _line_of_sight(rig.coefs[:, seen[0]], uv[seen[0], point], others)
    share = np.linspace(0.0, 1.0, MAGHSOUDI2019.search_positions)[:, None]
    return rig.project(ends[0] + share * (ends[1] - ends[0]))[:, view]


def _line_of_sight(coefs: FloatArray, uv: Points2D, others: FloatArray) -> FloatArray:
    """Return the two ends, shape (2, 3), of a line of sight within reach of other points.

    Eq. 1 of the paper with u and v known is two planes; the line is where they meet. It
    is cut to the size of the animal about the point nearest to the middle of the others.
    """
    L = coefs
    planes = np.array(
        [
            [L[0] - uv[0] * L[8], L[1] - uv[0] * L[9], L[2] - uv[0] * L[10]],
            [L[4] - uv[1] * L[8], L[5] - uv[1] * L[9], L[6] - uv[1] * L[10]],
        ]
    )
    level = np.array([uv[0] - L[3], uv[1] - L[7]])
    direction = np.cross(planes[0], planes[1])
    direction = direction / np.linalg.norm(direction)
    middle = others.mean(axis=0)
    nearest = middle + np.linalg.pinv(planes) @ (level - planes @ middle)
    size = np.linalg.norm(others[:, None] - others, axis=-1).max()
    return np.stack([nearest - size / 2 * direction, nearest + size / 2 * direction])


def _window_around(layout: Layout, view: int, path: FloatArray) -> Window | None:
    """Return the sub-image that holds the positions tried, clipped to the picture."""
    inside = np.array([uv for uv in path if layout.contains(view, uv)])
    if len(inside) == 0:
        return None
    width, height = layout.sizes[view]
    lengths = layout.lengths[view]
    if len(path) == 1:
        return place_window(inside[0], lengths, width=width, height=height)
    reach = np.array([lengths.half_u, lengths.half_v])
    low = np.maximum(np.round(inside.min(axis=0) - reach), 0)
    high = np.minimum(np.round(inside.max(axis=0) + reach), [width, height])
    box = (int(low[0]), int(low[1]), int(high[0]), int(high[1]))
    half = (high - low) / 2
    return Window(low + half, float(half[0]), float(half[1]), box)
