"""Tracklets that belong to the body: a nose, an ear, the root of the tail look like paws too.

A paw stands on the ground and moves with it, or swings. On a belt that moves, what keeps its
place for long is no paw; where no paw moves with the belt, belt and animal stand, and nothing
is said.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.paws.offline.association.network_flow.parameters import NETWORK_FLOW
from pawnb.core.paws.offline.association.network_flow.tracklets import Tracklet


def without_body_clutter(
    tracklets: Sequence[Tracklet], substrate_velocity: FloatArray, *, paw_width: float
) -> list[Tracklet]:
    """Leave out the tracklets that belong to the body.

    Parameters
    ----------
    tracklets : sequence of Tracklet
        Tracklets.
    substrate_velocity : ndarray, shape (d,)
        How paws that stand move, length per frame.
    paw_width : float
        Width of a paw.

    Returns
    -------
    list of Tracklet
        The others.
    """
    speed = float(np.linalg.norm(substrate_velocity))
    if not tracklets or speed == 0.0:
        return list(tracklets)
    walks = np.zeros(max(tracklet.last for tracklet in tracklets) + 1, bool)
    steps = [
        np.gradient(tracklet.at, axis=0) if len(tracklet.at) > 1 else None for tracklet in tracklets
    ]
    for tracklet, step in zip(tracklets, steps, strict=True):
        if step is not None:
            stands = (
                np.linalg.norm(step - substrate_velocity, axis=1)
                < NETWORK_FLOW.body_clutter_with * speed
            )
            walks[tracklet.first : tracklet.last + 1] |= stands
    kept = []
    for tracklet, step in zip(tracklets, steps, strict=True):
        if step is not None:
            during = walks[tracklet.first : tracklet.last + 1]
            slow = np.linalg.norm(step, axis=1) < NETWORK_FLOW.body_clutter_slow * speed
            enough = during.sum() * speed > NETWORK_FLOW.body_clutter_passed * paw_width
            if enough and (slow & during).sum() >= NETWORK_FLOW.body_clutter_share * during.sum():
                continue
        kept.append(tracklet)
    return kept
