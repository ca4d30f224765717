"""How far the candidates that points took are ahead of others: whether they could be told apart.

In every frame and view each candidate has a price for each point: what speaks against it there
by its look and by the other points, and how far it is from where all other frames have the
point, in the standard deviation of that. The *separation* of a candidate that was taken
is the price of the best one elsewhere in the picture, less its own: minus the logarithm of the
odds between both. Near 0 nothing tells them apart; below 0 another would have been cheaper by
this frame and view alone.
"""

from __future__ import annotations

import numpy as np

from pawnb.core.paws.offline.detection.colour.observations import Sights
from pawnb.core.paws.offline.projection import Geometry
from pawnb.core.paws.offline.smoothing import association_odds_kernels as loops

_APART = 0.5
"""Candidates nearer to each other than so many thicknesses say the same of a point."""
_MOST = 30.0
"""Largest separation, and that of candidates that are alone in their picture."""


def separations(
    measured: np.ndarray,
    expected: tuple[np.ndarray, np.ndarray],
    sights: Sights,
    *,
    against: np.ndarray,
    sigma: np.ndarray,
    geometry: Geometry,
    thickness_px: np.ndarray,
) -> np.ndarray:
    """Measure how far candidates are ahead of the next best ones.

    Parameters
    ----------
    measured : ndarray, shape (n, P, V, 2)
        Candidates taken, px, NaN where none.
    expected : (ndarray, ndarray), shape (n, P, d) and (n, P, d, d)
        Where the other frames have the points, and with what covariance.
    sights : Sights
        What every view shows.
    against : ndarray, shape (n, P, V, C)
        What speaks against each candidate being each point, minus a logarithm of odds.
    sigma : ndarray, shape (n, P, V, C)
        Standard deviation of each candidate, px.
    geometry : Geometry
        The views.
    thickness_px : ndarray, shape (V,)
        Thickness of a paw in each view.

    Returns
    -------
    ndarray, shape (n, P, V)
        Separations, -30 to 30; NaN where no candidate was taken, or it was placed by hand.
    """
    x, covariance = expected
    J = geometry.jacobian(x)
    spread = J @ covariance[:, :, None] @ np.swapaxes(J, -1, -2)
    return loops.gaps(
        measured, geometry.project(x), spread, sights.at, sights.is_there, sigma, against,
        _APART * thickness_px, _MOST,
    )  # fmt: skip
