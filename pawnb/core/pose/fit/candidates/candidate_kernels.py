"""What candidate poses of single legs are worth on a frame: compiled loops."""

from __future__ import annotations

import math

import numpy as np

from pawnb.core.compiled import compiled_loosely
from pawnb.core.pose.fit.layout import PoseLayout
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import ImageEvidence
from pawnb.core.pose.fit.rendering.paint_kernels import (
    NOTHING,
    clear,
    leg_chain,
    misfit,
    paint_body,
    paint_leg,
    step,
)


@compiled_loosely
def leg_footprint(
    layout: PoseLayout,
    pose: np.ndarray,
    leg: int,
    image_evidence: ImageEvidence,
    blur: float,
    soft: float,
    least: float,
    base: np.ndarray,
    value: np.ndarray,
    owner: np.ndarray,
    along: np.ndarray,
    joints: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, float]:
    """Return the pixels a leg covers, how dark it paints them, and what that is worth.

    Pixels count that it makes darker by ``least``. ``base`` is the painted body; the worth is the
    cost of the picture with body and leg less that with the body alone. Only the part of the
    canvas about the leg is painted and looked at.
    """
    leg_chain(layout, pose, leg, joints)
    height, width = value.shape
    top, bottom, left, right = height, 0, width, 0
    reach = 0.0
    for radius in layout.radius[leg]:
        reach = max(reach, radius + blur + 1.0)
    for s in range(layout.n_segments[leg] + 1):
        u, v = joints[s, 0] - image_evidence.box[0], joints[s, 1] - image_evidence.box[1]
        left, right = min(left, math.floor(u - reach)), max(right, math.ceil(u + reach))
        top, bottom = min(top, math.floor(v - reach)), max(bottom, math.ceil(v + reach))
    left, right = min(max(left, 0), width), min(right, width)
    top, bottom = min(max(top, 0), height), min(bottom, height)
    for v in range(top, bottom):
        value[v, left:right] = 0.0
        owner[v, left:right] = NOTHING
    paint_leg(layout, joints, leg, blur, image_evidence.box, value, owner, along)
    n = 0
    for v in range(top, bottom):
        for u in range(left, right):
            if value[v, u] > base[v, u] + least and image_evidence.weight[v, u] > 0.0:
                n += 1
    pixels, darks = np.empty(n, np.int64), np.empty(n)
    n, cost = 0, 0.0
    for v in range(top, bottom):
        for u in range(left, right):
            if value[v, u] > base[v, u] + least and image_evidence.weight[v, u] > 0.0:
                pixels[n], darks[n] = v * width + u, value[v, u]
                seen = image_evidence.seen[v, u]
                change = misfit(value[v, u] - seen, soft) - misfit(base[v, u] - seen, soft)
                cost += image_evidence.weight[v, u] * change
                n += 1
    return pixels, darks, cost


@compiled_loosely
def shared_cost(
    pixels_a: np.ndarray, darks_a: np.ndarray, pixels_b: np.ndarray, darks_b: np.ndarray,
    image_evidence: ImageEvidence, base: np.ndarray, soft: float,
) -> float:  # fmt: skip
    """Return the cost of two footprints together less that of each alone.

    Pixels are in ascending order. What both explain is counted once, so two legs on one place
    pay for it.
    """
    width = base.shape[1]
    i = j = 0
    total = 0.0
    while i < pixels_a.shape[0] and j < pixels_b.shape[0]:
        if pixels_a[i] < pixels_b[j]:
            i += 1
        elif pixels_a[i] > pixels_b[j]:
            j += 1
        else:
            v, u = pixels_a[i] // width, pixels_a[i] % width
            seen = image_evidence.seen[v, u]
            a, b = misfit(darks_a[i] - seen, soft), misfit(darks_b[j] - seen, soft)
            both = a if darks_a[i] > darks_b[j] else b
            total += image_evidence.weight[v, u] * (both - a - b + misfit(base[v, u] - seen, soft))
            i += 1
            j += 1
    return total


@compiled_loosely
def paint_base(
    layout: PoseLayout, pose: np.ndarray, blur: float, image_evidence: ImageEvidence,
    value: np.ndarray, owner: np.ndarray,
) -> None:  # fmt: skip
    """Paint the body alone."""
    clear(value, owner)
    paint_body(layout, pose, blur, image_evidence.box, value, owner)


