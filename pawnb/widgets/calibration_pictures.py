"""Calibrating by pictures of a board: everything the widget does, without the widget.

Which pictures are set aside, and in which the board lies on the floor, is written to
``calibration_pictures.csv`` at once.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pawnb.core.calibration.optics import show_points
from pawnb.core.calibration.rig_from_boards import (
    BoardFit,
    Sightings,
    calibrate_by_boards,
    sides_in_space,
    tell_disagreement,
)
from pawnb.core.calibration.scene_lines import scene_lines
from pawnb.errors import InputError
from pawnb.io.boards import Board
from pawnb.io.tables import read_cells, read_numbers, write_table
from pawnb.widgets.calibration_clicks import CalibrationDraft
from pawnb.widgets.calibration_points import ASIDE_COLOUR
from pawnb.workflow.calibration.board import find_boards, numbered
from pawnb.workflow.calibration.written import Written, write_calibration

PICTURE_FILE = "calibration_pictures.csv"
PICTURE_COLUMNS = ("view", "frame", "what")
ASIDE, FLOOR = "set aside", "floor"
BOARD = "board"
"""The name of the one button above each view."""

_USED_COLOUR = "#009e73"

Slot = tuple[str, int]
"""View and frame."""


@dataclass(frozen=True)
class _PicturesState:
    """What undo goes back to."""

    aside: frozenset[Slot] = frozenset()
    floor: int | None = None


class BoardPictures(CalibrationDraft[_PicturesState]):
    """Pictures of a board, and the cameras that they determine.

    Parameters
    ----------
    board : Board
        The board.
    pictures : mapping of str to Path
        View to its video, folder or glob.
    sizes : mapping of str to tuple of int
        Width and height of each view, px.
    folder : Path
        Where the choices and the calibration go.
    span : tuple of int
        First and last frame.

    Attributes
    ----------
    frame : int
        The frame looked at.
    current : tuple of str or None
        The view that is chosen, and "board".
    reason : str
        Why there are no cameras, in a sentence.
    """

    def __init__(
        self,
        board: Board,
        pictures: Mapping[str, str | Path],
        *,
        sizes: Mapping[str, tuple[int, int]],
        folder: Path,
        span: tuple[int, int],
    ) -> None:
        super().__init__(folder / PICTURE_FILE, sizes=sizes, span=span)
        self.board, self.pictures = board, dict(pictures)
        self.sightings: Sightings | None = None
        self.fitted: BoardFit | None = None
        self.reason = ""
        self._shots = np.zeros(0, int)
        self._state = self._read() if self.path.exists() else _PicturesState()
        self._fitted_state: _PicturesState | None = None

    # --- what there is ------------------------------------------------------------------

    @property
    def floor(self) -> int | None:
        """The frame whose board gives the axes; None for the first that most views see."""
        return self._state.floor

    @property
    def is_stale(self) -> bool:
        """Whether the cameras are those of other choices."""
        return self.sightings is not None and self._fitted_state != self._state

    @property
    def can_save(self) -> bool:
        """Whether there are cameras."""
        return self.fitted is not None and not self.is_stale

    def corners(self, view: str, frame: int) -> np.ndarray | None:
        """Return the corners found in a view and frame (n_corners, 2), or None."""
        at = np.flatnonzero(self._shots == frame)
        if self.sightings is None or not len(at):
            return None
        uv = self.sightings.uv[self.sightings.names.index(view), at[0]]
        return uv if np.isfinite(uv).any() else None

    def shot(self, view: str, frame: int) -> pd.Series | None:
        """Return the row of a view and frame in the table of errors, or None."""
        if self.fitted is None:
            return None
        table = self.fitted.shots
        rows = table[(table["view"] == view) & (table["shot"] == frame)]
        return rows.iloc[0] if len(rows) else None

    # --- what a person does -------------------------------------------------------------

    def select(self, view: str, _point: str) -> None:
        """Choose a view."""
        self.current = (view, BOARD)

    def find(self, progress: Callable[[int, int], None] | None = None) -> None:
        """Look for the board in every picture, and calibrate.

        Parameters
        ----------
        progress : callable, optional
            Called with (done, total) pictures.
        """
        found, shots, _ = find_boards(self.board, self.pictures, progress=progress)
        self.sightings, self._shots = found, shots
        self.refit()

    def refit(self) -> None:
        """Calibrate by the pictures that are not set aside; ``reason`` says why not."""
        state = self._state
        if self.sightings is None:
            return
        number = {int(frame): s for s, frame in enumerate(self._shots)}
        aside = [(v, number[f]) for v, f in state.aside if f in number]
        floor = number.get(state.floor) if state.floor is not None else None
        try:
            fit = calibrate_by_boards(self.sightings, floor=floor, aside=aside)
        except InputError as error:
            self.fitted, self.reason = None, str(error)
        else:
            self.fitted, self.reason = numbered(fit, self._shots), ""
        self._fitted_state = state

    def set_aside(self, slot: Slot | None = None) -> None:
        """Leave out the picture of the chosen view at this frame, or take it back."""
        if slot is None:
            if self.current is None:
                raise InputError("no view is chosen; click the button above one, then press X.")
            slot = (self.current[0], self.frame)
        self._make(replace(self._state, aside=self.aside ^ {slot}))

    def lie_on_floor(self) -> None:
        """Take the board of this frame for the floor: it gives the axes."""
        self._make(replace(self._state, floor=self.frame))

    def save_calibration(self) -> Written:
        """Write ``DLTcoefs.csv`` and ``lenses.toml``."""
        if self.fitted is None:
            raise InputError("there are no cameras yet; find the board first.")
        self.written = write_calibration(self.fitted.cameras, self.folder / "DLTcoefs.csv")
        return self.written

    def act(self, action: str) -> None:
        """Do what a button asks for."""
        if action == "aside":
            self.set_aside()
        elif action == "floor":
            self.lie_on_floor()
        else:
            raise InputError(f"{action} is no action of this widget.")

    # --- in words, and drawn --------------------------------------------------------------

    def prompt(self) -> str:
        """Say what to do next, how well the cameras fit, and what was set aside."""
        if self.sightings is None:
            return "Press Enter to find the board in every picture."
        if self.fitted is None:
            return f"⚠ {self.reason}"
        parts = []
        for view in self.sizes:
            own = self.fitted.of_view(view)
            parts.append(
                f"{view}: {own['rms_px']:.2f} px RMS of {own['n_shots']} of {len(self._shots)} "
                "pictures"
            )
        said = "; ".join(parts) + "."
        aside = self.fitted.shots[self.fitted.shots["set_aside"]]
        each = [f"{r.view} {r.shot} ({r.rms_px:.1f} px)" for r in aside.itertuples()]
        if each:
            said += f" Set aside: {', '.join(each)}."
        if (doubt := tell_disagreement(self.fitted)) is not None:
            said = f"⚠ {doubt[0].upper()}{doubt[1:]}.\n{said}"
        return (
            f"{said}\n{self._in_space(self.fitted)}\nThe yellow grid lies on the board of frame "
            f"{self.fitted.floor} in every view, z points out of its face. x is taken for forward "
            "and z for up: F takes the board of the frame on the screen instead."
        )

    def actions(self) -> list[dict[str, Any]]:
        """Return the buttons of this kind of calibration."""
        found = self.sightings is not None
        return [
            {"id": "find", "text": "Find the board", "keys": ["Enter"], "enabled": not found,
             "title": "Look for the board in every picture of every view (Enter)"},
            {"id": "aside", "text": "Set aside", "keys": ["x"],
             "enabled": found and self.current is not None,
             "title": "Leave out this picture of the chosen view; again takes it back (X)"},
            {"id": "floor", "text": "Lies on the floor", "keys": ["f"], "enabled": found,
             "title": "The board of this frame gives the axes: z is up from it (F)"},
        ]  # fmt: skip

    def overlay(self, view: str, frame: int) -> dict[str, Any]:
        """Return what is drawn over a view at a frame; see ``frame_canvas.Overlay``."""
        uv = self.corners(view, frame)
        row = self.shot(view, frame)
        by_hand = (view, frame) in self.aside
        is_aside = by_hand or (row is not None and bool(row["set_aside"]))
        colour = ASIDE_COLOUR if is_aside else _USED_COLOUR
        off = "" if row is None else f", {row['rms_px']:.2f} px RMS"
        if uv is None:
            state, words = "open", "not looked for yet" if self.sightings is None else "not found"
        elif is_aside:
            state, words = "hidden", f"set aside{'' if by_hand else ', as it does not agree'}{off}"
        else:
            state, words = "done", f"{int(np.isfinite(uv[:, 0]).sum())} corners{off}"
        chip = {"id": BOARD, "state": state, "title": f"{BOARD}: {words}", "colour": colour}
        lines: list[dict[str, object]] = []
        hollow: list[dict[str, object]] = []
        if uv is not None:
            lines += [
                {"at": [_place(p) for p in row_of], "colour": colour, "dash": is_aside}
                for row_of in uv.reshape(*self.board.shape[::-1], 2)
            ]
        if self.fitted is not None and self.sightings is not None:
            show = self._show(view)
            axes, hollow = scene_lines(show, around=self._around())
            lines += axes
        return {"points": [], "hollow": hollow, "lines": lines, "chips": [chip], "asks": None}

    # --- inside -------------------------------------------------------------------------

    def _in_space(self, fit: BoardFit) -> str:
        """Say how long squares are in space, and how far cameras stand: a wrong side is seen."""
        sides = sides_in_space(fit, self.board.corners())
        rms = float(np.sqrt(np.mean((sides - self.board.square) ** 2)))
        middle = self.board.corners().mean(axis=0)
        away = [
            f"{c.name} {np.linalg.norm(c.rotation @ middle + c.translation):.3g}"
            for c in fit.cameras
        ]
        return (
            f"In space the sides of squares of {self.board.square:g} come out "
            f"{np.median(sides):.4g} long, off by {rms:.2g} RMS. Cameras stand so far from the "
            f"board of frame {fit.floor}: {', '.join(away)}; if not, the side of a square is "
            "another."
        )

    def _show(self, view: str) -> Callable[[np.ndarray], np.ndarray]:
        """Return where a view, as filmed, shows points."""
        assert self.fitted is not None  # noqa: S101 (asked for with cameras only)
        camera = next(c for c in self.fitted.cameras if c.name == view)
        return lambda xyz: show_points(camera, xyz)

    def _around(self) -> np.ndarray:
        """Return places on the board that gives the axes, and around it: there the grid lies."""
        corners = self.board.corners()
        half = np.ptp(corners, axis=0) / 2
        return np.vstack([corners - half, corners + half])

    def _write(self) -> None:
        rows = [(view, frame, ASIDE) for view, frame in sorted(self.aside)]
        if self.floor is not None:
            rows.append(("", self.floor, FLOOR))
        write_table(pd.DataFrame(rows, columns=list(PICTURE_COLUMNS)), self.path)

    def _look_at_change(self, before: _PicturesState) -> None:
        for view, frame in before.aside ^ self.aside:
            self.current, self.frame = (view, BOARD), frame
        if before.floor != self.floor:
            changed = self.floor if self.floor is not None else before.floor
            self.frame = self.frame if changed is None else changed

    def _read(self) -> _PicturesState:
        """Read the choices there are."""
        where = self.path.name
        table = read_cells(self.path, PICTURE_COLUMNS)
        frames = read_numbers(table, "frame", where=where, whole=True)
        aside, floor = set(), None
        for view, frame, what in zip(table["view"], frames, table["what"], strict=True):
            if what == FLOOR:
                floor = self._checked_frame(int(frame))
            elif what == ASIDE and view in self.sizes:
                aside.add((str(view), self._checked_frame(int(frame))))
            else:
                raise InputError(
                    f"{where}: {what!r} of view {view!r}; expected {ASIDE!r} of "
                    f"{', '.join(self.sizes)}, or {FLOOR!r}."
                )
        return _PicturesState(aside=frozenset(aside), floor=floor)


def _place(uv: np.ndarray) -> list[float] | None:
    """Return a place as JSON has it."""
    return [round(float(x), 2) for x in uv] if np.isfinite(uv).all() else None
