"""Compiled loops over the pixels of a score; see :mod:`.colour.detector`."""

from __future__ import annotations

from typing import Any

import numpy as np

from pawnb.core.compiled import compiled

_SIDE, _OWN_WEIGHT, _HALF, _TO_BINS, _TEN, _FIVE = (
    np.uint32(n) for n in (61, 134, 1 << 15, 19, 10, 5)
)
"""Layout: weights of smoothing in parts of 256; twice that and three bits lie below five bits of
colour."""
_FIXED_POINT, _PART = np.float32(1 << 25), 1.0 / (1 << 25)
"""Layout: weights of the mask, as float32 has them, are whole numbers of 2^-25."""


@compiled
def look_up(table: np.ndarray, numbers: np.ndarray) -> np.ndarray:
    """Return the entries (h, w) of a table with these numbers."""
    out = np.empty(numbers.shape, table.dtype)
    for v in range(numbers.shape[0]):
        for u in range(numbers.shape[1]):
            out[v, u] = table[numbers[v, u]]
    return out


@compiled
def score_colours(pixels: np.ndarray, table: np.ndarray) -> np.ndarray:
    """Return the entries (h, w) of a table of colours for the pixels of an RGB picture.

    Parameters
    ----------
    pixels : ndarray, shape (h, w, 3), uint8
        The picture. It is smoothed first, exactly as ``cv2.GaussianBlur`` does over 3 x 3 px
        with a standard deviation of 0.8 px.
    table : ndarray, shape (32768,)
        Entries by five bits each of red, green and blue.
    """
    h, w = pixels.shape[:2]
    out = np.empty((h, w), table.dtype)
    flat = pixels.reshape(h, 3 * w)
    # with a pixel more on either side, mirrored as the rows are
    down = np.empty(3 * w + 6, np.uint16)
    smooth = np.empty(3 * w, np.uint16)
    for v in range(h):
        above = flat[v - 1 if v > 0 else min(1, h - 1)]
        own = flat[v]
        below = flat[v + 1 if v < h - 1 else max(h - 2, 0)]
        for i in range(3 * w):
            down[i + 3] = _SIDE * (np.uint32(above[i]) + below[i]) + _OWN_WEIGHT * np.uint32(own[i])
        for i in range(3):
            down[i] = down[6 + i if w > 1 else 3 + i]
            down[3 * w + 3 + i] = down[3 * w - 3 + i if w > 1 else 3 + i]
        for i in range(3 * w):
            total = np.uint32(_SIDE * (down[i] + down[i + 6]) + _OWN_WEIGHT * down[i + 3] + _HALF)
            smooth[i] = total >> _TO_BINS
        for u in range(w):
            number = (smooth[3 * u] << _TEN) | (smooth[3 * u + 1] << _FIVE) | smooth[3 * u + 2]
            out[v, u] = table[number]
    return out


@compiled
def weigh(score: np.ndarray) -> np.ndarray:
    """Return how far each pixel (h, w) belongs to the mask: 0 at score -1, 2^25 at score 1.

    They are whole numbers, and as fine as float32 has them: sums of them are exact.
    """
    half, least, most = np.float32(0.5), np.float32(0.0), np.float32(1.0)
    out = np.empty(score.shape, np.int32)
    for v in range(score.shape[0]):
        for u in range(score.shape[1]):
            out[v, u] = np.int32(min(max(score[v, u] * half + half, least), most) * _FIXED_POINT)
    return out


