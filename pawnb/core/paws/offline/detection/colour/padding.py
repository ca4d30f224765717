"""The detections of many frames in one array, so that work on them needs no loop over frames."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

_COLUMNS = 8
"""Numbers of a detection."""


def pad_and_stack(found: Sequence[Sequence[np.ndarray]]) -> tuple[np.ndarray, np.ndarray]:
    """Put detections side by side.

    Parameters
    ----------
    found : sequence
        For each frame, the detections (m, 8) of each view.

    Returns
    -------
    table : ndarray, shape (n, V, most, 8)
        The detections, and 0 where there is none.
    is_there : ndarray of bool, shape (n, V, most)
        Where there is one.
    """
    number = np.array([[len(rows) for rows in here] for here in found])
    is_there = np.arange(max(1, int(number.max()))) < number[..., None]
    table = np.zeros((*is_there.shape, _COLUMNS), np.float32)
    table[is_there] = np.concatenate([rows for here in found for rows in here])
    return table, is_there
