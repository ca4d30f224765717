"""Averages, phase planes and aligned acceleration: drawn is what the tables say."""

from __future__ import annotations

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest

from pawnb.errors import InputError
from pawnb.figures import (
    build_aligned_acceleration_table,
    build_phase_plane_table,
    plot_aligned_acceleration,
    plot_phase_plane,
    plot_stride_average,
)
from pawnb.gait.cycles import LegSignals, align_acceleration, average_cycles, cut_cycles

mpl.use("Agg")


@pytest.fixture(autouse=True)
def _close():
    yield
    plt.close("all")


LEGS, AMPLITUDE = ("L1", "R1", "L2", "R2"), 20.0


def make(n_strides=3, animals=("a", "b")):
    """Cosines of 2 strides a second about 0, 10, 20 and 30 degrees; b's are 4 degrees higher."""
    t = np.arange(0.0, 3.0, 0.001)
    signals, rows = [], []
    for k, animal in enumerate(animals):
        x = AMPLITUDE * np.cos(4.0 * np.pi * t)[:, None] + [0.0, 10.0, 20.0, 30.0] + 4.0 * k
        signals.append(LegSignals(animal=animal, trial="t", legs=LEGS, time_s=t, samples=x))
        rows += [
            {"animal": animal, "trial": "t", "leg": leg, "stride": i + 1,
             "start_s": 0.5 + 0.5 * i, "period_s": 0.5, "stance_s": 0.25}
            for leg in LEGS
            for i in range(n_strides)
        ]  # fmt: skip
    return signals, pd.DataFrame(rows)


def test_averages_are_drawn_with_their_bands():
    table = average_cycles(cut_cycles(*make()))
    axes = plot_stride_average(table).figure.axes
    assert [ax.get_title() for ax in axes] == ["Legs 1", "Legs 2"]
    for ax, legs in zip(axes, (("L1", "R1"), ("L2", "R2")), strict=True):
        for line, leg in zip(ax.lines, legs, strict=True):
            own = table[table["leg"] == leg]
            np.testing.assert_allclose(line.get_ydata(), own["mean"])
        assert ax.lines[0].get_linestyle() == "-"
        assert ax.lines[1].get_linestyle() == "--"
        corners = ax.collections[0].get_paths()[0].vertices[:, 1]
        own = table[table["leg"] == legs[0]]
        assert corners.max() == pytest.approx(own["high"].max())
        assert corners.min() == pytest.approx(own["low"].min())
        assert ax.texts[0].get_text() == f"12 strides, 2 animals\ndashed: {legs[1]}"
    spans = [np.ptp(ax.get_ylim()) for ax in axes]
    assert spans[0] == pytest.approx(spans[1])
    assert axes[0].get_ylabel() == "Leg angle (deg)"
    legend = axes[0].figure.legends[0].get_texts()[0].get_text()
    assert legend == "95 % interval of the mean of animals"


def test_the_phase_plane_of_a_cosine_is_an_ellipse():
    table = build_phase_plane_table(cut_cycles(*make()))
    own = table[(table["leg"] == "L1") & (table["kind"] == "mean")]
    speed = AMPLITUDE * 4.0 * np.pi
    # the mean of animals at 0 and 4 degrees runs about 2
    radius = ((own["value"] - 2.0) / AMPLITUDE) ** 2 + (own["velocity"] / speed) ** 2
    np.testing.assert_allclose(radius, 1.0, atol=0.01)
    assert (own["n_strides"] == 6).all()


def test_animals_count_once_in_the_phase_plane():
    """Animal a, about 0 degrees, has three strides, b, about 4 degrees, one: the mean is 2."""
    signals, strides = make()
    kept = strides[(strides["animal"] == "a") | (strides["stride"] == 1)]
    table = build_phase_plane_table(cut_cycles(signals, kept), legs=["L1"])
    mean = table[table["kind"] == "mean"]
    assert (mean["value"].max() + mean["value"].min()) / 2.0 == pytest.approx(2.0, abs=0.05)


