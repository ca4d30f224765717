"""Parts of the workbench: a tool with the buttons that lead on, a text of the list, results."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import ipywidgets as widgets

from pawnb.workflow.workbench.states import DONE, WORK_STEPS, Step

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
    notes : sequence of str
        What whoever uses the tool must know, a line each between both.
    """

    def __init__(self, tool: Any, buttons: Sequence[Any], notes: Sequence[str] = ()) -> None:
        self.tool = tool
        rows = [widgets.HBox(list(buttons), layout=ROW)] if buttons else []
        super().__init__([*rows, *(cell(f"⚠ {note}", None, wrap=True) for note in notes), tool])

    def follow(self, marks: Callable[[], object], changed: Callable[[], None]) -> Tool:
        """Call ``changed()`` when ``marks()`` is another after the tool has said something.

        Parameters
        ----------
        marks : callable
            What is followed.
        changed : callable
            Called when it has changed.

        Returns
        -------
        Tool
            Itself.
        """
        seen = marks()

        def look(_change: object) -> None:
            nonlocal seen
            if (now := marks()) != seen:
                seen = now
                changed()

        self.tool.observe(look, names="status")
        return self

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


def list_trials(rows: Sequence[Sequence[Any]]) -> Any:
    """Return the list of trials; in a narrow page each goes on over several lines.

    Parameters
    ----------
    rows : sequence of sequence of widget
        The heads, then a line each: the trial, what is done, and the next step.

    Returns
    -------
    widget
        The list.
    """
    for first, *_, last in rows:
        first.add_class("pawnb-own-line")  # where the page is narrow: surroundings.css
        last.add_class("pawnb-own-line")
    columns = f"minmax(8em, 2fr) repeat({len(DONE)}, 6em) minmax(12em, 3fr)"
    return widgets.GridBox(
        [one for row in rows for one in row],
        layout={"grid_template_columns": columns, "align_items": "center"},
    )


def step_menu(steps: Sequence[Step], do: Callable[[Step], object]) -> Any:
    """Return a menu of steps that are not the next one.

    Parameters
    ----------
    steps : sequence of str
        The steps.
    do : callable
        ``do(step)`` does the one that was chosen.

    Returns
    -------
    widget
        The menu; it shows no step once one was chosen.
    """
    menu = widgets.Dropdown(
        options=[("other steps", ""), *((WORK_STEPS[step], step) for step in steps)],
        layout={"width": "11em"},
    )

    def chosen(change: dict[str, Any]) -> None:
        if change["new"]:
            menu.value = ""
            do(change["new"])

    menu.observe(chosen, names="value")
    return menu


def video_choice(videos: Sequence[Path]) -> Any:
    """Return a list of videos of which several can be chosen; the first eight are.

    Parameters
    ----------
    videos : sequence of Path
        The videos.

    Returns
    -------
    widget
        The list.
    """
    return widgets.SelectMultiple(
        options=[(video.name, str(video)) for video in videos],
        value=[str(video) for video in videos[:8]],
        rows=min(4, len(videos)), layout={"width": "18em"},
    )  # fmt: skip


def show_findings(found: Sequence[str]) -> Tool:
    """Return what is to be mended or looks wrong, a line each."""
    lines = found or ["nothing looks wrong"]
    return Tool(widgets.VBox([cell(text, None, wrap=True) for text in lines]), [])


def show_results(figures: Sequence[Path], notes: Sequence[str]) -> Any:
    """Return figures to look through, one at a time, with what a reader must know of them.

    The first note stands above the figure, and the others below it: of many trials they are long.

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
    first, *more = [cell(note, None, wrap=True) for note in notes if note] or [cell("", None)]
    if not figures:
        return widgets.VBox([first, *more])
    n = len(more)
    pointer = f"{n} more note{'' if n == 1 else 's'} below the figure." if n else ""
    picture = widgets.Image(layout={"max_width": "min(100%, 900px)"})
    choice = widgets.Dropdown(
        options=[(path.stem, str(path)) for path in figures], description="figure",
        layout={"width": "30em"},
    )  # fmt: skip

    def show(_change: object = None) -> None:
        picture.value = Path(choice.value).read_bytes()

    choice.observe(show, names="value")
    show()
    above = [first, cell(pointer, None)] if pointer else [first]
    return widgets.VBox([*above, choice, picture, *more])