@compiled_loosely
def cover_painted(value: np.ndarray, owner: np.ndarray, dark: float) -> None:
    """Make what is painted as dark as ``dark``."""
    for v in range(value.shape[0]):
        for u in range(value.shape[1]):
            if owner[v, u] != NOTHING:
                value[v, u] = dark


@compiled_loosely
def free_of_others(
    image_evidence: ImageEvidence,
    zone: np.ndarray,
    owner: np.ndarray,
    neutral: float,
    out: np.ndarray,
) -> None:
    """Write darkness, at most ``neutral`` where ``zone`` or another leg lies, into ``out``.

    Where nothing can be seen it is NaN.
    """
    for v in range(out.shape[0]):
        for u in range(out.shape[1]):
            here = image_evidence.seen[v, u]
            if image_evidence.weight[v, u] == 0.0:
                out[v, u] = math.nan
            elif zone[v, u] or owner[v, u] != NOTHING:
                out[v, u] = min(here, neutral)
            else:
                out[v, u] = here


@compiled_loosely
def leg_support(
    layout: PoseLayout,
    joints: np.ndarray,
    leg: int,
    image_evidence: ImageEvidence,
    blur: float,
    limits: tuple[float, float, float],
    body: np.ndarray,
) -> tuple[float, float]:
    """Return how dark a leg's axis is relative to what is expected: whole leg, outer part.

    ``limits`` are the part of the leg, from the tip inwards, that counts as outer; the least
    darkness that is expected; and the share of that from which on the painted ``body`` looks the
    same without the leg: such places do not count, nor do those outside the crop. Where nothing
    counts, the answer is NaN.
    """
    share, least_dark, as_dark = limits
    height, width = image_evidence.seen.shape
    n = layout.n_segments[leg]
    whole = 0.0
    for s in range(n):
        whole += math.hypot(joints[s + 1, 0] - joints[s, 0], joints[s + 1, 1] - joints[s, 1])
    done, found, length, outer, outer_length = 0.0, 0.0, 0.0, 0.0, 0.0
    for s in range(n):
        du, dv = joints[s + 1, 0] - joints[s, 0], joints[s + 1, 1] - joints[s, 1]
        piece = math.hypot(du, dv)
        steps = max(1, int(piece))
        for i in range(steps):
            t = (i + 0.5) / steps
            u = round(joints[s, 0] + t * du - image_evidence.box[0])
            v = round(joints[s, 1] + t * dv - image_evidence.box[1])
            at = done + t * piece
            if 0 <= u < width and 0 <= v < height:
                dark = layout.dark[leg, s] + t * (layout.dark[leg, s + 1] - layout.dark[leg, s])
                radius = layout.radius[leg, s] + t * (
                    layout.radius[leg, s + 1] - layout.radius[leg, s]
                )
                # what is thin and what is near the tip is blurred
                expected = max(dark * min(1.0, radius) * step((whole - at) / blur), least_dark)
                if body[v, u] > as_dark * expected or image_evidence.weight[v, u] == 0.0:
                    continue
                here = min(max(image_evidence.seen[v, u] / expected, 0.0), 1.0)
                found += here * piece / steps
                length += piece / steps
                if at > (1.0 - share) * whole:
                    outer += here * piece / steps
                    outer_length += piece / steps
        done += piece
    return (
        found / length if length > 0 else math.nan,
        outer / outer_length if outer_length > 0 else math.nan,
    )


@compiled_loosely
def unexplained(
    owner: np.ndarray, image_evidence: ImageEvidence, dark: float, reach: float, pose: np.ndarray
) -> np.ndarray:
    """Return how many dark pixels near the animal nothing painted covers: left, right."""
    total = np.zeros(2)
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    for v in range(owner.shape[0]):
        for u in range(owner.shape[1]):
            if owner[v, u] == NOTHING and image_evidence.seen[v, u] > dark:
                du, dv = u + image_evidence.box[0] - pose[0], v + image_evidence.box[1] - pose[1]
                if du * du + dv * dv < reach * reach:
                    total[1 if -du * sin + dv * cos > 0 else 0] += 1.0
    return total
