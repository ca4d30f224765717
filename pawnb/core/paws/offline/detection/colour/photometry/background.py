"""What stands still in a grey picture: the rig behind the moving animal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from pawnb.arrays import ByteArray
from pawnb.core.paws.layout import Views
from pawnb.core.paws.offline.detection.colour.photometry.illumination import (
    mean_illumination,
    normalise_illumination,
)
from pawnb.core.paws.offline.detection.colour_parameters import COLOUR
from pawnb.core.pixels.grey import has_colour


def to_grey(pixels: ByteArray) -> ByteArray:
    """Return the grey levels of a picture without colour."""
    return pixels if pixels.ndim == 2 else pixels[..., 1]


def estimate_background(
    views: Views, sizes: Sequence[tuple[int, int]], shown: Mapping[int, ByteArray]
) -> list[ByteArray | None]:
    """Return what stands still in each view: the median of frames from all over the recording.

    Legs are never long at one place, so the median shows what is behind them, and of a wheel
    or a belt its average look.

    Parameters
    ----------
    views : Views
        The opened views.
    sizes : sequence of (int, int)
        Width and height of each.
    shown : mapping of int to ndarray
        A whole picture of each view, by its number, in whose light it is shown.

    Returns
    -------
    list of ndarray
        One grey picture a view, uint8; None for a view in colour, where colours tell more.
    """
    grey = [v for v, picture in shown.items() if not has_colour(picture)]
    illumination = {v: mean_illumination(to_grey(shown[v])) for v in grey}
    kept: dict[int, list[np.ndarray]] = {v: [] for v in grey}
    if grey:
        count = min(COLOUR.background_samples, views.n_frames)
        for frame in np.linspace(0, views.n_frames - 1, count).round().astype(int).tolist():
            opened = views.frame(frame)
            for v in grey:
                picture = to_grey(opened[views.names[v]].crop(0, 0, *sizes[v]))
                kept[v].append(normalise_illumination(picture, illumination[v]))
    return [
        np.median(kept[v], axis=0).astype(np.uint8) if v in kept else None
        for v in range(len(views.names))
    ]
