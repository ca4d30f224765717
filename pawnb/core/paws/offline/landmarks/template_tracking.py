"""Following landmarks (nose, ears, tail, marks on the back) by their own picture.

Paws are found by their colour and their shape, and they swing; what else is clicked on an
animal is a patch of its surface, which keeps its appearance and moves little from frame to frame.
In each view the patch is taken on by optical flow (Lucas & Kanade 1981, pyramidal: Bouguet
2001), then aligned with the patch as it was clicked, so that errors do not add up. Where
the look has changed for good, a later patch serves as well. Where nothing looks alike, the
landmark is occluded until it does again.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import cv2
import numpy as np

from pawnb.arrays import ByteArray, FloatArray
from pawnb.core.paws.layout import Layout, Placement
from pawnb.core.paws.offline.landmarks.parameters import LANDMARKS
from pawnb.core.paws.superpixels import FramePixels
from pawnb.core.rig import Rig


@dataclass
class _Patch:
    """A landmark's surroundings in one frame: a picture, and where in it the landmark is."""

    picture: ByteArray
    at: FloatArray


@dataclass
class _LandmarkState:
    """What is known of one landmark in one view.

    Parameters
    ----------
    uv : ndarray, shape (2,)
        Where it was last, or is thought to be, px.
    is_seen : bool
        Whether it was seen there.
    patches : list
        How it looks: first as it was clicked.
    on_flow : int
        Frames in a row in which flow alone followed it.
    window : int
        Side of its patch, px.
    age : int
        Frames since it was placed.
    usual : float
        How much it usually looks like its patches where it is seen.
    """

    uv: FloatArray
    window: int
    is_seen: bool = True
    patches: list[_Patch] = field(default_factory=list)
    on_flow: int = 0
    age: int = 0
    usual: float = 1.0

    @property
    def same(self) -> float:
        """Correlation from which a patch that was lost is found again."""
        return max(
            LANDMARKS.template_tracking_alike,
            min(LANDMARKS.template_tracking_same, LANDMARKS.template_tracking_about * self.usual),
        )


