"""Choice of a cut-off: against Duarte's optcutfreq on Pezzack's signal, and known truth."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from scipy.optimize import brentq
from scipy.signal import butter, filtfilt

from pawnb.errors import InputError
from pawnb.gait.residuals import (
    CURVE_COLUMNS,
    CUTOFF_COLUMNS,
    ESTIMATE_WARNING,
    analyse_residuals,
    compare_cutoffs,
)
from pawnb.io.formats import read_any_tracks
from pawnb.signals import butterworth_lowpass

LOCOMOUSE = "G6AE1_98_28_1_control_S1T1_R.mat"
FS = 250.0


def two_waves(*, n=600, sd=1.0, seed=0):
    t = np.arange(n) / FS
    true = 40 * np.sin(2 * np.pi * 3 * t) + 8 * np.sin(2 * np.pi * 7 * t + 1)
    return true, true + sd * np.random.default_rng(seed).standard_normal(n)


@pytest.fixture
def pezzack(real_data):
    table = pd.read_csv(real_data("signal-pezzack") / "pezzack.csv")
    return table, 1 / 0.0201


def filter_of_optcutfreq(runs, cutoff_hz, *, fs_hz, order):
    """RMS of raw minus filtered as optcutfreq 0.0.9 computes it: 0.802, nine samples of padding."""
    (run,) = runs
    sections = butter(order // 2, cutoff_hz / 0.802 / (fs_hz / 2))
    return float(np.sqrt(np.mean((filtfilt(*sections, run[:, 0]) - run[:, 0]) ** 2)))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("column", "published", "best_acceleration"),
    # optcutfreq 0.0.10 on its own choice, and the cut-off with the smallest error of
    # acceleration (reference_filter_numbers.txt)
    [("angle_raw_rad", 5.591988, 7.40), ("angle_noisy_rad", 3.928869, 5.45)],
)
def test_cutoffs_of_the_pezzack_signal(pezzack, monkeypatch, column, published, best_acceleration):
    table, fs = pezzack
    x = table[column].to_numpy(copy=True)
    found = analyse_residuals(x, fs_hz=fs)
    # with an exact cut-off it is nearer to the best than the published rule is, and still below
    assert published < found.cutoff_hz < best_acceleration
    assert abs(found.cutoff_hz - best_acceleration) < 0.9 * abs(published - best_acceleration)
    # the rule itself is the published one: with that filter its number comes out
    monkeypatch.setattr("pawnb.gait.residuals.residual_analysis.residual_rms", filter_of_optcutfreq)
    assert analyse_residuals(x, fs_hz=fs).cutoff_hz == pytest.approx(published, rel=1e-3)
    # a perturbed twin: one sample moved by a tenth of the range is seen
    x[70] += 0.1 * np.ptp(x)
    assert analyse_residuals(x, fs_hz=fs).cutoff_hz != pytest.approx(published, rel=1e-3)


def test_cross_validation_of_the_pezzack_signal(pezzack):
    table, fs = pezzack
    found = compare_cutoffs(table["angle_noisy_rad"].to_numpy(), fs_hz=fs)
    cutoff = found.set_index("method")["cutoff_hz"]
    assert cutoff["gcv"] == pytest.approx(5.45, rel=0.2)  # best for accelerations, as above


HARMONICS = np.array([1.0, 0.35, 0.15, 0.06, 0.03])


def stride(frames, periods, *, sd, seed, unit=1.0):
    """Five harmonics of 1 Hz, ``frames`` a period, with white noise; phases by chance."""
    rng = np.random.default_rng(seed)
    t = np.arange(int(periods * frames)) / frames
    waves = np.cos(np.outer(t, 2 * np.pi * np.arange(1, 6)) + rng.uniform(0, 2 * np.pi, 5))
    return unit * (waves @ HARMONICS + sd * rng.standard_normal(len(t)))


def endless_cutoff(frames, sd):
    """Where the residual of an endless recording of ``stride`` equals its noise, from the
    filter's response 1 / (1 + (w / wc)^4), w = tan(pi f / fs), wc = tan(pi fc / fs) / 0.8022."""
    f = (np.arange(20000) + 0.5) / 40000 * frames
    wave = np.arange(1, 6)

    def squares(cutoff):
        wc = np.tan(np.pi * cutoff / frames) / (np.sqrt(2) - 1) ** 0.25
        gone, lost = (1 - 1 / (1 + (np.tan(np.pi * x / frames) / wc) ** 4) for x in (f, wave))
        return sd**2 * np.mean(gone**2) + np.sum(HARMONICS**2 / 2 * lost**2) - sd**2

    return brentq(squares, 1.0, 0.4 * frames)


