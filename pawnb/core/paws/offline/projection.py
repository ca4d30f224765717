"""From space to pictures: a calibrated rig, or one view by itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core import dlt

_SAME = np.array([[1.0, 0, 0, 0, 0, 1.0, 0, 0, 0, 0, 0]]).T
"""Mathematics: a view that shows the plane as it is."""


@dataclass(frozen=True)
class Projection:
    """Projection of positions into the views.

    Parameters
    ----------
    coefs : ndarray, shape (11, V), optional
        DLT coefficients; without them there is one view and positions are its pixels.
    """

    coefs: FloatArray | None

    @property
    def n_coordinates(self) -> int:
        """3 in calibrated space, 2 in a picture."""
        return 2 if self.coefs is None else 3

    @property
    def table(self) -> FloatArray:
        """DLT coefficients (11, V); those of a single view leave positions as they are."""
        return _SAME if self.coefs is None else self.coefs

    @property
    def rows(self) -> FloatArray:
        """The same, a row a view (V, 11), for loops.

        A new array each time: those that may not be written, as a rig's, are another type, for
        which all would be compiled once more.
        """
        return np.array(self.table.T, dtype=float, order="C")

    def project(self, x: FloatArray) -> FloatArray:
        """Return image positions (..., V, 2) of positions (..., d)."""
        if self.coefs is None:
            return np.asarray(x, dtype=float)[..., None, :]
        return dlt.project(self.coefs, x)

    def jacobian(self, x: FloatArray) -> FloatArray:
        """Return the derivative (..., V, 2, d) of :meth:`project`."""
        if self.coefs is None:
            return np.broadcast_to(np.eye(2), (*x.shape[:-1], 1, 2, 2))
        L = self.coefs
        uv = dlt.project(L, x)
        weight = (x @ L[8:11] + 1.0)[..., None, None]
        rows = np.stack([L[0:3].T, L[4:7].T], axis=1)
        return np.asarray((rows - uv[..., None] * L[8:11].T[:, None]) / weight)
