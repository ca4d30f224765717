"""Butterworth filters of any order, and angles without jumps."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import butter, filtfilt

from pawnb.errors import InputError
from pawnb.signals import butterworth_lowpass, two_pass_correction, unwrap_angles

FS = 250.0


@pytest.mark.parametrize(
    ("order", "ratio"),
    # (sqrt 2 - 1)^(1/4) = 0.8022432629 for two passes of second order (worked examples);
    # one pass of first order: 0.6436 (Robertson & Dowling 2003)
    [(2, 0.6435942529), (4, 0.8022432629), (8, 0.8956803352)],
)
def test_correction_of_the_cutoff(order, ratio):
    assert two_pass_correction(order) == pytest.approx(ratio, abs=1e-10)
    assert two_pass_correction(order + 2) != pytest.approx(ratio, abs=1e-3)


def test_coefficients_are_the_published_ones():
    # fs 50, cut-off 6 Hz, two passes of second order (worked examples)
    b = [0.1305200801, 0.2610401602, 0.1305200801]
    a = [1.0, -0.7510232653, 0.2731035856]
    x = np.random.default_rng(0).standard_normal(80)
    expected = filtfilt(b, a, x, padtype="odd", padlen=25)  # three periods of 6 Hz
    found = butterworth_lowpass(x, cutoff_hz=6.0, fs_hz=50.0)
    np.testing.assert_allclose(found, expected, atol=1e-7)
    other = butter(2, 6.0 / 25.0)
    uncorrected = filtfilt(*other, x, padtype="odd", padlen=25)
    assert np.abs(found - uncorrected).max() > 0.02


@pytest.mark.parametrize("order", [2, 4, 6, 10])
def test_half_power_at_the_cutoff_and_steeper_with_order(order):
    cutoff = 10.0
    t = np.arange(0, 6, 1 / FS)
    middle = slice(500, 1000)
    amplitude = {}
    for factor in (1.0, 2.0):
        wave = np.cos(2 * np.pi * factor * cutoff * t)
        out = butterworth_lowpass(wave, cutoff_hz=cutoff, fs_hz=FS, order=order)
        amplitude[factor] = np.sqrt(2 * np.mean(out[middle] ** 2))
    assert amplitude[1.0] == pytest.approx(np.sqrt(0.5), rel=0.02)
    # response 1 / (1 + (sqrt 2 - 1) (f / fc)^order), but for the warping
    assert amplitude[2.0] == pytest.approx(1 / (1 + (np.sqrt(2) - 1) * 2**order), rel=0.15)


@pytest.mark.parametrize("order", [0, 1, 3, -2])
def test_odd_orders_are_refused(order):
    with pytest.raises(InputError, match=r"^order is .*; expected an even number from 2 on"):
        butterworth_lowpass(np.zeros(50), cutoff_hz=5.0, fs_hz=FS, order=order)


@settings(deadline=None)
@given(
    st.lists(st.floats(-170, 170), min_size=2, max_size=60),
    st.floats(-1000, 1000),
    st.sets(st.integers(0, 59)),
)
def test_unwrapping_undoes_wrapping(steps, start, missing):
    true = start + np.concatenate(([0.0], np.cumsum(steps)))
    wrapped = np.mod(true + 180.0, 360.0) - 180.0
    out = unwrap_angles(wrapped)
    np.testing.assert_allclose(out - out[0], true - true[0], atol=1e-6)
    slow = start + np.arange(60) * 2.5  # a gap of up to 58 samples holds less than half a turn
    gappy = np.mod(slow, 360.0)
    gappy[sorted(missing - {0, 59})] = np.nan
    there = np.isfinite(gappy)
    found = unwrap_angles(gappy)
    np.testing.assert_array_equal(np.isfinite(found), there)
    np.testing.assert_allclose(found[there] - found[0], slow[there] - slow[0], atol=1e-6)


def test_turns_are_not_counted_over_long_gaps():
    x = np.array([350.0, 10.0, np.nan, np.nan, 20.0, 350.0])
    np.testing.assert_array_equal(unwrap_angles(x, max_gap=1), [350, 370, np.nan, np.nan, 20, -10])
    np.testing.assert_array_equal(unwrap_angles(x, max_gap=2), unwrap_angles(x))
    np.testing.assert_array_equal(unwrap_angles(x), [350, 370, np.nan, np.nan, 380, 350])
    cycles = unwrap_angles(np.array([0.9, 0.1]), turn=1.0)
    np.testing.assert_allclose(cycles, [0.9, 1.1])
    with pytest.raises(InputError, match=r"^turn is 0; expected|^turn is 0, max_gap None"):
        unwrap_angles(x, turn=0)
