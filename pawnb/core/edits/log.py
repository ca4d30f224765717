"""Corrections with undo and redo, kept in ``edits.jsonl`` as they are made.

:class:`EditLog` holds Tracks together with what a person changed in them. The file
is the record: reading it again (:func:`replay`) gives the present state.

Tracks that are saved carry, in their provenance, how many corrections they contain
and a checksum of these; opening them again applies only what came later.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from pawnb.core.edits.copies import copy_tracks
from pawnb.core.edits.effects import Retracker, apply_edit, check_editable
from pawnb.core.edits.hidden import hidden_by_hand
from pawnb.core.edits.made_anew import same_places, say_made_anew
from pawnb.core.edits.records import (
    EDIT_LINES,
    Accept,
    Delete,
    Edit,
    Entry,
    Hide,
    Interpolate,
    Move,
    Pose,
    Retrack,
    Swap,
)
from pawnb.core.edits.solving import RigLike
from pawnb.core.edits.stretches import rows_of_edit
from pawnb.core.edits.words import describe_edit
from pawnb.errors import InputError
from pawnb.io.journal import Journal, enter_step, read_journal
from pawnb.schema import Tracks, add_provenance

__all__ = [
    "EDIT_LINES", "Accept", "Delete", "Edit", "EditLog", "Hide", "Interpolate", "Move", "Pose",
    "Retrack", "Swap", "apply_edit", "describe_edit", "replay", "say_unsaved",
]  # fmt: skip


@dataclass(frozen=True)
class _Change:
    """One applied correction with the Tracks before and after, or only their changed rows."""

    edit: Edit
    before: Tracks
    after: Tracks
    rows: slice | None


class EditLog:
    """Tracks and the corrections made in them.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks as the tracker made them, or as they were saved after earlier corrections.
        They are not modified.
    path : str or Path, optional
        ``edits.jsonl``. What it holds already is applied; without a path nothing is kept.
    rig : Rig, optional
        The calibrated views, to compute 3D points again.
    px_per_unit : float, optional
        Scale of a single view whose ``position`` is in real units, px per unit.
    retrack : callable, optional
        ``retrack(tracks, frame) -> Tracks`` tracks again from a frame on; it is given
        ``learn=True`` as well where colours are to be learnt anew.
    before : callable, optional
        ``before() -> Tracks`` reads the tracks as they were before any correction, so that those
        that the opened tracks contain can be undone, too.

    Attributes
    ----------
    tracks : xarray.Dataset
        The present state.
    active : tuple of Edit
        Every correction in force, in the order they were made.
    notes : list of str
        What a person should know about the file: a half-written last line, for instance.

    Raises
    ------
    InputError
        If the file cannot be read, or a correction in it does not fit these tracks.
    """

    def __init__(
        self,
        tracks: Tracks,
        path: str | Path | None = None,
        *,
        rig: RigLike | None = None,
        px_per_unit: float | None = None,
        retrack: Retracker | None = None,
        before: Callable[[], Tracks] | None = None,
    ) -> None:
        check_editable(tracks)
        self._before = before
        self._rig, self._px_per_unit, self._retrack = rig, px_per_unit, retrack
        self._file = None if path is None else Journal(path, EDIT_LINES, made_in="tracks")
        entries = self._file.entries if self._file is not None else []
        self.notes: list[str] = list(self._file.notes) if self._file is not None else []
        self._contained, self._past, self._future, note = _settle(entries, tracks)
        self.notes += [*note, *say_made_anew(tracks, before, self._past)]
        self.tracks = tracks
        self._changes: list[_Change] = []
        self._undone: list[_Change] = []  # those at the end of _future that were made here
        for edit in self._past[self._contained :]:
            self._changes.append(self._change(edit, self._past[: self._n_applied]))

    @property
    def _n_applied(self) -> int:
        return self._contained + len(self._changes)

    @property
    def active(self) -> tuple[Edit, ...]:
        """Every correction in force, in the order they were made."""
        return tuple(self._past)

    @property
    def can_undo(self) -> bool:
        """Whether there is a correction to undo.

        Those that the opened tracks contain can be undone where the tracks from before are
        there, unless the trial was tracked again among them.
        """
        return bool(self._changes) or self._can_reach_back

    @property
    def n_contained(self) -> int:
        """How many corrections the opened tracks contain that were not taken back since."""
        return self._contained

    @property
    def can_redo(self) -> bool:
        """Whether an undone correction can be made again."""
        return bool(self._future)

    def apply(self, edit: Edit) -> Tracks:
        """Make a correction: compute it, write its line to disk, then let it be seen.

        Parameters
        ----------
        edit : Edit
            The correction.

        Returns
        -------
        xarray.Dataset
            The present Tracks.

        Raises
        ------
        InputError
            If it does not fit the tracks or cannot be written; nothing has changed then.
        """
        before = self.tracks
        change = self._change(edit, self._past)
        self._write(edit, back_to=before)
        self._changes.append(change)
        self._past.append(edit)
        self._future.clear()
        self._undone.clear()
        return self.tracks

    def undo(self) -> Edit | None:
        """Take back the last correction.

        Returns
        -------
        Edit or None
            What was taken back; None where there was nothing.

        Raises
        ------
        InputError
            If the file cannot be written; nothing has changed then.
        """
        if not self._changes and self._can_reach_back:
            self._reach_back()
        if not self._changes:
            return None
        self._write("undo", back_to=self.tracks)
        change = self._changes.pop()
        self._undone.append(change)
        self._future.append(self._past.pop())
        self.tracks = self._restored(change, change.before)
        return change.edit

    def redo(self) -> Edit | None:
        """Make the correction that was undone last again.

        Returns
        -------
        Edit or None
            What was made again; None where there was nothing.

        Raises
        ------
        InputError
            If the file cannot be written; nothing has changed then.
        """
        if not self._future:
            return None
        before = self.tracks
        if self._undone:
            # the tracks are as they were then, so nothing needs to be computed again
            change = self._undone[-1]
            self.tracks = self._restored(change, change.after)
        else:
            change = self._change(self._future[-1], self._past)
        self._write("redo", back_to=before)
        if self._undone:
            self._undone.pop()
        self._changes.append(change)
        self._past.append(self._future.pop())
        return change.edit

    def stamped(self) -> Tracks:
        """Return the present Tracks with the corrections they contain in their provenance.

        Returns
        -------
        xarray.Dataset
            Tracks to save: opened again with the same ``edits.jsonl``, no correction is
            applied twice.
        """
        if not self._past:
            return self.tracks
        return add_provenance(
            self.tracks, step="edit", corrections=len(self._past), sha256=_checksum(self._past)
        )

    def check_alone(self) -> None:
        """Raise InputError if another window has written to the file since it was read here."""
        if self._file is None:
            return
        there, _ = read_journal(self._file.path, EDIT_LINES)
        if there != self._file.entries:
            raise InputError(
                f"{self._file.path}: another window or program has made corrections since it was "
                "opened here, which these tracks lack; open the tracks again."
            )

    @property
    def _can_reach_back(self) -> bool:
        contained = self._past[: self._contained]
        again = any(isinstance(edit, Retrack) for edit in contained)
        return self._before is not None and bool(contained) and not again

    def _reach_back(self) -> None:
        """Make the corrections again that the opened tracks contain, so that they can be undone."""
        assert self._before is not None  # noqa: S101
        present, edits = self.tracks, self._past[: self._contained]
        self.tracks, reached = self._before(), False
        try:
            changes = [self._change(edit, edits[:k]) for k, edit in enumerate(edits)]
            reached = same_places(self.tracks, present)
        finally:
            if not reached:
                self.tracks = present
        if not reached:
            raise InputError(
                "the tracks from before do not lead to these, so corrections that these contain "
                "cannot be undone."
            )
        self._contained, self._changes = 0, changes

    def _change(self, edit: Edit, past: Sequence[Edit]) -> _Change:
        """Apply a correction to the present tracks and remember what it changed."""
        before = self.tracks
        self.tracks = apply_edit(
            before,
            edit,
            rig=self._rig,
            px_per_unit=self._px_per_unit,
            retrack=self._retrack,
            hidden=hidden_by_hand(past, before),
            exchanged=[done for done in past if isinstance(done, Swap)],
        )
        if isinstance(edit, Retrack):
            return _Change(edit, before, self.tracks, None)
        # keep the rows that changed, not the whole recording
        rows = rows_of_edit(before, edit)
        was, now = (t.isel(time=rows).copy(deep=True) for t in (before, self.tracks))
        return _Change(edit, was, now, rows)

    def _restored(self, change: _Change, state: Tracks) -> Tracks:
        """Return the tracks as they were on one side of a change."""
        if change.rows is None:
            return state
        tracks = copy_tracks(self.tracks)
        for name, variable in state.data_vars.items():
            if "time" in variable.dims:
                tracks[name].values[change.rows] = variable.values
        return tracks

    def _write(self, entry: Entry, *, back_to: Tracks) -> None:
        """Write one line; where that fails, the tracks stay as they were."""
        if self._file is None:
            return
        try:
            self._file.append(entry)
        except InputError:
            self.tracks = back_to
            raise


def replay(
    tracks: Tracks,
    path: str | Path,
    *,
    rig: RigLike | None = None,
    px_per_unit: float | None = None,
    retrack: Retracker | None = None,
) -> Tracks:
    """Apply the corrections of ``edits.jsonl`` to Tracks, without any widget.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks as the tracker made them, or saved after some of these corrections.
    path : str or Path
        ``edits.jsonl``; it is only read.
    rig, px_per_unit, retrack
        As for :class:`EditLog`.

    Returns
    -------
    xarray.Dataset
        Tracks with every correction in force, and with these in their provenance.

    Raises
    ------
    InputError
        If the file does not exist, cannot be read, or does not fit these tracks.
    """
    if not Path(path).exists():
        raise InputError(f"{path}: no such file; expected the edits.jsonl of these tracks.")
    return EditLog(tracks, path, rig=rig, px_per_unit=px_per_unit, retrack=retrack).stamped()


def say_unsaved(tracks: Tracks, path: str | Path) -> str:
    """Say how many corrections in force tracks lack, but for labels that were right as they are.

    Empty where none; raises InputError where the tracks do not go with ``edits.jsonl``.
    """
    n_contained, past, _, _ = _settle(read_journal(path, EDIT_LINES)[0], tracks)
    n = sum(not isinstance(edit, Accept) for edit in past[n_contained:])
    said = "1 correction is" if n == 1 else f"{n} corrections are"
    return f"{said} not in the tracks; open the review and press Save tracks." if n else ""


def _settle(
    entries: Sequence[Entry], tracks: Tracks
) -> tuple[int, list[Edit], list[Edit], list[str]]:
    """Work out which corrections are in force and how many the tracks contain already.

    Returns
    -------
    n_contained : int
        How many of the corrections in force the tracks contain.
    past, future : list of Edit
        Corrections in force, and undone ones that can be made again.
    notes : list of str
        What a person should know.
    """
    steps = json.loads(tracks.attrs.get("provenance", "{}")).get("steps", [])
    stamp = next((s for s in reversed(steps) if s.get("step") == "edit"), None)
    past: list[Edit] = []
    future: list[Edit] = []
    met = False
    for entry in entries:
        enter_step(past, future, entry)
        met = met or _contains(past, stamp)
    if stamp is None:
        return 0, past, future, []
    n = int(stamp["corrections"])
    if _contains(past[:n], stamp):
        return n, past, future, []
    if met:
        raise InputError(
            f"these tracks contain corrections that were undone after they were saved ({n} then, "
            f"{len(past)} now); track the trial again, or open the tracks from before: the "
            "corrections in force are applied to them by themselves."
        )
    note = f"these tracks contain corrections that this edits.jsonl does not list ({n})"
    return 0, past, future, [note + "; they cannot be undone."]


def _contains(past: Sequence[Edit], stamp: dict | None) -> bool:
    """Whether these corrections are exactly those that a saved file says it contains."""
    return (
        stamp is not None
        and len(past) == stamp["corrections"]
        and _checksum(past) == stamp["sha256"]
    )


def _checksum(edits: Sequence[Edit]) -> str:
    """Return a checksum of corrections, independent of undone ones between them."""
    return hashlib.sha256("\n".join(map(EDIT_LINES.to_line, edits)).encode()).hexdigest()
