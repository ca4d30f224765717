"""Evidence of motion: optical flow from every click, both ways, checked forwards and backwards."""

from __future__ import annotations

from collections.abc import Iterator

import cv2
import numpy as np

from pawnb.arrays import ByteArray, Float32Array, FloatArray
from pawnb.core.parallel import in_parts
from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.detection.evidence import Detections
from pawnb.core.paws.offline.parameters import MotionParameters
from pawnb.core.paws.offline.scene.stack import BodyStack


def detect_by_motion(
    stack: BodyStack, annotations: Annotations, parameters: MotionParameters
) -> Detections:
    """Follow every click to the next and the previous click of the same point.

    Trust falls from frame to frame with the distance by which the flow back misses where it
    set out (Kalal, Mikolajczyk & Matas 2010).

    Parameters
    ----------
    stack : BodyStack
        The view.
    annotations : Annotations
        The clicks.
    parameters : MotionParameters
        The kind's parameters.

    Returns
    -------
    Detections
        At most two for each point and row.
    """
    ways = _ways(annotations, len(stack.grey))

    def along(way: tuple[int, int]) -> list[tuple[int, int, float, float, float]]:
        (row, end), points = way, ways[way]
        uv = np.array([annotations.places[row][point] for point in points])
        xy = uv @ stack.to_body[row, :, :2].T + stack.to_body[row, :, 2]
        followed = _follow(stack.grey, row, end, xy, parameters)
        return [(t, points[i], x, y, trust) for t, i, x, y, trust in followed]

    # ways do not depend on each other, and flow lets other threads run
    found = [one for own in in_parts(along, ways) for one in own]
    table = np.array(found, float).reshape(-1, 5)
    rows_found = table[:, 0].astype(int)
    place = stack.to_grid(table[:, 2:4])
    return Detections(
        row=rows_found,
        point=table[:, 1].astype(int),
        uv=stack.picture_of(place, rows_found),
        log_odds=np.log(parameters.gain * table[:, 4]),
        sd_px=np.full(len(table), parameters.sd * stack.spacing / stack.scale),
    )


def _ways(annotations: Annotations, n: int) -> dict[tuple[int, int], list[int]]:
    """Return the points that are followed from a row to another one, both ways."""
    ways: dict[tuple[int, int], list[int]] = {}
    for point in annotations.points:
        rows = annotations.rows_of(point)
        for before, row, after in zip([0, *rows], rows, [*rows[1:], n - 1], strict=False):
            for end in (after, before):
                ways.setdefault((row, end), []).append(point)
    return ways


def _follow(
    grey: ByteArray, row: int, end: int, xy: FloatArray, parameters: MotionParameters
) -> Iterator[tuple[int, int, float, float, float]]:
    """Yield row, number, x, y and trust while places (k, 2) are followed to another row."""

    def flow(source: ByteArray, target: ByteArray, at: Float32Array) -> tuple[np.ndarray, ...]:
        to, status, _ = cv2.calcOpticalFlowPyrLK(
            source, target, at, None,  # type: ignore[call-overload]
            winSize=(parameters.window,) * 2, maxLevel=parameters.levels,
        )  # fmt: skip
        return to, status[:, 0] > 0

    step = 1 if end > row else -1
    here, trust = np.asarray(xy, np.float32)[:, None], np.ones(len(xy))
    number = np.arange(len(xy))
    for t in range(row, end, step):
        there, found = flow(grey[t], grey[t + step], here)
        back, returned = flow(grey[t + step], grey[t], there)
        missed = np.linalg.norm(back - here, axis=-1)[:, 0].astype(float)
        trust = trust * parameters.kept * np.exp(-((missed / parameters.check_px) ** 2))
        on = found & returned & (trust >= parameters.lowest)
        here, trust, number = there[on], trust[on], number[on]
        if not len(number):
            return
        for i, (x, y), own in zip(number, here[:, 0].astype(float), trust, strict=True):
            yield t + step, int(i), float(x), float(y), float(own)
