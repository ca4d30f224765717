"""A matplotlib figure that a widget shows, and that tells where the pointer is (ipympl)."""

from __future__ import annotations

import functools
import threading
from collections.abc import Callable
from typing import Any, TypeVar, cast

import matplotlib as mpl
import matplotlib.pyplot as plt
from matplotlib.figure import Figure

MethodT = TypeVar("MethodT", bound=Callable[..., Any])


def alone(method: MethodT) -> MethodT:
    """Let a method of a widget run while nobody else changes or draws its ``_canvas``.

    Jupyter hears some messages of a page in the kernel's main thread and others, such as the
    canvas's own, in a thread beside it: a figure would be shown as far as it is drawn, and stay so.

    Parameters
    ----------
    method : callable
        A method of a widget whose ``_canvas`` is of :func:`make_canvas`.

    Returns
    -------
    callable
        The same, one thread at a time; it may call others that do the same.
    """

    @functools.wraps(method)
    def held(self: Any, *args: Any, **named: Any) -> Any:
        with self._canvas.alone:
            return method(self, *args, **named)

    return cast("MethodT", held)


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
        The canvas; its manager is set. Its lock ``alone`` is held while it draws; see
        :func:`alone`.
    """
    before = mpl.get_backend()
    # a notebook's backend shows figures at the end of a cell only if it is loaded while it is in
    # force, which pyplot leaves to the first figure
    plt.switch_backend(before)
    from ipympl.backend_nbagg import Canvas, FigureManager

    mpl.use(before)
    canvas = Canvas(figure)
    canvas.alone, draw = threading.RLock(), canvas.draw

    def draw_alone() -> None:
        with canvas.alone:
            draw()

    canvas.draw = draw_alone
    manager = FigureManager(canvas, 0)
    # matplotlib's own keys would make an axis logarithmic in passing
    canvas.mpl_disconnect(manager.key_press_handler_id)
    canvas.header_visible = canvas.toolbar_visible = canvas.footer_visible = False
    return canvas
