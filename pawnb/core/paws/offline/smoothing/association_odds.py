"""How far the detections that points took are ahead of others: whether they could be distinguished.

In every frame and view each detection has a price for each point: what speaks against it there
by its look and by the other points, and how far it is from where all other frames have the
point, in the standard deviation of that. The *separation* of a detection that was taken
is the price of the best one elsewhere in the picture, less its own: minus the logarithm of the
odds between both. Near 0 nothing tells them apart; below 0 another would have been cheaper by
this frame and view alone.
"""

from __future__ import annotations

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.paws.offline.detection.colour.observations import Observations
from pawnb.core.paws.offline.projection import Projection
from pawnb.core.paws.offline.smoothing import association_odds_kernels as loops
from pawnb.core.paws.offline.smoothing.parameters import SMOOTHING


def association_log_odds(
    measured: FloatArray,
    expected: tuple[FloatArray, FloatArray],
    observations: Observations,
    *,
    negative_log_odds: FloatArray,
    sigma: FloatArray,
    geometry: Projection,
    paw_width_px: FloatArray,
) -> FloatArray:
    """Measure how far detections are ahead of the next best ones.

    Parameters
    ----------
    measured : ndarray, shape (n, P, V, 2)
        Detections taken, px, NaN where none.
    expected : (ndarray, ndarray), shape (n, P, d) and (n, P, d, d)
        Where the other frames have the points, and with what covariance.
    observations : Observations
        What every view shows.
    negative_log_odds : ndarray, shape (n, P, V, C)
        What speaks against each detection being each point, minus a logarithm of odds.
    sigma : ndarray, shape (n, V, C)
        Standard deviation of each detection, px.
    geometry : Projection
        The views.
    paw_width_px : ndarray, shape (V,)
        Width of a paw in each view.

    Returns
    -------
    ndarray, shape (n, P, V)
        Separations, -30 to 30; NaN where no detection was taken, or it was placed by hand.
    """
    x, covariance = expected
    J = geometry.jacobian(x)
    spread = J @ covariance[:, :, None] @ np.swapaxes(J, -1, -2)
    return loops.gaps(
        measured,
        geometry.project(x),
        spread,
        observations.at,
        observations.is_there,
        sigma,
        negative_log_odds,
        SMOOTHING.association_odds_apart * paw_width_px,
        SMOOTHING.association_odds_most,
    )
