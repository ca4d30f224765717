"""Legs of the stick animal laid along limbs of the outline: which is which, and its joints."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares, linear_sum_assignment

from pawnb.arrays import BoolArray, FloatArray, IntArray
from pawnb.core.pose.animal import Leg, StickAnimal
from pawnb.core.pose.start_proposal.body_fit import BodyFit
from pawnb.core.pose.start_proposal.parameters import POSE_PROPOSAL
from pawnb.core.pose.start_proposal.silhouette import LimbOutline, Silhouette, sample_grid

_MOST_LEG_STEPS = 200
"""Resource: of the search for a leg's angles."""


@dataclass(frozen=True)
class LegFit:
    """One leg along its limb.

    Parameters
    ----------
    angles_deg : ndarray, shape (n_free,)
        Its free joints, degrees; see :class:`pawnb.core.pose.poses.Poses`.
    factor : float
        Length of the leg in the picture over ``scale`` times its length.
    sure : float
        0 (not found) to 1.
    """

    angles_deg: FloatArray
    factor: float
    sure: float


def assign_limbs(
    animal: StickAnimal, body: BodyFit, limbs: Sequence[LimbOutline]
) -> tuple[dict[str, LimbOutline], dict[str, float], float]:
    """Say which limb is which leg: by direction, length and the place where it leaves the body.

    Parameters
    ----------
    animal : StickAnimal
        The animal.
    body : BodyFit
        Its body in the outline.
    limbs : sequence of LimbOutline
        The limbs.

    Returns
    -------
    found : dict of str to LimbOutline
        Limb of each leg that has one.
    margins : dict of str to float
        How much worse the picture is explained when a leg changes limbs with another or
        goes without; 0 for legs without a limb.
    cost : float
        How badly all legs together fit.
    """
    p = POSE_PROPOSAL
    columns, whole = _cheapest(animal, body, limbs, longer=0.0, slack=p.length_sd_first)
    ratios = [
        _length_ratio(leg, body, limbs[k])
        for leg, k in zip(animal.legs, columns, strict=True)
        if k < len(limbs)
    ]
    # a species may have longer or shorter legs than its file says
    most = p.longer_most
    longer = float(np.clip(np.median(ratios), -most, most)) if ratios else 0.0
    columns, whole = _cheapest(animal, body, limbs, longer=longer, slack=p.length_sd)
    # a limb that is long and nobody's counts against the assignment
    longest = max((limb.own for limb in limbs), default=1.0)
    left = sum(limb.own / longest for k, limb in enumerate(limbs) if k not in columns)
    cost = float(whole[np.arange(len(columns)), columns].sum() + p.left_over * p.unmatched * left)
    found, margins = {}, {}
    for i, leg in enumerate(animal.legs):
        k = columns[i]
        if k >= len(limbs):
            margins[leg.name] = 0.0
            continue
        found[leg.name] = limbs[k]
        others = [j for j in range(len(columns)) if j != i]
        now = whole[i, k] + whole[others, columns[others]]
        swapped = whole[i, columns[others]] + whole[others, k]
        swapped[columns[others] >= len(limbs)] = np.inf
        margins[leg.name] = float(min((swapped - now).min(), p.unmatched))
    return found, margins, cost


def shared_limb(
    leg: Leg, body: BodyFit, found: dict[str, LimbOutline], *, outline: Silhouette
) -> LimbOutline | None:
    """Return the limb that a leg without one shares with another that lies close beside it.

    Parameters
    ----------
    leg : Leg
        The leg without a limb.
    body : BodyFit
        Where the body lies.
    found : dict of str to LimbOutline
        Limbs of the other legs.
    outline : Silhouette
        The outline.

    Returns
    -------
    LimbOutline or None
        The likeliest limb that is thick enough for two, cut to the leg's length; None where
        there is none.
    """
    thick = {name: _thickness(limb, outline) for name, limb in found.items()}
    usual = float(np.median(list(thick.values()))) if thick else 0.0
    p = POSE_PROPOSAL
    best, least = None, p.unmatched
    for name, limb in found.items():
        if thick[name] < p.two_legs * usual:
            continue
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(limb.path, axis=0).T))])
        rest = body.scale * sum(leg.lengths) - float(
            np.hypot(*(limb.root - body.place(np.array(leg.attach))))
        )
        inner = along <= max(rest, p.two_legs_share * along[-1])
        cut = LimbOutline(limb.path[inner], float(along[inner][-1]), 0.0)
        cost = _cost(leg, body, cut, longer=0.0, slack=p.length_sd)
        if cost < least:
            best, least = cut, cost
    return best


