"""A z-buffer in numpy: which triangle is seen in each pixel, for a whole mesh at once.

Triangles are cut into rows and rows into fragments with array operations only, so a
mesh of ten thousand triangles takes milliseconds. A pixel belongs to a triangle if
its centre does.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pawnb.arrays import FloatArray, IntArray


@dataclass(frozen=True)
class Fragments:
    """What a mesh covers in a picture.

    Attributes
    ----------
    triangle, pixel : ndarray (f,)
        Every (triangle, pixel) pair that covers, hidden ones too; pixels are
        numbered along the rows.
    winner : ndarray (height * width,)
        For each pixel the place, in these arrays, of the fragment that is seen; -1
        where there is none.
    """

    triangle: IntArray
    pixel: IntArray
    winner: IntArray


def rasterise(
    corners: FloatArray, inverse_depth: FloatArray, *, width: int, height: int
) -> Fragments:
    """Find the fragments of some triangles and which of them are in front.

    Parameters
    ----------
    corners : ndarray (m, 3, 2)
        Image positions of the corners, px.
    inverse_depth : ndarray (m, 3)
        1 / depth at the corners: linear in the picture under perspective.
    width, height : int
        Size of the picture.

    Returns
    -------
    Fragments
        Exact to the pixel centre.
    """
    edges, plane = _edges_and_planes(corners, inverse_depth)
    row_triangle, row, first, last = _rows(corners, edges, width=width, height=height)
    count = np.maximum(last - first + 1, 0)
    begin = np.cumsum(count) - count
    total = int(count.sum())
    triangle = np.repeat(row_triangle, count)
    x = np.arange(total) + np.repeat(first - begin, count)
    y = np.repeat(row, count)
    nearness = plane[triangle, 0] * x + plane[triangle, 1] * y + plane[triangle, 2]
    pixel = y * width + x
    nearest = np.full(width * height, -np.inf)
    np.maximum.at(nearest, pixel, nearness)
    # of two fragments at exactly the same depth the later is taken: deterministic
    winner = np.full(width * height, -1)
    front = np.flatnonzero(nearness == nearest[pixel])
    winner[pixel[front]] = front
    return Fragments(triangle=triangle, pixel=pixel, winner=winner)


def barycentric(corners: FloatArray, triangle: IntArray, xy: np.ndarray) -> np.ndarray:
    """Return the weights (f, 3) of the corners at image positions xy (f, 2).

    Parameters
    ----------
    corners : ndarray, shape (triangles, 3, 2)
        Corners of the triangles in the picture, px.
    triangle : ndarray of int, shape (f,)
        Which triangle each position is in.
    xy : ndarray, shape (f, 2)
        Positions, px.

    Returns
    -------
    ndarray, shape (f, 3)
        Weights, which add up to 1.
    """
    a = corners[:, 0]
    ab, ac = corners[:, 1] - a, corners[:, 2] - a
    area = ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0]
    # weights of the second and third corner are linear in x and y
    gx = np.stack([ac[:, 1], -ab[:, 1]], axis=1) / area[:, None]
    gy = np.stack([-ac[:, 0], ab[:, 0]], axis=1) / area[:, None]
    g0 = -(gx * a[:, :1] + gy * a[:, 1:])
    weights = gx[triangle] * xy[:, :1] + gy[triangle] * xy[:, 1:] + g0[triangle]
    return np.concatenate([1.0 - weights.sum(axis=1, keepdims=True), weights], axis=1)


def _edges_and_planes(
    corners: FloatArray, inverse_depth: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return edge functions (m, 3, 3), positive inside, and depth planes (m, 3)."""
    x, y = corners[..., 0], corners[..., 1]
    x1, y1 = x[:, [1, 2, 0]], y[:, [1, 2, 0]]
    a, b = y - y1, x1 - x
    c = -(a * x + b * y)
    area = (x[:, 1] - x[:, 0]) * (y[:, 2] - y[:, 0]) - (x[:, 2] - x[:, 0]) * (y[:, 1] - y[:, 0])
    edges = np.stack([a, b, c], axis=-1) * np.sign(area)[:, None, None]
    # each corner's weight is the edge opposite to it, divided by twice the area
    opposite = edges[:, [1, 2, 0]]
    with np.errstate(divide="ignore", invalid="ignore"):
        plane = np.einsum("mi,mik->mk", inverse_depth, opposite) / np.abs(area)[:, None]
    edges[area == 0] = [0.0, 0.0, -1.0]  # seen edge on: covers nothing
    return edges, plane


def _rows(
    corners: FloatArray, edges: FloatArray, *, width: int, height: int
) -> tuple[IntArray, IntArray, IntArray, IntArray]:
    """Cut triangles into rows: triangle, row, first and last column of each."""
    y = corners[..., 1]
    top = np.clip(np.ceil(y.min(axis=1)), 0, height).astype(int)
    bottom = np.clip(np.floor(y.max(axis=1)), -1, height - 1).astype(int)
    count = np.maximum(bottom - top + 1, 0)
    triangle = np.repeat(np.arange(len(corners)), count)
    row = np.arange(int(count.sum())) + np.repeat(top - (np.cumsum(count) - count), count)
    low = np.zeros(len(row))
    high = np.full(len(row), width - 1.0)
    for k in range(3):
        slope = edges[triangle, k, 0]
        rest = edges[triangle, k, 1] * row + edges[triangle, k, 2]
        with np.errstate(divide="ignore", invalid="ignore"):
            cross = -rest / slope
        np.copyto(low, np.maximum(low, cross), where=slope > 0)
        np.copyto(high, np.minimum(high, cross), where=slope < 0)
        np.copyto(high, -1.0, where=(slope == 0) & (rest < 0))
    first, last = np.ceil(low).astype(int), np.floor(high).astype(int)
    return triangle, row, first, last