@compiled
def find_ends(
    score: np.ndarray, weight: np.ndarray, around: int, reach: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Find where the share of mask is least.

    Parameters
    ----------
    score : ndarray, shape (h, w), float32
        Score of each pixel: those above 0 are the mask.
    weight : ndarray, shape (h, w)
        What :func:`weigh` says of it.
    around : int
        Half the side of the square over which the share of mask is taken, at most 30; what lies
        beyond the picture's edge is like what is nearest.
    reach : int
        No pixel of the mask that is so near along u and v has less.

    Returns
    -------
    rows, columns : ndarray of int, shape (n,)
        The pixels.
    share : ndarray, shape (n,), float32
        Share of mask about each.
    """
    h, w = score.shape
    rows, columns = _mask(score)
    share = np.empty((h, w), np.float32)
    sums = np.zeros(w, np.int32)
    scale = 1.0 / (2 * around + 1) ** 2
    for v in range(-around, around):
        _add(sums, weight[min(max(v, 0), h - 1)], 1)
    k = 0
    for v in range(h):
        _add(sums, weight[min(v + around, h - 1)], 1)
        total: Any = 0
        last: Any = -2
        while k < len(rows) and rows[k] == v:
            u = columns[k]
            if u == last + 1:
                total += sums[min(u + around, w - 1)] - sums[max(last - around, 0)]
            else:
                total = 0
                for i in range(u - around, u + around + 1):
                    total += sums[min(max(i, 0), w - 1)]
            share[v, u] = total * _PART * scale
            last = u
            k += 1
        _add(sums, weight[max(v - around, 0)], -1)
    n = 0
    least = np.empty(len(rows), np.float32)
    for k in range(len(rows)):
        v, u = rows[k], columns[k]
        if _is_least(score, share, v, u, reach):
            rows[n], columns[n], least[n] = v, u, share[v, u]
            n += 1
    return rows[:n].copy(), columns[:n].copy(), least[:n].copy()


@compiled
def _add(sums: np.ndarray, row: np.ndarray, sign: int) -> None:
    """Add a row to sums, or take it away."""
    for u in range(len(sums)):
        sums[u] += sign * row[u]


@compiled
def _mask(score: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return rows and columns of the pixels with a score above 0, row by row."""
    h, w = score.shape
    in_row, every = np.empty(h, np.int64), 0
    for v in range(h):
        count = 0
        for u in range(w):
            count += score[v, u] > 0
        in_row[v] = count
        every += count
    rows, columns = np.empty(every, np.int64), np.empty(every, np.int64)
    n = 0
    for v in range(h):
        if in_row[v] > 0:
            for u in range(w):
                if score[v, u] > 0:
                    rows[n], columns[n] = v, u
                    n += 1
    return rows, columns


@compiled
def _is_least(score: np.ndarray, share: np.ndarray, v: int, u: int, reach: int) -> bool:
    """Tell whether no pixel of the mask within ``reach`` has less share than one has."""
    own = share[v, u]
    if own > 1.0:
        return False
    for j in range(max(v - reach, 0), min(v + reach, score.shape[0] - 1) + 1):
        for i in range(max(u - reach, 0), min(u + reach, score.shape[1] - 1) + 1):
            if score[j, i] > 0 and share[j, i] < own:
                return False
    return True


@compiled
def centres(weight: np.ndarray, u: np.ndarray, v: np.ndarray, reach: int) -> np.ndarray:
    """Return the weighted centres (n, 2) of discs about some pixels."""
    h, w = weight.shape
    out = np.empty((len(u), 2))
    limit = (reach + 0.5) ** 2
    half = np.empty(reach + 1, np.int64)
    for j in range(reach + 1):
        half[j] = int(np.sqrt(limit - j * j))
    for n in range(len(u)):
        mass: Any = 0
        along: Any = 0
        down: Any = 0
        for j in range(max(-reach, -v[n]), min(reach, h - 1 - v[n]) + 1):
            left, right = max(u[n] - half[abs(j)], 0), min(u[n] + half[abs(j)], w - 1)
            in_row: Any = 0
            for i in range(left, right + 1):
                here = np.int64(weight[v[n] + j, i])
                in_row += here
                along += here * (i - u[n])
            mass += in_row
            down += in_row * j
        whole = max(mass * _PART, 1e-6)
        out[n, 0] = u[n] + along * _PART / whole
        out[n, 1] = v[n] + down * _PART / whole
    return out


@compiled
def mean_score(score: np.ndarray, centre: np.ndarray) -> np.ndarray:
    """Return the mean score (n,) of the nine pixels about some positions."""
    h, w = score.shape
    out = np.empty(len(centre))
    for n in range(len(centre)):
        u = min(max(int(np.rint(centre[n, 0])), 1), w - 2)
        v = min(max(int(np.rint(centre[n, 1])), 1), h - 2)
        total = 0.0
        for j in range(v - 1, v + 2):
            for i in range(u - 1, u + 2):
                total += score[j, i]
        out[n] = total / 9.0
    return out


@compiled
def distinct(at: np.ndarray, apart: float) -> np.ndarray:
    """Return the rows to keep: in order, without those within ``apart`` of one kept."""
    kept = np.empty(len(at), np.int64)
    n = 0
    for i in range(len(at)):
        is_free = True
        for k in range(n):
            du, dv = at[i, 0] - at[kept[k], 0], at[i, 1] - at[kept[k], 1]
            if du * du + dv * dv < apart * apart:
                is_free = False
                break
        if is_free:
            kept[n] = i
            n += 1
    return kept[:n].copy()


@compiled
def describe(
    score: np.ndarray,
    weight: np.ndarray,
    pixels: np.ndarray,
    share: np.ndarray,
    near: np.ndarray,
    reach: int,
    apart: float,
    limits: np.ndarray,
    grid: tuple[int, int, int],
) -> np.ndarray:
    """Return the table (m, 8) of those ends that are far enough from all before them.

    Parameters
    ----------
    score, weight : ndarray, shape (h, w)
        Score of each pixel, and what :func:`weigh` says of it.
    pixels : ndarray of int, shape (2, n)
        Columns and rows of the ends, those first that are kept first.
    share : ndarray, shape (n,)
        Share of mask about each.
    near : ndarray, shape (n, 2)
        Centre of the mask near each.
    reach : int
        As of :class:`~pawnb.core.paws.offline.detection.colour.detector.DetectorConfig`.
    apart : float
        Least distance of two ends, in ``reach``.
    limits : ndarray, shape (k, 3)
        Lines on one side of which ends must be; see there.
    grid : tuple of int
        Left and top of the picture in the view, px, and by what factor it was reduced.
    """
    left, top, shrink = grid
    kept = distinct(near, apart * reach)
    far = centres(weight, pixels[0][kept], pixels[1][kept], 2 * reach)
    means = mean_score(score, near[kept])
    out = np.empty((len(kept), 8))
    n = 0
    for k in range(len(kept)):
        i = kept[k]
        u = (near[i, 0] + 0.5) * shrink - 0.5 + left
        v = (near[i, 1] + 0.5) * shrink - 0.5 + top
        is_inside = True
        for j in range(len(limits)):
            is_inside &= limits[j, 0] * u + limits[j, 1] * v + limits[j, 2] >= 0
        if not is_inside:
            continue
        out[n, 0], out[n, 1] = u, v
        out[n, 2] = (near[i, 0] - far[k, 0]) * shrink
        out[n, 3] = (near[i, 1] - far[k, 1]) * shrink
        out[n, 4], out[n, 5] = share[i], means[k]
        out[n, 6] = (pixels[0, i] + 0.5) * shrink - 0.5 + left
        out[n, 7] = (pixels[1, i] + 0.5) * shrink - 0.5 + top
        n += 1
    return out[:n].copy()
