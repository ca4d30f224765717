"""Collisions of paws: the template predicts through them, and jumps are undone.

Haji Maghsoudi et al. 2019, Algorithms 3 and 4. The paper names three types:

- I, a paw before or behind one of the other side: left to the 3D Kalman filter and the
  reconstruction from both views, as in the paper, and to no step of its own;
- II, front and hind paw of one side nearer to each other than Collision_Threshold: the
  template that was fitted to the frames before predicts where each is, until they part;
- III, a front paw that has jumped to the paw of the other side after a collision of
  type II: it is told by its reprojection error, and another of the three best
  superpixels is taken, by direction of motion and reprojection error.

Algorithm 3 as printed clears the flag in each frame and sets it only where it is set
already, so that it never predicts from the spline. Here a collision of type II alone
sets the flag of a view, and it lasts from frame to frame until the paws part.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from pawnb.core.paws.layout import Layout
from pawnb.core.paws.template import StrideTemplate
from pawnb.core.paws.template_fit import TemplateFit, fit_template

_KEPT_STRIDES = 3
"""Strides of history that are kept for a fit, which uses the last one of them."""


class Candidates(Protocol):
    """What is needed of a detection: the places of the best superpixels, best first."""

    @property
    def places(self) -> np.ndarray:
        """Positions, px, shape (k, 2)."""
        ...


@dataclass(frozen=True)
class Undone:
    """A jump that was undone.

    Parameters
    ----------
    key : tuple of int
        View and point.
    rank : int
        Which of the best superpixels is taken instead: 1 is the second best.
    """

    key: tuple[int, int]
    rank: int


class Collisions:
    """Flags, history and template fits of one run (Flag_Collision, Spline_Predictor).

    Parameters
    ----------
    layout : Layout
        What stays the same in the run.
    template : StrideTemplate
        The stride template.
    fps : float
        Frames per second.
    """

    def __init__(self, layout: Layout, template: StrideTemplate, *, fps: float) -> None:
        self.layout = layout
        self.template = template
        self.fps = fps
        self.pairs = _pairs(layout)
        self.flags: dict[tuple[int, int, int], dict[int, TemplateFit]] = {}
        """View, front and hind paw in collision, to the fits of the two."""
        self._history: list[np.ndarray] = []
        self._now = 0
        longest = max(kind.period_s for kind in template.kinds.values())
        self._stride_frames = max(round(longest * fps), 1)
        self._kept = _KEPT_STRIDES * self._stride_frames
        # view and front paw: until when a jump may follow from a collision, and how many did
        self._watch: dict[tuple[int, int], int] = {}
        self._undone: dict[tuple[int, int], int] = {}

    def predict(self, centres: np.ndarray) -> None:
        """Put the template's predictions in place of the filters' where paws collide.

        Parameters
        ----------
        centres : ndarray, shape (V, P, 2)
            Predicted positions of this frame, px; changed in place.
        """
        for (view, _, _), fits in self.flags.items():
            for point, fit in fits.items():
                place = fit.predict(self._now)
                if self.layout.contains(view, place):
                    centres[view, point] = place

    def is_colliding(self, key: tuple[int, int]) -> bool:
        """Tell whether the flag of a type II collision is set for a point in a view."""
        view, point = key
        return any(view == v and point in (f, h) for v, f, h in self.flags)

    def weights(self, key: tuple[int, int]) -> tuple[float, ...]:
        """Return the weights of the features, adjusted during a collision (Algorithm 4).

        Parameters
        ----------
        key : tuple of int
            View and point.

        Returns
        -------
        tuple of 8 float
            For a front paw in collision that of F1 (initial green) is one higher, that of
            F4 (previous hue) one lower, but not below 0, and that of F7 (corner) is 0; for
            a hind paw that of F3 (initial hue) is two higher. The paper's section 4.5 calls
            F1 "previously tracked" and F3 the first; Eq. 3 is followed.
        """
        usual = self.layout.weights[key[1]]
        if not (self.layout.settings.adjust_weights and self.is_colliding(key)):
            return usual
        w = list(usual)
        if self.layout.kinds[key[1]] == "front":
            w[0] += 1
            w[3] = max(w[3] - 1, 0.0)
            w[6] = 0.0
        else:
            w[2] += 2
        return tuple(w)

    def undo_jumps(
        self,
        detections: Mapping[tuple[int, int], Candidates],
        uv: np.ndarray,
        *,
        last_uv: np.ndarray,
    ) -> list[Undone]:
        """Find front paws that jumped (type III), and which superpixel to take instead.

        A front paw is looked at while its type II collision lasts and for one stride of
        the template from its beginning. Where its reprojection error is significant, the
        first time in a stride each of the three best superpixels that moves forwards is
        tried; after that only those of the other two between the place in the frame
        before and the best one (Algorithm 3, lines 30 to 36, u towards the direction of
        travel). The one with the least reprojection error is taken, if that is less.

        Parameters
        ----------
        detections : mapping
            View and point to the best superpixels in this frame.
        uv : ndarray, shape (V, P, 2)
            What was found, px.
        last_uv : ndarray, shape (V, P, 2)
            Positions in the frame before, px.

        Returns
        -------
        list of Undone
            At most one a point. Without a rig there is no reprojection error, and none.
        """
        rig = self.layout.rig
        undone: list[Undone] = []
        if rig is None:
            return undone
        for point in sorted({p for _, p in self._watch}):
            views = [v for v, p in self._watch if p == point and (v, point) in detections]
            residual = float(rig.triangulate(uv[:, point]).residual_px)
            limit = min((self.layout.lengths[v].jump_residual for v in views), default=np.inf)
            if not residual > limit:
                continue
            best: tuple[float, Undone] | None = None
            for view in views:
                places = detections[view, point].places
                for rank in self._ranks_to_try((view, point), places, last_uv[view, point]):
                    tried = uv[:, point].copy()
                    tried[view] = places[rank]
                    error = float(rig.triangulate(tried).residual_px)
                    if error < (residual if best is None else best[0]):
                        best = (error, Undone((view, point), rank))
            if best is not None:
                undone.append(best[1])
                key = best[1].key
                self._undone[key] = self._undone.get(key, 0) + 1
        return undone

    def _ranks_to_try(
        self, key: tuple[int, int], places: np.ndarray, last: np.ndarray
    ) -> list[int]:
        """Return the places among the best three that go with the direction of motion."""
        forwards = self.layout.facing[key[0]] * (places[:, 0] - last[0])
        if self._undone.get(key, 0) == 0:
            return [k for k in range(1, len(places)) if forwards[k] > 0]
        return [k for k in range(1, len(places)) if 0 < forwards[k] < forwards[0]]

    def record(self, uv: np.ndarray) -> None:
        """Take in the positions of a frame, then set and clear flags for the next one.

        Parameters
        ----------
        uv : ndarray, shape (V, P, 2)
            What was found, px; NaN where nothing was.
        """
        for view, front, hind in self.pairs:
            pair = (view, front, hind)
            apart = float(np.linalg.norm(uv[view, front] - uv[view, hind]))
            near = apart < self.layout.lengths[view].collision
            if not near:
                # what cannot be measured, because a paw left the picture, ends it as well
                self.flags.pop(pair, None)
            elif pair not in self.flags:
                fits = self._fit(view, (front, hind))
                if fits:
                    self.flags[pair] = fits
                    self._watch[view, front] = self._now + self._stride_frames
                    self._undone.pop((view, front), None)
        self.remember(uv)
        for key in [key for key, until in self._watch.items() if until < self._now]:
            if not self.is_colliding(key):
                del self._watch[key]

    def reset(self, key: tuple[int, int]) -> None:
        """Forget what was found of a point in a view that a person has corrected.

        What was found before may have been wrong, so the template is fitted to later frames
        only; a collision of the point ends.
        """
        view, point = key
        for uv in self._history:
            uv[view, point] = np.nan
        for pair in [p for p in self.flags if p[0] == view and point in p[1:]]:
            del self.flags[pair]
        self._watch.pop(key, None)

    def remember(self, uv: np.ndarray) -> None:
        """Take in the positions of a frame that has been tracked already; set no flag."""
        self._history.append(uv.copy())
        del self._history[: -self._kept]
        self._now += 1

    def _fit(self, view: int, points: tuple[int, int]) -> dict[int, TemplateFit]:
        """Fit the template to the frames before, for each paw that has enough of them."""
        settings = self.layout.settings
        fits: dict[int, TemplateFit] = {}
        if len(self._history) < settings.start_frame_collision:
            return fits
        for point in points:
            path = np.array([uv[view, point] for uv in self._history])
            fit = fit_template(
                self.template.kinds[self.layout.kinds[point]],
                path,
                facing=self.layout.facing[view],
                fps=self.fps,
                cutoff_hz=settings.template_cutoff_hz,
                least_frames=settings.start_frame_collision,
            )
            if fit is not None:
                fits[point] = fit.delayed(self._now - len(self._history))
        return fits


def _pairs(layout: Layout) -> tuple[tuple[int, int, int], ...]:
    """Return view, front and hind paw of each side in each view that knows its direction.

    Front and hind paw belong together if their names differ in the first letter only, or
    if they are the only ones in the view.
    """
    pairs = []
    for view, facing in enumerate(layout.facing):
        if not facing:
            continue
        front, hind = (
            [p for p, k in enumerate(layout.kinds) if k == kind and layout.tracked[view, p]]
            for kind in ("front", "hind")
        )
        alike = [
            (view, f, h)
            for f in front
            for h in hind
            if layout.points[f][1:].upper() == layout.points[h][1:].upper()
        ]
        if not alike and len(front) == len(hind) == 1:
            alike = [(view, front[0], hind[0])]
        pairs += alike
    return tuple(pairs)
