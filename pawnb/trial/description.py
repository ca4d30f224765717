"""What a trial says: who was filmed, by which views, with what calibration."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path, PurePath
from typing import Any, Literal

from pawnb.errors import InputError, did_you_mean
from pawnb.schema import check_fields
from pawnb.trial.detections import check_detections
from pawnb.trial.kinds import TRAITS, Kind

Bayer = Literal["rggb", "bggr", "grbg", "gbrg"]

_KEY_OF_CAMERAS = {".toml": "anipose", ".yaml": "opencv", ".yml": "opencv"}
"""The key of [calibration] that names a file of cameras with that ending."""


@dataclass(frozen=True, kw_only=True)
class View:
    """One view: what a tracker sees, after decode, debayer, undistort, crop, mirror.

    Parameters
    ----------
    name : str
        Name used in every table.
    video : str
        A video file, a folder of pictures, or a glob, relative to the trial's folder.
    crop : tuple of int, optional
        ``u0, v0, u1, v1`` in px of the file's picture, half open.
    mirror : bool
        Whether the picture is flipped left to right after cropping.
    bayer : str, optional
        Bayer pattern of raw pictures: rggb, bggr, grbg or gbrg.
    offset : int
        This file's frame that belongs to frame 0 of the trial.
    facing : int, optional
        +1 where the animal faces right in this picture, -1 where it faces left.
    background : str, optional
        Picture without the animal (kind ``pose``).
    background_frames : tuple of int, optional
        Half-open range of frames without the animal (kind ``pose``).
    points : tuple of str
        Points that are tracked in this view; empty means every point.

    Examples
    --------
    >>> pawnb.View(name="cam1", video="cam1.avi", crop=(0, 100, 1280, 500)).crop
    (0, 100, 1280, 500)
    """

    name: str
    video: str
    crop: tuple[int, int, int, int] | None = None
    mirror: bool = False
    bayer: Bayer | None = None
    offset: int = 0
    facing: int | None = None
    background: str | None = None
    background_frames: tuple[int, int] | None = None
    points: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        check_fields(self, where="view")
        if not self.name:
            raise InputError("the name of a view is empty; name it.")
        u0, v0, u1, v1 = self.crop or (0, 0, 1, 1)
        if not (0 <= u0 < u1 and 0 <= v0 < v1):
            raise InputError(
                f"crop is {[u0, v0, u1, v1]}; expected u0, v0, u1, v1 with u0 < u1 and v0 < v1, "
                f"half open{_other_corner(u0, v0, u1, v1)}."
            )
        if self.facing not in (None, 1, -1):
            raise InputError(f"facing is {self.facing}; expected 1 (right) or -1 (left).")
        _check_range(self.background_frames, "background_frames")
        _check_unique(self.points, f"points of view {self.name!r}")


@dataclass(frozen=True, kw_only=True)
class Calibration:
    """How pixels become real units; the files are relative to the trial's folder.

    Parameters
    ----------
    dlt : str, optional
        ``DLTcoefs.csv``: 11 rows, one column a view.
    px_per_unit : float, optional
        Scale of a single view, px per unit.
    unit : str
        Name of the unit of length.
    forward, up : tuple of float
        Unit vectors in calibrated space.
    anipose, opencv : str, optional
        Instead of ``dlt`` and ``lens``: ``calibration.toml`` of Anipose or Pose2Sim, or
        ``cameras.yaml`` of OpenCV, whose cameras are called as the views are.
    lens : str, optional
        ``lenses.toml`` with matrix and distortion of each view.
    pixels : {"view", "file"}
        Whether the coefficients belong to the resulting view or to the whole picture.
    v : {"down", "up"}
        Direction of v for which the coefficients were made.

    Examples
    --------
    >>> pawnb.Calibration(dlt="DLTcoefs.csv").unit
    'mm'
    """

    dlt: str | None = None
    px_per_unit: float | None = None
    unit: str = "mm"
    forward: tuple[float, float, float] = (1.0, 0.0, 0.0)
    up: tuple[float, float, float] = (0.0, 0.0, 1.0)
    anipose: str | None = None
    opencv: str | None = None
    lens: str | None = None
    pixels: Literal["view", "file"] = "view"
    v: Literal["down", "up"] = "down"

    def __post_init__(self) -> None:
        check_fields(self, where="calibration")
        if self.px_per_unit is not None and self.px_per_unit <= 0:
            raise InputError(f"px_per_unit is {self.px_per_unit}; expected above 0.")
        named = [
            n for n in ("dlt", "px_per_unit", "anipose", "opencv") if getattr(self, n) is not None
        ]
        if len(named) > 1:
            raise InputError(f"has both {named[0]} and {named[1]}; keep the one that is meant.")
        if self.cameras is not None and self.lens is not None:
            raise InputError(f"has lens, and {named[0]} says the lenses too; leave lens out.")
        program = _KEY_OF_CAMERAS.get(PurePath(self.dlt or "").suffix.lower())
        if program is not None:
            raise InputError(
                f"dlt names {self.dlt}; expected a csv of 11 rows. A calibration of another "
                f'program is named by {program} = "{self.dlt}" instead of dlt and lens.'
            )
        object.__setattr__(self, "forward", _unit_vector(self.forward, "forward"))
        object.__setattr__(self, "up", _unit_vector(self.up, "up"))

    @property
    def cameras(self) -> str | None:
        """The file of another program's calibrated cameras, if one is named."""
        return self.anipose or self.opencv

    @property
    def of_views(self) -> str | None:
        """The file that says how the views lie in space: coefficients, or cameras."""
        return self.dlt or self.cameras


