"""How much a detection looks like a paw, by what was learnt from detections of known truth.

:func:`.detector.endpoint_score` is a plain rule for what the end of a limb
looks like; detections are ranked by it as they are found. Once the clicks have detections,
more is known: the score that the paws of this recording have. Where paws look much like what
is around them that score is low, and a limit that suits all recordings suits none of them.
The logarithm of the odds that a detection is a paw is taken as a sum of five curves, one for
each thing that is measured of it (a logistic regression on linear splines), fitted by
``benchmarks/learn_likeness.py`` to rendered scenes with truth. The rule knows limbs and the
curves know clutter: the geometric mean of both finds more paws than either alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pawnb.arrays import AnyArray, FloatArray
from pawnb.core.paws.offline.detection.colour.detections import ColourDetections, InViews
from pawnb.core.paws.offline.detection.colour.detector import endpoint_score
from pawnb.core.paws.offline.detection.colour_parameters import COLOUR


def curves() -> dict[str, tuple[tuple[float, ...], tuple[float, ...]]]:
    """Return the log-odds by each measure: its knots, and the curve's values there."""
    return {
        "score": COLOUR.curve_score,
        "share": COLOUR.curve_share,
        "ahead": COLOUR.curve_ahead,
        "beside": COLOUR.curve_beside,
        "length": COLOUR.curve_length,
    }


@dataclass(frozen=True)
class AppearanceLikelihood:
    """What tells how much detections look like paws.

    Parameters
    ----------
    limb_direction : sequence of (float, float)
        For each view, see :class:`.detector.DetectorConfig`.
    paw_width_px : ndarray, shape (V,)
        Width of a paw in each view.
    score : float, optional
        Usual score of detections at clicks; without it only the plain rule is used.
    """

    limb_direction: Sequence[tuple[float, float]]
    paw_width_px: FloatArray
    score: float | None = None

    def likeness(self, found: ColourDetections, view: int) -> FloatArray:
        """Return how much each detection of a view looks like a paw, 0 to 1."""
        plain = endpoint_score(found, self.limb_direction[view])
        if self.score is None:
            return plain
        measured = measures(
            found,
            self.limb_direction[view],
            score=self.score,
            paw_width_px=self.paw_width_px[view],
        )
        odds = sum(np.interp(measured[name], *curve) for name, curve in curves().items())
        return np.asarray(np.sqrt(plain / (1.0 + np.exp(-odds))))


def measures(
    found: ColourDetections,
    limb_direction: tuple[float, float],
    *,
    score: float,
    paw_width_px: float,
) -> dict[str, AnyArray]:
    """Return what is measured of detections.

    Parameters
    ----------
    found : ColourDetections
        Detections of one view.
    limb_direction : tuple of float
        Direction in which limbs tend to end.
    score : float
        Usual score at clicks.
    paw_width_px : float
        Width of a paw.

    Returns
    -------
    dict
        ``score``, in that at clicks; ``share`` of mask; ``ahead``, the cosine of the
        detection's direction with ``limb_direction``, and ``beside``, its sine, positive downwards
        from it; ``length`` from the wider centre to the near one, in paw widths.
    """
    step = found.direction.astype(float)
    length = np.hypot(step[:, 0], step[:, 1])
    du, dv = limb_direction
    unit = step / np.maximum(length, 1e-6)[:, None]
    down = 1.0 if du >= 0 else -1.0
    return {
        "score": found.score / score,
        "share": found.coverage.astype(float),
        "ahead": unit @ np.array([du, dv]),
        "beside": down * (unit[:, 1] * du - unit[:, 0] * dv),
        "length": length / paw_width_px,
    }


def score_at_clicks(
    clicks: FloatArray, found: Mapping[int, InViews], likelihood: AppearanceLikelihood
) -> float | None:
    """Return the usual score of the detections of clicks.

    Parameters
    ----------
    clicks : ndarray, shape (frames, P, V, 2)
        Clicks, NaN where there is none, in the order of ``found``.
    found : mapping
        Clicked frame to the detections of every view.
    likelihood : AppearanceLikelihood
        Without a score.

    Returns
    -------
    float or None
        The median; None where no click has a detection.
    """
    scores = []
    for click, by_view in zip(clicks, found.values(), strict=True):
        for p, v in np.argwhere(np.isfinite(click[..., 0])):
            here = by_view[v]
            away = np.linalg.norm(here.uv - click[p, v], axis=1) / likelihood.paw_width_px[v]
            near = away < COLOUR.likelihood_near
            if near.any():
                poor = 1.0 - likelihood.likeness(here.take(near), v)
                best = np.argmin(away[near] + 0.5 * poor)
                scores.append(float(here.score[near][best]))
    return max(float(np.median(scores)), COLOUR.least_score) if scores else None
