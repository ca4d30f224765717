"""Tracklets that belong to the body: a nose, an ear, the root of the tail look like paws too.

A paw stands on the ground and moves with it, or swings. On a belt that moves, what keeps its
place for long is no paw; where no paw moves with the belt, belt and animal stand, and nothing
is said.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pawnb.core.paws.offline.association.network_flow.tracklets import Tracklet

_SLOW = 0.35
"""What is slower, in the speed of the ground, stays: paws that land or lift off do for a moment."""
_WITH = 0.4
"""Speeds that differ from the ground's by less of it are those of paws that stand."""
_PASSED = 3.0
"""Thicknesses by which the ground must have moved away under what stays."""
_SHARE = 0.8
"""Share of its frames in which a tracklet must stay."""


def without_body_clutter(
    tracklets: Sequence[Tracklet], substrate_velocity: np.ndarray, *, paw_width: float
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
            stands = np.linalg.norm(step - substrate_velocity, axis=1) < _WITH * speed
            walks[tracklet.first : tracklet.last + 1] |= stands
    kept = []
    for tracklet, step in zip(tracklets, steps, strict=True):
        if step is not None:
            during = walks[tracklet.first : tracklet.last + 1]
            slow = np.linalg.norm(step, axis=1) < _SLOW * speed
            enough = during.sum() * speed > _PASSED * paw_width
            if enough and (slow & during).sum() >= _SHARE * during.sum():
                continue
        kept.append(tracklet)
    return kept
