"""A board before cameras that are known: projected by OpenCV, or painted pixel by pixel."""

from __future__ import annotations

import functools

import cv2
import numpy as np

SIZE = (640, 480)
FOCAL = (520.0, 560.0, 600.0)
CENTRE = np.array([319.5, 239.5])
BENT = np.array([-0.2, 0.06, 0.0, 0.0, 0.0])
NAMES = ("left", "middle", "right")


def look_at(eye, target):
    """R and t of a camera with v down, upright with +Z."""
    forward = np.subtract(target, eye) / np.linalg.norm(np.subtract(target, eye))
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    R = np.stack([right, np.cross(forward, right), forward])
    return R, -R @ np.asarray(eye, float)


def true_cameras():
    """Three cameras 0.6 m around the origin: (K, bent, R, t) each."""
    found = []
    for f, angle in zip(FOCAL, (-35.0, 0.0, 35.0), strict=True):
        a = np.radians(angle)
        eye = 600.0 * np.array([np.sin(a), -np.cos(a), 0.35])
        K = np.array([[f, 0.0, CENTRE[0]], [0.0, f, CENTRE[1]], [0.0, 0.0, 1.0]])
        found.append((K, BENT, *look_at(eye, [0.0, 0.0, 0.0])))
    return found


def board_poses(n, corners, seed=0):
    """Rotations and translations of a board that is tilted in its middle, near the origin."""
    rng = np.random.default_rng(seed)
    # it faces the cameras: x to the right, y up, z towards -Y of space
    faces = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    middle = corners.mean(axis=0)
    poses = []
    for _ in range(n):
        R = cv2.Rodrigues(rng.uniform(-0.45, 0.45, 3))[0] @ faces
        poses.append((R, rng.uniform(-60.0, 60.0, 3) - R @ middle))
    return poses


def shown(camera, xyz):
    """Where OpenCV shows points (n, 3)."""
    K, bent, R, t = camera
    return cv2.projectPoints(np.asarray(xyz, float), cv2.Rodrigues(R)[0], t, K, bent)[0][:, 0]


def seen_corners(cameras, poses, corners):
    """Corners (n_views, n_shots, n_corners, 2) without noise."""
    return np.array([[shown(camera, corners @ R.T + T) for R, T in poses] for camera in cameras])


def paint(camera, pose, board, *, per_square=40):
    """Render a view of the board: each pixel looks up what it meets on the board's plane."""
    _, _, R, t = camera
    drawn = draw_board(board, per_square)
    rays, shape = rays_of_pixels(camera[0][0, 0])
    # board (x, y, 0) to the camera's axes
    A, b = R @ pose[0], R @ pose[1] + t
    H = np.linalg.inv(np.column_stack([A[:, 0], A[:, 1], b]))
    plane = np.column_stack([rays, np.ones(len(rays))]) @ H.T
    x, y = plane[:, 0] / plane[:, 2], plane[:, 1] / plane[:, 2]
    scale = per_square / board.square
    column = x * scale - 0.5
    row = (board.rows * board.square - y) * scale - 0.5
    painted = cv2.remap(
        drawn,
        column.reshape(shape).astype(np.float32),
        row.reshape(shape).astype(np.float32),
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=150,
    )
    return cv2.resize(painted, SIZE, interpolation=cv2.INTER_AREA)


@functools.lru_cache
def rays_of_pixels(focal, over=2):
    """Directions of all samples, ``over`` along each side of a pixel, and their shape."""
    u, v = np.meshgrid(
        (np.arange(SIZE[0] * over) + 0.5) / over - 0.5,
        (np.arange(SIZE[1] * over) + 0.5) / over - 0.5,
    )
    K = np.array([[focal, 0.0, CENTRE[0]], [0.0, focal, CENTRE[1]], [0.0, 0.0, 1.0]])
    return straight_rays(K, BENT, np.stack([u.ravel(), v.ravel()], axis=1)), u.shape


def straight_rays(K, bent, uv):
    """Directions (n, 2) at depth one of what is filmed at uv: radial distortion undone in steps."""
    filmed = (uv - K[:2, 2]) / [K[0, 0], K[1, 1]]
    rays = filmed.copy()
    for _ in range(12):  # the error shrinks at least fivefold each time
        r2 = (rays**2).sum(axis=1, keepdims=True)
        rays = filmed / (1.0 + bent[0] * r2 + bent[1] * r2**2)
    return rays


def draw_board(board, per_square):
    """The board from the front, its first square black."""
    size = (board.columns * per_square, board.rows * per_square)
    if board.marker is not None:
        dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_1000)
        return cv2.aruco.CharucoBoard(
            (board.columns, board.rows), board.square, board.marker, dictionary
        ).generateImage(size, marginSize=0)
    row, column = np.indices((board.rows, board.columns))
    squares = np.where((row + column) % 2 == 0, 0, 255).astype(np.uint8)
    return np.kron(squares, np.ones((per_square, per_square), np.uint8))
