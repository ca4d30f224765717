"""A plain picture of every widget, for nbconvert and for viewers without a kernel."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np

from pawnb.errors import PawnbError
from pawnb.workflow.export.marks import line, rgb, ring, write_beside
from pawnb.workflow.export.tiles import TileLayout, resized_array

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_WIDTH_PX = 720
_DPI = 80
_LONGEST = 40
"""Signs of a cell that are shown."""


class Plain:
    """A widget that also shows as a picture: it says which in :meth:`plain_picture`."""

    def plain_picture(self) -> bytes:
        """Return the widget as it is now, as a PNG file; without buttons.

        Returns
        -------
        bytes
            The file.
        """
        raise NotImplementedError

    def _repr_mimebundle_(self, **options: Any) -> Any:
        """Return what a notebook may show: the widget, and its picture beside it."""
        bundle = super()._repr_mimebundle_(**options)  # type: ignore[misc]
        data = bundle[0] if isinstance(bundle, tuple) else bundle
        if data is not None:
            # a damaged frame, or marks that only a browser can draw: the widget itself is shown
            with suppress(PawnbError, OSError, ValueError, LookupError):
                data["image/png"] = base64.b64encode(self.plain_picture()).decode("ascii")
        return bundle


def draw_overlay(image: np.ndarray, overlay: dict[str, Any], *, scale: float) -> None:
    """Draw over a picture what the canvas draws over its view.

    Parameters
    ----------
    image : ndarray, shape (H, W, 3), uint8
        The picture, RGB; drawn upon.
    overlay : dict
        What is drawn over this view, see :data:`pawnb.widgets.frame_canvas.Overlay`; of a stick
        animal nothing.
    scale : float
        Pixels of ``image`` for one of the view.
    """

    def at(places: Sequence[Sequence[float] | None]) -> np.ndarray:
        known = [(np.nan, np.nan) if place is None else place for place in places]
        return (np.array(known, float).reshape(-1, 2) + 0.5) * scale - 0.5

    for one in overlay.get("lines", ()):
        line(image, at(one["at"]), rgb(one["colour"]), width=1)
    for mark in overlay.get("hollow", ()):
        (middle,) = at([(mark["u"], mark["v"])])
        corners = middle + 9.0 * np.array([(0, -1), (1, 0), (0, 1), (-1, 0), (0, -1)])
        line(image, corners, rgb(mark["colour"]), width=1)
    for mark in overlay.get("others", ()):
        (middle,) = at([(mark["u"], mark["v"])])
        ring(image, middle, rgb(mark["colour"]), origin="predicted")
    names = []
    for mark in overlay.get("points", ()):
        (middle,) = at([(mark["u"], mark["v"])])
        ring(image, middle, rgb(mark["colour"]), origin=mark.get("origin", "measured"))
        names.append((str(mark["id"]), middle, rgb(mark["colour"])))
    write_beside(image, names)


def picture_of_canvas(canvas: Any) -> bytes:
    """Return the views of a FrameCanvas at its frame, with what is drawn over them, as PNG."""
    frame = canvas.frame
    with canvas._video_lock:
        frames = canvas._views.frame(frame)
    with canvas._edit_lock:
        overlay = canvas.overlay(frame)
        legs = canvas.plain_legs(frame)
    layout = TileLayout(
        {stage["name"]: (stage["width"], stage["height"]) for stage in canvas.stages},
        width=_WIDTH_PX,
    )
    parts = {}
    for name, (_, _, height) in layout.at.items():
        image = frames[name].image()
        parts[name] = resized_array(image, (layout.part, height))
        scale = layout.part / image.shape[1]
        draw_overlay(parts[name], overlay["views"].get(name, {}), scale=scale)
        for places, colour in legs.get(name, ()):
            line(parts[name], (places + 0.5) * scale - 0.5, rgb(colour), width=2)
    said = ", ".join([f"frame {frame}", *([overlay["caption"]] if overlay.get("caption") else [])])
    return _png(layout.whole(parts, said))


def picture_of_figure(figure: Figure) -> bytes:
    """Return a figure as PNG; the canvas that shows it stays its canvas."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # a review of pictures needs none

    shown, file = figure.canvas, io.BytesIO()
    try:
        FigureCanvasAgg(figure)
        figure.savefig(file, format="png", dpi="figure")
    finally:
        figure.set_canvas(shown)
    return file.getvalue()


def picture_of_table(head: Sequence[str], rows: Sequence[Sequence[str]], title: str) -> bytes:
    """Return a table as PNG.

    Parameters
    ----------
    head : sequence of str
        Names of its columns.
    rows : sequence of sequence of str
        Its lines.
    title : str
        What stands above it.

    Returns
    -------
    bytes
        The file.
    """
    from matplotlib.figure import Figure  # 18 MB, which a review of pictures need not have

    figure = Figure(figsize=(_WIDTH_PX / _DPI, 0.6 + 0.28 * (len(rows) + 1)), dpi=_DPI)
    axes = figure.add_axes((0.01, 0.0, 0.98, 0.9))
    axes.axis("off")
    short = [[_short(cell) for cell in row] for row in [head, *rows]]
    axes.set_title(_short(title), loc="left", fontsize=10)
    cells = short[1:] or [[""] * len(head)]
    table = axes.table(
        cellText=cells, colLabels=short[0], loc="upper left", cellLoc="left", edges="horizontal"
    )
    table.auto_set_font_size(value=False)
    table.set_fontsize(8)
    table.auto_set_column_width(list(range(len(head))))
    return picture_of_figure(figure)


def _short(name: str) -> str:
    """Return a name as matplotlib takes it: never as mathematics, and not longer than its cell."""
    cut = name if len(name) <= _LONGEST else f"{name[: _LONGEST - 1]}…"
    return cut.replace("$", r"\$")


def _png(image: np.ndarray) -> bytes:
    """Return an RGB picture as a PNG file."""
    _, data = cv2.imencode(".png", cv2.cvtColor(image, cv2.COLOR_RGB2BGR))
    return data.tobytes()
