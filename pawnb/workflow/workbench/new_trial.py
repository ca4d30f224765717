"""A trial made from bare videos: what is asked for, checked as it is given, then written once."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from pawnb.core.video import ViewSet, open_views
from pawnb.errors import InputError
from pawnb.files import parse_toml, write_new
from pawnb.trial import (
    Animal,
    Calibration,
    Trial,
    View,
    trial_document,
    trial_from_document,
)
from pawnb.workflow.tracking.trial_views import trial_rig
from pawnb.workflow.workbench.animals import ANIMALS, AnimalChoice
from pawnb.workflow.workbench.film_alignment import offsets_by_event

_TRIAL_HEAD = (
    "# One recording of one animal. What each line means: docs/guide/trial.md of pawnb.\n"
    "# pawnb check on this folder says what is missing or looks wrong.\n"
)


@dataclass
class NewView:
    """One view of a new trial.

    Parameters
    ----------
    video : Path
        Its file.
    name : str
        What it is called.
    crop : tuple of int, optional
        u0, v0, u1, v1 in px of the file's picture, half open.
    mirror : bool
        Whether the picture is flipped left to right.
    points : tuple of str
        The points seen in it; empty means every point.
    event : int, optional
        Frame of its file that first shows a flash, or another event that every film shows, where
        these were not started together.
    """

    video: Path
    name: str
    crop: tuple[int, int, int, int] | None = None
    mirror: bool = False
    points: tuple[str, ...] = ()
    event: int | None = None


@dataclass
class NewTrial:
    """What is known of a new trial so far; works without a browser and without a terminal.

    Parameters
    ----------
    views : list of NewView
        The views.
    folder : Path
        Where ``trial.toml`` is to be.
    name : str
        Name of the trial; empty: that of its folder.
    fps : float, optional
        Frames per second of the recording.
    animal : AnimalChoice
        The animal.
    animal_id : str
        Which one.
    points : tuple of str
        Points to track, where the animal is not of the list.
    unit : str
        Unit of length.
    dlt : Path, optional
        DLT coefficients of the views.
    px_per_unit : float, optional
        Scale of a single view.
    belt_speed : float, optional
        Speed of the treadmill, unit / s.
    frames : tuple of int, optional
        First frame to use and one past the last; all of them by default.
    """

    views: list[NewView]
    folder: Path
    name: str = ""
    fps: float | None = None
    animal: AnimalChoice = ANIMALS[0]
    animal_id: str = ""
    points: tuple[str, ...] = ()
    unit: str = "mm"
    dlt: Path | None = None
    px_per_unit: float | None = None
    belt_speed: float | None = None
    frames: tuple[int, int] | None = None
    _sizes: dict[Path, tuple[int, int]] = field(default_factory=dict, repr=False)

    @property
    def path(self) -> Path:
        """The file to write."""
        return self.folder / "trial.toml"

    @property
    def points_in_force(self) -> tuple[str, ...]:
        """The points to track: those of the animal, or those that were named."""
        return self.animal.points or self.points

    @property
    def films(self) -> dict[Path, NewView]:
        """The first view of each film."""
        found: dict[Path, NewView] = {}
        for view in self.views:
            found.setdefault(view.video, view)
        return found

    @property
    def offsets(self) -> dict[Path, int]:
        """Frame of each film that belongs to frame 0; raises InputError as offsets_by_event."""
        films = self.films
        names, events = [v.name for v in films.values()], [v.event for v in films.values()]
        first = not self.animal.has_points
        return dict(zip(films, offsets_by_event(names, events, from_first=first), strict=True))

    @property
    def offsets_so_far(self) -> dict[Path, int]:
        """The same; as if all began together until the event is marked in every film."""
        try:
            return self.offsets
        except InputError:
            return dict.fromkeys(self.films, 0)

    def check_free(self) -> None:
        """Raise InputError where there is a trial already: it is never written over."""
        if self.path.exists():
            raise InputError(
                f"{self.path}: there is a trial already, and it is left as it is; edit it, or "
                "choose another folder."
            )

    def trial(self) -> Trial:
        """Return the trial as it would be written.

        Returns
        -------
        Trial
            The checked description.

        Raises
        ------
        InputError
            If something is missing or makes no sense.
        """
        if self.fps is None:
            raise InputError("how many frames were filmed in a second is not said yet.")
        if self.animal.has_points and not self.points_in_force:
            raise InputError("no point to track is named; name them, with commas between.")
        if self.dlt is not None and self.px_per_unit is not None:
            raise InputError("a trial has DLT coefficients or a scale, not both; leave one out.")
        if self.px_per_unit is not None and len(self.views) > 1:
            raise InputError("a scale in px is that of a single view; give DLT coefficients.")
        calibration = None
        # a unit is not lost where the views are calibrated later
        if self.dlt is not None or self.px_per_unit is not None or self.unit != Calibration().unit:
            dlt = None if self.dlt is None else self._relative(self.dlt)
            calibration = Calibration(dlt=dlt, px_per_unit=self.px_per_unit, unit=self.unit)
        name, offsets = self.name or self.folder.resolve().name, self.offsets
        return Trial(
            kind=self.animal.kind,
            name=name,
            fps=float(self.fps),
            animal=Animal(id=self.animal_id or name, species=self.animal.species),
            views=tuple(self._view(view, offsets[view.video]) for view in self.views),
            calibration=calibration,
            belt_speed=self.belt_speed,
            frames=self.frames,
            folder=self.folder,
        )

    def write(self) -> Path:
        """Write ``trial.toml``; returns the file.

        Raises
        ------
        InputError
            If something is missing, the videos cannot be opened that way, or there is a trial
            already.
        """
        trial = self.trial()
        self.check_free()
        with open_views(trial) as views:  # a crop beyond the picture is found here,
            trial_rig(trial, views)  # and coefficients of more or fewer views
        text = _TRIAL_HEAD + toml_of(trial)
        read = trial_from_document(
            parse_toml(text, where=str(self.path)), where=str(self.path), folder=self.folder
        )
        if read != trial:
            raise InputError(f"{self.path}: would not be read as it was meant; report this.")
        self.folder.mkdir(parents=True, exist_ok=True)
        try:
            write_new(self.path, text.encode())
        except FileExistsError:
            self.check_free()
        return self.path

    def size(self, view: NewView) -> tuple[int, int]:
        """Return width and height of a view's whole picture, px; raises InputError as opening."""
        if view.video not in self._sizes:
            with self.open_whole() as views:
                for own, reader in zip(self.views, views.readers.values(), strict=True):
                    self._sizes[own.video] = (reader.source.width, reader.source.height)
        return self._sizes[view.video]

    def open_whole(self) -> ViewSet:
        """Return the videos without crop and mirror, aligned, one view each, open."""
        offsets = self.offsets_so_far
        whole = [
            View(name=v.name, video=self._relative(v.video), offset=offsets[v.video])
            for v in self.views
        ]
        return open_views(
            Trial(
                kind="paws", name="new", fps=self.fps or 1.0, animal=Animal(id="new"),
                views=tuple(whole), folder=self.folder,
            )
        )  # fmt: skip

    def _view(self, view: NewView, offset: int) -> View:
        """Return a view as a trial says it."""
        points = view.points or (self.points_in_force if self.animal.has_points else ())
        odd = [point for point in points if point not in self.points_in_force]
        if odd and self.animal.has_points:
            raise InputError(
                f"view {view.name!r} sees {odd[0]!r}, which is none of the points "
                f"{', '.join(self.points_in_force)}."
            )
        return View(
            name=view.name, video=self._relative(view.video), crop=view.crop, mirror=view.mirror,
            offset=offset, points=points,
        )  # fmt: skip

    def _relative(self, path: Path) -> str:
        """Return a path relative to the trial's folder where that can be said."""
        try:
            return Path(os.path.relpath(path, self.folder)).as_posix()
        except ValueError:  # on another drive
            return path.resolve().as_posix()


