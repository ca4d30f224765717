"""Cluster permutation tests of curves: against MNE's clusters, scipy's t in every arrangement."""

from __future__ import annotations

import itertools

import numpy as np
import pandas as pd
import pytest
from scipy.stats import t as student
from scipy.stats import ttest_ind, ttest_rel

from pawnb.errors import InputError
from pawnb.gait.cycles.tests import compare_cycles

N = 20


def curves(n_a, n_b):
    """Curves of the animals of two groups by a formula; the second group is higher twice."""
    i, k = np.arange(n_a + n_b)[:, None], np.arange(N)
    made = np.sin(12.9898 * i * i + 0.61 * k) + 0.5 * np.sin(78.233 * i + 1.9 * k)
    bump = 1.2 * np.exp(-0.5 * ((k - 7.0) / 1.5) ** 2)
    bump = bump + 1.0 * np.exp(-0.5 * (((k - 19 + 10) % N - 10) / 1.5) ** 2)  # goes on over the end
    return made + np.where(i >= n_a, bump, 0.0)


def cycles(values, n_a, *, paired=False, leg="L2"):
    """Return curves as the table of cut cycles, two strides an animal whose mean they are."""
    rows = [
        (f"m{i - n_a if paired and i >= n_a else i}", "t" if i < n_a else "u", leg, stride,
         100.0 * k / N, curve[k % N] + (0.3 if stride else -0.3), "leg angle", "deg",
         "a" if i < n_a else "b")
        for i, curve in enumerate(values) for stride in (0, 1) for k in range(N + 1)
    ]  # fmt: skip
    columns = ["animal", "trial", "leg", "stride", "percent", "value", "signal", "unit", "group"]
    return pd.DataFrame(rows, columns=columns)


def masses(t, limit):
    """Return the sums of t over runs beyond the limit on a ring, found step by step."""
    found = []
    for side in (1, -1):
        inside = [side * x > limit for x in t]
        for k in range(len(t)):
            if inside[k] and not inside[k - 1]:  # a run begins; -1 is the last point
                run, j = 0.0, k
                while inside[j % len(t)]:
                    run, j = run + t[j % len(t)], j + 1
                found.append(run)
    return found


def every_p(statistic, values, arrangements, limit):
    """Return the heaviest cluster of every arrangement, each by scipy."""
    return np.array(
        [max(map(abs, masses(statistic(values, one), limit)), default=0.0) for one in arrangements]
    )


@pytest.mark.slow
def test_unpaired_clusters_are_those_of_mne_and_p_that_of_every_arrangement():
    values = curves(5, 6)
    found = compare_cycles(cycles(values, 5))
    heaviest = every_p(
        lambda v, c: ttest_ind(v[list(c)], np.delete(v, list(c), axis=0)).statistic,
        values, list(itertools.combinations(range(11), 6)), student.ppf(0.975, 9),
    )  # fmt: skip
    assert len(heaviest) == 462
    for row in found.itertuples():
        assert row.p == pytest.approx((heaviest >= abs(row.mass) - 1e-6).mean())
    assert (found["method"] == "all 462 arrangements").all()
    # MNE 1.13, permutation_cluster_test with ttest_ind_no_p and a ring of neighbours
    np.testing.assert_allclose(found["mass"], [13.653282, 10.747233], atol=1e-5)


def test_paired_clusters_are_those_of_mne_and_p_that_of_every_sign():
    values = curves(6, 6)
    found = compare_cycles(cycles(values, 6, paired=True), paired=True)
    difference = values[6:] - values[:6]
    heaviest = every_p(
        lambda v, s: ttest_rel(v * np.array(s)[:, None], 0.0 * v).statistic,
        difference, list(itertools.product((1, -1), repeat=6)), student.ppf(0.975, 5),
    )  # fmt: skip
    for row in found.itertuples():
        assert row.p == pytest.approx((heaviest >= abs(row.mass) - 1e-6).mean())
    # MNE 1.13, permutation_cluster_1samp_test with a ring of neighbours
    np.testing.assert_allclose(found["mass"], [11.606625, 10.988309], atol=1e-5)


def test_a_cluster_goes_on_over_the_end_of_the_stride():
    found = compare_cycles(cycles(curves(6, 6), 6, paired=True), paired=True)
    first = found.iloc[0]
    assert (first["start_percent"], first["stop_percent"]) == (90.0, 0.0)
    assert first["mean_difference"] > 0.9


def test_p_counts_the_legs():
    """With seven further legs that are the same in both groups p can only grow."""
    values = curves(5, 6)
    noise = curves(11, 0)
    alone = compare_cycles(cycles(values, 5))
    table = pd.concat(
        [cycles(values, 5), *(cycles(np.roll(noise, k, axis=0), 5, leg=f"R{k}") for k in range(4))]
    )
    joint = compare_cycles(table)
    own = joint[joint["leg"] == "L2"]
    assert (own["p"].to_numpy() >= alone["p"].to_numpy()).all()
    assert own["p"].iloc[-1] > alone["p"].iloc[-1]
    np.testing.assert_allclose(own["mass"], alone["mass"])


