"""The stride template: the mean path of a paw in a picture over one stride, and its fit.

Haji Maghsoudi et al. 2019, section 2.3.3 and Eq. 2 (the mean of tracked strides as a
cubic spline) and Eq. 7 to 9 (time shift, frequency and amplitude of the spline that
fit what was tracked). Front and hind paws have a template each; paws of both sides
share it, with u turned so that it grows towards the direction of travel.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize

from pawnb.errors import InputError
from pawnb.io.tables import write_text
from pawnb.schema import ORIGIN_CODE, Tracks
from pawnb.signals import (
    TWO_PASS_CORRECTION,
    butterworth_lowpass,
    find_runs,
    find_turns,
    refine_extremum,
)

DEFAULT_TEMPLATE = Path(__file__).with_name("stride_template.json")
"""The template that comes with pawnb, made by :mod:`pawnb.workflow.stride_template`."""

KINDS = ("front", "hind")
N_POINTS = 50
_FORMAT = "pawnb stride template 1"
_TRIED_FREQUENCIES = np.geomspace(0.5, 2.0, 17)
_TRIED_SHIFTS = 60
_MOST_DIFFERENT_PERIOD = 1.5
_GAP_FRAMES = 5
_JOINED_FRAMES = 5


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

    uv: np.ndarray
    period_s: np.ndarray


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

    uv: np.ndarray
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
            u, v = np.round(own.uv, 5).T.tolist()
            document[kind] = {
                "n_strides": own.n_strides,
                "period_s": round(own.period_s, 5),
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
    cutoff_hz: float = 30.0,
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
        ``"front"`` and ``"hind"`` to their strides. A stride is used where it was tracked
        throughout, and lasted no more than 1.5 times longer or shorter than the median.

    Raises
    ------
    InputError
        If the tracks have no image positions.
    """
    if "image_position" not in tracks:
        raise InputError("these tracks have no image positions; strides are cut in the pictures.")
    fps = float(tracks.attrs["fps"])
    found: dict[str, list[tuple[np.ndarray, float]]] = {kind: [] for kind in KINDS}
    for view in tracks["view"].to_numpy().tolist():
        for point, kind in points.items():
            used = points_by_view is None or point in points_by_view.get(view, ())
            if not used or point not in tracks["keypoint"] or not facing.get(view):
                continue
            own = tracks.sel(view=view, keypoint=point).isel(individual=0)
            uv = own["image_position"].to_numpy() * [facing[view], 1.0]
            uv[own["image_origin"].to_numpy() == ORIGIN_CODE["predicted"]] = np.nan
            smooth = _lowpass(uv, cutoff_hz=cutoff_hz, fps=fps)
            found[kind] += _closed_strides(smooth, n_points, fps)
    return {
        kind: Strides(
            np.array([uv for uv, _ in strides]).reshape(-1, n_points, 2),
            np.array([period for _, period in strides]),
        )
        for kind, strides in found.items()
    }


def _lowpass(uv: np.ndarray, *, cutoff_hz: float, fps: float) -> np.ndarray:
    """Low-pass; a slow recording limits the cut-off."""
    highest = 0.9 * TWO_PASS_CORRECTION * fps / 2.0
    return butterworth_lowpass(
        uv, cutoff_hz=min(cutoff_hz, highest), fs_hz=fps, max_gap=_GAP_FRAMES
    )


def _closed_strides(uv: np.ndarray, n_points: int, fps: float) -> list[tuple[np.ndarray, float]]:
    """Cut one paw's path in one view; return each stride as a closed path, and its period."""
    strides: list[tuple[np.ndarray, float]] = []
    known = uv[np.isfinite(uv[:, 0]), 0]
    if len(known) < 3:
        return strides
    excursion = 0.4 * float(np.subtract(*np.percentile(known, [95, 5])))
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
        strides.append(((closed - _midpoint(closed)) / size, (ends[1] - ends[0]) / fps))
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
    for kind in KINDS:
        uv = np.concatenate([one[kind].uv for one in everything] or [np.empty((0, N_POINTS, 2))])
        period = np.concatenate([one[kind].period_s for one in everything] or [np.empty(0)])
        if len(uv) == 0:
            raise InputError(
                f"the tracks hold no complete stride of a {kind} paw; a template needs some, "
                "in a view in which the direction of travel is known."
            )
        ratio = period / np.median(period)
        usual = (ratio < _MOST_DIFFERENT_PERIOD) & (ratio > 1.0 / _MOST_DIFFERENT_PERIOD)
        mean = uv[usual].mean(axis=0)
        kinds[kind] = KindTemplate(
            mean - _midpoint(mean), float(period[usual].mean()), int(usual.sum())
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
        document = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"{path}: cannot read the stride template ({error.strerror}).") from None
    except (json.JSONDecodeError, UnicodeDecodeError):
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
            for kind in KINDS
        }
    except (KeyError, ValueError, TypeError) as error:
        raise InputError(f"{path}: a damaged stride template ({error}).") from None
    return StrideTemplate(kinds)


