"""What the clicks say about a recording: sizes, colours, where to search and how."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from pawnb.core.parallel import on_threads
from pawnb.core.paws.layout import Layout, Placement, Views
from pawnb.core.paws.offline.association.network_flow.triangulation import Volume
from pawnb.core.paws.offline.detection.colour.background import estimate_background, to_grey
from pawnb.core.paws.offline.detection.colour.colour_model import Appearance, learn
from pawnb.core.paws.offline.detection.colour.detector import DetectorConfig
from pawnb.core.paws.offline.detection.colour.illumination import mean_illumination
from pawnb.core.paws.offline.detection.colour.scan import ROI, configure_detector, searched
from pawnb.core.paws.offline.projection import Projection
from pawnb.core.paws.offline.scene.bottom_view import BottomView, find_bottom_view
from pawnb.core.paws.offline.scene.parameters import MOVEMENT
from pawnb.core.paws.offline.settings import OfflineSettings


@dataclass(frozen=True)
class Scene:
    """What the clicks say.

    Parameters
    ----------
    geometry : Projection
        The views.
    home : int
        The frame in which most points were placed: sizes, directions and what is searched are
        taken from it.
    anchors : dict
        Frame to point number to position (d,).
    body_scale : float
        Distance of front from hind paws, in the unit of space.
    paw_width : float
        Width of a paw there.
    paw_width_px : ndarray, shape (V,)
        The same in each view.
    detectors, rois : list
        How and where each view is searched.
    limb_direction : list of (float, float)
        Direction in each picture in which limbs tend to end.
    up, forward : ndarray, shape (d,)
        Unit vectors.
    volume : Volume, optional
        Where paws can be; None for one view by itself.
    bottom_view : BottomView, optional
        The view from below, where there is one.
    is_flat : bool
        Whether there is one view only, from below: up in its picture is to one side of the
        animal, and positions have no height.
    """

    geometry: Projection
    home: int
    anchors: dict[int, dict[int, np.ndarray]]
    body_scale: float
    paw_width: float
    paw_width_px: np.ndarray
    detectors: list[DetectorConfig]
    rois: list[ROI]
    limb_direction: list[tuple[float, float]]
    up: np.ndarray
    forward: np.ndarray
    volume: Volume | None
    bottom_view: BottomView | None = None
    is_flat: bool = False

    @property
    def is_learnt(self) -> bool:
        """Whether a classifier that was learnt tells paws, not their colour."""
        return any(detector.finds_blobs for detector in self.detectors)

    @property
    def across(self) -> np.ndarray | None:
        """Unit vector to the side of the animal; None for one view from the side."""
        if self.volume is not None:
            return self.volume.across
        return self.up if self.is_flat else None


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
        Frame to positions placed by hand, from which the look of the paws is learnt.
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
    geometry = Projection(None if layout.rig is None else layout.rig.coefs)
    up, forward = _directions(layout)
    placed = {t: _positions(here, layout, up) for t, here in sorted(anchors.items())}
    home = frame_with_most_annotations(anchors)
    first = np.stack(list(placed[home].values()))
    everyone = np.stack([x for here in placed.values() for x in here.values()])
    middle = first.mean(axis=0)
    per_unit = np.linalg.norm(geometry.jacobian(middle), axis=(-2, -1)) / np.sqrt(2.0)
    appearances = _learn_appearance(views, layout, clicks)
    paw_width = float(np.median([a.paw_width_px for a in appearances]) / np.mean(per_unit))
    body_scale = float(np.linalg.norm(first[:, None] - first[None], axis=-1).max())
    paw_width = max(paw_width, least_paw_width * body_scale)
    paw_width_px = paw_width * per_unit
    substrate, height = float((everyone @ up).min()), settings.height
    leading = None
    is_flat = layout.rig is None and shows_two_rows(placed[home], layout.kinds, forward)
    if is_flat:
        leading = 0
        # all of the animal's breadth is searched
        breadth = float(np.ptp(everyone @ up))
        substrate, height = (
            substrate - MOVEMENT.treadmill_beside * body_scale,
            breadth / body_scale + 2.0 * MOVEMENT.treadmill_beside,
        )
    else:
        body_scale = max(body_scale, MOVEMENT.least_span * paw_width)
    stage = _Stage(middle, forward, up, substrate, body_scale, height)
    if layout.rig is not None:
        leading = leading_view(layout, anchors)
    limb_direction = stage.limb_direction(geometry, paw_width)
    if is_flat:
        limb_direction = [(float(forward[0]), float(forward[1]))]
    rois, hulls = stage.search(geometry, layout.sizes, leading)
    detectors = [
        configure_detector(
            appearances[v],
            paw_width_px[v],
            limb_direction[v],
            limits=hulls[v],
            is_below=v == leading,
        )
        for v in range(len(layout.sizes))
    ]
    detectors = _with_illumination(detectors, views, home, rois)
    volume = bottom_view = None
    if layout.rig is not None:
        across = np.cross(up, forward)
        beside = everyone @ across
        # the paws of the other side are to be found too, or they are taken for the clicked
        margin = (
            MOVEMENT.beside_strange if unlabelled_kinds(layout.kinds) else MOVEMENT.treadmill_beside
        ) * body_scale
        volume = Volume(
            up, across,
            (substrate - MOVEMENT.treadmill_below * body_scale,
             substrate + settings.height * body_scale),
            (float(beside.min()) - margin, float(beside.max()) + margin),
        )  # fmt: skip
        if leading is not None:
            bottom_view = BottomView(
                leading,
                layout.rig.coefs,
                volume,
                substrate,
                paw_width,
                paw_width_px,
                limb_direction,
            )
    return Scene(
        geometry,
        home,
        placed,
        body_scale,
        paw_width,
        paw_width_px,
        detectors,
        rois,
        limb_direction,
        up,
        forward,
        volume,
        bottom_view,
        is_flat,
    )


def leading_view(layout: Layout, anchors: Mapping[int, Sequence[Placement]]) -> int | None:
    """Return the calibrated view from below that leads, or None; no picture is looked at."""
    if layout.rig is None:
        return None
    here = anchors[frame_with_most_annotations(anchors)]
    up = _directions(layout)[0]
    middle = np.stack(list(_positions(here, layout, up).values())).mean(axis=0)
    jacobian = Projection(layout.rig.coefs).jacobian(middle)
    return find_bottom_view(jacobian, up, here, n_points=len(layout.points))


def frame_with_most_annotations(placed: Mapping[int, Sequence[Placement]]) -> int:
    """Return the frame in which most points are placed, in most views; the first of several.

    A recording may be corrected before it was clicked, one paw at a time.
    """

    def count(frame: int) -> tuple[int, int, int]:
        here = placed[frame]
        return len({place.point for place in here}), len(here), -frame

    return max(placed, key=count)


def shows_two_rows(
    placed: Mapping[int, np.ndarray], kinds: Sequence[str], forward: np.ndarray
) -> bool:
    """Tell whether a single picture shows left and right paws in two rows, as from below.

    Parameters
    ----------
    placed : mapping
        Point number to position (2,), px, in one frame.
    kinds : sequence of str
        Kind of each point.
    forward : ndarray, shape (2,)
        Unit vector along the animal.

    Returns
    -------
    bool
        True where two front and two hind paws lie in two rows well apart.
    """
    pairs = [
        np.array([x for p, x in placed.items() if kinds[p] == kind]) for kind in ("front", "hind")
    ]
    if any(len(pair) != 2 for pair in pairs):
        return False
    long = abs(float((pairs[0].mean(axis=0) - pairs[1].mean(axis=0)) @ forward))
    rows = np.sort([pair @ np.array([-forward[1], forward[0]]) for pair in pairs], axis=1)
    return bool(rows[:, 1].min() - rows[:, 0].max() > MOVEMENT.treadmill_rows * long)


def unlabelled_kinds(kinds: Sequence[str]) -> list[str]:
    """Return the kinds of paws of which an animal has one more than was clicked."""
    return [kind for kind in ("front", "hind") if list(kinds).count(kind) == 1]


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
    placed = {t: _positions(here, layout, scene.up) for t, here in sorted(anchors.items())}
    return replace(scene, anchors=placed)


def _directions(layout: Layout) -> tuple[np.ndarray, np.ndarray]:
    """Return up and forward in space, or in the picture of a single view."""
    if layout.rig is not None:
        return np.array(layout.rig.up), np.array(layout.rig.forward)
    return np.array([0.0, -1.0]), np.array([float(layout.facing[0]), 0.0])


def _positions(here: Sequence[Placement], layout: Layout, up: np.ndarray) -> dict[int, np.ndarray]:
    """Return the position of every point placed in one frame."""
    uv = np.full((len(layout.points), len(layout.views), 2), np.nan)
    for place in here:
        uv[place.point, place.view] = place.uv
    n_views = np.isfinite(uv[..., 0]).sum(axis=1)
    if layout.rig is None:
        return {int(p): uv[p, 0] for p in np.flatnonzero(n_views)}
    xyz = layout.rig.triangulate(uv, refine=True).xyz
    known = xyz[n_views >= 2]
    height = float(np.median(known @ up)) if len(known) else 0.0
    for p in np.flatnonzero(n_views == 1):
        v = int(np.flatnonzero(np.isfinite(uv[p, :, 0]))[0])
        xyz[p] = _on_plane(layout.rig.coefs[:, v], uv[p, v], up, height)
    return {int(p): xyz[p] for p in np.flatnonzero(n_views)}


def _on_plane(L: np.ndarray, uv: np.ndarray, up: np.ndarray, height: float) -> np.ndarray:
    """Return the point of a plane at some height that one view sees at ``uv``."""
    A = np.stack([L[0:3] - uv[0] * L[8:11], L[4:7] - uv[1] * L[8:11], up])
    b = np.array([uv[0] - L[3], uv[1] - L[7], height])
    return np.linalg.lstsq(A, b, rcond=None)[0]


def _learn_appearance(
    views: Views, layout: Layout, clicks: Mapping[int, Sequence[Placement]]
) -> list[Appearance]:
    """Learn the look of the paws in every view.

    Colours are the same in all views, so one look is learnt from all clicks. Grey levels are
    not: light comes from one side, and a mirror or a glass floor dims. There each view
    learns from its own clicks if it has some.
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
) -> dict[int, np.ndarray]:
    """Return whole pictures of some views in one frame."""
    opened = views.frame(frame)

    def whole(v: int) -> np.ndarray:
        return np.asarray(opened[layout.views[v]].crop(0, 0, *layout.sizes[v]))

    return dict(zip(which, on_threads(whole, which), strict=True))


