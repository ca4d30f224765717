"""What of a frame counts in the last fits: not what the animal is painted without."""

from __future__ import annotations

import numpy as np

from pawnb.core.pose.fit.fitter import FrameFitter
from pawnb.core.pose.fit.learning.body_clutter import without_odd_places
from pawnb.core.pose.fit.learning.leg_clutter import without_hairs
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import Sight
from pawnb.core.pose.fit.rendering.leg_attachments import without_corners


def counted(fitter: FrameFitter, pose: np.ndarray, sight: Sight) -> Sight:
    """Return a sight without the weight of odd places, hairs and corners; see their modules.

    Parameters
    ----------
    fitter : FrameFitter
        A fitter.
    pose : ndarray, shape (n_parameters,)
        Where the animal is.
    sight : Sight
        A frame.

    Returns
    -------
    Sight
        Its weight is a new array.
    """
    for without in (without_odd_places, without_hairs, without_corners):
        sight = without(fitter, pose, sight)
    return sight
