"""Figures 3.10 and 3.11: tables against the functions they stand on, and what is drawn."""

from __future__ import annotations

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest

from pawnb.errors import InputError
from pawnb.figures.filter_effect import build_filter_effect_table, plot_filter_effect
from pawnb.figures.residual_analysis import (
    build_residual_analysis_table,
    plot_residual_analysis,
)
from pawnb.gait.residuals import analyse_residuals, compare_cutoffs
from pawnb.signals import differentiate

mpl.use("Agg")
FS = 250.0


@pytest.fixture(autouse=True)
def _close():
    yield
    plt.close("all")


def signals():
    t = np.arange(400) / FS
    rng = np.random.default_rng(0)
    wave = 40 * np.sin(2 * np.pi * 3 * t) + 8 * np.sin(2 * np.pi * 7 * t)
    return pd.DataFrame({"L1": wave + rng.standard_normal(400), "R1": wave[::-1]}).assign(
        R1=lambda d: d["R1"] + 0.3 * rng.standard_normal(400)
    )


@pytest.mark.slow
def test_residual_table_is_that_of_each_signal_and_of_all():
    table = build_residual_analysis_table(signals(), fs_hz=FS)
    assert table["signal"].unique().tolist() == ["L1", "R1", "pooled"]
    chosen = table.groupby("signal", sort=False)["chosen_hz"].first()
    alone = analyse_residuals(signals()["R1"].to_numpy(), fs_hz=FS)
    assert chosen["R1"] == alone.cutoff_hz
    rows = compare_cutoffs(signals(), fs_hz=FS).query("method == 'residual'")
    np.testing.assert_array_equal(rows["cutoff_hz"], chosen)


@pytest.mark.slow
def test_residual_table_takes_one_signal_without_a_name():
    plain = signals().iloc[:, 0].to_numpy()
    table = build_residual_analysis_table(plain, fs_hz=FS)
    assert table["signal"].unique().tolist() == ["signal 1"]
    np.testing.assert_array_equal(
        table["residual"], build_residual_analysis_table(plain[:, None], fs_hz=FS)["residual"]
    )
    with pytest.raises(InputError, match="signals have 3 dimensions"):
        build_residual_analysis_table(np.zeros((40, 2, 2)), fs_hz=FS)


def test_residual_figure_shows_curve_line_and_cutoff():
    table = build_residual_analysis_table(signals(), fs_hz=FS)
    figure = plot_residual_analysis(table, unit="deg").figure
    assert [ax.get_title() for ax in figure.axes] == ["L1", "R1", "pooled"]
    assert [ax.get_title(loc="left") for ax in figure.axes] == ["a", "b", "c"]
    assert figure.axes[0].get_ylabel() == "Residual, RMS (deg)"
    for ax, (_, own) in zip(figure.axes, table.groupby("signal", sort=False), strict=True):
        curve = ax.lines[0].get_xydata()
        np.testing.assert_array_equal(curve, own[["cutoff_hz", "residual"]])
        chosen = own["chosen_hz"].iloc[0]
        assert ax.texts[0].get_text() == f"cut-off {chosen:.2f} Hz"
        corner = ax.lines[3].get_xydata()
        np.testing.assert_allclose(corner[1], [chosen, own["noise_rms"].iloc[0]])
        # Winter 2009: the line through the noise meets the axis at the noise's RMS
        np.testing.assert_allclose(ax.lines[2].get_xydata()[0], [0.0, own["noise_rms"].iloc[0]])


def test_residual_figure_says_when_there_is_no_cutoff():
    noise = pd.DataFrame({"x": np.random.default_rng(5).standard_normal(300)})
    table = build_residual_analysis_table(noise, fs_hz=FS)
    ax = plot_residual_analysis(table)
    (said,) = [text.get_text().replace("\n", " ") for text in ax.texts]
    assert said.startswith("no cut-off: the noise line starts at")


def test_residual_figure_says_why_a_stride_of_few_frames_has_no_cutoff():
    t = np.arange(300) / 100
    x = np.sin(2 * np.pi * 10 * t) + 0.002 * np.random.default_rng(1).standard_normal(300)
    table = build_residual_analysis_table(pd.DataFrame({"x": x}), fs_hz=100.0)
    assert table["chosen_hz"].isna().all()
    assert table["noise_rms"].isna().all()
    assert table["reason"].iloc[0].startswith("no cut-off: the line's noise")
    ax = plot_residual_analysis(table)
    said = ax.texts[0].get_text().replace("\n", " ").replace("- ", "-")
    assert said in table["reason"].iloc[0]


