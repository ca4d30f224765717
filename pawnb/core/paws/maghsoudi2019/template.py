"""The stride template: the mean path of a paw in a picture over one stride.

Haji Maghsoudi et al. 2019, section 2.3.3 and Eq. 2: the mean of tracked strides as a
cubic spline. How it is fitted: :mod:`.maghsoudi2019.template_fit`. Front and hind paws
have a template each; paws of both sides share it, with u turned so that it grows
towards the direction of travel.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from pawnb.arrays import BoolArray, FloatArray, Points2D
from pawnb.core.paws.maghsoudi2019.parameters import MAGHSOUDI2019
from pawnb.core.paws.maghsoudi2019.settings import Maghsoudi2019Settings
from pawnb.errors import InputError
from pawnb.files import read_text
from pawnb.io.tables import write_text
from pawnb.schema import ORIGIN_CODE, Tracks
from pawnb.signals import (
    butterworth_lowpass,
    find_turns,
    refine_extremum,
)

DEFAULT_TEMPLATE = Path(__file__).with_name("stride_template.json")
"""The template that comes with pawnb, made by :mod:`pawnb.workflow.stride_template`."""

PAW_KINDS = ("front", "hind")
N_POINTS = 50
"""Layout: phases of a stored stride, one a frame of a stride of 5 Hz at 250 frames per second."""
_FORMAT = "pawnb stride template 1"
_TEMPLATE_DECIMALS = 5
"""Layout: of numbers in the file."""
_MOST_TEMPLATE_BYTES = 2**24
"""Guard: a larger file is no template."""


@dataclass(frozen=True)
class Strides:
    """Strides of the paws of one kind, each as a closed path, before their mean is taken.

    Parameters
    ----------
    uv : ndarray, shape (n, k, 2)
        n strides at k phases: u forwards and v downwards from their midpoints, relative to
        the range of u in that stride.
    period_s : ndarray, shape (n,)
        Duration of each.
    """

    uv: Points2D
    period_s: FloatArray


@dataclass(frozen=True)
class KindTemplate:
    """The mean stride of front or of hind paws.

    Parameters
    ----------
    uv : ndarray, shape (k, 2)
        Mean path at k equal steps of the stride, from one anterior extreme to the next: u
        grows forwards, v downwards; u ranges over about 1.
    period_s : float
        Mean duration of the strides.
    n_strides : int
        Number of strides.
    """

    uv: Points2D
    period_s: float
    n_strides: int

    @cached_property
    def spline(self) -> CubicSpline:
        """Cubic spline through the mean, closed at the ends (Eq. 2); argument in cycles."""
        closed = np.vstack([self.uv, self.uv[:1]])
        return CubicSpline(np.linspace(0.0, 1.0, len(closed)), closed, bc_type="periodic")


@dataclass(frozen=True)
class StrideTemplate:
    """The templates of front and hind paws.

    Parameters
    ----------
    kinds : mapping
        ``"front"`` and ``"hind"`` to their template.
    """

    kinds: Mapping[str, KindTemplate]

    def save(self, path: str | Path) -> Path:
        """Write the template as JSON, whole or not at all."""
        document: dict[str, Any] = {"format": _FORMAT}
        for kind, own in self.kinds.items():
            u, v = np.round(own.uv, _TEMPLATE_DECIMALS).T.tolist()
            document[kind] = {
                "n_strides": own.n_strides,
                "period_s": round(own.period_s, _TEMPLATE_DECIMALS),
                "u": u,
                "v": v,
            }
        return write_text(json.dumps(document, indent=1) + "\n", path)


def cut_strides(
    tracks: Tracks,
    *,
    points: Mapping[str, str],
    facing: Mapping[str, int],
    points_by_view: Mapping[str, Iterable[str]] | None = None,
    cutoff_hz: float = Maghsoudi2019Settings.template_cutoff_hz,
    n_points: int = N_POINTS,
) -> dict[str, Strides]:
    """Cut tracked paws into strides in the pictures, from one anterior extreme to the next.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks with image positions.
    points : mapping
        Point to ``"front"`` or ``"hind"``; others are left out.
    facing : mapping
        +1 or -1 for each view: the animal faces right or left there. Views without are
        left out.
    points_by_view : mapping, optional
        Points to use in each view; default those that it has.
    cutoff_hz : float
        Cut-off of the low-pass filter.
    n_points : int
        Number of phases of a stride.

    Returns
    -------
    dict
        ``"front"`` and ``"hind"`` to their strides. A stride is used where the paw's place was
        known throughout, and lasted about as long as the median.
        A front paw is hidden in every stride: its place is known there from space, and from
        tracks that bridge what is hidden and say how surely (``sd``); what a filter or a
        template alone predicted is not.

    Raises
    ------
    InputError
        If the tracks have no image positions.
    """
    if "image_position" not in tracks:
        raise InputError("these tracks have no image positions; strides are cut in the pictures.")
    fps = float(tracks.attrs["fps"])
    found: dict[str, list[tuple[np.ndarray, float]]] = {kind: [] for kind in PAW_KINDS}
    for view in tracks["view"].to_numpy().tolist():
        for point, kind in points.items():
            used = points_by_view is None or point in points_by_view.get(view, ())
            if not used or point not in tracks["keypoint"] or not facing.get(view):
                continue
            own = tracks.sel(view=view, keypoint=point).isel(individual=0)
            uv = own["image_position"].to_numpy() * [facing[view], 1.0]
            uv[~_is_known(own)] = np.nan
            smooth = lowpass_path(uv, cutoff_hz=cutoff_hz, fps=fps)
            found[kind] += _closed_strides(smooth, n_points, fps)
    return {
        kind: Strides(
            np.array([uv for uv, _ in strides]).reshape(-1, n_points, 2),
            np.array([period for _, period in strides]),
        )
        for kind, strides in found.items()
    }


def _is_known(own: Tracks) -> BoolArray:
    """Tell in which rows (n,) the place of one paw in one view is known, seen there or not."""
    origin = own["image_origin"].to_numpy()
    seen = np.isin(origin, [ORIGIN_CODE[name] for name in ("measured", "resolved", "edited")])
    shown = origin == ORIGIN_CODE["reprojected"]
    if "sd" in own:
        bridged = shown | (origin == ORIGIN_CODE["predicted"])
        return np.asarray(seen | bridged & _is_sure(own))
    return np.asarray(seen | shown & (own["origin"].to_numpy() != ORIGIN_CODE["predicted"]))


def _is_sure(own: Tracks) -> BoolArray:
    """Tell in which rows (n,) the stated uncertainty of one paw is small beside its range."""
    xyz, sd = (own[name].transpose("time", "space").to_numpy() for name in ("position", "sd"))
    there = np.isfinite(xyz).all(axis=1)
    if not there.any():
        return there
    low, high = np.percentile(xyz[there], MAGHSOUDI2019.template_extent, axis=0)
    extent = (high - low).max()
    return np.asarray(np.linalg.norm(sd, axis=1) <= MAGHSOUDI2019.template_surest * extent)


def lowpass_path(uv: Points2D, *, cutoff_hz: float, fps: float) -> FloatArray:
    """Low-pass a path, bridging short gaps; a slow recording limits the cut-off.

    Parameters
    ----------
    uv : ndarray, shape (n, 2)
        Positions, px; NaN where there is none.
    cutoff_hz : float
        Cut-off, Hz; at most a share of the frame rate.
    fps : float
        Frames per second.

    Returns
    -------
    ndarray, shape (n, 2)
        The path, px.
    """
    return butterworth_lowpass(
        uv, cutoff_hz=min(cutoff_hz, MAGHSOUDI2019.cutoff_of_rate * fps), fs_hz=fps,
        max_gap=MAGHSOUDI2019.template_gap,
    )  # fmt: skip


def _closed_strides(uv: Points2D, n_points: int, fps: float) -> list[tuple[np.ndarray, float]]:
    """Cut one paw's path in one view; return each stride as a closed path, and its period."""
    strides: list[tuple[np.ndarray, float]] = []
    known = uv[np.isfinite(uv[:, 0]), 0]
    if len(known) < 3:
        return strides
    low, high = np.percentile(known, MAGHSOUDI2019.template_extent)
    excursion = MAGHSOUDI2019.template_excursion * float(high - low)
    if not excursion > 0:
        return strides
    turns = find_turns(uv[:, 0], min_excursion=excursion)
    tops = [int(i) for i, kind in turns if kind > 0]
    phase = np.arange(n_points) / n_points
    for first, last in pairwise(tops):
        if not np.isfinite(uv[first : last + 1]).all():
            continue
        ends = [refine_extremum(uv[:, 0], i)[0] for i in (first, last)]
        at = ends[0] + (ends[1] - ends[0]) * np.append(phase, 1.0)
        path = np.stack([np.interp(at, np.arange(len(uv)), uv[:, k]) for k in (0, 1)], axis=1)
        # the animal drifts along the belt: take that out, so that the path closes
        closed = path[:-1] - phase[:, None] * (path[-1] - path[0])
        size = np.ptp(closed[:, 0])
        strides.append(((closed - midpoint(closed)) / size, (ends[1] - ends[0]) / fps))
    return strides


