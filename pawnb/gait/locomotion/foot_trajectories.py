"""Paths of the feet taken out of Tracks, each from the space in which it was seen best."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pawnb.arrays import BoolArray, FloatArray
from pawnb.errors import InputError, did_you_mean
from pawnb.schema import Tracks

_PLACES_EVERYWHERE = ("deeplabcut", "lightningpose", "ensemblekalmansmoother")
"""Programs that give a place in every frame, as they are called in small letters without blanks:
movement writes LightningPose, or DeepLabCut/LightningPose where it cannot tell them apart."""
_SURE_ENOUGH = 0.6
"""Confidence from which a place of these programs is one."""
_OWN_SENSE = ("pawnb", "sleap")
"""Programs whose confidence has another scale: theirs leave out themselves what is too low."""
_LARGE_ERROR_PX = 5.0
"""Reprojection error, the mean over the views, from which on Anipose itself gives points less
weight (its default ``reproj_error_threshold``)."""
_FEWEST_VIEWS = 2
_TELLING_SHARE = 0.05
"""Share of a leg's places from which on it is said that they are doubtful. Set by hand."""
_LEAST_PLACEHOLDERS = 3
"""Frames in which a foot is exactly in the corner of the picture; no foot that moves is."""
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


def least_confidence(tracks: Tracks, given: float | None) -> float:
    """Return the confidence below which a position counts as missing.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks.
    given : float or None
        What the settings say; None for what suits the program that made the tracks.

    Returns
    -------
    float
        The confidence, from 0 to 1.
    """
    if given is not None:
        return given
    program = _program(tracks)
    return _SURE_ENOUGH if any(name in program for name in _PLACES_EVERYWHERE) else 0.0


def _program(tracks: Tracks) -> str:
    """Return what made the tracks, in small letters without blanks."""
    return re.sub(r"\s", "", str(tracks.attrs.get("source_software"))).lower()


def notes_on_confidence(tracks: Tracks, least: float) -> list[str]:
    """Say that positions of low confidence count as missing, or that none is known.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks.
    least : float
        The confidence below which a position counts as missing.

    Returns
    -------
    list of str
        One note; none where no position is left out.
    """
    if least <= 0.0:
        return []
    told = [tracks[name] for name in ("confidence", "image_confidence") if name in tracks]
    if any(bool((one > 0.0).any()) for one in told):
        return [f"positions with a confidence below {least:g} count as missing."]
    return ["the tracks tell no confidence, so no position is left out for a low one."]


def notes_on_doubtful_places(
    tracks: Tracks, legs: Mapping[str, str], *, individual: str, least: float
) -> list[str]:
    """Say which feet have many places that another program doubts, and that count all the same.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks; ``residual`` and ``n_views`` are Anipose's.
    legs : mapping
        Names of legs to names of points.
    individual : str
        Which animal.
    least : float
        The confidence below which a position counts as missing.

    Returns
    -------
    list of str
        A note for each reason: a low confidence, a large reprojection error, too few views.
    """
    if "position" not in tracks or _program(tracks).startswith(_OWN_SENSE):
        return []
    one = tracks.sel(individual=individual)
    known = one["position"].notnull().all("space")
    doubts = {}
    if least <= 0.0:
        doubts[
            f"a confidence below {_SURE_ENOUGH:g}; min_confidence={_SURE_ENOUGH:g} (--set) leaves "
            "them out"
        ] = one["confidence"] < _SURE_ENOUGH
    if "n_views" in one:
        doubts["been seen by fewer than two cameras, and were filled in"] = ~(
            one["n_views"] >= _FEWEST_VIEWS
        )
        doubts[
            f"a reprojection error above {_LARGE_ERROR_PX:g} px; look at them, or triangulate anew"
        ] = one["residual"] > _LARGE_ERROR_PX
    notes = []
    for what, doubtful in doubts.items():
        share = (doubtful & known).sum("time") / np.maximum(1, known.sum("time"))
        found = [
            f"{leg} {100 * float(share.sel(keypoint=point)):.0f} %"
            for leg, point in legs.items()
            if float(share.sel(keypoint=point)) >= _TELLING_SHARE
        ]
        if found:
            notes.append(f"{', '.join(found)} of the places count though they have {what}.")
    return notes


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


def notes_on_views(tracks: Tracks, spaces: Sequence[FootPaths]) -> list[str]:
    """Say which views the gait is not taken from, though they were tracked.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks.
    spaces : sequence of FootPaths
        What :func:`get_foot_paths` took out of them.

    Returns
    -------
    list of str
        One note; none where a leg has its place in space, or every view is used.
    """
    used = [space.source for space in spaces]
    views = [str(view) for view in tracks["view"].to_numpy()] if "view" in tracks.coords else []
    unused = [
        view
        for view in views
        if view not in used and bool(tracks["image_position"].sel(view=view).notnull().any())
    ]
    if not used or "position" in used or not unused:
        return []
    return [
        f"the gait is that seen in {', '.join(used)} alone; {', '.join(unused)} "
        f"{'is' if len(unused) == 1 else 'are'} not used, as the views are not calibrated: name "
        "their calibration in a trial.toml to analyse places in space."
    ]


def notes_on_placeholders(spaces: Sequence[FootPaths]) -> list[str]:
    """Say which feet lie for some frames where programs put points that they did not find.

    Parameters
    ----------
    spaces : sequence of FootPaths
        The feet.

    Returns
    -------
    list of str
        A note for each of those places, 0 and -1 on every axis.
    """
    notes = []
    for value in (0.0, -1.0):
        found = []
        for space in spaces:
            there = (space.positions == value).all(axis=1).sum(axis=0)
            found += [
                f"{leg} in {n} frames"
                for leg, n in zip(space.legs, there, strict=True)
                if n >= _LEAST_PLACEHOLDERS
            ]
        if found:
            place = ", ".join([f"{value:g}"] * spaces[0].positions.shape[1])
            notes.append(
                f"exactly at ({place}): {'; '.join(found)}. So some programs write points that "
                "they did not find, and events are wrong then: leave these cells empty, which "
                "counts as missing."
            )
    return notes


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
