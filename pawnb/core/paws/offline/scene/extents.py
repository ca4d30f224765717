"""How large the animal is in every view, by the points of all calibrated views together."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.scene.parameters import CAMERA
from pawnb.core.rig import Rig


def with_extents(
    annotations: Sequence[Annotations], sizes: Sequence[tuple[int, int]], rig: Rig | None
) -> list[Annotations]:
    """Return what was placed, with the extent of the whole animal where other views tell it.

    A view often has the legs of one side alone. Where these pass each other in the clicked frame
    they are a few pixels apart, and say nothing of how large the animal is. So all points that two
    views place in space are projected into each view, and the extent is that of these and its own.

    Parameters
    ----------
    annotations : sequence of Annotations
        What was placed in each of V views.
    sizes : sequence of (int, int)
        Width and height of each view, px.
    rig : Rig, optional
        The calibrated views, in their order; without it each view says it by itself.

    Returns
    -------
    list of Annotations
        The same places.
    """
    if rig is None or len(annotations) < 2:
        return list(annotations)
    seen: list[dict[int, dict[int, np.ndarray]]] = [
        {row: dict(here) for row, here in own.places.items()} for own in annotations
    ]
    for row in {row for own in annotations for row in own.rows}:
        for point in {p for own in annotations for p in own.places.get(row, {})}:
            for v, uv in _in_every_view(annotations, row, point, sizes=sizes, rig=rig):
                seen[v].setdefault(row, {}).setdefault(point, uv)
    return [
        dataclasses.replace(own, whole_extent=Annotations(all_of_it).extent()) if own.rows else own
        for own, all_of_it in zip(annotations, seen, strict=True)
    ]


def _in_every_view(
    annotations: Sequence[Annotations],
    row: int,
    point: int,
    *,
    sizes: Sequence[tuple[int, int]],
    rig: Rig,
) -> list[tuple[int, FloatArray]]:
    """Return views and where a point is in them, as two views or more that place it say."""
    nowhere = np.full(2, np.nan)
    uv = np.array([own.places.get(row, {}).get(point, nowhere) for own in annotations], float)
    if np.isfinite(uv[:, 0]).sum() < 2:
        return []
    found = rig.triangulate(uv)
    if not found.residual_px <= CAMERA.extent_residual * max(map(max, sizes)):
        return []
    projected = rig.project(found.xyz)
    inside = ((projected >= 0) & (projected < np.array(sizes))).all(axis=-1)
    return [(int(v), projected[v]) for v in np.flatnonzero(inside)]
