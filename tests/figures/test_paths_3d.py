"""Paths in space: gaps stay gaps, all axes have one scale."""

from __future__ import annotations

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest

from pawnb.errors import InputError
from pawnb.figures import build_paths_3d_table, plot_paths_3d

mpl.use("Agg")


@pytest.fixture(autouse=True)
def _close():
    yield
    plt.close("all")


def points():
    rows = [(f, "FR", 10.0 * f, 1.0, f % 2) for f in range(5)]
    rows += [(f, "HR", 10.0 * f - 5.0, -1.0, np.nan if f == 2 else 0.0) for f in range(1, 4)]
    rows.append((0, "tail", np.nan, np.nan, np.nan))
    return pd.DataFrame(rows, columns=["frame", "point", "x", "y", "z"])


def test_a_frame_that_was_not_seen_is_a_gap():
    table = build_paths_3d_table(points())
    assert table["point"].unique().tolist() == ["FR", "HR"]
    hind = table[table["point"] == "HR"]
    assert hind["frame"].tolist() == [1, 2, 3]
    assert hind["x"].isna().tolist() == [False, True, False]
    assert build_paths_3d_table(points(), frames=(1, 3))["frame"].max() == 2


def test_lines_are_the_table_in_all_three_panels():
    table = build_paths_3d_table(points())
    space, side, above = plot_paths_3d(table, unit="mm").figure.axes
    own = table[table["point"] == "FR"]
    x, y, z = space.lines[0].get_data_3d()
    np.testing.assert_allclose([x, y, z], own[["x", "y", "z"]].T)
    np.testing.assert_allclose(side.lines[0].get_xydata(), own[["x", "z"]])
    np.testing.assert_allclose(above.lines[0].get_xydata(), own[["x", "y"]])
    assert (side.get_ylabel(), above.get_ylabel(), above.get_xlabel()) == (
        "z (mm)", "y (mm)", "x (mm)",
    )  # fmt: skip
    assert side.get_aspect() == above.get_aspect() == 1.0
    # the box of the perspective has the proportions of its limits
    box = space._box_aspect
    spans = [np.ptp(getattr(space, f"get_{k}lim")()) for k in "xyz"]
    np.testing.assert_allclose(box / box[0], np.array(spans) / spans[0])
    # the triad: three lines of 5 mm (an eighth of 40 mm)
    triad = [np.ptp(np.array(line.get_data_3d()), axis=1).max() for line in space.lines[2:]]
    np.testing.assert_allclose(triad, 5.0)
    assert space.texts[-1].get_text() == "each line: 5 mm"


def test_bad_input_is_refused():
    with pytest.raises(InputError, match=r"point 'tail' is never seen.*there are FR, HR"):
        build_paths_3d_table(points(), points=["tail"])
    with pytest.raises(InputError, match=r"^paths: no point is seen in space"):
        build_paths_3d_table(points(), frames=(9, 10))
