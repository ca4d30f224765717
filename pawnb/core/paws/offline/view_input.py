"""What comes into the pipeline for one view."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.detection.evidence import Detections
from pawnb.core.paws.offline.scene.stack import BodyStack


@dataclass(frozen=True)
class ViewInput:
    """What comes in for one view.

    Parameters
    ----------
    name : str
        Its name.
    size : (int, int)
        Its width and height, px.
    stack : BodyStack
        Its pictures in the body's frame.
    annotations : Annotations
        What was placed by hand.
    detections : sequence of Detections
        Of further kinds of evidence.
    """

    name: str
    size: tuple[int, int]
    stack: BodyStack
    annotations: Annotations
    detections: Sequence[Detections] = ()