class TemplateTracker:
    """Landmarks followed through consecutive frames.

    Parameters
    ----------
    layout : Layout
        The views, the rig, and the landmarks as its points.
    placed : mapping
        Frame to positions of landmarks that are known there.

    Attributes
    ----------
    layout, placed
        What it was made with.
    uv : list of ndarray, shape (V, P, 2)
        For each frame, where they were seen, px; NaN where they were not.
    likeness : list of ndarray, shape (V, P)
        Correlation with how they look, 0 to 1; 0 where they were not seen.
    """

    def __init__(self, layout: Layout, placed: Mapping[int, Sequence[Placement]]) -> None:
        self.layout, self.placed = layout, placed
        self._windows = [window_px(width) for width, _ in layout.sizes]
        self._states: dict[tuple[int, int], _LandmarkState] = {}
        self._before: Mapping[str, FramePixels] | None = None
        self.uv: list[np.ndarray] = []
        self.likeness: list[np.ndarray] = []

    def step(self, frame: int, pictures: Mapping[str, FramePixels]) -> None:
        """Follow every landmark into the next frame.

        Parameters
        ----------
        frame : int
            Its number.
        pictures : mapping
            The frame of each view, by name.
        """
        shape = self.layout.tracked.shape
        uv, likeness = np.full((*shape, 2), np.nan), np.zeros(shape)
        here = {(place.view, place.point): place for place in self.placed.get(frame, ())}
        if self._before is not None:
            for key, state in self._states.items():
                if key not in here:
                    uv[key], likeness[key] = self._follow(key, state, pictures)
        for key, place in here.items():
            uv[key], likeness[key] = place.uv, 1.0
            patch = self._patch(key, place, pictures)
            self._states[key] = _LandmarkState(
                place.uv.copy(), self._windows[key[0]], patches=[patch]
            )
        self._agree(uv, likeness)
        self.uv.append(uv)
        self.likeness.append(likeness)
        self._before = pictures

    def _patch(
        self, key: tuple[int, int], place: Placement, pictures: Mapping[str, FramePixels]
    ) -> _Patch:
        """Return how a landmark looks where it is known."""
        box = self._box(key[0], place.uv)
        return _Patch(self._grey(pictures, key[0], box), place.uv - box[:2])

    def _box(self, view: int, centre: FloatArray) -> tuple[int, int, int, int]:
        """Return the region around a position: left, top, right, bottom within the picture."""
        half = LANDMARKS.template_tracking_around * self._windows[view]
        ends = []
        for middle, size in zip(centre, self.layout.sizes[view], strict=True):
            low = int(np.clip(round(float(middle)) - half, 0, max(size - 2 * half, 0)))
            ends.append((low, min(low + 2 * half, size)))
        (u0, u1), (v0, v1) = ends
        return u0, v0, u1, v1

    def _grey(
        self, pictures: Mapping[str, FramePixels], view: int, box: tuple[int, int, int, int]
    ) -> np.ndarray:
        """Return the grey values of a region."""
        part = np.ascontiguousarray(pictures[self.layout.views[view]].crop(*box))
        grey = part if part.ndim == 2 else cv2.cvtColor(part, cv2.COLOR_RGB2GRAY)
        # single pixels are noise
        return cv2.GaussianBlur(grey, (0, 0), LANDMARKS.blur_px)

    def _follow(
        self, key: tuple[int, int], state: _LandmarkState, pictures: Mapping[str, FramePixels]
    ) -> tuple[FloatArray, float]:
        """Follow one landmark in one view; NaN and 0 where it is not seen."""
        if self._before is None or not np.isfinite(state.uv).all():
            return np.full(2, np.nan), 0.0
        box = self._box(key[0], state.uv)
        was, now = (self._grey(frame, key[0], box) for frame in (self._before, pictures))
        begin = state.uv - np.array(box[:2], dtype=float)
        state.age += 1
        found = _find(state, was, now, begin)
        largest = LANDMARKS.template_tracking_largest * self._windows[key[0]]
        while found is None and state.age <= LANDMARKS.young_frames and state.window < largest:
            # what was clicked has too little texture: its surroundings help
            state.window = round(LANDMARKS.larger * state.window) // 2 * 2 + 1
            found = _find(state, was, now, begin)
        state.is_seen = found is not None
        if found is None:
            return np.full(2, np.nan), 0.0
        at, alike = found
        state.uv = at + box[:2]
        return state.uv.copy(), max(alike, LANDMARKS.least_likeness)

    def _agree(self, uv: FloatArray, likeness: FloatArray) -> None:
        """Let the views correct each other: one of three may be wrong, a lost one is helped."""
        rig = self.layout.rig
        if rig is None:
            return
        for point in range(uv.shape[1]):
            seen = np.flatnonzero(np.isfinite(uv[:, point, 0]))
            if len(seen) < 2:
                continue
            xyz = rig.triangulate(uv[:, point]).xyz
            away = np.linalg.norm(rig.project(xyz) - uv[:, point], axis=-1) / self._windows
            if np.nanmax(away) > LANDMARKS.template_tracking_apart:
                if len(seen) == 2:
                    self._lose(seen[likeness[seen, point].argmin()], point, uv, likeness)
                    continue
                worst, place = _contradicted(rig, uv[:, point], self._windows)
                if worst is not None:
                    self._lose(worst, point, uv, likeness)
                    xyz = place
            for view, place in enumerate(rig.project(xyz)):
                if (view, point) in self._states and np.isnan(uv[view, point, 0]):
                    self._states[view, point].uv = place
                    self._states[view, point].is_seen = False

    def _lose(self, view: int, point: int, uv: FloatArray, likeness: FloatArray) -> None:
        """Take back that a view has seen a landmark."""
        uv[view, point], likeness[view, point] = np.nan, 0.0
        self._states[view, point].is_seen = False


def window_px(width: int) -> int:
    """Return the side of a patch in a picture of some width, px: an odd number."""
    return max(LANDMARKS.least_window_px, round(LANDMARKS.window_share * width)) // 2 * 2 + 1


def _find(
    state: _LandmarkState, was: np.ndarray, now: np.ndarray, begin: FloatArray
) -> tuple[np.ndarray, float] | None:
    """Find a landmark in the region where it was at ``begin``: where, and how much alike."""
    window = state.window
    flown = _flow(was, now, begin, window) if state.is_seen else None
    at, alike = _align(state.patches, now, begin if flown is None else flown, window)
    near = flown is None or np.linalg.norm(at - flown) <= window / 2
    if alike >= (LANDMARKS.template_tracking_alike if state.is_seen else state.same) and near:
        state.on_flow = 0
        state.usual += LANDMARKS.template_tracking_forget * (alike - state.usual)
        return at, alike
    if (
        flown is not None
        and _correlate(was, begin, now, flown, window) >= LANDMARKS.template_tracking_same
    ):
        state.on_flow += 1
        if state.on_flow >= LANDMARKS.changed_frames:
            # the first patch is what was clicked: it is never let go
            state.patches[1:] = [*state.patches[1:], _Patch(now, flown)][
                1 - LANDMARKS.most_patches :
            ]
            state.on_flow = 0
        return flown, max(alike, 0.0) if near else 0.0
    at, alike = _seek(state.patches, now, window)
    return (at, alike) if alike >= state.same else None


