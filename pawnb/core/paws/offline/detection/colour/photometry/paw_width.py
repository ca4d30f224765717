"""How thick the paws are in one view, by the score of what is about the clicks."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from pawnb.arrays import Float32Array, FloatArray, IntArray
from pawnb.core.paws.offline.detection.colour_parameters import COLOUR


def paw_width_at(
    numbers: Sequence[IntArray], table: Float32Array, clicks: Sequence[FloatArray]
) -> float:
    """Measure how thick the paws are at the clicks: twice the distance to their edge.

    The edge is where the score is half way from that of the paw to that of what is around,
    smoothed, as single pixels that noise takes out of a paw would make it thin.

    Parameters
    ----------
    numbers : sequence of ndarray of int, shape (h, w)
        Bins of the pixels of some pictures.
    table : ndarray, shape (bins,)
        Score of each bin.
    clicks : sequence of ndarray, shape (k, 2)
        Positions in each picture, px.

    Returns
    -------
    float
        Median thickness, px.
    """
    found = []
    for number, uv in zip(numbers, clicks, strict=True):
        score = cv2.GaussianBlur(table[number], (0, 0), COLOUR.smooth_px)
        for place in np.round(uv).astype(int):
            low = np.maximum(place - COLOUR.look_px, 0)
            u1, v1 = place + COLOUR.look_px + 1
            part = score[low[1] : v1, low[0] : u1]
            fine = cv2.resize(
                part,
                None,
                fx=COLOUR.paw_width_fine,
                fy=COLOUR.paw_width_fine,
                interpolation=cv2.INTER_CUBIC,
            )
            u, v = ((place - low + 0.5) * COLOUR.paw_width_fine).astype(int)
            r = COLOUR.touch_px * COLOUR.paw_width_fine
            touched = (slice(max(v - r, 0), v + r + 1), slice(max(u - r, 0), u + r + 1))
            edge = 0.5 * (fine[touched].max() + np.percentile(part, COLOUR.paw_width_ground))
            depth = cv2.distanceTransform((fine > edge).astype(np.uint8), cv2.DIST_L2, 5)
            found.append(2.0 * float(depth[touched].max()) / COLOUR.paw_width_fine)
    return max(float(np.median(found)), 1.0)
