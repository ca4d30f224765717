"""What a person is making and can take back, written to its file at every change."""

from __future__ import annotations

from pathlib import Path
from typing import Generic, TypeVar

from pawnb.errors import InputError
from pawnb.files import GuardedFile, keep_copy

StateT = TypeVar("StateT")

_REFUSED = "this change was not made; open this widget again (run its cell) and repeat it there"


class Draft(Generic[StateT]):
    """A state, the states before and after it, and the file that holds it.

    Parameters
    ----------
    path : Path
        The file. One that is there already is kept beside it as ``*.before.csv`` at the first
        change (``*.before-2.csv`` ... where there is one). It is written only as long as nobody
        else writes it.
    span : tuple of int
        First and last frame that can be looked at.

    Attributes
    ----------
    saved : bool
        Whether the file holds the state.
    """

    _state: StateT

    def __init__(self, path: Path, span: tuple[int, int]) -> None:
        self.path, self.span = path, span
        self._file = GuardedFile(path)
        self.saved = False
        self._kept_before = not path.exists()
        self._past: list[StateT] = []
        self._future: list[StateT] = []

    @property
    def can_undo(self) -> bool:
        """Whether there is something to undo."""
        return bool(self._past)

    @property
    def can_redo(self) -> bool:
        """Whether something undone can be made again."""
        return bool(self._future)

    def undo(self) -> bool:
        """Take back the last change; say whether there was one."""
        return self._step(self._past, self._future)

    def redo(self) -> bool:
        """Make the change that was undone last again; say whether there was one."""
        return self._step(self._future, self._past)

    def save(self) -> Path:
        """Write the state to the file, whole or not at all.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        InputError
            If another window or program has changed the file since it was read here, or it
            cannot be written.
        """
        with self._file.writing(refused=_REFUSED):
            if not self._kept_before:
                keep_copy(self.path, "before")
                self._kept_before = True
            self._write()
        self.saved = True
        return self.path

    def _write(self) -> None:
        """Write the state to the file; each kind of draft says how."""
        raise NotImplementedError

    def _keep(self, state: StateT) -> bool:  # noqa: ARG002 (for kinds of draft that propose)
        """Say whether a state that undo or redo comes to belongs in the file."""
        return True

    def _enter(self, state: StateT) -> StateT:
        """Take over a state and save it; where that fails, nothing has changed."""
        before, self._state = self._state, state
        try:
            if self._keep(state):
                self.save()
            else:
                self.saved = False
        except (InputError, OSError):
            self._state = before
            raise
        return before

    def _make(self, state: StateT) -> None:
        """Take over a state that a person made; it can be undone."""
        self._past.append(self._enter(state))
        self._future.clear()

    def _step(self, source: list[StateT], target: list[StateT]) -> bool:
        """Move one state from one pile to the other; used by undo and redo."""
        if not source:
            return False
        target.append(self._enter(source[-1]))
        source.pop()
        self._look_at_change(target[-1])
        return True

    def _look_at_change(self, before: StateT) -> None:
        """Look at what undo or redo has changed; each kind of draft says how."""
        raise NotImplementedError

    def _checked_frame(self, frame: int) -> int:
        """Return a frame, refusing one outside the trial."""
        first, last = self.span
        if not first <= frame <= last:
            raise InputError(f"frame {frame} is not in the trial ({first} to {last}).")
        return int(frame)
