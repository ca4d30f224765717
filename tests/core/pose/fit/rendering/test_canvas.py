"""Every thread paints on a canvas of its own; one that is large enough is used again."""

import threading

import numpy as np

from pawnb.core.parallel import on_threads
from pawnb.core.pose.fit.layout import make_layout
from pawnb.core.pose.fit.rendering.canvas import Canvas
from pawnb.core.pose.species_file import load_species

LAYOUT = make_layout(load_species("dolomedes"), px_per_unit=2.0)


def test_threads_do_not_paint_over_each_other():
    canvas, met = Canvas(LAYOUT), threading.Barrier(2, timeout=5)

    def paint(number):
        value, _, _, joints = canvas.of_shape((4, 5))
        value[:], joints[:] = number, number
        met.wait()  # both have painted
        again = canvas.of_shape((4, 5))
        return set(np.unique(again[0])) | set(np.unique(again[3]))

    assert on_threads(paint, [1, 2]) == [{1.0}, {2.0}]


def test_a_canvas_grows_and_is_then_used_again():
    canvas = Canvas(LAYOUT)
    small = canvas.of_shape((3, 4))
    large = canvas.of_shape((6, 7))
    assert [a.shape for a in large[:3]] == [(6, 7)] * 3
    assert large[3].shape == (*LAYOUT.radius.shape, 2)
    assert not np.shares_memory(small[0], large[0])
    assert np.shares_memory(large[0], canvas.of_shape((2, 2))[0])
    assert all(a.flags.c_contiguous for a in canvas.of_shape((5, 3)))
