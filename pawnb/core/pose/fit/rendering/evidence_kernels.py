"""Light of the scene in a frame, and how much of it the animal takes: compiled loops."""

from __future__ import annotations

import math

import numpy as np

from pawnb.core.compiled import compiled_loosely
from pawnb.core.sorting_kernels import median


@compiled_loosely
def block_gains(
    image: np.ndarray, mean: np.ndarray, covered: np.ndarray, block: int, black: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the median of image / background in square blocks, and how many pixels it counts.

    Every other pixel of every other row counts, where ``covered`` is below 0 and the background
    is lighter than ``black``.
    """
    height, width = image.shape
    rows, columns = (height + block - 1) // block, (width + block - 1) // block
    gains, counts = np.ones((rows, columns)), np.zeros((rows, columns))
    values = np.empty(block * block)
    for i in range(rows):
        for j in range(columns):
            n = 0
            for v in range(i * block, min((i + 1) * block, height), 2):
                for u in range(j * block, min((j + 1) * block, width), 2):
                    if covered[v, u] == -1 and mean[v, u] > black:
                        values[n] = image[v, u] / mean[v, u]
                        n += 1
            if n:
                gains[i, j] = median(values[:n])
            counts[i, j] = n
    return gains, counts


@compiled_loosely
def smooth_gains(gains: np.ndarray, counts: np.ndarray, spread: float) -> np.ndarray:
    """Return gains averaged over blocks nearby with a Gaussian, each by its count."""
    rows, columns = gains.shape
    out = np.ones((rows, columns))
    reach = math.ceil(3 * spread)
    for i in range(rows):
        for j in range(columns):
            total = weights = 0.0
            for a in range(max(0, i - reach), min(rows, i + reach + 1)):
                for b in range(max(0, j - reach), min(columns, j + reach + 1)):
                    square = (a - i) ** 2 + (b - j) ** 2
                    w = counts[a, b] * math.exp(-0.5 * square / spread**2)
                    w += 1e-9 * counts[a, b] / (1.0 + square)
                    total += w * gains[a, b]
                    weights += w
            if weights > 0.0:
                out[i, j] = total / weights
    return out


@compiled_loosely
def darkness(
    image: np.ndarray, mean: np.ndarray, sd: np.ndarray, gains: np.ndarray, block: int,
    light: float, spread: float, limits: tuple[float, float, float], seen: np.ndarray,
    weight: np.ndarray,
) -> None:  # fmt: skip
    """Write how much darker than the background each pixel is, and how sure that is.

    Parameters
    ----------
    image, mean, sd : ndarray, shape (H, W)
        Frame, background's mean and standard deviation, grey values.
    gains : ndarray
        Light of this frame relative to the background's, at the middles of blocks.
    block : int
        Side of a block, px.
    light : float
        0 for a dark animal; for a light one, its grey value: 1 is as light as that.
    spread : float
        Standard deviation of what the painted animal leaves unexplained.
    limits : tuple of float
        Least and most darkness, and least contrast of a light animal, grey values.
    seen, weight : ndarray, shape (H, W)
        Receive darkness within the limits and one over its variance.
    """
    lowest, highest, least_contrast = limits
    rows, columns = gains.shape
    width = image.shape[1]
    lefts, share = np.empty(width, np.int64), np.empty(width)
    for u in range(width):
        x = min(max((u + 0.5) / block - 0.5, 0.0), columns - 1.0)
        lefts[u] = min(int(x), max(columns - 2, 0))
        share[u] = x - lefts[u]
    row = np.empty(columns + 1)  # one more, so that there is a block beside the last
    gain = np.empty(width)
    for v in range(image.shape[0]):
        y = min(max((v + 0.5) / block - 0.5, 0.0), rows - 1.0)
        i = min(int(y), max(rows - 2, 0))
        b = y - i
        below = min(i + 1, rows - 1)
        for j in range(columns):
            row[j] = (1 - b) * gains[i, j] + b * gains[below, j]
        row[columns] = row[columns - 1]
        for u in range(width):
            j = lefts[u]
            gain[u] = row[j] + share[u] * (row[j + 1] - row[j])
        for u in range(width):
            lit = max(gain[u] * mean[v, u], 1.0)
            contrast = max(light - lit, least_contrast) if light > 0.0 else -lit
            value = (image[v, u] - lit) / contrast
            seen[v, u] = min(max(value, lowest), highest)
            noise = gain[u] * sd[v, u] / contrast
            weight[v, u] = 1.0 / (spread * spread + noise * noise)


@compiled_loosely
def in_levels(seen: np.ndarray, levels: float, out: np.ndarray) -> None:
    """Write darkness, cut to 0 to 1, in so many steps into ``out`` (uint8)."""
    for v in range(seen.shape[0]):
        for u in range(seen.shape[1]):
            out[v, u] = np.uint8(levels * min(max(seen[v, u], 0.0), 1.0) + 0.5)


@compiled_loosely
def behind_filter(
    wide: np.ndarray, level: float, least: float, most: float, body: np.ndarray,
    seen: np.ndarray, weight: np.ndarray,
) -> None:  # fmt: skip
    """Make darkness and its weight those before a filter that takes light; in place.

    Parameters
    ----------
    wide : ndarray of uint8, shape (H, W)
        Light that the filter takes, in steps of ``level``.
    level, least, most : float
        A step; what does not count of it; and the most that counts.
    body : ndarray of bool, shape (H, W)
        Where the body may be: there is no filter.
    seen, weight : ndarray, shape (H, W)
        Darkness and its weight, changed.
    """
    for v in range(seen.shape[0]):
        for u in range(seen.shape[1]):
            taken = min(wide[v, u] * level - least, most)
            if taken > 0.0 and not body[v, u]:
                left = 1.0 - taken
                seen[v, u] = (seen[v, u] - taken) / left
                weight[v, u] *= left * left
