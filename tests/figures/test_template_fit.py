"""Template fit: which frames are what, and lines that are the table."""

from __future__ import annotations

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest

from pawnb.errors import InputError
from pawnb.figures import build_template_fit_table, plot_template_fit

mpl.use("Agg")


@pytest.fixture(autouse=True)
def _close():
    yield
    plt.close("all")


def table():
    frame = np.arange(10, 20)
    uv = np.column_stack([np.arange(10.0), 5.0 + np.arange(10.0)])
    uv[7] = np.nan
    return build_template_fit_table(frame, uv, uv + 0.5, used=(12, 16), foretold=(16, 18))


def test_parts_by_hand():
    made = table()
    assert made["part"].tolist() == (
        ["other"] * 2 + ["used for the fit"] * 4 + ["foretold"] * 2 + ["other"] * 2
    )
    np.testing.assert_allclose(made["u_fit"], made["u"] + 0.5)
    assert made["u"].isna().tolist() == [False] * 7 + [True] + [False] * 2


def test_dots_line_and_collision():
    made = table()
    above, below = plot_template_fit(made).figure.axes
    for ax, name in ((above, "u"), (below, "v")):
        line = next(item for item in ax.lines if item.get_label() == "template")
        np.testing.assert_array_equal(line.get_ydata(), made[f"{name}_fit"])
        dots = np.concatenate([d.get_ydata() for d in ax.lines if d.get_linestyle() == "None"])
        np.testing.assert_allclose(np.sort(dots), np.sort(made[name]))
        (shade,) = ax.patches
        assert (shade.get_x(), shade.get_x() + shade.get_width()) == (15.5, 17.5)
        assert ax.get_ylabel() == f"{name} (px)"
    low, high = below.get_ylim()
    assert low > high  # v points down


def test_bad_input_is_refused():
    with pytest.raises(InputError, match=r"^template fit: positions of shape \(3, 2\)"):
        build_template_fit_table([1, 2], np.zeros((3, 2)), np.zeros((3, 2)), used=(0, 2))
    with pytest.raises(InputError, match=r"none of the frames is in \(5, 6\)"):
        build_template_fit_table([1, 2], np.zeros((2, 2)), np.zeros((2, 2)), used=(5, 6))
