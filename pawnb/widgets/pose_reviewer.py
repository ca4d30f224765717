"""*PoseReviewer*: look at tracked poses over the video, correct them, and track on."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any, Literal

import pandas as pd

from pawnb.core.edits.log import Pose
from pawnb.core.video import ViewSet, open_views
from pawnb.errors import InputError
from pawnb.schema import Tracks
from pawnb.trial import Trial
from pawnb.widgets.comparing import DIFFERENCE_KEYS, Comparing
from pawnb.widgets.frame_canvas import NO_PLACING, Overlay
from pawnb.widgets.opened_trial import open_trial
from pawnb.widgets.pose_review_session import PoseReviewSession
from pawnb.widgets.retracking import RetrackTrial, as_sentence, say_taken
from pawnb.widgets.stick_actions import HANDLES, stick_actions
from pawnb.widgets.stick_pose import StickPose
from pawnb.widgets.stick_poser import StickPoser
from pawnb.widgets.stretch_edits import StretchEdits
from pawnb.widgets.timeline import STRETCH_KEYS, TIMELINE_KEYS
from pawnb.workflow.provenance.results import results_folder
from pawnb.workflow.start.propose_pose import pose_view

_IN_SPACE = (
    "Legs of poses in space are not exchanged or interpolated: which leg is which holds in every "
    "view at once, so drag a frame right and track again from there (R)."
)
_AT_WORK = "the poses are being tracked again; look at any frame meanwhile"
_UNMOVED = (
    "That moved nothing, so it is no correction. A leg at full reach goes no further: make it "
    "longer (]), or move the body."
)
_NO_LANE = ("Body", "has no lane and is never exchanged: there is one; it is moved frame by frame")
_POSE_REVIEW_KEYS = (
    *HANDLES,
    ("D", "the next doubtful frame, the most doubtful first"),
    ("A, Enter", "the pose is right as it is"),
    ("T", "fit the pose to the picture, as tracking with the default method begins"),
    ("Shift+N", "the chosen leg back to its natural orientation"),
    ("[, ]", "the chosen leg 2 % shorter, longer"),
    ("Shift+L, Shift+R", "copy the left legs to the right side, the right ones to the left"),
    ("R", "track again both ways from this frame, with its pose as certain"),
    ("Ctrl+Z, Ctrl+Y", "undo, redo"),
    ("Ctrl+S", "save the tracks"),
)


class PoseReviewer(StickPoser, Comparing):
    """Review the tracked poses of a jointed animal: step, correct, track again, undo.

    The stick animal shows the pose of every frame. What a person drags corrects the frame looked
    at; *Track again* then tracks the stretch around it again, both ways, up to where the new
    track meets the old one or the next frame that a person posed. On the timeline legs are
    exchanged, interpolated, hidden and deleted over a stretch. Every correction is in
    ``edits.jsonl``, on disk, at once, and is made again when the review is opened again.

    Parameters
    ----------
    trial : Trial, str or Path
        A trial of kind ``pose``, its ``trial.toml``, or the folder that holds it.
    tracks : xarray.Dataset
        Its tracks, for instance of :func:`pawnb.track`; not modified.
    edits : str or Path, optional
        The file of corrections; default ``results/edits.jsonl`` beside the trial.
    retrack : callable, optional
        ``retrack(trial, tracks, frame) -> Tracks``; default
        :func:`pawnb.workflow.tracking.track.retrack`.
    against : xarray.Dataset or "before", optional
        Other tracks of the trial to compare with; ``"before"``: ``tracks`` as they were before any
        correction. Their tips are dashed rings, and the thin line of each lane is the distance.
    **options
        ``against_name`` (what the others are called), ``out`` (folder for *Save*; default the
        folder of ``edits``), ``frame`` (to begin with),
        ``views`` (when they are open already), and the options of :class:`FrameCanvas`.

    Attributes
    ----------
    session : PoseReviewSession
        The poses under review; works without a browser.
    tracks : xarray.Dataset
        The tracks as corrected so far; can be observed, and set to others of the same trial.

    Raises
    ------
    InputError
        If the tracks are not those of a jointed animal, or the trial, its video or
        ``edits.jsonl`` cannot be used.
    """

    session: PoseReviewSession

    def __init__(
        self,
        trial: Trial | str | Path,
        tracks: Tracks,
        *,
        edits: str | Path | None = None,
        retrack: RetrackTrial | None = None,
        against: Tracks | Literal["before"] | None = None,
        out: str | Path | None = None,
        frame: int | None = None,
        views: ViewSet | None = None,
        **options: Any,
    ) -> None:
        trial = open_trial(trial)
        self._prepare(trial, retrack)
        edits = Path(edits or results_folder(trial) / "edits.jsonl").absolute()
        folder = Path(out).absolute() if out is not None else edits.parent
        self._count_minutes(edits)
        self._open_corrected = partial(
            StretchEdits,
            trial,
            edits=edits,
            retrack=self._track_again,
            save=self._saver(folder),
            before=self._tracks_before(folder),
        )
        shown = open_views(trial, share_memory=True) if views is None else views
        reader = shown.readers[pose_view(trial)]
        self._size = (reader.width, reader.height)
        self._open_tracks(tracks, frame=frame)
        named = options.pop("against_name", None)
        self._compare_tracks(tracks, against, named, listed=[*self.session.colours])
        self._offer_doubtful(self.session.suspects())
        super().__init__(trial, session=self.session, views=shown, **options)
        self._own_views = shown if views is None else None
        self.label = "Review poses"
        compared = DIFFERENCE_KEYS if against is not None else ()
        in_space = self.corrected.present.sizes["space"] == 3
        over = [line for line in STRETCH_KEYS if not (in_space and line[0] in ("X", "N"))]
        told = [("X, N", _IN_SPACE)] if in_space else []
        own = (*_POSE_REVIEW_KEYS, *compared, *TIMELINE_KEYS, *over, *told, _NO_LANE, *NO_PLACING)
        self.keys_help = [list(line) for line in own]
        self._prepare_lanes(
            trial,
            self.corrected.present,
            self.session.colours,
            partners=self.session.partners(),
            does=(*(() if in_space else ("swap", "interpolate")), "hide", "delete", "retrack"),
        )
        self._show_comparison()
        notes = [self._opening_notes(folder), *([_IN_SPACE] if in_space else [])]
        self._show_state(" ".join(note for note in notes if note))

    def overlay(self, frame: int) -> Overlay:
        """Return what is drawn over a frame."""
        drawn = super().overlay(frame)
        self._draw_others(frame, drawn["views"], self.session.colours)
        return drawn

    def edit(self, what: str, message: Mapping[str, Any]) -> int | None:
        """Do what a person did; see :meth:`FrameCanvas.edit`."""
        self.session.go(int(message["frame"]))
        action = str(message.get("action")) if what == "action" else ""
        value = message.get("value")
        if action == "retrack":
            self.retrack(self.session.frame)
        elif action == "stop":
            self._stop.set()
        elif action == "save":
            self.corrected.save()
            self._show_state("Tracks saved.")
        elif action in ("suspect", "next"):
            return self._look_at_doubtful(value)
        elif action in ("difference", "apart"):
            return self._look_at_difference(value)
        elif action in ("undo", "redo"):
            return self._step(action)
        elif what == "stretch":
            return self._edit_stretch(message)
        else:
            return self._correct(what, message)
        return None

    def _open_tracks(self, tracks: Tracks, *, frame: int | None = None) -> None:
        """Begin the review of some tracks."""
        self._remember(tracks)
        self.corrected = self._open_corrected(tracks)
        self.session = PoseReviewSession(self._trial, self.corrected, size=self._size, frame=frame)

    def _do_to_stretch(
        self, action: str, point: str, stretch: tuple[int, int], message: Mapping[str, Any]
    ) -> int | None:
        """Do what was asked for to a leg over a stretch; see :class:`TimelineCanvas`."""
        first, stop = stretch
        if action == "retrack":
            posed = [e.frame for e in self.corrected.corrections if isinstance(e, Pose)]
            begin = next((frame for frame in sorted(posed) if first <= frame < stop), first)
            self.retrack(begin, stretch=stretch)
            return None
        made, settled = self.corrected, [point]
        if action == "swap":
            other = str(message["other"])
            settled.append(other)
            if not message.get("stretch"):
                stop = made.next_crossing(first, point, other)
            said = made.swap(first, point, other, stop=stop)
        elif action == "interpolate":
            said = made.interpolate(first, stop, point)
        elif action == "hide":
            said = made.hide(first, None, point, stop=stop)
        elif action == "delete":
            said = made.delete(first, stop, point)
        else:
            raise InputError(f"{action} is nothing that can be done to a stretch.")
        self._tracked_again()
        for leg in settled:
            self._doubt_no_more(first, leg, stop=stop)
        self._show_state(said)
        return None

    def _step(self, action: str) -> int | None:
        """Undo or redo, say what was done, and look at its frame."""
        before, frame = self.corrected.corrections, self.session.frame
        (self.session.undo if action == "undo" else self.session.redo)()
        now = self.corrected.corrections
        done = max(before, now, key=len)[-1] if len(now) != len(before) else None
        self._tracked_again()
        self._show_state(say_taken(action, done))
        return self.session.frame if self.session.frame != frame else None

    def _correct(self, what: str, message: Mapping[str, Any]) -> int | None:
        """Pass on what may change a pose; one that was corrected is doubtful no more."""
        before, self.session.moved = self.corrected.corrections, True
        go = super().edit(what, message)
        now = self.corrected.corrections
        if now[: len(before)] == before and len(now) == len(before) + 1:
            self._doubt_no_more(now[-1].frame)
            self._show_state()
        elif not self.session.moved:
            self._show_state(_UNMOVED)
        return go

    def _visit(self, frame: int) -> None:
        """Look at a frame before the browser shows it, and choose the leg that it is about."""
        self.session.go(frame)
        if self._pointed is not None and self._pointed[0] == frame:
            if self._pointed[2] in self.session.colours:
                self.session.select(self._pointed[2])
            self._pointed = None  # from here on a person chooses

    def _show_state(self, said: str = "", *, busy: bool = False) -> None:
        """Say what was done, and which buttons can be pressed; few while tracks are made anew."""
        busy = busy or self.corrected.busy
        super()._show_state(as_sentence(said or _AT_WORK * busy), busy=busy)

    def _pose_shown(self, frame: int) -> tuple[StickPose, bool]:
        """Return the pose drawn over a frame, and whether it is only proposed."""
        pose = self.session.pose_at(frame)
        return (self.session.pose, True) if pose is None else (pose, False)

    def _find_doubtful(self) -> pd.DataFrame:
        """Return the frames to look at."""
        return self.session.suspects()

    def _tracked_again(self) -> None:
        """Look for doubtful frames anew, and at the new pose."""
        super()._tracked_again()
        self.session.go(self.session.frame)

    def _kept(self) -> str:
        """Say how many corrections there are, and where."""
        return self._cost()

    def _own_actions(self, *, busy: bool) -> list[dict[str, Any]]:
        """Return what a review does, and what changes a pose."""
        own: list[dict[str, Any]] = [
            {"id": "retrack", "text": "Track again from here", "keys": ["r"],
             "title": "Track both ways from this frame, with its pose as certain (R)"},
            {"id": "accept", "text": "Accept", "keys": ["a", "Enter"],
             "title": "This pose is right: it is kept where other frames are tracked again (A)"},
        ]  # fmt: skip
        own += [*self._review_actions(busy=busy), *self._difference_actions()]
        # these are about the start pose
        unfit = ("propose", "missing", "accept", "scale", "here", "here_too", "drop")
        return [*own, *(a for a in stick_actions(self.session) if a["id"] not in unfit)]
