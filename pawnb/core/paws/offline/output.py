"""Estimates of every view written as Tracks: positions, origins, how likely, their sd."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from pawnb.arrays import FloatArray, IntArray
from pawnb.core import dlt
from pawnb.core.paws.layout import Layout, Placement
from pawnb.core.paws.offline.association.in_space import (
    beyond_body,
    misses_clicks,
    shared_places,
    surest_two,
)
from pawnb.core.paws.offline.parameters import RUN
from pawnb.core.paws.offline.pipeline import ViewTrack
from pawnb.core.paws.offline.projection import Projection
from pawnb.core.paws.offline.quality.calibration import of_all_views
from pawnb.core.paws.offline.quality.measures import (
    CALIBRATED,
    falling,
    largest_distance,
    usual_span,
)
from pawnb.core.paws.offline.quality.parameters import LIMITS, QUALITY
from pawnb.core.paws.offline.treadmill.output import blank_tracks, keep_rows
from pawnb.core.paws.request import TrackingRequest
from pawnb.schema import ORIGIN_CODE, Tracks

_UNKNOWN_PX = 1e3
"""Guard: standard deviation, px, of places of which none is known; it leaves them no weight."""


def write_tracks(
    found: Sequence[ViewTrack],
    layout: Layout,
    task: TrackingRequest,
    *,
    placed: Mapping[int, Sequence[Placement]],
) -> Tracks:
    """Write what was found in the views.

    Parameters
    ----------
    found : sequence of ViewTrack
        One for each view of the layout.
    layout : Layout
        Points and views.
    task : TrackingRequest
        What was asked for. Of tracks that are gone on from, rows before its frames are kept.
    placed : mapping
        Row to what was placed by hand there.

    Returns
    -------
    Tracks
        ``image_confidence`` is the probability that the label lies within about half a paw
        (:mod:`.calibration`), in calibrated views that of all together
        (:func:`.calibration.of_all_views`); ``image_origin`` is ``measured`` where that is at least
        ``RUN.measured``, ``reprojected`` where only other calibrated views saw the point,
        ``missing`` where it is below ``RUN.lost``, else ``predicted``.
    """
    uv = np.stack([view.uv for view in found], axis=2)  # (n, P, V, 2)
    sd_px = np.stack([view.sd_px for view in found], axis=2)
    chance = np.stack([view.probability for view in found], axis=2)
    by_hand = np.zeros(chance.shape, bool)
    for row, here in placed.items():
        for place in here:
            if place.origin == "edited" and 0 <= row < len(uv):
                uv[row, place.point, place.view] = place.uv
                by_hand[row, place.point, place.view] = True
    chance = np.where(by_hand, 1.0, np.where(np.isfinite(uv[..., 0]), chance, 0.0))
    if layout.rig is None:
        x, sd, residual = _first_view(uv, sd_px, chance)
    else:
        x, sd, residual = _in_space(uv, sd_px, chance, layout.rig.coefs)
        chance = np.where(by_hand, chance, chance * _one_place_each(x, chance)[..., None])
    fill, told = np.zeros(chance.shape, bool), chance
    if layout.rig is not None:
        # where points are, views decide by themselves; whether that is right, together
        told = of_all_views(np.where(by_hand | ~np.isfinite(uv[..., 0]), np.nan, chance))
        shown = dlt.project(layout.rig.coefs, x)
        others = (chance >= RUN.seen).sum(axis=2, keepdims=True) >= 2
        fill = (chance < RUN.seen) & (told >= RUN.shown) & others & np.isfinite(shown[..., 0])
        # where the others miss what was clicked in a view, they tell nothing of the point in it
        alone = misses_clicks(
            uv, clicked=by_hand, chance=chance, coefs=layout.rig.coefs, sure=RUN.seen,
            gates=np.fmax(LIMITS.right * _usual_spans(uv), RUN.clicks_apart_px),
        )  # fmt: skip
        fill &= ~alone
        told = np.where(alone, chance, told * np.where(fill, 1.0, _views_agree(uv, shown)))
        told = np.where(by_hand, 1.0, told)
        uv = np.where(fill[..., None], shown, uv)
    image_origin = np.where(told >= RUN.measured, ORIGIN_CODE["measured"], ORIGIN_CODE["predicted"])
    image_origin = np.where(fill, ORIGIN_CODE["reprojected"], image_origin)
    lost = ~by_hand & ((chance < RUN.lost) & ~fill | ~np.isfinite(uv[..., 0]))
    image_origin = np.where(by_hand, ORIGIN_CODE["edited"], image_origin)
    image_origin = np.where(lost, ORIGIN_CODE["missing"], image_origin)
    uv = np.where(lost[..., None], np.nan, uv)
    told = np.where(lost, 0.0, told)
    return _as_tracks(layout, task, x, sd, residual, uv, image_origin, told)


def _first_view(
    uv: FloatArray, sd_px: FloatArray, chance: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return positions in the first view in which each point was found at all."""
    found = np.isfinite(uv[..., 0]).any(axis=0)
    view = np.argmax(found, axis=1)
    points = np.arange(uv.shape[1])
    x = np.where((chance[:, points, view] >= RUN.lost)[..., None], uv[:, points, view], np.nan)
    sd = np.repeat(sd_px[:, points, view][..., None], 2, axis=-1)
    return x, np.where(np.isfinite(x), sd, np.nan), np.full(x.shape[:2], np.nan)


