"""Collisions of paws: the template predicts through them, and jumps are undone.

Haji Maghsoudi et al. 2019, Algorithms 3 and 4. The paper names three types:

- I, a paw before or behind one of the other side: left to the 3D Kalman filter and the
  reconstruction from both views, as in the paper, and to no step of its own;
- II, front and hind paw of one side nearer to each other than Collision_Threshold: the
  template that was fitted to the frames before predicts where each is, until they part;
- III, a front paw that has jumped to the paw of the other side after a collision of
  type II: it is recognised by its reprojection error, and another of the three best
  superpixels is taken, by direction of motion and reprojection error.

Algorithm 3 as printed clears the flag in each frame and sets it only where it is set
already, so that it never predicts from the spline. Here a collision of type II alone
sets the flag, in every view of the two paws (line 11 predicts in both image planes), and
it lasts from frame to frame until the paws part.

Where this departs from the paper, because following it to the letter made more mistakes
than no template at all in rendered scenes (the template, carried through a collision, is a
worse guide than the filter while the paw is still seen). The setting ``template_predicts =
"always"`` takes these departures back:

- The template takes over for a paw only when the paw is lost: none of its three best
  superpixels is near where the filter has it, or (front paws) near where the template has
  it, or what is left is the other paw's. It then stays where the template has it,
  ``predicted``, until one of them is near the template again.
- A fit is given up if it misses a paw that is still found in the first frames of the
  collision; it is made again from the frames up to then.
- The flag is held a little longer than the paws are near, as front paws are hidden right
  after a collision.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pawnb.arrays import BoolArray, FloatArray, Points2D
from pawnb.core.paws.layout import Layout
from pawnb.core.paws.maghsoudi2019.collision_flags import (
    Candidates,
    Flag,
    Resolved,
    Undone,
    find_pairs,
    weights_in_collision,
)
from pawnb.core.paws.maghsoudi2019.parameters import MAGHSOUDI2019
from pawnb.core.paws.maghsoudi2019.template import StrideTemplate
from pawnb.core.paws.maghsoudi2019.template_fit import TemplateFit, fit_template


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
        self.pairs = find_pairs(layout)
        self._to_the_letter = layout.settings.template_predicts == "always"
        self.flags: dict[tuple[int, int, int], Flag] = {}
        """View, front and hind paw in collision, to the fits of the two."""
        self._expected: dict[tuple[int, int], np.ndarray] = {}
        self._history: list[np.ndarray] = []
        self._now = 0
        longest = max(kind.period_s for kind in template.kinds.values())
        self._stride_frames = max(round(longest * fps), 1)
        self._kept = MAGHSOUDI2019.collision_history * self._stride_frames
        # view and front paw: until when a jump may follow from a collision, and how many did
        self._watch: dict[tuple[int, int], int] = {}
        self._undone: dict[tuple[int, int], int] = {}

    def predict(self, centres: FloatArray) -> None:
        """Put the template's predictions in place of the filters' where a paw is lost.

        Parameters
        ----------
        centres : ndarray, shape (V, P, 2)
            Predicted positions of this frame, px; changed in place.
        """
        self._expected = {}
        for (view, _, _), flag in self.flags.items():
            for point, fit in flag.fits.items():
                place = fit.predict(self._now)
                if self.layout.contains(view, place):
                    self._expected[view, point] = place
                    if self._to_the_letter or point in flag.lost:
                        centres[view, point] = place

    def resolve(
        self,
        detections: Mapping[tuple[int, int], Candidates],
        uv: Points2D,
        *,
        centres: FloatArray,
    ) -> list[Resolved]:
        """Tell which paws in collision are lost, and which take another superpixel.

        Parameters
        ----------
        detections : mapping
            View and point to the best superpixels in this frame.
        uv : ndarray, shape (V, P, 2)
            What was found, px.
        centres : ndarray, shape (V, P, 2)
            Predicted positions, px.

        Returns
        -------
        list of Resolved
            Paws that do not keep the best superpixel.
        """
        resolved: list[Resolved] = []
        if self._to_the_letter:
            return resolved
        for (view, front, hind), flag in self.flags.items():
            for own, other in ((front, hind), (hind, front)):
                key = (view, own)
                if key not in self._expected or key not in detections:
                    continue
                places = detections[key].places
                good = self._is_own(flag, key, places, centres)
                good &= ~self._is_of(places, (view, other), uv, centres=centres, own=centres[key])
                rank = int(np.argmax(good)) if good.any() else None
                if rank is None:
                    flag.lost.setdefault(own, self._now)
                else:
                    flag.lost.pop(own, None)
                if rank != 0:
                    resolved.append(Resolved(key, rank, self._expected[key]))
        return resolved

    def _is_own(
        self, flag: Flag, key: tuple[int, int], places: FloatArray, centres: FloatArray
    ) -> BoolArray:
        """Tell which places are near enough to where a paw is to be: bool, shape (k,)."""
        view, point = key
        lost = point in flag.lost
        limit = self.layout.lengths[view].collision
        near = np.ones(len(places), dtype=bool)
        front = self.layout.kinds[point] == "front"
        if front or lost:
            step = np.linalg.norm(places - centres[key], axis=-1)
            p = MAGHSOUDI2019
            near &= step <= limit * (p.collision_found_again if lost else p.collision_step)
        if front:
            astray = limit * MAGHSOUDI2019.collision_astray
            near &= np.linalg.norm(places - self._expected[key], axis=-1) <= astray
        return near

    def _is_of(
        self,
        places: FloatArray,
        other: tuple[int, int],
        uv: Points2D,
        *,
        centres: FloatArray,
        own: FloatArray,
    ) -> BoolArray:
        """Tell which places another paw was found at, nearer to where it was to be."""
        limit = self.layout.lengths[other[0]].collision * MAGHSOUDI2019.collision_same
        same = np.linalg.norm(places - uv[other], axis=-1) <= limit
        theirs = np.linalg.norm(uv[other] - centres[other])
        return np.asarray(same & (np.linalg.norm(places - own, axis=-1) >= theirs))

    def is_colliding(self, key: tuple[int, int]) -> bool:
        """Tell whether a point in a view is in a type II collision, or lost after one."""
        view, point = key
        return any(
            view == pair[0] and point in pair[1:] and not flag.parted
            for pair, flag in self.flags.items()
        )

    def weights(self, key: tuple[int, int]) -> tuple[float, ...]:
        """Return the weights of the features, adjusted during a collision (Algorithm 4).

        Parameters
        ----------
        key : tuple of int
            View and point.

        Returns
        -------
        tuple of 8 float
            See :func:`.collision_flags.weights_in_collision`.
        """
        usual = self.layout.weights[key[1]]
        if not (self.layout.settings.adjust_weights and self.is_colliding(key)):
            return usual
        return weights_in_collision(usual, is_front=self.layout.kinds[key[1]] == "front")

    def undo_jumps(
        self,
        detections: Mapping[tuple[int, int], Candidates],
        uv: Points2D,
        *,
        last_uv: FloatArray,
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
        self, key: tuple[int, int], places: FloatArray, last: FloatArray
    ) -> list[int]:
        """Return the places among the best three that go with the direction of motion."""
        forwards = self.layout.facing[key[0]] * (places[:, 0] - last[0])
        if self._undone.get(key, 0) == 0:
            return [k for k in range(1, len(places)) if forwards[k] > 0]
        return [k for k in range(1, len(places)) if 0 < forwards[k] < forwards[0]]

    def record(self, uv: Points2D) -> None:
        """Take in the positions of a frame, then set and clear flags for the next one.

        Parameters
        ----------
        uv : ndarray, shape (V, P, 2)
            What was found, px; NaN where nothing was.
        """
        near = {
            pair[1:]
            for pair in self.pairs
            if np.linalg.norm(uv[pair[0], pair[1]] - uv[pair[0], pair[2]])
            < self.layout.lengths[pair[0]].collision
        }
        for pair in self.pairs:
            flag = self.flags.get(pair)
            if flag is not None:
                self._go_on(pair, flag, uv, near=pair[1:] in near)
            elif pair[1:] in near:
                fits = self._fit(pair[0], pair[1:])
                if fits:
                    self.flags[pair] = Flag(fits, self._now)
                    self._watch[pair[:2]] = self._now + self._stride_frames
                    self._undone.pop(pair[:2], None)
        self.remember(uv)
        for key in [key for key, until in self._watch.items() if until < self._now]:
            if not self.is_colliding(key):
                del self._watch[key]

    def _go_on(self, pair: tuple[int, int, int], flag: Flag, uv: Points2D, *, near: bool) -> None:
        """Clear a flag where the paws have parted, or where a fit is shown to be wrong."""
        if self._to_the_letter:
            if not near:
                del self.flags[pair]
            return
        view, p = pair[0], MAGHSOUDI2019
        limit = self.layout.lengths[view].collision
        for point, since in list(flag.lost.items()):
            if self._now - since > p.collision_lost * self._stride_frames:
                del flag.lost[point]
                flag.fits.pop(point, None)
        flag.parted = 0 if near or flag.lost else flag.parted + 1
        wrong = self._now - flag.since <= p.collision_beginning and any(
            np.linalg.norm(self._expected[view, point] - uv[view, point])
            > p.collision_wrong_fit * limit
            for point in flag.fits
            if point not in flag.lost and (view, point) in self._expected
        )
        if wrong or not flag.fits or flag.parted > p.collision_held * self._stride_frames:
            del self.flags[pair]

    def reset(self, key: tuple[int, int], place: FloatArray) -> None:
        """Make everything anew of a point in a view that a person has corrected.

        Where the correction is farther from the last position than a paw moves between two
        frames, what was found before was wrong, and the template is fitted to later frames
        only. A template that is in use is fitted anew.

        Parameters
        ----------
        key : tuple of int
            View and point.
        place : ndarray, shape (2,)
            Where the person put it, px.
        """
        view, point = key
        lengths = self.layout.lengths[view]
        if self._history:
            step = np.abs(self._history[-1][key] - place)
            most = MAGHSOUDI2019.slow_step
            if not (step <= [lengths.half_u * most, lengths.half_v * most]).all():
                for uv in self._history:
                    uv[key] = np.nan
        for pair in [p for p in self.flags if p[0] == view and point in p[1:]]:
            flag = self.flags.pop(pair)
            fits = self._fit(view, pair[1:])
            if point in fits:
                self.flags[pair] = Flag(fits, self._now, parted=flag.parted)
        self._watch.pop(key, None)

    def remember(self, uv: Points2D) -> None:
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
