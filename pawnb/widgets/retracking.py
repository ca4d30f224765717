"""Tracking again from a widget: in a thread of its own, with progress and a way to stop it."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import traitlets

from pawnb.core.edits.log import Edit, describe_edit
from pawnb.core.edits.working_time import WorkingTime
from pawnb.core.rig import Rig
from pawnb.errors import InputError, PawnbError
from pawnb.files import GuardedFile
from pawnb.io.native import read_tracks, write_tracks
from pawnb.schema import Tracks, add_provenance
from pawnb.trial import Trial
from pawnb.widgets.corrected_tracks import WAIT
from pawnb.widgets.review_session import suspect_options
from pawnb.widgets.timeline import TimelineCanvas
from pawnb.widgets.tracks_trait import TracksTrait
from pawnb.workflow.export.film import export_film
from pawnb.workflow.export.sheet import export_sheet
from pawnb.workflow.provenance.manifest import MANIFEST, PUT_ASIDE, find_fault
from pawnb.workflow.provenance.results import provenance_steps, write_track_results
from pawnb.workflow.reviewing.quality import assess_quality
from pawnb.workflow.tracking.track import retrack as workflow_retrack

_NOT_SAVED = (
    "the tracks were not saved, and every correction is in its file: open the review again on the "
    "tracks that are there"
)

_BEFORE = "tracks.before.nc"
"""File of results that holds the tracks as they were before any correction."""
_LEAST_MIN = 0.1
"""Less work is not spoken of."""

Doubt = tuple[int, str, str, str]
"""Frame, view, point and reason."""

RetrackTrial = Callable[..., Tracks]


class Retracking(TimelineCanvas):
    """A canvas whose tracks can be tracked again.

    What stands on it has the corrections (``corrected``), finds the doubtful frames
    (:meth:`_find_doubtful`), says how things stand (:meth:`_show_state`), and calls
    :meth:`_prepare` before anything else.
    """

    corrected: Any  # CorrectedTracks; traitlets wants no stricter word here

    tracks = TracksTrait()
    counts_minutes = traitlets.Bool(default_value=True).tag(sync=True)

    def _prepare(self, trial: Trial, retrack: RetrackTrial | None) -> None:
        """Remember the trial and how it is tracked again."""
        self._trial, self._retrack_trial = trial, retrack
        self._stop = threading.Event()
        self._doing = ""
        self._worker: threading.Thread | None = None
        self._pointed: tuple[int, str, str] | None = None  # frame, view, point jumped to
        self._looked: set[Doubt] = set()
        self._uncorrected: Tracks | None = None
        self._offer_doubtful(None)

    def _count_minutes(self, edits: Path) -> None:
        """Begin to count how long a person works, in a file beside the corrections."""
        self.working_time = WorkingTime(file_beside(edits, "minutes"))

    def effort(self) -> dict[str, float]:
        """Return what the review has cost: minutes without pauses, and corrections in force.

        Returns
        -------
        dict
            ``minutes``, over all sessions, and ``corrections``.
        """
        n = len(self.corrected.corrections)
        return {"minutes": self.working_time.minutes, "corrections": n}

    def _receive(self, widget: Any, message: dict[str, Any], buffers: Any) -> None:
        """Answer one message of the browser; of some only the time counts."""
        if message.get("type") in ("edit", "active"):
            self.working_time.hear()
        super()._receive(widget, message, buffers)

    def _cost(self) -> str:
        """Say how many corrections there are, in which file, and what they have cost."""
        n, path = len(self.corrected.corrections), self.corrected.edits
        kept = "" if path is None else f" in {path.name}"
        minutes = self.working_time.minutes
        spent = f", {minutes:.1f} min of work" if minutes >= _LEAST_MIN else ""
        return f"{n} correction{'' if n == 1 else 's'}{kept}{spent}."

    def _saver(self, folder: Path, *, rig: Rig | None = None) -> Callable[[Tracks], None]:
        """Return what writes tracks into a folder, unless others came there meanwhile.

        The tracks from before any correction are kept beside them, so that everything can be
        undone also when the review is opened again.
        """
        guard = GuardedFile(folder / "tracks.nc")

        def save(tracks: Tracks) -> None:
            self.working_time.keep()
            spent = {name: round(value, 1) for name, value in self.effort().items()}
            with guard.writing(refused=_NOT_SAVED):
                reviewed = add_provenance(tracks, step="review", **spent)
                write_track_results(reviewed, folder, rig=rig)
            if self._uncorrected is not None and self.corrected.corrections:
                write_tracks(self._uncorrected, folder / _BEFORE)

        return save

    def _tracks_before(self, folder: Path) -> Callable[[], Tracks] | None:
        """Return what reads the tracks from before any correction; None where they are not kept."""
        path = folder / _BEFORE
        return partial(read_tracks, path) if path.exists() else None

    def _remember(self, tracks: Tracks) -> None:
        """Remember tracks that hold no correction yet, to keep them when others are saved."""
        edited = any(step["step"] == "edit" for step in provenance_steps(tracks))
        self._uncorrected = None if edited else tracks

    def _opening_notes(self, folder: Path) -> str:
        """Return what to know of the file of corrections and of the results they belong to."""
        written = any((folder / name).exists() for name in (MANIFEST, PUT_ASIDE))
        fault = find_fault(folder, run="track") if written else None
        return " ".join([*self.corrected.notes, *([fault] if fault else [])])

    def _offer_doubtful(self, found: pd.DataFrame | None) -> None:
        """Take over which frames are to be looked at: those of ``suspects.csv``, in its order."""
        self._doubtful = found
        self._suspects = suspect_options(found)
        self._place = 0  # where in the list the next one is looked for

    def _doubt_no_more(
        self, frame: int, point: str | None = None, *, stop: int | None = None
    ) -> None:
        """Leave out what a person has settled: a point or all of a frame, or of a stretch."""
        if self._doubtful is None:
            return
        last = frame if stop is None else stop - 1
        settled = self._doubtful["frame"].between(frame, last).to_numpy()
        if point is not None:
            settled = settled & (self._doubtful["point"] == point).to_numpy()
        place = self._place - int(settled[: self._place].sum())
        self._offer_doubtful(self._doubtful[~settled])
        self._place = place

    def _look_at_doubtful(self, value: Any) -> int | None:
        """Go to a doubtful frame, the next without a value; say what is doubtful, and choose it."""
        place = int(value) if value else self._next_doubtful()
        if self._doubtful is None or place is None or not 0 <= place < len(self._suspects):
            self._show_state("That was the last of the doubtful frames.")
            return None
        self._place = place + 1
        self._looked.add(self._doubt(place))
        frame, view, point, _ = self._doubt(place)
        self._pointed = (frame, view, point)
        text = self._suspects[place][1]
        self._visit(frame)
        self._show_state(f"Doubtful {place + 1} of {len(self._suspects)}, {text}.")
        return frame

    def _next_doubtful(self) -> int | None:
        """Return the next place in the list that was not looked at yet, from the top at its end."""
        n = len(self._suspects)
        order = [*range(self._place, n), *range(min(self._place, n))]
        return next((place for place in order if self._doubt(place) not in self._looked), None)

    def _doubt(self, place: int) -> Doubt:
        """Return frame, view, point and reason at a place of the list."""
        assert self._doubtful is not None  # noqa: S101 (a list with places)
        row = self._doubtful.iloc[place]
        return int(row["frame"]), str(row["view"]), str(row["point"]), str(row["reason"])

    def _take_tracks(self, tracks: Tracks) -> None:
        """Review other tracks of the same trial, as if the review were opened on them."""
        before = self.corrected.present
        for what in ("view", "keypoint"):
            names, had = ([str(n) for n in some[what].to_numpy()] for some in (tracks, before))
            if names != had:
                raise InputError(
                    f"these tracks have other {what}s ({', '.join(names)}) than those under review "
                    f"({', '.join(had)}); open a review of their own on them."
                )
        if not np.array_equal(tracks["frame"].to_numpy(), before["frame"].to_numpy()):
            raise InputError(
                "these tracks are of other frames than those under review; open a review of their "
                "own on them."
            )
        with self._edit_lock:
            if self.corrected.busy:
                raise InputError(WAIT)
            self._open_tracks(tracks)
            self._tracked_again()
            self._show_state("other tracks are shown")
        self.refresh()

    def _open_tracks(self, tracks: Tracks) -> None:
        """Begin the review of some tracks: make ``corrected``, and the session of it."""
        raise NotImplementedError

    def _tell_of_tracks(self) -> None:
        """Tell who observes ``tracks``."""
        type(self).tracks.changed(self)

    def _lane_tracks(self) -> Tracks:
        """Return the tracks as they are now."""
        tracks: Tracks = self.corrected.present
        return tracks

    def _lane_suspects(self) -> pd.DataFrame | None:
        """Return the labels that are doubtful now."""
        return self._doubtful

    def _find_doubtful(self) -> pd.DataFrame | None:
        """Return the frames that are doubtful in the tracks as they are now."""
        raise NotImplementedError

    def _visit(self, frame: int) -> None:
        """Get ready for a frame that the browser is about to show."""

    def retrack(
        self, frame: int, *, learn: bool = False, stretch: tuple[int, int] | None = None
    ) -> None:
        """Begin to track again from a frame on, in a thread of its own.

        Parameters
        ----------
        frame : int
            The corrected frame: what was put in place there is tracked on.
        learn : bool
            Learn the colours of corrected points anew in that frame.
        stretch : tuple of int, optional
            First frame to take over from it, and one past the last; default all.

        Raises
        ------
        InputError
            If that is being done already.
        """
        if self.corrected.busy:
            raise InputError(WAIT)
        self._stop.clear()
        arguments = (frame, learn, stretch)
        self._worker = threading.Thread(
            target=self._retrack_now, args=arguments, name="pawnb-retrack", daemon=True
        )
        self._worker.start()

    def export_film(self, path: str | Path, **options: Any) -> Path:
        """Write the tracks as corrected so far as a film; see :func:`pawnb.export_film`."""
        return export_film(self._trial, self.corrected.tracks, path, **options)

    def export_sheet(self, path: str | Path, **options: Any) -> Path:
        """Write frames of the tracks as one picture; see :func:`pawnb.export_sheet`."""
        return export_sheet(self._trial, self.corrected.tracks, path, **options)

    def _page_notes(self) -> list[str]:
        """Return what was corrected, in words, for a page that only shows."""
        return [describe_edit(edit) for edit in self.corrected.corrections]

    def _page_traits(self) -> dict[str, Any]:
        """Return what the browser is told on a page that only shows."""
        said = (
            f"Tracks of {self._trial.name}. Step with the arrow keys, zoom with Ctrl and the wheel."
        )
        return super()._page_traits() | {"status": said}

    def close(self) -> None:
        """Take the widget away and stop the tracker."""
        worker = getattr(self, "_worker", None)
        if worker is not None and worker is not threading.current_thread():
            self._stop.set()
            worker.join()
        if (counted := getattr(self, "working_time", None)) is not None:
            counted.keep()
        super().close()

    def _show_state(self, said: str = "", *, busy: bool = False) -> None:
        """Say what was done, and which buttons can be pressed."""
        raise NotImplementedError

    def _tracked_again(self) -> None:
        """Take notice of new tracks, before they are shown."""
        self._offer_doubtful(self._find_doubtful())

    def _review_actions(self, *, busy: bool) -> list[dict[str, Any]]:
        """Return the buttons and menus of any review: save, doubtful frames, stop."""
        actions: list[dict[str, Any]] = [
            {"id": "save", "text": "Save tracks", "keys": ["Ctrl+s"],
             "title": "Write tracks.nc and its tables; corrections are kept anyway (Ctrl+S)"},
        ]  # fmt: skip
        if self._suspects:
            actions.append({"id": "suspect", "text": "Jump to a doubtful frame",
                            "title": "Frames that the tracker doubts, the most doubtful first",
                            "options": self._suspects})  # fmt: skip
            title = "The doubtful frame after the one looked at last (D)"
            actions.append({"id": "next", "text": "Next doubtful", "keys": ["d"], "title": title})
        if busy:
            actions.append({"id": "stop", "text": "Stop", "title": "Stop tracking again"})
        return actions

    def _retrack_now(self, frame: int, learn: bool, stretch: tuple[int, int] | None) -> None:
        """Track again and show the result; runs in its own thread."""
        go = None
        try:
            self._show_state(f"tracking again from frame {frame} on", busy=True)
            said, go = self.corrected.retrack(frame, learn=learn, stretch=stretch), frame
            self._tracked_again()
            said += f"; now {assess_quality(self.corrected.tracks).line()}"
            self._visit(frame)
            if self.alarm == WAIT:
                self.alarm = ""  # it is done now
        except (PawnbError, OSError) as error:
            self.alarm, said = str(error), "the tracks are as they were"
        except BaseException:
            self.alarm = f"tracking again from frame {frame} failed; see the kernel's messages."
            self._show_state("the tracks are as they were")
            raise
        self._show_state(said)
        self.refresh(go)

    def _track_again(self, tracks: Tracks, frame: int, **options: Any) -> Tracks:
        """Call the tracker; a person who stops it keeps the tracks as they were."""
        if self._retrack_trial is not None:
            return self._retrack_trial(self._trial, tracks, frame, **options)
        # while the review is being opened nothing of it is on the screen: a bar says how far it is
        opened = self.comm is not None
        new = workflow_retrack(
            self._trial,
            tracks,
            frame,
            progress=self._show_progress if opened else None,
            stop=self._stop.is_set,
            **options,
        )
        if self._stop.is_set():
            raise InputError(f"tracking again from frame {frame} was stopped.")
        return new

    def _show_progress(self, done: int, total: int, doing: str = "") -> None:
        if done % 10 == 0 or done == total or doing != self._doing:
            self._doing = doing
            self._show_state(f"{doing}: {done} of {total} frames", busy=True)


def as_sentence(said: str) -> str:
    """Return what is said with a capital letter and a full stop; nothing stays nothing."""
    stop = "" if not said or said.endswith(".") else "."
    return f"{said[:1].upper()}{said[1:]}{stop}"


def say_taken(action: str, edit: Edit | None) -> str:
    """Say what undo or redo did to a correction; None where there was nothing to do."""
    if edit is None:
        return f"nothing to {action}"
    return f"{'undone' if action == 'undo' else 'made again'}: {describe_edit(edit)}"


def file_beside(edits: Path, what: str) -> Path:
    """Return where else is kept what belongs to a file of corrections.

    Parameters
    ----------
    edits : Path
        The file of corrections, ``edits.jsonl`` or ``<name>.edits.jsonl``.
    what : str
        What is kept: it takes the place of ``edits`` in the name, or is added to it.

    Returns
    -------
    Path
        A file in the same folder.
    """
    path = edits.with_name(edits.name.replace("edits", what, 1))
    return path if path != edits else edits.with_name(f"{edits.name}.{what}")
