"""Room to paint on, each thread's own."""

from __future__ import annotations

import threading

from pawnb.arrays import AnyArray
from pawnb.core.pose.fit.layout import PoseLayout
from pawnb.core.pose.fit.rendering.paint_kernels import make_canvas


class Canvas(threading.local):
    """Arrays that a pose is painted on; they grow, and every thread that asks has its own.

    What is painted does not last: the next one who paints in the same thread paints over it.

    Parameters
    ----------
    layout : PoseLayout
        The animal: how many legs and joints there are.
    """

    def __init__(self, layout: PoseLayout) -> None:
        self._layout = layout
        self._room = make_canvas(1, 1, layout)

    def of_shape(self, shape: tuple[int, ...]) -> tuple[AnyArray, ...]:
        """Return the canvas for a picture of a shape.

        Parameters
        ----------
        shape : tuple of int
            Height and width of the picture, working px.

        Returns
        -------
        tuple of ndarray
            Value, owner and along, (H, W), and joints: as :func:`.make_canvas` returns them, but
            with what was painted there before.
        """
        height, width = shape
        size = height * width
        if size > self._room[0].size:
            self._room = make_canvas(1, size, self._layout)
        value, owner, along, joints = self._room
        return (
            value.ravel()[:size].reshape(shape),
            owner.ravel()[:size].reshape(shape),
            along.ravel()[:size].reshape(shape),
            joints,
        )