def fit_leg(
    leg: Leg, body: BodyFit, limb: LimbOutline, *, outline: Silhouette, margin: float
) -> LegFit:
    """Bend a leg so that it lies along a limb.

    Parameters
    ----------
    leg : Leg
        The leg.
    body : BodyFit
        Where the body lies.
    limb : LimbOutline
        Its limb.
    outline : Silhouette
        The outline that the limb is part of.
    margin : float
        How clearly the limb is this leg's; see :func:`assign_limbs`.

    Returns
    -------
    LegFit
        Joints and length; joints beyond their range cost more the further they are.
    """
    own = POSE_PROPOSAL
    part = np.array(own.leg_samples)
    attach = body.place(np.array(leg.attach))
    path = np.concatenate([attach[None], limb.path])
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
    lengths = body.scale * np.array(leg.lengths)
    chord = float(np.hypot(*(limb.tip - attach)))
    factor = float(np.clip(max(own.leg_arc * along[-1], chord) / lengths.sum(), *own.leg_factor))
    share = np.concatenate([[0.0], np.cumsum(lengths)]) / lengths.sum()
    joints = _along(path, along, share)
    free = np.array(leg.free)
    natural, half = np.array(leg.natural_deg)[free], np.array(leg.range_deg)[free] / 2
    inner = share[:-1, None] + np.diff(share)[:, None] * part
    wanted = _along(path, along, inner.ravel())

    def chain(p: FloatArray) -> FloatArray:
        """Joints and tip of the leg, (n + 1, 2) grid px."""
        angles = np.array(leg.natural_deg)
        angles[free] = p[:-1]
        turn = np.radians(body.heading_deg + leg.side * (90.0 - np.cumsum(angles)))
        steps = (np.exp(p[-1]) * lengths)[:, None] * np.stack([np.cos(turn), np.sin(turn)], 1)
        return np.concatenate([attach[None], attach + np.cumsum(steps, axis=0)])

    def residuals(p: FloatArray) -> FloatArray:
        places = chain(p)
        samples = places[:-1, None] + np.diff(places, axis=0)[:, None] * part[:, None]
        samples = samples.reshape(-1, 2)
        off = sample_grid(outline.ridge, samples)
        turn = (p[:-1] - natural) / half
        beyond = np.maximum(np.abs(turn) - 1.0, 0.0)
        return np.concatenate([
            own.leg_tip * (places[-1] - limb.tip),
            own.leg_middle * np.minimum(off, own.leg_far),
            own.leg_along * (samples - wanted).ravel(),
            own.leg_natural * turn,
            own.leg_beyond * beyond,
            [own.leg_length_weight * (p[-1] - np.log(factor))],
        ])  # fmt: skip

    start = np.append(_angles_of(leg, joints, body.heading_deg), np.log(factor))
    best = least_squares(residuals, start, method="lm", max_nfev=_MOST_LEG_STEPS)
    places = chain(best.x)
    off = float(np.hypot(*(places[-1] - limb.tip)))
    close = np.mean(sample_grid(outline.ridge, places[1:])) + off
    sure = _sureness(float(close), float(lengths.sum()), limb, margin)
    angles = (best.x[:-1] + 180.0) % 360.0 - 180.0
    return LegFit(angles, float(np.exp(best.x[-1])), sure)


def _sureness(close: float, size: float, limb: LimbOutline, margin: float) -> float:
    """Return how sure a leg of a size is that lies so close to its limb, 0 to 1."""
    p = POSE_PROPOSAL
    return float(
        np.exp(-((close / (p.leg_close * size)) ** 2))
        * (1.0 - np.exp(-max(margin, 0.0) / p.swap_cost))
        * min(1.0, p.leg_own * limb.own / limb.length)
    )


def count_crossings(chains: Sequence[FloatArray]) -> int:
    """Count pairs of legs, (n, 2) joints each, whose lines cross."""
    count = 0
    for a, b in itertools.combinations(chains, 2):
        count += bool(_cross(a[:-1, None], a[1:, None], b[None, :-1], b[None, 1:]).any())
    return count