@pytest.mark.slow
@pytest.mark.parametrize(("frames", "sd"), [(60, 0.02), (250, 0.02), (250, 0.002), (500, 0.002)])
def test_noise_of_known_size_is_read_off_the_curve(monkeypatch, frames, sd):
    # who is right where hundreds of frames make a period: the truth decides
    true, fs = endless_cutoff(frames, sd), float(frames)
    # in degrees, of which a step is 40
    signals = [stride(frames, 3.3, sd=sd, seed=seed, unit=40.0) for seed in range(3)]
    found = [analyse_residuals(x, fs_hz=fs) for x in signals]
    assert np.mean([one.cutoff_hz for one in found]) == pytest.approx(true, rel=0.1)
    assert np.mean([one.noise_rms for one in found]) == pytest.approx(40.0 * sd, rel=0.1)
    monkeypatch.setattr("pawnb.gait.residuals.residual_analysis.residual_rms", filter_of_optcutfreq)
    published = [analyse_residuals(x, fs_hz=fs).cutoff_hz for x in signals]
    assert np.mean(published) < (0.97 if frames == 60 else 0.9) * true


@pytest.mark.parametrize("harmonics", [(1.0,), (1.0, 0.3)])
def test_few_frames_a_stride_leave_no_noise_to_see(harmonics):
    # ten frames a stride: the whole curve is signal; a noise of 0.25 was reported for 0.002
    t = np.arange(300) / 100.0
    waves = [size * np.sin(2 * np.pi * 10 * (k + 1) * t) for k, size in enumerate(harmonics)]
    x = sum(waves) + 0.002 * np.random.default_rng(1).standard_normal(300)
    found = analyse_residuals(x, fs_hz=100.0)
    assert np.isnan(found.cutoff_hz)
    assert np.isnan(found.noise_rms)
    assert found.reason.startswith("no cut-off: the line's noise of ")
    assert "times the" in found.reason
    table = compare_cutoffs(x, fs_hz=100.0).set_index("method")
    assert table.loc["residual", "reason"] == found.reason
    assert np.isnan(table.loc["residual", "cutoff_hz"])
    # cross-validation does see it, and is what the reason names
    assert table.loc["gcv", "noise_rms"] == pytest.approx(0.002, rel=0.8)
    assert f"cross-validation, {table.loc['gcv', 'cutoff_hz']:.3g} Hz" in found.reason
    # what a person asked for is done, and said
    given = analyse_residuals(x, fs_hz=100.0, band_hz=(20.0, 35.0))
    assert np.isfinite(given.cutoff_hz)
    assert "; but the line's noise of" in given.reason


@pytest.mark.slow
def test_a_real_walk_of_few_frames_a_stride_has_no_cutoff_this_way(real_data):
    # a mouse of 2.4 strides a second; leaving out frames does not change the noise of a track, so
    # that at 400 Hz is the truth: 12 frames a stride gave 5.5 px, and a cut-off of 4.1 Hz
    tracks = read_any_tracks(real_data("mouse-locomouse") / LOCOMOUSE, fps=400.0)
    seen = tracks["image_position"].sel(view="bottom", image_space="u", keypoint=["FR", "FL"])
    x = seen.isel(individual=0).to_numpy()
    whole = analyse_residuals(x, fs_hz=400.0)
    assert whole.noise_rms < 0.6  # whole px, in the file; by hand: 0.29 of rounding alone
    for step, start in ((13, 0), (14, 7), (16, 0), (16, 8)):
        found = analyse_residuals(x[start::step], fs_hz=400.0 / step)
        assert np.isnan(found.cutoff_hz)
        assert found.reason.startswith("no cut-off: ")
    for step in (2, 3, 4):  # enough frames: it is still read
        found = analyse_residuals(x[::step], fs_hz=400.0 / step)
        assert found.cutoff_hz > 5 * 2.4


