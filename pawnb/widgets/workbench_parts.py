"""Parts of the workbench: a tool with the buttons that lead on, results, tracks made elsewhere."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import ipywidgets as widgets

from pawnb.errors import PawnbError
from pawnb.widgets.workbench_session import WorkbenchSession
from pawnb.workflow.words import split_legs

ROW = {"flex_flow": "row wrap", "align_items": "center"}
"""A line of parts that goes on below where it is too long."""


class Tool(widgets.VBox):  # type: ignore[misc]
    """A tool, with the buttons that lead on above it.

    Parameters
    ----------
    tool : widget
        The tool.
    buttons : sequence of widget
        The buttons.
    """

    def __init__(self, tool: Any, buttons: Sequence[Any]) -> None:
        self.tool = tool
        rows = [widgets.HBox(list(buttons), layout=ROW)] if buttons else []
        super().__init__([*rows, tool])

    def close(self) -> None:
        """Take the tool away."""
        self.tool.close()
        super().close()


def cell(text: str, colour: str | None, *, strong: bool = False, wrap: bool = False) -> Any:
    """Return a text of the list of trials.

    Parameters
    ----------
    text : str
        The text; no HTML.
    colour : str or None
        Colour of what is wrong; it may go on over several lines, as with ``wrap``.
    strong, wrap : bool
        Whether it is bold, and whether it may go on over several lines.

    Returns
    -------
    widget
        A label.
    """
    label = widgets.Label(text)
    label.style.font_weight = "bold" if strong else ""
    label.style.text_color = colour
    if wrap or colour:
        label.add_class("pawnb-wrap")
    return label


def show_results(figures: Sequence[Path], notes: Sequence[str]) -> Any:
    """Return figures to look through, one at a time, below what a reader must know of them.

    Parameters
    ----------
    figures : sequence of Path
        Pictures.
    notes : sequence of str
        The verdict on the tracks, and the notes of the analysis; empty ones are left out.

    Returns
    -------
    widget
        All of it.
    """
    said = [cell(note, None, wrap=True) for note in notes if note]
    if not figures:
        return widgets.VBox(said)
    picture = widgets.Image(layout={"max_width": "min(100%, 900px)"})
    choice = widgets.Dropdown(
        options=[(path.stem, str(path)) for path in figures], description="figure",
        layout={"width": "30em"},
    )  # fmt: skip

    def show(_change: object = None) -> None:
        picture.value = Path(choice.value).read_bytes()

    choice.observe(show, names="value")
    show()
    return widgets.VBox([*said, choice, picture])


class TracksForm(widgets.VBox):  # type: ignore[misc]
    """Gait of tracks that other programs made: they need no trial, only their frame rate.

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
    """

    def __init__(
        self,
        files: Sequence[Path],
        session: WorkbenchSession,
        *,
        begin: Callable[[str, Callable[[], Callable[[], None]]], None],
        show: Callable[[Callable[[], Any]], None],
    ) -> None:
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
        self._session, self._begin, self._show = session, begin, show
        go = widgets.Button(description="Analyse the gait", button_style="primary")
        go.on_click(lambda _: self.analyse())
        said = (
            "Each file counts as an animal of its own, unless it names its animals: where several "
            "are of one animal, name that of each file."
        )
        self.told = cell(said, None, wrap=True)
        rows = ([self.files, self.fps, go], [self.animals, self.groups, self.legs])
        super().__init__([*(widgets.HBox(row, layout=ROW) for row in rows), self.told])

    def analyse(self) -> None:
        """Analyse what is chosen, and show the results."""
        try:
            fps = float(self.fps.value)
        except ValueError:
            self.told.value = (
                f"a second has {self.fps.value!r} frames; expected a number, such as 200."
            )
            return
        files = [Path(name) for name in self.files.value]
        try:
            legs = split_legs(_words(self.legs.value))
        except PawnbError as error:
            self.told.value = str(error)
            return
        asked = {
            "animals": _words(self.animals.value), "groups": _words(self.groups.value),
            "legs": legs,
        }  # fmt: skip
        self._begin("gait", lambda: self._analysed(files, fps, asked))

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
