"""The sheet of the questions: small pictures of the labels whose answers would change most."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np

from pawnb.core.video.views import Frame
from pawnb.widgets.frame_canvas import FramePicture

MOST_CROPS = 6
"""Labels on a sheet at once: each is of another frame, which is read when it comes onto it."""
_SIDE_PX, _QUALITY = 128, 85


def cut_out(
    picture: FramePicture, place: tuple[float, float], size: float
) -> tuple[bytes, list[float]]:
    """Return the part of a picture about a place, and where in it the place is.

    Parameters
    ----------
    picture : FramePicture
        A view.
    place : tuple of float
        u, v in px.
    size : float
        Side of the square that is cut out, px; near an edge it is moved inwards.

    Returns
    -------
    data : bytes
        A JPEG of 128 x 128 px.
    at : list of float
        Place in it, as shares of its sides.
    """
    frame: Any = picture
    whole = None if isinstance(picture, Frame) else picture.image()
    height, width = (frame.height, frame.width) if whole is None else whole.shape[:2]
    side = int(min(size, width, height))
    low = [
        int(np.clip(round(x - side / 2), 0, most - side))
        for x, most in zip(place, (width, height), strict=True)
    ]
    u0, v0 = low
    if whole is None:
        image = frame.crop(u0, v0, u0 + side, v0 + side)
    else:
        image = whole[v0 : v0 + side, u0 : u0 + side]
    image = cv2.resize(image, (_SIDE_PX, _SIDE_PX), interpolation=cv2.INTER_AREA)
    if image.ndim == 3:
        image = cv2.cvtColor(image, cv2.COLOR_RGB2BGR)
    _, data = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])
    return data.tobytes(), [(x - x0 + 0.5) / side for x, x0 in zip(place, low, strict=True)]