@pytest.mark.slow
def test_random_arrangements_come_near_to_all_of_them():
    """8 and 8 animals have 12,870 arrangements; among 6 and 6 all are tried."""
    values = 0.55 * curves(8, 8) + 0.45 * np.roll(curves(16, 0), 5, axis=0)
    found = compare_cycles(cycles(values, 8))
    heaviest = []
    limit = student.ppf(0.975, 14)
    rng = np.random.default_rng(5)
    for _ in range(800):
        order = rng.permutation(16)
        t = ttest_ind(values[order[8:]], values[order[:8]]).statistic
        heaviest.append(max(map(abs, masses(t, limit)), default=0.0))
    assert (found["method"] == "9999 random arrangements").all()
    for row in found.itertuples():
        assert row.p == pytest.approx((np.array(heaviest) >= abs(row.mass)).mean(), abs=0.05)


def test_curves_without_a_difference_have_p_one_and_few_animals_a_note():
    same = np.tile(np.sin(np.arange(N)), (4, 1)) + 1e-3 * curves(4, 0)
    found = compare_cycles(cycles(same, 2))
    assert (found["p"] > 0.3).all()
    # 6 arrangements, of which two are mirror images
    assert found["note"].iloc[0] == "with 2 and 2 animals no p below 0.33 is possible"
    flat = compare_cycles(cycles(np.zeros((4, N)), 2))
    assert flat[["cluster", "p"]].to_numpy().tolist() == [[0, 1.0]]


def test_each_two_of_three_groups_are_compared_and_counted():
    table = cycles(curves(4, 8), 4)
    late = table["animal"].isin([f"m{i}" for i in range(8, 12)])
    table.loc[late, "group"] = "c"
    found = compare_cycles(table)
    pairs = set(zip(found["group_a"], found["group_b"], strict=True))
    assert pairs == {("a", "b"), ("a", "c"), ("b", "c")}
    np.testing.assert_allclose(found["p_adjusted"], np.minimum(3 * found["p"], 1.0))


def test_a_group_of_one_animal_does_not_keep_the_others_from_being_compared():
    table = cycles(curves(5, 6), 5)
    two = compare_cycles(table)
    single = table[table["animal"] == "m0"].assign(animal="x0", group="c")
    found = compare_cycles(pd.concat([table, single]))
    tested = found[found["p"].notna()].reset_index(drop=True)
    pd.testing.assert_frame_equal(tested, two)  # p_adjusted counts that one test
    rest = found[found["p"].isna()]
    assert list(zip(rest["group_a"], rest["group_b"], strict=True)) == [("a", "c"), ("b", "c")]
    assert rest["note"].tolist()[0] == "animals with curves: 5 of a, 1 of c: not compared"
    assert rest["p_adjusted"].isna().all()


def test_animals_without_every_leg_and_broken_strides_are_left_out():
    both = pd.concat([cycles(curves(5, 6), 5), cycles(curves(5, 6), 5, leg="R2")])
    gone = both[~((both["animal"] == "m0") & (both["leg"] == "R2"))]
    found = compare_cycles(gone)
    assert found["n_animals_a"].iloc[0] == 4
    assert "1 animal without whole curves" in found["note"].iloc[0]
    holed = cycles(curves(5, 6), 5)
    broken = (holed["stride"] == 1) & (holed["animal"] == "m3") & (holed["percent"] == 50.0)
    holed.loc[broken, "value"] = np.nan
    # the other stride of that animal is 0.3 lower
    low = curves(5, 6)
    low[3] -= 0.3
    np.testing.assert_allclose(
        compare_cycles(holed)["mass"], compare_cycles(cycles(low, 5))["mass"]
    )


def test_what_cannot_be_compared_is_one_sentence():
    table = cycles(curves(5, 6), 5)
    with pytest.raises(InputError, match=r"column 'group' holds \['a'\]; expected two groups"):
        compare_cycles(table[table["group"] == "a"])
    with pytest.raises(InputError, match="animal m0 is in more than one group; say paired=True"):
        compare_cycles(cycles(curves(3, 3), 3, paired=True))
    with pytest.raises(InputError, match="animals with curves: 1 of a, 6 of b; expected two or"):
        compare_cycles(table[table["animal"].isin(["m0", *(f"m{i}" for i in range(5, 11))])])
    with pytest.raises(InputError, match="threshold_p is 2"):
        compare_cycles(table, threshold_p=2)
    with pytest.raises(InputError, match="no stride has a whole curve"):
        compare_cycles(table.assign(value=np.nan))
