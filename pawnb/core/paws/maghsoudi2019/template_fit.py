"""Fitting the stride template to a paw that was tracked, to foretell it in a collision.

Haji Maghsoudi et al. 2019, Eq. 7 to 9: time shift by circular correlation, frequency and
amplitude by least squares.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import minimize

from pawnb.arrays import FloatArray, IntArray, Points2D
from pawnb.core.paws.maghsoudi2019.parameters import MAGHSOUDI2019
from pawnb.core.paws.maghsoudi2019.settings import Maghsoudi2019Settings
from pawnb.core.paws.maghsoudi2019.template import KindTemplate, lowpass_path, midpoint
from pawnb.signals import find_runs

_UNKNOWNS = 4
"""Mathematics: shift, frequency, amplitude and offset; fewer positions cannot tell them."""
_SIMPLEX = (1.05, 1.1, 1.0)
"""Numerics: first steps of the search, factors of frequency and amplitude, and frames."""
_CLOSE_ENOUGH = 1e-3
"""Numerics: the search ends where frames and squared px change by less, the latter a frame."""
_MOST_TEMPLATE_STEPS = 200
"""Resource: of the search."""


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
    offset: FloatArray
    facing: int
    rms_px: float

    def delayed(self, frames: int) -> TemplateFit:
        """Return the same fit for frames counted from ``frames`` earlier."""
        return replace(self, shift=self.shift + frames)

    def predict(self, frame: float | IntArray) -> FloatArray:
        """Return the position at a frame, px, shape (..., 2)."""
        path = self.template.spline((np.asarray(frame) - self.shift) * self.frequency % 1.0)
        return np.asarray(self.offset + self.amplitude * path * [self.facing, 1.0])


def fit_template(
    template: KindTemplate,
    uv: Points2D,
    *,
    facing: int,
    fps: float,
    cutoff_hz: float = Maghsoudi2019Settings.template_cutoff_hz,
    least_frames: int = Maghsoudi2019Settings.start_frame_collision,
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
    leaves the place of the curve to the midpoints, this one goes on from the last
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
    least_frames = max(least_frames, _UNKNOWNS)
    smooth = lowpass_path(uv, cutoff_hz=cutoff_hz, fps=fps)
    span = _last_run(smooth, max(round(template.period_s * fps), least_frames), least_frames)
    if span is None:
        return None
    first, last = span
    t = np.arange(first, last, dtype=float)
    target = facing * smooth[first:last, 0]
    centred = target - midpoint(target)
    if np.ptp(target) <= 1e-6 * max(1.0, float(np.abs(target).max())):
        return None

    def path(frequency: float, shift: float | np.ndarray) -> FloatArray:
        """Eq. 7: u of the spline at the frames, shifted; midpoint taken off."""
        phase = (t - np.asarray(shift)[..., None]) * frequency % 1.0
        u = template.spline(phase)[..., 0]
        return u - midpoint(u.T)[..., None]

    def cost(values: FloatArray) -> float:
        """Eq. 8, as a sum of squares."""
        frequency, amplitude, shift = values
        return float(((centred - amplitude * path(frequency, shift)) ** 2).sum())

    start = _best_correlation(path, centred, 1.0 / (template.period_s * fps))
    if start is None:
        return None
    f, a, tau = _least_squares(cost, start, n_frames=len(t))
    left = centred - a * path(f, tau)
    model = a * template.spline((t - tau) * f % 1.0) * [facing, 1.0]
    offset = (smooth[first:last] - model)[-MAGHSOUDI2019.fit_joined :].mean(axis=0)
    return TemplateFit(
        template=template,
        shift=tau,
        frequency=f,
        amplitude=a,
        offset=offset,
        facing=facing,
        rms_px=float(np.sqrt((left**2).mean())),
    )


def _last_run(smooth: FloatArray, length: int, least_frames: int) -> tuple[int, int] | None:
    """Return first frame and end of the last run of positions; None where it is too short."""
    runs = find_runs(np.isfinite(smooth[:, 0]))
    if len(runs) == 0:
        return None
    first, last = runs[-1]
    first = max(first, last - length)
    return None if last - first < least_frames else (first, last)


def _least_squares(cost: Any, start: tuple[float, ...], *, n_frames: int) -> tuple[float, ...]:
    """Return frequency, amplitude and shift of the least cost; the start where they cannot be."""
    f, a, tau = start
    faster, larger, later = _SIMPLEX
    solved = minimize(
        cost,
        np.array(start),
        method="Nelder-Mead",
        options={
            "initial_simplex": np.array(
                [[f, a, tau], [faster * f, a, tau], [f, larger * a, tau], [f, a, tau + later]]
            ),
            "xatol": _CLOSE_ENOUGH,
            "fatol": _CLOSE_ENOUGH * n_frames,
            "maxiter": _MOST_TEMPLATE_STEPS,
        },
    )
    found = tuple(float(x) for x in solved.x)
    return start if found[1] <= 0 or found[0] <= 0 else found


def _best_correlation(path: Any, centred: FloatArray, usual: float) -> tuple[float, ...] | None:
    """Find frequency, amplitude and shift with the largest circular correlation (Eq. 9)."""
    best, found = 0.0, None
    n_shifts = MAGHSOUDI2019.fit_n_shifts
    slowest, fastest = MAGHSOUDI2019.fit_frequencies
    ratios = np.geomspace(slowest, fastest, MAGHSOUDI2019.fit_n_frequencies)
    for frequency in usual * ratios:
        shifts = np.arange(n_shifts) / (n_shifts * frequency)
        tried = path(frequency, shifts)
        energy = (tried**2).sum(axis=1)
        product = tried @ centred
        likeness = product / np.sqrt(np.where(energy > 0, energy, np.inf))
        k = int(np.argmax(likeness))
        if likeness[k] > best:
            best = float(likeness[k])
            found = (float(frequency), float(product[k] / energy[k]), float(shifts[k]))
    return found
