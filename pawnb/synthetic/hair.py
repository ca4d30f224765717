"""Hairs that break the outline of a furred body: thin triangles rooted in its surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.synthetic.surfaces import unit


@dataclass(frozen=True)
class Hairs:
    """Hairs of one part, one entry a hair.

    Attributes
    ----------
    ring, segment : ndarray (n,)
        Root, as a fractional place on the grid of the part's tube.
    length : ndarray (n,)
        mm.
    lift, stray : ndarray (n,)
        How far it points away from the surface, and sideways, relative to along it.
    shade : ndarray (n,)
        Brightness relative to the fur.
    """

    ring: FloatArray
    segment: FloatArray
    length: FloatArray
    lift: FloatArray
    stray: FloatArray
    shade: FloatArray


def draw_hairs(
    rng: np.random.Generator, count: int, *, rings: tuple[float, float], segments: int, size: float
) -> Hairs:
    """Draw where hairs stand between two rings of a part and what each is like.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of chance.
    count : int
        Number of hairs.
    rings : tuple of float
        First and last ring.
    segments : int
        Corners of a ring.
    size : float
        Size of the animal: hairs are 1.6 to 3.4 times as long.

    Returns
    -------
    Hairs
        Where they stand, and what each is like.
    """
    return Hairs(
        ring=rng.uniform(*rings, count),
        segment=rng.uniform(0.0, segments, count),
        length=rng.uniform(1.6, 3.4, count) * size,
        lift=rng.uniform(0.15, 0.55, count),
        stray=rng.normal(0.0, 0.18, count),
        shade=rng.uniform(0.8, 1.3, count),
    )


def hair_triangles(
    grid: FloatArray, normals: FloatArray, hairs: Hairs, *, way: float, width: float
) -> tuple[FloatArray, FloatArray]:
    """Place hairs on a part as it is now.

    Parameters
    ----------
    grid, normals : ndarray (rings, segments, 3)
        The part's surface.
    hairs : Hairs
        Which hairs.
    way : {-1, 1}
        -1 for hairs that lie towards the first ring, +1 towards the last.
    width : float
        Width at the root, mm.

    Returns
    -------
    vertices, normals : ndarray (3 n, 3)
        Two corners at the root and one at the tip of each hair; hairs are lit as the skin
        that they stand on.
    """
    segments = grid.shape[1]
    ring, part = np.divmod(hairs.ring, 1.0)
    seg, rest = np.divmod(hairs.segment, 1.0)
    i, j = ring.astype(int), seg.astype(int)
    k = (j + 1) % segments
    part, rest = part[:, None], rest[:, None]

    def between(a: FloatArray) -> FloatArray:
        near = a[i, j] + part * (a[i + 1, j] - a[i, j])
        far = a[i, k] + part * (a[i + 1, k] - a[i, k])
        return near + rest * (far - near)

    root, normal = between(grid), unit(between(normals))
    along = way * unit(grid[i + 1, j] - grid[i, j])
    across = np.cross(normal, along)
    lie = unit(along + hairs.lift[:, None] * normal + hairs.stray[:, None] * across)
    tip = root + hairs.length[:, None] * lie
    root = root - 0.45 * width * normal  # rooted in the skin, not on it
    half = 0.5 * width * across
    vertices = np.stack([root - half, root + half, tip], axis=1).reshape(-1, 3)
    return vertices, np.repeat(normal, 3, axis=0)
