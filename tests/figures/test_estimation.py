"""Estimation plot: animals count once, differences are those of compare_groups."""

from __future__ import annotations

import itertools

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
from scipy.stats import ttest_ind, ttest_rel

from pawnb.errors import InputError
from pawnb.figures import build_estimation_table, plot_estimation

mpl.use("Agg")


@pytest.fixture(autouse=True)
def _close():
    yield
    plt.close("all")


def strides(paired=False):
    """Two values an animal, one below and one above its mean."""
    rows = []
    for group, means in (("control", (1.0, 2.0, 3.0)), ("lesion", (4.0, 5.0, 7.0))):
        for k, mean in enumerate(means):
            animal = f"m{k}" if paired else f"{group}{k}"
            rows += [(animal, group, mean - 0.5), (animal, group, mean + 0.5)]
    return pd.DataFrame(rows, columns=["animal", "group", "length"])


def test_animals_means_and_differences_by_hand():
    table = build_estimation_table(strides(), "length")
    animals = table[table["row"] == "animal"]
    assert animals["value"].tolist() == [1.0, 2.0, 3.0, 4.0, 5.0, 7.0]
    assert (animals["n"] == 2).all()
    means = table[table["row"] == "mean"]
    assert means["value"].tolist() == pytest.approx([2.0, 16.0 / 3.0])
    (away,) = table[table["row"] == "difference"].to_dict("records")
    welch = ttest_ind([4.0, 5.0, 7.0], [1.0, 2.0, 3.0], equal_var=False)
    interval = welch.confidence_interval(0.95)
    assert away["value"] == pytest.approx(10.0 / 3.0)
    assert (away["ci_low"], away["ci_high"]) == pytest.approx(tuple(interval))
    assert away["p"] == pytest.approx(welch.pvalue)
    assert (away["group"], away["against"], away["n_animals"]) == ("lesion", "control", 6)


def test_conditions_of_the_same_animals():
    table = build_estimation_table(strides(paired=True), "length", paired=True)
    (away,) = table[table["row"] == "difference"].to_dict("records")
    assert away["p"] == pytest.approx(ttest_rel([4.0, 5.0, 7.0], [1.0, 2.0, 3.0]).pvalue)
    assert away["n_animals"] == 3
    above = plot_estimation(table).figure.axes[0]
    joined = [line for line in above.lines if line.get_linewidth() == 0.6]
    assert [line.get_ydata()[:2].tolist() for line in joined if len(line.get_xdata()) == 2] == [
        [1.0, 4.0], [2.0, 5.0], [3.0, 7.0],
    ]  # fmt: skip


def test_points_means_and_intervals_are_drawn():
    table = build_estimation_table(strides(), "length")
    above, below = plot_estimation(table, label="Stride length (mm)").figure.axes
    dots = [line.get_ydata()[0] for line in above.lines if line.get_linestyle() == "None"]
    assert dots == [1.0, 2.0, 3.0, 4.0, 5.0, 7.0]
    bars = [line.get_ydata()[0] for line in above.lines if line.get_linewidth() == 1.6]
    assert bars == pytest.approx([2.0, 16.0 / 3.0])
    away = table[table["row"] == "difference"].iloc[0]
    interval = next(line for line in below.lines if line.get_linewidth() == 1.6)
    assert interval.get_ydata().tolist() == [away["ci_low"], away["ci_high"]]
    assert above.get_ylabel() == "Stride length (mm)"
    assert below.get_ylabel() == "Difference in\nstride length (mm)"
    assert [t.get_text() for t in below.get_xticklabels()] == [
        "control\n3 animals", "lesion\n3 animals",
    ]  # fmt: skip


def test_reference_that_comes_later():
    first = build_estimation_table(strides(), "length")
    table = build_estimation_table(strides(), "length", reference="lesion")
    (one,), (other,) = (t[t["row"] == "difference"].to_dict("records") for t in (first, table))
    assert (other["group"], other["against"]) == ("control", "lesion")
    assert other["value"] == -one["value"]
    assert (other["ci_low"], other["ci_high"]) == (-one["ci_high"], -one["ci_low"])
    assert (other["effect"], other["p_adjusted"]) == (-one["effect"], one["p_adjusted"])
    with pytest.raises(InputError, match=r"^reference is 'x'; expected one of the groups"):
        build_estimation_table(strides(), "length", reference="x")


def test_bad_input_is_refused():
    with pytest.raises(InputError, match=r"expected two groups or more"):
        build_estimation_table(strides().query("group == 'control'"), "length")
    with pytest.raises(InputError, match=r"^estimation plot: no value of 'length' with a group"):
        build_estimation_table(strides().assign(length=np.nan), "length")
    with pytest.raises(InputError, match=r"^estimation plot: the table is empty"):
        plot_estimation(build_estimation_table(strides(), "length").iloc[:0])