@dataclass(frozen=True)
class TemplateFit:
    """A template fitted to a paw in a view: the predicted spline of Algorithm 3.

    Parameters
    ----------
    template : KindTemplate
        The template.
    shift : float
        Time shift τ, frames.
    frequency : float
        Strides per frame; the paper's f is this × the frames of the template.
    amplitude : float
        Range of u in one stride, px; v grows with it.
    offset : ndarray, shape (2,)
        Added to the path, px.
    facing : int
        +1 or -1.
    rms_px : float
        Root mean square of what the fit leaves of u.
    """

    template: KindTemplate
    shift: float
    frequency: float
    amplitude: float
    offset: np.ndarray
    facing: int
    rms_px: float

    def delayed(self, frames: int) -> TemplateFit:
        """Return the same fit for frames counted from ``frames`` earlier."""
        return replace(self, shift=self.shift + frames)

    def predict(self, frame: float | np.ndarray) -> np.ndarray:
        """Return the position at a frame, px, shape (..., 2)."""
        path = self.template.spline((np.asarray(frame) - self.shift) * self.frequency % 1.0)
        return np.asarray(self.offset + self.amplitude * path * [self.facing, 1.0])


def fit_template(
    template: KindTemplate,
    uv: np.ndarray,
    *,
    facing: int,
    fps: float,
    cutoff_hz: float = 30.0,
    least_frames: int = 20,
) -> TemplateFit | None:
    """Fit shift, frequency and amplitude of a template to the last stride of a paw (Eq. 7-9).

    The low-passed u decides; v follows with the same shift, frequency and amplitude. No
    more frames are used than one stride of the template has. For each of a row of
    frequencies, the shift comes from the largest circular correlation with the closed
    template; ``scipy.optimize.minimize`` then brings frequency, amplitude and shift to the
    least sum of squares. The correlation is divided by the length of the two vectors, as
    a part of a stride would otherwise be drawn to where the template varies most.
    Eq. 8 is printed without its norm, and Eq. 9 with one for zeros added to short
    stretches; here the correlation runs over the frames that there are. Where the paper
    leaves the place of the curve to the midpoints, this one goes on from the last five
    frames: in rendered scenes the prediction is then a quarter nearer to the truth.

    Parameters
    ----------
    template : KindTemplate
        Template of this kind of paw.
    uv : ndarray, shape (n, 2)
        Positions up to the last frame before a collision, px; NaN where not tracked.
    facing : int
        +1 or -1: the animal faces right or left.
    fps : float
        Frames per second.
    cutoff_hz : float
        Cut-off of the low-pass filter.
    least_frames : int
        Fewest positions that are enough.

    Returns
    -------
    TemplateFit or None
        Frames are counted from the first of ``uv``. None where there are too few
        positions, or the paw hardly moved.
    """
    least_frames = max(least_frames, 4)
    smooth = _lowpass(uv, cutoff_hz=cutoff_hz, fps=fps)
    length = max(round(template.period_s * fps), least_frames)
    runs = find_runs(np.isfinite(smooth[:, 0]))
    if len(runs) == 0:
        return None
    first, last = runs[-1]
    first = max(first, last - length)
    if last - first < least_frames:
        return None
    t = np.arange(first, last, dtype=float)
    target = facing * smooth[first:last, 0]
    centred = target - _midpoint(target)
    if np.ptp(target) <= 1e-6 * max(1.0, float(np.abs(target).max())):
        return None

    def path(frequency: float, shift: float | np.ndarray) -> np.ndarray:
        """Eq. 7: u of the spline at the frames, shifted; midpoint taken off."""
        phase = (t - np.asarray(shift)[..., None]) * frequency % 1.0
        u = template.spline(phase)[..., 0]
        return u - _midpoint(u.T)[..., None]

    def cost(values: np.ndarray) -> float:
        """Eq. 8, as a sum of squares."""
        frequency, amplitude, shift = values
        return float(((centred - amplitude * path(frequency, shift)) ** 2).sum())

    start = _best_correlation(path, centred, 1.0 / (template.period_s * fps))
    if start is None:
        return None
    f, a, tau = start
    solved = minimize(
        cost,
        np.array(start),
        method="Nelder-Mead",
        options={
            "initial_simplex": np.array(
                [[f, a, tau], [1.05 * f, a, tau], [f, 1.1 * a, tau], [f, a, tau + 1.0]]
            ),
            "xatol": 1e-3,
            "fatol": 1e-3 * len(t),
            "maxiter": 200,
        },
    )
    f, a, tau = (float(x) for x in solved.x)
    if a <= 0 or f <= 0:
        f, a, tau = start
    left = centred - a * path(f, tau)
    model = a * template.spline((t - tau) * f % 1.0) * [facing, 1.0]
    offset = (smooth[first:last] - model)[-_JOINED_FRAMES:].mean(axis=0)
    return TemplateFit(
        template=template,
        shift=tau,
        frequency=f,
        amplitude=a,
        offset=offset,
        facing=facing,
        rms_px=float(np.sqrt((left**2).mean())),
    )


def _best_correlation(path: Any, centred: np.ndarray, usual: float) -> tuple[float, ...] | None:
    """Find frequency, amplitude and shift with the largest circular correlation (Eq. 9)."""
    best, found = 0.0, None
    for frequency in usual * _TRIED_FREQUENCIES:
        shifts = np.arange(_TRIED_SHIFTS) / (_TRIED_SHIFTS * frequency)
        tried = path(frequency, shifts)
        energy = (tried**2).sum(axis=1)
        product = tried @ centred
        likeness = product / np.sqrt(np.where(energy > 0, energy, np.inf))
        k = int(np.argmax(likeness))
        if likeness[k] > best:
            best = float(likeness[k])
            found = (float(frequency), float(product[k] / energy[k]), float(shifts[k]))
    return found


def _midpoint(x: np.ndarray) -> np.ndarray:
    """Return half the sum of the highest and the lowest value along the first axis (Eq. 9)."""
    return np.asarray((x.max(axis=0) + x.min(axis=0)) / 2.0)
