"""Comparison of groups: differences and effect sizes by hand and from books, level, coverage."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest
from scipy.stats import ttest_ind, ttest_rel
from statsmodels.stats.multitest import multipletests

from pawnb.errors import InputError, InputWarning
from pawnb.figures import build_estimation_table
from pawnb.gait.circular.tests import mean_test
from pawnb.gait.groups import GROUP_COLUMNS, adjust_p, compare_groups
from pawnb.gait.groups.animal_summary import summarise_animals
from pawnb.gait.groups.differences import compare_paired, compare_two, compare_two_phases, hedges_g
from pawnb.gait.overview import measures_by_animal

A = np.array([3.0, 4, 1, 2, 5])
B = np.array([7.0, 5, 6, 9, 8, 4])


def test_welch_and_its_interval():
    found = compare_two(A, B)
    other = ttest_ind(B, A, equal_var=False)
    ends = other.confidence_interval(0.95)
    assert (found.mean_a, found.mean_b, found.difference) == pytest.approx((3, 6.5, 3.5))
    assert found.p == pytest.approx(other.pvalue)
    assert (found.ci_low, found.ci_high) == pytest.approx((ends.low, ends.high))
    twin = compare_two(A, np.append(B[:5], 4.1))
    assert twin.p != pytest.approx(other.pvalue, rel=1e-3)


def test_paired_and_its_interval():
    found = compare_paired(A, B[:5])
    other = ttest_rel(B[:5], A)
    ends = other.confidence_interval(0.95)
    assert found.p == pytest.approx(other.pvalue)
    assert (found.ci_low, found.ci_high) == pytest.approx((ends.low, ends.high))
    assert found.p != pytest.approx(compare_two(A, B[:5]).p, rel=0.01)
    # Hedges (1981), Table 1: c(4) = 0.7979 for the 4 degrees of freedom of five differences
    each = B[:5] - A
    assert found.effect == pytest.approx(0.7979 * each.mean() / each.std(ddof=1), rel=1e-4)


@pytest.mark.parametrize(
    ("df", "j"),
    # Hedges (1981), Table 1, c(m): Gamma(m / 2) / (sqrt(m / 2) Gamma((m - 1) / 2))
    [(2, 0.5642), (4, 0.7979), (8, 0.9027), (10, 0.9227), (20, 0.9619), (50, 0.9849)],
)
def test_correction_of_small_samples(df, j):
    assert hedges_g(1.0, 2.0, df)[0] == pytest.approx(j, abs=5e-5)
    assert hedges_g(1.0, 2.0, df + 1)[0] != pytest.approx(j, abs=5e-5)


def test_interval_of_the_effect_size():
    # t = 4.2 with 20 pairs less one degree of freedom: the noncentral t distributions whose
    # 2.5 % tails begin there (scipy's nct, near its centre)
    from scipy.stats import nct

    g, low, high = hedges_g(4.2 / math.sqrt(20), math.sqrt(20), 19)
    j = g / (4.2 / math.sqrt(20))
    assert nct.cdf(4.2, 19, high / j * math.sqrt(20)) == pytest.approx(0.025, abs=1e-5)
    assert nct.cdf(4.2, 19, low / j * math.sqrt(20)) == pytest.approx(0.975, abs=1e-5)
    # very large effects do not break it
    assert hedges_g(40.0, math.sqrt(2.5), 8)[1] > 10


@pytest.mark.slow
def test_coverage_of_the_effect_size():
    # true difference 1 SD; 500 studies, standard error 1 %
    rng = np.random.default_rng(2)
    j = hedges_g(1.0, 1.0, 8)[0]
    hits = 0
    for _ in range(500):
        found = compare_two(rng.normal(0, 1, 5), rng.normal(1, 1, 5))
        hits += found.effect_low <= j <= found.effect_high
    assert 0.92 <= hits / 500 <= 0.98


def test_close_phases_compare_as_numbers_do():
    found = compare_two_phases(A * 1e-4 + 0.98, B * 1e-4 + 0.98)
    other = compare_two(A, B)
    assert found.difference == pytest.approx(3.5e-4)
    assert (found.ci_low, found.ci_high) == pytest.approx(
        (other.ci_low * 1e-4, other.ci_high * 1e-4), rel=1e-4
    )
    assert found.p == pytest.approx(other.p, rel=1e-3)
    assert math.isnan(found.effect)
    paired = compare_paired(np.mod(A * 1e-4 - 2e-4, 1), np.mod(B[:5] * 1e-4, 1), circular=True)
    assert paired.p == pytest.approx(compare_paired(A - 2, B[:5]).p, rel=1e-3)


def test_two_animals_a_group_are_enough_for_phases():
    """Standard errors of close phases are those of numbers: Welch's t test of scipy."""
    a, b = np.array([2.0, 3.0]), np.array([5.0, 9.0])
    found = compare_two_phases(a * 1e-4, b * 1e-4)
    test = ttest_ind(b, a, equal_var=False)
    assert found.p == pytest.approx(test.pvalue, rel=1e-3)
    interval = test.confidence_interval(0.95)
    assert (found.ci_low, found.ci_high) == pytest.approx(
        (interval.low * 1e-4, interval.high * 1e-4), rel=1e-3
    )
    assert math.isnan(compare_two_phases(a[:1] * 1e-4, b * 1e-4).p)


