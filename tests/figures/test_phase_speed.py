"""Phase against speed: points by hand, and slopes within animals."""

from __future__ import annotations

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest

from pawnb.errors import InputError
from pawnb.figures import build_phase_speed_table, plot_phase_speed
from pawnb.gait.regression.phase_slopes import phase_speed_table

mpl.use("Agg")


@pytest.fixture(autouse=True)
def _close():
    yield
    plt.close("all")


def tables(n_animals=5, trials=2, strides=3):
    """Phases that grow with speed; speeds differ between animals and trials."""
    phases, base = [], []
    for a in range(n_animals):
        for t in range(trials):
            speed = 100.0 + 40.0 * a + 7.0 * t
            for k in range(1, strides + 1):
                key = {"animal": f"m{a}", "trial": f"t{t}", "stride": k}
                within = (0.02 + 0.001 * a) * (k - 2)  # slopes differ between animals
                phase = (0.3 + 0.001 * speed + within + 0.03 * np.sin(7.0 * a)) % 1.0
                phases.append({**key, "leg": "L1", "reference": "L2", "phase": phase})
                base.append({**key, "leg": "L2", "speed": speed + k})
    return pd.DataFrame(phases), pd.DataFrame(base)


def test_a_point_is_a_trial():
    phases, strides = tables()
    table = build_phase_speed_table(phases, strides)
    assert len(table) == 10
    first = table.iloc[0]
    assert first["speed"] == pytest.approx(102.0)  # mean of 101, 102, 103
    assert first["phase"] == pytest.approx(phases["phase"].iloc[:3].mean())  # evenly about it
    assert first["n_strides"] == 3


def test_slopes_are_those_within_animals():
    phases, strides = tables()
    table = build_phase_speed_table(phases, strides)
    expected = phase_speed_table(phases, strides).iloc[0]
    for name in ("slope", "ci_low", "ci_high", "p", "n_animals"):
        assert set(table[name]) == {expected[name]}
    # each animal's own line, by least squares on its six strides
    m1 = phases["animal"] == "m1"
    own = np.polyfit(strides.loc[m1, "speed"], phases.loc[m1, "phase"], 1)
    row = table[table["animal"] == "m1"].iloc[0]
    assert row["animal_slope"] == pytest.approx(own[0])
    assert row["animal_phase"] == pytest.approx(np.polyval(own, row["animal_speed"]), abs=1e-4)


def test_what_is_said_above_a_panel():
    found = build_phase_speed_table(*tables())
    said = plot_phase_speed(found).texts[0].get_text()
    first = found.iloc[0]
    assert said.startswith(f"slope {first['slope']:.2g} [")
    assert first["p"] < 0.001
    assert said.endswith("]\np < 0.001, 5 animals")
    alone = build_phase_speed_table(*tables(n_animals=1, trials=2))
    assert alone["p"].isna().all()
    assert plot_phase_speed(alone).texts[0].get_text().endswith(", 1 animal")
    phases, strides = tables()
    flat = build_phase_speed_table(phases, strides.assign(speed=100.0))
    assert plot_phase_speed(flat).texts[0].get_text() == "no animal at several speeds"


def test_lines_of_animals_leave_the_cycle_and_return():
    phases, strides = tables(n_animals=1, trials=5)
    rising = 0.4 + 0.021 * (strides["speed"] - 100.0)
    table = build_phase_speed_table(phases.assign(phase=rising % 1.0), strides)
    lines = [line for line in plot_phase_speed(table).lines if line.get_linestyle() == "-"]
    assert len(lines) == 2
    ends = np.array([line.get_ydata() for line in lines])
    assert ends[0] - ends[1] == pytest.approx([1.0, 1.0])


def test_every_stride_can_be_a_point():
    phases, strides = tables()
    table = build_phase_speed_table(phases, strides, per="stride")
    np.testing.assert_allclose(table["phase"], phases["phase"])
    assert table["speed"].tolist() == strides["speed"].tolist()


def test_points_limits_and_marks():
    table = build_phase_speed_table(*tables())
    ax = plot_phase_speed(table, unit="mm")
    points = [line for line in ax.lines if line.get_linestyle() == "None"]
    assert len(points) == 5 == len({p.get_marker() for p in points})
    drawn = np.concatenate([p.get_xydata() for p in points])
    np.testing.assert_allclose(drawn, table[["speed", "phase"]])
    limits = [set(line.get_ydata()) for line in ax.lines if line.get_linestyle() == "--"]
    assert limits == [{0.4}, {0.6}]
    assert ax.get_xlabel() == "Speed (mm/s)"
    assert ax.get_ylabel() == "Phase (cycles)"
    names = [t.get_text() for t in ax.figure.legends[0].get_texts()]
    assert names == [f"m{k}" for k in range(5)]


def test_bad_input_is_refused():
    phases, strides = tables()
    with pytest.raises(InputError, match=r"no stride has a speed; speeds need tracks"):
        build_phase_speed_table(phases, strides.assign(speed=np.nan))
    with pytest.raises(InputError, match=r"^per is 'animal'; expected 'trial' or 'stride'"):
        build_phase_speed_table(phases, strides, per="animal")


def test_phases_about_0_stand_beside_each_other():
    # 0.98 and 0.02 are neighbours (CONVENTIONS.md); they stood at the two ends of the axis
    phases, strides = tables(n_animals=3)
    low, high = phases["animal"] == "m0", phases["animal"] != "m0"
    phases.loc[low, "phase"], phases.loc[high, "phase"] = 0.98, 0.02
    ax = plot_phase_speed(build_phase_speed_table(phases, strides))
    drawn = np.concatenate([p.get_ydata() for p in ax.lines if p.get_linestyle() == "None"])
    assert set(np.round(drawn, 6)) == {-0.02, 0.02}
    assert [t.get_text() for t in ax.get_yticklabels()] == ["0.5", "", "0", "", "0.5"]
    dashes = [line.get_ydata()[0] for line in ax.lines if line.get_linestyle() == "--"]
    assert dashes == pytest.approx([-0.1, 0.1])  # in-phase, instead of anti-phase


def test_speeds_that_hardly_differ_have_plain_numbers():
    # two crabs of 599.70 and 599.71 px/s had an axis of 0.01 and 0.02 "+5.997e2"
    phases, strides = tables(n_animals=2)
    strides["speed"] = 599.7 + 1e-4 * strides["speed"]
    ax = plot_phase_speed(build_phase_speed_table(phases, strides))
    ax.figure.canvas.draw()
    assert ax.xaxis.get_offset_text().get_text() == ""
    assert np.ptp(ax.get_xlim()) == pytest.approx(0.05 * 599.7, rel=0.01)


def test_dashes_may_stand_where_the_thesis_has_them():
    """Pullar (2009), section 3.6 and Figs. 4.18, 4.19: anti-phase is between 0.25 and 0.75."""
    phases, strides = tables()
    table = build_phase_speed_table(phases, strides)

    def dashes(**options):
        ax = plot_phase_speed(table, **options)
        return [line.get_ydata()[0] for line in ax.lines if line.is_dashed()]

    np.testing.assert_allclose(dashes(), [0.4, 0.6])
    np.testing.assert_allclose(dashes(near=0.25), [0.25, 0.75])
    with pytest.raises(InputError, match="near is 25; expected above 0"):
        plot_phase_speed(table, near=25)
