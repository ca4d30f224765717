"""Where cameras stand to each other, from boards that two or more of them see at one instant."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from pawnb.arrays import FloatArray
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
        What was seen, corners of a checkerboard counted from the same end in every view.
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
        Whether corners may be counted from the other end, as on a checkerboard.

    Returns
    -------
    Arrangement
        A start for :func:`pawnb.core.calibration.bundle.adjust`.

    Raises
    ------
    CalibrationError
        If a view shares no shot with the others.
    """
    uv = uv.copy()
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
        relation, turned = _relation(corners, uv, poses, (a, b), lenses[b], may_be_turned)
        for s in turned:
            uv[b, s] = uv[b, s, ::-1]
            poses[b, s] = pose_of_board(corners, uv[b, s], lenses[b])
        cameras[b] = relation @ cameras[a]
        placed.append(b)
    return Arrangement(cameras, _boards(corners, uv, poses, cameras, lenses), uv, first)


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
        Whether corners may be counted from the other end.

    Returns
    -------
    Arrangement
        The cameras as they are, and the boards where the median view wants them.
    """
    uv, lenses = uv.copy(), rows[:, :9]
    n_views, n_shots = uv.shape[:2]
    cameras = np.tile(np.eye(4), (n_views, 1, 1))
    cameras[:, :3, :3] = Rotation.from_rotvec(rows[:, 9:12]).as_matrix()
    cameras[:, :3, 3] = rows[:, 12:15]
    poses = np.array(
        [[pose_of_board(corners, uv[v, s], lenses[v]) for s in range(n_shots)]
         for v in range(n_views)]
    )  # fmt: skip
    boards = _boards(corners, uv, poses, cameras, lenses)
    if may_be_turned:
        for v, s in np.argwhere(np.isfinite(poses[..., 0, 0])):
            near, far = _errors(corners, uv[v, s], cameras[v] @ boards[s], lenses[v])
            if far < near:
                uv[v, s] = uv[v, s, ::-1]
    return Arrangement(cameras, boards, uv, 0)


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
    may_be_turned: bool,
) -> tuple[Pose, list[int]]:
    """Return how view b stands to view a, and in which shots b counts from the other end.

    Each shared shot says it; taken is what fits the median shot best.
    """
    a, b = pair
    shots = np.flatnonzero(np.isfinite(poses[a, :, 0, 0]) & np.isfinite(poses[b, :, 0, 0]))
    tried = shots[np.unique(np.linspace(0, len(shots) - 1, _MOST_CANDIDATES).astype(int))]
    best, best_error, turned = poses[b, shots[0]], np.inf, np.zeros(len(shots), bool)
    for s in tried:
        ends = (uv[b, s], uv[b, s, ::-1]) if may_be_turned else (uv[b, s],)
        for seen in ends:
            relation = pose_of_board(corners, seen, lens) @ np.linalg.inv(poses[a, s])
            errors = np.array(
                [_errors(corners, uv[b, t], relation @ poses[a, t], lens) for t in shots]
            )
            own = errors.min(axis=1) if may_be_turned else errors[:, 0]
            if np.median(own) < best_error:
                best, best_error = relation, float(np.median(own))
                turned = may_be_turned & (errors[:, 1] < errors[:, 0])
    return best, [int(s) for s in shots[turned]]


def _errors(corners: FloatArray, uv: FloatArray, pose: Pose, lens: FloatArray) -> list[float]:
    """Return the RMS error in px of a board so posed, counted from either end."""
    rvec = cv2.Rodrigues(pose[:3, :3])[0]
    shown = cv2.projectPoints(corners, rvec, pose[:3, 3], _matrix(lens), lens[4:9])[0][:, 0]
    return [
        float(np.sqrt(np.nanmean(((shown - seen) ** 2).sum(axis=1)))) for seen in (uv, uv[::-1])
    ]


def _boards(
    corners: FloatArray,
    uv: FloatArray,
    poses: FloatArray,
    cameras: FloatArray,
    lenses: FloatArray,
) -> FloatArray:
    """Return where each board is in space: by the view whose word fits all views best."""
    n_views, n_shots = poses.shape[:2]
    boards = np.full((n_shots, 4, 4), np.nan)
    for s in range(n_shots):
        seeing = [v for v in range(n_views) if np.isfinite(poses[v, s, 0, 0])]
        said = [np.linalg.inv(cameras[v]) @ poses[v, s] for v in seeing]
        costs = [
            np.median(
                [min(_errors(corners, uv[v, s], cameras[v] @ one, lenses[v])) for v in seeing]
            )
            for one in said
        ]
        if said:
            boards[s] = said[int(np.argmin(costs))]
    return boards


def _matrix(lens: FloatArray) -> FloatArray:
    """Return the camera matrix of a lens."""
    aspect, f, cx, cy = lens[:4]
    return np.array([[f, 0.0, cx], [0.0, aspect * f, cy], [0.0, 0.0, 1.0]])