def test_paired_phases_are_a_test_of_their_differences():
    rng = np.random.default_rng(1)
    a = rng.random(6)
    each = 0.1 + rng.normal(0, 0.05, 6)
    found = compare_paired(a, np.mod(a + each, 1), circular=True)
    test = mean_test(each, expected=0.0, animals=list("abcdef"))
    assert found.p == pytest.approx(test.p)


def test_scattered_phases_have_an_interval_of_95_percent_of_the_cycle():
    found = compare_two_phases(np.array([0, 0.3, 0.55]), np.array([0.1, 0.5, 0.8]))
    assert found.ci_high - found.ci_low == pytest.approx(0.95)
    assert "any is possible" in found.note
    assert found.p == 1.0


@pytest.mark.slow
@pytest.mark.parametrize("concentration", [50.0, 4.0])
def test_phases_of_two_groups_hold_their_level(concentration):
    rng = np.random.default_rng(6)
    low = hits = 0
    for _ in range(800):  # standard error 0.8 %
        a, b = rng.vonmises(0, concentration, (2, 5)) / (2 * np.pi)
        found = compare_two_phases(np.mod(a, 1), np.mod(b + 0.3, 1))
        hits += not found.ci_low > 0.3 and not found.ci_high < 0.3
        low += compare_two_phases(np.mod(a, 1), np.mod(b, 1)).p <= 0.05
    assert 0.93 <= hits / 800 <= 0.975
    assert low / 800 <= 0.065


P = np.array([0.01, 0.04, 0.03, 0.2, math.nan])


@pytest.mark.parametrize(
    ("correction", "expected"),
    # by hand; statsmodels agrees below
    [("holm", [0.04, 0.09, 0.09, 0.2]), ("bonferroni", [0.04, 0.16, 0.12, 0.8]),
     ("fdr", [0.04, 0.16 / 3, 0.16 / 3, 0.2]), ("none", [0.01, 0.04, 0.03, 0.2])],
)  # fmt: skip
def test_adjusted_p(correction, expected):
    found = adjust_p(P, correction=correction)
    assert found[:4] == pytest.approx(expected)
    assert math.isnan(found[4])
    assert adjust_p(P[:3], correction="none") == pytest.approx(P[:3])


def test_adjusted_p_is_statsmodels():
    p = np.random.default_rng(0).random(30) ** 3
    for ours, theirs in (("holm", "holm"), ("fdr", "fdr_bh"), ("bonferroni", "bonferroni")):
        assert adjust_p(p, correction=ours) == pytest.approx(multipletests(p, method=theirs)[1])


def strides(n_animals=4, groups=("control", "lesion", "sham")):
    rng = np.random.default_rng(8)
    rows = []
    for g, group in enumerate(groups):
        for i in range(n_animals):
            own = rng.normal(0.6 + 0.02 * g, 0.03)
            for _ in range(6):
                rows.append((f"{group}{i}", group, "L1", own + rng.normal(0, 0.01), rng.random()))
    return pd.DataFrame(rows, columns=["animal", "group", "leg", "duty_factor", "phase"])


