"""A matplotlib figure that a widget shows, and that tells where the pointer is (ipympl)."""

from __future__ import annotations

from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt
from matplotlib.figure import Figure


def make_canvas(figure: Figure) -> Any:
    """Return the canvas of a figure, a widget, without a title or toolbar.

    Importing ipympl makes it the backend of every figure of pyplot, which then no longer show
    in a notebook; the backend that was in use stays.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        A figure that pyplot does not know, else it shows a second time.

    Returns
    -------
    ipympl.backend_nbagg.Canvas
        The canvas; its manager is set.
    """
    before = mpl.get_backend()
    # a notebook's backend shows figures at the end of a cell only if it is loaded while it is in
    # force, which pyplot leaves to the first figure
    plt.switch_backend(before)
    from ipympl.backend_nbagg import Canvas, FigureManager

    mpl.use(before)
    canvas = Canvas(figure)
    manager = FigureManager(canvas, 0)
    # matplotlib's own keys would make an axis logarithmic in passing
    canvas.mpl_disconnect(manager.key_press_handler_id)
    canvas.header_visible = canvas.toolbar_visible = canvas.footer_visible = False
    return canvas
