"""Paths of the feet taken out of Tracks, each from the space in which it was seen best."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pawnb.arrays import BoolArray, FloatArray
from pawnb.errors import InputError, did_you_mean
from pawnb.schema import Tracks

_USED_VARIABLES = ("position", "confidence", "image_position", "image_confidence")


@dataclass(frozen=True, kw_only=True, eq=False)
class FootPaths:
    """Feet seen in one space: calibrated space, or the picture of one view.

    Parameters
    ----------
    source : str
        ``"position"``, or the name of the view whose image positions these are.
    unit : str
        Unit of the positions.
    legs : tuple of str
        The legs, in the order of the last axis.
    positions : ndarray, shape (n, d, k)
        Positions; NaN where missing.
    angle_deg : ndarray, shape (n, k), optional
        Angle of each leg, degrees, positive forwards, where the animal's pose is known: its
        extremes are AEP and PEP then.
    """

    source: str
    unit: str
    legs: tuple[str, ...]
    positions: FloatArray
    angle_deg: FloatArray | None = None

    @property
    def label(self) -> str:
        """Legs and space in words, for notes."""
        return f"{', '.join(self.legs)} ({self.source})"


def get_foot_paths(
    tracks: Tracks,
    legs: Mapping[str, str],
    *,
    individual: str | None = None,
    min_confidence: float = 0.0,
) -> list[FootPaths]:
    """Take the feet out of Tracks, each from the space in which it was seen best.

    ``position`` is used for every leg that has one in at least half as many frames as
    its best view; without calibration a foot may have image positions only, and then
    the first view is used that saw it at least nine tenths as often as the best.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks.
    legs : mapping
        Names of legs to names of points in the tracks.
    individual : str, optional
        Which animal; default the first.
    min_confidence : float
        Positions with a lower confidence count as missing.

    Returns
    -------
    list of FootPaths
        One for each space in use: ``position`` first, then views in their order. A leg
        that was never seen is in none of them.

    Raises
    ------
    InputError
        If a point or the individual is not in the tracks.
    """
    names = [str(p) for p in tracks["keypoint"].values]
    for leg, point in legs.items():
        if point not in names:
            raise InputError(
                f"leg {leg!r}: the tracks have no point {point!r}{did_you_mean(point, names)}; "
                f"they have {', '.join(names)}."
            )
    who = [str(i) for i in tracks["individual"].values]
    if individual is not None and individual not in who:
        raise InputError(f"no individual {individual!r}; the tracks have {', '.join(who)}.")
    used = [name for name in _USED_VARIABLES if name in tracks]
    one = tracks[used].isel(individual=who.index(individual) if individual else 0)
    spaces: dict[str, tuple[str, list[str], list[np.ndarray]]] = {}
    for leg, point in legs.items():
        found = _best_space(one.sel(keypoint=point), min_confidence)
        if found is not None:
            source, unit, path = found
            spaces.setdefault(source, (unit, [], []))
            spaces[source][1].append(leg)
            spaces[source][2].append(path)
    views = [str(v) for v in tracks["view"].values] if "view" in tracks.coords else []
    return [
        FootPaths(source=s, unit=u, legs=tuple(n), positions=np.stack(p, axis=-1))
        for s, (u, n, p) in sorted(
            spaces.items(), key=lambda item: ["position", *views].index(item[0])
        )
    ]


def _best_space(point: Tracks, least: float) -> tuple[str, str, FloatArray] | None:
    """Choose between a point's position and its image positions; None if never seen."""
    position = point["position"].transpose("time", "space").values.astype(float)
    position = np.where(_sure(point["confidence"].values, least)[:, None], position, np.nan)
    n_position = int(np.isfinite(position).all(axis=1).sum())
    seen: list[tuple[int, str, np.ndarray]] = []
    if "image_position" in point:
        paths = point["image_position"].transpose("view", "time", "image_space").values
        sure = _sure(point["image_confidence"].transpose("view", "time").values, least)
        paths = np.where(sure[..., None], paths.astype(float), np.nan)
        counts = np.isfinite(paths).all(axis=2).sum(axis=1)
        seen = [
            (int(n), str(view), path)
            for n, view, path in zip(counts, point["view"].values, paths, strict=True)
        ]
    most = max((n for n, _, _ in seen), default=0)
    if n_position and 2 * n_position >= most:
        return "position", str(point.attrs.get("units", "px")), position
    # the first of the views that are about as good, so that feet stay together
    return next(((view, "px", path) for n, view, path in seen if n and n >= 0.9 * most), None)


def _sure(confidence: FloatArray, least: float) -> BoolArray:
    """Say where a confidence suffices; one that was not recorded (NaN) is no reason to doubt."""
    return ~(confidence < least)
