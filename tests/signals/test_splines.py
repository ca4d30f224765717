"""Smoothing splines: against a dense solution, the filter's response, and the best cut-off."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import make_smoothing_spline

from pawnb.errors import InputError
from pawnb.signals import (
    butterworth_lowpass,
    smooth_motion,
    smooth_spline,
    spline_cutoff,
    splines,
)
from pawnb.signals.butterworth import end_bends

FS = 250.0


def noisy_angle(*, n=600, sd=1.0, seed=0):
    t = np.arange(n) / FS
    true = 40 * np.sin(2 * np.pi * 3 * t) + 8 * np.sin(2 * np.pi * 7 * t + 1)
    acceleration = -40 * (2 * np.pi * 3) ** 2 * np.sin(2 * np.pi * 3 * t)
    acceleration -= 8 * (2 * np.pi * 7) ** 2 * np.sin(2 * np.pi * 7 * t + 1)
    return true, true + sd * np.random.default_rng(seed).standard_normal(n), acceleration


def test_spline_is_the_textbook_solution():
    # Green & Silverman (1994), Eq. 2.4: (I + lambda Q R^-1 Q') f = y, Q second differences,
    # R tridiagonal with 2/3 and 1/6, for samples one apart
    rng = np.random.default_rng(1)
    cutoff = 30.0
    n = 40
    run = rng.standard_normal(n)
    # a cubic with the curvature of the run's ends is smoothed by nothing
    first, last = end_bends(run, cutoff_hz=cutoff, fs_hz=FS)
    # np.polyfit over three quarters of a period of 30 Hz, 7 samples, says the same
    assert first == pytest.approx(np.polyfit(np.arange(7), run[:7], 2)[0])
    assert last == pytest.approx(np.polyfit(np.arange(7), run[:-8:-1], 2)[0])
    t = np.arange(n)
    cubic = first * t**2 + (last - first) * t**3 / (3 * (n - 1))
    y = run - cubic
    q = np.zeros((n, n - 2))
    for j in range(n - 2):
        q[j : j + 3, j] = 1.0, -2.0, 1.0
    r = 2 / 3 * np.eye(n - 2) + 1 / 6 * (np.eye(n - 2, k=1) + np.eye(n - 2, k=-1))
    weight = (np.sqrt(2) - 1) / (2 * np.pi * cutoff / FS) ** 4
    expected = np.linalg.solve(np.eye(n) + weight * q @ np.linalg.solve(r, q.T), y) + cubic
    found = smooth_spline(run, fs_hz=FS, cutoff_hz=cutoff)
    np.testing.assert_allclose(found, expected, atol=1e-9)
    assert not np.allclose(
        smooth_spline(run, fs_hz=FS, cutoff_hz=1.05 * cutoff), expected, atol=1e-3
    )


@pytest.mark.parametrize("cutoff", [3.0, 12.0])
def test_spline_and_filter_of_one_cutoff_answer_alike(cutoff):
    t = np.arange(0, 40 / cutoff, 1 / FS)
    middle = slice(len(t) // 3, 2 * len(t) // 3)
    for factor in (0.6, 1.0, 1.5):
        wave = np.cos(2 * np.pi * factor * cutoff * t)
        spline = smooth_spline(wave, fs_hz=FS, cutoff_hz=cutoff)[middle]
        passed = butterworth_lowpass(wave, cutoff_hz=cutoff, fs_hz=FS)[middle]
        np.testing.assert_allclose(spline, passed, atol=0.02)
        # both follow 1 / (1 + (sqrt 2 - 1) (f / fc)^4)
        expected = 1 / (1 + (np.sqrt(2) - 1) * factor**4)
        assert np.sqrt(2 * np.mean(spline**2)) == pytest.approx(expected, rel=0.03)


def test_derivatives_are_those_of_the_movement():
    true, noisy, acceleration = noisy_angle(sd=0.2)
    inner = slice(60, -60)
    found = smooth_spline(noisy, fs_hz=FS, cutoff_hz=25.0, derivative=2)
    error = np.sqrt(np.mean((found - acceleration)[inner] ** 2))
    assert error < 0.2 * np.std(acceleration)
    raw = np.gradient(np.gradient(noisy, 1 / FS), 1 / FS)
    assert np.sqrt(np.mean((raw - acceleration)[inner] ** 2)) > 0.5 * np.std(acceleration)
    speed = smooth_spline(true, fs_hz=FS, cutoff_hz=100.0, derivative=1)
    np.testing.assert_allclose(speed[inner], np.gradient(true, 1 / FS)[inner], atol=4.0)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_cross_validation_finds_nearly_the_least_error(seed):
    true, noisy, _ = noisy_angle(sd=2.0, seed=seed)
    cutoffs = np.geomspace(2, 100, 120)
    errors = [np.mean((smooth_spline(noisy, fs_hz=FS, cutoff_hz=c) - true) ** 2) for c in cutoffs]
    chosen = spline_cutoff(noisy, fs_hz=FS)
    error = np.mean((smooth_spline(noisy, fs_hz=FS, cutoff_hz=chosen) - true) ** 2)
    assert error < 1.3 * min(errors)
    automatic = smooth_spline(noisy, fs_hz=FS)
    np.testing.assert_array_equal(automatic, smooth_spline(noisy, fs_hz=FS, cutoff_hz=chosen))
    # twice or half as much would be clearly worse
    for factor in (0.4, 3.0):
        other = smooth_spline(noisy, fs_hz=FS, cutoff_hz=factor * chosen)
        assert np.mean((other - true) ** 2) > 1.3 * min(errors)


@pytest.mark.slow
def test_choice_does_not_depend_on_units_or_on_time_zero():
    _, noisy, _ = noisy_angle(n=300)
    chosen = spline_cutoff(noisy, fs_hz=FS)
    assert spline_cutoff(1e4 * noisy + 77, fs_hz=FS) == pytest.approx(chosen, rel=2e-3)
    assert spline_cutoff(noisy, fs_hz=2 * FS) == pytest.approx(2 * chosen, rel=2e-3)


def test_spline_never_crosses_a_gap_and_leaves_short_runs_out():
    rng = np.random.default_rng(3)
    x = rng.standard_normal(100)
    x[50:54] = x[58:60] = np.nan
    out = smooth_spline(x, fs_hz=FS, cutoff_hz=20.0)
    alone = smooth_spline(x[:50], fs_hz=FS, cutoff_hz=20.0)
    np.testing.assert_array_equal(out[:50], alone)
    assert np.isnan(out[50:60]).all()  # a run of four samples lies between the gaps
    assert np.isfinite(out[60:]).all()
    filled = smooth_spline(x, fs_hz=FS, cutoff_hz=20.0, max_gap=4)
    assert np.isfinite(filled).all()


@pytest.mark.slow
def test_motion_by_both_ways_agrees():
    true, noisy, acceleration = noisy_angle(sd=0.05)
    inner = slice(60, -60)
    for method in ("butterworth", "spline"):
        motion = smooth_motion(noisy, fs_hz=FS, cutoff_hz=25.0, method=method)
        np.testing.assert_allclose(motion.position[inner], true[inner], atol=0.6)
        error = motion.acceleration - acceleration
        assert np.std(error[inner]) < 0.1 * np.std(acceleration)
    chosen = smooth_motion(noisy, fs_hz=FS, cutoff_hz=None, method="spline")
    assert np.isfinite(chosen.velocity).all()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: smooth_spline(np.zeros(9), fs_hz=FS, cutoff_hz=125.0), r"^cutoff_hz is 125; exp"),
        (lambda: smooth_spline(np.zeros(9), fs_hz=0.0), r"^fs_hz is 0\.0; expected a sampling"),
        (lambda: smooth_spline(np.zeros(9), fs_hz=FS, derivative=3), r"^derivative is 3; expected"),
        (lambda: smooth_spline(np.ones(4), fs_hz=FS), r"no 5 samples in a row; expected at least"),
        (lambda: smooth_motion(np.zeros(9), fs_hz=FS, cutoff_hz=None), r"^cutoff_hz is missing;"),
        (
            lambda: smooth_motion(np.zeros(9), fs_hz=FS, cutoff_hz=9.0, method="kalman"),
            r"^method is 'kalman'; expected 'butterworth' or 'spline'\.$",
        ),
    ],
)  # fmt: skip
def test_bad_arguments_are_refused(call, message):
    with pytest.raises(InputError, match=message):
        call()


@pytest.mark.parametrize("n", [5, 6, 30, 400])
@pytest.mark.parametrize("share", [0.005, 0.05, 0.45])
def test_the_spline_of_the_search_is_that_of_scipy(n, share):
    x = np.random.default_rng(n).normal(size=(n, 2)).cumsum(axis=0)
    at = np.arange(n, dtype=float)
    expected = make_smoothing_spline(at, x, lam=splines._weight(share))(at)
    np.testing.assert_allclose(splines._fit(x, share), expected, rtol=0, atol=1e-8)
    np.testing.assert_allclose(splines._fit(x[:, 0], share), expected[:, 0], rtol=0, atol=1e-8)