def test_the_mean_acceleration_ends_where_half_of_the_strides_end():
    """Two strides of five reach to 50 percent of the swing, the others to 20."""
    rows = [
        {"animal": "a", "trial": "t", "leg": "L1", "stride": k, "phase": "swing",
         "percent": float(p), "acceleration": 1.0, "peak_velocity": 1.0, "signal": "leg angle",
         "unit": "deg"}
        for k, reach in enumerate((50, 50, 20, 20, 20))
        for p in range(-20, reach + 1, 10)
    ]  # fmt: skip
    table = build_aligned_acceleration_table(pd.DataFrame(rows))
    assert table.loc[table["kind"] == "mean", "percent"].max() == 20.0
    # four of them: half reach to 50
    table = build_aligned_acceleration_table(pd.DataFrame(rows).query("stride < 4"))
    assert table.loc[table["kind"] == "mean", "percent"].max() == 50.0


def test_few_of_many_strides_are_drawn_but_all_are_averaged():
    signals, strides = make(n_strides=4)
    table = build_phase_plane_table(cut_cycles(signals, strides), legs=["L1"], most=3)
    shown = table[table["kind"] == "stride"].drop_duplicates(["animal", "trial", "stride"])
    assert len(shown) == 3
    assert (table["n_strides"] == 8).all()
    ax = plot_phase_plane(table)
    thin = [line for line in ax.lines if line.get_linewidth() < 0.5]
    assert len(thin) == 3
    mean = table[table["kind"] == "mean"]
    np.testing.assert_allclose(ax.lines[-1].get_xydata(), mean[["value", "velocity"]])
    assert ax.get_ylabel() == "Velocity (deg/s)"


def test_panels_of_the_phase_plane_have_the_same_width():
    axes = plot_phase_plane(build_phase_plane_table(cut_cycles(*make()))).figure.axes
    widths = [np.ptp(ax.get_xlim()) for ax in axes]
    assert widths[0] == pytest.approx(widths[1])


def test_a_stride_with_a_gap_is_left_out_of_the_phase_plane():
    signals, strides = make(animals=("a",))
    signals[0].samples[600:650, 0] = np.nan
    table = build_phase_plane_table(cut_cycles(signals, strides))
    assert table.loc[table["leg"] == "L1", "n_strides"].unique().tolist() == [2]
    assert table.loc[table["leg"] == "R1", "n_strides"].unique().tolist() == [3]


def test_acceleration_of_left_legs_about_the_greatest_speed():
    table = build_aligned_acceleration_table(align_acceleration(*make()))
    assert table["leg"].unique().tolist() == ["L1", "L2"]
    mean = table[(table["leg"] == "L1") & (table["kind"] == "mean")]
    greatest = AMPLITUDE * (4.0 * np.pi) ** 2
    expected = -greatest * np.sin(np.pi * mean["percent"] / 100.0)
    np.testing.assert_allclose(mean["acceleration"], expected, atol=0.02 * greatest)
    ax = plot_aligned_acceleration(table)
    thick = next(line for line in ax.lines if line.get_linewidth() == 1.2)
    np.testing.assert_allclose(thick.get_xydata(), mean[["percent", "acceleration"]])
    assert ax.get_xlabel() == "Swing (%), 0: fastest"
    assert ax.get_ylabel() == "Acceleration (deg/s²)"


def test_large_accelerations_are_given_in_thousands():
    table = build_aligned_acceleration_table(align_acceleration(*make(), phase="stance"))
    table["acceleration"] *= 10.0
    ax = plot_aligned_acceleration(table)
    own = table[(table["leg"] == "L1") & (table["kind"] == "mean")]
    thick = next(line for line in ax.lines if line.get_linewidth() == 1.2)
    np.testing.assert_allclose(thick.get_ydata(), own["acceleration"] / 1000.0)
    assert ax.get_ylabel() == "Acceleration (10³ deg/s²)"


def test_bad_input_is_refused():
    signals, strides = make()
    cycles = cut_cycles(signals, strides)
    with pytest.raises(InputError, match=r"no complete stride of leg 'X'; there are those of L1"):
        build_phase_plane_table(cycles, legs=["X"])
    with pytest.raises(InputError, match=r"^phase plane: no stride is complete"):
        build_phase_plane_table(cycles.assign(value=np.nan))
    both = pd.concat([align_acceleration(signals, strides, phase=p) for p in ("swing", "stance")])
    with pytest.raises(InputError, match=r"found swing and stance; expected strides of swing or"):
        build_aligned_acceleration_table(both)
    with pytest.raises(InputError, match=r"2 panels for one axes; choose one of them"):
        plot_stride_average(average_cycles(cycles), ax=plt.subplot())
