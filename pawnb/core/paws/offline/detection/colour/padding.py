"""The detections of many frames in one array, so that work on them needs no loop over frames."""

from __future__ import annotations

import numpy as np

from pawnb.core.paws.offline.detection.colour.detections import (
    N_COLUMNS,
    Detections,
    InFrames,
)


def pad_and_stack(found: InFrames) -> tuple[Detections, np.ndarray]:
    """Put detections side by side.

    Parameters
    ----------
    found : sequence
        For each frame, the detections of each view.

    Returns
    -------
    detections : Detections
        The detections, (n, V, most), and 0 where there is none.
    is_there : ndarray of bool, shape (n, V, most)
        Where there is one.
    """
    number = np.array([[len(rows) for rows in here] for here in found])
    is_there = np.arange(max(1, int(number.max()))) < number[..., None]
    table = np.zeros((*is_there.shape, N_COLUMNS), np.float32)
    table[is_there] = np.concatenate([own.table for here in found for own in here])
    return Detections(table), is_there
