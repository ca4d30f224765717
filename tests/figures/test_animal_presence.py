"""The view of Fig. 3.1: what is drawn is what the table says."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

from pawnb.errors import InputError
from pawnb.figures import build_animal_presence_table, plot_animal_presence


def table():
    return build_animal_presence_table(
        np.arange(10, 16), [0, 5, 4, 90, 80, 6], threshold=9.5, has_animal=[0, 0, 0, 1, 1, 0]
    )


def test_table_holds_every_frame():
    made = table()
    assert list(made["frame"]) == [10, 11, 12, 13, 14, 15]
    assert list(made["has_animal"]) == [False, False, False, True, True, False]
    assert set(made["threshold"]) == {9.5}


def test_drawn_lines_are_the_table():
    ax = plot_animal_presence(table())
    curve, limit = ax.lines
    np.testing.assert_array_equal(curve.get_ydata(), [0, 5, 4, 90, 80, 6])
    assert set(limit.get_ydata()) == {9.5}
    (shade,) = ax.patches
    assert (shade.get_x(), shade.get_x() + shade.get_width()) == (12.5, 14.5)
    plt.close(ax.figure)


def test_unequal_lengths_and_a_missing_threshold_are_refused():
    with pytest.raises(InputError, match="3 frames, 2 differences and 3 decisions"):
        build_animal_presence_table([1, 2, 3], [0, 1], threshold=1, has_animal=[0, 0, 0])
    with pytest.raises(InputError, match="threshold is nan"):
        build_animal_presence_table([1], [0], threshold=float("nan"), has_animal=[0])
