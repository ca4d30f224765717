"""What a place looks like at several scales: brightness, edges, texture, surroundings, colour."""

from __future__ import annotations

import cv2
import numpy as np

_RINGS_PX = (10.0, 20.0, 35.0)
_DIRECTIONS = 8


def feature_maps(grey: np.ndarray, colour: np.ndarray | None, spacing: int) -> np.ndarray:
    """Return features of every place of the grid.

    Gaussian derivatives at four scales, their differences, the structure tensor (Bigün &
    Granlund 1987), brightness (and colour) on three rings about the place, direction by
    direction, so that what lies ahead and what lies behind are told apart.

    Parameters
    ----------
    grey : ndarray of uint8, shape (H, W)
        A picture at the working scale.
    colour : ndarray of uint8, shape (H, W, 2), or None
        Its colour channels.
    spacing : int
        Px between places.

    Returns
    -------
    ndarray of float32, shape (h, w, F)
        F is 47 without colour and 59 with it.
    """
    h, w = grey.shape[0] // spacing, grey.shape[1] // spacing
    offset = spacing // 2

    def on_grid(x: np.ndarray) -> np.ndarray:
        return x[offset::spacing, offset::spacing][:h, :w]

    fine = cv2.GaussianBlur(grey.astype(np.float32) / 255, (0, 0), 1.5)
    gx, gy = cv2.Sobel(fine, cv2.CV_32F, 1, 0), cv2.Sobel(fine, cv2.CV_32F, 0, 1)
    brightness = on_grid(fine)
    gx_grid, gy_grid = on_grid(gx), on_grid(gy)
    features = _structure(gx, gy, on_grid)
    features += [brightness, gx_grid * 1.5, gy_grid * 1.5, np.hypot(gx_grid, gy_grid) * 1.5]
    near = on_grid(cv2.GaussianBlur(fine, (0, 0), 2.6))
    middle = cv2.GaussianBlur(near, (0, 0), 5.2 / spacing)
    far = cv2.GaussianBlur(middle, (0, 0), 10.4 / spacing)
    for x, gain in ((near, 1.0), (middle, 2.0), (far, 4.0)):
        dx, dy = cv2.Sobel(x, cv2.CV_32F, 1, 0) * gain, cv2.Sobel(x, cv2.CV_32F, 0, 1) * gain
        features += [x, dx, dy, np.hypot(dx, dy)]
    features += [(brightness - near) * 4, (near - middle) * 4, (middle - far) * 4]
    for i, radius in enumerate(_RINGS_PX):
        features += _ring(near if i == 0 else middle, radius / spacing, minus=0.7 * near)
    for channel in range(0 if colour is None else 2):
        shade = colour[..., channel].astype(np.float32) / 32 - 4  # type: ignore[index]
        shade = np.ascontiguousarray(on_grid(cv2.blur(shade, (3, 3))))
        smooth = cv2.GaussianBlur(shade, (0, 0), 5.1 / spacing)
        features += [shade, smooth]
        if channel == 0:
            features += _ring(smooth, _RINGS_PX[0] / spacing)
    return np.stack(features, axis=-1)


def _structure(gx: np.ndarray, gy: np.ndarray, on_grid) -> list[np.ndarray]:  # type: ignore[no-untyped-def]
    """Return strength, coherence and direction (doubled) of the texture."""
    xx, yy, xy = (
        on_grid(cv2.blur(cv2.blur(p, (7, 7)), (7, 7))) for p in (gx * gx, gy * gy, gx * gy)
    )
    apart = np.sqrt((xx - yy) ** 2 + 4 * xy**2)
    total = np.maximum(xx + yy, 0) + 1e-4
    return [np.sqrt(total) * 4, apart / total, (xx - yy) / total, 2 * xy / total]


def _ring(x: np.ndarray, radius: float, *, minus: np.ndarray | float = 0.0) -> list[np.ndarray]:
    """Return what lies at a distance in each of eight directions."""
    h, w = x.shape
    around = []
    for angle in np.arange(_DIRECTIONS) * (2 * np.pi / _DIRECTIONS):
        shift = np.array([[1, 0, radius * np.cos(angle)], [0, 1, radius * np.sin(angle)]])
        moved = cv2.warpAffine(
            x, shift, (w, h), flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
            borderMode=cv2.BORDER_REPLICATE,
        )  # fmt: skip
        around.append(moved - minus)
    return around