def test_table_of_groups():
    table = strides()
    found = compare_groups(table, ["duty_factor"], by=["leg"])
    assert list(found.columns) == ["leg", *GROUP_COLUMNS]
    assert found[["group_a", "group_b"]].to_numpy().tolist() == [
        ["control", "lesion"], ["control", "sham"], ["lesion", "sham"]
    ]  # fmt: skip
    row = found.iloc[0]
    assert row[["n_animals_a", "n_animals_b", "n_a", "n_b"]].tolist() == [4, 4, 24, 24]
    means = table.groupby(["group", "animal"])["duty_factor"].mean()
    direct = compare_two(means["control"].to_numpy(), means["lesion"].to_numpy())
    assert (row["difference"], row["p"]) == pytest.approx((direct.difference, direct.p))
    assert row["p_strides"] < row["p"] <= row["p_adjusted"]
    assert found["p_adjusted"].to_numpy() == pytest.approx(adjust_p(found["p"].to_numpy()))
    other = table.assign(leg="R1", duty_factor=1.0 - table["duty_factor"])
    legs = compare_groups(pd.concat([table, other]), ["duty_factor"], by=["leg"]).groupby("leg")
    for leg, sign in (("L1", 1.0), ("R1", -1.0)):
        own = legs.get_group(leg)["difference"].to_numpy(float)
        assert own == pytest.approx(sign * found["difference"].to_numpy(float))
    only = compare_groups(table, ["duty_factor"], reference="sham", correction="none")
    assert only["group_b"].tolist() == ["control", "lesion"]
    assert only["p_adjusted"].tolist() == only["p"].tolist()
    # repeating every stride changes nothing but the naive p
    again = compare_groups(pd.concat([table] * 3), ["duty_factor"], by=["leg"])
    assert again["p"].to_numpy() == pytest.approx(found["p"].to_numpy())
    assert (again["p_strides"] < found["p_strides"]).all()


@pytest.mark.slow
def test_each_measure_is_a_family():
    table = strides()
    table["period_s"] = table["phase"] * 0.1
    found = compare_groups(table, ["duty_factor", "period_s"])
    p = found["p"].to_numpy()
    # three pairs of groups a measure, by statsmodels
    by_hand = [multipletests(p[rows], method="holm")[1] for rows in (slice(3), slice(3, 6))]
    assert found["p_adjusted"].to_numpy() == pytest.approx(np.concatenate(by_hand))
    assert found["p_all_measures"].to_numpy() == pytest.approx(multipletests(p, method="holm")[1])
    assert (found["p_all_measures"] > found["p_adjusted"]).any()
    alone = compare_groups(table, ["duty_factor"])
    assert alone["p_adjusted"].to_numpy() == pytest.approx(found["p_adjusted"].to_numpy()[:3])


def test_legs_count_alike_where_they_are_averaged():
    # every animal: 4 strides of L1 at m, 1 of R1 at m + 0.1; its mean over legs is m + 0.05
    means = {"a1": 1.0, "a2": 1.2, "a3": 1.1, "b1": 2.0, "b2": 2.1, "b3": 2.3}
    rows = [
        (animal, animal[0], leg, m + (0.1 if leg == "R1" else 0.0))
        for animal, m in means.items()
        for leg in ("L1", "L1", "L1", "L1", "R1")
    ]
    table = pd.DataFrame(rows, columns=["animal", "group", "leg", "y"])
    found = compare_groups(table, ["y"], average_over="leg").iloc[0]
    assert (found["mean_a"], found["mean_b"]) == pytest.approx((1.15, 6.4 / 3 + 0.05))
    assert compare_groups(table, ["y"]).iloc[0]["mean_a"] == pytest.approx(1.12)
    assert (found["n_a"], found["n_animals_a"]) == (15, 3)
    with pytest.raises(InputError, match=r"^phases of several legs have no common mean; use by="):
        compare_groups(table, ["y"], average_over="leg", circular=True)


def test_conditions_of_the_same_animals():
    table = strides(groups=("walk", "run"))
    table["animal"] = table["animal"].str[-1]
    with pytest.raises(InputError, match=r"^animal 0 is in more than one group; say paired=True"):
        compare_groups(table, ["duty_factor"])
    cut = table[(table["animal"] != "3") | (table["group"] == "run")]
    found = compare_groups(cut, ["duty_factor"], paired=True).iloc[0]
    means = table.groupby(["group", "animal"])["duty_factor"].mean()
    expected = ttest_rel(means["run"].iloc[:3], means["walk"].iloc[:3])
    assert found["p"] == pytest.approx(expected.pvalue)
    assert found["note"] == "1 animal in one condition only left out"
    circular = compare_groups(table, ["phase"], paired=True, circular=True).iloc[0]
    assert "paired t of phases" in circular["method"]
    assert -0.5 <= circular["difference"] < 0.5


