"""Tracks, the corrections made in them, and tracking again: what every review stands on."""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path

from pawnb.core.edits.effects import Retracker
from pawnb.core.edits.log import Edit, EditLog, Retrack, describe_edit
from pawnb.core.rig import Rig
from pawnb.errors import InputError, PawnbError
from pawnb.schema import Tracks
from pawnb.trial import Trial

WAIT = "the trial is being tracked again; wait until that is done, or stop it."
"""What is said to a correction that comes meanwhile."""


class CorrectedTracks:
    """Tracks under review: corrections, undo, tracking again.

    Safe to use from several threads.

    Parameters
    ----------
    trial : Trial
        The trial of the tracks.
    tracks : xarray.Dataset
        Its tracks; not modified.
    rig : Rig, optional
        The calibrated views.
    edits : str or Path, optional
        ``edits.jsonl``; what it holds already is applied. None keeps nothing.
    retrack : callable, optional
        ``retrack(tracks, frame) -> Tracks`` tracks again from a frame on; it is given
        ``learn=True`` as well where colours are to be learnt anew.
    save : callable, optional
        ``save(tracks)`` writes the tracks.
    before : callable, optional
        ``before() -> Tracks`` reads the tracks as they were before any correction.

    Attributes
    ----------
    notes : list of str
        What a person should know about ``edits.jsonl``.
    busy : bool
        Whether the trial is being tracked again.
    lock : threading.RLock
        Held while the tracks change.

    Raises
    ------
    InputError
        If the tracks have no image positions, or ``edits.jsonl`` does not fit them.
    """

    def __init__(
        self,
        trial: Trial,
        tracks: Tracks,
        *,
        rig: Rig | None = None,
        edits: str | Path | None = None,
        retrack: Retracker | None = None,
        save: Callable[[Tracks], object] | None = None,
        before: Callable[[], Tracks] | None = None,
    ) -> None:
        self.edits = Path(edits) if edits is not None else None
        self.lock = threading.RLock()
        self._tracker, self._save = retrack, save
        self._ready: Tracks | None = None  # made outside the lock, for the log to take over
        self.busy = False
        calibration = trial.calibration
        self._log = EditLog(
            tracks,
            edits,
            rig=rig,
            px_per_unit=calibration.px_per_unit if calibration is not None else None,
            retrack=self._retracked if retrack is not None else None,
            before=before,
        )
        self.notes = list(self._log.notes)
        # where what these tracks contain is undone, the file they came from is written again
        self._n_saved = self._log.n_contained if before is not None and save is not None else None

    @property
    def present(self) -> Tracks:
        """The present state, as the tracker and the corrections left it."""
        return self._log.tracks

    @property
    def tracks(self) -> Tracks:
        """The present state, its corrections listed in its provenance."""
        with self.lock:
            return self._log.stamped()

    @property
    def corrections(self) -> tuple[Edit, ...]:
        """Every correction in force."""
        with self.lock:
            return self._log.active

    @property
    def can_undo(self) -> bool:
        """Whether there is a correction to undo."""
        return self._log.can_undo

    @property
    def can_redo(self) -> bool:
        """Whether an undone correction can be made again."""
        return self._log.can_redo

    @property
    def span(self) -> tuple[int, int]:
        """First and last frame of the tracks."""
        frames = self._log.tracks["frame"].to_numpy()
        return int(frames[0]), int(frames[-1])

    def apply(self, edit: Edit) -> str:
        """Make a correction; returns what was done, in words."""
        with self.lock:
            self._check_idle()
            self._log.apply(edit)
        return describe_edit(edit)

    def undo(self) -> Edit | None:
        """Take back the last correction; returns it, or None where there was none."""
        return self._step(self._log.undo)

    def redo(self) -> Edit | None:
        """Make the correction that was undone last again; returns it, or None."""
        return self._step(self._log.redo)

    def retrack(
        self, frame: int, *, learn: bool = False, stretch: tuple[int, int] | None = None
    ) -> str:
        """Track again from a frame on; returns what was done, in words.

        Pictures and points can be looked at meanwhile, but not corrected.

        Parameters
        ----------
        frame : int
            The corrected frame.
        learn : bool
            Learn the colours of the corrected points anew there.
        stretch : tuple of int, optional
            First frame to take over from it, and one past the last; default all.

        Returns
        -------
        str
            What was done.

        Raises
        ------
        InputError
            If no tracker was given, it is running already or fails, or another window has made
            corrections meanwhile.
        """
        if self._tracker is None:
            raise InputError("no tracker was given; open the review with retrack=.")
        with self.lock:
            self._check_idle()
            self._log.check_alone()  # else it would be refused once it is tracked
            before = self._log.tracks
            self.busy = True
        try:
            options = {"learn": True} if learn else {}
            ready = self._tracker(before.copy(deep=True), frame, **options)
            since, stop = stretch or (None, None)
            edit = Retrack(frame=frame, learn=learn, since=since, stop=stop)
            with self.lock:
                self._ready = ready
                self._log.apply(edit)
        finally:
            self._ready, self.busy = None, False
        return describe_edit(edit)

    def save(self) -> None:
        """Write the tracks with the ``save`` that was given.

        Raises
        ------
        InputError
            If none was given, it fails, or another window has made corrections meanwhile.
        """
        if self._save is None:
            raise InputError("no place to save was given; open the review with save=.")
        with self.lock:
            self._log.check_alone()
            self._save(self._log.stamped())
            self._n_saved = len(self._log.active)

    def _step(self, action: Callable[[], Edit | None]) -> Edit | None:
        """Undo or redo; a file saved with what is now undone is written again."""
        with self.lock:
            self._check_idle()
            edit = action()
            if self._n_saved is not None and len(self._log.active) < self._n_saved:
                self.save()
            return edit

    def _check_idle(self) -> None:
        if self.busy:
            raise InputError(WAIT)

    def _retracked(self, tracks: Tracks, frame: int, **options: bool) -> Tracks:
        """Hand over what was tracked outside the lock; on opening, track now."""
        if self._ready is not None:
            return self._ready
        if self._tracker is None:
            raise InputError("no tracker was given; open the review with retrack=.")
        try:
            return self._tracker(tracks, frame, **options)
        except (PawnbError, OSError) as error:
            where = "" if self.edits is None else f" in {self.edits}"
            raise InputError(
                f"the corrections{where} track again from frame {frame}, which could not be done: "
                f"{error} No correction is lost."
            ) from None
