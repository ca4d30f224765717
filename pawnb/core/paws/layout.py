"""What stays the same while paws are tracked: which point in which view, sizes, models."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
import pandas as pd

from pawnb.arrays import BoolArray, Points2D
from pawnb.core import kalman
from pawnb.core.paws.maghsoudi2019.settings import Lengths, Maghsoudi2019Settings, lengths_in_view
from pawnb.core.paws.request import TrackingRequest
from pawnb.core.paws.superpixels import FramePixels
from pawnb.core.rig import Rig
from pawnb.errors import CalibrationError, InputError, did_you_mean
from pawnb.schema import START_COLUMNS


class Sized(Protocol):
    """What is needed of the reader of one view."""

    @property
    def width(self) -> int:
        """Width of the view's picture, px."""
        ...

    @property
    def height(self) -> int:
        """Height of the view's picture, px."""
        ...


class Views(Protocol):
    """What is needed of an opened trial: see :class:`pawnb.core.video.ViewSet`."""

    @property
    def names(self) -> Sequence[str]:
        """Names of the views."""
        ...

    @property
    def n_frames(self) -> int:
        """Frames that every view has."""
        ...

    @property
    def readers(self) -> Mapping[str, Sized]:
        """Reader of each view, with its width and height."""
        ...

    def frame(self, i: int) -> Mapping[str, FramePixels]:
        """Return frame i of every view."""
        ...

    def frames(
        self, start: int, stop: int, *, step: int = 1, partly: bool = False
    ) -> Iterator[tuple[int, Mapping[str, FramePixels]]]:
        """Go through frames of every view, as :class:`range` does; ``partly``: small parts.

        Parameters
        ----------
        start, stop, step : int
            As those of :class:`range`.
        partly : bool
            Whether only small parts of the pictures will be asked for.

        Yields
        ------
        iterator
            Frame, and the picture of each view by its name.
        """
        ...


@dataclass(frozen=True)
class Layout:
    """Which point is tracked in which view, and everything that does not change.

    V views and P points, in the order of ``views`` and ``points``.

    Parameters
    ----------
    views, points : tuple of str
        Names.
    tracked : ndarray of bool, shape (V, P)
        Which point each view tracks.
    sizes : tuple of (int, int)
        Width and height of each view, px.
    lengths : tuple of Lengths
        Lengths of the settings in the pixels of each view.
    facing : tuple of int
        +1, -1, or 0 where unknown, for each view.
    weights : tuple
        Weights of the features for each point.
    kinds : tuple of str
        ``"front"``, ``"hind"`` or ``"other"`` for each point.
    settings : Maghsoudi2019Settings
        The settings.
    rig : Rig, optional
        The calibrated views, in the order of ``views``.
    uses_space : bool
        Whether points are predicted in space; without a rig, and by method ``slic-2d``,
        each view predicts by itself.
    in_space, in_image : ConstantVelocity
        Kalman models in 3D and in a picture.
    """

    views: tuple[str, ...]
    points: tuple[str, ...]
    tracked: BoolArray
    sizes: tuple[tuple[int, int], ...]
    lengths: tuple[Lengths, ...]
    facing: tuple[int, ...]
    weights: tuple[tuple[float, ...], ...]
    kinds: tuple[str, ...]
    settings: Maghsoudi2019Settings
    rig: Rig | None
    uses_space: bool
    in_space: kalman.ConstantVelocity
    in_image: kalman.ConstantVelocity

    def contains(self, view: int, uv: Points2D) -> bool:
        """Tell whether a position lies inside the picture of a view."""
        width, height = self.sizes[view]
        return bool(-0.5 <= uv[0] < width - 0.5 and -0.5 <= uv[1] < height - 0.5)

    def only(self, which: BoolArray) -> Layout:
        """Return the layout of some of the points.

        Parameters
        ----------
        which : ndarray of bool, shape (P,)
            Those that stay.

        Returns
        -------
        Layout
            The same views, with these points.
        """

        def kept(values: Sequence[Any]) -> tuple[Any, ...]:
            return tuple(value for value, stays in zip(values, which, strict=True) if stays)

        return replace(
            self,
            points=kept(self.points),
            tracked=self.tracked[:, which],
            weights=kept(self.weights),
            kinds=kept(self.kinds),
        )


