"""*ClickInitialiser*: click every point once, in one frame or more, and tracking can begin."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from pawnb.core.rig import Rig, load_rig
from pawnb.core.video import open_views
from pawnb.core.video.doubts.exchanged_films import film_codes, tell_other_films
from pawnb.errors import InputError
from pawnb.io.start import clicked_films
from pawnb.trial import Trial
from pawnb.widgets.frame_canvas import MOUSE_AND_KEYS, FrameCanvas, Overlay, ViewSource
from pawnb.widgets.opened_trial import open_trial
from pawnb.widgets.start_session import StartSession
from pawnb.widgets.start_words import what_contradicts
from pawnb.workflow.start.propose import StartProposal, propose_paws

_CLICK_KEYS = (
    ("Click", "place the point that is asked for; the next is asked for by itself"),
    (
        "Drag a point",
        "adjust it; the number beside it is its distance in px from where the other views put it",
    ),
    ("H", "the point that is asked for is hidden in this view"),
    ("Right click, Delete", "take a point away: it is hidden here"),
    ("Ctrl+Z, Ctrl+Y", "undo, redo"),
)


class ClickInitialiser(FrameCanvas):
    """Click the start points of a trial in all its views.

    The next point is asked for by itself, view by view. Where the views are calibrated, a
    dashed line shows where a point clicked in one other view must lie, and a hollow
    diamond where two others say it is. Every change is written to ``start.csv`` at once.
    Any frame will do: method ``pawnb`` tracks both ways from it. Points may be clicked in further
    frames, any of them in each, and :func:`pawnb.suggest_frames` says where that helps most.

    Parameters
    ----------
    trial : Trial, str or Path
        The trial, its ``trial.toml``, or the folder that holds it.
    frame : int, optional
        Frame to begin with; default the first that has clicks, else the first.
    start : pandas.DataFrame, optional
        Clicks to begin with (frame, view, point, u, v in px); default those in the file.
    propose : bool or StartProposal
        Whether to offer points to accept or drag, drawn dashed, those of
        :func:`pawnb.propose_start`, or a proposal that was made before. Where none can be
        made it is said why, and the points are clicked.
    **options
        ``path`` (file for the clicks; default the trial's ``[start] points``, else
        ``start.csv`` beside the trial), ``views`` and ``rig`` (when they are open already),
        and the options of :class:`FrameCanvas`.

    Attributes
    ----------
    session : StartSession
        The clicks; works without a browser.

    Raises
    ------
    InputError
        If the trial, its videos or the clicks there are cannot be used.
    """

    def __init__(
        self,
        trial: Trial | str | Path,
        *,
        frame: int | None = None,
        start: pd.DataFrame | None = None,
        propose: bool | StartProposal = False,
        path: str | Path | None = None,
        views: ViewSource | None = None,
        rig: Rig | None = None,
        **options: Any,
    ) -> None:
        trial = open_trial(trial)
        self._own_views = open_views(trial, share_memory=True) if views is None else None
        shown: ViewSource = self._own_views if self._own_views is not None else views  # type: ignore[assignment]
        self.session = StartSession(
            trial,
            sizes={name: (r.width, r.height) for name, r in shown.readers.items()},
            span=trial_span(trial, shown),
            frame=frame,
            start=start,
            rig=view_rig(trial, shown) if rig is None else rig,
            path=path,
            films=film_codes(shown.readers),
        )
        self._proposal = self._reason = ""
        exchanged = tell_other_films(self.session.films, clicked_films(self.session.path))
        self._exchanged = "".join(f"⚠ {text}.\n" for text in exchanged)
        if propose:
            self._propose(trial, propose)
        super().__init__(shown, frame=self.session.frame, span=self.session.span, **options)
        self.label = "Click the start points"
        self.link_views(self.session.rig)
        self.keys_help = [list(line) for line in (*_CLICK_KEYS, *MOUSE_AND_KEYS)]
        self.tell_selected = True
        self._show_state()
        self.observe(self._look_at, names="frame")

    @property
    def start(self) -> pd.DataFrame:
        """The clicks so far, as :func:`pawnb.track` takes them for ``start``."""
        return self.session.table()

    def overlay(self, frame: int) -> Overlay:
        """Return what is drawn over a frame."""
        return self.session.overlay(frame)

    def edit(self, what: str, message: Mapping[str, Any]) -> int | None:
        """Do what a person did; see :meth:`FrameCanvas.edit`."""
        session = self.session
        session.go(int(message["frame"]))
        view, point = message.get("view"), message.get("point")
        before = session.frame
        if what == "click":
            session.click(str(view), float(message["u"]), float(message["v"]))
        elif what == "moved":
            session.place(str(view), str(point), float(message["u"]), float(message["v"]))
        elif what == "select":
            session.select(str(view), str(point))
        elif what == "hide":
            session.hide(str(view), str(point))
        elif what == "action":
            self._act(message["action"])
        self._show_state()
        return session.frame if session.frame != before else None

    def close(self) -> None:
        """Take the widget away and close the videos it opened."""
        super().close()
        if (own := getattr(self, "_own_views", None)) is not None:
            own.close()

    def _propose(self, trial: Trial, propose: bool | StartProposal) -> None:
        """Offer a proposal, and say in words how sure it is."""
        try:
            proposal = propose if isinstance(propose, StartProposal) else propose_paws(trial)
        except InputError as error:  # all points can be clicked as well
            self._reason = f"No paws are proposed: {error} "
            return
        self.session.propose(proposal.start)
        each = "; ".join(f"{row.point} {row.words}" for row in proposal.points.itertuples())
        self._proposal = " ".join([f"Proposed: {each}.", *proposal.notes, ""])

    def _act(self, action: str) -> None:
        """Do what a button or its key asks for."""
        if action == "accept":
            self.session.accept_all()
        elif action == "undo":
            self.session.undo()
        elif action == "redo":
            self.session.redo()
        elif action == "skip":
            self.session.hide()

    def _look_at(self, change: Mapping[str, Any]) -> None:
        """Ask for the points of the frame that a person went to."""
        with self._edit_lock:
            if change["new"] != self.session.frame:
                self.session.go(int(change["new"]))
                self._show_state()
                self.refresh()

    def _show_state(self) -> None:
        session = self.session
        file = (
            f"Saved in {session.path.name}." if session.saved else "Every click is saved at once."
        )
        offered = bool(session.offered())
        said = self._proposal if offered else ""
        contradiction = what_contradicts(session)
        warned = f"⚠ {contradiction}\n" if contradiction else ""
        clicked = f"{there} " if (there := session.clicked()) else ""
        state = f"{self._exchanged}{warned}{said}{clicked}{session.missing()} {file}"
        actions: list[dict[str, Any]] = [
            {"id": "skip", "text": "Hidden here", "keys": ["h"],
             "title": "The point that is asked for cannot be seen in this view (H)",
             "enabled": session.current is not None},
            {"id": "undo", "text": "Undo", "title": "Take back the last change (Ctrl+Z)",
             "keys": ["Ctrl+z"], "enabled": session.can_undo},
            {"id": "redo", "text": "Redo", "title": "Make it again (Ctrl+Y)",
             "keys": ["Ctrl+y", "Ctrl+Shift+Z"], "enabled": session.can_redo},
        ]  # fmt: skip
        if offered:
            accept = {"id": "accept", "text": "Accept all", "keys": ["Enter"]}
            title = "Take every proposed point of this frame as it is (Enter)"
            actions = [accept | {"title": title}, *actions]
        self._tell(f"{self._reason}{session.prompt()}\n{state}", actions)


def trial_span(trial: Trial, views: ViewSource) -> tuple[int, int]:
    """Return the first and last frame of a trial that every view has."""
    first, stop = trial.frames or (getattr(views, "first_frame", 0), views.n_frames)
    return max(first, getattr(views, "first_frame", 0)), min(stop, views.n_frames) - 1


def view_rig(trial: Trial, views: ViewSource) -> Rig | None:
    """Return the calibrated views of a trial, or None where nothing is calibrated."""
    readers = views.readers.items()
    sizes = {n: (r.source.width, r.source.height) for n, r in readers if hasattr(r, "source")}
    return load_rig(trial, sizes=sizes)
