"""The pose in the first view, corrected by what the second tells.

One view shows where a leg's line lies, but hardly where along a straight leg its joints are. Once
the joints are known in space, each segment's projected length is too. Angles and lengths of every
leg are fitted to where the joints in space appear in the first view; angles stay near those that
the first view gave, because a short segment's direction is no better known in space.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core import dlt
from pawnb.core.pose.animal import Leg, StickAnimal
from pawnb.core.pose.poses import joint_positions
from pawnb.core.pose.space.parameters import IN_SPACE
from pawnb.core.pose.space.settings import SpaceSettings
from pawnb.core.pose.space.track import SpaceTrack
from pawnb.core.pose.track_result import PoseTrack
from pawnb.schema import ORIGIN_CODE

_FIRST_VIEW_STEPS = 6
"""Numerics: steps of Gauss-Newton from places that are nearly right."""


def corrected_first_view(
    animal: StickAnimal,
    track: PoseTrack,
    space: SpaceTrack,
    *,
    coefs: FloatArray,
    settings: SpaceSettings,
) -> PoseTrack:
    """Return poses of the first view that agree with the joints in space.

    Parameters
    ----------
    animal : StickAnimal
        The animal.
    track : PoseTrack
        Poses of the first view alone.
    space : SpaceTrack
        Joints in space, row for row.
    coefs : ndarray, shape (11,)
        DLT coefficients of the first view.
    settings : SpaceSettings
        ``angle_sd_deg``, ``across_share`` and ``least_support``: a leg of which the second view
        shows less stays as it is, and so does a pose that a person corrected.

    Returns
    -------
    PoseTrack
        Body and heading as before. Standard deviations are those of the first view alone, too
        wide where the second has helped.
    """
    poses = track.poses
    span = animal.span * float(np.nanmedian(poses.scale))
    seen = dlt.project(coefs, space.joints)[..., 0, :]
    roots = joint_positions(animal, poses)[:, :, 0]
    angles, lengths = poses.angles_deg.copy(), poses.lengths_px.copy()
    free_from = segment_from = 0
    for i, leg in enumerate(animal.legs):
        n, n_free = len(leg.segments), int(sum(leg.free))
        free, segments = slice(free_from, free_from + n_free), slice(segment_from, segment_from + n)
        target = seen[:, i, : n + 1]
        rows = np.isfinite(target).all(axis=(1, 2)) & np.isfinite(poses.xy[:, 0])
        rows &= np.nan_to_num(space.support[:, i]) >= settings.least_support
        rows &= track.origin[:, i] != ORIGIN_CODE["edited"]
        if rows.any():
            fit = _LegFit(
                leg, poses.heading_deg[rows], roots[rows, i], target[rows], span, settings
            )
            angles[rows, free], lengths[rows, segments] = fit.run(poses.angles_deg[rows, free])
        free_from, segment_from = free_from + n_free, segment_from + n
    fitted = dataclasses.replace(poses, angles_deg=angles, lengths_px=lengths)
    return dataclasses.replace(track, poses=fitted)


class _LegFit:
    """Gauss-Newton fit of one leg in many frames at once."""

    def __init__(
        self,
        leg: Leg,
        heading_deg: FloatArray,
        root: FloatArray,
        target: FloatArray,
        span_px: float,
        settings: SpaceSettings,
    ) -> None:
        self.leg, self.root, self.target = leg, root, target
        self.heading = np.radians(heading_deg)
        self.free = np.flatnonzero(leg.free)
        self.place_sd = settings.across_share * span_px
        self.length_sd = IN_SPACE.projected_length_sd * span_px
        self.angle_sd = np.radians(settings.angle_sd_deg)

    def run(self, angles_deg: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the free angles (n, free), degrees, and the lengths (n, segments), px."""
        before = np.radians(angles_deg)
        steps = np.diff(self.target, axis=1)
        known = np.hypot(steps[..., 0], steps[..., 1])
        angles, lengths = before.copy(), known.copy()
        n_free, n = len(self.free), known.shape[1]
        prior = np.r_[np.full(n_free, self.angle_sd), np.full(n, self.length_sd)] ** -2.0
        for _ in range(_FIRST_VIEW_STEPS):
            places, jacobian = self._places(angles, lengths)
            off = (self.target[:, 1:] - places).reshape(len(places), -1)
            moved = np.concatenate([before - angles, known - lengths], axis=1)
            # (n, 2 n_segments, unknowns)
            matrix = np.einsum("npi,npj->nij", jacobian, jacobian) / self.place_sd**2
            right = np.einsum("npi,np->ni", jacobian, off) / self.place_sd**2 + prior * moved
            step = np.linalg.solve(matrix + np.diag(prior), right[..., None])[..., 0]
            angles, lengths = angles + step[:, :n_free], lengths + step[:, n_free:]
        return np.degrees(angles), np.maximum(lengths, 0.0)

    def _places(self, angles: FloatArray, lengths: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return joints 1 to the tip (n, segments, 2), and their derivative by the unknowns."""
        side, n = self.leg.side, lengths.shape[1]
        every = np.tile(np.radians(self.leg.natural_deg), (len(angles), 1))
        every[:, self.free] = angles
        turn = self.heading[:, None] + side * (np.pi / 2 - np.cumsum(every, axis=1))
        along = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
        aside = np.stack([-np.sin(turn), np.cos(turn)], axis=-1)
        places = self.root[:, None] + np.cumsum(lengths[..., None] * along, axis=1)
        inner = np.tri(n, dtype=bool)  # joint m + 1 moves with segments up to m
        by_length = np.where(inner[None, :, None], np.moveaxis(along, 1, 2)[:, None], 0.0)
        turned = np.cumsum(-side * lengths[..., None] * aside, axis=1)
        shift = np.concatenate([np.zeros_like(turned[:, :1]), turned[:, :-1]], axis=1)
        # turning joint j moves what lies beyond it
        by_angle = np.where(
            inner[None, :, :, None], turned[:, :, None] - shift[:, None], 0.0
        )  # (n, joint, angle, 2)
        by_angle = np.moveaxis(by_angle, 2, 3)[..., self.free]
        jacobian = np.concatenate([by_angle, by_length], axis=-1)
        return places, jacobian.reshape(len(angles), 2 * n, -1)
