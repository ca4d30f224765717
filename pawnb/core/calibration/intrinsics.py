"""Focal length and distortion of one view, from a board in several poses.

How many coefficients a lens gets is decided by what they do for shots that they were not fitted
to: too few leave an error everywhere, too many bend the picture where the board never was.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.calibration.corners import FEWEST_CORNERS
from pawnb.errors import CalibrationError

FEWEST_SHOTS = 3
"""Fewer poses of a flat board do not tell focal length from distance."""

_MOST_SHOTS = 60
"""More say nothing new about a lens, and the fit takes time with their square."""

_BETTER = 0.95
"""A model of more coefficients is taken where it lowers the held-out error by 5 % (by hand: on
mouse-4cam-cage each step that shows in the residuals lowers it by 6 to 70 %)."""

_SQUARE = cv2.CALIB_FIX_ASPECT_RATIO | cv2.CALIB_USE_INTRINSIC_GUESS
_CENTRED = cv2.CALIB_FIX_PRINCIPAL_POINT | cv2.CALIB_ZERO_TANGENT_DIST
MODELS: tuple[tuple[str, int, tuple[str, ...]], ...] = (
    (
        "no distortion",
        _SQUARE | _CENTRED | cv2.CALIB_FIX_K1 | cv2.CALIB_FIX_K2 | cv2.CALIB_FIX_K3,
        ("f",),
    ),
    ("k1", _SQUARE | _CENTRED | cv2.CALIB_FIX_K2 | cv2.CALIB_FIX_K3, ("f", "k1")),
    ("k1, k2", _SQUARE | _CENTRED | cv2.CALIB_FIX_K3, ("f", "k1", "k2")),
    (
        "centre, k1, k2, p1, p2, k3",
        _SQUARE,
        ("f", "cx", "cy", "k1", "k2", "p1", "p2", "k3"),
    ),
)
"""Name, flags of OpenCV and free numbers of each model, fewest first."""


@dataclass(frozen=True)
class LensFit:
    """The lens of a view.

    Parameters
    ----------
    lens : ndarray, shape (9,)
        aspect, f, cx, cy, k1, k2, p1, p2, k3.
    model : str
        Which of :data:`MODELS`.
    free : tuple of str
        Its free numbers.
    rms_px : float
        Root mean square error of the corners in this view alone.
    """

    lens: FloatArray
    model: str
    free: tuple[str, ...]
    rms_px: float


def fit_lens(corners: FloatArray, uv: FloatArray, *, size: tuple[int, int], view: str) -> LensFit:
    """Find focal length and distortion of one view.

    Parameters
    ----------
    corners : ndarray, shape (n_corners, 3)
        Corners on the board.
    uv : ndarray, shape (n_shots, n_corners, 2)
        Where they are seen, px; NaN where they are not.
    size : tuple of int
        Width and height of the picture, px.
    view : str
        Its name, for messages.

    Returns
    -------
    LensFit
        The smallest model that does about as well as any on shots left out.

    Raises
    ------
    CalibrationError
        If too few shots show the board, or they determine no lens.
    """
    seen = np.isfinite(uv[..., 0])
    shots = np.flatnonzero(seen.sum(axis=1) >= FEWEST_CORNERS)
    if len(shots) < FEWEST_SHOTS:
        raise CalibrationError(
            f"view {view!r}: the board is found in {len(shots)} of {len(uv)} pictures; at least "
            f"{FEWEST_SHOTS} are needed, each with the board tilted another way."
        )
    if len(shots) > _MOST_SHOTS:
        shots = shots[np.linspace(0, len(shots) - 1, _MOST_SHOTS).astype(int)]
    pairs = [
        (corners[seen[s]].astype(np.float32), uv[s, seen[s]].astype(np.float32)) for s in shots
    ]
    best, best_error = 0, np.inf
    for k, model in enumerate(MODELS):
        error = _held_out_rms(pairs, size, model[1])
        if error < _BETTER * best_error:
            best, best_error = k, error
    if not np.isfinite(best_error):
        raise CalibrationError(
            f"view {view!r}: the {len(shots)} pictures of the board determine no lens; tilt the "
            "board differently in each, and bring it near to every corner of the picture."
        )
    name, flags, free = MODELS[best]
    rms, K, bent = _fit(pairs, size, flags)
    lens = np.r_[1.0, K[0, 0], K[0, 2], K[1, 2], np.ravel(bent)[:5]]
    return LensFit(lens, name, free, rms)


def _fit(
    pairs: list[tuple[np.ndarray, np.ndarray]], size: tuple[int, int], flags: int
) -> tuple[float, np.ndarray, np.ndarray]:
    """Fit one model; NaN where OpenCV finds none."""
    objects, images = [p[0] for p in pairs], [p[1] for p in pairs]
    K = np.array(
        [[max(size), 0.0, (size[0] - 1) / 2], [0.0, max(size), (size[1] - 1) / 2], [0.0, 0.0, 1.0]]
    )
    rms, K, bent, _, _ = cv2.calibrateCamera(objects, images, size, K, None, flags=flags)
    return float(rms), K, bent


def _held_out_rms(
    pairs: list[tuple[np.ndarray, np.ndarray]], size: tuple[int, int], flags: int
) -> float:
    """Return the RMS error of shots that were not fitted: the even by the odd, and the other way.

    Each shot left out is posed by its own corners. Shots that cannot be posed count as infinite.
    """
    if len(pairs) < 2 * FEWEST_SHOTS:
        halves = [(pairs[:i] + pairs[i + 1 :], pairs[i : i + 1]) for i in range(len(pairs))]
    else:
        halves = [(pairs[0::2], pairs[1::2]), (pairs[1::2], pairs[0::2])]
    squares = []
    for fitted, left_out in halves:
        try:
            _, K, bent = _fit(fitted, size, flags)
            for points, image in left_out:
                found, rvec, tvec = cv2.solvePnP(points, image, K, bent)
                shown = cv2.projectPoints(points, rvec, tvec, K, bent)[0][:, 0]
                squares.append(np.where(found, ((shown - image) ** 2).sum(axis=1), np.inf))
        except cv2.error:  # too few or degenerate poses
            return np.inf
    error = np.sqrt(np.mean(np.concatenate(squares)))
    return float(error) if np.isfinite(error) else np.inf
