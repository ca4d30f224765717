"""Intraclass correlation of animals: Shrout & Fleiss, closed forms, and how often it holds."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest
from scipy.stats import f as fisher

from pawnb.errors import InputError
from pawnb.gait.groups.animal_summary import summarise_animals
from pawnb.gait.inference.variance_shares import icc_interval, variance_shares
from pawnb.gait.regression.mixed import fit_mixed
from pawnb.gait.repeatability import intraclass_correlation

# Shrout & Fleiss (1979), Table 2: six targets, four judges
JUDGES = np.array([[9, 2, 5, 8], [6, 1, 3, 2], [8, 4, 6, 8], [7, 1, 2, 6], [10, 5, 6, 9],
                   [6, 2, 4, 7]], dtype=float)  # fmt: skip


def test_shrout_and_fleiss():
    animals = np.repeat(np.arange(6), 4)
    _, icc = variance_shares(JUDGES.ravel(), animals)
    low, high = icc_interval(JUDGES.ravel(), animals)
    assert round(icc, 2) == 0.17  # their Table 4
    assert round(high, 2) == 0.72  # R's psych prints -0.13 and 0.72; a share is not below 0
    assert low == 0.0
    other = JUDGES + np.arange(6)[:, None]
    low, high = icc_interval(other.ravel(), animals)
    form = intraclass_correlation(other, form="ICC1")
    assert (low, high) == pytest.approx((form.low, form.high))
    assert low > 0.0


def test_unequal_numbers_by_hand():
    # two animals, of 2 and 4 strides: one ratio of squares, lambda = 2 * 4 / 6 * 2 = 8 / 3
    values = np.array([1.0, 3.0, 6.0, 7.0, 8.0, 9.0])
    animals = list("aabbbb")
    between = 2 * (2.0 - 34 / 6) ** 2 + 4 * (7.5 - 34 / 6) ** 2
    within = (2.0 + 5.0) / 4
    ratios = [(between / within / fisher.ppf(q, 1, 4) - 1) / (8 / 3) for q in (0.95, 0.05)]
    found = icc_interval(values, animals, level=0.9)
    assert found == pytest.approx(tuple(max(r, 0) / (1 + max(r, 0)) for r in ratios))


def test_it_holds_the_truth_as_often_as_it_says():
    # exact for normal values, unequal numbers and a term: 95 %, standard error 0.9 %
    rng = np.random.default_rng(2)
    codes = np.repeat(np.arange(6), [3, 5, 8, 12, 20, 4])
    speed = rng.normal(0.0, 1.0, len(codes)) + codes
    design = np.column_stack((np.ones(len(codes)), speed))
    held = 0
    for _ in range(600):
        y = rng.normal(0.0, 1.0, 6)[codes] + rng.normal(0.0, 1.5, len(codes)) + 2.0 * speed
        low, high = icc_interval(y, codes.tolist(), design=design)
        held += low <= 1 / (1 + 1.5**2) <= high
    assert 0.925 < held / 600 < 0.975


def test_it_stands_beside_every_share():
    rng = np.random.default_rng(0)
    table = pd.DataFrame({"animal": np.repeat(list("abcde"), 8), "leg": "L1"})
    table["y"] = rng.normal(0, 1, 5)[np.repeat(np.arange(5), 8)] + rng.normal(0, 1, 40)
    row = summarise_animals(table, ["y"]).iloc[0]
    assert row["icc_low"] < row["icc"] < row["icc_high"]
    fit = fit_mixed(table, "y")
    assert (fit.icc_low, fit.icc_high) == pytest.approx((row["icc_low"], row["icc_high"]))
    assert fit.icc == pytest.approx(row["icc"], rel=1e-3)  # balanced
    table["x"] = rng.normal(0, 1, 40)
    assert math.isnan(fit_mixed(table, "y", ["x"]).icc_low)  # slopes are random too
    assert fit_mixed(table, "y", ["x"], slopes=False).icc_low < fit.icc_high


def test_what_cannot_be_told_is_nan():
    assert all(math.isnan(v) for v in icc_interval(np.arange(4.0), list("aaaa")))
    assert all(math.isnan(v) for v in icc_interval(np.arange(4.0), list("abcd")))
    assert all(math.isnan(v) for v in icc_interval(np.array([1.0, 1, 2, 2]), list("aabb")))
    with pytest.raises(InputError, match=r"^level is 2"):
        icc_interval(np.arange(4.0), list("aabb"), level=2)
