"""Pieces of path that belong to the body: a nose, an ear, the root of the tail look like paws too.

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
"""Share of its frames in which a piece must stay."""


def without_fixtures(
    pieces: Sequence[Tracklet], drift: np.ndarray, *, thickness: float
) -> list[Tracklet]:
    """Leave out the pieces that belong to the body.

    Parameters
    ----------
    pieces : sequence of Tracklet
        Pieces of path.
    drift : ndarray, shape (d,)
        How paws that stand move, length per frame.
    thickness : float
        Thickness of a paw.

    Returns
    -------
    list of Tracklet
        The others.
    """
    speed = float(np.linalg.norm(drift))
    if not pieces or speed == 0.0:
        return list(pieces)
    walks = np.zeros(max(piece.last for piece in pieces) + 1, bool)
    steps = [np.gradient(piece.at, axis=0) if len(piece.at) > 1 else None for piece in pieces]
    for piece, step in zip(pieces, steps, strict=True):
        if step is not None:
            stands = np.linalg.norm(step - drift, axis=1) < _WITH * speed
            walks[piece.first : piece.last + 1] |= stands
    kept = []
    for piece, step in zip(pieces, steps, strict=True):
        if step is not None:
            during = walks[piece.first : piece.last + 1]
            slow = np.linalg.norm(step, axis=1) < _SLOW * speed
            enough = during.sum() * speed > _PASSED * thickness
            if enough and (slow & during).sum() >= _SHARE * during.sum():
                continue
        kept.append(piece)
    return kept