def _in_space(
    uv: FloatArray, sd_px: FloatArray, chance: FloatArray, coefs: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return positions in space from the views that saw each point, else from the best two.

    There are none far beyond the body: there lines of sight cross of views that disagree. Where
    views miss them by more than their standard deviations say, those in space are as much larger
    (the ratio of Birge 1932, Phys. Rev. 40, 207).
    """
    rank = np.argsort(np.argsort(-chance, axis=2), axis=2)
    used = ((chance >= RUN.seen) | (rank < 2)) & (chance >= RUN.lost)
    result = dlt.triangulate(coefs, np.where(used[..., None], uv, np.nan), refine=True)
    J = Projection(coefs).jacobian(np.nan_to_num(result.xyz))
    weight = np.where(
        used, 1 / np.maximum(np.nan_to_num(sd_px, nan=_UNKNOWN_PX), RUN.least_sd_px) ** 2, 0.0
    )
    information = np.einsum("npvki,npv,npvkj->npij", J, weight, J)
    variance = np.linalg.inv(information + 1e-12 * np.eye(3)).diagonal(axis1=-2, axis2=-1)
    off = np.linalg.norm(dlt.project(coefs, result.xyz) - uv, axis=-1)
    square = np.nansum(weight * off**2, axis=2) / np.maximum(2 * used.sum(axis=2) - 3, 1)
    variance = variance * np.maximum(square, 1.0)[..., None]
    sure = surest_two(chance)
    astray = beyond_body(result.xyz, sure, sure=RUN.seen, gate=LIMITS.beyond)
    astray &= sure < 1  # who has placed a point has seen to it
    x = np.where(astray[..., None], np.nan, result.xyz)
    sd = np.where(np.isfinite(x), np.sqrt(np.abs(variance)), np.nan)
    return x, sd, np.where(astray, np.nan, result.residual_px)


def _one_place_each(x: FloatArray, chance: FloatArray) -> FloatArray:
    """Return what is left of the chance of points (n, P) that share their place in space."""
    spans = np.array([largest_distance(here) for here in x])
    size = float(np.nanmedian(spans)) if np.isfinite(spans).any() else np.nan
    return shared_places(x, surest_two(chance), LIMITS.beside * size)


def _views_agree(uv: np.ndarray, shown: np.ndarray) -> np.ndarray:
    """Return what is left of the chance of labels (n, P, V) that the other views have elsewhere.

    As for methods that give no probability (:mod:`.quality.measures`).
    """
    far, least = QUALITY.disagree_fall
    off = np.linalg.norm(uv - shown, axis=-1) / _usual_spans(uv)
    return falling(off, (LIMITS.right, far * LIMITS.right, least))


def _usual_spans(uv: FloatArray) -> FloatArray:
    """Return the usual largest distance of points in each view (V,), px."""
    return np.array([usual_span(own) for own in np.moveaxis(uv, 2, 0)])


def _as_tracks(
    layout: Layout,
    task: TrackingRequest,
    x: FloatArray,
    sd: FloatArray,
    residual: FloatArray,
    uv: FloatArray,
    image_origin: IntArray,
    chance: FloatArray,
) -> Tracks:
    """Return the arrays as Tracks, joined to what is gone on from."""
    n = len(x)
    new, begin, kept = blank_tracks(layout, task, n, in_space=layout.rig is not None)
    known_x = np.isfinite(x[..., 0])
    seen = np.isin(image_origin, [ORIGIN_CODE["measured"], ORIGIN_CODE["edited"]])
    enough = seen.sum(axis=2) >= (1 if layout.rig is None else 2)
    origin = np.where(enough, ORIGIN_CODE["measured"], ORIGIN_CODE["predicted"])
    edited = (image_origin == ORIGIN_CODE["edited"]).any(axis=2)
    origin = np.where(edited, ORIGIN_CODE["edited"], origin)
    origin = np.where(known_x, origin, ORIGIN_CODE["missing"])
    at = slice(begin, begin + n)
    new["position"][at, ..., 0] = np.swapaxes(x, 1, 2)
    new["sd"][at, ..., 0] = np.swapaxes(sd, 1, 2)
    new["origin"][at, ..., 0] = origin
    new["confidence"][at, ..., 0] = np.where(known_x, chance.max(axis=2), 0.0)
    new["residual"][at, ..., 0] = np.where(known_x, residual, np.nan)
    new["image_position"][at, ..., 0] = uv.transpose(0, 2, 3, 1)
    new["image_origin"][at, ..., 0] = image_origin.transpose(0, 2, 1)
    new["image_confidence"][at, ..., 0] = chance.transpose(0, 2, 1)
    if layout.rig is not None:
        off = np.linalg.norm(dlt.project(layout.rig.coefs, x) - uv, axis=-1)
        new["image_residual"][at, ..., 0] = np.where(seen, off, np.nan).transpose(0, 2, 1)
    if task.tracks is None:
        new["image_confidence"].attrs[CALIBRATED] = 1
        return new
    return keep_rows(task.tracks, new, kept)