def _cheapest(
    animal: StickAnimal, body: BodyFit, limbs: Sequence[LimbOutline], *, longer: float, slack: float
) -> tuple[IntArray, FloatArray]:
    """Return the cheapest limb of each leg, and the cost of each pair.

    Columns from ``len(limbs)`` on stand for having no limb.
    """
    costs = np.array(
        [
            [_cost(leg, body, limb, longer=longer, slack=slack) for limb in limbs]
            for leg in animal.legs
        ]
    )
    p = POSE_PROPOSAL
    most, other = p.unmatched_most * p.unmatched, p.unmatched_other * p.unmatched
    costs = np.minimum(costs.reshape(len(animal.legs), len(limbs)), most)
    nobody = np.where(np.eye(len(animal.legs), dtype=bool), p.unmatched, other)
    whole = np.concatenate([costs, nobody], axis=1)
    rows, columns = linear_sum_assignment(whole)
    return columns[np.argsort(rows)], whole


def _thickness(limb: LimbOutline, outline: Silhouette) -> float:
    """Return the mean half thickness of a limb's inner half, grid px."""
    inner = limb.path[: max(1, len(limb.path) // 2)]
    return float(np.mean(sample_grid(outline.depth, inner)))


def _length_ratio(leg: Leg, body: BodyFit, limb: LimbOutline) -> float:
    """Return the logarithm of a limb's length over the leg's."""
    attach = body.place(np.array(leg.attach))
    arc = limb.length + float(np.hypot(*(limb.root - attach)))
    return float(np.log(arc / (body.scale * sum(leg.lengths))))


def _cost(leg: Leg, body: BodyFit, limb: LimbOutline, *, longer: float, slack: float) -> float:
    """Return how badly a limb fits a leg: squares of deviations over their usual size."""
    p = POSE_PROPOSAL
    attach = body.place(np.array(leg.attach))
    lengths = np.array(leg.lengths)
    reach = limb.tip - attach
    usual = _natural_tip_deg(leg)
    direction = _forward_deg(leg, reach, body.heading_deg)
    turned = _wrapped(direction - usual) / p.direction_sd_deg
    length = (_length_ratio(leg, body, limb) - longer) / slack
    length *= 1.0 if length > 0 else p.length_short  # a raised leg is shorter in the picture
    # where the limb leaves the body, seen from the middle of the legs' roots
    out = _wrapped(_forward_deg(leg, limb.root - attach, body.heading_deg) - leg.natural_deg[0])
    near = np.hypot(*(limb.root - attach)) / (body.scale * (lengths[0] + lengths[1]))
    rooted = out / (2 * p.root_sd_deg), max(near - 1.0, 0.0) / p.root_sd
    return float(turned**2 + length**2 + rooted[0] ** 2 + rooted[1] ** 2)


def _natural_tip_deg(leg: Leg) -> float:
    """Return the direction of the tip from the root in the natural pose, forwards from across."""
    turn = np.radians(np.cumsum(leg.natural_deg))
    lengths = np.array(leg.lengths)
    return float(np.degrees(np.arctan2(lengths @ np.sin(turn), lengths @ np.cos(turn))))


def _forward_deg(leg: Leg, step: FloatArray, heading_deg: float) -> float:
    """Return a direction in the picture as degrees forwards from the perpendicular to the body."""
    direction = np.degrees(np.arctan2(step[1], step[0]))
    return float(_wrapped(90.0 - leg.side * (direction - heading_deg)))


def _angles_of(leg: Leg, joints: FloatArray, heading_deg: float) -> FloatArray:
    """Return the free joints of a leg whose joints lie at these places, degrees."""
    n = len(leg.segments)
    angles, total = [], 0.0
    for j in range(n):
        if leg.free[j]:
            # a free joint turns all segments up to the next free one
            end = next((k for k in range(j + 1, n) if leg.free[k]), n)
            turn = _wrapped(_forward_deg(leg, joints[end] - joints[j], heading_deg) - total)
            angles.append(turn)
            total += turn
        else:
            total += leg.natural_deg[j]
    return np.array(angles)


def _along(path: FloatArray, along: FloatArray, share: FloatArray) -> FloatArray:
    """Return points at shares of a path's length, shape (n, 2)."""
    at = share * along[-1]
    return np.stack([np.interp(at, along, path[:, 0]), np.interp(at, along, path[:, 1])], axis=1)


def _cross(a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray) -> BoolArray:
    """Say whether the lines a-b and c-d cross."""

    def side(p: FloatArray, q: FloatArray, r: FloatArray) -> FloatArray:
        return np.sign(
            (q[..., 0] - p[..., 0]) * (r[..., 1] - p[..., 1])
            - (q[..., 1] - p[..., 1]) * (r[..., 0] - p[..., 0])
        )

    return (side(a, b, c) * side(a, b, d) < 0) & (side(c, d, a) * side(c, d, b) < 0)


def _wrapped(angle: float) -> float:
    """Return an angle in [-180, 180)."""
    return (angle + 180.0) % 360.0 - 180.0
