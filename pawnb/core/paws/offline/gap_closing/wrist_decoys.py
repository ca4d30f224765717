"""What still shows of a limb whose paw is hidden: a wrist says where its paw is.

Towards the end of a stance the wrist of a front paw goes ahead over it and becomes a candidate of
its own, about a thickness above. A hind paw then lands beside the paw and covers it; only the
wrist is left, and when the paw lifts off it would be taken for it. But it was seen apart from the
paw while that surely stood, and is followed from there: what has been followed is not the paw.
It says where that is, as far from the wrist as it was. Once it has left the ground it is followed
no longer, for the paw goes up to where its wrist was.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pawnb.core.paws.offline.detection.colour.observations import Sights
from pawnb.core.paws.offline.gap_closing.wrist_kernels import follow
from pawnb.core.paws.offline.projection import Geometry
from pawnb.core.paws.offline.stride.stance import Ground, Stance

_FOLLOWED_S = 0.03
"""Time, s, for which wrists are followed: so long a paw may be covered before it lifts off."""
_VAGUE = 1.0
"""Cost of what a wrist says of its paw, besides how the wrist looks: it turns over the paw."""
_NO_PAW = 30.0
"""What speaks against a wrist being the paw."""


@dataclass(frozen=True)
class Wrists:
    """Which candidates are no paws but wrists.

    Parameters
    ----------
    found : ndarray of bool, shape (n, P, V, C)
        Which candidates are the wrist of which point.
    away : ndarray, shape (n, P, V, C, 2)
        How far each is from its paw, px; 0 for all others.
    """

    found: np.ndarray
    away: np.ndarray

    def told(self, sights: Sights, against: np.ndarray) -> tuple[Sights, np.ndarray]:
        """Return where every candidate says its point is, and what speaks against it.

        Parameters
        ----------
        sights : Sights
            What every view shows.
        against : ndarray, shape (n, P, V, C)
            What speaks against each candidate, minus a logarithm of odds.
        """
        return replace(sights, at=sights.at - self.away), against + _VAGUE * self.found

    def left_out(self, choice: np.ndarray, against: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return a choice (n, P, V) without wrists, -1 there, and what then speaks against them.

        They tell what a paw did, but they are not what is measured of it.
        """
        chosen = np.take_along_axis(self.found, np.maximum(choice, 0)[..., None], axis=-1)
        return np.where(chosen[..., 0], -1, choice), against + _NO_PAW * self.found


def follow_wrists(
    stances: Sequence[Sequence[Stance]],
    sights: Sights,
    *,
    ground: Ground,
    geometry: Geometry,
    thickness_px: np.ndarray,
) -> Wrists:
    """Find wrists: candidates that were apart from a paw while it surely stood.

    Parameters
    ----------
    stances : sequence
        When each point surely stands.
    sights : Sights
        What every view shows.
    ground : Ground
        What they stand on.
    geometry : Geometry
        The views.
    thickness_px : ndarray, shape (V,)
        Thickness of a paw in each view.

    Returns
    -------
    Wrists
        Those of the frames after each stance.
    """
    n, n_points, n_views = sights.at.shape[:3]
    found, away = np.zeros(sights.at.shape[:-1], bool), np.zeros(sights.at.shape)
    # the candidates that are there come first
    count = sights.is_there.sum(axis=-1)
    steps = max(2, round(_FOLLOWED_S * ground.manner.fps))
    for p in range(n_points):
        ends = [one for one in stances[p] if 1 < one.stop < n]
        if not ends:
            continue
        last = np.array([one.stop - 1 for one in ends])
        places = np.stack(
            [ground.places(one, np.array([t, t - 1])) for one, t in zip(ends, last, strict=True)]
        )
        uv = geometry.project(places)
        for v in range(n_views):
            # copies: of one point in one view the slice would be of another type to compile for
            near, far = np.zeros((n, sights.at.shape[3]), bool), np.zeros((n, *sights.at.shape[3:]))
            follow(
                sights.at[:, p, v].copy(), count[:, v].copy(), last, uv[:, :, v].copy(),
                float(thickness_px[v]), steps, near, far,
            )  # fmt: skip
            found[:, p, v], away[:, p, v] = near, far
    return Wrists(found, away)
