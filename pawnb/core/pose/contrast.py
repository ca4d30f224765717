"""Cost of neighbours with different labels: Ising and contrast terms.

Pullar 2009, §3.2.2 and §3.2.3: Eq. 3.10 to 3.13.
"""

from __future__ import annotations

import cv2
import numpy as np

from pawnb.arrays import AnyArray, Float32Array


def squared_gradient(picture: AnyArray) -> Float32Array:
    """Return the squared gradient of every pixel by Sobel's operator (Eq. 3.13).

    Parameters
    ----------
    picture : ndarray, shape (H, W)
        Grey values.

    Returns
    -------
    ndarray of float32, shape (H, W)
        Gx² + Gy² with the weights 1, 2, 1 of Eq. 3.13, so that a slope of one grey value a px
        gives 64. The thesis takes the square root and calls that g².
    """
    grey = np.ascontiguousarray(picture, dtype=np.float32)
    gx, gy = (cv2.Sobel(grey, cv2.CV_32F, *d, borderType=cv2.BORDER_REPLICATE)
              for d in ((1, 0), (0, 1)))  # fmt: skip
    return gx**2 + gy**2


def neighbour_costs(
    picture: AnyArray, *, ising: float, contrast: float, edge_grey: float
) -> tuple[Float32Array, Float32Array]:
    """Return what it costs that two neighbours have different labels.

    Parameters
    ----------
    picture : ndarray, shape (H, W)
        Grey values.
    ising : float
        K of Eq. 3.10.
    contrast : float
        lambda of Eq. 3.11.
    edge_grey : float
        sigma of Eq. 3.11.

    Returns
    -------
    right : ndarray of float32, shape (H, W - 1)
        K + lambda exp(-g² / (2 sigma²)) of each pixel and the one to its right. g² is the mean
        of the two pixels' squared gradients; the thesis prints g in the exponent where its
        text defines g². Neighbours share an edge, so dist(i, j) is 1.
    down : ndarray of float32, shape (H - 1, W)
        The same of each pixel and the one below.
    """
    g2 = squared_gradient(picture)

    def cost(one: Float32Array, other: Float32Array) -> Float32Array:
        fall = edge_fall(np.float32(0.5) * (one + other), edge_grey)
        return np.float32(ising) + np.float32(contrast) * fall

    return cost(g2[:, :-1], g2[:, 1:]), cost(g2[:-1], g2[1:])


def edge_fall(g2: Float32Array, edge_grey: float) -> Float32Array:
    """Return exp(-g² / (2 sigma²)) of Eq. 3.11: 1 where the picture is flat, to 0 at edges.

    Parameters
    ----------
    g2 : ndarray of float32
        Squared gradients.
    edge_grey : float
        sigma.

    Returns
    -------
    ndarray of float32
        The factor of the contrast term.
    """
    return np.exp(np.float32(-0.5 / edge_grey**2) * g2)
