"""One run of the paper's general tracker: its state, and the step from frame to frame.

Haji Maghsoudi et al. 2019, Algorithms 1, 2 and 3; what is done about collisions is in
:mod:`.maghsoudi2019.collisions`. Where the paper pairs the two cameras of a side, all
views that track a point are used.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from pawnb.arrays import BoolArray, FloatArray, Points2D
from pawnb.core import kalman
from pawnb.core.paws.layout import Layout, Placement
from pawnb.core.paws.maghsoudi2019.collisions import Collisions
from pawnb.core.paws.maghsoudi2019.frame_result import Detection, FrameResult
from pawnb.core.paws.maghsoudi2019.fusion import best_superpixels, compute_features, fuse, normalise
from pawnb.core.paws.maghsoudi2019.parameters import MAGHSOUDI2019
from pawnb.core.paws.maghsoudi2019.reacquisition import find_hidden
from pawnb.core.paws.superpixels import (
    FramePixels,
    Look,
    Superpixels,
    measure_superpixels,
    place_window,
)
from pawnb.core.rig import Rig
from pawnb.schema import ORIGIN_CODE

_MISSING_CODE, _MEASURED_CODE, _PREDICTED_CODE, _RESOLVED_CODE = (
    ORIGIN_CODE[name] for name in ("missing", "measured", "predicted", "resolved")
)
"""Layout: codes of origins."""
_STEP_OF_JACOBIAN = 1e-3
"""Numerics: step of the differences that stand for derivatives, in the largest coordinate."""


class Run:
    """The state of one run: Kalman filters, and the colours that were learnt.

    Parameters
    ----------
    layout : Layout
        What stays the same.
    collisions : Collisions, optional
        What handles collisions; without it nothing is done about them.
    """

    def __init__(self, layout: Layout, *, collisions: Collisions | None = None) -> None:
        n_views, n_points = layout.tracked.shape
        self.layout = layout
        self.collisions = collisions
        self.initial: dict[tuple[int, int], Look] = {}
        self.previous: dict[tuple[int, int], Look] = {}
        self._settled: set[tuple[int, int]] = set()
        self.idle = np.zeros(n_points, dtype=bool)
        """Points that are only followed where they were placed, and not looked for."""
        self.space = kalman.start(layout.in_space, np.full((n_points, 3), np.nan))
        self.image = kalman.start(layout.in_image, np.full((n_views, n_points, 2), np.nan))
        self.last_uv = np.full((n_views, n_points, 2), np.nan)
        self.last_xyz = np.full((n_points, 3), np.nan)
        self.detections: dict[tuple[int, int], Detection] = {}
        # without a rig, the view whose picture gives a point its position
        self.home: dict[int, int] = {}

    def learn(self, pictures: Mapping[str, FramePixels], placed: Sequence[Placement]) -> None:
        """Learn the colour of points from where they are known to be.

        A point put there by hand (and one of which no colour is known yet) gives the
        initial colour, unless that is settled, and every point the colour of the frame
        before.
        """
        for place in sorted(placed, key=lambda place: (place.view, place.point)):
            key = (place.view, place.point)
            self.home.setdefault(place.point, place.view)
            if self.idle[place.point]:
                continue
            superpixels = self._measure(pictures, place.view, place.uv)
            if superpixels is None:
                continue
            look = superpixels.look(superpixels.at(place.uv))
            self.previous[key] = look
            anew = place.origin == "edited" and key not in self._settled
            if anew or key not in self.initial:
                self.initial[key] = look

    def settle(self) -> None:
        """Keep the initial colours that are known: what is placed later changes none."""
        self._settled |= set(self.initial)

    def step(self, pictures: Mapping[str, FramePixels], placed: Sequence[Placement]) -> FrameResult:
        """Track one frame: predict, find, reconstruct, update.

        Parameters
        ----------
        pictures : mapping
            The frame of each view, by name.
        placed : sequence of Placement
            Points whose place in this frame is known.

        Returns
        -------
        FrameResult
            Positions, origins and confidences.
        """
        layout = self.layout
        self._predict()
        centres = self._predicted_uv()
        if self.collisions is not None:
            self.collisions.predict(centres)
        result = self._empty_result()
        self.detections = {}
        self.learn(pictures, placed)
        for place in placed:
            key = (place.view, place.point)
            if self.collisions is not None and place.origin == "edited":
                self.collisions.reset(key, place.uv)
            result.uv[key] = place.uv
            result.image_origin[key] = ORIGIN_CODE[place.origin]
            result.image_confidence[key] = place.confidence
        fixed = {(place.view, place.point) for place in placed}
        before = dict(self.previous)
        for key in self.initial:
            if key not in fixed and not self.idle[key[1]]:
                self._find(pictures, key, centres[key], result)
        if layout.uses_space and layout.settings.hidden == "search":
            self._find_hidden(pictures, fixed, result)
        if self.collisions is not None:
            self._resolve(self.collisions, result, centres=centres, before=before)
            self._undo_jumps(self.collisions, result)
        if layout.rig is not None:
            self._triangulate(layout.rig, result)
        self._update(result, result.image_origin == ORIGIN_CODE["edited"])
        if self.collisions is not None:
            self.collisions.record(result.uv)
        self._fill_predicted(result, centres)
        if layout.rig is None:
            self._take_from_picture(result)
        return result

    def follow(self, uv: Points2D, by_hand: BoolArray) -> None:
        """Take the filters over a frame that has been tracked already.

        Parameters
        ----------
        uv : ndarray, shape (V, P, 2)
            Where the points were found, px; NaN where they were not.
        by_hand : ndarray of bool, shape (V, P)
            Which of them a person put in place.
        """
        self._predict()
        result = self._empty_result()
        result.uv[:] = uv
        if self.layout.rig is not None:
            self._triangulate(self.layout.rig, result)
        self._update(result, by_hand)
        if self.collisions is not None:
            self.collisions.remember(result.uv)

    def _measure(
        self, pictures: Mapping[str, FramePixels], view: int, centre: FloatArray
    ) -> Superpixels | None:
        """Measure the superpixels around a position; None where it is outside the picture."""
        layout = self.layout
        width, height = layout.sizes[view]
        lengths = layout.lengths[view]
        window = place_window(centre, lengths, width=width, height=height)
        if window is None:
            return None
        picture = pictures[layout.views[view]]
        return measure_superpixels(picture, window, lengths, settings=layout.settings)

    def _predict(self) -> None:
        """Take the filters one frame on."""
        self.space = kalman.predict(self.layout.in_space, self.space)
        self.image = kalman.predict(self.layout.in_image, self.image)

    def _predicted_uv(self) -> FloatArray:
        """Project the 3D prediction; where a point has none, take that in the picture."""
        flat = self.image.position.copy()
        if self.layout.rig is None or not self.layout.uses_space:
            return flat
        projected = np.swapaxes(self.layout.rig.project(self.space.position), 0, 1)
        return np.where(np.isfinite(projected), projected, flat)

    def _empty_result(self) -> FrameResult:
        n_views, n_points = self.layout.tracked.shape
        n_space = 2 if self.layout.rig is None else 3
        return FrameResult(
            uv=np.full((n_views, n_points, 2), np.nan),
            image_origin=np.full((n_views, n_points), _MISSING_CODE, dtype=np.int8),
            image_confidence=np.zeros((n_views, n_points)),
            position=np.full((n_points, n_space), np.nan),
            origin=np.full(n_points, _MISSING_CODE, dtype=np.int8),
            confidence=np.zeros(n_points),
            residual=np.full(n_points, np.nan),
        )

    def _find(
        self,
        pictures: Mapping[str, FramePixels],
        key: tuple[int, int],
        centre: FloatArray,
        result: FrameResult,
    ) -> None:
        """Find a point in the sub-image around its predicted position."""
        view, point = key
        superpixels = self._measure(pictures, view, centre)
        if superpixels is None:
            return
        layout = self.layout
        features = compute_features(
            superpixels, self.initial[key], self.previous[key], facing=layout.facing[view]
        )
        weights = layout.weights[point]
        colliding = False
        if self.collisions is not None:
            weights = self.collisions.weights(key)
            colliding = self.collisions.is_colliding(key)
        scores = fuse(normalise(features), weights)
        best = best_superpixels(scores, count=layout.settings.n_best)
        self.detections[key] = Detection(superpixels, best, scores[best])
        self._accept(key, superpixels, int(best[0]), float(scores[best[0]]), result)
        if colliding:
            result.image_origin[key] = _RESOLVED_CODE

    def _resolve(
        self,
        collisions: Collisions,
        result: FrameResult,
        *,
        centres: FloatArray,
        before: Mapping[tuple[int, int], Look],
    ) -> None:
        """Put lost paws where the template has them; let others take another superpixel."""
        for resolved in collisions.resolve(self.detections, result.uv, centres=centres):
            key = resolved.key
            found = self.detections[key]
            if resolved.rank is None:
                result.uv[key] = resolved.place
                result.image_origin[key] = _PREDICTED_CODE
                result.image_confidence[key] = 0.0
                self.previous[key] = before[key]
                del self.detections[key]
                continue
            number, score = int(found.best[resolved.rank]), float(found.scores[resolved.rank])
            self._accept(key, found.superpixels, number, score, result)
            result.image_origin[key] = _RESOLVED_CODE

    def _undo_jumps(self, collisions: Collisions, result: FrameResult) -> None:
        """Take another of the best superpixels where a paw has jumped to another one."""
        for undone in collisions.undo_jumps(self.detections, result.uv, last_uv=self.last_uv):
            found = self.detections[undone.key]
            number, score = int(found.best[undone.rank]), float(found.scores[undone.rank])
            self._accept(undone.key, found.superpixels, number, score, result)
            result.image_origin[undone.key] = _RESOLVED_CODE

    def _accept(
        self,
        key: tuple[int, int],
        superpixels: Superpixels,
        number: int,
        score: float,
        result: FrameResult,
    ) -> None:
        """Take a superpixel as the point's image."""
        result.uv[key] = superpixels.uv[number]
        result.image_origin[key] = _MEASURED_CODE
        result.image_confidence[key] = score
        self.previous[key] = superpixels.look(number)

    def _find_hidden(
        self,
        pictures: Mapping[str, FramePixels],
        fixed: set[tuple[int, int]],
        result: FrameResult,
    ) -> None:
        """Look for points in the views where they have not been seen yet."""
        for view, point in np.argwhere(self.layout.tracked).tolist():
            key = (view, point)
            if key in self.initial or key in fixed or self.idle[point]:
                continue
            looks = self._looks_like(view, point)
            found = find_hidden(self.layout, pictures, key, looks=looks, uv=result.uv)
            if found is not None:
                superpixels, number, score = found
                self.initial[key] = superpixels.look(number)
                self._accept(key, superpixels, number, score, result)

    def _looks_like(self, view: int, point: int) -> list[Look]:
        """Return what a point may look like in a view where it has not been seen.

        Points of its kind (front or hind) in that view, in that light, tell more than the
        point itself in another view; a point of no kind is compared with itself.
        """
        kinds = self.layout.kinds
        alike = [
            look
            for (v, p), look in self.initial.items()
            if v == view and kinds[p] == kinds[point] != "other"
        ]
        return alike or [look for (_, p), look in self.initial.items() if p == point]

    def _triangulate(self, rig: Rig, result: FrameResult) -> None:
        """Give every point that two views or more have found its place in space."""
        solved = rig.triangulate(np.swapaxes(result.uv, 0, 1))
        for point in np.flatnonzero(np.isfinite(solved.xyz[:, 0])).tolist():
            used = np.isfinite(result.uv[:, point, 0])
            by_hand = (result.image_origin[used, point] == ORIGIN_CODE["edited"]).all()
            result.position[point] = solved.xyz[point]
            result.residual[point] = solved.residual_px[point]
            found = (result.image_origin[used, point] != _PREDICTED_CODE).any()
            code = _MEASURED_CODE if found else _PREDICTED_CODE
            result.origin[point] = ORIGIN_CODE["edited"] if by_hand else code
            result.confidence[point] = result.image_confidence[used, point].mean()

    def _take_from_picture(self, result: FrameResult) -> None:
        """Without a rig, take each point's position from the view of its first click."""
        for point, view in self.home.items():
            result.position[point] = result.uv[view, point]
            result.origin[point] = result.image_origin[view, point]
            result.confidence[point] = result.image_confidence[view, point]

    def _update(self, result: FrameResult, by_hand: BoolArray) -> None:
        """Update the filters; those of points put in place by hand start anew there."""
        layout = self.layout
        slow, moved = self._is_slow(result.uv)
        self.image = _advance(layout.in_image, self.image, result.uv, by_hand, self.last_uv, slow)
        self.last_uv = result.uv.copy()
        if layout.rig is None:
            return
        xyz = result.position.copy()
        for point in np.flatnonzero(np.isnan(xyz[:, 0])).tolist():
            xyz[point] = self._nearest_on_ray(point, result.uv[:, point])
        calm = np.all(slow | ~moved, axis=0) & np.any(moved, axis=0)
        self.space = _advance(
            layout.in_space, self.space, xyz, np.asarray(by_hand.any(axis=0)), self.last_xyz, calm
        )
        self.last_xyz = xyz

    def _is_slow(self, uv: Points2D) -> tuple[BoolArray, BoolArray]:
        """Tell which points moved no more than half the sub-image's half size, and which moved.

        That is about what the paper gives as the most between two frames (30 px and 15 px
        in sub-images of ± 70 and ± 40 px). A larger step is a correction, no velocity.
        """
        limit = np.array([[x.half_u, x.half_v] for x in self.layout.lengths], dtype=float)
        limit *= MAGHSOUDI2019.slow_step
        step = np.abs(uv - self.last_uv)
        return (step <= limit[:, None, :]).all(axis=-1), np.isfinite(step).all(axis=-1)

    def _nearest_on_ray(self, point: int, uv: Points2D) -> FloatArray:
        """Move a 3D prediction the least so that it projects to the one view that saw it."""
        predicted = self.space.position[point]
        seen = np.flatnonzero(np.isfinite(uv[:, 0]))
        rig = self.layout.rig
        if rig is None or len(seen) != 1 or not np.isfinite(predicted).all():
            return np.full(3, np.nan)
        view = int(seen[0])
        step = _STEP_OF_JACOBIAN * max(float(np.abs(predicted).max()), 1.0)
        around = rig.project(np.vstack([predicted, predicted + step * np.eye(3)]))[:, view]
        jacobian = (around[1:] - around[0]).T / step
        return np.asarray(predicted + np.linalg.pinv(jacobian) @ (uv[view] - around[0]))

    def _fill_predicted(self, result: FrameResult, centres: FloatArray) -> None:
        """Give the prediction where nothing was found, if it is inside the picture."""
        layout = self.layout
        for key in self.initial:
            gone = result.image_origin[key] == _MISSING_CODE
            if gone and np.isfinite(centres[key]).all() and layout.contains(key[0], centres[key]):
                result.uv[key] = centres[key]
                result.image_origin[key] = _PREDICTED_CODE
        if layout.rig is not None:
            lost = np.isnan(result.position[:, 0]) & np.isfinite(self.space.position[:, 0])
            result.position[lost] = self.space.position[lost]
            result.origin[lost] = _PREDICTED_CODE


def _advance(
    model: kalman.ConstantVelocity,
    state: kalman.State,
    measured: FloatArray,
    restart: BoolArray,
    last: FloatArray,
    slow: BoolArray,
) -> kalman.State:
    """Update states; start those anew that are new or put in place.

    A start takes its velocity from the step since the last frame where that is slow.
    """
    updated = kalman.update(model, state, measured)
    known = np.isfinite(measured).all(axis=-1)
    fresh = known & (restart | np.isnan(state.mean).any(axis=-1))
    step = measured - last
    use = slow & np.isfinite(step).all(axis=-1)
    begun = kalman.start(model, measured, np.where(use[..., None], step, 0.0))
    return kalman.State(
        np.where(fresh[..., None], begun.mean, updated.mean),
        np.where(fresh[..., None, None], begun.covariance, updated.covariance),
    )