def lacking(*gone):
    """Conditions of four animals; some lack one of them."""
    means = {"before": (1.0, 2.0, 3.0, 9.0), "after": (4.0, 5.0, 7.0, 20.0), "late": (2, 4, 5, 6)}
    rows = [
        (f"m{k}", condition, mean + away)
        for condition, own in means.items()
        for k, mean in enumerate(own)
        for away in (-0.5, 0.5)
        if (f"m{k}", condition) not in gone
    ]
    return pd.DataFrame(rows, columns=["animal", "condition", "length"])


def test_animals_without_a_partner_are_seen_but_not_in_the_means():
    known = lacking(("m3", "after")).query("condition != 'late'")
    table = build_estimation_table(known, "length", group="condition", paired=True)
    means = table[table["row"] == "mean"].set_index("group")
    # by hand: of 1, 2, 3 (9 has no partner) and 4, 5, 7
    assert means["value"].to_dict() == pytest.approx({"before": 2.0, "after": 16.0 / 3.0})
    assert means[["n", "n_animals"]].to_numpy().tolist() == [[6, 3], [6, 3]]
    (away,) = table[table["row"] == "difference"].to_dict("records")
    assert means.loc["after", "value"] - means.loc["before", "value"] == pytest.approx(
        away["value"]
    )
    assert table[table["row"] == "animal"]["counts"].tolist() == [True] * 3 + [False] + [True] * 3
    above, below = plot_estimation(table).figure.axes
    names = [t.get_text() for t in below.get_xticklabels()]
    assert names == ["before\n3 of 4 animals", "after\n3 animals"]
    colours = [line.get_markeredgecolor() for line in above.lines if line.get_linestyle() == "None"]
    assert len(colours) == 7
    assert [c != colours[0] for c in colours] == [False] * 3 + [True] + [False] * 3
    assert "3 pairs" in below.texts[0].get_text()


def test_each_condition_counts_who_is_in_the_reference_too():
    table = build_estimation_table(
        lacking(("m3", "before"), ("m0", "late")), "length", group="condition", paired=True
    )
    means = table[table["row"] == "mean"].set_index("group")
    # by hand: 1, 2, 3 have partners; 4, 5, 7 without 20; 4, 5 without 6
    assert means["value"].to_dict() == pytest.approx(
        {"before": 2.0, "after": 16.0 / 3.0, "late": 4.5}
    )
    pairs = table[table["row"] == "difference"].set_index("group")["n_animals"].to_dict()
    assert pairs == {"after": 3, "late": 2}


def test_conditions_that_share_no_animal_have_no_difference():
    known = lacking(("m0", "late"), ("m1", "late"), ("m2", "late"), ("m3", "before"))
    table = build_estimation_table(known, "length", group="condition", paired=True)
    _, below = plot_estimation(table).figure.axes
    assert len(below.texts) == 1
    assert below.get_xticklabels()[2].get_text() == "late\n0 of 1\nanimal"


@pytest.mark.slow
def test_words_of_many_conditions_do_not_run_into_each_other():
    base = np.arange(5.0)
    rows = [
        (f"m{k}", f"day {c}", 10.0 + value + c * (1.0 + 0.1 * k))
        for c in range(5)
        for k, value in enumerate(base)
    ]
    known = pd.DataFrame(rows, columns=["animal", "condition", "length"])
    table = build_estimation_table(known, "length", group="condition", paired=True)
    _, below = plot_estimation(table).figure.axes
    below.figure.canvas.draw()
    boxes = [t.get_window_extent() for t in below.get_xticklabels()]
    gaps = [b.x0 - a.x1 for a, b in itertools.pairwise(boxes)]
    assert min(gaps) > 0.0
    # once, as all are against the same one; and p of several comparisons is adjusted
    assert [t.get_text().count("less") for t in below.texts] == [1, 0, 0, 0]
    assert all("adj. p" in t.get_text().replace("\n", " ") for t in below.texts)


def test_words_beside_a_difference_near_zero_are_not_struck_through_by_the_zero_line():
    """They are centred on the difference: p stood on the dashed line of no difference."""
    rows = strides()
    rows.loc[rows["group"] == "lesion", "length"] -= 3.3
    below = plot_estimation(build_estimation_table(rows, "length")).figure.axes[1]
    (words,) = below.texts[:1]
    below.figure.draw_without_rendering()
    patch = words.get_bbox_patch()
    zero = below.transData.transform((0.0, 0.0))[1]
    box = patch.get_window_extent()
    assert box.y0 < zero < box.y1
    assert patch.get_facecolor() == mpl.colors.to_rgba(below.get_facecolor())
    (line,) = [one for one in below.lines if np.allclose(one.get_ydata(), 0.0)]
    assert words.get_zorder() > line.get_zorder()
