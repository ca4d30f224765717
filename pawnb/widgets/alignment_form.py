"""Films of a trial that were not started together, aligned by a flash that all of them show."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import ipywidgets as widgets

from pawnb.core.video import open_views
from pawnb.errors import InputError, PawnbError
from pawnb.trial import Trial, View
from pawnb.widgets.flash_field import FlashField
from pawnb.widgets.frame_canvas import FrameCanvas
from pawnb.widgets.plain import Plain
from pawnb.workflow.workbench.film_alignment import offsets_by_event, tell_alignment
from pawnb.workflow.workbench.used_frames import write_offsets


class AlignmentForm(Plain, widgets.VBox):  # type: ignore[misc]
    """Align the films of a trial: the frame with the flash is marked in each.

    Parameters
    ----------
    trial : Trial
        A trial with two films or more.
    done : callable, optional
        ``done(said)`` is called once ``trial.toml`` says it, with what was done, in words.
    **options
        The options of :class:`FrameCanvas`.

    Raises
    ------
    InputError
        If all views are of one film, or a film cannot be opened.
    """

    def __init__(
        self, trial: Trial, *, done: Callable[[str], object] | None = None, **options: Any
    ) -> None:
        super().__init__()
        self.trial, self._done = trial, done
        films = {view.video: view for view in reversed(trial.views)}
        self._films = [view for view in trial.views if films[view.video] is view]
        if len(self._films) < 2:
            raise InputError(f"{trial.name}: all views are of one film, which needs no alignment.")
        self._views = open_views(trial)
        span = (self._views.first_frame, self._views.n_frames - 1)
        self.canvas = FrameCanvas(self._views, span=span, **options)
        lengths = {v.name: self._views.readers[v.name].n_frames for v in self._films}
        self.marks = [
            FlashField(
                None, film=view.name, n_frames=lengths[view.name], changed=self._look,
                here=partial(self._frame_of_file, view),
            )
            for view in self._films
        ]  # fmt: skip
        self._use = widgets.Button(description="Align the films", button_style="primary")
        self._use.on_click(lambda _: self.write())
        how = widgets.Label(
            tell_alignment({v.name: v.offset for v in self._films}, lengths)
            or "The films are taken to have been started together. Were they not, go to the frame "
            "in which a picture first shows a flash or another sudden event, press Flash is here "
            "beside its name, and do so for each."
        )
        # beside the button, where it is seen while the frames are marked
        self._told = widgets.Label()
        for words in (how, self._told):
            words.add_class("pawnb-wrap")
        row = {"flex_flow": "row wrap", "align_items": "center"}
        self.children = (
            how, self.canvas,
            *(
                widgets.HBox([widgets.Label(view.name, layout={"width": "8em"}), mark], layout=row)
                for view, mark in zip(self._films, self.marks, strict=True)
            ),
            self._told, self._use,
        )  # fmt: skip

    def offsets(self) -> dict[str, int]:
        """Return the offset of each view as the marks say; raises InputError where one lacks."""
        names = [view.name for view in self._films]
        events = [mark.frame() for mark in self.marks]
        if all(event is None for event in events):
            raise InputError(
                "no flash is marked yet: go to the frame in which a picture first shows it, and "
                "press Flash is here beside its name."
            )
        found = offsets_by_event(names, events, from_first=self.trial.is_jointed)
        of_film = {v.video: n for v, n in zip(self._films, found, strict=True)}
        return {view.name: of_film[view.video] for view in self.trial.views}

    def write(self) -> bool:
        """Write the offsets into ``trial.toml``; says what is wrong where that cannot be."""
        try:
            kept = write_offsets(self.trial, self.offsets())
        except (PawnbError, OSError) as error:
            self._told.value = str(error)
            return False
        if self._done is not None:
            again = f" Click the points again: those of before are in {kept.name}." if kept else ""
            self._done(f"the films are aligned.{again}")
        return True

    def plain_picture(self) -> bytes:
        """Return the films as they are shown, as PNG."""
        return self.canvas.plain_picture()

    def close(self) -> None:
        """Take the form away and close the films."""
        self.canvas.close()
        self._views.close()
        super().close()

    def _frame_of_file(self, view: View) -> int:
        """Return which frame of its file a view shows."""
        return int(self.canvas.frame) + view.offset

    def _look(self) -> None:
        """Say how the films would be aligned, or what is missing."""
        try:
            offsets = self.offsets()
        except InputError as error:
            self._told.value = str(error)
            return
        begins = ", ".join(f"frame {offset} of {name}" for name, offset in offsets.items())
        self._told.value = f"Frame 0 will be {begins}. Press Align the films to use this."
