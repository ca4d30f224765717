"""How far a kind of evidence is trusted, by how often it agrees with what the others say."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import numpy as np

from pawnb.core.paws.offline.association.estimates import Estimates
from pawnb.core.paws.offline.detection.evidence import Detections
from pawnb.core.paws.offline.parameters import RUN
from pawnb.core.paws.offline.scene.stack import BodyStack


def agreeing_share(
    found: Detections, stack: BodyStack, estimates: Mapping[int, Estimates], *, radius: float
) -> dict[int, float]:
    """Return in which share of rows the best place of a kind is that of all other kinds.

    Parameters
    ----------
    found : Detections
        Of the kind.
    stack : BodyStack
        The view.
    estimates : mapping
        Point to where the other kinds put it; they must not have used this one.
    radius : float
        About half a paw, in places.

    Returns
    -------
    dict
        Point to the share, 0 to below 1; points of which nothing was found are left out.
    """
    shares = {}
    for point, estimate in estimates.items():
        own = np.flatnonzero(found.point == point)
        if not len(own):
            continue
        order = own[np.lexsort((-found.log_odds[own], found.row[own]))]
        best = order[np.unique(found.row[order], return_index=True)[1]]
        off = [
            np.linalg.norm(stack.grid_of(found.uv[i], found.row[i]) - estimate.place[found.row[i]])
            for i in best
        ]
        shares[point] = float(np.sum(np.array(off) < radius)) / (len(best) + RUN.agreement_pseudo)
    return shares


def trust_by_agreement(found: Detections, shares: Mapping[int, float]) -> Detections:
    """Scale detections of a kind by how often its best place is that of all other kinds.

    A kind that finds a point where clicks, flow and appearance find it, forwards and backwards in
    time, is believed elsewhere; one that is mostly alone is not.

    Parameters
    ----------
    found : Detections
        Of the kind.
    shares : mapping
        Point to the share of rows that agree (:func:`agreeing_share`).

    Returns
    -------
    Detections
        The ratios of likelihoods of each point, beyond 1, times its share.
    """
    log_odds = found.log_odds.copy()
    for point, share in shares.items():
        log_odds[found.point == point] += np.log(max(share, 1e-6))
    return dataclasses.replace(found, log_odds=log_odds)