@dataclass(frozen=True, kw_only=True)
class Animal:
    """Who was filmed.

    Parameters
    ----------
    id : str
        The animal's id; strides of one animal are pooled under it.
    species : str, optional
        ``mouse``, a built-in species, or the path of a species file.
    group : str, optional
        Experimental group.
    body : tuple of str
        Points of the body, rear to front, that give origin and heading.
    across : tuple of str
        A point at the animal's left and its fellow at the right, such as the ears, that give
        the body's roll.
    extra : mapping
        Any further fields of the section, such as ``mass_g``.

    Examples
    --------
    >>> pawnb.Animal(id="m07", group="control", body=("tail_base", "nose")).group
    'control'
    """

    id: str
    species: str | None = None
    group: str | None = None
    body: tuple[str, ...] = ()
    across: tuple[str, ...] = ()
    extra: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        check_fields(self, where="animal")
        if len(self.across) not in (0, 2):
            raise InputError(
                f"across names {len(self.across)} points; expected two, at the left and at the "
                'right, for instance across = ["ear_L", "ear_R"].'
            )
        _check_unique(self.body, "body")
        _check_unique(self.across, "across")


@dataclass(frozen=True, kw_only=True)
class Trial:
    """One recording of one animal: everything ``trial.toml`` says.

    Parameters
    ----------
    kind : {"paws", "pose", "tracks"}
        Points in one or more views, a jointed animal, or tracks made elsewhere.
    name : str
        Name used in every table.
    fps : float
        Frames per second of the recording (not of its play-back).
    animal : Animal
        Who was filmed.
    folder : Path
        Folder that the paths are relative to.
    frames : tuple of int, optional
        Half-open range of frames to use.
    belt_speed : float or str, optional
        Treadmill speed in unit / s, or a csv with columns frame, speed.
    views : tuple of View
        The views, in the order of the DLT columns.
    calibration : Calibration, optional
        None where nothing is calibrated.
    start_points, start_pose : str, optional
        Files with the clicked start.
    tracks_file : str, optional
        Tracks made elsewhere (kind ``tracks``).
    tracks_of_views : mapping
        View to its file of tracks, where each view has one of its own.
    tracks_legs : mapping
        Leg names to the names of points in that file.
    tracking : mapping
        Settings of the tracker.
    detections : mapping
        View to a file of another program's predictions, taken as evidence (kind ``paws``).
    detections_points : mapping
        Names of points in those files to the trial's own, where they differ.
    point_tracker : str, optional
        File with the weights of BootsTAPIR, whose paths are taken as evidence (kind ``paws``).
    gait : mapping
        Settings of the gait analysis.

    Examples
    --------
    >>> views = tuple(pawnb.View(name=name, video=f"{name}.avi") for name in ("cam1", "cam2"))
    >>> trial = pawnb.Trial(
    ...     kind="paws", name="m07-35cms-03", fps=250.0, animal=pawnb.Animal(id="m07"), views=views,
    ...     belt_speed=350.0, calibration=pawnb.Calibration(dlt="DLTcoefs.csv"),
    ... )
    >>> [view.name for view in trial.views]
    ['cam1', 'cam2']
    """

    kind: Kind
    name: str
    fps: float
    animal: Animal
    folder: Path = field(default_factory=Path)
    frames: tuple[int, int] | None = None
    belt_speed: float | str | None = None
    views: tuple[View, ...] = ()
    calibration: Calibration | None = None
    start_points: str | None = None
    start_pose: str | None = None
    tracks_file: str | None = None
    tracks_of_views: Mapping[str, str] = field(default_factory=dict)
    tracks_legs: Mapping[str, str] = field(default_factory=dict)
    tracking: Mapping[str, Any] = field(default_factory=dict)
    detections: Mapping[str, str] = field(default_factory=dict)
    detections_points: Mapping[str, str] = field(default_factory=dict)
    point_tracker: str | None = None
    gait: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        check_fields(self, where="trial")
        if self.fps <= 0:
            raise InputError(f"[trial] fps is {self.fps}; expected a number above 0.")
        _check_range(self.frames, "[trial] frames")
        _check_unique([view.name for view in self.views], "views")
        named = "detections" if self.detections else "point_tracker" if self.point_tracker else ""
        if named and not TRAITS[self.kind].takes_detections:
            taken = " or ".join(repr(kind) for kind, own in TRAITS.items() if own.takes_detections)
            raise InputError(
                f"[tracking] {named} is for a trial of kind {taken}, and the kind is "
                f"{self.kind!r}; leave it out."
            )
        check_detections(self.detections, [view.name for view in self.views])
        if self.views and self.tracks_of_views:
            names = [view.name for view in self.views]
            for name in self.tracks_of_views:
                if name not in names:
                    raise InputError(
                        f"[tracks] file names view {name!r}{did_you_mean(name, names)}; the views "
                        f"are {', '.join(names)}."
                    )

    def view(self, name: str) -> View:
        """Return the view of that name; raises InputError if there is none."""
        for view in self.views:
            if view.name == name:
                return view
        names = [v.name for v in self.views]
        raise InputError(
            f"trial {self.name!r} has no view {name!r}{did_you_mean(name, names)}; "
            f"its views are {', '.join(names)}."
        )

    @property
    def is_tracked_elsewhere(self) -> bool:
        """Whether another program has tracked it: it names files of tracks, not a recording."""
        return not TRAITS[self.kind].has_recording

    @property
    def is_jointed(self) -> bool:
        """Whether a jointed animal is posed in it, of which the species tells; else points."""
        return TRAITS[self.kind].is_jointed

    def must_be(self, *kinds: str, or_else: str) -> None:
        """Refuse what only trials of other kinds are for.

        Parameters
        ----------
        *kinds : str
            The kinds that are fit for it.
        or_else : str
            What the sentence says after the kind of this trial.

        Raises
        ------
        InputError
            If this trial is of none of these kinds.
        """
        if self.kind not in kinds:
            raise InputError(f"trial {self.name!r} is of kind {self.kind!r}{or_else}")

    @property
    def track_files(self) -> tuple[str, ...]:
        """Every file of tracks that was made elsewhere."""
        return tuple(name for name in (self.tracks_file, *self.tracks_of_views.values()) if name)

    def start_file(self) -> str | None:
        """Return the csv of start clicks: the one named, else ``start.csv`` where it exists."""
        if self.start_points is None and self.path("start.csv").exists():
            return "start.csv"
        return self.start_points

    def start_pose_file(self) -> str | None:
        """Return the csv of the start pose: the one named, else ``start_pose.csv`` if there.

        Trials of another kind have none unless they name it.
        """
        there = self.is_jointed and self.path("start_pose.csv").exists()
        return "start_pose.csv" if self.start_pose is None and there else self.start_pose

    def path(self, relative: str) -> Path:
        """Return a path of the trial as a path that can be opened."""
        return self.folder / relative


