"""What a timeline shows of tracks: three bytes for each point and frame."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import pandas as pd

from pawnb.errors import InputError, PawnbError
from pawnb.gait.analysis.leg_names import choose_legs
from pawnb.gait.analysis.run import analyse
from pawnb.schema import ORIGIN_CODE, Tracks
from pawnb.trial import Trial

UNKNOWN_LEVEL = 255
"""Confidence of a point that is missing, and standard deviation that is not known."""
FULL = 250
"""Confidence 1, and the largest standard deviation that can be told from larger ones."""
IS_EDITED, SUSPECT, STANCE, IS_PREDICTED = 1, 2, 4, 8
"""Bits of the third byte."""

Stances = Mapping[str, Sequence[tuple[float, float]]]
"""Of each point begin and end of its stances, s."""


def sd_scale(tracks: Tracks) -> float:
    """Return the standard deviation that fills a lane: the 99th percentile of all, or 0.

    Parameters
    ----------
    tracks : xarray.Dataset
        The tracks.

    Returns
    -------
    float
        In the unit of ``position``; 0 where the tracker told none.
    """
    spread = _spread(tracks)
    known = spread[np.isfinite(spread)]
    return float(np.percentile(known, 99)) if len(known) else 0.0


def build_lanes(
    tracks: Tracks,
    points: Sequence[str],
    *,
    suspects: pd.DataFrame | None = None,
    stances: Stances | None = None,
    sd_full: float = 0.0,
    spread: np.ndarray | None = None,
) -> np.ndarray:
    """Return what the lanes of a timeline show.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks of one individual.
    points : sequence of str
        The points that have a lane, in order.
    suspects : pandas.DataFrame, optional
        Doubtful labels: frame, point (or several with commas).
    stances : mapping, optional
        Begin and end of each point's stances, s.
    sd_full : float
        Standard deviation that fills a lane, in the unit of ``position``; see :func:`sd_scale`.
    spread : ndarray, shape (n, P), optional
        Shown in place of the standard deviation of each keypoint of the tracks, in the unit of
        ``sd_full``.

    Returns
    -------
    ndarray of uint8, shape (points, frames, 3)
        Of every frame from the first to the last: confidence (0 to 250, 255 where missing),
        standard deviation (0 to 250, 255 where not known), and the bits of :data:`IS_EDITED`,
        :data:`SUSPECT`, :data:`STANCE` and :data:`IS_PREDICTED`.
    """
    frames = tracks["frame"].to_numpy()
    first, n = int(frames[0]), int(frames[-1] - frames[0]) + 1
    names = [str(name) for name in tracks["keypoint"].to_numpy()]
    chosen = [names.index(point) for point in points]
    lanes = np.zeros((len(chosen), n, 3), dtype=np.uint8)
    lanes[..., :2] = UNKNOWN_LEVEL
    at = frames - first
    spread = _spread(tracks) if spread is None else spread
    confidence, sd = _confidence(tracks)[:, chosen], spread[:, chosen]
    lanes[:, at, 0] = _bytes(confidence, 1.0).T
    lanes[:, at, 1] = _bytes(sd, sd_full).T
    lanes[:, at, 2] = _origin_bits(tracks)[:, chosen].T
    place = {point: k for k, point in enumerate(points)}
    if suspects is not None:
        for frame, named in zip(suspects["frame"], suspects["point"], strict=True):
            for point in {str(named), *str(named).split(", ")} & place.keys():
                if 0 <= int(frame) - first < n:
                    lanes[place[point], int(frame) - first, 2] |= SUSPECT
    times = tracks["time"].to_numpy()
    for point, bars in (stances or {}).items():
        for begin, end in bars if point in place else ():
            lanes[place[point], at[(times >= begin) & (times <= end)], 2] |= STANCE
    return lanes


def find_stances(tracks: Tracks, trial: Trial) -> dict[str, list[tuple[float, float]]]:
    """Return when each foot stands, as the gait diagram shows it.

    Parameters
    ----------
    tracks : xarray.Dataset
        The tracks.
    trial : Trial
        Their trial.

    Returns
    -------
    dict
        Point to begin and end of its stances, s; empty where the gait cannot be analysed.
    """
    from pawnb.figures.gait_diagram import (
        build_gait_diagram_table,  # brings pyplot, needed here only
    )

    # analysing warns of another rate: its times are those of the tracks, as the lanes' are. Not
    # silenced by a filter: those are of all threads, and this runs beside what the person does
    trial = replace(trial, fps=float(tracks.attrs["fps"]))
    try:
        legs = choose_legs(tracks, trial=trial)
        events = analyse(tracks, trial=trial).events
        times = tracks["time"].to_numpy()
        bars = build_gait_diagram_table(events, span_s=(float(times[0]), float(times[-1])))
    except (PawnbError, InputError):
        return {}
    stands = bars[bars["phase"] == "stance"]
    return {
        point: [(float(a), float(b)) for a, b in own[["start_s", "end_s"]].to_numpy()]
        for leg, point in legs.items()
        if len(own := stands[stands["leg"] == leg])
    }


def _bytes(values: np.ndarray, full: float) -> np.ndarray:
    """Return values from 0 to ``full`` as bytes."""
    if full <= 0:
        return np.full(values.shape, UNKNOWN_LEVEL, dtype=np.uint8)
    scaled = np.clip(np.nan_to_num(values) / full, 0, 1) * FULL
    return np.where(np.isfinite(values), np.round(scaled), UNKNOWN_LEVEL).astype(np.uint8)


def _confidence(tracks: Tracks) -> np.ndarray:
    """Return the confidence of each point (n, P): the best of its views; NaN where missing."""
    if "image_confidence" not in tracks:
        there = np.isfinite(tracks["position"].to_numpy()[..., 0]).all(axis=1)
        return np.where(there, tracks["confidence"].to_numpy()[..., 0], np.nan)
    origin = tracks["image_origin"].to_numpy()[..., 0]
    own = (origin != ORIGIN_CODE["missing"]) & (origin != ORIGIN_CODE["reprojected"])
    confidence = np.where(own, tracks["image_confidence"].to_numpy()[..., 0], -1.0).max(axis=1)
    return np.where(own.any(axis=1), confidence, np.nan)


def _spread(tracks: Tracks) -> np.ndarray:
    """Return the standard deviation of each point (n, P), over all directions; NaN if unknown."""
    if "sd" not in tracks:
        return np.full((tracks.sizes["time"], tracks.sizes["keypoint"]), np.nan)
    return np.sqrt((tracks["sd"].to_numpy()[..., 0] ** 2).mean(axis=1))


def _origin_bits(tracks: Tracks) -> np.ndarray:
    """Return (n, P) bits: placed by hand in some view; seen in no view, only predicted."""
    if "image_origin" not in tracks:
        return np.zeros((tracks.sizes["time"], tracks.sizes["keypoint"]), dtype=np.uint8)
    origin = tracks["image_origin"].to_numpy()[..., 0]
    edited = (origin == ORIGIN_CODE["edited"]).any(axis=1)
    seen = np.isin(origin, [ORIGIN_CODE[word] for word in ("measured", "resolved", "edited")])
    predicted = (origin == ORIGIN_CODE["predicted"]).any(axis=1) & ~seen.any(axis=1)
    return (IS_EDITED * edited + IS_PREDICTED * predicted).astype(np.uint8)
