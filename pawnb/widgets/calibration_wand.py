"""Clicking the two ends of a wand: everything the widget does, without the widget.

Each change is written to ``calibration_wand.csv`` at once, which ``pawnb calibrate --wand`` reads,
too.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pawnb.core.calibration.optics import show_points
from pawnb.core.calibration.rig_from_wand import FEWEST_FRAMES, WandFit
from pawnb.core.calibration.scene_lines import scene_lines
from pawnb.core.lens import Lens
from pawnb.errors import InputError
from pawnb.widgets.calibration_clicks import ClickDraft, ClickState
from pawnb.widgets.calibration_points import ASIDE_COLOUR
from pawnb.workflow.calibration.wand import WAND_COLUMNS, calibrate_ends, read_ends
from pawnb.workflow.calibration.written import Written, write_calibration

WAND_FILE = "calibration_wand.csv"
WAND_COLOURS = {"end 1": "#e69f00", "end 2": "#56b4e9"}
"""Both ends and their colours (Okabe & Ito 2008)."""


Slot = tuple[str, int, str]
"""View, frame and end."""


class WandClicks(ClickDraft[ClickState]):
    """The clicks on both ends of a wand, and the cameras that they determine.

    Parameters
    ----------
    length : float
        Distance of the two ends, in the unit that the calibration will have.
    sizes : mapping of str to tuple of int
        Width and height of each view, px.
    folder : Path
        Where the clicks and the calibration go.
    span : tuple of int
        First and last frame.
    lenses : tuple of Lens
        Lenses that are known, one a view; without them focal lengths are found.

    Attributes
    ----------
    frame : int
        The frame looked at.
    current : tuple of str or None
        View and end that are asked for, or chosen.
    fitted : WandFit or None
        The cameras of the clicks as they were when it was last calibrated.

    Raises
    ------
    InputError
        If the length is not above 0, or the clicks there are cannot be used.
    """

    def __init__(
        self,
        length: float,
        *,
        sizes: Mapping[str, tuple[int, int]],
        folder: Path,
        span: tuple[int, int],
        lenses: tuple[Lens, ...] = (),
    ) -> None:
        super().__init__(folder / WAND_FILE, sizes=sizes, span=span)
        if not (np.isfinite(length) and length > 0):
            raise InputError(f"the wand is {length:g} long; expected a length above 0.")
        self.length, self.lenses, self.names = float(length), lenses, tuple(WAND_COLOURS)
        self.fitted: WandFit | None = None
        self._state = self._read() if self.path.exists() else ClickState()
        self._fitted_state: ClickState | None = None
        self._offer_next()

    # --- what there is ------------------------------------------------------------------

    @property
    def can_save(self) -> bool:
        """Whether there are cameras of the clicks as they are."""
        return self.fitted is not None and self._fitted_state == self._state

    def n_frames(self) -> int:
        """Return in how many frames two views or more have both ends."""
        whole = {
            (v, f) for v, f, end in self._state.clicks
            if (v, f) not in self.aside
            and all((v, f, e) in self._state.clicks for e in WAND_COLOURS)
        }  # fmt: skip
        frames = [f for _, f in whole]
        return sum(frames.count(f) >= 2 for f in set(frames))

    def table(self) -> pd.DataFrame:
        """Return the clicks as they are saved: frame, view, point, u, v, set_aside."""
        rows = sorted(
            (frame, list(self.sizes).index(view), end, *uv, int((view, frame) in self.aside))
            for (view, frame, end), uv in self._state.clicks.items()
        )
        names = list(self.sizes)
        return pd.DataFrame(
            [(frame, names[v], *rest) for frame, v, *rest in rows],
            columns=[*WAND_COLUMNS, "set_aside"],
        )

    # --- what a person does -------------------------------------------------------------

    def go(self, frame: int) -> None:
        """Look at another frame."""
        if frame != self.frame:
            super().go(frame)
            self._offer_next()

    def refit(self) -> None:
        """Calibrate by the clicks that are not set aside."""
        state = self._state
        used = self.table()
        fit = calibrate_ends(
            used[used["set_aside"] == 0], self.length, sizes=self.sizes, lenses=self.lenses
        )
        self.fitted, self._fitted_state = fit, state

    def act(self, action: str) -> None:
        """Do what a button asks for."""
        if action != "aside":
            raise InputError(f"{action} is no action of this widget.")
        if self.current is None:
            raise InputError("no view is chosen; click a button above one, then press X.")
        self._make(replace(self._state, aside=self.aside ^ {(self.current[0], self.frame)}))

    def save_calibration(self) -> Written:
        """Write ``DLTcoefs.csv`` and, where lenses bend, ``lenses.toml``."""
        if self.fitted is None or not self.can_save:
            raise InputError("there are no cameras of these clicks yet; press Enter first.")
        self.written = write_calibration(self.fitted.cameras, self.folder / "DLTcoefs.csv")
        return self.written

    # --- in words, and drawn --------------------------------------------------------------

    def prompt(self) -> str:
        """Say what to do next, how well it fits, and what was set aside."""
        n, ready = self.n_frames(), self.n_frames() >= FEWEST_FRAMES
        open_end = self.current is not None and (
            (self.current[0], self.frame, self.current[1]) not in self._state.clicks
        )
        first = (
            f"Click {self.current[1]} of the wand in {self.current[0]}."
            if open_end and self.current
            else "Both ends are placed in every view: go to another frame."
        )
        lines = [first + (" Press Enter to calibrate." if ready and not self.can_save else "")]
        if self.fitted is None:
            lines.append(
                f"{n} frame{'' if n == 1 else 's'} with both ends in two views; {FEWEST_FRAMES} "
                "are needed, the wand all over the space and turned in all directions."
            )
        else:
            table = self.fitted.errors
            good = table[~table["set_aside"]]
            rms = good.groupby("view", sort=False)["error_px"].agg(
                lambda e: float(np.sqrt(np.mean(np.square(e))))
            )
            said = "; ".join(f"{view}: {value:.2f} px RMS" for view, value in rms.items())
            aside = [
                f"{r.view} {r.frame} ({r.error_px:.1f} px)"
                for r in table[table["set_aside"]].itertuples()
            ]
            lines.append(f"{said} of {good['frame'].nunique()} frames." + (
                f" Set aside: {', '.join(aside)}." if aside else ""
            ))  # fmt: skip
            away = [f"{c.name} {np.linalg.norm(c.translation):.3g}" for c in self.fitted.cameras]
            lines.append(
                f"Cameras stand so far from where the axes are drawn: {', '.join(away)}; if not, "
                "the wand is of another length. x is taken for forward and z for up."
            )
        return "\n".join(lines)

    def actions(self) -> list[dict[str, Any]]:
        """Return the buttons of this kind of calibration."""
        return [
            {"id": "fit", "text": "Calibrate", "keys": ["Enter"],
             "enabled": self.n_frames() >= FEWEST_FRAMES and not self.can_save,
             "title": "Find the cameras from the wand (Enter)"},
            {"id": "aside", "text": "Set aside", "keys": ["x"], "enabled": self.current is not None,
             "title": "Leave out this frame of the chosen view; again takes it back (X)"},
        ]  # fmt: skip

    def overlay(self, view: str, frame: int) -> dict[str, Any]:
        """Return what is drawn over a view at a frame; see ``frame_canvas.Overlay``."""
        is_aside = (view, frame) in self.aside
        points, chips = [], []
        for end, colour in WAND_COLOURS.items():
            uv = self._state.clicks.get((view, frame, end))
            state, words = "open", "not clicked at this frame"
            if uv is not None:
                shown = ASIDE_COLOUR if is_aside else colour
                origin = "predicted" if is_aside else "measured"
                points.append(
                    {"id": end, "u": uv[0], "v": uv[1], "colour": shown, "origin": origin}
                )
                state = "hidden" if is_aside else "done"
                words = f"at ({uv[0]:.1f}, {uv[1]:.1f}){self._off(view, frame)}"
            chips.append({"id": end, "colour": colour, "state": state, "title": f"{end}: {words}"})
        at = [[p["u"], p["v"]] for p in points]
        lines: list[dict[str, object]] = []
        if len(at) == len(WAND_COLOURS):
            lines.append({"at": at, "colour": ASIDE_COLOUR if is_aside else "#ffffff"})
        hollow: list[dict[str, object]] = []
        if self.fitted is not None:
            camera = next(c for c in self.fitted.cameras if c.name == view)
            reach = np.array([[-1.0, -1.0, 0.0], [1.0, 1.0, 0.0]]) * self.length
            axes, hollow = scene_lines(lambda xyz: show_points(camera, xyz), around=reach)
            lines += axes
        asks = self.asked_in(view) if frame == self.frame else None
        return {"points": points, "hollow": hollow, "lines": lines, "chips": chips, "asks": asks}

    # --- inside -------------------------------------------------------------------------

    def _off(self, view: str, frame: int) -> str:
        """Return words for how far a place of the wand is from where its camera shows it."""
        if self.fitted is None:
            return ""
        table = self.fitted.errors
        rows = table[(table["view"] == view) & (table["frame"] == frame)]
        return f", {rows['error_px'].iloc[0]:.2f} px off" if len(rows) else ""

    def _is_asked(self, current: tuple[str, str], view: str, free: Sequence[str]) -> bool:
        return current[0] == view and current[1] in free

    def _all_clicked(self, view: str) -> str:
        return f"both ends are placed in {view} at frame {self.frame}; drag one."

    def _look_at_change(self, before: ClickState) -> None:
        for view, frame, end in self._changed_slots(before):
            self.frame, self.current = frame, (view, end)
        for view, frame in before.aside ^ self.aside:
            self.frame, self.current = frame, (view, next(iter(WAND_COLOURS)))

    def _slot(self, view: str, end: str) -> Slot:
        """Return view, frame and end, refusing unknown ones."""
        if view not in self.sizes or end not in WAND_COLOURS:
            raise InputError(
                f"there is no {end!r} in view {view!r}; a wand has {' and '.join(WAND_COLOURS)}."
            )
        return view, self.frame, end

    def _read(self) -> ClickState:
        """Read the clicks there are."""
        clicks, aside = {}, set()
        columns = read_ends(self.path)
        for frame, view, end, u, v, is_aside in columns.itertuples(index=False, name=None):
            self._slot(str(view), str(end))
            clicks[str(view), self._checked_frame(int(frame)), str(end)] = (float(u), float(v))
            if is_aside:
                aside.add((str(view), int(frame)))
        return ClickState(clicks=clicks, aside=frozenset(aside))
