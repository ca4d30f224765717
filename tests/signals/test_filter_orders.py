"""Butterworth filters of any order, and angles without jumps."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import butter, sosfiltfilt

from pawnb.errors import InputError
from pawnb.signals import (
    butterworth_lowpass,
    one_pass_cutoff,
    smooth_motion,
    two_pass_correction,
    unwrap_angles,
)

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
    # Winter (2009), section 3.4.4.2, Eq. 3.9: w = tan(pi fc / fs) / C, C = 0.802; K1 = sqrt(2) w,
    # K2 = w^2, a0 = K2 / (1 + K1 + K2), a1 = 2 a0, a2 = a0, K3 = 2 a0 / K2, b1 = -2 a0 + K3,
    # b2 = 1 - 2 a0 - K3 + 2 a0; for fs 60 and fc 6 Hz without C he prints 0.06746, 0.13491,
    # 0.06746, 1.14298, -0.41280
    def winter(fc, fs, c):
        w = np.tan(np.pi * fc / fs) / c
        k1, k2 = np.sqrt(2) * w, w**2
        a0 = k2 / (1 + k1 + k2)
        b1 = -2 * a0 + 2 * a0 / k2
        return a0, b1, 1 - 4 * a0 - b1

    np.testing.assert_allclose(winter(6, 60, 1.0), [0.06746, 1.14298, -0.41280], atol=6e-6)
    a0, b1, b2 = winter(6, 60, (np.sqrt(2) - 1) ** 0.25)
    pulse = np.zeros(401)
    pulse[200] = 1.0
    once = np.zeros(401)
    for n in range(2, 401):
        new = a0 * pulse[n] + 2 * a0 * pulse[n - 1] + a0 * pulse[n - 2]
        once[n] = new + b1 * once[n - 1] + b2 * once[n - 2]
    twice = np.zeros(401)
    for n in range(398, -1, -1):
        new = a0 * once[n] + 2 * a0 * once[n + 1] + a0 * once[n + 2]
        twice[n] = new + b1 * twice[n + 1] + b2 * twice[n + 2]
    found = butterworth_lowpass(pulse, cutoff_hz=6.0, fs_hz=60.0)
    np.testing.assert_allclose(found, twice, atol=1e-9)
    uncorrected = sosfiltfilt(butter(2, 6 / 0.8022 / 30, output="sos"), pulse)
    assert np.abs(found - uncorrected).max() > 1e-3


@pytest.mark.parametrize("order", [2, 4, 6, 8])
@pytest.mark.parametrize("share", [0.02, 0.1, 0.2, 0.3, 0.4])
def test_half_power_stands_at_the_cutoff_that_was_asked_for(order, share):
    # the definition of a cut-off, measured on what a pulse leaves; the frequency itself divided
    # by the ratio put 20 Hz at 21.5 Hz (order 2: 24.2)
    pulse = np.zeros(4001)
    pulse[2000] = 1.0
    out = butterworth_lowpass(pulse, cutoff_hz=100 * share, fs_hz=100.0, order=order)
    power = np.abs(np.fft.rfft(out)) ** 2
    half = np.interp(-0.5, -power, np.fft.rfftfreq(4001, 0.01))
    assert half == pytest.approx(100 * share, rel=0.002)
    # one pass alone: half its power is further up, as the docstring says
    single = butter(order // 2, one_pass_cutoff(100 * share, fs_hz=100.0, order=order), fs=100.0,
                    output="sos")  # fmt: skip
    once = np.abs(np.fft.rfft(sosfiltfilt(single, pulse))) ** 2
    np.testing.assert_allclose(once[20:100], power[20:100], rtol=1e-6)


@pytest.mark.parametrize("method", ["butterworth", "spline"])
@pytest.mark.parametrize("n", [14, 40, 300])
def test_a_parabola_keeps_its_acceleration_to_the_ends(method, n):
    # 3 t^2 has 6 everywhere; point reflection alone left 1.04 at the ends, the natural ends of a
    # spline 0
    t = np.arange(n) / 100.0
    for cutoff in (6.0, 20.0):
        motion = smooth_motion(
            np.column_stack([3 * t**2, 5 - 3 * t**2]), fs_hz=100.0, cutoff_hz=cutoff, method=method
        )
        np.testing.assert_allclose(motion.acceleration[:, 0], 6.0, atol=0.05)
        np.testing.assert_allclose(motion.acceleration[:, 1], -6.0, atol=0.05)
        np.testing.assert_allclose(motion.velocity[1:-1, 0], 6 * t[1:-1], atol=0.01)


def test_ends_of_a_noisy_movement_are_no_worse_than_under_point_reflection():
    # what the curvature at the ends may cost: five harmonics, noise of a fiftieth, 100 recordings
    rng = np.random.default_rng(0)
    worse = []
    for _ in range(100):
        n = int(rng.uniform(150, 330))
        t = np.arange(n) / FS
        shift, size = rng.uniform(0, 2 * np.pi, 5), np.array([1, 0.35, 0.15, 0.06, 0.03])
        true = (size * np.cos(np.outer(t, 6 * np.pi * np.arange(1, 6)) + shift)).sum(axis=1)
        x = true + 0.02 * rng.standard_normal(n)
        single = butter(2, one_pass_cutoff(21.0, fs_hz=FS), fs=FS, output="sos")
        both = (
            butterworth_lowpass(x, cutoff_hz=21.0, fs_hz=FS),
            sosfiltfilt(single, x, padtype="odd", padlen=36),
        )
        worse.append(
            [
                np.mean(np.diff((out - true)[:6]) ** 2 + np.diff((out - true)[-6:]) ** 2)
                for out in both
            ]
        )
    ours, reflected = np.sqrt(np.mean(worse, axis=0))
    assert ours < 1.1 * reflected


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
    assert amplitude[1.0] == pytest.approx(np.sqrt(0.5), rel=0.002)
    # response 1 / (1 + (sqrt 2 - 1) (f / fc)^order), but for the warping
    assert amplitude[2.0] == pytest.approx(1 / (1 + (np.sqrt(2) - 1) * 2**order), rel=0.2)


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
