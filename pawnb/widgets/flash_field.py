"""The frame in which a film shows a flash, typed or taken from the picture that is shown."""

from __future__ import annotations

from collections.abc import Callable

import ipywidgets as widgets

from pawnb.errors import InputError


class FlashField(widgets.HBox):  # type: ignore[misc]
    """Asks for the frame of one film's file that first shows what all films show.

    Parameters
    ----------
    frame : int or None
        The frame that is known.
    film : str
        What the film is called.
    n_frames : int
        How many frames its file has.
    here : callable
        Returns the frame of the file that is shown now.
    changed : callable
        Called when another one was named.
    """

    def __init__(
        self,
        frame: int | None,
        *,
        film: str,
        n_frames: int,
        here: Callable[[], int],
        changed: Callable[[], object],
    ) -> None:
        self._film, self._n = film, n_frames
        self.field = widgets.Text(
            value="" if frame is None else str(frame), placeholder="started together",
            description="flash in frame", continuous_update=False, layout={"width": "18em"},
            style={"description_width": "initial"},
        )  # fmt: skip
        take = widgets.Button(
            description="Flash is here", layout={"width": "9em"},
            tooltip="Where cameras were not started together: the picture shown is the first of "
            "this film with a flash, or another event that all films show",
        )  # fmt: skip
        self.take = take
        take.on_click(lambda _: self._take(here))
        self.field.observe(lambda _: changed(), names="value")
        super().__init__([self.field, take])

    def frame(self) -> int | None:
        """Return the frame; raises InputError for what is no frame."""
        if not (word := self.field.value.strip()):
            return None
        if not word.isdecimal() or int(word) >= self._n:
            raise InputError(
                f"the flash is in frame {word!r} of {self._film}; expected one of frames 0 to "
                f"{self._n - 1}."
            )
        return int(word)

    def _take(self, here: Callable[[], int]) -> None:
        """Take the frame that is shown."""
        self.field.value = str(here())
