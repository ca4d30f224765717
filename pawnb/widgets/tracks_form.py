"""Tracks that other programs made, in the workbench: looked at on the film, and their gait."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import ipywidgets as widgets

from pawnb.errors import InputError, PawnbError
from pawnb.widgets.track_reviewer import TrackReviewer
from pawnb.widgets.workbench_parts import ROW, Tool, cell, show_results
from pawnb.widgets.workbench_session import WorkbenchSession, described
from pawnb.workflow.reviewing.foreign import corrected_file
from pawnb.workflow.words import split_legs
from pawnb.workflow.workbench.films import film_of, first_file
from pawnb.workflow.workbench.states import TrialState


def review_on_film(
    file: Path,
    films: Sequence[str | Path],
    *,
    fps: float,
    button: Callable[..., Any],
    then: Callable[[Path], None],
    room: int,
    **which: str,
) -> Tool:
    """Open tracks of another program on their film, with a button that saves and leads on.

    Parameters
    ----------
    file : Path
        The file, or what a review made of it: corrections go on from where they were.
    films : sequence of str or Path
        The film of each view, in the order of the file.
    fps : float
        Frames a second.
    button : callable
        ``button(text, act, main=)`` gives a button.
    then : callable
        ``then(file)`` goes on with the corrected file, or with the one that was right.
    room : int
        Height for pictures, CSS px.
    **which
        ``animal``, where the file has several.

    Returns
    -------
    Tool
        The review.

    Raises
    ------
    InputError
        If the file or a film cannot be used.
    """
    first = first_file(file)
    tool = TrackReviewer.of_file(first, list(films), fps=fps, max_height=room, **which)

    def reviewed() -> None:
        if tool.corrected.corrections:
            tool.corrected.save()
        then(corrected_file(first) if tool.corrected.corrections else first)

    return Tool(tool, [button("Save, and analyse the gait", reviewed, main=True)])


def review_of_trial(state: TrialState, **how: Any) -> Tool:
    """Open the tracks of a trial of kind ``tracks`` on their films, see :func:`review_on_film`.

    Parameters
    ----------
    state : TrialState
        The trial; it has films.
    **how
        ``button``, ``then`` and ``room``.

    Returns
    -------
    Tool
        The review.
    """
    trial = described(state)
    file = trial.path(trial.track_files[0])
    return review_on_film(file, state.films, fps=trial.fps, **how)


class TracksForm(widgets.VBox):  # type: ignore[misc]
    """Gait of tracks that other programs made: they need no trial, only their frame rate.

    Where videos lie beside them, they are looked at on the film and corrected first.

    Parameters
    ----------
    files : sequence of Path
        The files there are.
    session : WorkbenchSession
        What analyses them.
    begin : callable
        ``begin(doing, work)`` does the work off this thread, and then what that gives.
    show : callable
        ``show(make)`` opens another tool instead.
    button : callable
        ``button(text, act, main=)`` gives a button, which says what is wrong where it cannot act.
    room : callable
        ``room()`` gives the height for pictures, CSS px.
    """

    def __init__(
        self,
        files: Sequence[Path],
        session: WorkbenchSession,
        *,
        begin: Callable[[str, Callable[[], Callable[[], None]]], None],
        show: Callable[[Callable[[], Any]], None],
        button: Callable[..., Any],
        room: Callable[[], int],
    ) -> None:
        self._session, self._begin, self._show = session, begin, show
        self._button, self._room = button, room
        self.files = widgets.SelectMultiple(
            options=[(path.name, str(path)) for path in files], rows=min(6, len(files)),
            value=[str(path) for path in session.one_a_recording(files)],
            layout={"width": "24em"},
        )  # fmt: skip
        self.fps = widgets.Text(placeholder="frames a second", description="filmed at")
        self.animals = widgets.Text(placeholder="m1, m1, m2: of each file", description="animals")
        self.groups = widgets.Text(placeholder="old, old, young: of each", description="groups")
        self.legs = widgets.Text(
            placeholder="where not told by name: FR=paw 1, HR=paw 2", description="legs",
            layout={"width": "30em"},
        )  # fmt: skip
        said = (
            "Each file counts as an animal of its own, unless it names its animals: where several "
            "are of one animal, name that of each file."
        )
        self.told = cell(said, None, wrap=True)
        go = self._button("Analyse the gait", self.analyse, main=True)
        rows = [[self.files, self.fps, go], *self._film_row(), [self.animals, self.groups]]
        rows[-1].append(self.legs)
        super().__init__([*(widgets.HBox(row, layout=ROW) for row in rows), self.told])

    def _film_row(self) -> list[list[Any]]:
        """Return what leads to the film, where there is one."""
        videos = self._session.films()
        self.film = widgets.SelectMultiple(
            options=[(path.name, str(path)) for path in videos], rows=min(4, max(1, len(videos))),
            layout={"width": "24em"},
        )  # fmt: skip
        self.files.observe(lambda _: self._choose_film(), names="value")
        self._choose_film()
        look = self._button("Look at the tracks on the film", self.review)
        return [[self.film, look]] if videos else []

    def _choose_film(self) -> None:
        """Choose the film of the one file that is chosen, where names tell it."""
        chosen = [Path(name) for name in self.files.value]
        film = film_of(chosen[0]) if len(chosen) == 1 else None
        self.film.value = [] if film is None else [str(film)]

    def review(self) -> None:
        """Open the tracks of one file on its film."""
        self._guarded(self._review)

    def analyse(self) -> None:
        """Analyse what is chosen, and show the results."""
        self._guarded(lambda: self._analyse([Path(name) for name in self.files.value]))

    def _guarded(self, act: Callable[[], None]) -> None:
        """Do something; say what is wrong where it cannot be done."""
        try:
            act()
        except (PawnbError, OSError) as error:
            self.told.value = str(error)

    def _analyse(self, files: Sequence[Path]) -> None:
        """Analyse files off this thread."""
        fps, asked = self._rate(), self._asked()
        self._begin("gait", lambda: self._analysed(files, fps, asked))

    def _review(self) -> None:
        """Open the review, with a button that leads on to the gait."""
        films = list(self.film.value)
        if len(self.files.value) != 1 or not films:
            raise InputError(
                "choose one file of tracks, and its film (of several views, the film of each)."
            )
        path, fps = Path(self.files.value[0]), self._rate()
        names = self._asked()["animals"] or []
        which = {"animal": names[0]} if len(names) == 1 else {}
        self._show(
            lambda: review_on_film(
                path, films, fps=fps, button=self._button, room=self._room(),
                then=lambda file: self._analyse([file]), **which,
            )
        )  # fmt: skip

    def _rate(self) -> float:
        """Return the frames a second that were typed."""
        try:
            return float(self.fps.value)
        except ValueError:
            raise InputError(
                f"a second has {self.fps.value!r} frames; expected a number, such as 200."
            ) from None

    def _asked(self) -> dict[str, Any]:
        """Return what was typed of animals, groups and legs."""
        return {
            "animals": _words(self.animals.value), "groups": _words(self.groups.value),
            "legs": split_legs(_words(self.legs.value)),
        }  # fmt: skip

    def _analysed(
        self, files: Sequence[Path], fps: float, asked: Mapping[str, Any]
    ) -> Callable[[], None]:
        """Analyse files; gives what to do then."""
        run = self._session.gait_of_tracks(files, fps, **asked)
        figures = sorted((run.out / "figures").rglob("*.png"))
        said = [line.removeprefix("note: ") for line in run.text().splitlines()]
        return lambda: self._show(lambda: Tool(show_results(figures, said), []))


def _words(text: str) -> list[str] | None:
    """Return what stands between commas; None where nothing was typed."""
    return [word.strip() for word in text.split(",")] if text.strip() else None
