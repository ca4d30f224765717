"""What is fixed to the body: pictures in the body's frame, and back: compiled loops."""

from __future__ import annotations

import math

import numpy as np

from pawnb.core.compiled import compiled


@compiled
def in_body_frame(seen: np.ndarray, box: np.ndarray, pose: np.ndarray, out: np.ndarray) -> None:
    """Write a picture, turned so that the body looks along its rows, into ``out``.

    Parameters
    ----------
    seen : ndarray, shape (H, W)
        The picture.
    box : ndarray, shape (2,)
        Left and top of its crop.
    pose : ndarray
        The body's place and heading.
    out : ndarray, shape (side, side)
        Receives it, the body's origin in the middle; 0 beyond the crop.
    """
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    height, width = seen.shape
    half = out.shape[0] // 2
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            x, y = float(j - half), float(i - half)
            u = pose[0] + x * cos - y * sin - box[0]
            v = pose[1] + x * sin + y * cos - box[1]
            a, b = math.floor(u), math.floor(v)
            out[i, j] = 0.0
            if 0 <= a < width - 1 and 0 <= b < height - 1:
                s, t = u - a, v - b
                upper = (1 - s) * seen[b, a] + s * seen[b, a + 1]
                lower = (1 - s) * seen[b + 1, a] + s * seen[b + 1, a + 1]
                out[i, j] = (1 - t) * upper + t * lower


@compiled
def disregard(kept: np.ndarray, pose: np.ndarray, box: np.ndarray, weight: np.ndarray) -> None:
    """Give pixels less weight where a place of the body does not count; in place.

    Parameters
    ----------
    kept : ndarray, shape (side, side)
        How much places in the body's frame count, 0 to 1; beyond it, all do.
    pose : ndarray
        The body's place and heading.
    box : ndarray, shape (2,)
        Left and top of the crop.
    weight : ndarray, shape (H, W)
        The weight, changed.
    """
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    half = kept.shape[0] // 2
    for v in range(weight.shape[0]):
        for u in range(weight.shape[1]):
            du, dv = u + box[0] - pose[0], v + box[1] - pose[1]
            x, y = du * cos + dv * sin + half, -du * sin + dv * cos + half
            a, b = math.floor(x), math.floor(y)
            if 0 <= a < kept.shape[0] - 1 and 0 <= b < kept.shape[0] - 1:
                s, t = x - a, y - b
                upper = (1 - s) * kept[b, a] + s * kept[b, a + 1]
                lower = (1 - s) * kept[b + 1, a] + s * kept[b + 1, a + 1]
                weight[v, u] *= (1 - t) * upper + t * lower


@compiled
def hide(
    attached_clutter: np.ndarray,
    pose: np.ndarray,
    body: np.ndarray,
    box: np.ndarray,
    seen: np.ndarray,
    weight: np.ndarray,
) -> None:
    """Make nothing seen, and with no weight, where a fixture lies; in place.

    Parameters
    ----------
    attached_clutter : ndarray of bool, shape (side, side)
        Where they lie, in the body's frame.
    pose : ndarray
        The body's place and heading.
    body : ndarray of bool, shape (H, W)
        Where the body itself may be: it stays as it is.
    box : ndarray, shape (2,)
        Left and top of the crop.
    seen, weight : ndarray, shape (H, W)
        Darkness and its weight, changed.
    """
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    side = attached_clutter.shape[0]
    half = side // 2
    for v in range(seen.shape[0]):
        for u in range(seen.shape[1]):
            du, dv = u + box[0] - pose[0], v + box[1] - pose[1]
            a, b = round(du * cos + dv * sin) + half, round(-du * sin + dv * cos) + half
            if 0 <= a < side and 0 <= b < side and attached_clutter[b, a] and not body[v, u]:
                seen[v, u] = 0.0
                weight[v, u] = 0.0
