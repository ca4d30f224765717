"""Small bright or pinkish spots in a picture that could be paws, and where their digits are.

A bare paw is lighter, redder and yellower than most of a picture, but belts may be as light or
as red as it is. So the picture itself tells which of its colours count: by how they vary over
it, the one mixture of lightness, redness and yellowness is made that skin stands out by most
from the rest (Fisher's linear discriminant). Redness alone is kept as another way to look. In
a grey picture a paw is lighter than what is around it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import cv2
import numpy as np

from pawnb.arrays import ByteArray, FloatArray, Points2D
from pawnb.core.paws.start_proposal.parameters import PAW_PROPOSAL
from pawnb.core.pixels.grey import has_colour

Look = Literal["skin", "red", "light"]
"""What tells a paw from the rest."""


@dataclass(frozen=True)
class Blobs:
    """Spots of one picture, the most paw-like first.

    Parameters
    ----------
    uv : ndarray, shape (n, 2)
        Positions, px.
    strength : ndarray, shape (n,)
        How far each stands out, 1 for what stands out most in an ordinary picture.
    """

    uv: Points2D
    strength: FloatArray


def paw_likeness(image: ByteArray, paw_px: float, *, look: Look = "skin") -> FloatArray:
    """Return how paw-like each pixel is.

    Parameters
    ----------
    image : ndarray, shape (H, W, 3) or (H, W)
        RGB or grey, uint8.
    paw_px : float
        Length of a hind paw, px.
    look : {"skin", "red", "light"}
        What tells a paw in a picture with colours; a grey one is always looked at for
        "light".

    Returns
    -------
    ndarray, shape (H, W)
        Above its median in the picture: the mixture of CIELAB's L*, a* and b* by which skin
        stands out most ("skin"), or a* ("red"). Or the white top-hat of grey levels ("light").
    """
    if image.ndim == 3:
        if look != "light" and has_colour(image):
            lab = cv2.cvtColor(image.astype(np.float32) / 255.0, cv2.COLOR_RGB2LAB)
            some = lab[::4, ::4]
            towards = _towards_skin(some) if look == "skin" else np.array([0.0, 1.0, 0.0])
            paw = cv2.transform(lab, towards.astype(np.float32)[None])
            return np.asarray(paw - np.median(some @ towards), dtype=float)
        image = image[..., 1]
    return np.asarray(_top_hat(image.astype(np.float32), paw_px), dtype=float)


def _towards_skin(lab: np.ndarray) -> np.ndarray:
    """Return the direction in CIELAB along which skin stands out most from a picture."""
    spread = np.cov(lab.reshape(-1, 3).T) + PAW_PROPOSAL.colour_noise**2 * np.eye(3)
    towards = np.linalg.solve(spread, np.array(PAW_PROPOSAL.skin))
    return np.asarray(towards / np.linalg.norm(towards))


def _top_hat(image: np.ndarray, paw_px: float) -> np.ndarray:
    """Return by how much pixels exceed what is left when all that is small is taken away."""
    size = max(3, round(PAW_PROPOSAL.top_hat * paw_px)) | 1
    kernel = cv2.getStructuringElement(cv2.MORPH_RECT, (size, size))
    return np.asarray(cv2.morphologyEx(image, cv2.MORPH_TOPHAT, kernel))


def find_blobs(
    likeness: FloatArray,
    paw_px: float,
    *,
    most: int | None = None,
    still: FloatArray | None = None,
) -> Blobs:
    """Find the spots of paw size that stand out.

    Parameters
    ----------
    likeness : ndarray, shape (H, W)
        As of :func:`paw_likeness`.
    paw_px : float
        Length of a hind paw, px.
    most : int, optional
        How many spots are returned at most; default the parameter ``blobs_most``.
    still : ndarray, shape (H, W), optional
        How paw-like each place is most of the time. What a spot has of this hardly counts: it
        stays where it is, and the paws of a running animal do not.

    Returns
    -------
    Blobs
        Local maxima of the smoothed likeness and its contrast with what is around, no two
        nearer than the parameter ``blob_radius``.
    """
    p = PAW_PROPOSAL
    sigma = max(p.blob_blur * paw_px, p.blob_blur_px)
    smooth = cv2.GaussianBlur(likeness.astype(np.float32), (0, 0), sigma)
    stays = np.zeros(smooth.shape)
    if still is not None:
        usual = cv2.GaussianBlur(still.astype(np.float32), (0, 0), sigma)
        stays = np.clip(usual / np.maximum(smooth, 1e-6), 0.0, 1.0)
    smooth += _top_hat(smooth, paw_px)
    scale = float(np.percentile(smooth, p.blob_percentile)) or 1.0
    smooth = cv2.multiply(smooth, 1.0 - (1.0 - p.still_worth) * stays, dtype=cv2.CV_32F)
    radius = max(1, round(p.blob_radius * paw_px))
    kernel = np.ones((2 * radius + 1, 2 * radius + 1), np.uint8)
    peaks = (smooth == cv2.dilate(smooth, kernel)) & (smooth > 0)
    rows, columns = np.nonzero(peaks)
    value = smooth[rows, columns]
    order = np.argsort(-value, kind="stable")[: p.blobs_most if most is None else most]
    uv = np.stack([columns[order], rows[order]], axis=-1).astype(float)
    return Blobs(uv, np.asarray(np.clip(value[order] / scale, 0.0, 1.0), dtype=float))


def find_digits(
    likeness: FloatArray, uv: FloatArray, direction: FloatArray, *, reach_px: float, pad_px: float
) -> FloatArray:
    """Find the middle of the digits of the paw at a spot.

    Parameters
    ----------
    likeness : ndarray, shape (H, W)
        As of :func:`paw_likeness`, in the same pixels as ``uv``.
    uv : ndarray, shape (2,)
        A position on the paw.
    direction : ndarray, shape (2,)
        Unit vector in the picture towards the tips of the digits.
    reach_px : float
        How far from ``uv`` the paw may reach.
    pad_px : float
        Length of the digits, from which the mean is taken.

    Returns
    -------
    ndarray, shape (2,)
        Mean of the paw's pixels no farther than ``pad_px`` behind its foremost ones.
    """
    height, width = likeness.shape
    u0, v0 = np.maximum(np.floor(uv - reach_px).astype(int), 0)
    u1 = min(int(np.ceil(uv[0] + reach_px)) + 1, width)
    v1 = min(int(np.ceil(uv[1] + reach_px)) + 1, height)
    if u0 >= u1 or v0 >= v1:
        return uv
    part, p = likeness[v0:v1, u0:u1].astype(np.float32), PAW_PROPOSAL
    window = cv2.GaussianBlur(part, (0, 0), max(p.digits_blur * pad_px, p.digits_blur_px))
    column, row = round(float(uv[0])) - int(u0), round(float(uv[1])) - int(v0)
    near = window[max(row - 1, 0) : row + 2, max(column - 1, 0) : column + 2]
    if near.size == 0:
        return uv
    peak, ground = float(near.max()), float(np.percentile(window, p.digits_ground))
    mask = (window > peak - p.digits_edge * (peak - ground)).astype(np.uint8)
    _, labels = cv2.connectedComponents(mask)
    here = labels[max(row - 1, 0) : row + 2, max(column - 1, 0) : column + 2]
    own = labels == np.bincount(here.ravel(), minlength=2)[1:].argmax() + 1
    rows, columns = np.nonzero(own)
    place = np.stack([columns + u0, rows + v0], axis=-1).astype(float)
    place = place[np.linalg.norm(place - uv, axis=-1) <= reach_px]
    if len(place) == 0:
        return uv
    along = place @ direction
    tip = float(np.percentile(along, p.digits_tip))
    return np.asarray(place[along >= tip - pad_px].mean(axis=0))


def share_as_paw_like(likeness: FloatArray, uv: FloatArray) -> float:
    """Return the share of a picture that is as paw-like as a place in it, or more so.

    Parameters
    ----------
    likeness : ndarray, shape (H, W)
        As of :func:`paw_likeness`.
    uv : ndarray, shape (2,)
        The place, px.

    Returns
    -------
    float
        0 to 1; 1 for a place outside the picture.
    """
    u, v = np.rint(uv).astype(int)
    here = likeness[max(v - 1, 0) : max(v + 2, 0), max(u - 1, 0) : max(u + 2, 0)]
    return float((likeness[::2, ::2] >= here.mean()).mean()) if here.size else 1.0
