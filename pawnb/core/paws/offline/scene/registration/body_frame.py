"""The body's frame: where the animal is in every picture, and which way it is turned."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import cv2
import numpy as np

from pawnb.arrays import ByteArray, Float32Array, FloatArray
from pawnb.core.paws.offline.parameters import SceneParameters
from pawnb.core.paws.offline.scene.parameters import CAMERA
from pawnb.core.paws.offline.scene.registration.camera_motion import find_camera_motion
from pawnb.core.paws.offline.scene.registration.following import follow_animal
from pawnb.core.paws.offline.scene.registration.foreground import Blob, find_blob


@dataclass(frozen=True)
class ViewBodyFrame:
    """Where the animal is.

    Parameters
    ----------
    centre : ndarray, shape (n, 2)
        A place that goes with the body, px of the view.
    angle : ndarray, shape (n,)
        How far the body is turned, rad.
    kind : {"stays", "follows", "travels", "turns"}
        Whether the frame stays where it is, goes with the animal (by what moves, or by its blob),
        or turns with it, too.
    pans : bool
        Whether the camera moves.
    """

    centre: FloatArray
    angle: FloatArray
    kind: str
    pans: bool

    def rotations(self) -> FloatArray:
        """Return the rotation (n, 2, 2) from the view to the body."""
        c, s = np.cos(self.angle), np.sin(self.angle)
        return np.stack([np.stack([c, s], -1), np.stack([-s, c], -1)], -2)


def find_body_frame(
    pictures: ByteArray,
    clicks: Mapping[int, FloatArray],
    extent: float,
    *,
    scale: float,
    parameters: SceneParameters,
) -> ViewBodyFrame:
    """Find the body's frame from small pictures of the whole view.

    Four frames are tried: one that stays, one that follows the median motion of features that
    move, one that follows the centroid of the foreground blob, and one that turns with its longer
    axis as well. The one in which the foreground about the clicks looks most like that of the
    clicked frames is taken; the simpler one where there is little between them, but the second
    where the animal gets away from its clicks.

    Parameters
    ----------
    pictures : ndarray of uint8, shape (n, H, W)
        Small grey pictures.
    clicks : mapping
        Row to clicked places (k, 2), px of the small pictures.
    extent : float
        Size of the animal in them, px.
    scale : float
        Px of a small picture in one of the view.
    parameters : SceneParameters
        The stage's parameters.

    Returns
    -------
    ViewBodyFrame
        In px of the view.
    """
    n = len(pictures)
    camera = find_camera_motion(pictures)
    telling = _of_like_points(clicks)
    blob = find_blob(pictures, camera, clicks=telling, extent=extent)
    way = follow_animal(pictures, camera, clicks=telling, extent=extent)
    tried = {
        "stays": (np.zeros((n, 2)), np.zeros(n)), "follows": (way, np.zeros(n)), **_moving(blob),
    }  # fmt: skip
    alike = {
        kind: _alikeness(blob.difference, clicks, extent, *frame) for kind, frame in tried.items()
    }
    away = float(np.ptp(way, axis=0).max()) > CAMERA.body_away * extent
    best = "follows" if away and alike["follows"] > alike["stays"] - CAMERA.body_alike else "stays"
    for kind in ("travels", "turns"):
        if kind in alike and alike[kind] > alike[best] + parameters.better:
            best = kind
    centre, angle = tried[best]
    if best != "stays":
        centre, angle = _held(centre, angle, CAMERA.body_step * extent)
    return ViewBodyFrame(centre / scale, angle, best, camera.pans)


def _of_like_points(clicks: Mapping[int, FloatArray]) -> dict[int, FloatArray]:
    """Return the clicks of frames whose middles are about the same place of the body.

    Those in which nearly all points were clicked; where the first has fewer, only that one.
    """
    most, first = max(map(len, clicks.values())), min(clicks)
    fewest = max(2.0, CAMERA.body_points * most)
    telling = {row: uv for row, uv in clicks.items() if len(uv) >= fewest}
    return telling if first in telling else {first: clicks[first]}


def _moving(blob: Blob) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return the frames that a blob gives: its centre, and its direction as well."""
    found = np.isfinite(blob.centre[:, 0])
    rows = np.arange(len(found))
    if found.mean() < CAMERA.body_found:
        return {}
    filled = [np.interp(rows, rows[found], blob.centre[found, d]) for d in (0, 1)]
    centre = np.stack([_smooth(one, CAMERA.body_centre_sd) for one in filled], axis=1)
    frames = {"travels": (centre, np.zeros(len(rows)))}
    clear = found & (blob.elongation > CAMERA.body_elongation)
    if clear.mean() > CAMERA.body_clear:
        angle = np.unwrap(2 * blob.angle[clear]) / 2
        frames["turns"] = (
            centre,
            _smooth(np.interp(rows, rows[clear], angle), CAMERA.body_angle_sd),
        )
    return frames


def _smooth(values: FloatArray, sd_frames: float) -> FloatArray:
    """Return values smoothed over time."""
    row = np.ascontiguousarray(values, float)[None]
    return cv2.GaussianBlur(row, (0, 0), sd_frames, borderType=cv2.BORDER_REPLICATE)[0]


def _held(centre: FloatArray, angle: FloatArray, step: float) -> tuple[FloatArray, FloatArray]:
    """Return a frame that moves in steps."""
    centre, angle = centre.copy(), angle.copy()
    for t in range(1, len(angle)):
        stays = np.linalg.norm(centre[t] - centre[t - 1]) <= step
        if stays and abs(angle[t] - angle[t - 1]) <= CAMERA.body_turn_rad:
            centre[t], angle[t] = centre[t - 1], angle[t - 1]
    return centre, angle


def _alikeness(
    difference: Float32Array,
    clicks: Mapping[int, FloatArray],
    extent: float,
    centre: FloatArray,
    angle: FloatArray,
) -> float:
    """Return the mean correlation of the foreground with that of the clicked frames."""
    n = len(difference)
    y, x = np.mgrid[: CAMERA.body_side_px, : CAMERA.body_side_px] - CAMERA.body_side_px / 2
    weights = np.exp(-(x**2 + y**2) / (2 * (CAMERA.body_side_px / CAMERA.body_window) ** 2))
    weights /= weights.sum()
    compared = np.unique(np.linspace(0, n - 1, min(n, CAMERA.body_compared)).astype(int))
    rotation = ViewBodyFrame(centre, angle, "", pans=False).rotations()

    def patch(t: int, offset: FloatArray) -> FloatArray:
        A = rotation[t] * (CAMERA.body_side_px / (CAMERA.body_shown * extent))
        there = centre[t] + rotation[t].T @ offset
        to_patch = np.hstack([A, (CAMERA.body_side_px / 2 - A @ there)[:, None]])
        found = cv2.warpAffine(
            difference[t],
            to_patch,
            (CAMERA.body_side_px, CAMERA.body_side_px),
            borderMode=cv2.BORDER_REPLICATE,
        )
        found = found - (weights * found).sum()
        return found / (np.sqrt((weights * found**2).sum()) + 1e-6)

    alike = []
    for row, uv in clicks.items():
        offset = rotation[row] @ (uv.mean(axis=0) - centre[row])
        reference = weights * patch(row, offset)
        alike += [(reference * patch(t, offset)).sum() for t in compared if abs(t - row) > 2]
    return float(np.mean(alike)) if alike else 0.0
