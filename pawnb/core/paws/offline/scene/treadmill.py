"""What the clicks say about a recording: sizes, colours, where to search and how."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.paws.layout import Layout, Placement, Views
from pawnb.core.paws.offline.association.network_flow.triangulation import Volume
from pawnb.core.paws.offline.detection.colour.detector import DetectorConfig
from pawnb.core.paws.offline.detection.colour.scan import ROI, configure_detector
from pawnb.core.paws.offline.projection import Projection
from pawnb.core.paws.offline.scene.bottom_view import BottomView, find_bottom_view
from pawnb.core.paws.offline.scene.clicks import (
    clicked_positions,
    directions,
    frame_with_most_annotations,
    shows_two_rows,
    unlabelled_kinds,
)
from pawnb.core.paws.offline.scene.geometry import Geometry
from pawnb.core.paws.offline.scene.parameters import MOVEMENT
from pawnb.core.paws.offline.scene.search_region import SearchRegion
from pawnb.core.paws.offline.scene.view_appearance import learn_appearance, with_illumination
from pawnb.core.paws.offline.scene.views import SideViews, SingleView, SingleViewFromBelow
from pawnb.core.paws.offline.settings import OfflineSettings


@dataclass(frozen=True)
class Scene:
    """What the clicks say.

    Parameters
    ----------
    geometry : Geometry
        How the views stand about the animal.
    home : int
        The frame in which most points were placed: sizes, directions and what is searched are
        taken from it.
    anchors : dict
        Frame to point number to position (d,).
    body_scale : float
        Distance of front from hind paws, in the unit of space.
    detectors, rois : list
        How and where each view is searched.
    up, forward : ndarray, shape (d,)
        Unit vectors.
    """

    geometry: Geometry
    home: int
    anchors: dict[int, dict[int, np.ndarray]]
    body_scale: float
    detectors: list[DetectorConfig]
    rois: list[ROI]
    up: FloatArray
    forward: FloatArray

    @property
    def is_learnt(self) -> bool:
        """Whether a classifier that was learnt tells paws, not their colour."""
        return any(detector.finds_blobs for detector in self.detectors)

    @property
    def projection(self) -> Projection:
        """From positions to pictures."""
        return self.geometry.projection

    @property
    def paw_width(self) -> float:
        """Width of a paw, in the unit of space."""
        return self.geometry.paw_width

    @property
    def paw_width_px(self) -> FloatArray:
        """The same in each view (V,), px."""
        return self.geometry.paw_width_px

    @property
    def limb_direction(self) -> Sequence[tuple[float, float]]:
        """Direction in each picture in which limbs tend to end."""
        return self.geometry.limb_direction


def read_scene(
    views: Views,
    layout: Layout,
    clicks: Mapping[int, Sequence[Placement]],
    *,
    anchors: Mapping[int, Sequence[Placement]],
    settings: OfflineSettings,
    least_paw_width: float = 0.0,
) -> Scene:
    """Work out what the clicks say.

    Parameters
    ----------
    views : Views
        The opened views.
    layout : Layout
        Which point is tracked in which view.
    clicks : mapping
        Frame to positions placed by hand, from which the appearance of paws is learnt.
    anchors : mapping
        Frame to positions that tracks pass through.
    settings : OfflineSettings
        The settings.
    least_paw_width : float
        Paws are at least so thick, in distances of front from hind paws.

    Returns
    -------
    Scene
        What they say.
    """
    placed = _read_placed(layout, anchors)
    appearances = learn_appearance(views, layout, clicks)
    paw_width = float(np.median([a.paw_width_px for a in appearances]) / np.mean(placed.per_unit))
    paw_width = max(paw_width, least_paw_width * placed.body_scale)
    read = _read_single_view if layout.rig is None else _read_views_in_space
    geometry, region = read(placed, layout, paw_width=paw_width, height=settings.height)
    rois, hulls = region.search(geometry.projection, layout.sizes, geometry.from_below)
    detectors = [
        configure_detector(
            appearances[v],
            geometry.paw_width_px[v],
            geometry.limb_direction[v],
            limits=hulls[v],
            is_below=bool(geometry.from_below[v]),
        )
        for v in range(len(layout.sizes))
    ]
    return Scene(
        geometry, placed.home, placed.positions, region.body_scale,
        with_illumination(detectors, views, placed.home, rois=rois), rois,
        placed.up, placed.forward,
    )  # fmt: skip


@dataclass(frozen=True)
class _Placed:
    """Where points were placed, and the scale of the pictures there."""

    by_hand: Mapping[int, Sequence[Placement]]
    projection: Projection
    up: FloatArray
    forward: FloatArray
    positions: dict[int, dict[int, np.ndarray]]
    home: int
    middle: FloatArray  # (d,), of the points in the frame ``home``
    every: FloatArray  # (m, d), those of all frames
    per_unit: FloatArray  # (V,), px of each view for a unit of space
    body_scale: float  # largest distance of two points in the frame ``home``

    def region(self, *, substrate: float, body_scale: float, height: float) -> SearchRegion:
        """Return where the animal is, with what it stands on and its size."""
        return SearchRegion(self.middle, self.forward, self.up, substrate, body_scale, height)


def _read_placed(layout: Layout, anchors: Mapping[int, Sequence[Placement]]) -> _Placed:
    """Return where points were placed."""
    projection = Projection(None if layout.rig is None else layout.rig.coefs)
    up, forward = directions(layout)
    placed = {t: clicked_positions(here, layout, up) for t, here in sorted(anchors.items())}
    home = frame_with_most_annotations(anchors)
    first = np.stack(list(placed[home].values()))
    middle = first.mean(axis=0)
    return _Placed(
        anchors, projection, up, forward, placed, home, middle,
        np.stack([x for here in placed.values() for x in here.values()]),
        np.linalg.norm(projection.jacobian(middle), axis=(-2, -1)) / np.sqrt(2.0),
        float(np.linalg.norm(first[:, None] - first[None], axis=-1).max()),
    )  # fmt: skip


def _read_single_view(
    placed: _Placed, layout: Layout, *, paw_width: float, height: float
) -> tuple[Geometry, SearchRegion]:
    """Return a view by itself, from the side or from below, and where the animal is in it."""
    up, forward, body_scale = placed.up, placed.forward, placed.body_scale
    along_up = placed.every @ up
    paw_width_px = paw_width * placed.per_unit
    if shows_two_rows(placed.positions[placed.home], layout.kinds, forward):
        # all of the animal's breadth is searched
        beside = MOVEMENT.treadmill_beside
        region = placed.region(
            substrate=float(along_up.min()) - beside * body_scale,
            body_scale=body_scale,
            height=float(np.ptp(along_up)) / body_scale + 2.0 * beside,
        )
        ahead = [(float(forward[0]), float(forward[1]))]
        view = SingleViewFromBelow(placed.projection, paw_width, paw_width_px, ahead, up)
        return view, region
    region = placed.region(
        substrate=float(along_up.min()),
        body_scale=max(body_scale, MOVEMENT.least_span * paw_width),
        height=height,
    )
    limb_direction = region.limb_direction(placed.projection, paw_width)
    return SingleView(placed.projection, paw_width, paw_width_px, limb_direction, up), region


def _read_views_in_space(
    placed: _Placed, layout: Layout, *, paw_width: float, height: float
) -> tuple[Geometry, SearchRegion]:
    """Return calibrated views, from the side or led by one from below, and where the animal is."""
    up, across = placed.up, np.cross(placed.up, placed.forward)
    substrate = float((placed.every @ up).min())
    body_scale = max(placed.body_scale, MOVEMENT.least_span * paw_width)
    region = placed.region(substrate=substrate, body_scale=body_scale, height=height)
    beside = placed.every @ across
    # the paws of the other side are to be found too, or they are taken for the clicked
    margin = (
        MOVEMENT.beside_strange if unlabelled_kinds(layout.kinds) else MOVEMENT.treadmill_beside
    ) * body_scale
    volume = Volume(
        up, across,
        (substrate - MOVEMENT.treadmill_below * body_scale, substrate + height * body_scale),
        (float(beside.min()) - margin, float(beside.max()) + margin),
    )  # fmt: skip
    paw_width_px = paw_width * placed.per_unit
    limb_direction = region.limb_direction(placed.projection, paw_width)
    leading = leading_view(layout, placed.by_hand)
    if leading is None:
        views = SideViews(placed.projection, paw_width, paw_width_px, limb_direction, volume)
        return views, region
    view = BottomView(
        placed.projection, paw_width, paw_width_px, limb_direction, volume, leading, substrate
    )
    return view, region


def leading_view(layout: Layout, anchors: Mapping[int, Sequence[Placement]]) -> int | None:
    """Return the calibrated view from below that leads, or None; no picture is looked at."""
    if layout.rig is None:
        return None
    here = anchors[frame_with_most_annotations(anchors)]
    up = directions(layout)[0]
    middle = np.stack(list(clicked_positions(here, layout, up).values())).mean(axis=0)
    jacobian = Projection(layout.rig.coefs).jacobian(middle)
    return find_bottom_view(jacobian, up, here, n_points=len(layout.points))


def move_anchors(scene: Scene, layout: Layout, anchors: Mapping[int, Sequence[Placement]]) -> Scene:
    """Return the same scene with other positions that tracks pass through.

    Parameters
    ----------
    scene : Scene
        The scene.
    layout : Layout
        Points and views.
    anchors : mapping
        Row to what is certain there.

    Returns
    -------
    Scene
        The scene with these.
    """
    placed = {t: clicked_positions(here, layout, scene.up) for t, here in sorted(anchors.items())}
    return replace(scene, anchors=placed)