def _flow(was: np.ndarray, now: np.ndarray, at: np.ndarray, window: int) -> np.ndarray | None:
    """Return where optical flow takes a position; None where it does not come back."""
    there = _lucas_kanade(was, now, at, at, window, levels=LANDMARKS.flow_levels)
    if there is None:
        return None
    back = _lucas_kanade(now, was, there, at, window, levels=LANDMARKS.flow_levels)
    return None if back is None or np.linalg.norm(back - at) > LANDMARKS.back_px else there


def _lucas_kanade(
    was: ByteArray, now: ByteArray, at: FloatArray, guess: FloatArray, window: int, *, levels: int
) -> FloatArray | None:
    """Return where the surroundings of ``at`` are in another picture, sought from a guess."""
    first, then = (np.asarray(x, np.float32)[None, None].copy() for x in (at, guess))
    either = cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT
    stop = (either, LANDMARKS.flow_steps, LANDMARKS.flow_ends_px)
    found, ok, _ = cv2.calcOpticalFlowPyrLK(
        was, now, first, then, winSize=(window, window), maxLevel=levels, criteria=stop,
        flags=cv2.OPTFLOW_USE_INITIAL_FLOW,
    )  # fmt: skip
    place = found[0, 0].astype(float)
    inside = (place >= 0).all() and (place <= np.array(now.shape[::-1]) - 1).all()
    return place if ok[0, 0] and inside else None


def _align(
    patches: Sequence[_Patch], now: ByteArray, guess: FloatArray, window: int
) -> tuple[FloatArray, float]:
    """Return where a patch fits best near a guess, and how well: the clicked one if it does."""
    best, likeness = guess, -1.0
    for patch in patches:
        alike_lit = _in_the_light_of(patch, now, guess, window)
        at = _lucas_kanade(alike_lit, now, patch.at, guess, window, levels=LANDMARKS.align_levels)
        if at is None:
            continue
        alike = _correlate(patch.picture, patch.at, now, at, window)
        if alike > likeness:
            best, likeness = at, alike
        if likeness >= LANDMARKS.template_tracking_alike:
            break
    return best, likeness


def _in_the_light_of(patch: _Patch, now: np.ndarray, guess: np.ndarray, window: int) -> np.ndarray:
    """Return a patch's picture as bright and as contrasted as another is about a position.

    Flow takes a change of brightness for motion.
    """
    own, other = _cut(patch.picture, patch.at, window), _cut(now, guess, window)
    gain = float(np.clip(other.std() / max(float(own.std()), 1e-6), *LANDMARKS.gains))
    return cv2.convertScaleAbs(patch.picture, alpha=gain, beta=other.mean() - gain * own.mean())


def _seek(patches: Sequence[_Patch], now: ByteArray, window: int) -> tuple[FloatArray, float]:
    """Return where in the whole region a patch fits best, and how well."""
    best, likeness = np.zeros(2), -1.0
    for patch in patches:
        cut = _cut(patch.picture, patch.at, window)
        if min(now.shape) < window or cut.std() < 1e-6:
            continue
        _, high, _, corner = cv2.minMaxLoc(cv2.matchTemplate(now, cut, cv2.TM_CCOEFF_NORMED))
        if high > likeness:
            best, likeness = np.array(corner, dtype=float) + (window - 1) / 2, float(high)
    if likeness < LANDMARKS.template_tracking_lost:
        return best, likeness
    return _align(patches, now, best, window)


def _cut(picture: np.ndarray, at: np.ndarray, window: int) -> np.ndarray:
    """Return the square of a picture about a position between pixels."""
    return cv2.getRectSubPix(picture, (window, window), (float(at[0]), float(at[1])))


def _correlate(
    one: ByteArray, at: FloatArray, other: ByteArray, there: FloatArray, window: int
) -> float:
    """Return the correlation of two patches; 0 where either has no texture."""
    first, second = _cut(one, at, window), _cut(other, there, window)
    if first.std() < 1e-6 or second.std() < 1e-6:
        return 0.0
    return float(cv2.matchTemplate(first, second, cv2.TM_CCOEFF_NORMED)[0, 0])


def _contradicted(
    rig: Rig, uv: FloatArray, windows: Sequence[int]
) -> tuple[int | None, FloatArray]:
    """Return the view without which the others agree, if there is one, and their place."""
    tried = []
    for view in np.flatnonzero(np.isfinite(uv[:, 0])):
        rest = uv.copy()
        rest[view] = np.nan
        place = rig.triangulate(rest).xyz
        left = np.nanmax(np.linalg.norm(rig.project(place) - rest, axis=-1) / windows)
        tried.append((float(left), int(view), place))
    left, worst, place = min(tried, key=lambda one: one[0])
    return (worst if left <= LANDMARKS.template_tracking_together else None), place
