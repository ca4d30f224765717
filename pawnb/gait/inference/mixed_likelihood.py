"""Restricted likelihood of a mixed model of animals, each animal reduced to a few rows.

An animal's strides enter through the columns of its random parts and of the fixed terms only.
An orthogonal rotation of its strides puts all of these into the first few rows and leaves, in
the others, nothing but residuals of variance sigma². So an animal of ten thousand strides costs
as much as one of ten.
"""

from __future__ import annotations

import itertools
import math

import numpy as np
from scipy.optimize import minimize

from pawnb.arrays import FloatArray, IntArray

# logarithms of variances over that of the residual
_GRID = (-5.0, -1.5, 1.5)
_LOG_NO_VARIANCE = -14.0
_MOST_STARTS = 243


class Blocks:
    """The data of a mixed model, animal by animal.

    ``W = I + U D U'`` is the covariance of an animal's strides over that of the residual (U:
    columns of the random parts, D: their variances).

    Parameters
    ----------
    y : ndarray, shape (n,)
        Outcome.
    design : ndarray, shape (n, p)
        Fixed terms.
    codes : ndarray of int, shape (n,)
        Animal of each row, from 0.
    parts : dict of str to ndarray, shape (n,)
        Random parts: ``animal`` (ones) and terms with slopes of their own, which are taken about
        their mean.
    trial_codes : ndarray of int, shape (n,), or None
        Trial of each row, where trials are random too.

    Attributes
    ----------
    names : list of str
        Random parts, ``trial`` last.
    sizes : ndarray
        What the column of each was divided by, so that variances are comparable.
    """

    def __init__(
        self,
        y: FloatArray,
        design: FloatArray,
        codes: IntArray,
        parts: dict[str, np.ndarray],
        trial_codes: IntArray | None,
    ) -> None:
        self.n, self.p = design.shape
        self.names = [*parts] if trial_codes is None else [*parts, "trial"]
        columns = [c if name == "animal" else c - c.mean() for name, c in parts.items()]
        sizes = [float(np.sqrt(np.mean(c**2))) for c in columns]
        self.sizes = np.array(sizes if trial_codes is None else [*sizes, 1.0])
        whole = np.column_stack([c / size for c, size in zip(columns, sizes, strict=True)])
        members = [np.flatnonzero(codes == i) for i in range(int(codes.max()) + 1)]
        random = [whole[rows] for rows in members]
        if trial_codes is not None:
            random = [
                np.column_stack((u, trial_codes[rows][:, None] == np.unique(trial_codes[rows])))
                for u, rows in zip(random, members, strict=True)
            ]
        most = max(u.shape[1] for u in random)
        random = [np.pad(u, ((0, 0), (0, most - u.shape[1]))) for u in random]
        self.part_of = np.minimum(np.arange(most), len(self.names) - 1)
        reduced = [
            np.linalg.qr(np.column_stack((u, design[rows], y[rows])), mode="r")
            for u, rows in zip(random, members, strict=True)
        ]
        height = most + self.p + 1
        rows = np.array([np.pad(r, ((0, height - len(r)), (0, 0))) for r in reduced])
        self.u, self.xy = rows[:, :, :most], rows[:, :, most:]
        self.beyond = self.n - rows.shape[0] * height
        """Strides less rows: those left out, or less than 0 where rows of zeros were added."""

    def covariances(self, variances: FloatArray) -> FloatArray:
        """Return W of every animal's rows.

        Parameters
        ----------
        variances : ndarray
            Variance of each part over that of the residual.

        Returns
        -------
        ndarray, shape (animals, rows, rows)
            Covariances over that of the residual.
        """
        scaled = self.u * variances[self.part_of]
        return np.asarray(np.eye(self.u.shape[1]) + scaled @ self.u.transpose(0, 2, 1))

    def products(self, variances: FloatArray) -> tuple[FloatArray, float]:
        """Return ``[X y]' W^-1 [X y]`` over all animals, and log |W|.

        Parameters
        ----------
        variances : ndarray
            Variance of each part over that of the residual.

        Returns
        -------
        products : ndarray, shape (p + 1, p + 1)
            The sums.
        log_w : float
            The logarithm.
        """
        w = self.covariances(variances)
        inner = np.linalg.solve(w, self.xy)
        return np.einsum("kqi,kqj->ij", self.xy, inner), float(np.linalg.slogdet(w)[1].sum())

    def deviance(self, variances: FloatArray) -> float:
        """Return minus twice the restricted log likelihood, but for a constant.

        Parameters
        ----------
        variances : ndarray
            Variance of each part over that of the residual.

        Returns
        -------
        float
            The deviance.
        """
        products, log_w = self.products(variances)
        xx, xy = products[: self.p, : self.p], products[: self.p, self.p]
        rest = max(float(products[self.p, self.p] - xy @ np.linalg.solve(xx, xy)), 1e-300)
        return log_w + float(np.linalg.slogdet(xx)[1]) + (self.n - self.p) * math.log(rest)

    def fit(self) -> tuple[FloatArray, bool]:
        """Maximise the likelihood.

        From the best of a coarse grid: there are local maxima where one variance is 0.

        Returns
        -------
        variances : ndarray
            Variance of each part over that of the residual.
        converged : bool
            Whether a maximum was found.
        """
        parts = len(self.names)
        if len(_GRID) ** parts <= _MOST_STARTS:
            grid = np.array(list(itertools.product(_GRID, repeat=parts)))
        else:
            grid = np.repeat(np.array(_GRID)[:, None], parts, axis=1)
        start = grid[int(np.argmin([self.deviance(np.exp(one)) for one in grid]))]
        found = minimize(
            lambda logarithms: self.deviance(np.exp(logarithms)), start, method="Nelder-Mead",
            bounds=[(_LOG_NO_VARIANCE, 14.0)] * parts,
            options={"xatol": 1e-4, "fatol": 1e-7, "maxfev": 2000 * parts},
        )  # fmt: skip
        variances = np.exp(np.asarray(found.x, dtype=float))
        return np.where(variances < 2.0 * math.exp(_LOG_NO_VARIANCE), 0.0, variances), bool(
            found.success
        )
