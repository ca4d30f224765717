"""What comes into the pipeline for one view."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass, field

from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.detection.evidence import Detections
from pawnb.core.paws.offline.reuse.point_evidence import PointEvidence
from pawnb.core.paws.offline.scene.stack import BodyStack
from pawnb.core.paws.offline.self_training.learnt import Earlier


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
    known : Annotations
        What is known of earlier tracks: certain where only a part is tracked again, and
        never trained on.
    earlier : Earlier, optional
        An earlier run on the same rows, from which what it has learnt is taken.
    kept : PointEvidence, optional
        What that run has found of points whose clicks are the same by now, in the rows that are
        tracked again.
    """

    name: str
    size: tuple[int, int]
    stack: BodyStack
    annotations: Annotations
    detections: Sequence[Detections] = ()
    known: Annotations = field(default_factory=lambda: Annotations({}))
    earlier: Earlier | None = None
    kept: PointEvidence | None = None

    def part(self, begin: int, end: int) -> ViewInput:
        """Return the rows from ``begin`` up to ``end``, with all that is certain in them."""
        placed = {row: dict(here) for row, here in self.known.places.items()}
        for row, here in self.annotations.places.items():
            placed[row] = {**placed.get(row, {}), **here}
        return dataclasses.replace(
            self,
            stack=self.stack.part(begin, end),
            annotations=Annotations(placed).part(begin, end),
            detections=[found.part(begin, end) for found in self.detections],
        )

    def how_framed(self) -> str:
        """Say how the body's frame of the view was found."""
        body = self.stack.body
        how = {
            "stays": "the animal stays in place",
            "follows": "it follows the animal",
            "travels": "it follows the animal",
            "turns": "it follows the animal and turns with it",
        }[body.kind]
        return f"{self.name}: {how}" + (", the camera moves" if body.pans else "")
