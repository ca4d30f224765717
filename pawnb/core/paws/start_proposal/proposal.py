"""Finding the paws without clicks: the frame and the points that a person accepts or drags.

Frames from all over the recording are looked through for places that could be paws
(:mod:`pawnb.core.paws.start_proposal.places`). In each frame, one place is chosen for each paw
(:mod:`.start_proposal.choose`). The frame is proposed whose least certain paw is most certain;
there, the middle of each paw's digits is measured in every view. Where spots of the colour of
skin make no sure paws, all is done again with red spots, then with light ones, and the surest
is taken.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from pawnb.core import dlt
from pawnb.core.paws.layout import Views
from pawnb.core.paws.start_proposal.blobs import (
    Blobs,
    Look,
    find_blobs,
    find_digits,
    paw_likeness,
    share_as_paw_like,
)
from pawnb.core.paws.start_proposal.choose import Paw, ViewGeometry, choose_places
from pawnb.core.paws.start_proposal.parameters import PAW_PROPOSAL
from pawnb.core.paws.start_proposal.places import (
    CandidatePlaces,
    Stage,
    find_stage,
    join,
    on_ground,
    pair_blobs,
)
from pawnb.core.paws.superpixels import FramePixels
from pawnb.core.pixels.grey import has_colour
from pawnb.core.rig import Rig
from pawnb.errors import InputError
from pawnb.schema import START_COLUMNS

_LOOKS_IN_TURN: tuple[Look, ...] = ("skin", "red", "light")
"""What paws are found by, one after the other until each paw is sure."""


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
    sides_known : bool
        Whether the calibration tells left from right.
    """

    frame: int
    start: pd.DataFrame
    sure: dict[str, float]
    sides_known: bool = True


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
        If a point is not one of the four paws, or no paws can be distinguished from the rest.
    """
    groups = _groups(points_by_view)
    paws = _wanted(groups)
    if not any(len(names) > 1 for names in groups.values()):
        raise InputError(
            "no point is tracked by two views; paws can be proposed only where two calibrated "
            "views see the same side: click the points instead."
        )
    looks = _Looks(views, frames)
    ways = _LOOKS_IN_TURN if looks.has_colour() else _LOOKS_IN_TURN[-1:]
    found = None
    for done, look in enumerate(ways):
        later = None if progress is None else _after(progress, done * len(frames))
        other = _find(replace(looks, look=look), rig, groups, paws, later)
        found = max((one for one in (found, other) if one is not None), key=_worth, default=None)
        if found is not None and min(found.sure.values()) >= PAW_PROPOSAL.sure:
            break
    if found is None:
        raise InputError(
            "no paws were found: too few spots stand out where the views agree; click the points "
            "instead."
        )
    return _as_sure_as_all(found, rig)


def _as_sure_as_all(found: FoundPaws, rig: Rig) -> FoundPaws:
    """Withhold paws of which most are not sure; doubt all where left and right are not known."""
    usual = float(np.median(list(found.sure.values())))
    if usual < PAW_PROPOSAL.found:
        raise InputError(
            "no frame shows the paws so clearly that they can be proposed; click the points "
            "instead."
        )
    start = found.start
    seen = [
        rig.triangulate(_in_all_views(rows, rig))
        for _, rows in start.groupby("point")
        if len(rows) > 1
    ]
    known = len(seen) > 1 and bool(
        (dlt.handedness(rig.coefs, np.stack([solved.xyz for solved in seen])) == 1).all()
    )
    most = 1.0 if known else PAW_PROPOSAL.sides_unknown
    sure = {point: min(value, most) for point, value in found.sure.items()}
    return replace(found, sure=sure, sides_known=known)


def _in_all_views(rows: pd.DataFrame, rig: Rig) -> np.ndarray:
    """Return the clicks (V, 2) of one point; NaN in views that have none."""
    uv = np.full((len(rig.names), 2), np.nan)
    for view, u, v in zip(rows["view"], rows["u"], rows["v"], strict=True):
        uv[rig.index(view)] = u, v
    return uv


def _after(progress: Callable[[int, int], None], before: int) -> Callable[[int, int], None]:
    """Return what reports progress when so many frames have been looked through before."""
    return lambda done, total: progress(before + done, before + total)


@dataclass(frozen=True)
class _Looks:
    """Frames to look through, and by which likeness."""

    views: Views
    frames: Sequence[int]
    look: Look = "skin"

    def has_colour(self) -> bool:
        """Tell whether any view has colours."""
        pictures = self.views.frame(int(self.frames[0]))
        whole = (self._whole(pictures[name], name) for name in self.views.names)
        return any(image.ndim == 3 and has_colour(image) for image in whole)

    def likeness(self, picture: FramePixels, name: str) -> np.ndarray:
        """Return the likeness of the whole picture of a view."""
        width = self.views.readers[name].width
        return paw_likeness(
            self._whole(picture, name), PAW_PROPOSAL.paw_of_width * width, look=self.look
        )

    def _whole(self, picture: FramePixels, name: str) -> np.ndarray:
        """Return the whole picture of a view."""
        reader = self.views.readers[name]
        return np.asarray(picture.crop(0, 0, reader.width, reader.height))


def _find(
    looks: _Looks,
    rig: Rig,
    groups: Mapping[tuple[str, ...], list[str]],
    paws: Sequence[Paw],
    progress: Callable[[int, int], None] | None,
) -> FoundPaws | None:
    """Find the paws by one likeness; None where too few spots stand out."""
    views = looks.views
    seen = _look_through(looks, progress)
    paw_px = {name: PAW_PROPOSAL.paw_of_width * views.readers[name].width for name in views.names}
    places: dict[int, list[CandidatePlaces]] = {}
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
    geometry = ViewGeometry(rig, list(groups.values()), paw_px)
    chosen = {
        frame: choose_places(parts, paws=paws, stage=stage, geometry=geometry)
        for frame, parts in places.items()
    }
    order = sorted(chosen, key=lambda frame: (-_frame_score(chosen[frame], paws), frame))
    found = [
        _measure(frame, chosen[frame], looks=looks, rig=rig, groups=groups, paws=paws, stage=stage)
        for frame in order[: PAW_PROPOSAL.frames_measured]
    ]
    return max(found, key=_worth)


def _groups(points_by_view: Mapping[str, Sequence[str]]) -> dict[tuple[str, ...], list[str]]:
    """Return the views that track the same points, by these points."""
    groups: dict[tuple[str, ...], list[str]] = {}
    for view, points in points_by_view.items():
        groups.setdefault(tuple(sorted(points)), []).append(view)
    return groups


def _wanted(groups: Mapping[tuple[str, ...], list[str]]) -> list[Paw]:
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
            wanted.append(Paw(point, number, side, point.startswith("F")))
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
                PAW_PROPOSAL.paw_of_width * views.readers[name].width,
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
    if len(frames) < PAW_PROPOSAL.still_frames:
        return dict.fromkeys(views.names)
    kept: dict[str, list[np.ndarray]] = {name: [] for name in views.names}
    for at in np.linspace(0, len(frames) - 1, PAW_PROPOSAL.still_frames).round():
        pictures = views.frame(int(frames[int(at)]))
        for name in views.names:
            kept[name].append(looks.likeness(pictures[name], name).astype(np.float32))
    return {name: np.maximum(np.median(shown, axis=0), 0.0) for name, shown in kept.items()}


def _frame_score(chosen: Mapping[Paw, tuple[np.ndarray, float]], paws: Sequence[Paw]) -> float:
    """Return how good a frame is: its worst paw counts most."""
    return _score([chosen[paw][1] if paw in chosen else 0.0 for paw in paws])


def _worth(found: FoundPaws) -> tuple[float, int]:
    """Return what proposals are compared by: how sure they are, then how early."""
    return _score(found.sure.values()), -found.frame


def _score(sure: Iterable[float]) -> float:
    """Return the least of some numbers, and a little of their mean."""
    values = np.array(list(sure))
    return float(values.min() + PAW_PROPOSAL.mean_share * values.mean())


def _measure(
    frame: int,
    chosen: Mapping[Paw, tuple[np.ndarray, float]],
    *,
    looks: _Looks,
    rig: Rig,
    groups: Mapping[tuple[str, ...], list[str]],
    paws: Sequence[Paw],
    stage: Stage,
) -> FoundPaws:
    """Measure the digits of the chosen paws in every view that tracks them."""
    views, pictures, p = looks.views, looks.views.frame(frame), PAW_PROPOSAL
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
            paw_px = np.mean(
                [PAW_PROPOSAL.paw_of_width * views.readers[name].width for name in names]
            )
            off = float(solved.residual_px) / paw_px / p.paw_residual_sd
            lift = (float(solved.xyz @ stage.axes[2]) - stage.ground) / stage.span
            off, lift = off / p.digits_residual, lift / p.digits_lift_sd
            score *= float(np.exp(-0.5 * off**2 - 0.5 * lift**2))
            uv = own.project(solved.xyz)
        if looks.look != "light":
            shares = [
                share_as_paw_like(likeness[name], at) for name, at in zip(names, uv, strict=True)
            ]
            score /= 1.0 + (float(np.mean(shares)) / p.rare) ** 2
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
    direction = (before - here) / scale + PAW_PROPOSAL.digits_down * (under - here) / scale
    direction /= np.linalg.norm(direction)
    reach, pad = PAW_PROPOSAL.digits_reach * scale, PAW_PROPOSAL.digits_length * scale
    return find_digits(likeness, here, direction, reach_px=reach, pad_px=pad)
