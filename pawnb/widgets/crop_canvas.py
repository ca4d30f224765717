"""The part of each picture that a view keeps, dragged by its corners."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from pawnb.widgets.frame_canvas import NO_PLACING, FrameCanvas, Overlay
from pawnb.workflow.workbench.new_trial import NewTrial, NewView

_LEFT_TOP, _RIGHT_BOTTOM = "left top", "right bottom"
DRAWN_COLOUR = "#F0E442"
_LEAST_CROP_PX = 16
"""No side of a view is shorter: it would hold no animal."""


def drag_corner(
    crop: tuple[int, int, int, int] | None,
    size: tuple[int, int],
    corner: str,
    *,
    u: float,
    v: float,
) -> tuple[int, int, int, int] | None:
    """Return the part that is kept after one corner was dragged.

    Parameters
    ----------
    crop : tuple of int or None
        What was kept: u0, v0, u1, v1, half open; None for all.
    size : tuple of int
        Width and height of the picture, px.
    corner : str
        "left top" or "right bottom".
    u, v : float
        Where it was dragged to, px.

    Returns
    -------
    tuple of int or None
        What is kept now; None where that is the whole picture.
    """
    width, height = size
    u0, v0, u1, v1 = crop or (0, 0, width, height)
    if corner == _LEFT_TOP:
        u0 = min(max(0, round(u)), u1 - _LEAST_CROP_PX)
        v0 = min(max(0, round(v)), v1 - _LEAST_CROP_PX)
    else:
        u1 = max(min(width, round(u) + 1), u0 + _LEAST_CROP_PX)
        v1 = max(min(height, round(v) + 1), v0 + _LEAST_CROP_PX)
    return None if (u0, v0, u1, v1) == (0, 0, width, height) else (u0, v0, u1, v1)


class CropCanvas(FrameCanvas):
    """The videos of a new trial as they are, with the part of each that is kept.

    Parameters
    ----------
    made : NewTrial
        The new trial; its views are changed as corners are dragged.
    changed : callable, optional
        Called after each change.
    **options
        Those of :class:`FrameCanvas`.
    """

    def __init__(
        self, made: NewTrial, *, changed: Callable[[], None] | None = None, **options: Any
    ) -> None:
        self._made, self._changed = made, changed
        self._own_views = made.open_whole()
        # as they are called on the page, whatever they are called afterwards
        self._shown = {view.name: view for view in made.views}
        super().__init__(self._own_views, **options)
        self.label = "Choose the part of each picture"
        self.keys_help = [
            ["Drag a corner", "keep only this part of the picture"],
            *(list(line) for line in NO_PLACING),
        ]
        self._show_state()

    def overlay(self, _frame: int) -> Overlay:
        """Return the frame of the part of each view that is kept, and its corners."""
        return {"views": {name: self._marks(view) for name, view in self._shown.items()}}

    def edit(self, what: str, message: Mapping[str, Any]) -> int | None:
        """Take over a corner that was dragged."""
        if what == "moved":
            view = self._shown[str(message["view"])]
            size = self._made.size(view)
            u, v = float(message["u"]), float(message["v"])
            view.crop = drag_corner(view.crop, size, str(message["point"]), u=u, v=v)
            self._show_state()
            if self._changed is not None:
                self._changed()
        return None

    def film_lengths(self) -> dict[Path, int]:
        """Return how many frames the file of each film has."""
        readers = self._own_views.readers.values()
        return {v.video: r.n_frames for v, r in zip(self._made.views, readers, strict=True)}

    def close(self) -> None:
        """Take the widget away and close the videos."""
        super().close()
        if (own := getattr(self, "_own_views", None)) is not None:
            own.close()

    def _marks(self, view: NewView) -> dict[str, Any]:
        """Return what is drawn over a view."""
        width, height = self._made.size(view)
        u0, v0, u1, v1 = view.crop or (0, 0, width, height)
        left, top, right, bottom = u0, v0, u1 - 1, v1 - 1
        own = {"colour": DRAWN_COLOUR}
        corner = own | {"clamped": True}  # let go outside of the picture, it is on its border
        ring = [[left, top], [right, top], [right, bottom], [left, bottom], [left, top]]
        return {
            "points": [
                {"id": _LEFT_TOP, "u": left, "v": top, **corner},
                {"id": _RIGHT_BOTTOM, "u": right, "v": bottom, **corner},
            ],
            "lines": [{"at": ring, **own}],
        }

    def _show_state(self) -> None:
        """Say what is kept."""
        said = []
        for name, view in self._shown.items():
            width, height = self._made.size(view)
            u0, v0, u1, v1 = view.crop or (0, 0, width, height)
            said.append(f"{name}: {u1 - u0} x {v1 - v0} of {width} x {height} px")
        self.status = (
            "Drag the corners where only a part of a picture is meant.\n" + "; ".join(said) + "."
        )