def test_whiteness_does_not_take_a_stride_for_noise():
    # the residual of a lone high harmonic can look white enough, yet it is far above the noise
    t = np.arange(300) / 100.0
    x = sum(
        size * np.sin(2 * np.pi * 12 * (k + 1) * t + k) for k, size in enumerate((1.0, 0.3, 0.1))
    )
    x = x + 0.002 * np.random.default_rng(1).standard_normal(300)
    row = compare_cutoffs(x, fs_hz=100.0).set_index("method").loc["autocorrelation"]
    assert np.isnan(row["cutoff_hz"]) or row["residual_rms"] < 0.03


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("sd", [0.3, 2.0])
def test_choices_against_the_truth(sd, seed):
    true, noisy = two_waves(sd=sd, seed=seed)
    cutoffs = np.geomspace(2, 90, 50)

    def error(cutoff):
        return np.mean((butterworth_lowpass(noisy, cutoff_hz=cutoff, fs_hz=FS) - true) ** 2)

    errors = [error(c) for c in cutoffs]
    least = min(errors)
    found = compare_cutoffs(noisy, fs_hz=FS).set_index("method")
    for method in ("gcv", "autocorrelation"):
        assert error(found.loc[method, "cutoff_hz"]) < 1.25 * least
    assert found.loc["gcv", "noise_rms"] == pytest.approx(sd, rel=0.1)
    # residual analysis smooths too much, as Yu et al. (1999) say, though it is of the right size
    best = cutoffs[np.argmin(errors)]
    assert 0.4 * best < found.loc["residual", "cutoff_hz"] < best
    assert error(0.4 * best) > 1.25 * least


def test_choice_does_not_depend_on_the_unit():
    _, degrees = two_waves()
    one = compare_cutoffs(degrees, fs_hz=FS)
    other = compare_cutoffs(np.deg2rad(degrees) + 5.0, fs_hz=FS)
    np.testing.assert_allclose(other["cutoff_hz"], one["cutoff_hz"], rtol=2e-3)
    np.testing.assert_allclose(other["residual_rms"], np.deg2rad(one["residual_rms"]), rtol=5e-3)


def test_curve_line_and_band_belong_together():
    _, noisy = two_waves()
    found = analyse_residuals(noisy, fs_hz=FS)
    curve = found.curve
    assert tuple(curve.columns) == CURVE_COLUMNS
    band = curve[curve["in_band"]]
    assert found.band_hz == (band["cutoff_hz"].iloc[0], band["cutoff_hz"].iloc[-1])
    slope, noise = np.polyfit(band["cutoff_hz"], band["residual"], 1)
    assert found.noise_rms == pytest.approx(noise)
    np.testing.assert_allclose(curve["noise_line"], noise + slope * curve["cutoff_hz"])
    at = np.interp(found.cutoff_hz, curve["cutoff_hz"], curve["residual"])
    assert at == pytest.approx(noise, rel=0.02)
    # one point of the curve computed by hand
    row = curve.iloc[10]
    left = noisy - butterworth_lowpass(noisy, cutoff_hz=row["cutoff_hz"], fs_hz=FS)
    assert row["residual"] == pytest.approx(np.sqrt(np.mean(left**2)))
    assert f"{found.cutoff_hz:.3g} Hz" in found.reason
    assert "after three lifetimes" in found.reason
    assert found.warning == ESTIMATE_WARNING


@pytest.mark.slow
def test_gaps_part_the_signal():
    _, noisy = two_waves()
    gappy = noisy.copy()
    gappy[300:310] = np.nan
    pieces = np.full((600, 2), np.nan)
    pieces[:300, 0], pieces[:290, 1] = noisy[:300], noisy[310:]
    one, two = (compare_cutoffs(x, fs_hz=FS) for x in (gappy, pieces))
    pooled = two[two["signal"] == "pooled"]
    np.testing.assert_allclose(one["cutoff_hz"], pooled["cutoff_hz"], rtol=1e-9)
    assert one["n_samples"].tolist() == [590] * 3


