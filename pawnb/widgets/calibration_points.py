"""Clicking points of known position: everything the widget does, without the widget.

Each change is written to ``calibration_clicks.csv`` at once, which ``pawnb calibrate POINTS
CLICKS`` reads, too. The views do not move, so a click counts whatever frame it was made in.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pawnb.core.calibration.scene_lines import scene_lines
from pawnb.errors import InputError
from pawnb.io.tables import read_cells, read_numbers
from pawnb.widgets.calibration_clicks import ClickDraft, ClickState
from pawnb.workflow.calibration.known_points import (
    KnownPointFit,
    fit_known_points,
    worst_click,
    write_known_points,
)
from pawnb.workflow.calibration.written import Written
from pawnb.workflow.export.colours import point_colours

CLICK_FILE = "calibration_clicks.csv"
CALIBRATION_COLUMNS = ("view", "point", "u", "v", "frame", "set_aside")
LIMIT_PX = 3.0
"""Clicks further from where the view shows their point are pointed out: three times what a hand
that aims at a mark is off by (about 1 px, set by hand)."""

ASIDE_COLOUR = "#999999"

Slot = tuple[str, str]
"""View and point."""


@dataclass(frozen=True)
class _ClicksState(ClickState):
    """What undo goes back to; slots are views and points."""

    frames: Mapping[Slot, int] = field(default_factory=dict)
    bends: bool = False


class PointCalibration(ClickDraft[_ClicksState]):
    """The clicks on points of known position, and the views that they determine.

    Parameters
    ----------
    known : mapping of str to ndarray, shape (3,)
        Positions of the points.
    sizes : mapping of str to tuple of int
        Width and height of each view, px.
    folder : Path
        Where the clicks and the calibration go.
    span : tuple of int
        First and last frame.

    Attributes
    ----------
    frame : int
        The frame looked at.
    current : tuple of str or None
        View and point that are asked for, or chosen.

    Raises
    ------
    InputError
        If the clicks that are there do not fit the views and points.
    """

    def __init__(
        self,
        known: Mapping[str, np.ndarray],
        *,
        sizes: Mapping[str, tuple[int, int]],
        folder: Path,
        span: tuple[int, int],
    ) -> None:
        super().__init__(folder / CLICK_FILE, sizes=sizes, span=span)
        self.known, self.names = dict(known), tuple(known)
        self.colours = point_colours(self.known)
        self._state = self._read() if self.path.exists() else _ClicksState()
        self._fitted: tuple[_ClicksState, KnownPointFit] | None = None
        self._offer_next()

    # --- what there is ------------------------------------------------------------------

    @property
    def bends(self) -> bool:
        """Whether lenses are taken to bend lines."""
        return self._state.bends

    def fit(self) -> KnownPointFit:
        """Return what the clicks determine, computed once for each change."""
        if self._fitted is None or self._fitted[0] is not self._state:
            used = {slot: uv for slot, uv in self._state.clicks.items() if slot not in self.aside}
            found = fit_known_points(self.known, used, sizes=self.sizes, bends=self.bends)
            self._fitted = (self._state, found)
        return self._fitted[1]

    def residuals(self) -> dict[Slot, float]:
        """Return how far each click is from where its view shows the point, px."""
        fit = self.fit()
        return {
            (view, point): float(np.hypot(*(fit.views[view].show(self.known[point][None])[0] - uv)))
            for (view, point), uv in self._state.clicks.items()
            if view in fit.views
        }

    def table(self) -> pd.DataFrame:
        """Return the clicks as they are saved, in the order of views and points."""
        rows = [
            (view, point, *self._state.clicks[view, point], self._state.frames[view, point],
             int((view, point) in self.aside))
            for view in self.sizes for point in self.known if (view, point) in self._state.clicks
        ]  # fmt: skip
        return pd.DataFrame(rows, columns=list(CALIBRATION_COLUMNS))

    # --- what a person does -------------------------------------------------------------

    def set_aside(self, slot: Slot | None = None) -> None:
        """Set the chosen click aside, or take it back; without one, that which fits worst."""
        if slot is None:
            chosen = self.current if self.current in self._state.clicks else None
            worst = self.worst()
            slot = chosen or (worst[:2] if worst is not None else None)
        if slot is None or slot not in self._state.clicks:
            raise InputError("no click is chosen; choose one above its picture, then press X.")
        self._make(replace(self._state, aside=self.aside ^ {slot}))
        self.current = slot

    def let_bend(self) -> None:
        """Take lenses to bend straight lines, or no more."""
        self._make(replace(self._state, bends=not self.bends))

    def save_calibration(self) -> Written:
        """Write ``DLTcoefs.csv`` and, where lenses bend, ``lenses.toml``."""
        self.written = write_known_points(self.fit(), self.folder / "DLTcoefs.csv")
        return self.written

    # --- in words, and drawn --------------------------------------------------------------

    def worst(self) -> tuple[str, str, float] | None:
        """Return view, point and px of the click that fits worst beyond the limit."""
        return worst_click(self.fit(), self._state.clicks, limit_px=LIMIT_PX, aside=self.aside)

    def prompt(self) -> str:
        """Say what to do next, how well it fits, and what is worst."""
        slot = self._open_slot()
        first = f"Click {slot[1]} in {slot[0]}." if slot else "Every point is clicked in each view."
        fit, parts = self.fit(), []
        for view in self.sizes:
            if view in fit.views:
                error = fit.views[view].residual_px
                rms = np.sqrt(np.mean(error**2))
                parts.append(f"{view}: {rms:.2f} px RMS of {len(error)} points")
            else:
                parts.append(f"{view}: {fit.reasons[view].split(';')[0].rstrip('.')}")
        worst = self.worst()
        warned = (
            f"\n⚠ {worst[1]} in {worst[0]} is {worst[2]:.1f} px from where the view shows it: "
            "move it, or set it aside (X)."
            if worst
            else ""
        )
        return f"{first}{warned}\n{'; '.join(parts)}."

    def actions(self) -> list[dict[str, Any]]:
        """Return the buttons of this kind of calibration."""
        words = "Lenses straight" if self.bends else "Lenses bend"
        return [
            {"id": "aside", "text": "Set aside", "keys": ["x"], "enabled": bool(self.clicks),
             "title": "Leave the chosen click out, or the worst; again takes it back (X)"},
            {"id": "bends", "text": words,
             "title": "Find focal length and k1 of each lens (eight points or more), or take lines "
             "to be straight"},
        ]  # fmt: skip

    @property
    def can_save(self) -> bool:
        """Whether every view is determined."""
        return not self.fit().reasons

    def act(self, action: str) -> None:
        """Do what a button asks for."""
        if action == "aside":
            self.set_aside()
        elif action == "bends":
            self.let_bend()
        else:
            raise InputError(f"{action} is no action of this widget.")

    def overlay(self, view: str, _frame: int) -> dict[str, Any]:
        """Return what is drawn over a view, at any frame; see ``frame_canvas.Overlay``."""
        fitted = self.fit().views.get(view)
        points, hollow, chips, guides = [], [], [], {}
        residuals = self.residuals()
        for point, colour in self.colours.items():
            slot = (view, point)
            uv = self._state.clicks.get(slot)
            is_aside = slot in self.aside
            if fitted is not None:
                shown = fitted.show(self.known[point][None])[0]
                if np.isfinite(shown).all():
                    guides[point] = [np.round(shown, 2).tolist()]
                    if uv is None:
                        hollow.append({"id": point, "u": guides[point][0][0],
                                       "v": guides[point][0][1], "colour": colour})  # fmt: skip
            if uv is not None:
                points.append(
                    {"id": point, "u": uv[0], "v": uv[1],
                     "colour": ASIDE_COLOUR if is_aside else colour,
                     "origin": "predicted" if is_aside else "measured"}
                )  # fmt: skip
            off = f", {residuals[slot]:.2f} px off" if slot in residuals else ""
            state, words = (
                ("open", "not clicked yet") if uv is None
                else ("hidden", f"set aside{off}") if is_aside
                else ("done", f"at ({uv[0]:.1f}, {uv[1]:.1f}){off}")
            )  # fmt: skip
            chips.append(
                {"id": point, "colour": colour, "state": state, "title": f"{point}: {words}"}
            )
        lines: list[dict[str, object]] = []
        if fitted is not None:
            lines, ends = scene_lines(fitted.show, around=np.array(list(self.known.values())))
            hollow += ends
        return {"points": points, "hollow": hollow, "lines": lines, "chips": chips,
                "asks": self.asked_in(view), "guides": guides, "limit_px": LIMIT_PX,
                "residuals": True}  # fmt: skip

    # --- inside -------------------------------------------------------------------------

    def _open_slot(self) -> Slot | None:
        """Return the view and point that a person is asked for."""
        if self.current is not None and self.current not in self._state.clicks:
            return self.current
        return None

    def _offer_next(self) -> None:
        if self._open_slot() is None:
            super()._offer_next()

    def _is_asked(self, current: tuple[str, str], view: str, free: Sequence[str]) -> bool:
        del view  # one point is asked for in every view
        return current[1] in free

    def _all_clicked(self, view: str) -> str:
        return f"every point is clicked in {view}; drag one to move it."

    def _with_click(self, slot: Slot, uv: tuple[float, float]) -> _ClicksState:
        state = super()._with_click(slot, uv)
        return replace(state, frames={slot: self.frame, **state.frames})

    def _without_click(self, slot: Slot) -> _ClicksState:
        return replace(super()._without_click(slot), aside=self.aside - {slot})

    def _look_at_change(self, before: _ClicksState) -> None:
        for slot in self._changed_slots(before) | (before.aside ^ self.aside):
            self.current = slot

    def _slot(self, view: str, point: str) -> Slot:
        if view not in self.sizes or point not in self.known:
            raise InputError(
                f"there is no point {point!r} in view {view!r}; points are {', '.join(self.known)} "
                f"in {', '.join(self.sizes)}."
            )
        return view, point

    def _read(self) -> _ClicksState:
        """Read the clicks there are."""
        where = self.path.name
        table = read_cells(self.path, CALIBRATION_COLUMNS[:4])
        numbers = {name: read_numbers(table, name, where=where) for name in ("u", "v")}
        more = {
            name: read_numbers(table, name, where=where, whole=True)
            for name in CALIBRATION_COLUMNS[4:]
            if name in table
        }
        table = table.assign(frame=self.span[0], set_aside=0).assign(**numbers, **more)
        clicks, frames, aside = {}, {}, set()
        columns = (table[name].tolist() for name in CALIBRATION_COLUMNS)
        for view, point, u, v, frame, is_aside in zip(*columns, strict=True):
            slot = (str(view), str(point))
            self._slot(*slot)
            clicks[slot], frames[slot] = (u, v), int(frame)
            if is_aside:
                aside.add(slot)
        return _ClicksState(clicks=clicks, frames=frames, aside=frozenset(aside))
