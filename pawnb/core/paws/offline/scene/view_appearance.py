"""What paws look like in the views, learnt from the pictures that were clicked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from pawnb.arrays import ByteArray
from pawnb.core.parallel import on_threads
from pawnb.core.paws.layout import Layout, Placement, Views
from pawnb.core.paws.offline.detection.colour.colour_model import Appearance, learn
from pawnb.core.paws.offline.detection.colour.detector import DetectorConfig
from pawnb.core.paws.offline.detection.colour.photometry.background import (
    estimate_background,
    to_grey,
)
from pawnb.core.paws.offline.detection.colour.photometry.illumination import mean_illumination
from pawnb.core.paws.offline.detection.colour.scan import ROI, searched
from pawnb.core.paws.offline.scene.clicks import frame_with_most_annotations
from pawnb.core.paws.offline.scene.parameters import MOVEMENT


def learn_appearance(
    views: Views, layout: Layout, clicks: Mapping[int, Sequence[Placement]]
) -> list[Appearance]:
    """Learn the appearance of paws in every view.

    Colours are the same in all views, so one look is learnt from all clicks. Grey levels are
    not: light comes from one side, and a mirror or a glass floor dims. There each view
    learns from its own clicks if it has some.

    Parameters
    ----------
    views : Views
        The opened views.
    layout : Layout
        Points and views.
    clicks : mapping
        Frame to positions placed by hand.

    Returns
    -------
    list of Appearance
        One a view.
    """
    like = frame_with_most_annotations(clicks)
    shown = _whole_pictures(views, layout, like, range(len(layout.views)))
    still = estimate_background(views, layout.sizes, shown)
    pictures, places, owners = [], [], []
    for frame, here in clicks.items():
        clicked = sorted({place.view for place in here})
        whole = shown if frame == like else _whole_pictures(views, layout, frame, clicked)
        for v in clicked:
            pictures.append(whole[v] if still[v] is None else to_grey(whole[v]))
            places.append(np.stack([place.uv for place in here if place.view == v]))
            owners.append(v)
    around = 2 * round(MOVEMENT.around_share * max(size[0] for size in layout.sizes) / 2) + 1

    def learn_from(which: Sequence[int]) -> Appearance:
        return learn(
            [pictures[i] for i in which], [places[i] for i in which], around_px=around,
            backgrounds=[still[owners[i]] for i in which],
        )  # fmt: skip

    everywhere = learn_from(range(len(pictures)))
    detectors = []
    for v, background in enumerate(still):
        own_pictures = [i for i, owner in enumerate(owners) if owner == v]
        alone = background is not None and len(own_pictures) > 0
        detector = learn_from(own_pictures) if alone else everywhere
        detectors.append(replace(detector, background=background))
    return detectors


def _whole_pictures(
    views: Views, layout: Layout, frame: int, which: Sequence[int]
) -> dict[int, ByteArray]:
    """Return whole pictures of some views in one frame."""
    opened = views.frame(frame)

    def whole(v: int) -> ByteArray:
        return np.asarray(opened[layout.views[v]].crop(0, 0, *layout.sizes[v]))

    return dict(zip(which, on_threads(whole, which), strict=True))


def with_illumination(
    detectors: Sequence[DetectorConfig], views: Views, frame: int, *, rois: Sequence[ROI]
) -> list[DetectorConfig]:
    """Note how bright what is searched is in a clicked frame.

    Parameters
    ----------
    detectors : sequence of DetectorConfig
        How each view is searched.
    views : Views
        The opened views.
    frame : int
        The frame.
    rois : sequence of ROI
        Where each is searched.

    Returns
    -------
    list of DetectorConfig
        The same, with the brightness.
    """
    opened = views.frame(frame)
    parts = [
        searched(opened[name], roi, detector.shrink)[0]
        for name, roi, detector in zip(views.names, rois, detectors, strict=True)
    ]
    return [
        replace(detector, illumination=mean_illumination(part))
        for detector, part in zip(detectors, parts, strict=True)
    ]
