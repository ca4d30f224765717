"""Standard errors and degrees of freedom of the fixed effects of a mixed model, for few animals.

Kenward & Roger (1997), as in SAS and in R's pbkrtest (Halekoh & Højsgaard 2014), for one term
at a time: the error is made larger for what the estimated variances and the weights made from
them hide, and t has the degrees of freedom that belong to the variance of that error.

Where the variance between animals that a term rests on is estimated as 0, as it is in half of
all studies in which it is 0, Kenward and Roger's p is far too large: 0-1 % false positives of
3 to 5 animals. Satterthwaite's, which then counts strides, is too small where animals have
unequal numbers of strides: 8-12 % of 3. There the error comes from how much the animals' own
scores differ: CR2 of Bell & McCaffrey (2002) with Satterthwaite's degrees of freedom (Pustejovsky
& Tipton 2018). Of balanced data both are the t test of the animals' own means or slopes, whatever
the variance is.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.gait.inference.mixed_likelihood import Blocks

KENWARD_ROGER = "Kenward-Roger"
SCORES = "CR2 of animals"

_SINGULAR = 1e-7
"""Least eigenvalue of a matrix scaled to a diagonal of 1 that is not rounding."""


class FixedEffects(NamedTuple):
    """Estimates of fixed effects.

    Attributes
    ----------
    estimates, errors, dfs : ndarray, shape (p,)
        Estimates, standard errors, degrees of freedom of t.
    methods : list of str
        How error and degrees of freedom of each were found.
    residual : float
        Variance of the residual.
    identified : bool
        False where the data do not tell the variances apart.
    """

    estimates: np.ndarray
    errors: np.ndarray
    dfs: np.ndarray
    methods: list[str]
    residual: float
    identified: bool


def estimate_fixed_effects(
    blocks: Blocks, variances: FloatArray, *, rests_on: Sequence[str | None]
) -> FixedEffects:
    """Estimate the fixed effects of a fitted model, with their errors and degrees of freedom.

    Parameters
    ----------
    blocks : Blocks
        The data.
    variances : ndarray
        Variance of each random part over that of the residual.
    rests_on : sequence of str or None
        The random part between animals on which the error of each term rests: ``animal`` for a
        term that is constant within animals, the term itself where it has a random slope, None
        for a term that is compared within animals only.

    Returns
    -------
    FixedEffects
        What was found.
    """
    p = blocks.p
    products, _ = blocks.products(variances)
    phi = np.linalg.inv(products[:p, :p])
    estimates = phi @ products[:p, p]
    residual = float(products[p, p] - products[:p, p] @ estimates) / (blocks.n - p)
    errors, dfs, identified = _kenward_roger(blocks, variances, phi * residual, residual)
    absent = {name for name, v in zip(blocks.names, variances, strict=True) if v == 0.0}
    by_scores = np.array([part in absent for part in rests_on])
    if by_scores.any():
        other, other_dfs = _cr2(blocks, variances, phi)
        errors, dfs = np.where(by_scores, other, errors), np.where(by_scores, other_dfs, dfs)
    methods = [SCORES if scores else KENWARD_ROGER for scores in by_scores]
    return FixedEffects(estimates, errors, dfs, methods, residual, identified)


def _kenward_roger(
    blocks: Blocks, variances: FloatArray, phi: FloatArray, residual: float
) -> tuple[FloatArray, FloatArray, bool]:
    """Return adjusted errors, degrees of freedom, and whether the variances are told apart."""
    firsts, seconds, information = _derivatives(blocks, variances, phi, residual)
    scale = 1.0 / np.sqrt(np.maximum(np.diag(information), 1e-300))
    scaled = information * np.outer(scale, scale)
    identified = bool(np.linalg.eigvalsh(scaled)[0] > _SINGULAR)
    covariance = np.zeros_like(scaled)
    there = np.ix_(*[np.append(True, variances > 0.0)] * 2)  # a part of no variance is no part
    covariance[there] = np.linalg.pinv(scaled[there], rcond=_SINGULAR, hermitian=True)
    covariance *= np.outer(scale, scale)
    # second derivatives of V are 0 here
    inner = seconds - np.einsum("iab,bc,jcd->ijad", firsts, phi, firsts)
    adjusted = phi + 2.0 * phi @ np.einsum("ij,ijab->ab", covariance, inner) @ phi
    gradients = np.einsum("ab,ibc,ca->ia", phi, firsts, phi)  # of the variances of the estimates
    spread = np.einsum("ia,ij,ja->a", gradients, covariance, gradients)
    dfs = 2.0 * np.diag(phi) ** 2 / np.maximum(spread, 1e-300)
    errors = np.sqrt(np.maximum(np.diag(adjusted), np.diag(phi)))
    return errors, np.minimum(dfs, blocks.n - blocks.p), identified


def _derivatives(
    blocks: Blocks, variances: FloatArray, phi: FloatArray, residual: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return P_i and Q_ij of Kenward and Roger, and the expected information.

    With the covariance V = sum of theta_i G_i (the residual first):
    ``P_i = -X' V^-1 G_i V^-1 X``, ``Q_ij = X' V^-1 G_i V^-1 G_j V^-1 X``, and information
    ``tr(P G_i P G_j) / 2`` of the restricted likelihood.
    """
    rows, parts = blocks.u.shape[1], len(blocks.names)
    x = blocks.xy[:, :, : blocks.p]
    inverse = np.linalg.inv(blocks.covariances(variances)) / residual
    ones = np.broadcast_to(np.eye(rows), inverse.shape)
    kernels = [ones]
    for i in range(parts):
        own = blocks.u[:, :, blocks.part_of == i]
        kernels.append(own @ own.transpose(0, 2, 1))
    weighted = inverse @ x
    moved = [g @ weighted for g in kernels]  # G_i V^-1 X
    firsts = np.array([-np.einsum("krp,krq->pq", weighted, m) for m in moved])
    count = len(kernels)
    seconds = np.empty((count, count, blocks.p, blocks.p))
    information = np.empty((count, count))
    products = [inverse @ g for g in kernels]
    for i in range(count):
        for j in range(i + 1):
            q = np.einsum("krp,krs,ksq->pq", moved[i], inverse, moved[j])
            seconds[i, j], seconds[j, i] = q, q.T
            trace = float(np.einsum("krs,ksr->", products[i], products[j]))
            if i == j == 0:
                trace += blocks.beyond / residual**2
            trace -= 2.0 * float(np.einsum("ab,ba->", phi, q))
            trace += float(np.einsum("ab,ba->", phi @ firsts[i], phi @ firsts[j]))
            information[i, j] = information[j, i] = trace / 2.0
    return firsts, seconds, information