def new_trial(videos: Sequence[str | Path], folder: str | Path | None = None) -> NewTrial:
    """Begin a trial of some videos.

    Parameters
    ----------
    videos : sequence of str or Path
        Video files, or folders of pictures, one a view.
    folder : str or Path, optional
        Where ``trial.toml`` is to be; default that of the first video.

    Returns
    -------
    NewTrial
        Its views, each called after its file, with the DLT coefficients that lie beside it.

    Raises
    ------
    InputError
        If there is no video, one is not there, or the folder has a trial already.
    """
    paths = [Path(video) for video in videos]
    if not paths:
        raise InputError("no video; name the file of each view.")
    for path in paths:
        if not path.exists():
            raise InputError(f"{path}: no such video.")
    home = Path(folder) if folder is not None else paths[0].parent
    names: list[str] = []
    for path in paths:
        stem = re.sub(r"\s+", "_", path.stem) or "view"
        same = [name for name in names if name == stem or name.startswith(f"{stem}-")]
        names.append(stem if not same else f"{stem}-{len(same) + 1}")
    made = NewTrial([NewView(p, n) for p, n in zip(paths, names, strict=True)], home)
    made.check_free()
    if len(paths) > 1 and (home / "DLTcoefs.csv").exists():
        made.dlt = home / "DLTcoefs.csv"
    return made


def part_of_frames(first: int | None, last: int | None, n: int) -> tuple[int, int] | None:
    """Return the frames to use as a trial says them.

    Parameters
    ----------
    first, last : int or None
        The first and the last frame to use; None for that of the recording.
    n : int
        Number of frames of the recording.

    Returns
    -------
    tuple of int or None
        The first and one past the last; None where that is the whole recording.

    Raises
    ------
    InputError
        If they are not two frames of the recording, the first before the last.
    """
    begin, end = 0 if first is None else first, n if last is None else last + 1
    if not 0 <= begin < end - 1 <= n - 1:
        raise InputError(
            f"frames {begin} to {end - 1} are to be used; expected two of frames 0 to {n - 1}, "
            "the first before the last."
        )
    return None if (begin, end) == (0, n) else (begin, end)


def second_view(view: NewView, taken: Sequence[str]) -> NewView:
    """Return another view of the same video, as of a mirror in the picture.

    Parameters
    ----------
    view : NewView
        The view there is.
    taken : sequence of str
        Names that are taken.

    Returns
    -------
    NewView
        The other one.
    """
    k = next(k for k in range(2, len(taken) + 3) if f"{view.name}-{k}" not in taken)
    return replace(view, name=f"{view.name}-{k}", crop=None, mirror=False, points=())


def toml_of(trial: Trial) -> str:
    """Return a trial as TOML that a person likes to read: one field a line, lists on one line.

    Parameters
    ----------
    trial : Trial
        The trial.

    Returns
    -------
    str
        The text of ``trial.toml``.
    """
    lines: list[str] = []
    for name, section in trial_document(trial).items():
        for part in section if isinstance(section, list) else [section]:
            lines.append(f"[[{name}]]" if isinstance(section, list) else f"[{name}]")
            lines += [f"{_key(key)} = {_value(value)}" for key, value in part.items()]
            lines.append("")
    return "\n".join(lines)


def _key(key: str) -> str:
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else _value(key)


def _value(value: Any) -> str:
    """Return a plain value in TOML: JSON is that, but for tables."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{_key(k)} = {_value(v)}" for k, v in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(_value, value)) + "]"
    # DEL is the one character that JSON leaves as it is and TOML refuses
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
