"""Evidence that others offer: predictions of other programs, kinds of other packages."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pawnb.core.paws.layout import Layout
from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.detection.evidence import Detections, EvidenceKind, found_by
from pawnb.core.paws.offline.detection.predictions import predictions_as_detections
from pawnb.core.paws.offline.scene.stack import BodyStack
from pawnb.core.paws.request import TrackingRequest


def detections_of_others(
    layout: Layout,
    task: TrackingRequest,
    stack: BodyStack,
    *,
    annotations: Annotations,
    view: int,
    span: tuple[int, int],
    kinds: Sequence[EvidenceKind],
) -> list[Detections]:
    """Return what other programs and other packages' kinds of evidence find in a view.

    Parameters
    ----------
    layout : Layout
        Views and points of the recording.
    task : TrackingRequest
        What is to be tracked, with the predictions of other programs.
    stack : BodyStack
        The view.
    annotations : Annotations
        What was placed in it by hand.
    view : int
        Its number.
    span : (int, int)
        First row of the stack and one past its last, counted from the first frame of the task.
    kinds : sequence of EvidenceKind
        Kinds of evidence of other packages.

    Returns
    -------
    list of Detections
        One of each kind, and of the predictions.

    Raises
    ------
    InputError
        If a kind fails, or returns what cannot be used.
    """
    name = layout.views[view]
    asked: dict[str, Any] = {"annotations": annotations, "points": layout.points}
    found = [found_by(kind, name, stack, **asked) for kind in kinds]
    if name in task.predictions:
        uv, likelihood = (one[slice(*span)] for one in task.predictions[name].of(layout.points))
        size = layout.sizes[view]
        found.append(predictions_as_detections(uv, likelihood, annotations, size=size))
    return found
