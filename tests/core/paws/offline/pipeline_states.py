"""States of the treadmill pipeline for tests of single stages."""

import numpy as np

from pawnb.core.paws.offline.association.network_flow.assignment import Assignment
from pawnb.core.paws.offline.gap_closing.state import TrackingState
from pawnb.core.paws.offline.stride.model import StrideModel


def known_state(chosen, annotated, body=None, **strides):
    """What is known before any tracks are, but for what is told of strides."""
    return TrackingState(
        Assignment(chosen, annotated), np.full(chosen.shape, np.nan), np.zeros(chosen.shape[:2]),
        StrideModel(**strides), body,
    )  # fmt: skip
