"""Which points are landmarks, and their tracks in space from where each view has seen them."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np

from pawnb.arrays import BoolArray, FloatArray, IntArray
from pawnb.core.paws.layout import Layout, Placement
from pawnb.core.paws.offline.landmarks.parameters import LANDMARKS
from pawnb.core.paws.offline.landmarks.template_tracking import window_px
from pawnb.core.paws.offline.projection import Projection
from pawnb.core.paws.offline.smoothing import refinement_kernels as loops
from pawnb.core.paws.offline.smoothing.forward_backward_distance import (
    NormalEquations,
    forward_backward_distance,
)
from pawnb.core.paws.offline.smoothing.smoother import covariances, diagonals, smooth
from pawnb.core.paws.offline.smoothing.tracks import SmoothedTracks
from pawnb.errors import InputError

_BODY_PART = re.compile(
    r"(?i)(?<![a-z])(?:left|right)?(?:nose|snout|muzzle|head|ear(?![a-z])|eye|neck|back|spine|trunk"
    r"|chest|belly|abdomen|thorax|rump|tail|shoulder|scapula|elbow|wrist|hip|pelvis|knee|ankle)"
)


def choose_landmarks(
    points: Sequence[str], kinds: Sequence[str], named: Sequence[str] = ()
) -> BoolArray:
    """Tell which points are landmarks rather than paws.

    Parameters
    ----------
    points : sequence of str
        Names of the points.
    kinds : sequence of str
        ``"front"``, ``"hind"`` or ``"other"`` for each.
    named : sequence of str
        Points that a person says are landmarks.

    Returns
    -------
    ndarray of bool, shape (P,)
        Those named, and points whose name tells no paw: all of them where others do, else
        those that are called after another part of the body.

    Raises
    ------
    InputError
        If a point is named that there is not.
    """
    for name in named:
        if name not in points:
            raise InputError(
                f"setting 'landmarks' names {name!r}; the points are {', '.join(points)}."
            )
    paws = [kind != "other" for kind in kinds]
    return np.array(
        [
            point in named or (not paw and (any(paws) or bool(_BODY_PART.search(point))))
            for point, paw in zip(points, paws, strict=True)
        ],
        dtype=bool,
    )


def check_landmarks(layout: Layout, placed: Mapping[int, Sequence[Placement]]) -> None:
    """Refuse a landmark in calibrated space that was clicked in a single view.

    Parameters
    ----------
    layout : Layout
        The landmarks as its points.
    placed : mapping
        Frame to positions that are known there.

    Raises
    ------
    InputError
        If one view alone has a landmark: it does not tell where that is in space.
    """
    if layout.rig is None:
        return
    here = {(place.point, place.view) for places in placed.values() for place in places}
    for number, point in enumerate(layout.points):
        views = sorted({layout.views[v] for p, v in here if p == number})
        if len(views) < 2:
            raise InputError(
                f"landmark {point!r} is clicked in view {views[0]!r} alone, which does not tell "
                "where it is in space; click it in a second view, or leave it out."
            )


def join_views(
    uv: FloatArray,
    likeness: FloatArray,
    *,
    by_hand: BoolArray,
    layout: Layout,
    fps: float,
    max_occlusion_s: float,
) -> SmoothedTracks:
    """Join what the views have seen into smooth tracks.

    Parameters
    ----------
    uv : ndarray, shape (n, P, V, 2)
        Where each view has seen each landmark, px; NaN where it has not.
    likeness : ndarray, shape (n, P, V)
        How much it looked like itself, 0 to 1.
    by_hand : ndarray of bool, shape (n, P, V)
        What a person has put in place.
    layout : Layout
        The landmarks as its points.
    fps : float
        Frames per second.
    max_occlusion_s : float
        A landmark that is not seen for longer is missing.

    Returns
    -------
    SmoothedTracks
        The tracks; positions are NaN where a landmark is missing.
    """
    n, n_points = likeness.shape[:2]
    geometry = Projection(None if layout.rig is None else layout.rig.coefs)
    d = geometry.n_coordinates
    patch_px = np.array([float(window_px(width)) for width, _ in layout.sizes])
    sigma = LANDMARKS.tracks_sigma * patch_px / np.clip(likeness, LANDMARKS.least_clear, 1.0)
    x, sd = np.full((n, n_points, d), np.nan), np.full((n, n_points, d), np.nan)
    apart = np.full((n, n_points), np.nan)
    start = uv[:, :, 0] if layout.rig is None else layout.rig.triangulate(uv).xyz
    for p in range(n_points):
        placed = np.flatnonzero(np.isfinite(start[:, p, 0]))
        if not len(placed):
            continue
        begun = np.stack(
            [np.interp(np.arange(n), placed, start[placed, p, i]) for i in range(d)], 1
        )
        per_unit = np.linalg.norm(geometry.jacobian(begun[placed[0]]), axis=(-2, -1)) / np.sqrt(2.0)
        patch = float(np.median(patch_px / per_unit))
        jerk = LANDMARKS.tracks_jerk * patch * (LANDMARKS.rate_hz / fps) ** 3
        path, equations = _smoothest(
            begun, uv[:, p], sigma[:, p], by_hand=by_hand[:, p], jerk=jerk, geometry=geometry
        )
        known = _near(placed, n, max_occlusion_s * fps)
        x[known, p] = path[known]
        variance = diagonals(equations.covariance[:, 0]) + (LANDMARKS.tracks_alike * patch) ** 2
        sd[known, p] = np.sqrt(variance)[known]
        apart[:, p] = forward_backward_distance(equations)[:, 0]
    # no two detections are kept of a landmark, and no earlier decision
    displacement_from_first_pass, association_log_odds = (
        np.full((n, n_points), np.nan),
        np.full(likeness.shape, np.nan),
    )
    return SmoothedTracks(
        x, sd, uv, likeness, displacement_from_first_pass, association_log_odds, apart
    )


def _smoothest(
    x: FloatArray,
    uv: FloatArray,
    sigma: FloatArray,
    *,
    by_hand: BoolArray,
    jerk: float,
    geometry: Projection,
) -> tuple[FloatArray, NormalEquations]:
    """Return the smoothest path (n, d) through what views (n, V) have seen, and what it solves."""
    table = geometry.rows
    seen = np.isfinite(uv[..., 0])
    jerk2 = np.full(x.shape, jerk**2)
    for step in range(LANDMARKS.tracks_steps):
        weight = 1.0 / sigma**2
        if step:
            away = np.linalg.norm(uv - geometry.project(x), axis=-1)
            weight *= np.minimum(
                (LANDMARKS.tracks_tail + 1.0) / (LANDMARKS.tracks_tail + (away / sigma) ** 2), 1.0
            )
        weight = np.where(by_hand, LANDMARKS.by_hand / sigma**2, weight)
        weight = np.where(seen, weight, 0.0)
        W, z = loops.normal_equations(
            x[:, None], np.nan_to_num(uv)[:, None], weight[:, None], table
        )
        x, factor = smooth(W[:, 0], z[:, 0], jerk2)
    spread = covariances(factor, x.shape[1])[:, None]
    return x, NormalEquations(W, z, jerk2[:, None], np.zeros(z.shape), None, spread)


def _near(placed: IntArray, n: int, longest: float) -> BoolArray:
    """Tell which of n frames lie on or between frames that are no further apart than that."""
    known = np.zeros(n, dtype=bool)
    known[placed] = True
    for before, after in pairwise(placed):
        if after - before <= longest:
            known[before:after] = True
    return known