def test_an_animal_whose_phases_cancel_out_is_left_out_and_the_others_are_compared():
    rows = [("a1", "a", 0.1), ("a2", "a", 0.15), ("a3", "a", 0.0), ("a3", "a", 0.5),
            ("b1", "b", 0.3), ("b2", "b", 0.4)]  # fmt: skip
    table = pd.DataFrame(rows, columns=["animal", "group", "phase"])
    found = compare_groups(table, ["phase"], circular=True).iloc[0]
    assert found["note"] == "1 animals without a mean phase left out"
    assert found["difference"] == pytest.approx(0.225)  # of 0.125 and 0.35
    assert (found["n_animals_a"], found["n_a"], found["n_animals_b"], found["n_b"]) == (2, 2, 2, 2)
    alone = compare_groups(table[table["animal"].isin(["a3", "b1"])], ["phase"], circular=True)
    assert math.isnan(alone.iloc[0]["p"])
    assert alone.iloc[0]["note"] == "1 animals without a mean phase left out"


@pytest.mark.parametrize(
    ("a", "b", "options"),
    [
        # R 4.2.2, t.test of each of these: Error: data are essentially constant
        ([0.75, 0.75, 0.75], [0.5, 0.5, 0.5], {}),
        ([0.1 + 0.2, 0.3, 0.3], [0.6, 0.6, 0.6], {}),
        ([0.1, 0.2, 0.3], [0.2, 0.3, 0.4], {"paired": True}),
        ([0.5, 0.5, 0.5], [0.98, 0.98, 0.98], {"circular": True}),
        ([0.1, 0.2, 0.3], [0.2, 0.3, 0.4], {"circular": True, "paired": True}),
    ],
)
def test_what_differs_by_rounding_only_is_not_tested(a, b, options):
    rows = [
        (f"{i}" if "paired" in options else f"{group}{i}", group, value)
        for group, values in (("a", a), ("b", b))
        for i, value in enumerate(values)
    ]
    table = pd.DataFrame(rows, columns=["animal", "group", "y"])
    found = compare_groups(table, ["y"], **options).iloc[0]
    assert found[["ci_low", "ci_high", "effect", "p"]].isna().all()
    assert found["note"] == "no spread between animals beyond rounding: no interval and no p"
    assert (found["n_animals_a"], found["n_animals_b"], found["method"]) == (3, 3, "none")


def test_a_group_without_values_is_told():
    table = strides()
    table.loc[table["group"] == "sham", "duty_factor"] = np.nan
    found = compare_groups(table, ["duty_factor"])
    assert found["note"].tolist() == ["", "no values in sham", "no values in sham"]
    with pytest.raises(InputError, match=r"^column 'leg' does not hold numbers"):
        compare_groups(table, ["leg"])


def test_one_animal_in_a_group_has_no_p():
    table = strides()
    table = table[~table["animal"].isin(["sham1", "sham2", "sham3"])]
    found = compare_groups(table, ["duty_factor"])
    last = found.iloc[2]
    assert last["n_animals_b"] == 1
    assert math.isnan(last["p"])
    assert math.isnan(last["p_adjusted"])
    assert "one animal in a group" in last["note"]
    # what has no p is not counted in the correction
    assert found.iloc[0]["p_adjusted"] == pytest.approx(found.iloc[0]["p"])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"correction": "x"}, "^correction is 'x'; expected one of"),
        ({"reference": "x"}, "^reference is 'x'; expected one of the groups"),
        ({"group": "leg"}, r"^column 'leg' holds \['L1'\]; expected two groups or more"),
        ({"by": ["sex"]}, "column 'sex' is missing"),
        ({"level": 95}, "^level is 95"),
        ({"paired": True}, "^paired: no animal is in both conditions"),
    ],
)
def test_bad_input_is_refused(options, message):
    with pytest.raises(InputError, match=message):
        compare_groups(strides(), ["duty_factor"], **options)
    with pytest.raises(InputError, match=r"^correction is 'x'"):
        adjust_p(P, correction="x")


