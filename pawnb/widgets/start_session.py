"""Clicking the start points: everything the widget does, without the widget.

Each change is written to ``start.csv`` at once, so nothing a person clicked is lost
when the browser or the kernel ends.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import pandas as pd

from pawnb.core.rig import Rig
from pawnb.errors import InputError
from pawnb.io.start import FILM_COLUMN, films_of_clicks, write_start
from pawnb.schema import START_COLUMNS, check_columns
from pawnb.trial import Trial
from pawnb.widgets.draft import Draft
from pawnb.widgets.start_marks import Slot, draw_view
from pawnb.widgets.start_points import points_by_view, read_unfinished
from pawnb.widgets.start_words import next_step, what_is_clicked, what_is_missing
from pawnb.workflow.export.colours import point_colours


@dataclass(frozen=True)
class _StartState:
    """What undo goes back to."""

    clicks: Mapping[Slot, tuple[float, float]] = field(default_factory=dict)
    hidden: frozenset[Slot] = frozenset()
    frame: int = 0


class StartSession(Draft[_StartState]):
    """The clicks of one trial, and which one is asked for next.

    Parameters
    ----------
    trial : Trial
        The trial; its views name their points.
    sizes : mapping of str to tuple of int
        Width and height of each view, px.
    span : tuple of int
        First and last frame that can be clicked.
    frame : int, optional
        Frame to begin with; default the first that has clicks, else the first of ``span``.
    start : pandas.DataFrame, optional
        Clicks there are already, columns frame, view, point, u, v; default those of the
        file, if it exists.
    rig : Rig, optional
        The calibrated views; with it, clicks in other views help to place the next.
    path : str or Path, optional
        Where the clicks go; default the trial's ``[start] points``, else ``start.csv``
        beside the trial.
    films : mapping of str to str, optional
        Code of each view's film, kept beside its clicks: films may be exchanged later.

    Attributes
    ----------
    frame : int
        The frame looked at.
    current : tuple of str or None
        View and point asked for next; None where all are placed or marked as hidden.
    clicks : dict
        (frame, view, point) to (u, v) in px.
    films : dict
        Code of each view's film.
    hidden : frozenset
        (frame, view, point) marked as hidden.
    proposed : dict
        (frame, view, point) to (u, v) in px of points that nobody has clicked or accepted.

    Raises
    ------
    InputError
        If no view names its points and the animal is not a mouse, or the clicks there
        are do not fit the trial.
    """

    def __init__(
        self,
        trial: Trial,
        *,
        sizes: Mapping[str, tuple[int, int]],
        span: tuple[int, int],
        frame: int | None = None,
        start: pd.DataFrame | None = None,
        rig: Rig | None = None,
        path: str | Path | None = None,
        films: Mapping[str, str] | None = None,
    ) -> None:
        super().__init__(
            Path(path) if path else trial.path(trial.start_points or "start.csv"), span
        )
        self.trial, self.rig, self.sizes = trial, rig, dict(sizes)
        if start is None and self.path.exists():
            start = read_unfinished(self.path)
        self.points_by_view = points_by_view(trial, start)
        every = dict.fromkeys(p for points in self.points_by_view.values() for p in points)
        self.points = tuple(every)
        self.colours = point_colours(self.points)
        clicks = {} if start is None else self._clicks_of(start)
        self.films, self._earlier_films = dict(films or {}), films_of_clicks(self.path)
        if frame is None:
            frame = min((f for f, _, _ in clicks), default=span[0])
        self._state = _StartState(clicks=clicks, frame=self._checked_frame(frame))
        self.proposed: dict[Slot, tuple[float, float]] = {}
        self.current: tuple[str, str] | None = None
        self._offer_next()

    # --- what there is ------------------------------------------------------------------

    @property
    def frame(self) -> int:
        """The frame looked at."""
        return self._state.frame

    @property
    def clicks(self) -> dict[Slot, tuple[float, float]]:
        """Every click: (frame, view, point) to (u, v) in px."""
        return dict(self._state.clicks)

    @property
    def hidden(self) -> frozenset[Slot]:
        """Every (frame, view, point) marked as hidden."""
        return self._state.hidden

    def table(self) -> pd.DataFrame:
        """Return the clicks as they are saved: frame, view, point, u, v, in a fixed order."""
        views = list(self.points_by_view)
        order = {
            (view, point): (views.index(view), number)
            for view, points in self.points_by_view.items()
            for number, point in enumerate(points)
        }
        rows = sorted(
            ((*slot, *uv) for slot, uv in self._state.clicks.items()),
            key=lambda row: (row[0], order[row[1], row[2]]),
        )
        return pd.DataFrame(rows, columns=list(START_COLUMNS))

    # --- what a person does -------------------------------------------------------------

    def go(self, frame: int) -> None:
        """Look at another frame; the first point that is still open there is asked for."""
        if frame != self.frame:
            self._state = replace(self._state, frame=self._checked_frame(frame))
            self.current = None
            self._offer_next()

    def select(self, view: str, point: str) -> None:
        """Ask for this point next."""
        self._check(view, point)
        self.current = (view, point)

    def click(self, view: str, u: float, v: float) -> str:
        """Place the point that is asked for; the next is then asked for by itself.

        A click in another view than the one asked for places the same point there if it
        is still open, else the first point that is.

        Parameters
        ----------
        view : str
            Where the click was.
        u, v : float
            Its position in px of the view.

        Returns
        -------
        str
            The point that was placed.

        Raises
        ------
        InputError
            If every point of that view is placed, or the click is outside the picture.
        """
        point = self.asked_in(view)
        if point is None:
            raise InputError(
                f"every point of {view} is placed or hidden in frame {self.frame}; drag one to "
                "move it, or choose one above the picture to place it again."
            )
        self.place(view, point, u, v)
        return point

    def asked_in(self, view: str) -> str | None:
        """Return the point that a click in a view places; None where all is placed or hidden."""
        open_here = [p for v, p in self._open_slots() if v == view]
        asked_in, asked = self.current or (None, None)
        if asked is not None and (asked_in == view or asked in open_here):
            return asked
        return open_here[0] if open_here else None

    def place(self, view: str, point: str, u: float, v: float) -> None:
        """Put a point at (u, v) in px of a view: a click, or the end of a drag.

        Parameters
        ----------
        view, point : str
            Which point in which view.
        u, v : float
            Position in px of the view.

        Raises
        ------
        InputError
            If the position is outside the picture.
        """
        self._check(view, point)
        width, height = self.sizes[view]
        if not (-0.5 <= u < width - 0.5 and -0.5 <= v < height - 0.5):
            raise InputError(
                f"{point} at ({u:.1f}, {v:.1f}) is outside the picture of {view} "
                f"({width} x {height} px); click inside it."
            )
        slot = (self.frame, view, point)
        clicks = {**self._state.clicks, slot: (round(float(u), 3), round(float(v), 3))}
        self._change(replace(self._state, clicks=clicks, hidden=self._state.hidden - {slot}))

    def hide(self, view: str | None = None, point: str | None = None) -> None:
        """Mark a point as hidden in a view; without names, the one that is asked for.

        Parameters
        ----------
        view, point : str, optional
            Which point in which view.

        Raises
        ------
        InputError
            If there is no such point, or none is asked for.
        """
        if view is None or point is None:
            if self.current is None:
                raise InputError("no point is asked for; choose one above a picture first.")
            view, point = self.current
        self._check(view, point)
        slot = (self.frame, view, point)
        clicks = {key: uv for key, uv in self._state.clicks.items() if key != slot}
        self._change(replace(self._state, clicks=clicks, hidden=self._state.hidden | {slot}))

    def propose(self, start: pd.DataFrame) -> None:
        """Offer points (frame, view, point, u, v in px) to accept or drag, and look at them."""
        self.proposed = self._clicks_of(start)
        if self.proposed:
            self.go(min(frame for frame, _, _ in self.proposed))

    def accept_all(self) -> None:
        """Take every proposed point of this frame that is neither clicked nor hidden."""
        for slot in self.offered():
            self.place(slot[1], slot[2], *self.proposed[slot])

    def offered(self) -> list[Slot]:
        """Return every point proposed in this frame that is neither clicked nor hidden yet."""
        return [slot for view, point in self._open_slots()
                if (slot := (self.frame, view, point)) in self.proposed]  # fmt: skip

    # --- in words -----------------------------------------------------------------------

    def prompt(self) -> str:
        """Say what to do next."""
        return next_step(self)

    def clicked(self) -> str:
        """Say which frames have clicks, where others than this one do."""
        return what_is_clicked(self)

    def missing(self) -> str:
        """Say what a tracker would still lack, or that nothing is missing."""
        return what_is_missing(self)

    # --- what is drawn ------------------------------------------------------------------

    def overlay(self, frame: int) -> dict[str, Any]:
        """Return what is drawn over a frame; see ``frame_canvas.Overlay``."""
        here = frame == self.frame
        views = {view: draw_view(self, frame, view) for view in self.points_by_view}
        current = list(self.current) if here and self.current else None
        return {"views": views, "current": current}

    # --- inside -------------------------------------------------------------------------

    def _open_slots(self) -> list[tuple[str, str]]:
        """Return views and points neither clicked nor hidden in this frame, in order."""
        settled = {*self._state.clicks, *self.hidden}
        return [
            (view, point)
            for view, points in self.points_by_view.items()
            for point in points
            if (self.frame, view, point) not in settled
        ]

    def _offer_next(self) -> None:
        """Ask for the next open point after the one asked for last, which is kept if open."""
        slots = self._open_slots()
        if self.current in slots:
            return
        order = [(v, p) for v, points in self.points_by_view.items() for p in points]
        if self.current in order:
            place = order.index(self.current)
            slots.sort(key=lambda slot: (order.index(slot) - place - 1) % len(order))
        self.current = slots[0] if slots else None

    def _change(self, state: _StartState) -> None:
        """Take over a new state, save it, and ask for the next point."""
        self._make(state)
        self._offer_next()

    def _write(self) -> None:
        table = self.table()
        rows = table.itertuples(index=False, name=None)
        codes = [self._earlier_films.get(row, self.films.get(row[1], "")) for row in rows]
        write_start(table.assign(**{FILM_COLUMN: codes}) if any(codes) else table, self.path)

    def _look_at_change(self, before: _StartState) -> None:
        """Look at the frame where something changed, and ask for what is open again."""
        was, now = before.clicks, self._state.clicks
        changed = {slot for slot in {*was, *now} if was.get(slot) != now.get(slot)}
        for frame, view, point in changed | (before.hidden ^ self.hidden):
            self._state = replace(self._state, frame=frame)
            self.current = (view, point)
        self._offer_next()

    def _check(self, view: str, point: str) -> None:
        if point not in self.points_by_view.get(view, ()):
            known = ", ".join(f"{v}: {' '.join(p)}" for v, p in self.points_by_view.items())
            raise InputError(f"{view} does not track a point {point!r}; points are {known}.")

    def _clicks_of(self, start: pd.DataFrame) -> dict[Slot, tuple[float, float]]:
        """Read clicks from a table, checking that they fit the trial."""
        check_columns(start, START_COLUMNS, where="start points")
        clicks = {}
        for frame, view, point, u, v in start[list(START_COLUMNS)].itertuples(index=False):
            self._check(view, point)
            clicks[self._checked_frame(int(frame)), view, point] = (float(u), float(v))
        return clicks
