"""Stepping patterns: which trials, which stretch, and bars where the table says."""

from __future__ import annotations

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest

from pawnb.errors import InputError
from pawnb.figures import build_stepping_pattern_table, plot_stepping_pattern
from pawnb.figures.stepping_pattern import choose_window

mpl.use("Agg")


@pytest.fixture(autouse=True)
def _close():
    yield
    plt.close("all")


def tables(speeds=(100.0, 300.0, 200.0), animal="a"):
    """Two legs land every 0.2 s for 2 s and lift 0.12 s later; R1 half a stride later."""
    events, strides = [], []
    for i, speed in enumerate(speeds):
        who = {"animal": animal, "trial": f"t{i}"}
        for leg, late in (("L1", 0.0), ("R1", 0.1)):
            for k in range(10):
                at = 0.2 * k + late
                events += [
                    {**who, "leg": leg, "event": "AEP", "time_s": at},
                    {**who, "leg": leg, "event": "PEP", "time_s": at + 0.12},
                ]
                strides.append(
                    {
                        **who,
                        "leg": leg,
                        "period_s": 0.2,
                        "speed": speed,
                        "frequency_hz": 5.0,
                        "stride_length": speed / 5.0,
                    }
                )
    return pd.DataFrame(events), pd.DataFrame(strides)


def test_trials_go_from_the_slowest_to_the_fastest():
    table = build_stepping_pattern_table(*tables())
    first = table.drop_duplicates("panel")
    assert first["trial"].tolist() == ["t0", "t2", "t1"]
    assert first["speed"].tolist() == [100.0, 200.0, 300.0]
    assert first["stride_length"].tolist() == [20.0, 40.0, 60.0]
    assert (first["n_strides"] == 20).all()
    # four strides of 0.2 s; the recording lasts from 0 to 2.02 s
    np.testing.assert_allclose(table["span_s"], 0.8)


def test_bars_of_the_middle_by_hand():
    """Events run from 0 to 2.02 s, so 0.8 s about the middle begin at 0.61 s."""
    table = build_stepping_pattern_table(*tables(), trials=[("a", "t1")])
    left = table[table["leg"] == "L1"]
    # stances of L1: 0.6-0.72 (cut at 0.61), 0.8-0.92, 1.0-1.12, 1.2-1.32, 1.4-1.52 (cut at 1.41)
    np.testing.assert_allclose(left["start_s"], [0.0, 0.19, 0.39, 0.59, 0.79], atol=1e-9)
    np.testing.assert_allclose(left["end_s"], [0.11, 0.31, 0.51, 0.71, 0.8], atol=1e-9)


def test_the_animal_with_the_most_trials_is_shown():
    events, strides = (pd.concat(pair) for pair in zip(tables(), tables((50.0,), "b"), strict=True))
    assert set(build_stepping_pattern_table(events, strides)["animal"]) == {"a"}
    chosen = build_stepping_pattern_table(events, strides, trials=[("b", "t0")], span_s=0.5)
    assert set(chosen["animal"]) == {"b"}
    assert set(chosen["span_s"]) == {0.5}


def test_panels_bars_and_scale():
    table = build_stepping_pattern_table(*tables())
    axes = plot_stepping_pattern(table, unit="mm").figure.axes
    assert len(axes) == 3
    for number, ax in enumerate(axes):
        own = table[table["panel"] == number]
        assert [bar.get_x() for bar in ax.patches] == own["start_s"].tolist()
        assert ax.get_xlim() == (0.0, pytest.approx(0.8))
    said = axes[1].get_title()
    assert said == "a, t2\nspeed 200 mm/s, 5.00 strides/s, stride length 40 mm"
    (scale,) = axes[2].lines
    assert scale.get_xdata().tolist() == [0.0, 0.2]
    assert axes[2].get_xlabel() == "0.2 s"


def test_bad_input_is_refused():
    events, strides = tables()
    with pytest.raises(InputError, match=r"^stepping pattern: no strides of animal 'x'"):
        build_stepping_pattern_table(events, strides, trials=[("x", "t0")])
    with pytest.raises(InputError, match=r"^span_s is 0; expected more than 0"):
        build_stepping_pattern_table(events, strides, span_s=0)
    with pytest.raises(InputError, match=r"^stepping pattern: no strides; expected"):
        build_stepping_pattern_table(events, strides.iloc[:0])
    table = build_stepping_pattern_table(events, strides)
    with pytest.raises(InputError, match=r"3 trials for one axes"):
        plot_stepping_pattern(table, ax=plt.subplot())


def test_a_stretch_is_shown_in_which_the_animal_steps():
    """Two runs of 1 s with a pause of 8 s between, in the middle of which nothing is to be seen."""
    events, strides = tables(speeds=(100.0,))
    strides["start_s"] = [0.2 * k + late for late in (0.0, 0.1) for k in range(10)]
    events.loc[events["time_s"] >= 1.0, "time_s"] += 8.0
    strides.loc[strides["start_s"] >= 1.0, "start_s"] += 8.0
    table = build_stepping_pattern_table(events, strides)
    assert table["span_s"].iloc[0] == pytest.approx(0.8)
    stances = table[table["phase"] == "stance"]
    for leg in ("L1", "R1"):
        own = stances[stances["leg"] == leg]
        assert np.isclose(own["end_s"] - own["start_s"], 0.12).sum() >= 3
    # where it steps all the time the middle is shown, as it always was
    reach = (0.0, 2.0)
    assert choose_window(strides.assign(start_s=np.tile(np.arange(10) * 0.2, 2)), reach, 0.8) == 0.6


def test_long_names_are_broken_and_large_numbers_are_written_out():
    # the name of a file was there twice, and cut off at both sides; 3001 mm/s was "3e+03"
    events, strides = tables()
    name = "Carcinus_maenas_trial_0_long_name_of_a_recording"
    strides = strides.assign(animal=name, trial=name, speed=3001.0)
    table = build_stepping_pattern_table(events.assign(animal=name, trial=name), strides)
    ax = plot_stepping_pattern(table, unit="mm")
    title = ax.get_title()
    assert "speed 3001 mm/s" in title
    assert title.replace("\n", "").count(name) == 1
    ax.figure.canvas.draw()
    assert ax.title.get_window_extent().width < ax.figure.bbox.width