def _cr2(blocks: Blocks, variances: np.ndarray, phi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return standard errors from the animals' scores, and degrees of freedom.

    ``phi`` is ``(X' W^-1 X)^-1``.
    """
    p = blocks.p
    roots, axes = np.linalg.eigh(blocks.covariances(variances))
    white = (axes / np.sqrt(roots)[:, None, :]) @ axes.transpose(0, 2, 1) @ blocks.xy
    x, y = white[:, :, :p], white[:, :, p]
    rest = y - x @ (phi @ np.einsum("krp,kr->p", x, y))
    left, axes = np.linalg.eigh(np.eye(x.shape[1]) - x @ phi @ x.transpose(0, 2, 1))
    known = left > _SINGULAR
    halves = np.where(known, 1.0 / np.sqrt(np.where(known, left, 1.0)), 0.0)
    moved = (axes * halves[:, None, :]) @ axes.transpose(0, 2, 1) @ x @ phi
    errors2 = (np.einsum("krp,kr->kp", moved, rest) ** 2).sum(axis=0)
    # how the scores of two animals vary together, for each term
    ends = np.einsum("krp,krq->kpq", moved, x)
    together = -np.einsum("ipa,ab,jpb->pij", ends, phi, ends)
    k = len(moved)
    together[:, np.arange(k), np.arange(k)] += np.einsum("krp,krp->pk", moved, moved)
    traces = np.einsum("pii->p", together)
    dfs = traces**2 / np.maximum(np.einsum("pij,pij->p", together, together), 1e-300)
    return np.sqrt(errors2), dfs
