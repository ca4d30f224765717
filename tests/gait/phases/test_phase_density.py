"""Densities on the torus of legs whose lags are known at every instant."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from scipy.stats import vonmises

from pawnb.errors import InputError
from pawnb.gait.cycles import LegSignals
from pawnb.gait.phases.density import Plane, default_planes, even_phase, phase_density
from pawnb.gait.phases.relative_phase import phase_angle

FS = 200.0
LEGS = ("FR", "FL", "HR", "HL")


def trial(lags, *, animal="m1", name="t", seconds=4.0, rhythm_hz=4.0):
    """Legs as cosines that come later by known parts of a cycle, and one stride a cycle."""
    t = np.arange(int(seconds * FS)) / FS
    samples = np.column_stack([np.cos(2 * np.pi * (rhythm_hz * t - lag)) for lag in lags])
    signal = LegSignals(animal=animal, trial=name, legs=LEGS, time_s=t, samples=samples)
    rows = [
        (animal, name, leg, k / rhythm_hz, 1.0 / rhythm_hz)
        for leg in LEGS
        for k in range(int(seconds * rhythm_hz))
    ]
    return signal, pd.DataFrame(rows, columns=["animal", "trial", "leg", "start_s", "period_s"])


def peak(table):
    row = table.loc[table["density"].idxmax()]
    return row["phase_x"], row["phase_y"]


@pytest.mark.parametrize(
    ("gait", "lags", "place"),
    [("trot", (0, 0.5, 0.5, 0), (0.5, 0.5)), ("pace", (0, 0.5, 0, 0.5), (0.5, 0.0)),
     ("bound", (0, 0, 0.5, 0.5), (0.0, 0.5)), ("walk", (0, 0.5, 0.75, 0.25), (0.5, 0.75))],
)  # fmt: skip
def test_gaits_lie_where_they_ought_to(gait, lags, place):
    signal, strides = trial(lags)
    found = phase_density([signal], strides)
    away = (np.array(peak(found)) - place + 0.5) % 1.0 - 0.5
    assert np.abs(away).max() <= 1.0 / 48, gait
    assert found["density"].mean() == pytest.approx(1.0, abs=1e-4)
    named = found[["leg_x", "reference_x", "leg_y", "reference_y"]].drop_duplicates()
    assert named.to_numpy().tolist() == [["FL", "FR", "HR", "FR"]]  # as the lags are


def test_a_single_place_is_as_wide_as_the_bandwidth():
    """A wrapped Gaussian of standard deviation s has a mean vector of exp(-2 pi^2 s^2)."""
    signal, strides = trial((0, 0.5, 0.5, 0))
    found = phase_density([signal], strides, bandwidth_cycles=0.08)
    across = found.groupby("phase_x")["density"].sum()
    r = np.abs((across * np.exp(2j * np.pi * across.index)).sum() / across.sum())
    assert r == pytest.approx(np.exp(-2 * np.pi**2 * 0.08**2), abs=0.01)


def test_a_leg_that_stands_long_and_swings_fast_has_one_lag():
    """Stance 0.75 of the stride: the lag of a steady gait stays where it is made."""
    t = np.arange(800) / FS
    lags = (0, 0.5, 0.7, 0.2)
    phase = [(4.0 * t - lag) % 1.0 for lag in lags]
    samples = [np.where(p < 0.75, 1 - p / 0.375, -np.cos(np.pi * (p - 0.75) / 0.25)) for p in phase]
    _, strides = trial(lags)
    uneven = LegSignals(
        animal="m1", trial="t", legs=LEGS, time_s=t, samples=np.column_stack(samples)
    )
    found = phase_density([uneven], strides)
    np.testing.assert_allclose(peak(found), (0.5, 0.7), atol=1.0 / 48)
    across = found.groupby("phase_x")["density"].sum()
    r = np.abs((across * np.exp(2j * np.pi * across.index)).sum() / across.sum())
    assert r == pytest.approx(np.exp(-2 * np.pi**2 * 0.03**2), abs=0.01)


def test_animals_count_once_each_however_long_they_were_filmed():
    long, of_long = trial((0, 0.5, 0.5, 0), animal="m1", seconds=9.0)
    short, of_short = trial((0, 0.0, 0.5, 0.5), animal="m2", seconds=3.0)
    found = phase_density([long, short], pd.concat([of_long, of_short]))
    trot = found[(found["phase_x"] - 0.5).abs() < 0.25]["density"].sum()
    assert trot / found["density"].sum() == pytest.approx(0.5, abs=0.01)
    assert found["n_animals"].unique().tolist() == [2]


def test_a_lag_that_drifts_is_a_band():
    """The left leg loses a whole cycle in the recording: its lag is anywhere, equally often."""
    signal, strides = trial((0, 0.0, 0.5, 0.5), seconds=8.0)
    drift = np.cos(2 * np.pi * (4.0 * signal.time_s - signal.time_s / 8.0))
    samples = signal.samples.copy()
    samples[:, 1] = drift
    band = LegSignals(animal="m1", trial="t", legs=LEGS, time_s=signal.time_s, samples=samples)
    found = phase_density([band], strides)
    across = found.groupby("phase_x")["density"].mean()
    assert across.min() > 0.7
    assert across.max() < 1.3


def test_only_strides_that_count_are_looked_at():
    signal, strides = trial((0, 0.5, 0.5, 0))
    half = strides[strides["start_s"] < 2.0]
    found = phase_density([signal], half)
    assert found["n_samples"].iloc[0] == pytest.approx(2.0 * FS, abs=4)
    with pytest.raises(InputError, match="at no instant are the legs"):
        phase_density([signal], strides[strides["leg"] != "HR"])


def test_planes_by_names():
    assert default_planes(LEGS) == [Plane(("FL", "FR"), ("HR", "FR"))]
    spider = [f"{side}{k}" for side in "LR" for k in (1, 2, 3, 4)]
    assert [plane.x for plane in default_planes(spider)] == [
        ("L1", "R1"),
        ("L2", "R2"),
        ("L3", "R3"),
    ]
    assert default_planes(["a", "b", "c"]) == []


def test_what_cannot_be_is_one_sentence():
    signal, strides = trial((0, 0.5, 0.5, 0))
    with pytest.raises(InputError, match="no leg 'XX'; there are FR, FL, HR, HL"):
        phase_density([signal], strides, planes=[(("XX", "FR"), ("HR", "FR"))])
    with pytest.raises(InputError, match="bins is 2"):
        phase_density([signal], strides, bins=2)
    with pytest.raises(InputError, match="expected those of one kind"):
        phase_density([], strides)


@pytest.mark.slow
def test_scattered_lags_are_told_as_scattered():
    """Lags of trials drawn from a von Mises distribution keep its mean vector length."""
    lags = vonmises(2.0).rvs(200, random_state=1) / (2 * np.pi)
    parts = [
        trial((0, lag % 1.0, 0.5, 0.5), animal=f"m{i}", seconds=8.0) for i, lag in enumerate(lags)
    ]
    found = phase_density([s for s, _ in parts], pd.concat([t for _, t in parts]))
    across = found.groupby("phase_x")["density"].sum()
    r = np.abs((across * np.exp(2j * np.pi * across.index)).sum() / across.sum())
    expected = np.abs(np.exp(2j * np.pi * lags).mean()) * np.exp(-2 * np.pi**2 * 0.03**2)
    assert r == pytest.approx(expected, abs=0.02)


@pytest.mark.parametrize("lag", [0.05, 0.3, 0.5, 0.7])
def test_a_lag_is_not_rounded_to_samples(lag):
    """50 samples a stride are 0.02 cycle apart; 0.006 are left of how the ends are mirrored."""
    signal, _ = trial((0, lag, 0.5, 0.5), seconds=8.0)
    every = np.ones(len(signal.time_s), bool)
    reference, leg = (even_phase(phase_angle(signal.samples[:, k]), every) for k in (0, 1))
    mean = np.angle(np.exp(2j * np.pi * (reference - leg)).mean()) / (2 * np.pi)
    assert mean % 1.0 == pytest.approx(lag, abs=0.008)
