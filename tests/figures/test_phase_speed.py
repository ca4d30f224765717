"""Phase against speed: points by hand, and correlations that count animals."""

from __future__ import annotations

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest

from pawnb.errors import InputError
from pawnb.figures import build_phase_speed_table, plot_phase_speed
from pawnb.gait.circular_correlation import angular_linear

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
                phase = (0.3 + 0.001 * speed + 0.02 * (k - 2) + 0.03 * np.sin(7.0 * a)) % 1.0
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


def test_the_correlation_counts_animals():
    table = build_phase_speed_table(*tables())
    expected = angular_linear(
        table["phase"].to_numpy(), table["speed"].to_numpy(), animals=table["animal"].tolist()
    )
    assert set(table["basis"]) == {"animals"}
    np.testing.assert_allclose(table["r_al"], expected.r)
    np.testing.assert_allclose(table["p"], expected.p_permutation)
    assert (table["n_animals"] == 5).all()


def test_few_animals_are_said_to_be_counted_as_trials():
    table = build_phase_speed_table(*tables(n_animals=2, trials=4))
    assert set(table["basis"]) == {"trials"}
    said = plot_phase_speed(table).texts[0].get_text()
    assert said.endswith("if 8 trials\nof 2 animals were independent")
    alone = build_phase_speed_table(*tables(n_animals=1, trials=2))
    assert alone["r_al"].isna().all()
    assert plot_phase_speed(alone).texts[0].get_text() == "2 trials, 1 animal: no r"


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
    assert limits == [{0.25}, {0.75}]
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
