"""The ResidualExplorer: what its state does, and that slider, line and curves go together."""

import numpy as np
import pandas as pd
import pytest

from pawnb.errors import InputError
from pawnb.gait.residuals import analyse_residuals
from pawnb.signals import smooth_motion
from pawnb.widgets.residual_explorer import ResidualExplorer
from pawnb.widgets.residual_session import ResidualSession

FS = 100.0
T = np.arange(400) / FS
RNG = np.random.default_rng(3)
SIGNALS = pd.DataFrame(
    {
        "a": 10 * np.sin(2 * np.pi * 2 * T) + 0.3 * RNG.standard_normal(400),
        "b": 5 * np.cos(2 * np.pi * 1.5 * T) + 0.3 * RNG.standard_normal(400),
    }
)


@pytest.mark.slow
def test_session_begins_at_the_pooled_choice_and_filters_with_the_hand():
    session = ResidualSession(SIGNALS, fs_hz=FS)
    pooled = analyse_residuals(SIGNALS.to_numpy(), fs_hz=FS)
    assert session.cutoff_hz == pytest.approx(pooled.cutoff_hz)
    session.show("b")
    session.set_cutoff(7.0)
    expected = smooth_motion(SIGNALS["b"].to_numpy(), fs_hz=FS, cutoff_hz=7.0)
    np.testing.assert_allclose(session.smoothed().velocity, expected.velocity)
    assert session.text() == "b: cut-off 7.00 Hz."
    own = analyse_residuals(SIGNALS["b"].to_numpy(), fs_hz=FS)
    assert session.chosen()["residual"] == (pytest.approx(own.cutoff_hz), own.reason)


def test_a_method_without_a_choice_says_why():
    # a straight line has no noise: residual analysis finds no cut-off
    session = ResidualSession(pd.DataFrame({"a": T}), fs_hz=FS)
    cutoff_hz, reason = session.chosen()["residual"]
    assert np.isnan(cutoff_hz)
    assert f"residual: {reason}" in session.text()


def test_where_residual_analysis_has_no_answer_the_hand_begins_with_another_method_and_says_so():
    # ten frames a stride: a cut-off of 10.7 Hz would halve the movement
    t = np.arange(300) / FS
    x = np.sin(2 * np.pi * 10 * t) + 0.002 * np.random.default_rng(1).standard_normal(300)
    session = ResidualSession(pd.DataFrame({"a": x}), fs_hz=FS)
    assert session.begun_by == "gcv"
    assert 25 < session.cutoff_hz < 45
    assert "It is that of gcv, as residual analysis has none." in session.text()
    assert "residual: no cut-off: the line's noise" in session.text()
    session.set_cutoff(20.0)
    assert "It is that of" not in session.text()
    noise = np.random.default_rng(1).standard_normal(300)
    nothing = ResidualSession(pd.DataFrame({"a": noise}), fs_hz=FS)
    assert nothing.begun_by == ""
    assert nothing.cutoff_hz == nothing.highest_hz
    assert "next to nothing is taken away" in nothing.text()


@pytest.mark.slow
def test_cutoffs_stay_within_what_the_filter_can_do():
    session = ResidualSession(SIGNALS, fs_hz=FS)
    assert session.set_cutoff(1e6) == session.highest_hz
    assert session.set_cutoff(-3.0) > 0
    with pytest.raises(InputError, match="expected a number"):
        session.set_cutoff(np.nan)
    with pytest.raises(InputError, match="no signal 'c'; there are a, b"):
        session.show("c")


@pytest.mark.slow
def test_a_foot_that_is_hardly_seen_can_be_shown_beside_the_others():
    gaps = SIGNALS["a"].where(np.arange(400) % 15 > 0)
    session = ResidualSession(pd.DataFrame({"FL": gaps, "FR": SIGNALS["a"]}), fs_hz=FS)
    # the pooled samples are those of FR alone, as FL has no run of 20
    own = analyse_residuals(SIGNALS["a"].to_numpy(), fs_hz=FS)
    assert session.cutoff_hz == pytest.approx(own.cutoff_hz)
    assert session.residuals().curve["residual"].isna().all()
    assert "residual: no cut-off: no run of 20 samples" in session.text()
    with pytest.raises(InputError, match=r"no run of 20 samples without a gap; expected at least"):
        ResidualSession(gaps, fs_hz=FS)


@pytest.mark.slow
def test_a_cutoff_that_one_noisy_foot_sets_is_said_where_it_is_taken():
    noisy = SIGNALS["b"] + 8.0 * np.random.default_rng(5).standard_normal(400)
    session = ResidualSession(pd.DataFrame({"FR": SIGNALS["a"], "FL": noisy}), fs_hz=FS)
    assert "But by itself FR " in session.text()
    session.set_cutoff(9.0)
    assert "But by itself" not in session.text()


