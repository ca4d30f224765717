"""Mean-field iterations: every point in every view, given the others."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from pawnb.arrays import Float32Array
from pawnb.core.parallel import Threads
from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.association.epipolar import epipolar_support
from pawnb.core.paws.offline.association.exclusivity import open_to_each
from pawnb.core.paws.offline.association.forward_backward import (
    Posterior,
    smooth_posterior,
)
from pawnb.core.paws.offline.association.joint import paint_names, tell_apart
from pawnb.core.paws.offline.association.parameters import LINKS
from pawnb.core.paws.offline.detection.evidence import bump_at
from pawnb.core.paws.offline.parameters import AssociationParameters, IdentityParameters
from pawnb.core.paws.offline.scene.stack import BodyStack
from pawnb.core.rig import Rig


@dataclass(frozen=True)
class ViewEvidence:
    """What is known of one view before points and views are compared.

    Parameters
    ----------
    stack : BodyStack
        The view.
    name : str
        Its name.
    size : (int, int)
        Its width and height, px.
    annotations : Annotations
        What was placed by hand; certain.
    likelihood : mapping
        Point to ratios of likelihoods (n, h, w) of all kinds together.
    prior : mapping
        Point to the probability of places without evidence (h, w).
    looks, others : mapping, optional
        Point to ratios of likelihoods (n, h, w) by appearance, and by all other kinds; with
        them names are decided over whole tracklets.
    trust : float
        Power of the ratios by appearance within ``likelihood``.
    """

    stack: BodyStack
    name: str
    size: tuple[int, int]
    annotations: Annotations
    likelihood: Mapping[int, np.ndarray]
    prior: Mapping[int, np.ndarray]
    looks: Mapping[int, np.ndarray] = field(default_factory=dict)
    others: Mapping[int, np.ndarray] = field(default_factory=dict)
    trust: float = 1.0


def associate(
    views: Sequence[ViewEvidence],
    *,
    radius: float,
    parameters: AssociationParameters,
    rig: Rig | None = None,
    identity: IdentityParameters | None = None,
    compared: bool = True,
) -> list[dict[int, Posterior]]:
    """Return the probability of every place for every point and frame, view by view.

    Parameters
    ----------
    views : sequence of ViewEvidence
        The views.
    radius : float
        About half a paw, in places.
    parameters : AssociationParameters
        The stage's parameters.
    rig : Rig, optional
        Without it every view is by itself.
    identity : IdentityParameters, optional
        With it the last iteration has names decided jointly over whole tracklets.
    compared : bool
        Whether the agreement of posteriors, and how sure names are, is worked out; both are 1
        throughout otherwise.

    Returns
    -------
    list of dict
        For each view: point to its Posterior.
    """
    factors: list[dict[int, np.ndarray]] = [{} for _ in views]
    decided: dict[str, dict[int, np.ndarray]] = {}
    for iteration in range(parameters.iterations):
        posteriors = [
            _solve(
                view,
                factor,
                parameters,
                compared=compared and iteration == parameters.iterations - 1,
            )
            for view, factor in zip(views, factors, strict=True)
        ]
        if iteration == parameters.iterations - 1:
            break
        masses = [{point: p.mass for point, p in own.items()} for own in posteriors]
        support = _support(views, masses, radius, rig)
        last = iteration == parameters.iterations - 2
        factors = []
        for view, own, more in zip(views, masses, support, strict=True):
            if identity is not None and last and len(own) > 1:
                factor, decided[view.name] = _kinds_apart(
                    view, own, more, radius=radius, parameters=identity, sampled=compared
                )
            else:
                factor = open_to_each(own, radius, parameters.exclusive)
            factors.append({p: f * more[p] if p in more else f for p, f in factor.items()})
    return [
        {
            p: dataclasses.replace(q, name_share=decided[view.name][p])
            if view.name in decided
            else q
            for p, q in own.items()
        }
        for view, own in zip(views, posteriors, strict=True)
    ]


def _solve(
    view: ViewEvidence,
    factors: Mapping[int, Float32Array],
    parameters: AssociationParameters,
    *,
    compared: bool,
) -> dict[int, Posterior]:
    """Return the posteriors of one view, its points in parallel."""
    stack = view.stack
    points = sorted(view.likelihood)

    def one(point: int) -> Posterior:
        ratio = view.likelihood[point]
        ratio = ratio * factors[point] if point in factors else ratio.copy()
        for row in view.annotations.rows_of(point):
            uv = view.annotations.places[row][point]
            ratio[row] = bump_at(ratio.shape[1:], stack.grid_of(uv, row), LINKS.click_sd) + 1e-9
        return smooth_posterior(
            np.asarray(ratio, np.float32),
            stack.forward,
            stack.backward,
            prior=view.prior[point],
            parameters=parameters,
            compared=compared,
        )

    with Threads() as pool:
        return dict(zip(points, pool.map(one, points), strict=True))


def _support(
    views: Sequence[ViewEvidence],
    masses: Sequence[Mapping[int, np.ndarray]],
    radius: float,
    rig: Rig | None,
) -> list[dict[int, np.ndarray]]:
    """Return what calibrated views say of each other; nothing of one view."""
    if rig is None or len(views) < 2:
        return [{} for _ in views]
    return epipolar_support(
        masses, [v.stack for v in views], names=[v.name for v in views],
        clicks=[v.annotations for v in views], rig=rig, radius=radius,
    )  # fmt: skip


def _kinds_apart(
    view: ViewEvidence,
    masses: Mapping[int, Float32Array],
    support: Mapping[int, Float32Array],
    *,
    radius: float,
    parameters: IdentityParameters,
    sampled: bool,
) -> tuple[dict[int, np.ndarray], dict[int, np.ndarray]]:
    """Return factors by which every tracklet is one point's alone, and how surely it is."""
    points, shape = sorted(masses), view.stack.shape
    tracklets, names, shares = tell_apart(
        view.stack, view.annotations, masses=masses, looks=view.looks,
        others={p: m * support[p] if p in support else m for p, m in view.others.items()},
        prior=view.prior, trust=view.trust, radius=radius, parameters=parameters, sampled=sampled,
    )  # fmt: skip
    factors = paint_names(
        shape, tracklets, names, points=points, radius=radius, parameters=parameters
    )
    sure = {p: np.zeros(shape[0]) for p in points}
    for one, name, share in zip(tracklets, names, shares, strict=True):
        if name >= 0:
            sure[int(name)][one.rows] = share
    return factors, sure
