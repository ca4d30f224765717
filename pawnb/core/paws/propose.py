"""Finding the paws without clicks: the frame and the points that a person accepts or drags.

Frames from all over the recording are looked through for places that could be paws
(:mod:`pawnb.core.paws.places`). For each frame, one place is chosen for each paw by what it
looks like, how well its views agree, how near it is to the ground and to where such paws
stand. The frame is proposed whose least certain paw is most certain; there, the middle of
each paw's digits is measured in every view. Where red spots make no sure paws, all is done
again with spots that are red and yellow, and the surer of the two is taken.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from pawnb.core.grey import has_colour
from pawnb.core.paws.appearance import Picture
from pawnb.core.paws.blobs import PAW_SHARE, Blobs, find_blobs, find_digits, paw_likeness
from pawnb.core.paws.layout import Views
from pawnb.core.paws.places import Places, Stage, find_stage, join, on_ground, pair_blobs
from pawnb.core.rig import Rig
from pawnb.errors import InputError
from pawnb.schema import START_COLUMNS

_STILL_FRAMES = 9
"""Frames, spread over those that are looked through, that tell what stays where it is. Fewer
may all fall into one stance."""
_SURE = 0.5
"""Where each paw is so sure, they are not looked for in another way."""
_TRIED = 12
"""Frames in which the digits are measured before one is chosen."""

_ABOVE_SD, _BELOW_SD = 0.2, 0.06
_LIFT_SD = 0.13
_ALONG_SD, _APART, _CLEAR, _SAME = 0.6, 0.22, 0.25, 0.15
_RESIDUAL_SD = 0.1
_ONE_VIEW = 0.6
_ASIDE, _ASIDE_SD = 0.3, 0.25
_REACH, _PAD, _DOWN = 0.35, 0.06, 0.6
"""All of these are in spans, so that no length has to be known: standard deviations of the
height above and below the ground, of the digits' height, and of the place along forward and
to the side; the least distances of paws; the reach of a paw and the length of its digits.
``_DOWN`` is how much digits point down in the picture for each part forward; residuals are
in paw lengths."""


@dataclass(frozen=True)
class FoundPaws:
    """Paws found in one frame.

    Parameters
    ----------
    frame : int
        The frame.
    start : DataFrame
        frame, view, point, u, v (px).
    sure : dict of str to float
        How sure each point is, 0 to 1; 0 for a point that was not found.
    """

    frame: int
    start: pd.DataFrame
    sure: dict[str, float]


@dataclass(frozen=True)
class _Paw:
    """A point that is looked for: which group of views, which side, front or hind."""

    point: str
    group: int
    side: int
    is_front: bool


def find_paws(
    views: Views,
    rig: Rig,
    *,
    points_by_view: Mapping[str, Sequence[str]],
    frames: Sequence[int],
    progress: Callable[[int, int], None] | None = None,
) -> FoundPaws:
    """Find the four paws of a running animal in one of some frames.

    Parameters
    ----------
    views : Views
        The opened views.
    rig : Rig
        Their calibration, whose ``forward`` is the direction in which the animal faces.
    points_by_view : mapping
        Points of each view, among FR, HR, FL and HL.
    frames : sequence of int
        Frames to look through, ascending.
    progress : callable, optional
        ``progress(done, total)``.

    Returns
    -------
    FoundPaws
        The frame and the points.

    Raises
    ------
    InputError
        If a point is not one of the four paws, or no paws can be told from the rest.
    """
    groups = _groups(points_by_view)
    paws = _wanted(groups)
    if not any(len(names) > 1 for names in groups.values()):
        raise InputError(
            "no point is tracked by two views; paws can be proposed only where two calibrated "
            "views see the same side: click the points instead."
        )
    looks = _Looks(views, frames)
    found = _find(looks, rig, groups, paws, progress)
    if looks.has_colour() and (found is None or min(found.sure.values()) < _SURE):
        n = len(frames)
        later = None if progress is None else lambda done, _: progress(n + done, 2 * n)
        other = _find(replace(looks, yellow=True), rig, groups, paws, later)
        both = [one for one in (found, other) if one is not None]
        found = max(both, key=lambda one: _score(one.sure.values()), default=None)
    if found is None:
        raise InputError(
            "no paws were found: too few spots stand out where the views agree; click the points "
            "instead."
        )
    return found


@dataclass(frozen=True)
class _Looks:
    """Frames to look through, and by which likeness."""

    views: Views
    frames: Sequence[int]
    yellow: bool = False

    def has_colour(self) -> bool:
        """Tell whether any view has colours."""
        pictures = self.views.frame(int(self.frames[0]))
        whole = (self._whole(pictures[name], name) for name in self.views.names)
        return any(image.ndim == 3 and has_colour(image) for image in whole)

    def likeness(self, picture: Picture, name: str) -> np.ndarray:
        """Return the likeness of the whole picture of a view."""
        width = self.views.readers[name].width
        return paw_likeness(self._whole(picture, name), PAW_SHARE * width, yellow=self.yellow)

    def _whole(self, picture: Picture, name: str) -> np.ndarray:
        """Return the whole picture of a view."""
        reader = self.views.readers[name]
        return np.asarray(picture.crop(0, 0, reader.width, reader.height))


def _find(
    looks: _Looks,
    rig: Rig,
    groups: Mapping[tuple[str, ...], list[str]],
    paws: Sequence[_Paw],
    progress: Callable[[int, int], None] | None,
) -> FoundPaws | None:
    """Find the paws by one likeness; None where too few spots stand out."""
    views = looks.views
    seen = _look_through(looks, progress)
    paw_px = {name: PAW_SHARE * views.readers[name].width for name in views.names}
    places: dict[int, list[Places]] = {}
    for frame, blobs in seen.items():
        places[frame] = [
            pair_blobs(rig, {name: blobs[name] for name in names}, paw_px=paw_px)
            for names in groups.values()
        ]
    stage = find_stage(join([part for parts in places.values() for part in parts]), rig)
    if stage is None:
        return None
    for frame, parts in places.items():
        for number, names in enumerate(groups.values()):
            if len(names) == 1:
                parts[number] = on_ground(rig, names[0], seen[frame][names[0]], stage=stage)
    chosen = {frame: _choose(parts, paws, stage) for frame, parts in places.items()}
    order = sorted(chosen, key=lambda frame: (-_frame_score(chosen[frame], paws), frame))
    found = [
        _measure(frame, chosen[frame], looks=looks, rig=rig, groups=groups, paws=paws, stage=stage)
        for frame in order[:_TRIED]
    ]
    return max(found, key=lambda one: (_score(one.sure.values()), -one.frame))


def _groups(points_by_view: Mapping[str, Sequence[str]]) -> dict[tuple[str, ...], list[str]]:
    """Return the views that track the same points, by these points."""
    groups: dict[tuple[str, ...], list[str]] = {}
    for view, points in points_by_view.items():
        groups.setdefault(tuple(sorted(points)), []).append(view)
    return groups


def _wanted(groups: Mapping[tuple[str, ...], list[str]]) -> list[_Paw]:
    """Return every point that is looked for, once for each group that tracks it."""
    wanted = []
    for number, points in enumerate(groups):
        for point in points:
            if point not in ("FR", "HR", "FL", "HL"):
                raise InputError(
                    f"only the paws FR, HR, FL and HL can be proposed; found point {point!r}: "
                    "click the points instead."
                )
            side = 1 if point.endswith("R") else -1
            wanted.append(_Paw(point, number, side, point.startswith("F")))
    return wanted


def _look_through(
    looks: _Looks, progress: Callable[[int, int], None] | None
) -> dict[int, dict[str, Blobs]]:
    """Find the spots of every view in some frames."""
    views, still = looks.views, _still(looks)
    seen = {}
    for done, number in enumerate(looks.frames, 1):
        pictures = views.frame(int(number))
        seen[int(number)] = {
            name: find_blobs(
                looks.likeness(pictures[name], name),
                PAW_SHARE * views.readers[name].width,
                still=still[name],
            )
            for name in views.names
        }
        if progress is not None:
            progress(done, len(looks.frames))
    return seen


def _still(looks: _Looks) -> Mapping[str, np.ndarray | None]:
    """Return how paw-like each place is most of the time: what stays there is no paw."""
    views, frames = looks.views, looks.frames
    if len(frames) < _STILL_FRAMES:
        return dict.fromkeys(views.names)
    kept: dict[str, list[np.ndarray]] = {name: [] for name in views.names}
    for at in np.linspace(0, len(frames) - 1, _STILL_FRAMES).round():
        pictures = views.frame(int(frames[int(at)]))
        for name in views.names:
            kept[name].append(looks.likeness(pictures[name], name).astype(np.float32))
    return {name: np.maximum(np.median(shown, axis=0), 0.0) for name, shown in kept.items()}


def _choose(
    parts: Sequence[Places], paws: Sequence[_Paw], stage: Stage
) -> dict[_Paw, tuple[np.ndarray, float]]:
    """Choose a place for each paw in one frame: (xyz, how sure)."""
    chosen = {}
    for group, side in dict.fromkeys((paw.group, paw.side) for paw in paws):
        pair = {paw.is_front: paw for paw in paws if (paw.group, paw.side) == (group, side)}
        places = parts[group]
        scores = {is_front: _rate(places, stage, side, is_front) for is_front in pair}
        if len(pair) == 2:
            along = places.xyz @ stage.axes[0]
            apart = (along[:, None] - along[None]) / stage.span
            both = np.minimum(scores[True][:, None], scores[False][None])
            # paws that touch each other hide each other
            clear = np.where(apart < _APART, 0.0, 1.0 - np.exp(-0.5 * (apart / _CLEAR) ** 2))
            both = both * clear
            # of two equal pairs, the one whose better paw is better
            total = both + 1e-3 * (scores[True][:, None] + scores[False][None]) * (both > 0)
            if not total.size or total.max() <= 0:
                continue
            at = np.unravel_index(int(total.argmax()), total.shape)
            best, seen = {True: int(at[0]), False: int(at[1])}, float(clear[at])
        else:
            seen = 1.0
            best = {k: int(score.argmax()) for k, score in scores.items() if len(score)}
        for is_front, k in best.items():
            chosen[pair[is_front]] = (places.xyz[k], seen * float(scores[is_front][k]))
    return _each_its_own(chosen, stage)


def _each_its_own(
    chosen: dict[_Paw, tuple[np.ndarray, float]], stage: Stage
) -> dict[_Paw, tuple[np.ndarray, float]]:
    """Leave out paws whose place is that of another paw that fits it better."""
    kept: dict[_Paw, tuple[np.ndarray, float]] = {}
    for paw, (xyz, score) in sorted(chosen.items(), key=lambda item: -item[1][1]):
        others = [place for other, (place, _) in kept.items() if other.point != paw.point]
        if all(np.linalg.norm(xyz - place) >= _SAME * stage.span for place in others):
            kept[paw] = (xyz, score)
    return kept


def _rate(places: Places, stage: Stage, side: int, is_front: bool) -> np.ndarray:
    """Return how well each place fits a paw, 0 to 1."""
    along, aside, height = (places.xyz @ stage.axes.T).T
    span = stage.span
    above = (height - stage.ground) / span
    fits = np.exp(-0.5 * (above / np.where(above > 0, _ABOVE_SD, _BELOW_SD)) ** 2)
    off = (along - (stage.front if is_front else stage.hind)) / (_ALONG_SD * span)
    fits *= np.exp(-0.5 * off**2)
    outward = side * (aside - stage.middle) / span
    fits *= np.exp(-0.5 * ((outward - _ASIDE) / _ASIDE_SD) ** 2)
    views = np.where(
        np.isnan(places.residual),
        _ONE_VIEW,
        np.exp(-0.5 * (np.nan_to_num(places.residual) / _RESIDUAL_SD) ** 2),
    )
    return fits * views * np.sqrt(np.clip(places.strength, 0.0, 1.0))


def _frame_score(chosen: Mapping[_Paw, tuple[np.ndarray, float]], paws: Sequence[_Paw]) -> float:
    """Return how good a frame is: its worst paw counts most."""
    return _score([chosen[paw][1] if paw in chosen else 0.0 for paw in paws])


def _score(sure: Iterable[float]) -> float:
    """Return the least of some numbers, and a little of their mean."""
    values = np.array(list(sure))
    return float(values.min() + 0.1 * values.mean())


def _measure(
    frame: int,
    chosen: Mapping[_Paw, tuple[np.ndarray, float]],
    *,
    looks: _Looks,
    rig: Rig,
    groups: Mapping[tuple[str, ...], list[str]],
    paws: Sequence[_Paw],
    stage: Stage,
) -> FoundPaws:
    """Measure the digits of the chosen paws in every view that tracks them."""
    views, pictures = looks.views, looks.views.frame(frame)
    likeness = {
        name: looks.likeness(pictures[name], name)
        for name in dict.fromkeys(name for names in groups.values() for name in names)
    }
    members = list(groups.values())
    rows = []
    sure = {paw.point: 0.0 for paw in paws}
    for paw, (xyz, score) in chosen.items():
        names = members[paw.group]
        uv = np.array([_digits(rig, name, xyz, likeness[name], stage) for name in names])
        if len(names) > 1:
            own = rig.subset(names)
            solved = own.triangulate(uv)
            paw_px = np.mean([PAW_SHARE * views.readers[name].width for name in names])
            off = float(solved.residual_px) / paw_px / _RESIDUAL_SD
            lift = (float(solved.xyz @ stage.axes[2]) - stage.ground) / stage.span
            score *= float(np.exp(-0.5 * (off / 2.0) ** 2 - 0.5 * (lift / _LIFT_SD) ** 2))
            uv = own.project(solved.xyz)
        rows += [
            (frame, name, paw.point, round(float(u), 2), round(float(v), 2))
            for name, (u, v) in zip(names, uv, strict=True)
        ]
        sure[paw.point] = max(sure[paw.point], score)
    return FoundPaws(frame, pd.DataFrame(rows, columns=list(START_COLUMNS)), sure)


def _digits(rig: Rig, name: str, xyz: np.ndarray, likeness: np.ndarray, stage: Stage) -> np.ndarray:
    """Return the middle of the digits in one view."""
    ahead = stage.span * stage.axes[0]
    below = -stage.span * stage.axes[2]
    one = rig.subset((name,))
    here, before, under = one.project(np.stack([xyz, xyz + ahead, xyz + below]))[:, 0]
    scale = float(np.linalg.norm(before - here))
    direction = (before - here) / scale + _DOWN * (under - here) / scale
    direction /= np.linalg.norm(direction)
    return find_digits(likeness, here, direction, reach_px=_REACH * scale, pad_px=_PAD * scale)
