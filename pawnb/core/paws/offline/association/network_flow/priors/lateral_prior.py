"""How far to the side of the body each paw goes, where two views of one side give little depth.

A paw that one view alone sees can lie anywhere along its sight line, and with two cameras on one
side of the animal smoothing draws it far off along it, to where the far paw is. Paws keep to
their sides: what frames in which two views met say of that holds for the others.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pawnb.arrays import FloatArray, IntArray
from pawnb.core.paws.offline.association.network_flow.parameters import NETWORK_FLOW


@dataclass(frozen=True)
class LateralPrior:
    """Where paws usually are to the side, and how surely.

    Parameters
    ----------
    across : ndarray, shape (d,)
        Unit vector to the side.
    usual : ndarray, shape (n, P)
        Where each point usually is along it in each frame.
    information : ndarray, shape (P,)
        One over the variance of that; 0 of points of which nothing is known.
    """

    across: FloatArray
    usual: FloatArray
    information: FloatArray

    def add(self, W: FloatArray, z: FloatArray, views: IntArray) -> None:
        """Add to information (n, P, d, d) and target (n, P, d) where fewer than two views see.

        ``views`` is how many do, shape (n, P).

        Parameters
        ----------
        W : ndarray, shape (n, P, d, d)
            Information, changed in place.
        z : ndarray, shape (n, P, d)
            Target, changed in place.
        views : ndarray of int, shape (n, P)
            How many views see each point.
        """
        known = np.where(views < 2, self.information, 0.0)
        W += known[..., None, None] * np.outer(self.across, self.across)
        z += (known * self.usual)[..., None] * self.across


def learn_lateral_prior(
    places: FloatArray, body: FloatArray, across: FloatArray, *, body_scale: float
) -> LateralPrior:
    """Return where points usually are to the side of the body.

    Parameters
    ----------
    places : ndarray, shape (n, P, d)
        Where views met, NaN elsewhere.
    body : ndarray, shape (n, d)
        The slowly moving middle of the body.
    across : ndarray, shape (d,)
        Unit vector to the side.
    body_scale : float
        Distance of front from hind paws, in the same unit.

    Returns
    -------
    LateralPrior
        By the median of each point and the spread about it.
    """
    middle = (body @ across)[:, None]
    away = places @ across - middle
    known = np.isfinite(away).any(axis=0)
    usual, spread = np.zeros(away.shape[1]), np.full(away.shape[1], np.inf)
    usual[known] = np.nanmedian(away[:, known], axis=0)
    spread[known] = NETWORK_FLOW.to_sd * np.nanmedian(np.abs(away[:, known] - usual[known]), axis=0)
    return LateralPrior(
        across,
        middle + usual,
        1.0 / (spread**2 + (NETWORK_FLOW.lateral_prior_wanders * body_scale) ** 2),
    )
