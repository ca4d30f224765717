"""What two views tell: every joint in space, and how sure it is."""

from __future__ import annotations

from dataclasses import dataclass

from pawnb.arrays import FloatArray


@dataclass(frozen=True, kw_only=True)
class SpaceTrack:
    """Joints of one animal in space in n frames; NaN where it was not found.

    Parameters
    ----------
    body : ndarray, shape (n, 3)
        The place of the body (the origin of its frame), unit of the calibration.
    joints : ndarray, shape (n, n_legs, most segments + 1, 3)
        Body-coxa joint, the joints outwards, tip.
    body_sd, joints_sd : ndarray
        Their standard deviations along x, y, z, given the model.
    seen_uv : ndarray, shape (n, n_legs, most segments + 1, 2)
        Where the second view shows the joints, px of that view.
    body_uv : ndarray, shape (n, 2)
        Where it shows the body.
    residual_px : ndarray, shape (n, n_legs, most segments + 1)
        Distance in the first view of a joint in space from where that view alone places it.
    support : ndarray, shape (n, n_legs)
        Share of the leg's middle line on which the second view is dark as the animal is.
    """

    body: FloatArray
    joints: FloatArray
    body_sd: FloatArray
    joints_sd: FloatArray
    seen_uv: FloatArray
    body_uv: FloatArray
    residual_px: FloatArray
    support: FloatArray