def test_a_foot_that_is_hardly_seen_does_not_hide_the_others():
    seen = signals().iloc[:, 0]
    rare = seen.where(np.arange(len(seen)) % 15 > 0)  # a gap after every 14 samples
    both = pd.DataFrame({"FL": rare, "FR": seen, "HR": np.nan, "HL": 3.0})
    table = build_residual_analysis_table(both, fs_hz=FS)
    first = table.groupby("signal", sort=False).first()
    assert first.index.tolist() == ["FL", "FR", "HR", "HL", "pooled"]
    assert first.loc["FL", "reason"] == "no cut-off: no run of 20 samples without a gap"
    assert first.loc["HR", "reason"].startswith("no cut-off: no value in any frame")
    assert first.loc["FR", "chosen_hz"] == analyse_residuals(seen.to_numpy(), fs_hz=FS).cutoff_hz
    figure = plot_residual_analysis(table).figure
    said = [ax.texts[0].get_text().replace("\n", " ") for ax in figure.axes]
    assert said[0] == "no cut-off: no run of 20 samples without a gap"
    assert said[1] == f"cut-off {first.loc['FR', 'chosen_hz']:.2f} Hz"
    with pytest.raises(InputError, match=r"^residual analysis: no run of 20 samples without a gap"):
        build_residual_analysis_table(both[["FL"]], fs_hz=FS)


def test_one_axes_for_several_signals_is_refused():
    table = build_residual_analysis_table(signals(), fs_hz=FS)
    _, ax = plt.subplots()
    with pytest.raises(InputError, match=r"^residual analysis: 3 panels for one axes; choose"):
        plot_residual_analysis(table, ax=ax)
    assert plot_residual_analysis(table[table["signal"] == "L1"], ax=ax) is ax
    with pytest.raises(InputError, match=r"^residual analysis: no signal; expected at least one"):
        build_residual_analysis_table(pd.DataFrame(), fs_hz=FS)
    with pytest.raises(InputError, match=r"^residual analysis: the table is empty\.$"):
        plot_residual_analysis(table.iloc[:0])


def test_filter_effect_holds_raw_and_filtered_derivatives():
    x = signals()["L1"].to_numpy()
    table = build_filter_effect_table(x, fs_hz=FS, cutoff_hz=12.0, span_s=(0.4, 0.8))
    parts = dict(list(table.groupby("quantity", sort=False)))
    assert list(parts) == ["position", "velocity", "acceleration"]
    shown = slice(100, 201)
    raw = differentiate(x, dt=1 / FS, order=2)[shown]
    np.testing.assert_allclose(parts["acceleration"]["raw"], raw)
    # the noise of the raw acceleration is many times that of the filtered one (section 3.5)
    spread = {name: np.std(own["raw"] - own["filtered"]) for name, own in parts.items()}
    assert spread["acceleration"] > 100 * spread["velocity"] > 100 * spread["position"]
    spline = build_filter_effect_table(x, fs_hz=FS, cutoff_hz=None, method="spline")
    assert spline["cutoff_hz"].isna().all()
    assert len(spline) == 1200


def test_filter_figure_has_three_panels_with_units():
    x = signals()["L1"].to_numpy()
    table = build_filter_effect_table(x, fs_hz=FS, cutoff_hz=12.0, span_s=(0.4, 0.8))
    figure = plot_filter_effect(table, unit="deg", name="Leg angle").figure
    labels = [ax.get_ylabel() for ax in figure.axes]
    assert labels == ["Leg angle (deg)", "Velocity (deg/s)", "Acceleration (deg/s²)"]
    assert figure.get_size_inches()[0] == pytest.approx(85 / 25.4)
    raw, filtered = figure.axes[2].lines
    own = table[table["quantity"] == "acceleration"]
    np.testing.assert_array_equal(raw.get_ydata(), own["raw"])
    np.testing.assert_array_equal(filtered.get_ydata(), own["filtered"])
    names = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert names == ["raw", "Butterworth, 12 Hz"]


def test_filter_effect_refuses_what_is_no_signal():
    with pytest.raises(InputError, match=r"^filter effect: x has 2 dimensions; expected one"):
        build_filter_effect_table(np.zeros((5, 2)), fs_hz=FS, cutoff_hz=9.0)
    with pytest.raises(InputError, match=r"^filter effect: no sample in the span; expected"):
        build_filter_effect_table(np.zeros(50), fs_hz=FS, cutoff_hz=9.0, span_s=(5, 6))
