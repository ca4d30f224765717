"""*CalibrationDigitiser*: cameras from known points, a board or a wand, or the scale of a view."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pandas as pd

from pawnb.core.calibration.balls import snap_to_ball
from pawnb.core.video import ViewSet, open_view
from pawnb.errors import InputError, PawnbError
from pawnb.files import keep_copy
from pawnb.io.boards import Board, read_board
from pawnb.trial import Trial, View
from pawnb.widgets.calibration_pictures import BoardPictures
from pawnb.widgets.calibration_points import PointCalibration
from pawnb.widgets.calibration_wand import WandClicks
from pawnb.widgets.frame_canvas import MOUSE_AND_KEYS, FrameCanvas, Overlay
from pawnb.widgets.scale_clicks import ScaleClicks
from pawnb.workflow.calibration.known_points import read_known_points
from pawnb.workflow.calibration.scale import write_scale
from pawnb.workflow.calibration.wand import read_lenses

_DIGITISER_KEYS = (
    ("Click", "place the point that is asked for; a hollow diamond is where the view shows it"),
    ("Drag a point", "adjust it; the number beside it is its residual in px"),
    ("S", "snap clicks to the centre of the ball or round mark that they are on, or no more"),
    ("X", "set a click, or the picture of a board, aside; again takes it back"),
    ("F", "the board of this frame lies on the floor: it gives the axes"),
    ("C", "measure the scale of one view by two clicks a known distance apart, or by a grid"),
    ("W, Ctrl+S", "write DLTcoefs.csv and lenses.toml"),
    ("Right click, Delete", "take a click away"),
    ("Ctrl+Z, Ctrl+Y", "undo, redo"),
)
_FPS = 25.0


class CalibrationDigitiser(FrameCanvas):
    """Calibrate cameras by known points, by pictures of a board, or by a wand.

    Residuals are shown while points are clicked. As soon as a view is determined, a grid on the
    plane z = 0 and the three axes are drawn over it, so that a wrong geometry is seen even where
    residuals are small. What does not agree is set aside, and every change can be undone. Clicks
    and choices are written to a file at once; the calibration is, on request.

    Parameters
    ----------
    pictures : mapping
        View to its pictures, as filmed (neither cropped nor mirrored): a video, a folder or a glob.
    points : DataFrame, str or Path, optional
        Known positions: ``point, x, y, z``. Six or more, not in one plane, determine a view; eight
        one whose lens bends.
    board : Board, str or Path, optional
        A checkerboard or ChArUco board instead of points, or its ``board.toml``; pictures of one
        number are of one instant.
    wand : float, optional
        The length of a wand instead, whose two ends are clicked in every view, frame by frame.
    lenses : str or Path, optional
        ``lenses.toml`` of the views, for a wand; without it focal lengths are found.
    folder : str or Path
        Where clicks and calibration go; default the current folder.
    trial : Trial, optional
        The trial that a measured scale is written into; its own films are shown as it aligns them.
    **options
        The options of :class:`FrameCanvas`.

    Attributes
    ----------
    session : PointCalibration, BoardPictures, WandClicks or None
        The clicks or pictures; works without a browser.
    measuring : ScaleClicks or None
        The two clicks of a scale, while they are made.

    Raises
    ------
    InputError
        If several or none of points, board and wand are given (without a trial), or a file is
        wrong.

    Examples
    --------
    >>> films = {name: trial.path(view.video) for view in trial.views if (name := view.name)}
    >>> corners = [(f"p{i}{j}{k}", 50.0 * i, 50.0 * j, 50.0 * k)
    ...            for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    >>> known = pd.DataFrame(corners, columns=["point", "x", "y", "z"])
    >>> widget = pawnb.CalibrationDigitiser(films, points=known, folder="sample")
    >>> widget.status.split(".")[0]
    'Click p000 in cam1'
    >>> widget.close()
    """

    def __init__(
        self,
        pictures: Mapping[str, str | Path],
        *,
        points: pd.DataFrame | str | Path | None = None,
        board: Board | str | Path | None = None,
        wand: float | None = None,
        lenses: str | Path | None = None,
        folder: str | Path = ".",
        trial: Trial | None = None,
        **options: Any,
    ) -> None:
        ways = {"points": points, "board": board, "wand": wand}
        given = [name for name, value in ways.items() if value is not None]
        if len(given) > 1:
            raise InputError(f"{' and '.join(given)} are given; calibrate by one of them.")
        if not given and trial is None:
            raise InputError(
                "neither points, board nor wand is given; give a table of known points (point, x, "
                "y, z), a board.toml, the length of a wand, or a trial whose scale is to be "
                "measured."
            )
        known = None if points is None else read_known_points(points)
        found = board if board is None or isinstance(board, Board) else read_board(board)
        self.trial = trial
        offsets = {} if trial is None else _offsets_of(trial, pictures)
        if found is not None and len(set(offsets.values())) > 1:
            raise InputError(
                "the films of the trial were not started together, and pictures of a board are "
                "taken by their number in each file: name films of the board that begin together."
            )
        self._own_views = _open(pictures, offsets)
        self._worker: threading.Thread | None = None
        self._doing = ""
        self._snaps = False
        self.measuring: ScaleClicks | None = None
        self._measured_view = next(iter(pictures))
        sizes = {name: (r.width, r.height) for name, r in self._own_views.readers.items()}
        span = (self._own_views.first_frame, self._own_views.n_frames - 1)
        folder = Path(folder)
        self.session: PointCalibration | BoardPictures | WandClicks | None = None
        if known is not None:
            self.session = PointCalibration(known, sizes=sizes, folder=folder, span=span)
        elif found is not None:
            self.session = BoardPictures(found, pictures, sizes=sizes, folder=folder, span=span)
        elif wand is not None:
            self.session = WandClicks(
                wand, sizes=sizes, folder=folder, span=span, lenses=read_lenses(lenses, list(sizes))
            )
        else:
            self.measuring = ScaleClicks()
        super().__init__(self._own_views, span=span, **options)
        self.label = "Calibrate the views"
        self.keys_help = [list(line) for line in (*_DIGITISER_KEYS, *MOUSE_AND_KEYS)]
        self.tell_selected = True
        self._show_state()
        self.observe(self._look_at, names="frame")

    def overlay(self, frame: int) -> Overlay:
        """Return what is drawn over a frame; see :data:`pawnb.widgets.frame_canvas.Overlay`."""
        if self.measuring is not None:
            told: dict[str, Any] = {name: {"points": [], "chips": []} for name in self._views.names}
            told[self._measured_view] = self.measuring.marks()
            return {"views": told, "current": None}
        if self.session is None:
            return {"views": {}, "current": None}
        current = list(self.session.current) if self.session.current else None
        views = {name: self.session.overlay(name, frame) for name in self._views.names}
        return {"views": views, "current": current}

    def edit(self, what: str, message: Mapping[str, Any]) -> int | None:
        """Do what a person did; see :meth:`FrameCanvas.edit`."""
        frame = int(message["frame"])
        if self._doing:
            raise InputError(f"{self._doing}; wait for its end, then do it again.")
        if self.session is not None:
            self.session.go(frame)
        if what == "action":
            self._act(str(message["action"]), message.get("value"), frame)
        elif self.measuring is not None:
            self._measure(what, message)
        elif self.session is not None:
            self._digitise(what, message)
        if isinstance(self.session, BoardPictures) and self.session.is_stale:
            self._begin("Calibrating again", self.session.refit)
        self._show_state()
        now = frame if self.session is None else self.session.frame
        return now if now != frame else None

    def close(self) -> None:
        """Take the widget away and close its pictures."""
        super().close()
        if (worker := getattr(self, "_worker", None)) is not None:
            worker.join()
        if (own := getattr(self, "_own_views", None)) is not None:
            own.close()

    def wait(self) -> None:
        """Wait until what was begun (finding boards, calibrating) has ended."""
        if self._worker is not None:
            self._worker.join()

    @property
    def doing(self) -> str:
        """What is being done without a person, in words; empty where nothing is."""
        return self._doing

    # --- what a person does -------------------------------------------------------------

    def _digitise(self, what: str, message: Mapping[str, Any]) -> None:
        """Take over a click, a drag, a choice or a removal."""
        session = self.session
        view, point = str(message.get("view")), str(message.get("point"))
        if what == "select" and session is not None:
            session.select(view, point)
        if session is None or isinstance(session, BoardPictures):
            return
        if what in ("click", "moved"):
            u, v = self._snapped(view, float(message["u"]), float(message["v"]), session.frame)
            if what == "click":
                session.click(view, u, v)
            else:
                session.place(view, point, u, v)
        elif what == "hide":
            session.remove(view, point)

    def _snapped(self, view: str, u: float, v: float, frame: int) -> tuple[float, float]:
        """Return the centre of the mark under a click, where clicks snap; else the click."""
        if not self._snaps:
            return u, v
        found = snap_to_ball(self._grey(view, frame), u, v)
        if found is None:
            self.alarm = "No ball or round mark is there: the point lies where it was clicked."
        return (u, v) if found is None else found

    def _grey(self, view: str, frame: int) -> np.ndarray:
        """Return a picture in grey, (H, W) uint8."""
        with self._video_lock:
            image = self._views.frame(frame)[view].image()
        return np.asarray(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY) if image.ndim == 3 else image)

    def _act(self, action: str, value: Any, frame: int) -> None:
        """Do what a button, its key or a slider asks for."""
        session = self.session
        if action == "snap":
            self._snaps = not self._snaps
        elif action == "scale":
            self.measuring = ScaleClicks() if self.measuring is None else None
        elif action == "known_length" and self.measuring is not None:
            self.measuring.set_length(float(value))
        elif action == "grid" and self.measuring is not None:
            self.measuring.take_grid(self._grey(self._measured_view, frame))
        elif action == "use_scale":
            self._use_scale()
        elif session is None:
            raise InputError(f"{action} is no action of this widget.")
        elif action == "undo":
            session.undo()
        elif action == "redo":
            session.redo()
        elif action == "save":
            self._save(session)
        elif action == "find" and isinstance(session, BoardPictures):
            self._begin("Looking for the board", lambda: session.find(self._progress))
        elif action == "fit" and isinstance(session, WandClicks):
            self._begin("Calibrating", session.refit)
        else:
            session.act(action)

    def _save(self, session: PointCalibration | BoardPictures | WandClicks) -> None:
        """Write the calibration; one that was there before this widget is kept beside it."""
        for name in ("DLTcoefs.csv", "lenses.toml"):
            if session.written is None and (session.folder / name).exists():
                keep_copy(session.folder / name, "before")
        session.save_calibration()

    def _measure(self, what: str, message: Mapping[str, Any]) -> None:
        """Place an end of the known length; in another view it begins anew."""
        if self.measuring is None or what not in ("click", "moved"):
            return
        view, u, v = str(message["view"]), float(message["u"]), float(message["v"])
        if what == "moved":
            self.measuring.move(str(message["point"]), u, v)
            return
        if view != self._measured_view:
            self.measuring, self._measured_view = ScaleClicks(self.measuring.length), view
        self.measuring.click(u, v)

    def _use_scale(self) -> None:
        """Write the measured scale into the trial."""
        found = None if self.measuring is None else self.measuring.result()
        if found is None:
            raise InputError("click both ends of a known length first.")
        if self.trial is None:
            raise InputError(
                f"the scale is {found.px_per_unit:.4g} px per unit, but no trial was given to "
                "write it into: CalibrationDigitiser(..., trial=trial)."
            )
        self.trial = write_scale(self.trial, found.px_per_unit)

    # --- what takes a while -------------------------------------------------------------

    def _begin(self, doing: str, work: Callable[[], None]) -> None:
        """Do something in a thread of its own; clicks wait for its end, pictures do not."""

        def run() -> None:
            try:
                work()
            except PawnbError as error:
                self.alarm = str(error)
            finally:
                self._doing = ""
                with self._edit_lock:
                    self._show_state()
                self.refresh()

        self._doing = doing
        self._worker = threading.Thread(target=run, name="pawnb-calibration", daemon=True)
        self._worker.start()

    def _progress(self, done: int, total: int) -> None:
        """Say how many pictures have been looked at."""
        self.status = f"{self._doing}: {done} of {total} pictures ..."

    def _look_at(self, change: Mapping[str, Any]) -> None:
        """Follow a person to another frame."""
        with self._edit_lock:
            if self.session is not None and change["new"] != self.session.frame:
                self.session.go(int(change["new"]))
                self._show_state()

    # --- in words -----------------------------------------------------------------------

    def _show_state(self) -> None:
        """Say what is to be done, and which buttons can be pressed."""
        self.sliders = []
        if self._doing:
            self._tell(f"{self._doing} ...", [])
        elif self.measuring is not None:
            self._show_measuring(self.measuring)
        elif self.session is not None:
            session = self.session
            kept = f"Saved in {session.path.name}." if session.saved else ""
            if session.written is not None:
                lines = session.written.lines()
                kept += f" Wrote {' and '.join(Path(f).name for f in session.written.files())}: "
                kept += lines[-1]
            actions = [*session.actions(), *self._common(session)]
            self._tell(f"{session.prompt()}\n{kept}".rstrip(), actions)

    def _common(
        self, session: PointCalibration | BoardPictures | WandClicks
    ) -> list[dict[str, Any]]:
        """Return the buttons that both kinds of calibration have."""
        snap = {"id": "snap", "text": "Snap: on" if self._snaps else "Snap: off", "keys": ["s"],
                "title": "Let clicks snap to the centre of the ball they are on (S)"}  # fmt: skip
        return [
            *([] if isinstance(session, BoardPictures) else [snap]),
            {"id": "scale", "text": "Scale", "keys": ["c"],
             "title": "Measure the scale of one view by two clicks (C)"},
            {"id": "undo", "text": "Undo", "keys": ["Ctrl+z"], "enabled": session.can_undo,
             "title": "Take back the last change (Ctrl+Z)"},
            {"id": "redo", "text": "Redo", "keys": ["Ctrl+y", "Ctrl+Shift+Z"],
             "enabled": session.can_redo, "title": "Make it again (Ctrl+Y)"},
            {"id": "save", "text": "Write calibration", "keys": ["w", "Ctrl+s"],
             "enabled": session.can_save, "title": "Write DLTcoefs.csv and lenses.toml (W)"},
        ]  # fmt: skip

    def _show_measuring(self, measuring: ScaleClicks) -> None:
        """Say what to click for the scale."""
        calibration = None if self.trial is None else self.trial.calibration
        unit = "mm" if calibration is None else calibration.unit
        found = measuring.result()
        words = "" if found is None else f"\n{self._measured_view}: {found.text(unit)}."
        self.sliders = [
            {"id": "known_length", "text": f"Known length, {unit}", "number": True, "min": 0,
             "max": None, "step": "any", "value": measuring.length,
             "title": "How far apart the two ends are"},
        ]  # fmt: skip
        leave = {"id": "scale", "text": "Leave", "keys": ["c"], "title": "Back to the points (C)"}
        actions: list[dict[str, Any]] = [
            {"id": "use_scale", "text": "Use this scale", "keys": ["Enter"],
             "enabled": found is not None, "title": "Write px_per_unit into trial.toml (Enter)"},
            {"id": "grid", "text": "Find a grid",
             "title": "Its lines are the known length apart; choose a frame without the animal"},
            *([leave] if self.session is not None else []),
        ]  # fmt: skip
        self._tell(f"{measuring.prompt(unit)}{words}", actions)


def _offsets_of(trial: Trial, pictures: Mapping[str, str | Path]) -> dict[str, int]:
    """Return the offsets of a trial's own films, where these are clicked in; else 0."""
    own = {view.name: view for view in trial.views}
    return {
        name: own[name].offset
        if name in own and Path(path).absolute() == trial.path(own[name].video).absolute()
        else 0
        for name, path in pictures.items()
    }


def _open(pictures: Mapping[str, str | Path], offsets: Mapping[str, int]) -> ViewSet:
    """Open the pictures of each view, as filmed."""
    if not pictures:
        raise InputError("no pictures are given; name those of each view: {'side': 'side.mp4'}.")
    readers = {
        str(name): open_view(View(name=str(name), video=str(Path(path).absolute())), Path())
        for name, path in pictures.items()
    }
    return ViewSet(readers, fps=_FPS, offsets=offsets)