def make_layout(
    views: Views,
    start: pd.DataFrame,
    task: TrackingRequest,
    *,
    settings: Maghsoudi2019Settings,
    in_space: bool = True,
) -> Layout:
    """Work out the layout of a run from the opened views and the start clicks.

    Parameters
    ----------
    views : Views
        The opened views.
    start : DataFrame
        Clicks: frame, view, point, u, v.
    task : TrackingRequest
        What is to be tracked; the rig may hold further views.
    settings : Maghsoudi2019Settings
        The settings.
    in_space : bool
        Whether to predict in space where there is a rig.

    Returns
    -------
    Layout
        The layout.

    Raises
    ------
    InputError
        If a view or point is unknown, or a set of weights names no point.
    CalibrationError
        If the rig lacks a view.
    """
    names, points_by_view, rig = tuple(views.names), task.points_by_view, task.rig
    for name in points_by_view:
        if name not in names:
            raise InputError(
                f"points are listed for view {name!r}{did_you_mean(name, names)}; "
                f"the views are {', '.join(names)}."
            )
    clicked = list(dict.fromkeys(start["point"]))
    listed = list(dict.fromkeys(p for name in names for p in points_by_view.get(name, ())))
    everything = any(not points_by_view.get(name) for name in names)
    points = tuple(listed + [p for p in clicked if p not in listed] if everything else listed)
    for name in (*settings.front, *settings.hind):
        if name not in points:
            raise InputError(
                f"setting 'front' or 'hind' names {name!r}{did_you_mean(name, points)}; "
                f"the points are {', '.join(points)}."
            )
    sizes = tuple((views.readers[n].width, views.readers[n].height) for n in names)
    if rig is not None:
        lacking = [n for n in names if n not in rig.names]
        if lacking:
            raise CalibrationError(
                f"the calibration has no view {lacking[0]!r}{did_you_mean(lacking[0], rig.names)}; "
                f"it has {', '.join(rig.names)}."
            )
        rig = rig.subset(names)
    noise = {
        name: getattr(settings, name) for name in ("process_var", "measurement_var", "initial_var")
    }
    return Layout(
        views=names,
        points=points,
        tracked=np.array([[p in (points_by_view.get(n) or points) for p in points] for n in names]),
        sizes=sizes,
        lengths=tuple(lengths_in_view(settings, width) for width, _ in sizes),
        facing=_facings(names, points, start, rig, settings, task.facing or {}),
        weights=tuple(settings.weights(p) for p in points),
        kinds=tuple(settings.kind(p) for p in points),
        settings=settings,
        rig=rig,
        uses_space=in_space and rig is not None,
        in_space=kalman.make_model(3, **noise),
        in_image=kalman.make_model(2, **noise),
    )


def _facings(
    names: Sequence[str],
    points: Sequence[str],
    start: pd.DataFrame,
    rig: Rig | None,
    settings: Maghsoudi2019Settings,
    given: Mapping[str, int],
) -> tuple[int, ...]:
    """Say where the animal faces: as given, else by the rig, else front against hind clicks."""
    kinds = {point: settings.kind(point) for point in points}
    sides = []
    for name in names:
        if name in given:
            sides.append(int(given[name]))
            continue
        if rig is not None:
            sides.append(_facing_by_rig(rig, name))
            continue
        rows = start[start["view"] == name]
        kind = rows["point"].map(kinds)
        front, hind = (rows.loc[kind == k, "u"].mean() for k in ("front", "hind"))
        sides.append(int(np.sign(front - hind)) if np.isfinite(front - hind) else 0)
    return tuple(sides)


