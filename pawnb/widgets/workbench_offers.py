"""Buttons beside a review for what would make tracks better that are not good."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import ipywidgets as widgets

from pawnb.core.edits.log import Retrack
from pawnb.errors import PawnbError
from pawnb.widgets.workbench_parts import ROW
from pawnb.widgets.workbench_session import WorkbenchSession
from pawnb.workflow.workbench.states import TrialState


class Offers(widgets.HBox):  # type: ignore[misc]
    """What would make tracks better, a button each; chosen anew once the trial is tracked again.

    Parameters
    ----------
    session : WorkbenchSession
        What knows it.
    state : TrialState
        The trial.
    reviewer : TrackReviewer or PoseReviewer
        The review of its tracks.
    button : callable
        ``button(text, act)`` gives a button.
    use_frames : callable
        ``use_frames(state, (first, stop))`` tracks these frames only.
    click_also : callable
        ``click_also(state, frame)`` opens the clicks at another frame.
    chosen : callable
        Called when they were chosen anew.
    """

    def __init__(
        self,
        session: WorkbenchSession,
        state: TrialState,
        reviewer: Any,
        *,
        button: Callable[[str, Callable[[], object]], Any],
        use_frames: Callable[[TrialState, tuple[int, int]], None],
        click_also: Callable[[TrialState, int], None],
        chosen: Callable[[], None],
    ) -> None:
        super().__init__(layout=ROW)
        self._session, self._state, self._reviewer = session, state, reviewer
        self._button, self._use_frames, self._click_also = button, use_frames, click_also
        self._chosen = chosen
        self._again = self._tracked_again()
        self.children = self._buttons()
        reviewer.observe(self._look, names="tracks")

    def _look(self, _change: object) -> None:
        """Choose anew where the trial was tracked again, or that was undone."""
        if (again := self._tracked_again()) == self._again:
            return
        self._again = again
        self.children = self._buttons()
        self._chosen()

    def _tracked_again(self) -> list[Retrack]:
        """Return how often, and from where, the trial was tracked again."""
        return [edit for edit in self._reviewer.corrected.corrections if isinstance(edit, Retrack)]

    def _buttons(self) -> tuple[Any, ...]:
        """Return the buttons for the tracks as they are now."""
        try:
            return self._offered()
        except (PawnbError, OSError):  # the clicks are not there any more, for instance
            return ()

    def _offered(self) -> tuple[Any, ...]:
        """Return a button for each thing that would make the tracks better."""
        tracks, state, buttons = self._reviewer.tracks, self._state, []
        if (part := self._session.frames_to_use(state, tracks)) is not None:
            text = f"Animal is in view in frames {part[0]} to {part[1] - 1} only: track these"
            buttons.append(self._button(text, partial(self._use_frames, state, part)))
        if (frame := self._session.frame_to_click(state, tracks)) is not None:
            text = f"Click frame {frame} as well, and track again"
            buttons.append(self._button(text, partial(self._click_also, state, frame)))
        return tuple(buttons)
