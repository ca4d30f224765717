"""Places in space that could be paws, and what they tell of the ground and the animal.

Spots of every view (:mod:`.start_proposal.blobs`) are paired over the views that track the
same points; pairs whose lines of sight meet are places. Over many frames most of them
gather where paws stand: the lowest height at which they gather is the ground; on it, they
gather twice along forward, where hind and where front paws stand, and the distance of
these two, the *span*, is the only measure of the animal that is needed.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d

from pawnb.arrays import BoolArray, FloatArray, Points3D
from pawnb.core.paws.start_proposal.blobs import Blobs
from pawnb.core.paws.start_proposal.parameters import PAW_PROPOSAL
from pawnb.core.rig import Rig
from pawnb.signals.robust import MAD_TO_SD


@dataclass(frozen=True)
class CandidatePlaces:
    """Places in space that could be paws, n of them.

    Parameters
    ----------
    xyz : ndarray, shape (n, 3)
        The places, in the unit of the rig.
    strength : ndarray, shape (n,)
        How paw-like each is, 0 to 1: as its spot that is least like a paw.
    residual : ndarray, shape (n,)
        How far its views disagree, in paw lengths; NaN where there is one view only.
    """

    xyz: Points3D
    strength: FloatArray
    residual: FloatArray

    @property
    def weight(self) -> FloatArray:
        """Strength, less where the views disagree."""
        off = np.nan_to_num(self.residual, nan=0.0) / PAW_PROPOSAL.place_residual_sd
        return self.strength * np.exp(-0.5 * off**2)


@dataclass(frozen=True)
class Stage:
    """Where paws stand in a recording.

    Parameters
    ----------
    axes : ndarray, shape (3, 3)
        Rows: forward, to the animal's right, up.
    ground : float
        Height at which places gather.
    middle : float
        Position to the right of the line between left and right paws.
    hind, front : float
        Position along forward of the middle of where hind and front paws stand.
    """

    axes: FloatArray
    ground: float
    middle: float
    hind: float
    front: float

    @property
    def span(self) -> float:
        """Distance between hind and front paws."""
        return self.front - self.hind


def pair_blobs(
    rig: Rig, blobs: Mapping[str, Blobs], *, paw_px: Mapping[str, float]
) -> CandidatePlaces:
    """Find the places that two of the views see.

    Parameters
    ----------
    rig : Rig
        The calibrated views.
    blobs : mapping of str to Blobs
        Spots of the views that track the same points.
    paw_px : mapping of str to float
        Length of a paw in each view, px.

    Returns
    -------
    CandidatePlaces
        One for each pair of spots whose lines of sight meet.
    """
    parts = [CandidatePlaces(np.empty((0, 3)), np.empty(0), np.empty(0))]
    for a, b in itertools.combinations(blobs, 2):
        here, there = blobs[a], blobs[b]
        uv = np.stack(np.broadcast_arrays(here.uv[:, None], there.uv[None]), axis=2)
        strength = np.minimum(here.strength[:, None], there.strength[None]).ravel()
        solved = rig.subset((a, b)).triangulate(uv.reshape(-1, 2, 2))
        residual = solved.residual_px / (0.5 * (paw_px[a] + paw_px[b]))
        good = residual < PAW_PROPOSAL.worst_residual
        good &= strength > PAW_PROPOSAL.least_strength
        parts.append(CandidatePlaces(solved.xyz[good], strength[good], residual[good]))
    return join(parts)


def on_ground(rig: Rig, view: str, blobs: Blobs, *, stage: Stage) -> CandidatePlaces:
    """Find where the lines of sight of one view meet the ground.

    Parameters
    ----------
    rig : Rig
        The calibrated views.
    view : str
        The view.
    blobs : Blobs
        Its spots.
    stage : Stage
        The ground.

    Returns
    -------
    CandidatePlaces
        One for each spot that is on the ground in front of the camera.
    """
    L = rig.coefs[:, rig.index(view)]
    u, v = blobs.uv.T
    rows = [L[None, 0:3] - u[:, None] * L[8:11], L[None, 4:7] - v[:, None] * L[8:11]]
    rows.append(np.broadcast_to(stage.axes[2], rows[0].shape))
    right = np.stack([u - L[3], v - L[7], np.full(len(u), stage.ground)], axis=-1)
    matrix = np.stack(rows, axis=1)
    good = np.abs(np.linalg.det(matrix)) > 1e-12 * np.abs(matrix).max(axis=(1, 2)) ** 3
    xyz = np.linalg.solve(matrix[good], right[good][..., None])[..., 0]
    return CandidatePlaces(xyz, blobs.strength[good], np.full(len(xyz), np.nan))


def join(parts: Sequence[CandidatePlaces]) -> CandidatePlaces:
    """Return the places of all parts, in their order."""
    names = ("xyz", "strength", "residual")
    joined = (np.concatenate([getattr(part, name) for part in parts]) for name in names)
    return CandidatePlaces(*joined)


def find_stage(places: CandidatePlaces, rig: Rig) -> Stage | None:
    """Find the ground, the line between left and right, and where the paws stand.

    Parameters
    ----------
    places : CandidatePlaces
        Places of many frames from all over the recording.
    rig : Rig
        Its directions forward and up.

    Returns
    -------
    Stage or None
        None where too few places gather.
    """
    forward, up = np.asarray(rig.forward, dtype=float), np.asarray(rig.up, dtype=float)
    axes = np.stack([forward, np.cross(forward, up), up])
    local = places.xyz @ axes.T
    p = PAW_PROPOSAL
    if len(local) < p.places_least:
        return None
    away = np.linalg.norm(local - np.median(local, axis=0), axis=1)
    near = away < p.place_far * np.median(away)
    local, weight = local[near], places.weight[near]
    low, high = np.percentile(local[:, 2], p.ground_range)
    total, edges = np.histogram(local[:, 2], bins=p.ground_bands, range=(low, high), weights=weight)
    # places that are wrong spread over many heights: what counts is a narrow peak
    peak = gaussian_filter1d(total, p.ground_narrow) - gaussian_filter1d(total, p.ground_wide)
    inner = peak[1:-1]
    is_peak = (inner > peak[:-2]) & (inner >= peak[2:])
    is_peak &= inner >= p.ground_gathered * inner.max()
    if not is_peak.any():
        return None
    band = edges[1] - edges[0]
    # the middle of the band, of which the first has no neighbour and is no peak
    ground = float(low + (np.flatnonzero(is_peak)[0] + 1.5) * band)
    standing = np.abs(local[:, 2] - ground) < p.ground_thickness * band
    if standing.sum() < p.places_least:
        return None
    local, weight = local[standing], weight[standing]
    for axis in (0, 1, 0, 1):
        near = _in_the_crowd(local[:, axis])
        local, weight = local[near], weight[near]
    hind, front = _two_middles(local[:, 0], weight)
    left, right = _two_middles(local[:, 1], weight)
    return Stage(axes, ground, 0.5 * (left + right), hind, front)


def _in_the_crowd(values: FloatArray) -> BoolArray:
    """Tell which numbers lie within some robust standard deviations of the median."""
    away = np.abs(values - np.median(values))
    return np.asarray(away <= PAW_PROPOSAL.crowd_sd * MAD_TO_SD * np.median(away))


def _two_middles(values: FloatArray, weight: FloatArray) -> tuple[float, float]:
    """Split numbers in two where it explains most of their variance; return both means."""
    order = np.argsort(values, kind="stable")
    x, w = values[order], weight[order] + 1e-12
    below, sum_below = np.cumsum(w)[:-1], np.cumsum(w * x)[:-1]
    above, sum_above = w.sum() - below, (w * x).sum() - sum_below
    low, high = sum_below / below, sum_above / above
    best = int((below * above * (high - low) ** 2).argmax())
    return float(low[best]), float(high[best])
