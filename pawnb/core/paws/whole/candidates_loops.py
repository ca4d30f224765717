"""Compiled loops over the pixels of a score; see :mod:`pawnb.core.paws.whole.candidates`."""

from __future__ import annotations

import numpy as np

from pawnb.core.compiled import compiled


@compiled
def look_up(table: np.ndarray, numbers: np.ndarray) -> np.ndarray:
    """Return the entries (h, w) of a table with these numbers."""
    out = np.empty(numbers.shape, table.dtype)
    for v in range(numbers.shape[0]):
        for u in range(numbers.shape[1]):
            out[v, u] = table[numbers[v, u]]
    return out


@compiled
def weigh(score: np.ndarray) -> np.ndarray:
    """Return how far each pixel (h, w) belongs to the mask: 0 at score -1, 1 at score 1."""
    out = np.empty_like(score)
    for v in range(score.shape[0]):
        for u in range(score.shape[1]):
            out[v, u] = min(max(score[v, u] * np.float32(0.5) + np.float32(0.5), 0.0), 1.0)
    return out


@compiled
def find_ends(score: np.ndarray, share: np.ndarray, reach: int) -> tuple[np.ndarray, np.ndarray]:
    """Return rows and columns (n,) of mask pixels of which none within ``reach`` has less share."""
    h, w = score.shape
    rows, columns = np.empty(h * w, np.int64), np.empty(h * w, np.int64)
    n = 0
    for v in range(h):
        for u in range(w):
            own = share[v, u]
            is_end = score[v, u] > 0 and own <= 1.0
            j = max(v - reach, 0)
            while is_end and j <= min(v + reach, h - 1):
                for i in range(max(u - reach, 0), min(u + reach, w - 1) + 1):
                    if score[j, i] > 0 and share[j, i] < own:
                        is_end = False
                        break
                j += 1
            if is_end:
                rows[n], columns[n] = v, u
                n += 1
    return rows[:n].copy(), columns[:n].copy()


@compiled
def centres(weight: np.ndarray, u: np.ndarray, v: np.ndarray, reach: int) -> np.ndarray:
    """Return the weighted centres (n, 2) of discs about some pixels."""
    h, w = weight.shape
    out = np.empty((len(u), 2))
    limit = (reach + 0.5) ** 2
    for n in range(len(u)):
        mass = along = down = 0.0
        for j in range(max(-reach, -v[n]), min(reach, h - 1 - v[n]) + 1):
            for i in range(max(-reach, -u[n]), min(reach, w - 1 - u[n]) + 1):
                if i * i + j * j <= limit:
                    here = np.float64(weight[v[n] + j, u[n] + i])
                    mass += here
                    along += here * i
                    down += here * j
        out[n, 0] = u[n] + along / max(mass, 1e-6)
        out[n, 1] = v[n] + down / max(mass, 1e-6)
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
