"""*TrackReviewer*: look at tracks over the video, correct them, and track on."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pandas as pd

from pawnb.core.rig import Rig
from pawnb.core.suspects.chances import worth_a_look
from pawnb.core.suspects.frames import find_suspects
from pawnb.core.video import open_views
from pawnb.errors import InputError
from pawnb.files import GuardedFile
from pawnb.schema import Tracks
from pawnb.trial import Trial
from pawnb.widgets.click_initialiser import view_rig
from pawnb.widgets.comparing import DIFFERENCE_KEYS, Comparing
from pawnb.widgets.frame_canvas import MOUSE_AND_KEYS, Overlay, ViewSource
from pawnb.widgets.opened_trial import open_trial
from pawnb.widgets.questions import Questions
from pawnb.widgets.retracking import RetrackTrial, as_sentence, file_beside, say_taken
from pawnb.widgets.review_session import ReviewSession
from pawnb.widgets.timeline import STRETCH_KEYS, TIMELINE_KEYS
from pawnb.workflow.provenance.mended_trial import as_described_now
from pawnb.workflow.provenance.results import results_folder
from pawnb.workflow.reviewing.foreign import Videos, corrected_file, open_foreign

_TRACK_REVIEW_KEYS = (
    ("D", "the next doubtful frame, the most doubtful first"),
    (
        "Drag a point",
        "correct it; the other views show where it lies in them, and how far they are from it. "
        "Let go outside of the picture, or Esc: it stays where it was",
    ),
    ("Click", "place a point that has no ring here, after choosing it above the picture"),
    ("Right click, Delete", "the point is not visible here"),
    ("A, Enter", "the chosen point is right as it is"),
    ("R", "track the corrected points again from this frame on"),
    ("L", "the same, with their colours learnt in this frame"),
    ("Q", "questions about the most doubtful labels, answered by one key each; Q ends them"),
    ("Ctrl+Z, Ctrl+Y", "undo, redo"),
    ("Ctrl+S", "save the tracks"),
)
_MARKS = (
    "Ring: tracked point (dashed: predicted; double: placed by hand). "
    "Hollow diamond: where the other views put it."
)


_AGAIN = ("retrack", "learn")
_LOOKING = ("suspect", "next", "difference", "apart", "stop")

_WHAT_TO_DO = {
    True: "look at the doubtful frames (D: the next), and drag a point that is wrong",
    False: "step through the frames and drag a point that is wrong",
}


class TrackReviewer(Comparing, Questions):
    """Review tracks over the video: all views at once, correct, track again, undo.

    Rings are the tracked points, with a trail of the last 20 frames; hollow diamonds show
    where the other views put each point. Every correction is in ``edits.jsonl``, on disk,
    before another frame is shown, and is applied again when the review is opened again.

    Parameters
    ----------
    trial : Trial, str or Path
        The trial, its ``trial.toml``, or the folder that holds it.
    tracks : xarray.Dataset
        Its tracks, for instance of :func:`pawnb.track`; not modified.
    edits : str or Path, optional
        The file of corrections; default ``results/edits.jsonl`` beside the trial.
    retrack : callable, optional
        ``retrack(trial, tracks, frame) -> Tracks``, given ``learn=True`` as well where colours
        are to be learnt anew; default :func:`pawnb.workflow.tracking.track.retrack`.
    suspects : pandas.DataFrame, optional
        Frames to look at (frame, view, point, reason, score), offered as a menu; default
        those of :func:`pawnb.core.suspects.frames.find_suspects`, found again after tracking again,
        an exchange, and undo. What is corrected or accepted is left out.
    against : xarray.Dataset or "before", optional
        Other tracks of the trial to compare with, for instance those made by hand, drawn as dashed
        rings; ``"before"``: ``tracks`` as they were before any correction. The thin line of each
        lane is then the distance, and a menu and C lead to the largest ones.
    **options
        ``against_name`` (what the others are called), ``out`` (folder for *Save*; default the
        folder of ``edits``), ``write`` (a function that writes the tracks instead; nothing is
        tracked again then), ``views`` and ``rig`` (when they are open already), and the options
        of :class:`FrameCanvas`.

    Attributes
    ----------
    session : ReviewSession
        The tracks under review; works without a browser.
    tracks : xarray.Dataset
        The tracks as corrected so far; can be observed, and set to others of the same trial.
    expected_errors_left : float
        How many labels that nobody has looked at are expected to be wrong.

    Raises
    ------
    InputError
        If the trial, its videos, the tracks or ``edits.jsonl`` cannot be used.
    """

    def __init__(
        self,
        trial: Trial | str | Path,
        tracks: Tracks,
        *,
        edits: str | Path | None = None,
        retrack: RetrackTrial | None = None,
        suspects: pd.DataFrame | None = None,
        against: Tracks | Literal["before"] | None = None,
        against_name: str | None = None,
        out: str | Path | None = None,
        write: Callable[[Tracks], object] | None = None,
        views: ViewSource | None = None,
        rig: Rig | None = None,
        **options: Any,
    ) -> None:
        trial = open_trial(trial)
        self._prepare(trial, retrack)
        self._own_views = open_views(trial, share_memory=True) if views is None else None
        shown: ViewSource = self._own_views if self._own_views is not None else views  # type: ignore[assignment]
        edits = Path(edits or results_folder(trial) / "edits.jsonl").absolute()
        folder = Path(out).absolute() if out is not None else edits.parent
        rig = view_rig(trial, shown) if rig is None else rig
        self._given_doubtful = suspects
        self._answers_file = file_beside(edits, "answers")
        self._count_minutes(edits)
        self._tracks_again = write is None
        save = self._saver(folder, rig=rig) if write is None else write
        self._open_session = partial(
            ReviewSession,
            trial,
            rig=rig,
            edits=edits,
            retrack=self._track_again,
            save=save,
            before=None if write is not None else self._tracks_before(folder),
        )
        self._open_tracks(as_described_now(tracks, trial))
        self._compare_tracks(tracks, against, against_name, rig=rig)
        self._offer_doubtful(self._find_doubtful())
        first, last = self.session.span
        if first >= shown.n_frames:
            raise InputError(
                f"the tracks begin with frame {first}, and the film has {shown.n_frames}, from 0 "
                f"to {shown.n_frames - 1}: they are of another film, or count from the start of a "
                "session; number their frames as those of the film."
            )
        self._times = np.asarray(getattr(shown, "time_s", np.arange(shown.n_frames) / trial.fps))
        span = (first, min(last, shown.n_frames - 1))
        super().__init__(shown, **{"frame": first, "span": span, **options})
        self.label = "Review tracks"
        self.link_views(rig)
        compared = DIFFERENCE_KEYS if against is not None else ()
        own = (*_TRACK_REVIEW_KEYS, *compared, *TIMELINE_KEYS, *STRETCH_KEYS, *MOUSE_AND_KEYS)
        self.keys_help = [list(line) for line in (("Marks", _MARKS), *own)]
        self._prepare_lanes(
            trial,
            self.session.present,
            self.session.colours,
            partners={point: self.session.partners(point) for point in self.session.points},
            does=("swap", "interpolate", "hide", "delete", *_AGAIN[:1] * self._tracks_again),
        )
        self._show_comparison()
        self._opening = self._opening_notes(folder)
        self._show_state(self._opening)

    @classmethod
    def of_file(
        cls, path: str | Path, videos: Videos, *, fps: float | None = None, **options: Any
    ) -> TrackReviewer:
        """Review another program's tracks over their videos, and write them back as they were made.

        *Save* writes ``corrected_<name>`` beside the file, in its format; what nobody touched
        stays as it was, bit by bit. Corrections are in ``<name>.edits.jsonl``. Where frames or
        places do not fit the videos, it is said as the review opens.

        Parameters
        ----------
        path : str or Path
            The file: DeepLabCut, SLEAP, DLTdv, movement and others with points in pictures.
        videos : str, Path, sequence or mapping
            The video of the view, or those of the views, in the order of the file or by name.
        fps : float, optional
            Frames per second, where the file does not say.
        **options
            ``program`` and ``animal`` (see :func:`~pawnb.workflow.reviewing.foreign.open_foreign`)
            and those of :class:`TrackReviewer`.

        Returns
        -------
        TrackReviewer
            The review; nothing is tracked again in it.

        Raises
        ------
        InputError
            If the file or the videos cannot be used.
        """
        told = {name: options.pop(name) for name in ("program", "animal") if name in options}
        foreign = open_foreign(Path(path).absolute(), videos, fps=fps, **told)
        file = foreign.path
        target = GuardedFile(corrected_file(file))
        options = {"edits": file.with_name(f"{file.name}.edits.jsonl"), **options}
        review = cls(
            foreign.trial,
            foreign.tracks,
            write=lambda tracks: foreign.write(tracks, target),
            **options,
        )
        if doubts := foreign.doubts():
            review._show_state(" ".join(["Note:", *doubts, review._opening]).rstrip())
        return review

    def overlay(self, frame: int) -> Overlay:
        """Return what is drawn over a frame."""
        drawn = self.session.overlay(frame) | {"caption": f"{self._times[frame]:.3f} s"}
        drawn |= self._look(frame)
        self._draw_others(frame, drawn["views"], self.session.colours)
        if self._pointed is not None and self._pointed[0] == frame:
            drawn["current"] = list(self._pointed[1:])
        return drawn

    def edit(self, what: str, message: Mapping[str, Any]) -> int | None:
        """Do what a person did; see :meth:`FrameCanvas.edit`."""
        frame = int(message["frame"])
        self._pointed = None  # from here on a person chooses
        view, point = str(message.get("view")), str(message.get("point"))
        if what == "moved":
            u, v = float(message["u"]), float(message["v"])
            self._settle(frame, point, self.session.move(frame, view, point, u=u, v=v))
        elif what == "hide":
            self._settle(frame, point, self.session.hide(frame, view, point))
        elif what == "click":
            self._place_missing(frame, view, message)
        elif what == "action":
            return self._act(str(message["action"]), frame, message)
        elif what == "stretch":
            return self._edit_stretch(message)
        return None

    def close(self) -> None:
        """Take the widget away, stop the tracker, and close the videos it opened."""
        super().close()
        if (own := getattr(self, "_own_views", None)) is not None:
            own.close()

    # --- inside -------------------------------------------------------------------------

    def _open_tracks(self, tracks: Tracks) -> None:
        """Begin the review of some tracks."""
        self._remember(tracks)
        self.session = self.corrected = self._open_session(tracks)

    def _place_missing(self, frame: int, view: str, message: Mapping[str, Any]) -> None:
        """Place the chosen point if this view has none; otherwise a click means nothing."""
        chosen = message.get("selected")
        if chosen and chosen[0] == view and not self.session.is_seen(frame, *chosen):
            u, v = float(message["u"]), float(message["v"])
            self._settle(frame, chosen[1], self.session.move(frame, *chosen, u=u, v=v))

    def _settle(self, frame: int, point: str, said: str) -> None:
        """Say what was corrected; it is not doubtful any more."""
        self._doubt_no_more(frame, point)
        self._show_state(said + self.session.say_seen_once(frame, point))

    def _act(self, action: str, frame: int, message: Mapping[str, Any]) -> int | None:
        """Do what a button, menu or its key asks for; may say which frame to show."""
        value, chosen = message.get("value"), message.get("selected")
        if action in ("undo", "redo"):
            edit = self.session.undo() if action == "undo" else self.session.redo()
            self._tracked_again()
            self._show_state(say_taken(action, edit))
            if self._question is not None:
                return self._ask_again(edit)
            return edit.frame if edit is not None else None
        if action == "accept":
            if not chosen:
                raise InputError("choose a point first: click it, or its name above the picture.")
            self._settle(frame, chosen[1], self.session.accept(frame, *chosen))
        elif action == "swap" and value:
            said = self.session.swap(frame, *self.session.pairs()[int(value)])
            self._tracked_again()  # what it has mended is doubtful no more
            self._show_state(said)
        elif action in _AGAIN and self._tracks_again:
            self.retrack(frame, learn=action == "learn")
        elif action == "stop":
            self._stop.set()
        elif action == "save":
            self.session.save()
            self._show_state("tracks saved")
        elif action in ("suspect", "next"):
            return self._look_at_doubtful(value)
        elif action.partition(" ")[0] in ("ask", "answer"):
            return self._act_on_question(action, value)
        elif action in ("difference", "apart"):
            return self._look_at_difference(value)
        return None

    def _do_to_stretch(
        self, action: str, point: str, stretch: tuple[int, int], message: Mapping[str, Any]
    ) -> int | None:
        """Do what was asked for to a point over a stretch; see :class:`TimelineCanvas`."""
        session, (first, stop), view = self.session, stretch, message.get("view")
        if action == "retrack" and self._tracks_again:
            self.retrack(session.frame_to_track_from(first, stop), stretch=stretch)
            return None
        settled = {point}
        if action == "swap":
            other = str(message["other"])
            settled.add(other)
            if not message.get("stretch"):
                stop = session.next_crossing(first, point, other)
            said = session.swap(first, point, other, stop=stop, view=view)
        elif action == "hide":
            said = session.hide(first, view, point, stop=stop)
        elif action == "delete":
            said = session.delete(first, stop, point, view=view)
        elif action == "interpolate":
            said = session.interpolate(first, stop, point, view=view)
        else:
            raise InputError(f"{action} is nothing that can be done to a stretch.")
        self._tracked_again()
        for name in settled:
            self._doubt_no_more(first, name, stop=stop)
            said += session.say_lost(first, stop, name)
        self._show_state(said)
        return None

    def _find_doubtful(self) -> pd.DataFrame:
        """Return the labels to look at: those that were given, else found anew."""
        found = self._given_doubtful
        if found is None:
            found = find_suspects(self.session.tracks, rig=self.session.rig)
            found = self._leave_out_seen(found)
        return worth_a_look(found)

    def _doubt_no_more(
        self, frame: int, point: str | None = None, *, stop: int | None = None
    ) -> None:
        """Leave out what a person has settled, among those that were given as well."""
        super()._doubt_no_more(frame, point, stop=stop)
        if self._given_doubtful is not None:
            self._given_doubtful = self._doubtful

    def _show_state(self, said: str = "", *, busy: bool = False) -> None:
        """Say what was done, and which buttons can be pressed."""
        session = self.session
        busy = busy or session.busy
        said = as_sentence(said or _WHAT_TO_DO[bool(self._suspects)])
        pairs = [[str(i), f"{a} and {b}"] for i, (a, b) in enumerate(session.pairs())]
        actions: list[dict[str, Any]] = [
            {"id": "retrack", "text": "Track again from here", "keys": ["r"],
             "title": "Track the points corrected in this frame again from here on, every state "
                      "of the tracker reset (R)"},
            {"id": "learn", "text": "… with new colours", "keys": ["l"],
             "title": "The same, and learn the colours of the corrected points in this frame (L)"},
            {"id": "accept", "text": "Accept", "keys": ["a", "Enter"],
             "title": "The chosen point is right as it is (A)"},
            {"id": "swap", "text": "Exchange from here on", "options": pairs,
             "title": "Two points were mistaken for one another from this frame on"},
            {"id": "undo", "text": "Undo", "keys": ["Ctrl+z"],
             "title": "Take back the last correction (Ctrl+Z)", "enabled": session.can_undo},
            {"id": "redo", "text": "Redo", "keys": ["Ctrl+y", "Ctrl+Shift+Z"],
             "title": "Make it again (Ctrl+Y)", "enabled": session.can_redo},
            *self._review_actions(busy=busy),
            *self._question_actions(),
            *self._difference_actions(),
        ]  # fmt: skip
        if self._question is not None:
            actions = self._question_actions()
        for action in actions:
            free = not busy or action["id"] in _LOOKING
            action["enabled"] = action.get("enabled", True) and free
        left_out = [*(() if pairs else ("swap",)), *(() if self._tracks_again else _AGAIN)]
        shown = [action for action in actions if action["id"] not in left_out]
        self._tell(f"{said}\n{self._cost()}", shown)
