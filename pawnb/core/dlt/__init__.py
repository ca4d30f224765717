"""Direct linear transform: fit, project and triangulate, on plain arrays.

A view is described by 11 coefficients, ``L1 .. L11``, with

    u = (L1 X + L2 Y + L3 Z + L4) / (L9 X + L10 Y + L11 Z + 1)
    v = (L5 X + L6 Y + L7 Z + L8) / (L9 X + L10 Y + L11 Z + 1)

(Abdel-Aziz & Karara 1971; paper 2019, Eq. 1). Coefficients of several views are the
columns of one array of shape (11, n_views). An affine view has L9 = L10 = L11 = 0.
Missing image positions are NaN.

Comes in: points in space and in pictures. Goes out: coefficients, and points that are projected
or triangulated.
"""

from pawnb.core.dlt.fit import FLAT_SHARE, MIN_POINTS, DltFit, fit_dlt
from pawnb.core.dlt.projection import (
    Triangulation,
    check_coefs,
    handedness,
    project,
    reprojection_error,
    to_matrix,
    transform_image,
    triangulate,
)

__all__ = [
    "FLAT_SHARE",
    "MIN_POINTS",
    "DltFit",
    "Triangulation",
    "check_coefs",
    "fit_dlt",
    "handedness",
    "project",
    "reprojection_error",
    "to_matrix",
    "transform_image",
    "triangulate",
]


def __dir__() -> list[str]:
    """List the public names."""
    return sorted(__all__)
