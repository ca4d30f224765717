"""What the pipeline is given: detections, what is certain, and what the clicks say."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from pawnb.arrays import FloatArray
from pawnb.core.paws.layout import Layout
from pawnb.core.paws.offline.detection.colour.detections import InFrames, InViews
from pawnb.core.paws.offline.scene.geometry import Anchors
from pawnb.core.paws.offline.scene.treadmill import Scene
from pawnb.core.paws.offline.settings import OfflineSettings


@dataclass(frozen=True)
class ReferenceAnnotations:
    """Clicks from which it is learnt where the tracked points lie on the paws.

    Parameters
    ----------
    clicks : ndarray, shape (frames, P, V, 2)
        Clicks, px, NaN where there is none, in the order of ``found``.
    found : mapping
        Clicked frame to the detections of every view.
    """

    clicks: FloatArray
    found: Mapping[int, InViews]


@dataclass(frozen=True)
class Recording:
    """What is given, the same in every pass.

    Parameters
    ----------
    found : sequence
        Detections of every frame and view.
    anchors : mapping
        Frame to point number to position, certain.
    certain : ndarray, shape (n, P, V, 2)
        Image positions placed by hand, NaN elsewhere.
    reference : ReferenceAnnotations
        Clicks that say where on a paw its point is.
    scene : Scene
        What the clicks say.
    layout : Layout
        Which point is tracked in which view.
    fps : float
        Frames per second.
    settings : OfflineSettings
        The settings.
    """

    found: InFrames
    anchors: Anchors
    certain: FloatArray
    reference: ReferenceAnnotations
    scene: Scene
    layout: Layout
    fps: float
    settings: OfflineSettings
