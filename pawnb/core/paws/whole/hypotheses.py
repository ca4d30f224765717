"""Places in space where a paw may be: candidates of two views that meet."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pawnb.core import dlt
from pawnb.core.paws.whole.candidates import worth


@dataclass(frozen=True)
class Volume:
    """Where paws can be, as limits of coordinates along some directions.

    Parameters
    ----------
    up, across : ndarray, shape (3,)
        Unit vectors.
    height : tuple of float
        Lowest and highest coordinate along ``up``.
    width : tuple of float
        Lowest and highest coordinate along ``across``.
    """

    up: np.ndarray
    across: np.ndarray
    height: tuple[float, float]
    width: tuple[float, float]

    def holds(self, xyz: np.ndarray) -> np.ndarray:
        """Tell which points (n, 3) lie inside."""
        h, w = xyz @ self.up, xyz @ self.across
        return np.asarray(
            (h >= self.height[0]) & (h <= self.height[1])
            & (w >= self.width[0]) & (w <= self.width[1])
        )  # fmt: skip


@dataclass(frozen=True)
class Places:
    """Hypotheses of one frame.

    Parameters
    ----------
    at : ndarray, shape (k, d)
        Positions.
    cost : ndarray, shape (k,)
        Cost of taking each for a paw; lower is better.
    """

    at: np.ndarray
    cost: np.ndarray

    def take(self, which: np.ndarray) -> Places:
        """Return some of the hypotheses."""
        return Places(self.at[which], self.cost[which])

    def distance(self, points: np.ndarray) -> np.ndarray:
        """Return the distance (k,) of each from the nearest of some points (m, d)."""
        away = np.linalg.norm(self.at[:, None] - points[None], axis=-1)
        return np.asarray(away.min(axis=1, initial=np.inf))


class Pairing:
    """Makes hypotheses of candidates; holds what depends on the rig alone.

    Parameters
    ----------
    coefs : ndarray, shape (11, V)
        DLT coefficients.
    volume : Volume
        Where paws can be.
    tolerance_px : ndarray, shape (V,)
        Distance at which candidates of two views still count as one point.
    distal : sequence of (float, float)
        For each view, see :class:`~pawnb.core.paws.whole.candidates.Look`.
    apart : float
        Hypotheses closer than this are one.
    most : int
        Hypotheses kept.
    """

    def __init__(
        self,
        coefs: np.ndarray,
        volume: Volume,
        *,
        tolerance_px: np.ndarray,
        distal: Sequence[tuple[float, float]],
        apart: float,
        most: int,
    ) -> None:
        self.distal = distal
        self.coefs, self.volume, self.tolerance_px = coefs, volume, tolerance_px
        self.apart, self.most = apart, most
        matrices = [dlt.to_matrix(coefs[:, v]) for v in range(coefs.shape[1])]
        self.pairs = [
            (a, b, _fundamental(matrices[a], matrices[b]))
            for a, b in itertools.combinations(range(len(matrices)), 2)
        ]

    def places(self, found: list[np.ndarray]) -> Places:
        """Return the hypotheses of one frame from the candidates of its views."""
        uv = self._meeting(found)
        if not len(uv):
            return Places(np.empty((0, 3)), np.empty(0))
        xyz = triangulate(self.coefs, uv)
        xyz = xyz[self.volume.holds(xyz)]
        if not len(xyz):
            return Places(np.empty((0, 3)), np.empty(0))
        support = self._support(xyz, found)
        order = np.argsort(-support)
        kept: list[int] = []
        for i in order:
            if len(kept) == self.most:
                break
            if not kept or np.min(np.linalg.norm(xyz[kept] - xyz[i], axis=1)) >= self.apart:
                kept.append(int(i))
        return Places(xyz[kept], 1.5 * np.maximum(0.0, 2.0 - support[kept]))

    def _meeting(self, found: list[np.ndarray]) -> np.ndarray:
        """Return image positions (n, V, 2), NaN but for two views, of rays that meet."""
        rows = []
        n = self.coefs.shape[1]
        for a, b, F in self.pairs:
            ca, cb = found[a], found[b]
            if not len(ca) or not len(cb):
                continue
            pa = np.column_stack([ca[:, :2], np.ones(len(ca))]).astype(float)
            pb = np.column_stack([cb[:, :2], np.ones(len(cb))]).astype(float)
            line_b, line_a = pa @ F.T, pb @ F
            value = np.abs(line_b @ pb.T)
            away_b = value / np.hypot(line_b[:, 0], line_b[:, 1])[:, None]
            away_a = value / np.hypot(line_a[:, 0], line_a[:, 1])[None]
            i, j = np.nonzero((away_b < self.tolerance_px[b]) & (away_a < self.tolerance_px[a]))
            uv = np.full((len(i), n, 2), np.nan)
            uv[:, a], uv[:, b] = pa[i, :2], pb[j, :2]
            rows.append(uv)
        return np.concatenate(rows) if rows else np.empty((0, n, 2))

    def _support(self, xyz: np.ndarray, found: list[np.ndarray]) -> np.ndarray:
        """Return in how many views, softly counted, a candidate lies at each point (k,)."""
        uv = dlt.project(self.coefs, xyz)
        total = np.zeros(len(xyz))
        for v, rows in enumerate(found):
            if not len(rows):
                continue
            step = uv[:, v, None, :] - rows[None, :, :2]
            square = (step**2).sum(axis=-1) / (0.6 * self.tolerance_px[v]) ** 2
            total += (np.exp(-square) * worth(rows, self.distal[v])[None]).max(axis=1)
        return total


def triangulate(coefs: np.ndarray, uv: np.ndarray) -> np.ndarray:
    """Triangulate (n, V, 2) by the normal equations: quick, for hypotheses only."""
    seen = np.isfinite(uv[..., 0])
    w = seen.astype(float)[..., None]
    uv0 = np.where(seen[..., None], uv, 0.0)
    L = coefs.T
    Au = (L[None, :, 0:3] - uv0[..., :1] * L[None, :, 8:11]) * w
    Av = (L[None, :, 4:7] - uv0[..., 1:] * L[None, :, 8:11]) * w
    bu = (uv0[..., 0] - L[None, :, 3]) * w[..., 0]
    bv = (uv0[..., 1] - L[None, :, 7]) * w[..., 0]
    N = np.einsum("nvi,nvj->nij", Au, Au) + np.einsum("nvi,nvj->nij", Av, Av)
    r = np.einsum("nvi,nv->ni", Au, bu) + np.einsum("nvi,nv->ni", Av, bv)
    N += np.eye(3) * 1e-12 * np.trace(N, axis1=1, axis2=2)[:, None, None]
    return np.asarray(np.linalg.solve(N, r[..., None])[..., 0])


def _fundamental(A: np.ndarray, B: np.ndarray) -> np.ndarray:
    """Return F with ``b^T F a = 0`` for the pictures a, b of one point."""
    _, _, Vt = np.linalg.svd(A)
    e = B @ Vt[3]
    cross = np.array([[0, -e[2], e[1]], [e[2], 0, -e[0]], [-e[1], e[0], 0]])
    F = cross @ B @ np.linalg.pinv(A)
    return np.asarray(F / np.linalg.norm(F))
