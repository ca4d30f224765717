"""Evidence of motion: optical flow from every click, both ways, checked forwards and backwards."""

from __future__ import annotations

from collections.abc import Iterator

import cv2
import numpy as np

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
    n = len(stack.grey)
    found: list[tuple[int, int, float, float, float]] = []
    for point in annotations.points:
        rows = annotations.rows_of(point)
        for i, row in enumerate(rows):
            uv = annotations.places[row][point]
            xy = stack.to_body[row, :, :2] @ uv + stack.to_body[row, :, 2]
            after = rows[i + 1] if i + 1 < len(rows) else n - 1
            before = rows[i - 1] if i else 0
            for end in (after, before):
                for t, x, y, trust in _follow(stack.grey, row, end, xy, parameters):
                    found.append((t, point, x, y, trust))
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


def _follow(
    grey: np.ndarray, row: int, end: int, xy: np.ndarray, parameters: MotionParameters
) -> Iterator[tuple[int, float, float, float]]:
    """Yield row, x, y and trust while a place is followed to another row."""

    def flow(source: np.ndarray, target: np.ndarray, at: np.ndarray) -> tuple[np.ndarray, bool]:
        to, status, _ = cv2.calcOpticalFlowPyrLK(
            source, target, at, None,  # type: ignore[call-overload]
            winSize=(parameters.window,) * 2, maxLevel=parameters.levels,
        )  # fmt: skip
        return to, bool(status[0, 0])

    step = 1 if end > row else -1
    here, trust = np.array([[xy]], np.float32), 1.0
    for t in range(row, end, step):
        there, found = flow(grey[t], grey[t + step], here)
        back, returned = flow(grey[t + step], grey[t], there)
        if not (found and returned):
            return
        missed = float(np.linalg.norm(back - here))
        trust *= parameters.kept * np.exp(-((missed / parameters.check_px) ** 2))
        if trust < parameters.lowest:
            return
        here = there
        yield t + step, float(here[0, 0, 0]), float(here[0, 0, 1]), trust
