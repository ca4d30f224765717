"""What speaks against the tracks of a tracker that decides over the whole recording.

Such tracks are smooth and their views agree, also where they are wrong: jumps and residuals tell
little. They carry their uncertainty (``sd``) instead, and what they say of themselves tells more:
points that are hardly recognised for a while, are only vaguely known, or are not where they
are at the same moment of other strides. Every kind of evidence counts by how much it is
above its own median; a point that no view shows counts less, as nobody can put it right there,
and so does one that moves fast: a paw in swing is out of sight and vague by right, while one that
stands, or is about to lift off, can be seen and is often taken wrong.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.ndimage import uniform_filter1d

from pawnb.core.paws.whole.cycle import learn_cycle
from pawnb.core.paws.whole.habit import follow_body
from pawnb.core.paws.whole.settings import WholeSettings
from pawnb.core.rig import Rig
from pawnb.core.suspect_evidence import (
    Evidence,
    find_nearest,
    image_positions,
    in_views,
    level_off,
    passes_disagree,
)
from pawnb.schema import ORIGIN_CODE, Tracks

_WHILE = 5
"""Frames over which confidence and residuals are averaged."""
_CONFIDENCE = 4.0
"""Evidence against a point that is not recognised at all."""
_CROSSING = 0.3
_OFF_CYCLE = 2.0
"""Standard deviations from the usual place that count one."""
_NEAR = 0.4
"""Points cross within about this share of the size of a paw."""
_UNSEEN = 0.6
"""Share of the doubt that is left where no view shows the point."""
_MOVING = 0.5
"""Doubts are divided by 1 plus this at the speed that a tenth of all labels reach."""
_FASTEST = 1.5
"""Speeds beyond this many times that one count no more."""
_ORDINARY_PERCENT = 80.0
"""In so many frames doubts are ordinary."""
_VAGUE = 4.0
"""Tracks this many times vaguer than usual count half where the stride is learnt."""


def states_uncertainty(tracks: Tracks) -> bool:
    """Tell whether tracks carry the uncertainty of their positions."""
    return "sd" in tracks and bool(np.isfinite(tracks["sd"].to_numpy()).any())


def collect_uncertainty(
    tracks: Tracks, *, rig: Rig | None, other: Tracks | None, paw_px: float | None
) -> list[Evidence]:
    """Measure every kind of evidence against tracks that state their uncertainty.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks with image positions and ``sd``.
    rig : Rig, optional
        The calibrated views: what is forward and up.
    other : xarray.Dataset, optional
        Tracks of the same recording made another way.
    paw_px : float, optional
        Size of a paw in px.

    Returns
    -------
    list of Evidence
        In a fixed order.

    Raises
    ------
    InputError
        If ``other`` shares no view and point with the tracks.
    """
    uv = image_positions(tracks)
    found = [_hardly_recognised(tracks, uv), _views_disagree(tracks, uv), _vague(tracks, uv)]
    away, off = off_cycle(tracks, rig)
    unit = tracks.attrs["units"]

    def words(key: tuple[int, int, int]) -> str:
        return f"it is {off[key[0], key[2]]:.1f} {unit} from where it is in other strides"

    found.append(_above_usual(level_off(away / _OFF_CYCLE), uv, words))
    found.append(_crossing(uv, tracks["keypoint"].to_numpy().tolist(), paw_px))
    if other is not None:
        found.append(passes_disagree(tracks, other, uv))
    return found


def add_up(tracks: Tracks, evidence: list[Evidence]) -> np.ndarray:
    """Return the doubts (n, V, P) about all labels; 0 for the ordinary ones.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks with image positions.
    evidence : list of Evidence
        What :func:`collect_uncertainty` found.
    """
    total = np.asarray(np.sum([item.score for item in evidence], axis=0))
    unseen = ~_recognised(tracks).any(axis=1, keepdims=True)
    total *= np.where(unseen, _UNSEEN, 1.0) / (1.0 + _MOVING * _pace(tracks))[:, None]
    known = np.isfinite(image_positions(tracks)[..., 0]).any(axis=1)
    if not known.any():
        return np.zeros(total.shape)
    middle, usual = np.percentile(total.max(axis=1)[known], (50.0, _ORDINARY_PERCENT))
    total = np.maximum(total - usual, 0.0) / max(float(usual - middle), 0.1)
    # who has placed a point in one view has seen to all of it
    by_hand = tracks["image_origin"].isel(individual=0).to_numpy() == ORIGIN_CODE["edited"]
    total *= ~by_hand.any(axis=1, keepdims=True)
    # in which view it shows best: where the point is seen, and least like itself
    sure = tracks["image_confidence"].isel(individual=0).to_numpy()
    return total * np.where(_recognised(tracks), 1.0 - 1e-3 * sure, 1.0 - 2e-3)


def _pace(tracks: Tracks) -> np.ndarray:
    """Return how fast points (n, P) move from the ground, 1 where a tenth are faster."""
    x = np.moveaxis(tracks["position"].isel(individual=0).to_numpy(), 1, -1)
    frames = tracks["frame"].to_numpy().astype(float)
    if len(frames) < 2:
        return np.zeros(x.shape[:2])
    velocity = np.gradient(x, frames, axis=0)
    known = np.isfinite(velocity).all(axis=-1)
    if not known.any():
        return np.zeros(x.shape[:2])
    # standing paws go with the ground, and most paws stand
    speed = np.linalg.norm(velocity - np.median(velocity[known], axis=0), axis=-1)
    fast = float(np.percentile(speed[known], 90.0))
    if not fast > 0:
        return np.zeros(x.shape[:2])
    return np.minimum(np.where(known, speed, 0.0) / fast, _FASTEST)


def _recognised(tracks: Tracks) -> np.ndarray:
    """Return which labels (n, V, P) were found in the picture, or placed by hand."""
    origin = tracks["image_origin"].isel(individual=0).to_numpy()
    return np.asarray((origin == ORIGIN_CODE["measured"]) | (origin == ORIGIN_CODE["edited"]))


def _above_usual(
    values: np.ndarray, uv: np.ndarray, words: Callable[[tuple[int, int, int]], str]
) -> Evidence:
    """Make evidence of values (n, P): what they have above their median."""
    known = values[np.isfinite(values)]
    usual = float(np.median(known)) if len(known) else 0.0
    return Evidence(in_views(np.nan_to_num(np.maximum(values - usual, 0.0)), uv), words)


def _relative(values: np.ndarray) -> tuple[np.ndarray, float]:
    """Return the logarithm of 1 + values in units of their median, and the median."""
    known = values[np.isfinite(values) & (values > 0)]
    usual = float(np.median(known)) if len(known) else 1.0
    return np.log1p(np.nan_to_num(values) / usual), usual


def _hardly_recognised(tracks: Tracks, uv: np.ndarray) -> Evidence:
    """Doubt points of which no view is sure for a while."""
    seen = _recognised(tracks)
    count = seen.sum(axis=1)
    confidence = tracks["image_confidence"].isel(individual=0).to_numpy()
    confidence = np.where(seen, confidence, 0.0).sum(axis=1) / np.maximum(count, 1)
    # a point that is out of sight is neither right nor wrong
    unsure = np.where(count > 0, 1.0 - confidence, 0.5)
    lasting = uniform_filter1d(unsure, _WHILE, axis=0, mode="nearest")

    def words(key: tuple[int, int, int]) -> str:
        t, _, p = key
        if count[t, p] == 0:
            return "no view shows it and it is only predicted"
        return f"it is hardly recognised here (confidence {1.0 - lasting[t, p]:.2f})"

    return _above_usual(_CONFIDENCE * lasting, uv, words)


def _views_disagree(tracks: Tracks, uv: np.ndarray) -> Evidence:
    """Doubt points whose views disagree for a while."""
    residual = np.nan_to_num(tracks["residual"].isel(individual=0).to_numpy())
    lasting = uniform_filter1d(residual, _WHILE, axis=0, mode="nearest")
    score, usual = _relative(lasting)

    def words(key: tuple[int, int, int]) -> str:
        here = lasting[key[0], key[2]]
        return f"the views disagree for a while (by {here:.1f} px, usually {usual:.1f})"

    return _above_usual(score, uv, words)


def _vague(tracks: Tracks, uv: np.ndarray) -> Evidence:
    """Doubt points that are only vaguely known."""
    sd = _uncertainty(tracks)
    score, usual = _relative(sd)
    unit = tracks.attrs["units"]

    def words(key: tuple[int, int, int]) -> str:
        here = sd[key[0], key[2]]
        return f"its place is only known to {here:.1f} {unit} (usually {usual:.1f})"

    return _above_usual(score, uv, words)


def _uncertainty(tracks: Tracks) -> np.ndarray:
    """Return the standard deviations (n, P) of positions, over all directions together."""
    sd = tracks["sd"].isel(individual=0).to_numpy()
    return np.asarray(np.sqrt(np.square(sd).sum(axis=1)))


def off_cycle(tracks: Tracks, rig: Rig | None) -> tuple[np.ndarray, np.ndarray]:
    """Measure how far points are from where they are at the same moment of other strides.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks with positions and ``sd``.
    rig : Rig, optional
        The calibrated views.

    Returns
    -------
    ndarray, shape (n, P)
        Distances in standard deviations of the stride; NaN for all where the points do not
        move in cycles, and for points seen too rarely.
    ndarray, shape (n, P)
        The same in the unit of space.
    """
    x = np.moveaxis(tracks["position"].isel(individual=0).to_numpy(), 1, -1)
    n, n_points, d = x.shape
    away = np.full((n, n_points), np.nan)
    off = away.copy()
    often = np.isfinite(x[..., 0]).mean(axis=0) > 0.5
    if not often.any():
        return away, off
    x = x[:, often]
    axes = np.eye(d)
    if d == 3 and rig is not None:
        forward, up = np.asarray(rig.forward, float), np.asarray(rig.up, float)
        axes = np.stack([forward, np.cross(up, forward), up])
    sd = _uncertainty(tracks)[:, often]
    usual = float(np.nanmedian(sd)) if np.isfinite(sd).any() else 0.0
    if not usual > 0:
        return away, off
    fps, usually = float(tracks.attrs["fps"]), WholeSettings()
    cycle = learn_cycle(
        x, follow_body(x, max(1, round(2.0 * usually.body_s * fps))), axes=axes,
        frames=(usually.shortest_stride_s * fps, usually.longest_stride_s * fps), noise=usual / 2.0,
        trust=np.nan_to_num(1.0 / (1.0 + (sd / (_VAGUE * usual)) ** 2)),
    )  # fmt: skip
    if cycle is not None:
        rows = np.arange(n)
        for k, p in enumerate(np.flatnonzero(often).tolist()):
            away[:, p] = np.sqrt(cycle.square(rows, k, x[:, k]))
            off[:, p] = np.linalg.norm(x[:, k] - cycle.mean[:, k], axis=-1)
    return away, off


def _crossing(uv: np.ndarray, points: list[str], paw_px: float | None) -> Evidence:
    """Doubt points that are close to another point in some view."""
    near, who, size = find_nearest(uv, paw_px)
    share = np.nan_to_num(np.exp(-near / (_NEAR * size)[:, None]), nan=0.0)
    closest = share.argmax(axis=1)

    def words(key: tuple[int, int, int]) -> str:
        t, _, p = key
        v = closest[t, p]
        return f"it is {near[t, v, p]:.0f} px from {points[who[t, v, p]]}: they may be mistaken"

    return _above_usual(_CROSSING * share.max(axis=1), uv, words)
