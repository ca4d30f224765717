"""GaitExplorer: pick legs, pairs and strides, and correct events by hand."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import ipywidgets as widgets
from matplotlib.figure import Figure

from pawnb.errors import InputError
from pawnb.gait import GaitTables
from pawnb.widgets.gait_panels import GaitPanels
from pawnb.widgets.gait_session import GaitSession
from pawnb.widgets.plain import Plain, picture_of_figure
from pawnb.widgets.plot_canvas import alone, make_canvas
from pawnb.widgets.plot_theme import fit_figure, set_theme
from pawnb.widgets.surroundings import Surroundings

_REACH_OF_PLOT = 0.02
"""How near to an event a click must be, as a share of the width of the axes: about 12 px."""
_STILL = 0.004
"""A shorter way of the pointer is a click, not a drag: about 3 px."""
_WRONG_IN_PLOT = {False: "#A33B00", True: "#FF9E64"}
"""Colour of words on what is wrong, on a light and on a dark page."""
_GAIT_SIZE_PX, _BESIDE_GAIT_PX = (1000, 640), 330
"""Size of the plots before a page shows them, which is their greatest height; and height of the
window that buttons and menus take."""
_WRAP = {"flex_flow": "row wrap"}
_HELP = (
    "Click a stride in the gait diagram, or a point of the plot below right: it turns yellow in "
    "every plot. In the signal, click an event and drag it to where it belongs; where one is "
    "missing, click there and add it. Keys in the plots: Left, Right move the picked event by a "
    "frame, with Shift by ten; Delete; 1 to 4 add AEP, PEP, TD, LO; Ctrl+Z, Ctrl+Y undo, redo."
)
_ADDED = ("AEP", "PEP", "TD", "LO")
_MOVED = {"left": -1, "right": 1, "shift+left": -10, "shift+right": 10}
"""Keys that move an event, and by how many frames."""


class GaitExplorer(Plain, widgets.VBox):  # type: ignore[misc]
    """Look through the strides of an analysis and correct its events.

    Click a stride in the gait diagram: it is marked there, in the signal of its leg, in the
    phases of the pair and among the strides of its leg. Click an event in the signal to pick it
    and drag it to move it; delete it, add one where it is missing, or exclude the stride and say
    why. Undo takes back what
    was done last.

    Parameters
    ----------
    tables : GaitTables
        The analysis; it is not modified.
    path : str or Path, optional
        ``event_edits.jsonl``: every correction is a line in it, on disk as it is made. What it
        holds already is applied. In the folder of results, ``pawnb gait`` applies it too.

    Attributes
    ----------
    session : GaitSession
        The state; ``session.tables`` are the tables with the corrections.
    tables : GaitTables
        The same.

    Raises
    ------
    InputError
        If there is no event, or the corrections cannot be read.
    """

    def __init__(self, tables: GaitTables, path: str | Path | None = None) -> None:
        super().__init__()
        self.session = GaitSession(tables, path)
        self._figure = Figure(figsize=(_GAIT_SIZE_PX[0] / 100, _GAIT_SIZE_PX[1] / 100), dpi=100)
        self._canvas = make_canvas(self._figure)
        self._panels = GaitPanels(self._figure, self.session)
        self._pressed: float | None = None
        self._filling = False
        self._around = Surroundings()
        self._make_controls()
        self._fill()
        self._draw()
        for name, handler in (
            ("button_press_event", self._on_press),
            ("motion_notify_event", self._on_move),
            ("button_release_event", self._on_release),
            ("key_press_event", self._on_key),
        ):
            self._canvas.mpl_connect(name, handler)
        self._around.observe(self._on_room, names=["width", "height"])
        self._around.observe(lambda _: self._draw(), names="dark")

    @alone
    def plain_picture(self) -> bytes:
        """Return the plots as PNG."""
        return picture_of_figure(self._figure)

    @property
    def tables(self) -> GaitTables:
        """The tables with every correction in force."""
        return self.session.tables

    def _make_controls(self) -> None:
        """Make the drop-downs and buttons."""
        trials = [(f"{animal}, {trial}", (animal, trial)) for animal, trial in self.session.trials]
        self._trial = widgets.Dropdown(options=trials, description="trial")
        self._pair = widgets.Dropdown(description="phase of", layout={"width": "14em"})
        self._span = widgets.FloatRangeSlider(
            description="time (s)", readout_format=".2f", continuous_update=False,
            layout={"width": "28em"},
        )  # fmt: skip
        self._legs: dict[str, widgets.ToggleButton] = {}
        self._leg_box = widgets.HBox()
        self._reason = widgets.Text(placeholder="reason, e.g. the animal stumbled")
        self._told, said = widgets.Label(), widgets.Label(_HELP)
        for words in (self._told, said):
            words.add_class("pawnb-wrap")
        self._delete = self._button("delete event", "trash", self.session.delete_event)
        self._adds = {
            event: self._button(f"add {event}", "plus", partial(self.session.add_event, event))
            for event in _ADDED
        }
        self._exclude = self._button("exclude stride", "ban", self._exclude_with_reason)
        self._undo = self._button("undo", "undo", self.session.undo)
        self._redo = self._button("redo", "repeat", self.session.redo)
        self._trial.observe(self._on_trial, names="value")
        self._pair.observe(self._on_pair, names="value")
        self._span.observe(self._on_span, names="value")
        row = widgets.HBox([self._trial, self._pair, self._span], layout=_WRAP)
        for button in self._adds.values():
            button.layout.width = "7em"
        buttons = [
            self._delete,
            *self._adds.values(),
            self._exclude,
            self._reason,
            self._undo,
            self._redo,
        ]
        legs = widgets.HBox([widgets.Label("legs"), self._leg_box], layout=_WRAP)
        self._leg_box.layout = _WRAP
        acts = widgets.HBox(buttons, layout=_WRAP)
        self.children = (self._around, row, legs, said, acts, self._told, self._canvas)

    def _button(self, name: str, icon: str, act: Callable[[], None]) -> Any:
        """Return a button that does something and shows what became of it."""
        button = widgets.Button(description=name, icon=icon)
        button.on_click(lambda _: self._do(act))
        return button

    @alone
    def _do(self, act: Callable[[], None]) -> None:
        """Do something and draw everything; say what is wrong where it cannot be done."""
        try:
            act()
        except InputError as error:
            self._panels.mark()  # an event that was dragged goes back
            self._tell(str(error), wrong=True)
            return
        self._draw()

    @alone
    def _tell(self, text: str, *, wrong: bool = False) -> None:
        """Say something below the buttons, offer what can be done, and show the plots."""
        self._told.value = text
        self._told.style.text_color = _WRONG_IN_PLOT[self._around.dark] if wrong else None
        session, edits = self.session, self.session.edits
        self._undo.disabled, self._redo.disabled = not edits.can_undo, not edits.can_redo
        self._delete.disabled = session.event is None
        kinds = [event for pair in session.kinds() for event in pair]
        for event, button in self._adds.items():
            button.layout.display = None if event in kinds else "none"
            button.disabled = session.place_s is None
        self._exclude.disabled = self._reason.disabled = session.picked() is None
        self._show()

    def _show(self) -> None:
        """Let the browser show the plots as they are now."""
        set_theme(self._figure, dark=self._around.dark)
        self._canvas.draw_idle()

    @alone
    def _on_room(self, _change: dict[str, Any]) -> None:
        """Fit the plots into the page."""
        room = (self._around.width, self._around.height)
        fit_figure(self._figure, room=room, highest_px=_GAIT_SIZE_PX[1], beside_px=_BESIDE_GAIT_PX)

    @alone
    def _draw(self) -> None:
        """Draw everything anew."""
        self._panels.draw()
        self._tell(self.session.text())

    def _exclude_with_reason(self) -> None:
        """Exclude the picked stride for the reason that was typed."""
        self.session.exclude_stride(self._reason.value)
        self._reason.value = ""

    def _fill(self) -> None:
        """Offer the legs, pairs and times of the trial that is shown."""
        session = self.session
        self._filling = True
        self._pair.options = [(f"{leg} to {ref}", (leg, ref)) for leg, ref in session.pairs]
        if session.pairs:
            self._pair.value = session.pair
        self._legs = {leg: self._leg_button(leg) for leg in session.all_legs}
        self._leg_box.children = tuple(self._legs.values())
        first, last = session.span_s
        self._span.max = max(last, self._span.min)  # never below the old minimum on the way
        self._span.min, self._span.max = first, last
        self._span.step = (last - first) / 200.0
        self._span.value = session.span_s
        self._panels.span_s = session.span_s
        self._filling = False

    def _leg_button(self, leg: str) -> Any:
        """Return the button that shows or hides one leg."""
        button = widgets.ToggleButton(
            value=leg in self.session.legs, description=leg, icon="check",
            tooltip=f"show or hide {leg} in the gait diagram",
            layout={"width": "auto", "min_width": "4.5em", "max_width": "11em"},
        )  # fmt: skip
        button.observe(self._on_legs, names="value")
        return button

    @alone
    def _on_trial(self, change: dict[str, Any]) -> None:
        """Show another trial."""
        self.session.show(*change["new"])
        self._fill()
        self._draw()

    def _on_pair(self, change: dict[str, Any]) -> None:
        """Show the phases of another pair."""
        if not self._filling and change["new"] is not None:
            self._do(lambda: self.session.show_pair(*change["new"]))

    @alone
    def _on_span(self, change: dict[str, Any]) -> None:
        """Show another stretch of time."""
        if not self._filling:
            self._panels.show_span(change["new"])
            self._show()

    def _on_legs(self, change: dict[str, Any]) -> None:
        """Show the legs whose buttons are down; the last one stays down."""
        if self._filling:
            return
        chosen = [leg for leg, button in self._legs.items() if button.value]
        self._do(lambda: self.session.show_legs(chosen))
        if not chosen:
            self._filling = True
            change["owner"].value = True
            self._filling = False
        change["owner"].icon = "check" if change["owner"].value else ""

    @alone
    def _on_press(self, event: Any) -> None:
        """Pick the stride or the event under the pointer."""
        self._pressed = None
        if event.xdata is None:
            return
        panels, session, before = self._panels, self.session, self.session.shown_leg
        if event.inaxes is panels.diagram:
            row = round(event.ydata)
            if 0 <= row < len(panels.rows):
                session.pick(panels.rows[row], float(event.xdata))
        elif event.inaxes is panels.strides:
            start_s = panels.nearest_stride(event.x, event.y)
            if start_s is not None:
                session.pick(before, start_s)
        elif event.inaxes is panels.signal:
            within_s, kinds = _REACH_OF_PLOT * self._width(), panels.kinds_at(float(event.ydata))
            session.pick_event(float(event.xdata), within_s=within_s, kinds=kinds)
            self._pressed = float(event.xdata) if session.event is not None else None
        if session.shown_leg != before:
            panels.draw_leg()
        else:
            panels.mark()
        self._tell(session.text())

    def _on_key(self, event: Any) -> None:
        """Do what a key asks for."""
        key, session = str(event.key), self.session
        keys: dict[str, Callable[[], None]] = {
            "delete": session.delete_event, "backspace": session.delete_event,
            "ctrl+z": session.undo, "ctrl+y": session.redo, "ctrl+shift+z": session.redo,
            "ctrl+Z": session.redo,
        }  # fmt: skip
        keys |= {str(k): partial(session.add_event, kind) for k, kind in enumerate(_ADDED, 1)}
        keys |= {name: partial(session.step_event, by) for name, by in _MOVED.items()}
        if key in keys:
            self._do(keys[key])

    @alone
    def _on_move(self, event: Any) -> None:
        """Let the line of the picked event follow the pointer."""
        line, picked = self._panels.event_line, self.session.event
        if line is None or picked is None or not self._drags(event):
            return
        line.set_xdata([self._dragged_to(event)] * 2)
        self._told.value = f"{picked[1]} of {picked[0]} to {self._dragged_to(event):.3f} s"
        self._canvas.draw_idle()

    @alone
    def _on_release(self, event: Any) -> None:
        """Move the picked event to where the pointer was dragged."""
        if self._drags(event):
            to_s = self._dragged_to(event)
            self._pressed = None
            self._do(lambda: self.session.move_event(to_s))
        elif self._pressed is not None:
            self._pressed = None
            self._panels.mark()
            self._tell(self.session.text())

    def _drags(self, event: Any) -> bool:
        """Tell whether the pointer drags an event, and not only clicks it."""
        if self._pressed is None or event.inaxes is not self._panels.signal:
            return False
        return abs(float(event.xdata) - self._pressed) > _STILL * self._width()

    def _dragged_to(self, event: Any) -> float:
        """Return where the picked event is dragged to, s."""
        if self.session.event is None or self._pressed is None:
            raise InputError("no event is dragged.")
        return float(self.session.event[2] + float(event.xdata) - self._pressed)

    def _width(self) -> float:
        """Return the width of the signal's axes, s."""
        low, high = self._panels.signal.get_xlim()
        return float(high - low)