def _with_illumination(
    detectors: Sequence[DetectorConfig], views: Views, frame: int, rois: Sequence[ROI]
) -> list[DetectorConfig]:
    """Note how bright what is searched is in a clicked frame."""
    opened = views.frame(frame)
    parts = [
        searched(opened[name], roi, detector.shrink)[0]
        for name, roi, detector in zip(views.names, rois, detectors, strict=True)
    ]
    return [
        replace(detector, illumination=mean_illumination(part))
        for detector, part in zip(detectors, parts, strict=True)
    ]


@dataclass(frozen=True)
class _Stage:
    """Where the animal is and how large; see :class:`Scene`."""

    middle: np.ndarray
    forward: np.ndarray
    up: np.ndarray
    substrate: float
    body_scale: float
    height: float

    def limb_direction(self, geometry: Projection, paw_width: float) -> list[tuple[float, float]]:
        """Return the direction in each picture in which limbs tend to end."""
        tip = self.middle + (self.forward - self.up) * paw_width
        step = geometry.project(tip) - geometry.project(self.middle)
        step = step / np.maximum(np.linalg.norm(step, axis=-1, keepdims=True), 1e-9)
        return [(float(a), float(b)) for a, b in step]

    def search(
        self, geometry: Projection, sizes: Sequence[tuple[int, int]], leading: int | None
    ) -> tuple[list[ROI], list[np.ndarray]]:
        """Return the region of each view, and the limits within which paws can be."""
        rois, hulls = [], []
        for v, size in enumerate(sizes):
            # what is far to the side is not occluded from below
            broad = MOVEMENT.broad_below if v == leading else MOVEMENT.treadmill_broad
            corners = geometry.project(self._box(1.15, broad))[:, v]
            low, high = corners.min(axis=0), corners.max(axis=0)
            rois.append(ROI((low + high) / 2, (high - low) / 2, size))
            hulls.append(_hull(geometry.project(self._box(2.5, broad))[:, v]))
        return rois, hulls

    def _box(self, long: float, broad: float) -> np.ndarray:
        """Return the corners of the box in which paws are searched."""
        base = self.middle + (self.substrate - self.middle @ self.up) * self.up
        sides = [np.zeros_like(self.up)]
        if len(self.up) == 3:
            across = broad * self.body_scale * np.cross(self.up, self.forward)
            sides = [across, -across]
        return np.stack(
            [
                base + a * long * self.body_scale * self.forward + s + c * self.body_scale * self.up
                for a in (-1.0, 1.0) for s in sides
                for c in (-MOVEMENT.treadmill_below, self.height)
            ]
        )  # fmt: skip


def _hull(corners: np.ndarray) -> np.ndarray:
    """Return the lines (m, 3) of the convex hull of points, positive inside."""
    hull = cv2.convexHull(corners.astype(np.float32))[:, 0].astype(float)
    edge = np.roll(hull, -1, axis=0) - hull
    normal = np.column_stack([-edge[:, 1], edge[:, 0]])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-9)
    lines = np.column_stack([normal, -(normal * hull).sum(axis=1)])
    inside = lines[:, :2] @ hull.mean(axis=0) + lines[:, 2]
    return np.asarray(lines * np.sign(inside)[:, None])
