"""What one calibrated view says of another: a point lies on the epipolar line of what is seen."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from pawnb.core.paws.offline.association.estimates import modes
from pawnb.core.paws.offline.scene.stack import BodyStack
from pawnb.core.rig import Rig
from pawnb.core.sightlines import find_epipolar_line

_MODES = 3
_FLOOR = 0.05
"""What a place far from every line keeps: the other view may be wrong."""
_SD_RADII = 0.5
"""Standard deviation of a line, in radii: two clicks of one paw in two views are so far apart."""


def epipolar_support(
    posteriors: Sequence[Mapping[int, np.ndarray]],
    stacks: Sequence[BodyStack],
    *,
    names: Sequence[str],
    rig: Rig,
    radius: float,
    sizes: Sequence[tuple[int, int]],
) -> list[dict[int, np.ndarray]]:
    """Return how far every place of each view is supported by the other views.

    Parameters
    ----------
    posteriors : sequence of mapping
        For each view: point to the probability of every place (n, h, w).
    stacks : sequence of BodyStack
        The views.
    names : sequence of str
        Their names in the rig.
    rig : Rig
        The calibration.
    radius : float
        About half a paw, in places.
    sizes : sequence of (int, int)
        Width and height of each view, px.

    Returns
    -------
    list of dict
        For each view: point to factors (n, h, w) of at most 1.
    """
    coefs = rig.subset(names).coefs
    support: list[dict[int, np.ndarray]] = []
    for a, stack in enumerate(stacks):
        n, h, w = stack.shape
        support.append({point: np.ones((n, h, w), np.float32) for point in posteriors[a]})
        y, x = np.mgrid[:h, :w]
        for b, other in enumerate(stacks):
            if a == b:
                continue
            for point in sorted(set(posteriors[a]) & set(posteriors[b])):
                factor = support[a][point]
                for t in range(n):
                    seen = modes(posteriors[b][point][t], radius, _MODES)
                    on_line = np.full((h, w), _FLOOR + 1 - sum(p for _, p in seen))
                    for place, probability in seen:
                        uv = other.picture_of(place, t)
                        ends = find_epipolar_line(coefs[:, b], uv, coefs[:, a], size=sizes[a])
                        if not np.isfinite(ends).all():
                            continue
                        p, q = stack.grid_of(ends, t)
                        along = (q - p) / (np.linalg.norm(q - p) + 1e-12)
                        away = (x - p[0]) * along[1] - (y - p[1]) * along[0]
                        sd = _SD_RADII * radius
                        on_line += probability * np.exp(-(away**2) / (2 * sd**2))
                    factor[t] *= np.minimum(on_line, 1.0)
    return support