class Mouse:
    """What matplotlib tells of the pointer."""

    def __init__(self, ax, x):
        self.inaxes, self.xdata = ax, x


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:Passing unrecognized arguments:DeprecationWarning")  # ipympl
def test_slider_line_and_curves_go_together():
    from pawnb.widgets.residual_explorer import ResidualExplorer

    explorer = ResidualExplorer(SIGNALS, fs_hz=FS, unit="mm")
    explorer._slider.value = 6.0
    assert explorer.cutoff_hz == 6.0
    assert explorer._line.get_xdata()[0] == 6.0
    expected = smooth_motion(SIGNALS["a"].to_numpy(), fs_hz=FS, cutoff_hz=6.0).acceleration
    np.testing.assert_allclose(explorer._smooth["acceleration"].get_ydata(), expected)
    explorer._on_press(Mouse(explorer._curve, 9.0))
    explorer._on_move(Mouse(explorer._curve, 12.0))
    explorer._on_release(Mouse(explorer._curve, 12.0))
    explorer._on_move(Mouse(explorer._curve, 20.0))  # no longer held
    assert explorer.cutoff_hz == pytest.approx(12.0, abs=0.1)
    assert explorer._slider.value == pytest.approx(12.0, abs=0.1)
    # what the filter leaves is never cut off, however little it filters
    explorer._slider.value = explorer.session.highest_hz
    low, high = explorer._figure.axes[3].get_ylim()
    acceleration = explorer._smooth["acceleration"].get_ydata()
    assert low < acceleration.min() < acceleration.max() < high
    # a button takes what a method chose
    taker = explorer._takers.children[1]
    assert taker.description.startswith("residual analysis: ")
    taker.click()
    assert explorer.cutoff_hz == pytest.approx(explorer.session.chosen()["residual"][0], abs=0.05)
    assert explorer._line.get_xdata()[0] == explorer.cutoff_hz
    assert taker.description.endswith(f"{explorer.cutoff_hz:.2f} Hz")
    # a browser brings a slider to its steps, which nobody asked for
    taken, step = explorer.cutoff_hz, explorer.fs_step
    explorer._slider.value = round(taken / step) * step
    assert explorer.cutoff_hz == explorer.session.cutoff_hz == taken
    explorer._slider.value += 2 * step
    assert explorer.cutoff_hz == explorer._slider.value
    assert explorer._number.value == pytest.approx(explorer.cutoff_hz, abs=0.001)
    explorer._number.value = 12.3456
    assert explorer.cutoff_hz == explorer._line.get_xdata()[0] == 12.3456
    labels = [ax.get_ylabel() for ax in explorer._figure.axes[1:]]
    assert labels == ["position (mm)", "velocity (mm/s)", "acceleration (mm/s²)"]
    explorer._choice.value = "b"
    assert explorer.session.name == "b"
    assert "b: cut-off" in explorer._told.value


@pytest.mark.slow
@pytest.mark.parametrize(
    ("given", "names"),
    [
        (SIGNALS["a"], ("a",)),
        (SIGNALS["a"].rename(None), ("signal 1",)),
        (SIGNALS["a"].to_numpy(), ("signal 1",)),
        (SIGNALS["a"].tolist(), ("signal 1",)),
        (SIGNALS.to_numpy(), ("signal 1", "signal 2")),
        (SIGNALS.set_axis([0, 1], axis=1), ("0", "1")),
    ],
)
def test_signals_may_be_arrays_series_and_lists(given, names):
    session = ResidualSession(given, fs_hz=FS)
    assert session.names == names
    expected = ResidualSession(SIGNALS[["a", "b"][: len(names)]], fs_hz=FS)
    assert session.cutoff_hz == pytest.approx(expected.cutoff_hz)
    np.testing.assert_array_equal(session.signal, SIGNALS["a"])


def test_signals_that_are_none_are_refused_in_a_sentence():
    with pytest.raises(InputError, match=r"^these signals are no table of numbers; give an array"):
        ResidualSession(["a", "b"], fs_hz=FS)
    with pytest.raises(InputError, match=r"^signals have 3 dimensions; expected time and signal"):
        ResidualSession(np.zeros((4, 2, 2)), fs_hz=FS)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:Passing unrecognized arguments:DeprecationWarning")
def test_the_cutoff_is_a_trait_that_is_checked_observed_and_followed():
    explorer = ResidualExplorer(SIGNALS["a"].tolist(), fs_hz=FS)
    heard = []
    explorer.observe(lambda change: heard.append(change["new"]), "cutoff_hz")
    explorer.cutoff_hz = 7.25
    assert explorer.session.cutoff_hz == explorer._slider.value == 7.25
    assert explorer._line.get_xdata()[0] == 7.25
    explorer._slider.value = 9.5
    assert explorer.cutoff_hz == explorer.session.cutoff_hz == 9.5
    assert heard == [7.25, 9.5]
    for wrong in (0.0, -3.0, 99.0, float("nan")):
        with pytest.raises(InputError, match=r"^cutoff_hz is .*; expected above 0, at most "):
            explorer.cutoff_hz = wrong
    assert explorer.cutoff_hz == 9.5
    assert "cutoff_hz" in explorer.get_state()  # so that jslink finds it
    explorer.close()


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:Passing unrecognized arguments:DeprecationWarning")
def test_a_foot_without_a_curve_is_drawn_without_one():
    explorer = ResidualExplorer(
        pd.DataFrame({"FR": SIGNALS["a"], "HL": np.nan, "HR": 3.0}), fs_hz=FS
    )
    for name in ("HL", "HR", "FR"):
        explorer._choice.value = name
        assert explorer._told.value.startswith(f"{name}: cut-off ")
    explorer.close()
