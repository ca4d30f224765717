"""Choice of a cut-off: against Duarte's optcutfreq on Pezzack's signal, and known truth."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from pawnb.errors import InputError
from pawnb.gait.residuals import (
    CURVE_COLUMNS,
    CUTOFF_COLUMNS,
    ESTIMATE_WARNING,
    analyse_residuals,
    compare_cutoffs,
)
from pawnb.signals import butterworth_lowpass

FS = 250.0


def two_waves(*, n=600, sd=1.0, seed=0):
    t = np.arange(n) / FS
    true = 40 * np.sin(2 * np.pi * 3 * t) + 8 * np.sin(2 * np.pi * 7 * t + 1)
    return true, true + sd * np.random.default_rng(seed).standard_normal(n)


@pytest.fixture
def pezzack(real_data):
    table = pd.read_csv(real_data("signal-pezzack") / "pezzack.csv")
    return table, 1 / 0.0201


@pytest.mark.parametrize(
    ("column", "automatic", "in_band"),
    # optcutfreq 0.0.10 on its own choice, and with the band 10 to 20 Hz, of which it uses
    # the cut-offs up to 19.6 Hz (reference_filter_numbers.txt)
    [("angle_raw_rad", 5.591988, 5.486856), ("angle_noisy_rad", 3.928869, 3.752128)],
)
def test_cutoffs_of_the_pezzack_signal(pezzack, column, automatic, in_band):
    table, fs = pezzack
    x = table[column].to_numpy(copy=True)
    found = analyse_residuals(x, fs_hz=fs)
    assert round(found.cutoff_hz, 2) == round(automatic, 2)  # 5.59 and 3.93 Hz
    given = analyse_residuals(x, fs_hz=fs, band_hz=(10.0, 19.7))
    # the ends of the signal are continued further than there
    assert given.cutoff_hz == pytest.approx(in_band, rel=1e-3)
    # a perturbed twin: one sample moved by a tenth of the range is seen
    x[70] += 0.1 * np.ptp(x)
    assert round(analyse_residuals(x, fs_hz=fs).cutoff_hz, 2) != round(automatic, 2)
    assert analyse_residuals(x, fs_hz=fs, band_hz=(10.0, 19.7)).cutoff_hz != pytest.approx(
        in_band, rel=1e-3
    )


def test_known_limits_of_the_pezzack_signal(pezzack):
    # the cut-off with the smallest error of acceleration is 5.45 Hz for the noisy signal
    # (reference_filter_numbers.txt): residual analysis is too low, cross-validation nearer
    table, fs = pezzack
    found = compare_cutoffs(table["angle_noisy_rad"].to_numpy(), fs_hz=fs)
    cutoff = found.set_index("method")["cutoff_hz"]
    assert cutoff["residual"] < 4.0
    assert cutoff["gcv"] == pytest.approx(5.45, rel=0.15)


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


def test_no_choice_is_said_in_words():
    rng = np.random.default_rng(5)
    still = compare_cutoffs(np.linspace(0, 1, 80), fs_hz=FS).set_index("method")
    assert np.isnan(still.loc["residual", "cutoff_hz"])
    assert still.loc["residual", "reason"] == "no cut-off: the signal is a straight line"
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
        (lambda x: compare_cutoffs(x.reshape(4, 5, 30), fs_hz=FS), r"^signals have 3 dimensions"),
    ],
)  # fmt: skip
def test_bad_arguments_are_refused(call, message):
    with pytest.raises(InputError, match=message):
        call(two_waves()[1])
