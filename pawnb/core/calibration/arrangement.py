"""Where cameras stand to each other, from boards that two or more of them see at one instant."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from pawnb.arrays import FloatArray, IntArray
from pawnb.core.calibration.corners import FEWEST_CORNERS
from pawnb.errors import CalibrationError

_MOST_CANDIDATES = 40
"""Shared shots that are tried as the relation of two views; more say the same."""

Pose = np.ndarray
"""(4, 4): a board's positions to those in a camera's axes."""


@dataclass(frozen=True)
class Arrangement:
    """Cameras and boards in the axes of the first camera placed.

    Parameters
    ----------
    cameras : ndarray, shape (n_views, 4, 4)
        Positions to those in each camera's axes.
    boards : ndarray, shape (n_shots, 4, 4)
        Positions on the board to those in space; NaN where no view saw it.
    uv : ndarray, shape (n_views, n_shots, n_corners, 2)
        What was seen, corners of a checkerboard counted from the same one in every view.
    first : int
        The camera whose axes they are.
    """

    cameras: FloatArray
    boards: FloatArray
    uv: FloatArray
    first: int


def arrange(
    corners: FloatArray,
    uv: FloatArray,
    lenses: FloatArray,
    *,
    names: tuple[str, ...],
    may_be_turned: bool,
) -> Arrangement:
    """Place cameras one after the other, each by the shots it shares with one already placed.

    Parameters
    ----------
    corners : ndarray, shape (n_corners, 3)
        Corners on the board.
    uv : ndarray, shape (n_views, n_shots, n_corners, 2)
        Where they are seen, px; NaN where they are not.
    lenses : ndarray, shape (n_views, 9)
        aspect, f, cx, cy, k1, k2, p1, p2, k3 of each view.
    names : tuple of str
        Names of the views.
    may_be_turned : bool
        Whether corners may be counted from another one, as on a checkerboard.

    Returns
    -------
    Arrangement
        A start for :func:`pawnb.core.calibration.bundle.adjust`.

    Raises
    ------
    CalibrationError
        If a view shares no shot with the others, or a single one that may be counted two ways.
    """
    uv, orders = uv.copy(), orders_of_corners(corners, may_be_turned=may_be_turned)
    n_views, n_shots = uv.shape[:2]
    poses = np.full((n_views, n_shots, 4, 4), np.nan)
    for v in range(n_views):
        for s in range(n_shots):
            poses[v, s] = pose_of_board(corners, uv[v, s], lenses[v])
    is_seen = np.isfinite(poses[..., 0, 0])
    first = int(is_seen.sum(axis=1).argmax())
    cameras = np.full((n_views, 4, 4), np.nan)
    cameras[first] = np.eye(4)
    placed = [first]
    while len(placed) < n_views:
        rest = [v for v in range(n_views) if v not in placed]
        shared = {(a, b): int((is_seen[a] & is_seen[b]).sum()) for a in placed for b in rest}
        (a, b), n = max(shared.items(), key=lambda item: item[1])
        if not n:
            raise CalibrationError(
                f"view {names[rest[0]]!r} shares no picture of the board with "
                f"{', '.join(names[v] for v in placed)}; show the board to two views at one "
                "instant, and give their pictures in the same order."
            )
        if n == 1 and len(orders) > 1:
            raise CalibrationError(
                f"view {names[b]!r} shares one picture of the board with {names[a]!r} and no more, "
                "and a checkerboard does not tell from which end its corners are counted: show it "
                "to both views at one instant in 3 pictures or more, tilted differently. A ChArUco "
                "board that is described as a checkerboard is found in few pictures: give its "
                "markers."
            )
        relation, order = _relation(corners, uv, poses, (a, b), lenses[b], orders)
        for s, k in order.items():
            uv[b, s] = uv[b, s, orders[k]]
            poses[b, s] = pose_of_board(corners, uv[b, s], lenses[b])
        cameras[b] = relation @ cameras[a]
        placed.append(b)
    boards = _boards(corners, uv, poses, cameras, lenses, orders)
    return Arrangement(
        cameras, boards, _counted_alike(corners, uv, boards, cameras, lenses, orders), first
    )


def place_boards(
    corners: FloatArray, uv: FloatArray, rows: FloatArray, *, may_be_turned: bool
) -> Arrangement:
    """Place boards before cameras that are given.

    Parameters
    ----------
    corners : ndarray, shape (n_corners, 3)
        Corners on the board.
    uv : ndarray, shape (n_views, n_shots, n_corners, 2)
        Where they are seen, px; NaN where they are not.
    rows : ndarray, shape (n_views, 15)
        The cameras (:mod:`pawnb.core.calibration.optics`).
    may_be_turned : bool
        Whether corners may be counted from another one.

    Returns
    -------
    Arrangement
        The cameras as they are, and the boards where the median view wants them.
    """
    lenses = rows[:, :9]
    orders = orders_of_corners(corners, may_be_turned=may_be_turned)
    n_views, n_shots = uv.shape[:2]
    cameras = np.tile(np.eye(4), (n_views, 1, 1))
    cameras[:, :3, :3] = Rotation.from_rotvec(rows[:, 9:12]).as_matrix()
    cameras[:, :3, 3] = rows[:, 12:15]
    poses = np.array(
        [[pose_of_board(corners, uv[v, s], lenses[v]) for s in range(n_shots)]
         for v in range(n_views)]
    )  # fmt: skip
    boards = _boards(corners, uv, poses, cameras, lenses, orders)
    return Arrangement(
        cameras, boards, _counted_alike(corners, uv, boards, cameras, lenses, orders), 0
    )


def orders_of_corners(corners: FloatArray, *, may_be_turned: bool) -> IntArray:
    """Return the orders in which the corners of a board may have been counted.

    Parameters
    ----------
    corners : ndarray, shape (n_corners, 3)
        Corners on the board.
    may_be_turned : bool
        Whether nothing on the board tells one end from the other.

    Returns
    -------
    ndarray of int, shape (n_orders, n_corners)
        As they are first; then turned by 180 degrees and, where as many squares lie along both
        sides, by 90 and 270.
    """
    flat = corners[:, :2] - corners[:, :2].mean(axis=0)
    orders = [np.arange(len(flat))]
    for cosine, sine in ((-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)) if may_be_turned else ():
        turned = flat @ np.array([[cosine, -sine], [sine, cosine]])
        away, order = cKDTree(flat).query(turned)
        if np.allclose(away, 0.0, atol=1e-6 * float(np.abs(flat).max())):
            orders.append(order)
    return np.stack(orders)


def pose_of_board(corners: FloatArray, uv: FloatArray, lens: FloatArray) -> Pose:
    """Return where a board is before a camera; NaN where too few corners are seen.

    Parameters
    ----------
    corners : ndarray, shape (n_corners, 3)
        Corners on the board.
    uv : ndarray, shape (n_corners, 2)
        Where they are seen, px; NaN where they are not.
    lens : ndarray, shape (9,)
        The lens of the view.

    Returns
    -------
    ndarray, shape (4, 4)
        Positions on the board to those in the camera's axes.
    """
    pose = np.full((4, 4), np.nan)
    seen = np.isfinite(uv[:, 0])
    if seen.sum() < FEWEST_CORNERS:
        return pose
    K, bent = _matrix(lens), lens[4:9]
    found, rvec, tvec = cv2.solvePnP(corners[seen], uv[seen], K, bent, flags=cv2.SOLVEPNP_IPPE)
    if found:
        rvec, tvec = cv2.solvePnPRefineLM(corners[seen], uv[seen], K, bent, rvec, tvec)
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = cv2.Rodrigues(rvec)[0], np.ravel(tvec)
    return pose


def as_vectors(poses: FloatArray) -> FloatArray:
    """Return poses (n, 4, 4) as rotation vector and translation (n, 6)."""
    return np.hstack([Rotation.from_matrix(poses[:, :3, :3]).as_rotvec(), poses[:, :3, 3]])


def _relation(
    corners: FloatArray,
    uv: FloatArray,
    poses: FloatArray,
    pair: tuple[int, int],
    lens: FloatArray,
    orders: IntArray,
) -> tuple[Pose, dict[int, int]]:
    """Return how view b stands to view a, and in which order b counts the corners of each shot.

    Each shared shot says it; taken is what fits the median shot best.
    """
    a, b = pair
    shots = np.flatnonzero(np.isfinite(poses[a, :, 0, 0]) & np.isfinite(poses[b, :, 0, 0]))
    tried = shots[np.unique(np.linspace(0, len(shots) - 1, _MOST_CANDIDATES).astype(int))]
    best, best_error, counted = poses[b, shots[0]], np.inf, np.zeros(len(shots), int)
    for s in tried:
        for order in orders:
            relation = pose_of_board(corners, uv[b, s, order], lens) @ np.linalg.inv(poses[a, s])
            errors = np.array(
                [_errors(corners, uv[b, t], relation @ poses[a, t], lens, orders) for t in shots]
            )
            if (error := float(np.median(errors.min(axis=1)))) < best_error:
                best, best_error, counted = relation, error, errors.argmin(axis=1)
    return best, dict(zip(shots.tolist(), counted.tolist(), strict=True))


def _errors(
    corners: FloatArray, uv: FloatArray, pose: Pose, lens: FloatArray, orders: IntArray
) -> list[float]:
    """Return the RMS error in px of a board so posed, counted in each order."""
    rvec = cv2.Rodrigues(pose[:3, :3])[0]
    shown = cv2.projectPoints(corners, rvec, pose[:3, 3], _matrix(lens), lens[4:9])[0][:, 0]
    return [float(np.sqrt(np.nanmean(((shown - uv[order]) ** 2).sum(axis=1)))) for order in orders]


def _boards(
    corners: FloatArray,
    uv: FloatArray,
    poses: FloatArray,
    cameras: FloatArray,
    lenses: FloatArray,
    orders: IntArray,
) -> FloatArray:
    """Return where each board is in space: by the view whose word fits all views best."""
    n_views, n_shots = poses.shape[:2]
    boards = np.full((n_shots, 4, 4), np.nan)
    for s in range(n_shots):
        seeing = [v for v in range(n_views) if np.isfinite(poses[v, s, 0, 0])]
        said = [np.linalg.inv(cameras[v]) @ poses[v, s] for v in seeing]
        costs = [
            np.median(
                [
                    min(_errors(corners, uv[v, s], cameras[v] @ one, lenses[v], orders))
                    for v in seeing
                ]
            )
            for one in said
        ]
        if said:
            boards[s] = said[int(np.argmin(costs))]
    return boards


def _counted_alike(
    corners: FloatArray,
    uv: FloatArray,
    boards: FloatArray,
    cameras: FloatArray,
    lenses: FloatArray,
    orders: IntArray,
) -> FloatArray:
    """Return corners in the order that suits where each board is: two views need not share it."""
    uv = uv.copy()
    is_seen = np.isfinite(uv[..., 0]).sum(axis=-1) >= FEWEST_CORNERS
    for v, s in np.argwhere(is_seen & np.isfinite(boards[:, 0, 0])):
        errors = _errors(corners, uv[v, s], cameras[v] @ boards[s], lenses[v], orders)
        uv[v, s] = uv[v, s, orders[int(np.argmin(errors))]]
    return uv


def _matrix(lens: FloatArray) -> FloatArray:
    """Return the camera matrix of a lens."""
    aspect, f, cx, cy = lens[:4]
    return np.array([[f, 0.0, cx], [0.0, aspect * f, cy], [0.0, 0.0, 1.0]])
