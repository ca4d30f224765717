"""What a paw looks like: the sub-image, its superpixels, and the means of each.

Haji Maghsoudi et al. 2019, section 2.3.4: a median filter against noise, SLIC
superpixels (Achanta et al. 2012) of the sub-image only, their number from the
smallest paw (Eq. 10), and the means of green, hue, red, u and v over each. Hue is
an angle, and pink lies across its wrap: its mean and differences are circular,
which the paper does not say.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import cv2
import numpy as np

from pawnb.arrays import AnyArray, ByteArray, FloatArray, IntArray, Points2D
from pawnb.core.paws.maghsoudi2019.settings import Lengths, Maghsoudi2019Settings
from pawnb.core.pixels.grey import has_colour

# L* of CIELAB runs from 0 to 100 where a grey picture runs from 0 to 1 in slic
_GREY_COMPACTNESS = 0.01
_ANGLES = np.arange(256) * (2 * np.pi / 256)
_COS, _SIN = np.cos(_ANGLES), np.sin(_ANGLES)


class FramePixels(Protocol):
    """What is needed of a frame: its pixels in a half-open region."""

    def crop(self, u0: int, v0: int, u1: int, v1: int) -> AnyArray:
        """Return the pixels of a region inside the picture.

        Parameters
        ----------
        u0, v0, u1, v1 : int
            Left, top, and one past right and bottom, px.

        Returns
        -------
        ndarray, shape (v1 - v0, u1 - u0, 3) or (v1 - v0, u1 - u0)
            The pixels.
        """
        ...


@dataclass(frozen=True)
class Window:
    """A sub-image: what was asked for, and the part of it inside the picture.

    Parameters
    ----------
    centre : ndarray, shape (2,)
        Centre in px of the view.
    half_u, half_v : float
        Half its width and height before it was clipped.
    box : tuple of int
        u0, v0, u1, v1, half open, inside the picture.
    """

    centre: FloatArray
    half_u: float
    half_v: float
    box: tuple[int, int, int, int]

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the clipped box."""
        u0, v0, u1, v1 = self.box
        return v1 - v0, u1 - u0

    def corner(self, facing: int) -> FloatArray:
        """Return the bottom corner towards the direction of travel (+1 right, -1 left)."""
        return self.centre + np.array([facing * self.half_u, self.half_v])


@dataclass(frozen=True)
class Look:
    """Mean colour of one superpixel.

    Parameters
    ----------
    green, red : float
        0 to 255.
    hue : float
        Degrees.
    """

    green: float
    hue: float
    red: float


@dataclass(frozen=True)
class Superpixels:
    """Means over each of the n superpixels of a sub-image.

    Parameters
    ----------
    green, red : ndarray, shape (n,)
        0 to 255.
    hue : ndarray, shape (n,)
        Circular mean, degrees in [0, 360); 0 where the picture is grey.
    uv : ndarray, shape (n, 2)
        Centre in px of the view.
    labels : ndarray of int, shape (rows, columns)
        Superpixel of each pixel of the sub-image.
    window : Window
        The sub-image.
    """

    green: FloatArray
    hue: FloatArray
    red: FloatArray
    uv: Points2D
    labels: IntArray
    window: Window

    def look(self, number: int) -> Look:
        """Return the colour of one superpixel."""
        return Look(float(self.green[number]), float(self.hue[number]), float(self.red[number]))

    def at(self, uv: Points2D) -> int:
        """Return the number of the superpixel at a position inside the sub-image."""
        u0, v0, u1, v1 = self.window.box
        column = int(np.clip(round(float(uv[0])), u0, u1 - 1)) - u0
        row = int(np.clip(round(float(uv[1])), v0, v1 - 1)) - v0
        return int(self.labels[row, column])


def place_window(centre: FloatArray, lengths: Lengths, *, width: int, height: int) -> Window | None:
    """Place a sub-image and clip it to the picture.

    Parameters
    ----------
    centre : ndarray, shape (2,)
        Its centre, px.
    lengths : Lengths
        Its half sizes.
    width, height : int
        Size of the picture.

    Returns
    -------
    Window or None
        None where the centre is outside the picture or unknown (NaN): the point cannot
        be seen there.
    """
    if not np.isfinite(centre).all():
        return None
    u, v = float(centre[0]), float(centre[1])
    if not (-0.5 <= u < width - 0.5 and -0.5 <= v < height - 0.5):
        return None
    box = (
        max(round(u - lengths.half_u), 0),
        max(round(v - lengths.half_v), 0),
        min(round(u + lengths.half_u), width),
        min(round(v + lengths.half_v), height),
    )
    # a window smaller than a pixel still holds the pixel of its centre
    box = (box[0], box[1], max(box[2], box[0] + 1), max(box[3], box[1] + 1))
    return Window(np.array([u, v]), lengths.half_u, lengths.half_v, box)


