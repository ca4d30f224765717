"""The page around plots: its room, whether it is dark, and whether Python still hears it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import anywidget
import traitlets

_STATIC = Path(__file__).parent / "static"


def read_static(*names: str) -> str:
    """Return files of ``static`` joined into one module or style sheet."""
    return "\n".join((_STATIC / name).read_text(encoding="utf-8") for name in names)


class Surroundings(anywidget.AnyWidget):
    """A line above plots that tells Python what the page is like.

    Nothing is seen of it while all is well; where the kernel is lost it says so.

    Attributes
    ----------
    width, height : int
        Room for the plots and height of the window, CSS px; 0 before a browser shows it.
    dark : bool
        Whether the page is dark.
    """

    _esm = read_static("connection.js", "surroundings.js")
    _css = read_static("frame_canvas.css", "surroundings.css")

    width = traitlets.Int(0).tag(sync=True)
    height = traitlets.Int(0).tag(sync=True)
    dark = traitlets.Bool(default_value=False).tag(sync=True)

    def __init__(self) -> None:
        super().__init__()
        self.on_msg(self._receive)

    def bring(self) -> None:
        """Scroll to the first shown that has the class ``pawnb-next``, if it begins above."""
        self.send({"type": "bring"})

    def _receive(self, _widget: Any, message: dict[str, Any], _buffers: Any) -> None:
        """Answer the browser, which asks whether anybody is there."""
        if message.get("type") == "hello":
            self.send({"type": "hello", "who": message["who"]})
