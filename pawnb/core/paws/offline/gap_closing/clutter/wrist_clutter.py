"""What still shows of a limb whose paw is occluded: a wrist says where its paw is.

Towards the end of a stance the wrist of a front paw goes ahead over it and becomes a detection of
its own, about a paw width above. A hind paw then lands beside the paw and covers it; only the
wrist is left, and when the paw lifts off it would be taken for it. But it was seen apart from the
paw while that surely stood, and is followed from there: what has been followed is not the paw.
It says where that is, as far from the wrist as it was. Once it has left the ground it is followed
no longer, for the paw goes up to where its wrist was.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pawnb.arrays import BoolArray, FloatArray, IntArray
from pawnb.core.paws.offline.detection.colour.observations import Observations
from pawnb.core.paws.offline.gap_closing.clutter.wrist_kernels import WristGates, follow
from pawnb.core.paws.offline.gap_closing.parameters import GAP_CLOSING
from pawnb.core.paws.offline.projection import Projection
from pawnb.core.paws.offline.stride.stance import Stance, Substrate


@dataclass(frozen=True)
class WristClutter:
    """Which detections are no paws but wrists.

    Parameters
    ----------
    found : ndarray of bool, shape (n, P, V, C)
        Which detections are the wrist of which point.
    away : ndarray, shape (n, P, V, C, 2)
        How far each is from its paw, px; 0 for all others.
    """

    found: BoolArray
    away: FloatArray

    def observed(
        self, observations: Observations, negative_log_odds: FloatArray
    ) -> tuple[Observations, FloatArray]:
        """Return where every detection says its point is, and what speaks against it.

        Parameters
        ----------
        observations : Observations
            What every view shows.
        negative_log_odds : ndarray, shape (n, P, V, C)
            What speaks against each detection, minus a logarithm of odds.
        """
        return replace(
            observations, at=observations.at - self.away
        ), negative_log_odds + GAP_CLOSING.wrist_clutter_vague * self.found

    def left_out(
        self, choice: IntArray, negative_log_odds: FloatArray
    ) -> tuple[IntArray, FloatArray]:
        """Return a choice (n, P, V) without wrists, -1 there, and what then speaks against them.

        They tell what a paw did, but they are not what is measured of it.
        """
        chosen = np.take_along_axis(self.found, np.maximum(choice, 0)[..., None], axis=-1)
        return np.where(
            chosen[..., 0], -1, choice
        ), negative_log_odds + GAP_CLOSING.no_paw * self.found


def follow_wrist_clutter(
    stances: Sequence[Sequence[Stance]],
    observations: Observations,
    *,
    substrate: Substrate,
    geometry: Projection,
    paw_width_px: FloatArray,
) -> WristClutter:
    """Find wrists: detections that were apart from a paw while it surely stood.

    Parameters
    ----------
    stances : sequence
        When each point surely stands.
    observations : Observations
        What every view shows.
    substrate : Substrate
        What they stand on.
    geometry : Projection
        The views.
    paw_width_px : ndarray, shape (V,)
        Width of a paw in each view.

    Returns
    -------
    WristClutter
        Those of the frames after each stance.
    """
    n, n_points, n_views = observations.at.shape[:3]
    found, away = np.zeros(observations.at.shape[:-1], bool), np.zeros(observations.at.shape)
    # the detections that are there come first
    count = observations.is_there.sum(axis=-1)
    steps = max(2, round(GAP_CLOSING.followed_s * substrate.motion_model.fps))
    for p in range(n_points):
        ends = [one for one in stances[p] if 1 < one.stop < n]
        if not ends:
            continue
        last = np.array([one.stop - 1 for one in ends])
        places = np.stack(
            [substrate.places(one, np.array([t, t - 1])) for one, t in zip(ends, last, strict=True)]
        )
        uv = geometry.project(places)
        for v in range(n_views):
            # copies: of one point in one view the slice would be of another type to compile for
            near, far = (
                np.zeros((n, observations.at.shape[3]), bool),
                np.zeros((n, *observations.at.shape[3:])),
            )
            follow(
                observations.at[:, p, v].copy(),
                count[:, v].copy(),
                last,
                uv[:, :, v].copy(),
                _gates(float(paw_width_px[v])),
                steps,
                near,
                far,
            )
            found[:, p, v], away[:, p, v] = near, far
    return WristClutter(found, away)


def _gates(paw_width_px: float) -> WristGates:
    """Return the distances, px, by which wrists are followed where paws are so wide."""
    return WristGates(
        GAP_CLOSING.wrist_nearest * paw_width_px,
        GAP_CLOSING.wrist_farthest * paw_width_px,
        GAP_CLOSING.wrist_same * paw_width_px,
        GAP_CLOSING.wrist_risen * paw_width_px,
    )