def count_superpixels(window: Window, lengths: Lengths, settings: Maghsoudi2019Settings) -> int:
    """Return the number of superpixels of a sub-image, clipped or not (Eq. 10).

    Parameters
    ----------
    window : Window
        The sub-image.
    lengths : Lengths
        The paw's area.
    settings : Maghsoudi2019Settings
        ``n_superpixels`` replaces Eq. 10 where given.

    Returns
    -------
    int
        rows × columns / (2 × area of the paw), at least 2.
    """
    rows, columns = window.shape
    if settings.n_superpixels is None:
        number = rows * columns / (2 * lengths.paw_area)
    else:
        whole = 4 * window.half_u * window.half_v
        number = settings.n_superpixels * rows * columns / whole
    return max(int(number), 2)


def measure_superpixels(
    picture: FramePixels, window: Window, lengths: Lengths, *, settings: Maghsoudi2019Settings
) -> Superpixels:
    """Cut out a sub-image, filter it, segment it and measure its superpixels.

    Parameters
    ----------
    picture : FramePixels
        A frame of one view; colour (RGB) or grey, 8 bit.
    window : Window
        The sub-image.
    lengths : Lengths
        Lengths in px of that view.
    settings : Maghsoudi2019Settings
        Settings of the median filter and of SLIC.

    Returns
    -------
    Superpixels
        Means of green, hue, red, u and v. A grey picture has its grey value as green
        and red, and hue 0 throughout.
    """
    crop = np.ascontiguousarray(picture.crop(*window.box))
    if lengths.median > 1:
        crop = cv2.medianBlur(crop, lengths.median)
    if crop.ndim == 3 and not has_colour(crop):
        crop = np.ascontiguousarray(crop[..., 1])
    grey = crop.ndim == 2
    from skimage.segmentation import slic  # slow to import

    labels = slic(
        crop,
        n_segments=count_superpixels(window, lengths, settings),
        compactness=settings.slic_compactness * (_GREY_COMPACTNESS if grey else 1.0),
        max_num_iter=settings.slic_iterations,
        sigma=settings.slic_sigma_px,
        start_label=0,
        channel_axis=None if grey else -1,
    )
    return _means(crop, labels, window)


def _means(crop: ByteArray, labels: IntArray, window: Window) -> Superpixels:
    """Take the mean of every channel and of u and v over each label."""
    flat = labels.ravel()
    count = np.bincount(flat)

    def mean(values: np.ndarray) -> FloatArray:
        return np.bincount(flat, weights=values.ravel()) / count

    rows, columns = labels.shape
    u0, v0 = window.box[:2]
    u = np.broadcast_to(np.arange(u0, u0 + columns, dtype=float), (rows, columns))
    v = np.broadcast_to(np.arange(v0, v0 + rows, dtype=float)[:, None], (rows, columns))
    uv = np.stack([mean(u), mean(v)], axis=-1)
    if crop.ndim == 2:
        level = mean(crop)
        return Superpixels(level, np.zeros_like(level), level, uv, labels, window)
    hue = cv2.cvtColor(crop, cv2.COLOR_RGB2HSV_FULL)[..., 0]
    angle = np.degrees(np.arctan2(mean(_SIN[hue]), mean(_COS[hue]))) % 360.0
    return Superpixels(mean(crop[..., 1]), angle, mean(crop[..., 0]), uv, labels, window)


def hue_difference(a: FloatArray | float, b: FloatArray | float) -> FloatArray:
    """Return the angle between hues.

    Parameters
    ----------
    a, b : ndarray or float
        Hues in degrees.

    Returns
    -------
    ndarray
        Degrees in [0, 180].
    """
    return np.abs((np.asarray(a) - np.asarray(b) + 180.0) % 360.0 - 180.0)


def colour_difference(superpixels: Superpixels, look: Look) -> FloatArray:
    """Return how much each superpixel differs in colour from a look.

    Parameters
    ----------
    superpixels : Superpixels
        n superpixels.
    look : Look
        The colour to compare with.

    Returns
    -------
    ndarray, shape (n,)
        Root mean square of the differences in green and red (of 255) and hue (of 180°);
        0 is the same colour, 1 the opposite.
    """
    parts = [
        (superpixels.green - look.green) / 255.0,
        (superpixels.red - look.red) / 255.0,
        hue_difference(superpixels.hue, look.hue) / 180.0,
    ]
    return np.sqrt(np.mean(np.square(parts), axis=0))
