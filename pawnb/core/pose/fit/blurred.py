"""A frame blurred for the coarse steps of a fit."""

from __future__ import annotations

import cv2
import numpy as np

from pawnb.core.pose.fit.solve_loops import Sight


def blurred(sight: Sight, half_width: float) -> Sight:
    """Return the sight blurred by a Gaussian as wide as a parabolic kernel of that half width."""
    sd = half_width / np.sqrt(5.0)
    return sight._replace(seen=cv2.GaussianBlur(sight.seen, (0, 0), sd))
