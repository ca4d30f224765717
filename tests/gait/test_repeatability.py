"""Agreement: against Bland & Altman (1986) and Shrout & Fleiss (1979), and known disagreement."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from pawnb.errors import InputError
from pawnb.gait.repeatability import (
    REPEATABILITY_COLUMNS,
    bland_altman,
    intraclass_correlation,
    match_strides,
    repeatability_table,
)

# Bland & Altman (1986) Lancet 327:307: peak flow of 17 people, first of two readings
WRIGHT = [494, 395, 516, 434, 476, 557, 413, 442, 650, 433, 417, 656, 267, 478, 178, 423, 427]
MINI = [512, 430, 520, 428, 500, 600, 364, 380, 658, 445, 432, 626, 260, 477, 259, 350, 451]
# Shrout & Fleiss (1979), Table 2: six targets, four judges
JUDGES = [[9, 2, 5, 8], [6, 1, 3, 2], [8, 4, 6, 8], [7, 1, 2, 6], [10, 5, 6, 9], [6, 2, 4, 7]]


def test_agreement_is_that_of_the_lancet():
    # mean difference -2.1, SD 38.8, limits -79.7 and 75.5 (from the rounded SD), interval of
    # the mean difference -22.0 to 17.8
    found = bland_altman(MINI, WRIGHT, factor=2.0)
    assert found.n == 17
    assert (round(found.bias, 1), round(found.sd, 1)) == (-2.1, 38.8)
    assert (round(found.bias_low, 1), round(found.bias_high, 1)) == (-22.0, 17.8)
    assert (found.limit_low, found.limit_high) == pytest.approx((-79.7, 75.5), abs=0.1)
    # its limits' intervals, -114.3 to -45.1 and 40.9 to 110.1, take sqrt(3 / n) for the error
    assert found.limit_error == pytest.approx((114.3 - 45.1) / 2, rel=0.02)
    twin = bland_altman(MINI, [*WRIGHT[:-1], WRIGHT[-1] + 20])
    assert round(twin.bias, 1) != -2.1
    assert round(twin.sd, 1) != 38.8


@pytest.mark.parametrize(
    ("form", "icc", "low", "high"),
    # coefficients .17, .29, .71 (Shrout & Fleiss, Table 4); intervals as R's psych prints them
    [("ICC1", 0.17, -0.13, 0.72), ("ICC2", 0.29, 0.02, 0.76), ("ICC3", 0.71, 0.34, 0.95)],
)
def test_intraclass_correlations_of_shrout_and_fleiss(form, icc, low, high):
    found = intraclass_correlation(JUDGES, form=form)
    assert tuple(round(v, 2) for v in found[:3]) == (icc, low, high)
    twin = [row.copy() for row in JUDGES]
    twin[0][1] += 2
    assert round(intraclass_correlation(twin, form=form).icc, 2) != icc


def test_bias_counts_against_agreement_only():
    rng = np.random.default_rng(0)
    true = rng.normal(0, 1, 200)
    both = np.column_stack((true, true)) + 0.2 * rng.standard_normal((200, 2))
    shifted = both + np.array([0.0, 1.0])
    plain = intraclass_correlation(both)
    assert plain.icc == pytest.approx(1 / 1.04, abs=0.02)  # 1 / (1 + 0.2^2)
    assert plain.low < 1 / 1.04 < plain.high
    assert intraclass_correlation(shifted, form="ICC3").icc == pytest.approx(
        intraclass_correlation(both, form="ICC3").icc
    )
    assert intraclass_correlation(shifted).icc == pytest.approx(1 / 1.54, abs=0.05)


def test_interval_holds_the_truth_as_often_as_it_says():
    rng = np.random.default_rng(1)
    held = 0
    for _ in range(400):
        true = rng.normal(0, 1, 12)
        values = true[:, None] + 0.5 * rng.standard_normal((12, 2)) + 0.3 * rng.standard_normal(2)
        low, high = intraclass_correlation(values)[1:3]
        held += low <= 1 / (1 + 0.25 + 0.09) <= high
    assert 0.92 < held / 400 < 0.99  # F and Satterthwaite: nominally 0.95


def test_perfect_agreement_is_one():
    values = np.column_stack((np.arange(5.0), np.arange(5.0)))
    for form in ("ICC1", "ICC2", "ICC3"):
        assert intraclass_correlation(values, form=form)[:3] == (1.0, 1.0, 1.0)
    moved = intraclass_correlation(values + np.array([0.0, 1.0]))
    assert np.isfinite(moved[:3]).all()
    found = bland_altman(values[:, 0], values[:, 1])
    assert (found.bias, found.sd, found.trend_p) == (0.0, 0.0, 1.0)


def strides_of(person, *, seed=0):
    rng = np.random.default_rng(seed)
    rows = []
    for animal in "abc":
        for leg in ("L1", "R1"):
            start = 0.0
            for stride in range(10):
                period = 0.2 + 0.02 * rng.standard_normal()
                true = 0.6 + 0.05 * rng.standard_normal()
                rows.append(
                    {
                        "animal": animal, "trial": "t", "leg": leg, "stride": stride + 1,
                        "start_s": start + 0.002 * person, "period_s": period,
                        "duty_factor": true + 0.02 * person,
                    }
                )  # fmt: skip
                start += period
    return pd.DataFrame(rows)


def test_measures_of_two_people_are_compared_stride_by_stride():
    one, two = strides_of(0), strides_of(1)
    two = two[two["stride"] != 4].assign(stride=lambda t: t["stride"] + 5)  # numbered differently
    table = repeatability_table(one, two).set_index("measure")
    assert (*table.index.names, *table.columns) == REPEATABILITY_COLUMNS
    assert table.index.tolist() == ["period_s", "duty_factor"]
    assert table["n"].tolist() == [54, 54]
    assert table["n_animals"].tolist() == [3, 3]
    assert table.loc["duty_factor", "bias"] == pytest.approx(0.02)
    assert table.loc["period_s", "icc"] == 1.0
    assert table.loc["duty_factor", "icc"] < 1.0
    few = repeatability_table(one.iloc[:2], two, measures=["duty_factor"])
    assert few["n"].iloc[0] == 2
    assert few["bias"].isna().all()


def test_a_stride_is_used_once():
    one = strides_of(0).iloc[:1]
    two = pd.concat([strides_of(1).iloc[:1].assign(start_s=s) for s in (0.03, 0.01, 0.2)])
    matched = match_strides(one, two)
    assert matched["start_s_2"].tolist() == [0.01]
    both = pd.concat([strides_of(0).iloc[:1].assign(start_s=s) for s in (0.0, 0.015)])
    assert match_strides(both, two.iloc[1:2])["start_s_1"].tolist() == [0.015]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: bland_altman([1, 2], [1, 2]), r"^agreement: shapes \(2,\) and \(2,\); expected"),
        (lambda: bland_altman([1, 2, np.nan], [1, 2, 3]), r"^agreement: a value is not finite"),
        (lambda: bland_altman([1, 2, 3], [1, 2, 4], factor=0), r"^level is 0\.95, factor 0;"),
        (lambda: intraclass_correlation([[1, 2]]), r"^intraclass correlation: values of shape"),
        (lambda: intraclass_correlation(np.ones((3, 2))), r"all values are equal; nothing varies"),
        (lambda: intraclass_correlation(JUDGES, form="ICC4"), r"^form is 'ICC4', level 0\.95;"),
        (
            lambda: match_strides(strides_of(0), strides_of(0).assign(trial="u")),
            r"^repeatability: the two tables share no stride; expected the same animals",
        ),
    ],
)
def test_bad_arguments_are_refused(call, message):
    with pytest.raises(InputError, match=message):
        call()
