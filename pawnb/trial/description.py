"""What a trial says: who was filmed, by which views, with what calibration."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from pawnb.errors import InputError, did_you_mean

Kind = Literal["paws", "pose", "tracks"]
Bayer = Literal["rggb", "bggr", "grbg", "gbrg"]


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
    lens : str, optional
        ``lenses.toml`` with matrix and distortion of each view.
    pixels : {"view", "file"}
        Whether the coefficients belong to the resulting view or to the whole picture.
    v : {"down", "up"}
        Direction of v for which the coefficients were made.
    """

    dlt: str | None = None
    px_per_unit: float | None = None
    unit: str = "mm"
    forward: tuple[float, float, float] = (1.0, 0.0, 0.0)
    up: tuple[float, float, float] = (0.0, 0.0, 1.0)
    lens: str | None = None
    pixels: Literal["view", "file"] = "view"
    v: Literal["down", "up"] = "down"


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
    """

    id: str
    species: str | None = None
    group: str | None = None
    body: tuple[str, ...] = ()
    across: tuple[str, ...] = ()
    extra: Mapping[str, Any] = field(default_factory=dict)


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
    tracks_legs : mapping
        Leg names to the names of points in that file.
    tracking : mapping
        Settings of the tracker.
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
    tracks_legs: Mapping[str, str] = field(default_factory=dict)
    tracking: Mapping[str, Any] = field(default_factory=dict)

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

    def start_file(self) -> str | None:
        """Return the csv of start clicks: the one named, else ``start.csv`` where it exists."""
        if self.start_points is None and self.path("start.csv").is_file():
            return "start.csv"
        return self.start_points

    def start_pose_file(self) -> str | None:
        """Return the csv of the start pose: the one named, else ``start_pose.csv`` if there.

        Trials of another kind have none unless they name it.
        """
        there = self.kind == "pose" and self.path("start_pose.csv").is_file()
        return "start_pose.csv" if self.start_pose is None and there else self.start_pose

    def path(self, relative: str) -> Path:
        """Return a path of the trial as a path that can be opened."""
        return self.folder / relative
