"""A new trial by questions in a terminal: ``pawnb new``."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from pawnb.core.video.doubts.one_film import tell_same_films
from pawnb.errors import InputError
from pawnb.workflow.workbench.animals import ANIMALS, choose_animal
from pawnb.workflow.workbench.film_alignment import tell_alignment
from pawnb.workflow.workbench.new_trial import NewTrial, NewView, new_trial, part_of_frames

T = TypeVar("T")
Ask = Callable[[str], str]
Say = Callable[[str], None]


class _Questions:
    """Asks, and asks again where an answer makes no sense."""

    def __init__(self, ask: Ask, say: Say) -> None:
        self._ask, self._say = ask, say

    def __call__(
        self, question: str, take: Callable[[str], T], *, default: str = "", may_end: bool = False
    ) -> T:
        """Return what an answer means; Enter takes the default, as the end does where it may."""
        shown = f"{question} [{default}]: " if default else f"{question}: "
        while True:
            try:
                answer = self._ask(shown).strip()
            except EOFError:
                if may_end:
                    return take(default)
                raise InputError(
                    f"no answer to {question!r}, so nothing was written; answer every question, "
                    "or write trial.toml by hand (docs/guide/trial.md)."
                ) from None
            try:
                return take(answer or default)
            except InputError as error:
                self._say(f"  {error}")

    def say(self, text: str) -> None:
        """Say something."""
        self._say(text)


def ask_new_trial(
    videos: list[str], *, folder: str | Path | None = None, ask: Ask = input, say: Say = print
) -> Path:
    """Make a trial by questions, and write its ``trial.toml``.

    Parameters
    ----------
    videos : list of str
        The video of each view; empty: they are asked for.
    folder : str or Path, optional
        Where ``trial.toml`` is to be; default that of the first video.
    ask, say : callable
        How a line is asked for and said.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        If a video cannot be used, there is a trial already, or the answers end too early;
        nothing is written then.
    """
    put = _Questions(ask, say)
    named = tuple(videos) or put("Video files, one a view, with commas between", _some_names)
    made = new_trial(named, folder)
    notes, filmed = _look_at(made)
    say(f"A new trial in {made.path}; Enter takes what stands in [brackets].")
    for note in notes:
        say(f"  {note}")
    made.name = put("Name of the trial", str, default=made.folder.resolve().name)
    made.animal_id = put("Id of the animal", str, default=made.name)
    for i, animal in enumerate(ANIMALS, start=1):
        say(f"  {i}  {animal.name}: {animal.words}")
    made.animal = put("Which animal", choose_animal, default="1")
    if made.animal.has_points and not made.animal.points:
        made.points = put("Points to track, with commas between", _some_names)
    rate = "Frames filmed in a second (of the recording, not of its play-back)"
    made.fps = put(rate, _positive, default=filmed)
    _ask_calibration(made, put)
    made.belt_speed = put(f"Speed of the treadmill in {made.unit} a second (Enter: none)", _perhaps)
    for view in made.views:
        _ask_view(made, view, put)
    _ask_frames(made, put)
    _ask_flash(made, put)
    return made.write()


def _look_at(made: NewTrial) -> tuple[list[str], str]:
    """Refuse what cannot be used before anything is asked; return what is known of the videos.

    The second is the rate at which the camera says that it filmed; empty where it says none.
    """
    if made.folder.is_dir() and not os.access(made.folder, os.W_OK):
        raise InputError(
            f"{made.folder}: nothing can be written in this folder; name another for trial.toml "
            "with --out."
        )
    with made.open_whole() as views:
        notes = [note for reader in views.readers.values() for note in reader.source.notes]
        notes += [f"{text}." for text in tell_same_films(views)]
        rates = [reader.source.filmed_fps for reader in views.readers.values()]
    filmed = f"{rates[0]:g}" if rates[0] is not None else ""
    return list(dict.fromkeys(notes)), filmed


def _ask_calibration(made: NewTrial, put: _Questions) -> None:
    """Ask for the unit, and for the file of coefficients or the scale."""
    made.unit = put("Unit of length", str, default="mm")
    if len(made.views) > 1:
        found = str(made.dlt) if made.dlt is not None else ""
        more = "" if found else " (Enter: not calibrated)"
        made.dlt = put(f"File of the DLT coefficients{more}", _file_or_none, default=found)
    else:
        made.px_per_unit = put(f"Pixels in one {made.unit} (Enter: not known)", _perhaps)


def _ask_view(made: NewTrial, view: NewView, put: _Questions) -> None:
    """Ask what a view shows."""
    width, height = made.size(view)
    others = [other.name for other in made.views if other is not view]
    points = made.points_in_force

    def free_name(answer: str) -> str:
        if answer in others:
            raise InputError(f"there is another view {answer!r}; give each its own name.")
        return answer

    def known_points(answer: str) -> tuple[str, ...]:
        names = _some_names(answer)
        if odd := [name for name in names if name not in points]:
            raise InputError(f"{odd[0]!r} is none of the points {', '.join(points)}.")
        return names

    def crop(answer: str) -> tuple[int, int, int, int] | None:
        found = _crop(answer)
        if found is not None and not (found[2] <= width and found[3] <= height):
            raise InputError(f"the picture has {width} x {height} px only.")
        return found

    put.say(f"View of {view.video.name}, {width} x {height} px")
    view.name = put("  Name of the view", free_name, default=view.name)
    view.crop = put(
        "  Part of the picture: left, top, right, bottom in px (Enter: all of it)", crop
    )
    view.mirror = put("  Is it seen in a mirror (y or n)", _yes, default="n")
    if made.animal.has_points and len(made.views) > 1:
        view.points = put("  Points seen in it", known_points, default=", ".join(points))


def _ask_frames(made: NewTrial, put: _Questions) -> None:
    """Ask for the frames to use; files of answers that were written before it was asked fit."""
    with made.open_whole() as views:
        n = views.n_frames

    def part(answer: str) -> tuple[int, int] | None:
        words = answer.replace(",", " ").split()
        if words and (len(words) != 2 or not all(word.isdecimal() for word in words)):
            raise InputError("expected two whole numbers, for instance 85, 199.")
        first, last = map(int, words) if words else (None, None)
        return part_of_frames(first, last, n)

    question = f"Frames with the animal in view: first, last (Enter: all, 0 to {n - 1})"
    made.frames = put(question, part, may_end=True)


def _ask_flash(made: NewTrial, put: _Questions) -> None:
    """Ask of several films where each shows a flash; then for the frames of the aligned ones."""
    films = made.films
    if len(films) < 2:
        return
    names = [view.name for view in films.values()]
    with made.open_whole() as views:
        lengths = {
            v.name: r.n_frames for v, r in zip(made.views, views.readers.values(), strict=True)
        }

    def events(answer: str) -> list[int | None]:
        words = answer.replace(",", " ").split()
        if words and (len(words) != len(films) or not all(word.isdecimal() for word in words)):
            raise InputError(f"expected a whole number for each of {', '.join(names)}.")
        found: list[int | None] = [int(word) for word in words]
        found = found or [None] * len(films)
        for name, event in zip(names, found, strict=True):
            if event is not None and event >= lengths[name]:
                raise InputError(f"{name} has frames 0 to {lengths[name] - 1} only.")
        return found

    if text := tell_alignment(dict.fromkeys(names, 0), {name: lengths[name] for name in names}):
        put.say(text.partition(". ")[0] + ".")
    question = (
        "Frame of each film that first shows a flash, where they were not started together: "
        f"{', '.join(names)} (Enter: together)"
    )
    found = put(question, events, may_end=True)
    for view in made.views:
        view.event = found[list(films).index(view.video)]
    if any(made.offsets.values()):
        put.say("The films are aligned; frames are counted from the first that all of them have.")
        _ask_frames(made, put)


def _some_names(answer: str) -> tuple[str, ...]:
    names = tuple(name for word in answer.split(",") if (name := word.strip()))
    if not names:
        raise InputError("name at least one.")
    return names


def _positive(answer: str) -> float:
    try:
        value = float(answer.replace(",", "."))
    except ValueError:
        value = 0.0
    if not 0 < value < float("inf"):
        raise InputError(f"{answer!r} is no number above 0.")
    return value


def _perhaps(answer: str) -> float | None:
    return _positive(answer) if answer else None


def _file_or_none(answer: str) -> Path | None:
    if answer and not Path(answer).is_file():
        raise InputError(f"{answer}: no such file.")
    return Path(answer) if answer else None


def _crop(answer: str) -> tuple[int, int, int, int] | None:
    if not answer:
        return None
    words = answer.replace(",", " ").split()
    if len(words) != 4 or not all(word.isdigit() for word in words):
        raise InputError("expected four whole numbers, for instance 0, 100, 1280, 500.")
    left, top, right, bottom = map(int, words)
    if not (left < right and top < bottom):
        raise InputError("left must be less than right, and top less than bottom.")
    return left, top, right, bottom


def _yes(answer: str) -> bool:
    if answer.lower() in ("y", "yes"):
        return True
    if answer.lower() in ("n", "no"):
        return False
    raise InputError("answer y or n.")