def test_pooled_lies_between_the_signals():
    _, quiet = two_waves(sd=0.3)
    _, loud = two_waves(sd=3.0, seed=1)
    table = compare_cutoffs(pd.DataFrame({"quiet": quiet, "loud": loud}), fs_hz=FS)
    assert tuple(table.columns) == CUTOFF_COLUMNS
    assert table["signal"].tolist() == ["quiet"] * 3 + ["loud"] * 3 + ["pooled"] * 3
    cutoff = table.set_index(["method", "signal"])["cutoff_hz"].unstack()  # noqa: PD010
    assert (cutoff["loud"] < cutoff["pooled"]).all()
    assert (cutoff["pooled"] < cutoff["quiet"]).all()


@pytest.mark.slow
def test_a_pooled_cutoff_that_one_noisy_foot_sets_says_so():
    # the movement is the same, so the cut-off of two alike feet is that of each
    _, quiet = two_waves(sd=0.05)
    _, like = two_waves(sd=0.05, seed=1)
    _, loud = two_waves(sd=15.0, seed=2)
    alike = compare_cutoffs(pd.DataFrame({"FR": quiet, "HR": like}), fs_hz=FS)
    assert not alike["reason"].str.contains("but by itself").any()
    table = compare_cutoffs(pd.DataFrame({"FR": quiet, "HR": like, "FL": loud}), fs_hz=FS)
    table = table.set_index(["signal", "method"])
    pooled, own = table.loc[("pooled", "residual")], table.loc[("FR", "residual")]
    assert pooled["cutoff_hz"] < 0.5 * own["cutoff_hz"]
    assert f"; but by itself FR {own['cutoff_hz']:.3g} Hz, HR " in pooled["reason"]
    assert "one cut-off does not suit all" in pooled["reason"]
    assert "but" not in own["reason"]


def test_no_choice_is_said_in_words():
    rng = np.random.default_rng(5)
    still = compare_cutoffs(np.linspace(0, 1, 80), fs_hz=FS).set_index("method")
    assert np.isnan(still.loc["residual", "cutoff_hz"])
    assert still.loc["residual", "reason"] == "no cut-off: the signal is a straight line"
    for held in (np.full(80, 3.0), np.zeros(80), np.linspace(0, 1, 80)):  # a foot in whole px
        rows = compare_cutoffs(held, fs_hz=FS)
        assert set(rows["reason"]) == {"no cut-off: the signal is a straight line"}
        assert rows[["cutoff_hz", "residual_rms", "noise_rms"]].isna().all(axis=None)
    noise = compare_cutoffs(rng.standard_normal(300), fs_hz=FS).set_index("method")
    assert np.isnan(noise.loc["residual", "cutoff_hz"])
    assert noise.loc["residual", "reason"].startswith("no cut-off: ")
    short = compare_cutoffs(np.append(rng.standard_normal(19), np.nan), fs_hz=FS)
    assert short["cutoff_hz"].isna().all()
    assert set(short["reason"]) == {"no cut-off: no run of 20 samples without a gap"}
    assert set(short["n_samples"]) == {0}


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda x: analyse_residuals(x[:19], fs_hz=FS), r"no run of 20 samples without a gap; exp"),
        (lambda x: analyse_residuals(x, fs_hz=FS, band_hz=(50, 40)), r"^band_hz is 50 to 40; exp"),
        (lambda x: analyse_residuals(x, fs_hz=FS, band_hz=(50, 51)), r"^band_hz is 50 to 51; exp"),
        (lambda x: analyse_residuals(x, fs_hz=FS, order=3), r"^order is 3; expected an even"),
        (lambda x: compare_cutoffs(x, fs_hz=-1.0), r"^fs_hz is -1\.0; expected a sampling rate"),
        (lambda x: compare_cutoffs(pd.DataFrame(), fs_hz=FS), r"^signals: expected at least one"),
        (lambda x: compare_cutoffs(["a", "b"], fs_hz=FS), r"^these signals are no table of numb"),
        (lambda x: analyse_residuals(x, fs_hz=FS, band_hz=20.0), r"^band_hz is 20\.0; expected"),
        (lambda x: analyse_residuals(x * np.nan, fs_hz=FS), r"no value in any frame .*image_pos"),
        (lambda x: compare_cutoffs(x.reshape(4, 5, 30), fs_hz=FS), r"^signals have 3 dimensions"),
    ],
)  # fmt: skip
def test_bad_arguments_are_refused(call, message):
    with pytest.raises(InputError, match=message):
        call(two_waves()[1])
