"""Where a residual curve is a straight line: there only noise is left."""

from __future__ import annotations

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.errors import InputError
from pawnb.gait.residuals.cutoff_scores import NO_CUTOFF

_LIFETIMES = 3.0
_FLOOR = 1000.0 * float(np.finfo(float).eps)


def find_noise_band(cutoffs: FloatArray, residual: FloatArray) -> tuple[int, int] | str:
    """Find the straight part of a residual curve (in shares of the range), or say why not."""
    last = int(0.95 * (len(cutoffs) - 1))
    height = np.log(np.abs(residual[: last + 1] - residual[last]) + _FLOOR)
    rate = float(np.polyfit(cutoffs[: last + 1], height, 1)[0])
    if rate >= 0.0:
        return f"{NO_CUTOFF}the residual does not fall with the cut-off"
    first = int(np.searchsorted(cutoffs, -_LIFETIMES / rate))
    if last - first < 3:
        return (
            f"{NO_CUTOFF}the residual still falls at {cutoffs[last]:.3g} Hz, so no band is "
            "noise alone; film faster, or give the band (band_hz)"
        )
    return first, last


def given_band(cutoffs: FloatArray, band_hz: tuple[float, float]) -> tuple[int, int]:
    """Return first and one past the last point within a band given in Hz."""
    try:
        low, high = (float(end) for end in band_hz)
    except (TypeError, ValueError):
        raise InputError(
            f"band_hz is {band_hz!r}; expected two frequencies in Hz, such as (20, 40)."
        ) from None
    first, last = (int(k) for k in np.searchsorted(cutoffs, [low, high]))
    if not 0.0 <= low < high or last - first < 3:
        raise InputError(
            f"band_hz is {low:g} to {high:g}; expected two frequencies, the lower one first, "
            f"with at least three cut-offs between them (steps of "
            f"{cutoffs[1] - cutoffs[0]:.2g} Hz up to {cutoffs[-1]:.3g} Hz)."
        )
    return first, last