def _facing_by_rig(rig: Rig, name: str) -> int:
    """Say where the animal faces in a view; 0 in one that looks along its way."""
    try:
        return rig.facing(name)
    except CalibrationError:
        return 0


@dataclass(frozen=True)
class Placement:
    """A point put in place in one view and one frame, by hand or by tracks that exist.

    Parameters
    ----------
    view, point : int
        Their numbers in the layout.
    uv : ndarray, shape (2,)
        Position, px.
    origin : str
        ``"edited"`` where a person put it there.
    confidence : float
        1 where a person put it there.
    """

    view: int
    point: int
    uv: Points2D
    origin: str = "edited"
    confidence: float = 1.0


def only_points(
    placed: Mapping[int, Sequence[Placement]], which: BoolArray
) -> dict[int, list[Placement]]:
    """Return the placements of some points, numbered as in :meth:`Layout.only`.

    Parameters
    ----------
    placed : mapping
        Frame to placements.
    which : ndarray of bool, shape (P,)
        The points that stay.

    Returns
    -------
    dict
        Frame to placements, of frames that have any.
    """
    number = np.cumsum(which) - 1
    kept = {
        frame: [replace(p, point=int(number[p.point])) for p in here if which[p.point]]
        for frame, here in placed.items()
    }
    return {frame: here for frame, here in kept.items() if here}


def read_start(
    start: pd.DataFrame, layout: Layout, frames: tuple[int, int]
) -> dict[int, list[Placement]]:
    """Turn the clicks into placements by frame.

    Parameters
    ----------
    start : DataFrame
        frame, view, point, u, v.
    layout : Layout
        The layout.
    frames : tuple of int
        First frame and one past the last that are tracked.

    Returns
    -------
    dict
        Frame to placements.

    Raises
    ------
    InputError
        If a click has an unknown view or point, is outside the picture or in a frame
        that is not tracked, or is there twice.
    """
    placements: dict[int, list[Placement]] = {}
    seen: set[tuple[int, str, str]] = set()
    columns = (start[name].tolist() for name in START_COLUMNS)
    for frame, view, point, u, v_px in zip(*columns, strict=True):
        what = f"the start has point {point!r} in view {view!r} in frame {frame}"
        if view not in layout.views:
            raise InputError(
                f"{what}, but there is no such view{did_you_mean(view, layout.views)}; "
                f"the views are {', '.join(layout.views)}."
            )
        v = layout.views.index(view)
        if point not in layout.points or not layout.tracked[v, layout.points.index(point)]:
            here = [p for i, p in enumerate(layout.points) if layout.tracked[v, i]]
            raise InputError(
                f"{what}, but that view does not track it{did_you_mean(point, here)}; "
                f"it tracks {', '.join(here)}."
            )
        if not frames[0] <= frame < frames[1]:
            raise InputError(
                f"{what}, but frames {frames[0]} to {frames[1] - 1} are tracked; "
                "click in one of those or track others."
            )
        uv = np.array([u, v_px], dtype=float)
        if not np.isfinite(uv).all() or not layout.contains(v, uv):
            width, height = layout.sizes[v]
            raise InputError(
                f"{what} at ({u}, {v_px}), outside its picture of {width} x {height} px; "
                "click inside it."
            )
        if (frame, view, point) in seen:
            raise InputError(f"{what} twice; keep one click.")
        seen.add((frame, view, point))
        placements.setdefault(frame, []).append(Placement(v, layout.points.index(point), uv))
    return placements


def check_every_point_started(start: pd.DataFrame, layout: Layout) -> None:
    """Raise InputError if a point is clicked in no view."""
    clicked = set(start["point"])
    lacking = [point for point in layout.points if point not in clicked]
    if lacking:
        raise InputError(
            f"point {lacking[0]!r} is clicked in no view; "
            "click it in at least one view of a start frame."
        )
