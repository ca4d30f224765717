"""The four cameras of the synthetic treadmill and their exact DLT coefficients."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.synthetic.scene import FULL_HEIGHT, FULL_WIDTH, SceneSettings

# name, side of the treadmill (-1: the animal's right when it runs towards +X), degrees that
# the camera stands ahead (+) or behind, elevation, distance and focal length in mm and px
_PLACES = (
    ("cam1", -1, 20.0, 15.0, 500.0, 2430.0),
    ("cam2", -1, -22.0, 14.0, 510.0, 2500.0),
    ("cam3", 1, 21.0, 16.0, 495.0, 2420.0),
    ("cam4", 1, -19.0, 13.5, 505.0, 2470.0),
)
_PLACES_BELOW = (
    ("cam1", -1, 2.0, -78.0, 520.0, 2430.0),
    ("cam2", -1, 18.0, -56.0, 510.0, 2500.0),
    ("cam3", 1, -17.0, -57.0, 515.0, 2420.0),
    ("cam4", 1, 3.0, -70.0, 505.0, 2470.0),
)
_LOOK_AT = np.array([0.0, 0.0, 32.0])
_LOOK_AT_FROM_BELOW = np.array([0.0, 0.0, 8.0])


@dataclass(frozen=True)
class PinholeCamera:
    """A perspective camera without distortion.

    Attributes
    ----------
    name : str
        Name of the view.
    centre : ndarray (3,)
        Where it stands, mm.
    matrix : ndarray (3, 4)
        Projection to homogeneous px of the picture at its scale; the third
        coordinate is the depth in mm.
    side : int
        -1 on the side of -Y, +1 on the side of +Y, 0 below the belt.
    """

    name: str
    centre: FloatArray
    matrix: FloatArray
    side: int

    @property
    def coefs(self) -> FloatArray:
        """The DLT coefficients L1..L11 (11,)."""
        return (self.matrix / self.matrix[2, 3]).ravel()[:11]

    def project(self, xyz: np.ndarray) -> tuple[FloatArray, FloatArray]:
        """Return image positions (..., 2) in px and depths (...) in mm of points (..., 3)."""
        h = xyz @ self.matrix[:, :3].T + self.matrix[:, 3]
        return h[..., :2] / h[..., 2:], h[..., 2]

    def rays(self, u: np.ndarray, v: np.ndarray) -> FloatArray:
        """Return the directions (..., 3) of the rays through image positions, depth 1."""
        inverse = np.linalg.inv(self.matrix[:, :3])
        pixels = np.stack(np.broadcast_arrays(u, v, 1.0), axis=-1)
        return pixels @ inverse.T


def make_cameras(settings: SceneSettings) -> list[PinholeCamera]:
    """Set up the cameras: two on the side of -Y, two on the side of +Y, of which some are used.

    Below a belt of glass the first looks nearly straight up, the others more from the sides.

    At scale 1 the principal point is the centre of the 2048 x 700 picture. A picture
    at scale s is the full picture resampled, so ``u' = (u + 0.5) s - 0.5``.
    """
    rng = np.random.default_rng([settings.seed, 2])
    cameras = []
    places = _PLACES_BELOW if settings.below else _PLACES
    for name, side, ahead, elevation, distance, focal in places:
        turn = settings.camera_jitter_deg * np.clip(rng.standard_normal(4), -2.0, 2.0)
        azimuth = np.radians(ahead + turn[0])
        height = np.radians(elevation + 0.5 * turn[1])
        away = np.array(
            [
                np.sin(azimuth) * np.cos(height),
                side * np.cos(azimuth) * np.cos(height),
                np.sin(height),
            ]
        )
        target = (_LOOK_AT_FROM_BELOW if settings.below else _LOOK_AT) + np.array(
            [turn[2], 0.0, 0.0]
        )
        roll = np.radians(0.25 * turn[3])
        matrix = _projection(target + distance * away, -away, roll, focal)
        s = settings.scale
        resample = np.array([[s, 0, 0.5 * s - 0.5], [0, s, 0.5 * s - 0.5], [0, 0, 1]])
        centre = target + distance * away
        side = 0 if settings.below else side
        cameras.append(PinholeCamera(name=name, centre=centre, matrix=resample @ matrix, side=side))
    return cameras[: settings.n_views]


def _projection(centre: FloatArray, look: FloatArray, roll: float, focal: float) -> FloatArray:
    """Return the projection matrix (3, 4) of the full-scale picture."""
    right = np.cross(look, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    down = np.cross(look, right)
    turned = np.stack(
        [
            np.cos(roll) * right + np.sin(roll) * down,
            -np.sin(roll) * right + np.cos(roll) * down,
            look,
        ]
    )
    intrinsic = np.array(
        [
            [focal, 0.0, (FULL_WIDTH - 1) / 2],
            [0.0, focal, (FULL_HEIGHT - 1) / 2],
            [0.0, 0.0, 1.0],
        ]
    )
    return intrinsic @ np.hstack([turned, -turned @ centre[:, None]])