def _check_range(span: tuple[int, int] | None, what: str) -> None:
    """Refuse a half-open range that holds no frame."""
    if span is not None and not 0 <= span[0] < span[1]:
        raise InputError(
            f"{what} is {list(span)}; expected first and one past last, for instance [0, 1000]."
        )


def _check_unique(names: Sequence[str], what: str) -> None:
    """Refuse a name that is there twice."""
    twice = next((name for i, name in enumerate(names) if name in names[:i]), None)
    if twice is not None:
        raise InputError(f"{what}: the name {twice!r} is there twice; give each its own.")


def _other_corner(u0: int, v0: int, width: int, height: int) -> str:
    """Say how a crop is written that was perhaps given by its width and height."""
    if min(u0, v0) < 0 or min(width, height) < 1:
        return ""
    corners = [u0, v0, u0 + width, v0 + height]
    return f"; if {width} and {height} are its width and height, write {corners}"


def _unit_vector(vector: tuple[float, float, float], what: str) -> tuple[float, float, float]:
    """Return the direction with length 1, or say that it has none."""
    length = math.hypot(*vector)
    if not (math.isfinite(length) and length > 0):
        raise InputError(f"{what} is {list(vector)}; expected a direction that is not zero.")
    x, y, z = vector
    return vector if abs(length - 1) < 1e-15 else (x / length, y / length, z / length)