def average_strides(strides: Iterable[Mapping[str, Strides]]) -> StrideTemplate:
    """Make a template from the strides of one or more recordings (Eq. 2).

    Parameters
    ----------
    strides : iterable of mapping
        From :func:`cut_strides`, one a recording.

    Returns
    -------
    StrideTemplate
        The means over all strides of each kind.

    Raises
    ------
    InputError
        If there is no stride of a kind.
    """
    everything = list(strides)
    kinds = {}
    for kind in PAW_KINDS:
        uv = np.concatenate([one[kind].uv for one in everything] or [np.empty((0, N_POINTS, 2))])
        period = np.concatenate([one[kind].period_s for one in everything] or [np.empty(0)])
        if len(uv) == 0:
            raise InputError(
                f"the tracks hold no complete stride of a {kind} paw; a template needs some, "
                "in a view in which the direction of travel is known."
            )
        ratio = period / np.median(period)
        odd = MAGHSOUDI2019.template_odd_stride
        usual = (ratio < odd) & (ratio > 1.0 / odd)
        mean = uv[usual].mean(axis=0)
        kinds[kind] = KindTemplate(
            mean - midpoint(mean), float(period[usual].mean()), int(usual.sum())
        )
    return StrideTemplate(kinds)


@lru_cache(maxsize=8)
def load_template(path: str | Path = DEFAULT_TEMPLATE) -> StrideTemplate:
    """Read a template from JSON.

    Parameters
    ----------
    path : str or Path
        A file written by :meth:`StrideTemplate.save`; default the one in the package.

    Returns
    -------
    StrideTemplate
        The template.

    Raises
    ------
    InputError
        If there is no such file, or it is no template.
    """
    path = Path(path)
    try:
        document = json.loads(
            read_text(path, expected="a stride template", most_bytes=_MOST_TEMPLATE_BYTES)
        )
    except (ValueError, RecursionError) as error:
        if isinstance(error, InputError):
            raise
        document = None
    if not isinstance(document, dict) or document.get("format") != _FORMAT:
        raise InputError(
            f"{path}: not a stride template; make one with python -m "
            "pawnb.workflow.stride_template TRIAL -o FILE."
        )
    try:
        kinds = {
            kind: KindTemplate(
                np.array([document[kind]["u"], document[kind]["v"]], dtype=float).T,
                float(document[kind]["period_s"]),
                int(document[kind]["n_strides"]),
            )
            for kind in PAW_KINDS
        }
    except (KeyError, ValueError, TypeError) as error:
        raise InputError(f"{path}: a damaged stride template ({error}).") from None
    return StrideTemplate(kinds)


def midpoint(x: FloatArray) -> FloatArray:
    """Return half the sum of the highest and the lowest value along the first axis (Eq. 9)."""
    return np.asarray((x.max(axis=0) + x.min(axis=0)) / 2.0)