def unlike_legs(lacking):
    """Fore legs at 0.65, hind legs 0.07 above, animals as they come; no difference of groups."""
    steps = {"a1": 0.0, "a2": 0.01, "a3": 0.02, "b1": 0.0, "b2": 0.01, "b3": 0.02}
    rows = [
        (animal, animal[0], leg, 0.65 + step + 0.07 * (leg == "HR"))
        for animal, step in steps.items()
        for leg in ("FR", "HR")
        for _ in range(4)
        if leg not in lacking.get(animal, ())
    ]
    return pd.DataFrame(rows, columns=["animal", "group", "leg", "duty_factor"])


def test_an_animal_without_a_leg_does_not_differ_by_what_its_legs_differ():
    whole = compare_groups(unlike_legs({}), ["duty_factor"], average_over="leg").iloc[0]
    assert (whole["difference"], whole["note"]) == (pytest.approx(0.0), "")
    lame = unlike_legs({"b1": ["HR"], "b2": ["HR"]})
    found = compare_groups(lame, ["duty_factor"], average_over="leg").iloc[0]
    # of fore legs alone: the groups are the same, and p is 1
    assert (found["difference"], found["mean_a"]) == pytest.approx((0.0, 0.66))
    assert (found["p"], found["n_a"], found["n_animals_b"]) == (pytest.approx(1.0), 12, 3)
    assert found["note"] == "mean of FR only: HR is not known of b1, b2"
    table = build_estimation_table(lame, "duty_factor", average_over="leg")
    assert table.loc[table["row"] == "mean", "value"].tolist() == pytest.approx([0.66, 0.66])
    assert measures_by_animal(lame, ["duty_factor"])["duty_factor"]["b1"] == pytest.approx(0.65)


def test_a_leg_that_stands_in_one_condition_is_left_out_in_the_other():
    table = unlike_legs({"b1": ["HR"]})
    table["animal"] = table["animal"].str[-1]
    alone = table[table["animal"] == "3"].assign(animal="4", group="a")
    table = pd.concat([table, alone[alone["leg"] == "HR"]])  # without partner, so of no account
    found = compare_groups(table, ["duty_factor"], average_over="leg", paired=True).iloc[0]
    assert (found["difference"], found["mean_b"]) == pytest.approx((0.0, 0.66))
    only = "1 animal in one condition only left out"
    assert found["note"].endswith(f"{only}; mean of FR only: HR is not known of 1")


def test_animals_that_share_no_leg_are_said_to_have_means_of_different_ones():
    lacking = {"a1": ["HR"], "a2": ["HR"], "a3": ["HR"], "b3": ["HR"], "b1": ["FR"], "b2": ["FR"]}
    found = compare_groups(unlike_legs(lacking), ["duty_factor"], average_over="leg").iloc[0]
    assert found["n_animals_b"] == 3
    assert found["note"] == (
        "animals have means of different legs: HR is not known of a1, a2, a3 and 1 more; "
        "FR is not known of b1, b2"
    )


def strides_of_groups():
    return pd.DataFrame(
        {
            "animal": np.repeat(list("abcdef"), 3),
            "group": np.repeat(["control", "lesion"], 9),
            "duty": np.arange(18) / 40,
        }
    )


def test_animals_without_a_group_are_named():
    """As of a dictionary that lacks one: Series.map leaves its rows without a group."""
    table = strides_of_groups()
    group = {"a": "control", "b": "control", "d": "lesion", "e": "lesion", "f": "lesion"}
    with pytest.warns(InputWarning, match=r"'group' is empty in rows of c, which are left out"):
        found = compare_groups(table.assign(group=table["animal"].map(group)), ["duty"])
    assert (found["n_animals_a"][0], found["n_animals_b"][0]) == (2, 3)


@pytest.mark.parametrize("summarise", [compare_groups, summarise_animals, measures_by_animal])
def test_rows_of_no_animal_are_refused(summarise):
    table = strides_of_groups().assign(leg="FR")
    table.loc[2, "animal"] = None
    with pytest.raises(InputError, match=r"column 'animal' is empty in row 3; expected a name"):
        summarise(table, ["duty"])


def test_infinite_values_are_refused():
    table = strides_of_groups()
    table.loc[2, "duty"] = np.inf
    with pytest.raises(InputError, match="groups: column 'duty' is infinite in row 3"):
        compare_groups(table, ["duty"])
