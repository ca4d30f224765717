"""Strides cut from signals whose derivatives are known, averaged by animal."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from scipy.stats import ttest_1samp
from walking import Walk

from pawnb.errors import InputError
from pawnb.gait import analyse, pool
from pawnb.gait.cycles import (
    HEIGHT,
    POSITION,
    LegSignals,
    align_acceleration,
    average_cycles,
    centre_signals,
    cut_cycles,
)

PERIOD_S, AMPLITUDE, FS = 0.5, 30.0, 1000.0
W = 2.0 * np.pi / PERIOD_S


def cosine(animal="a", trial="t", amplitude=AMPLITUDE, gap=None):
    """A leg that swings as a cosine: AEP at 0, 0.5, 1.0 s; PEP half way between."""
    t = np.arange(0.0, 2.0, 1.0 / FS)
    values = amplitude * np.cos(W * t)
    if gap is not None:
        values[(t > gap[0]) & (t < gap[1])] = np.nan
    return LegSignals(animal=animal, trial=trial, legs=("L1",), time_s=t, samples=values[:, None])


def strides(animal="a", trial="t", starts=(0.5, 1.0)):
    return pd.DataFrame(
        [
            {"animal": animal, "trial": trial, "leg": "L1", "stride": k + 1, "start_s": start,
             "period_s": PERIOD_S, "stance_s": PERIOD_S / 2}
            for k, start in enumerate(starts)
        ]
    )  # fmt: skip


def test_a_cosine_is_cut_with_its_exact_derivatives():
    cycles = cut_cycles([cosine()], strides(), n_points=51)
    assert len(cycles) == 2 * 51
    phase = 2.0 * np.pi * cycles["percent"] / 100.0
    np.testing.assert_allclose(cycles["value"], AMPLITUDE * np.cos(phase), atol=2e-3)
    speed = AMPLITUDE * W
    np.testing.assert_allclose(cycles["velocity"], -speed * np.sin(phase), atol=1e-3 * speed)
    np.testing.assert_allclose(
        cycles["acceleration"], -speed * W * np.cos(phase), atol=1e-3 * speed * W
    )
    assert set(cycles["unit"]) == {"deg"}


def test_a_stride_with_a_gap_is_there_with_nan_and_not_in_the_mean():
    cycles = cut_cycles([cosine(gap=(0.6, 0.7))], strides())
    first = cycles[cycles["stride"] == 1]
    inside = first["percent"].between(21, 39)
    assert first.loc[inside, "value"].isna().all()
    assert first.loc[~first["percent"].between(19, 41), "value"].notna().all()
    average = average_cycles(cycles).set_index("percent")
    assert average.loc[30.0, "n_strides"] == 1
    assert average.loc[60.0, "n_strides"] == 2


def test_acceleration_is_aligned_at_the_greatest_speed():
    """Swing from PEP to AEP: a cosine is fastest in the middle, where it stops accelerating."""
    for phase, sign in (("swing", 1.0), ("stance", -1.0)):
        aligned = align_acceleration([cosine()], strides(), phase=phase)
        own = aligned[aligned["stride"] == 1].set_index("percent")
        assert own.index.min() == pytest.approx(-50.0, abs=2.0)
        assert own.index.max() == pytest.approx(50.0, abs=2.0)
        expected = -sign * AMPLITUDE * W**2 * np.sin(np.pi * own.index.to_numpy() / 100.0)
        np.testing.assert_allclose(own["acceleration"], expected, atol=0.01 * AMPLITUDE * W**2)
        np.testing.assert_allclose(own["peak_velocity"], sign * AMPLITUDE * W, rtol=1e-3)


def test_animals_count_once_each():
    """Animal a has two strides of amplitude 30, b one of 20, c one of 22: mean of 30, 20, 22."""
    signals = [cosine("a"), cosine("b", amplitude=20.0), cosine("c", amplitude=22.0)]
    table = pd.concat([strides("a"), strides("b", starts=(0.5,)), strides("c", starts=(0.5,))])
    average = average_cycles(cut_cycles(signals, table)).set_index("percent")
    top = average.loc[0.0]
    assert top["mean"] == pytest.approx(24.0, abs=0.01)
    assert (top["n_animals"], top["n_strides"]) == (3, 4)
    # the interval is scipy's one-sample t interval
    interval = ttest_1samp([30.0, 20.0, 22.0], 0.0).confidence_interval(0.95)
    np.testing.assert_allclose([top["low"], top["high"]], interval, atol=0.02)
    assert top["band"] == "95 % interval of the mean of animals"


def test_one_animal_has_the_sd_of_its_strides_and_a_single_stride_no_band():
    cycles = cut_cycles([cosine()], strides())
    cycles.loc[cycles["stride"] == 2, "value"] += 4.0
    top = average_cycles(cycles).set_index("percent").loc[0.0]
    assert top["band"] == "SD of strides"
    assert top["high"] - top["mean"] == pytest.approx(np.sqrt(8.0))  # SD of two, 4 apart
    single = average_cycles(cut_cycles([cosine()], strides(starts=(0.5,))))
    assert single["low"].isna().all()
    assert single["mean"].notna().all()


def test_centred_signals_keep_what_lies_between_legs():
    t = np.arange(10.0)
    samples = np.column_stack([t, t + 6.0, np.full(10, np.nan)])
    samples[0, 0] = np.nan
    one = LegSignals(animal="a", trial="t", legs=("FR", "HR", "FL"), time_s=t, samples=samples)
    (centred,) = centre_signals([one])
    # means over time: 5 (of 1 to 9) and 10.5; their mean is 7.75
    np.testing.assert_allclose(centred.samples, samples - 7.75)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: cut_cycles([cosine()], strides(), n_points=1), r"^n_points is 1; expected 2"),
        (lambda: align_acceleration([cosine()], strides(), phase="flight"),
         r"^phase is 'flight'; expected 'swing' or 'stance'\.$"),
        (lambda: align_acceleration([cosine()], strides(), step_percent=0),
         r"^step_percent is 0; expected more than 0\.$"),
        (lambda: cut_cycles([cosine()], strides().drop(columns="start_s")),
         r"^strides: column 'start_s' is missing"),
        (lambda: average_cycles(cut_cycles([cosine()], strides()), level=95),
         r"^level is 95; expected between 0 and 1"),
        (lambda: LegSignals(animal="a", trial="t", legs=("L1",), time_s=np.arange(5.0) ** 2,
                            samples=np.zeros((5, 1))), r"the times are not equally spaced"),
        (lambda: LegSignals(animal="a", trial="t", legs=("L1", "R1"), time_s=np.arange(5.0),
                            samples=np.zeros((5, 1))), r"samples of shape \(5, 1\) for 5 times"),
        (lambda: cut_cycles([cosine(), LegSignals(animal="b", trial="t", legs=("L1",),
                             time_s=np.arange(5.0), samples=np.zeros((5, 1)), unit="mm",
                             signal="height")], strides()),
         r"^the signals are of several kinds, height \(mm\) and leg angle \(deg\); choose one\.$"),
    ],
)  # fmt: skip
def test_bad_input_is_refused(call, message):
    with pytest.raises(InputError, match=message):
        call()


def test_no_strides_give_an_empty_table():
    assert len(cut_cycles([cosine("x")], strides())) == 0
    assert len(average_cycles(cut_cycles([cosine("x")], strides()))) == 0


def test_an_analysis_hands_on_its_signals():
    """Seen from the body a foot is furthest forward at AEP, and lifted in swing only."""
    walk = Walk()
    tables = analyse(walk.tracks(duration=2.0), belt_speed=walk.speed)
    chosen = {one.signal: one for one in tables.signals}
    assert {one.unit for one in tables.signals} == {"mm"}
    assert pool([tables]).signals == tables.signals
    place, height = (
        average_cycles(cut_cycles([one], tables.strides)).query("leg == 'FR'")
        for one in (chosen[POSITION], chosen[HEIGHT])
    )
    assert place["percent"].iloc[place["mean"].argmax()] in (0.0, 100.0)
    # PEP: where stance ends, by the exact duty factor from AEP to PEP
    turn = place["percent"].iloc[place["mean"].argmin()]
    assert turn == pytest.approx(100.0 * walk.exact_duty, abs=3.0)
    stance = 100.0 * walk.early / walk.period  # touch-down comes so much later than AEP
    middle = height["percent"].between(stance + 5, stance + 55)
    assert height.loc[middle, "mean"].abs().max() < 0.5
    assert height["mean"].max() == pytest.approx(walk.swing_height, abs=0.5)
