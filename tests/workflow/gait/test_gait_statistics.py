"""The statistics that pawnb gait writes: from inputs whose differences are known."""

from __future__ import annotations

import dataclasses

import numpy as np
import pandas as pd
import pytest
from scipy.stats import ttest_ind
from statsmodels.stats.multitest import multipletests

from pawnb import gait
from pawnb.gait.groups import adjust_p
from pawnb.gait.joints import get_joint_angles, joint_range_table
from pawnb.io.native import write_tracks
from pawnb.schema import make_tracks
from pawnb.synthetic.spider_study import simulate_spider_study
from pawnb.trial import Animal, Trial
from pawnb.workflow.gait.drawing.drawings import gait_drawings
from pawnb.workflow.gait.run import run_gait
from pawnb.workflow.gait.statistics import body_angles_of, joint_angles_of, statistics_tables
from pawnb.workflow.provenance.results import describe_trial

pytestmark = pytest.mark.slow

OWN = (-0.006, -0.002, 0.001, 0.007)
"""How far the periods of four animals are from the mean of their group, s; they sum to 0."""


def events_of(animal, trial, period_s, *, lag=0.5):
    """Ten strides of two legs that never vary: duty factor 0.6."""
    rows = []
    for leg, shift in (("L1", lag), ("R1", 0.0)):
        for k in range(11):
            start = (k + shift) * period_s
            rows += [(animal, trial, leg, "AEP", start)]
            rows += [(animal, trial, leg, "PEP", start + 0.6 * period_s)]
    return pd.DataFrame(rows, columns=["animal", "trial", "leg", "event", "time_s"])


def two_groups(*, same_animals=False):
    """Four animals a group, periods 0.20 s in a and 0.25 s in b; phases 0.5 in a, 0.6 in b."""
    events, groups = [], {}
    for group, period, lag in (("a", 0.20, 0.5), ("b", 0.25, 0.6)):
        for k, own in enumerate(OWN):
            animal = f"m{k}" if same_animals else f"{group}{k}"
            trial = f"{animal}-{group}"
            events.append(events_of(animal, trial, period + own, lag=lag + own))
            groups[animal, trial] = group
    return gait.analyse_events(pd.concat(events, ignore_index=True)), groups


def test_groups_differ_by_what_was_put_in():
    tables, groups = two_groups()
    found, notes = statistics_tables(tables, groups=groups)
    assert notes == []
    table = found["groups"].set_index(["measure", "leg"])
    period = table.loc[("period_s", "L1")]
    assert period["difference"] == pytest.approx(0.05)
    # Welch's t of two samples of four: their standard error is that of OWN, twice
    error = np.sqrt(2 * np.var(OWN, ddof=1) / 4)
    # t(0.975, 6 df) = 2.446912, any table
    assert period["ci_high"] - 0.05 == pytest.approx(2.446912 * error, rel=1e-5)
    assert (period["n_animals_a"], period["n_animals_b"]) == (4, 4)
    phase = found["groups"].loc[found["groups"]["measure"] == "phase"].iloc[0]
    assert (phase["leg"], phase["reference"]) == ("L1", "R1")
    assert phase["difference"] == pytest.approx(0.1, abs=1e-6)
    assert set(found["groups"]["design"]) == {"unpaired"}


@pytest.mark.slow
def test_measures_are_families_and_single_legs_are_follow_ups():
    tables, groups = two_groups()
    table = statistics_tables(tables, groups=groups)[0]["groups"]
    roles = table.set_index("role")
    first = table[table["role"] != "follow-up"]
    assert set(roles.loc["measure", "leg"]) == {"all"}
    assert set(roles.loc["follow-up", "leg"]) == {"L1", "R1"}
    assert roles.loc[["phase"], ["leg", "reference"]].to_numpy().tolist() == [["L1", "R1"]]
    # one comparison a measure: nothing to adjust for
    np.testing.assert_allclose(first["p_adjusted"], first["p"])
    np.testing.assert_allclose(first["p_all_measures"], adjust_p(first["p"].to_numpy()))
    legs = table[(table["role"] == "follow-up") & (table["measure"] == "period_s")]
    assert legs["p_adjusted"].tolist() == pytest.approx(multipletests(legs["p"], method="holm")[1])
    assert legs["p_all_measures"].isna().all()


def noisy_groups(*, effect, seed=3, k=3, legs=("FR", "HR", "FL", "HL")):
    """Strides of k animals a group; of their measures the duty factor alone differs."""
    rng = np.random.default_rng(seed)
    tables, _ = two_groups()
    measures = ["period_s", "frequency_hz", "stance_s", "swing_s", "duty_factor", "stride_length",
                "speed", "step_displacement"]  # fmt: skip
    rows, groups = [], {}
    for group in ("a", "b"):
        for i in range(k):
            animal = f"{group}{i}"
            groups[animal, "t"] = group
            own = dict(zip(measures, rng.normal(1.0, 0.05, len(measures)), strict=True))
            own["duty_factor"] = 0.6 + rng.normal(0, 0.01) + effect * (group == "b")
            rows += [
                {"animal": animal, "trial": "t", "leg": leg, "stride": n, "start_s": float(n)}
                | {name: value + rng.normal(0, 0.004) for name, value in own.items()}
                for leg in legs
                for n in range(5)
            ]
    strides = pd.DataFrame(rows).reindex(columns=tables.strides.columns)
    events = strides[["animal", "trial", "leg"]].assign(event="AEP", time_s=strides["start_s"])
    empty = tables.phases.head(0)
    return dataclasses.replace(tables, strides=strides, phases=empty, events=events), groups


@pytest.mark.slow
def test_a_true_difference_is_not_lost_among_other_measures():
    tables, groups = noisy_groups(effect=0.05)
    table = statistics_tables(tables, groups=groups)[0]["groups"]
    row = table[(table["measure"] == "duty_factor") & (table["role"] == "measure")].iloc[0]
    # Welch's t of the animals' means over legs
    strides = tables.strides.groupby(["animal", "leg"])["duty_factor"].mean()
    means = strides.groupby("animal").mean()
    expected = ttest_ind(means[["b0", "b1", "b2"]], means[["a0", "a1", "a2"]], equal_var=False)
    assert row["p"] == pytest.approx(expected.pvalue)
    assert row["p_adjusted"] == pytest.approx(expected.pvalue)
    assert row["p_adjusted"] < 0.02
    assert row["effect"] > 2.5
    # over all rows, single legs among them, the same difference was lost
    before = adjust_p(table["p"].to_numpy(dtype=float))[row.name]
    assert before > 0.1


@pytest.mark.slow
def test_figure_and_table_of_three_groups_print_the_same_p():
    tables, groups = noisy_groups(effect=0.02, k=6)
    groups = {key: "c" if key[0] in ("b4", "b5", "a5") else g for key, g in groups.items()}
    table = statistics_tables(tables, groups=groups)[0]["groups"]
    rows = table[(table["measure"] == "duty_factor") & (table["role"] == "measure")]
    drawing = next(
        d for d in gait_drawings(tables, groups=groups) if d.name == "estimation_duty_factor"
    )
    drawn, ax = drawing.draw()
    said = " ".join(text.get_text() for one in ax.figure.axes for text in one.texts)
    drawn = drawn[drawn["row"] == "difference"].set_index("group")
    assert list(drawn.index) == ["c", "b"]
    for row in rows[rows["group_a"] == "a"].to_dict("records"):
        for name in ("difference", "ci_low", "ci_high", "effect", "p", "p_adjusted"):
            column = "value" if name == "difference" else name
            assert drawn.loc[row["group_b"], column] == row[name]
        assert f"p {row['p_adjusted']:.3f}" in said
        assert row["p_adjusted"] > row["p"]


@pytest.mark.slow
def test_groups_of_phases_are_adjusted_over_pairs_of_legs():
    tables, groups = two_groups()
    other = tables.phases.assign(
        leg="L2", phase=np.random.default_rng(0).random(len(tables.phases))
    )
    tables = dataclasses.replace(tables, phases=pd.concat([tables.phases, other]))
    table = statistics_tables(tables, groups=groups)[0]["groups"]
    rows = table[table["role"] == "phase"]
    assert rows["p_adjusted"].tolist() == pytest.approx(multipletests(rows["p"], method="holm")[1])
    assert rows["leg"].tolist() == ["L1", "L2"]


def test_conditions_of_the_same_animals_are_paired():
    tables, groups = two_groups(same_animals=True)
    table = statistics_tables(tables, groups=groups)[0]["groups"]
    assert set(table["design"]) == {"paired"}
    period = table[(table["measure"] == "period_s") & (table["leg"] == "R1")].iloc[0]
    # every animal differs by 0.05 s exactly, its own period cancels: nothing can be tested
    assert period["difference"] == pytest.approx(0.05)
    assert np.isnan(period["p"])
    assert period["note"] == "no spread between animals beyond rounding: no interval and no p"


@pytest.mark.slow
def test_trials_without_group_are_left_out_and_one_group_is_not_compared():
    tables, groups = two_groups()
    some = {key: group for key, group in groups.items() if key[0] != "b3"}
    table = statistics_tables(tables, groups=some)[0]["groups"]
    assert table.loc[0, "n_animals_b"] == 3
    alone = {key: group for key, group in groups.items() if group == "a"}
    assert "groups" not in statistics_tables(tables, groups=alone)[0]
    assert "groups" not in statistics_tables(tables)[0]


def test_groups_that_cannot_be_compared_say_so_and_are_no_error():
    tables, _ = two_groups(same_animals=True)
    # m0 in both conditions a and b, nobody in both a and c
    groups = {("m0", "m0-a"): "a", ("m0", "m0-b"): "b", ("m1", "m1-a"): "c"}
    found, notes = statistics_tables(tables, groups=groups)
    assert notes == []
    assert found["groups"]["p"].isna().all()
    own = found["groups"].set_index(["measure", "leg", "group_a", "group_b"])["note"]
    assert own["period_s", "all", "a", "b"] == "one animal in both: no interval and no p"
    assert own["period_s", "all", "a", "c"] == "no animal is in both conditions: not compared"


def test_events_alone_give_no_speed():
    tables, _ = two_groups()
    found, _ = statistics_tables(tables)
    assert set(found) == {"animals", "steadiness", "stride_durations", "legs"}
    period = found["animals"].set_index(["leg", "measure"]).loc[("L1", "period_s")]
    assert period["mean"] == pytest.approx(0.225)
    assert period["n_animals"] == 8
    assert "stride_length" not in set(found["animals"]["measure"])


def test_phases_on_speed_are_those_within_animals():
    tables, _ = two_groups()
    order = tables.strides.groupby(["animal", "leg"]).cumcount()
    strides = tables.strides.assign(speed=100.0 + 10.0 * order)
    # 0.001 cycle for each unit of speed in animals of group a, 0.003 in those of b
    steep = tables.phases["animal"].str.startswith("b")
    place = tables.phases.groupby(["animal", "leg"]).cumcount()
    phases = tables.phases.assign(phase=0.4 + np.where(steep, 0.03, 0.01) * place)
    found, _ = statistics_tables(dataclasses.replace(tables, strides=strides, phases=phases))
    row = found["phase_speed"].iloc[0]
    assert list(found["phase_speed"].columns[:6]) == [
        "leg", "reference", "slope", "ci_low", "ci_high", "n_animals",
    ]  # fmt: skip
    # R 4.2.2: t.test(rep(c(.001, .003), each = 4)): 0.001106256 0.002893744
    expected = [0.002, 0.001106256, 0.002893744]
    assert row[["slope", "ci_low", "ci_high"]].tolist() == pytest.approx(expected, rel=1e-5)
    assert (row["n_animals"], row["unit"]) == (8, "cycle/(unit of the tracks/s)")


def test_nothing_at_all_gives_no_table():
    tables, _ = two_groups()
    empty = dataclasses.replace(tables, strides=tables.strides.head(0))
    assert statistics_tables(empty) == ({}, [])


@pytest.mark.slow
def test_the_command_writes_them(tmp_path):
    study = simulate_spider_study(animals=4, trials=1, seed=2)
    paths = []
    for k, run in enumerate(study.runs):
        animal = dataclasses.replace(run.trial.animal, group="first" if k < 2 else "second")
        trial = dataclasses.replace(run.trial, animal=animal)
        folder = tmp_path / f"run{k}"
        folder.mkdir()
        tracks = run.tracks(noise_px=0.2, angle_noise_deg=0.0)
        write_tracks(describe_trial(tracks, trial), folder / "tracks.nc")
        paths.append(folder)
    out = tmp_path / "all"
    run = run_gait(paths, out=out, figures="none")
    written = {path.name for path in run.files}
    names = (
        "animals", "steadiness", "against_speed", "phase_speed", "joint_ranges", "groups",
    )  # fmt: skip
    assert {f"{name}.csv" for name in names} <= written
    assert all((out / name).is_file() for name in written)
    against = pd.read_csv(out / "against_speed.csv")
    # the rows of Pullar's (2009) Table 4.5: protraction and retraction also against frequency
    assert set(against["predictor"]) == {"speed", "speed_bl", "frequency_hz"}
    on_frequency = against[against["predictor"] == "frequency_hz"]
    assert on_frequency["outcome"].tolist() == ["swing_s", "stance_s"]
    slopes_of = against.set_index(["outcome", "predictor"])["b"]
    # S = n / 4 duty - 3 / 4 (its appendix A), with eight legs
    np.testing.assert_allclose(
        slopes_of["wave_gait_margin"], 2.0 * slopes_of["duty_factor"], rtol=1e-9
    )
    assert set(against["n_animals"]) == {4}
    slopes = pd.read_csv(out / "phase_speed.csv")
    assert len(slopes) == len(pd.read_csv(out / "phase_summary.csv"))
    assert set(slopes["unit"]) == {"cycle/(mm/s)"}
    ranges = pd.read_csv(out / "joint_ranges.csv", dtype={"pair": str})
    true = study.true_angles()
    knee = true[(true["joint"] == "TM") & true["leg"].isin(["L2", "R2"])]
    each = knee.groupby(["animal", "leg"])["angle_deg"].agg(np.ptp).mean()
    own = ranges[(ranges["joint"] == "TM") & (ranges["pair"] == "2")].iloc[0]
    assert own["range_mean_deg"] == pytest.approx(each, abs=0.1)  # smoothed, though without noise
    assert own["n_animals"] == 4
    groups = pd.read_csv(out / "groups.csv")
    assert set(groups["group_a"]) == {"first"}
    assert set(groups["n_animals_b"]) == {2}


def test_angles_take_the_name_of_the_trials_animal():
    run = simulate_spider_study(animals=1, trials=1).runs[0]
    angles = joint_angles_of([(run.tracks(), "nora", "t1")])
    assert set(angles["animal"]) == {"nora"}
    assert set(angles["trial"]) == {"t1"}
    assert joint_angles_of([(run.tracks().drop_vars("joint_angle"), None, "t1")]) is None


def test_ranges_of_angles_that_were_not_smoothed_are_not_too_wide():
    """The extremes of noise are no movement: Pullar (2009, section 3.5) smooths first."""
    run = simulate_spider_study(animals=1, trials=1).runs[0]
    noisy = run.tracks(angle_noise_deg=1.0)
    found = joint_range_table(joint_angles_of([(noisy, None, "t1")]))
    plain = joint_range_table(get_joint_angles(noisy))
    true = joint_range_table(get_joint_angles(run.tracks(angle_noise_deg=0.0)))
    wide = found["range_mean_deg"] - true["range_mean_deg"]
    assert (plain["range_mean_deg"] - true["range_mean_deg"]).mean() > 2.0
    assert abs(wide.mean()) < 0.7
    # a tracker that tells its uncertainty has smoothed already
    smooth = noisy.assign(sd=noisy["position"])
    pd.testing.assert_frame_equal(joint_range_table(joint_angles_of([(smooth, None, "t1")])), plain)


def test_legs_are_compared_over_animals():
    tables, _ = two_groups()
    found, _ = statistics_tables(tables)
    row = found["legs"].set_index("measure").loc["period_s"]
    assert (row["legs"], row["n_animals"]) == ("L1 R1", 8)
    # both legs of an animal have one period: see events_of
    assert "the legs differ by the same in every animal" in row["note"]
    assert set(found["stride_durations"]["n_animals"]) == {1}
    assert len(found["stride_durations"]) == 8
    one = gait.analyse_events(events_of("m", "t", 0.2))
    assert "legs" not in statistics_tables(one)[0]


def test_body_angles_of_the_trials_that_name_a_body():
    """Nose 30 degrees to the left of the tail and 45 up; the left ear level with the right one."""
    names = ["tail", "nose", "ear_L", "ear_R"]
    tracks = make_tracks([4, 5], names, fps=250.0, unit="mm")
    nose = np.array([np.cos(np.pi / 6), np.sin(np.pi / 6), 1.0])
    left = np.array([-nose[1], nose[0], 0.0])
    for k, place in enumerate([np.zeros(3), nose, left, -left]):
        tracks["position"][:, :, k, 0] = place
    named = Animal(id="m1", body=("tail", "nose"), across=("ear_L", "ear_R"))
    trial = Trial(kind="tracks", name="t", fps=250.0, animal=named)
    plain = dataclasses.replace(trial, animal=Animal(id="m2"))
    found = body_angles_of([(tracks, plain), (tracks, trial), (tracks, None)])
    assert found[["animal", "trial", "frame"]].to_numpy().tolist() == [
        ["m1", "t", 4],
        ["m1", "t", 5],
    ]
    angles = found[["roll_deg", "pitch_deg", "yaw_deg"]]
    np.testing.assert_allclose(angles, [[0.0, 45.0, 30.0]] * 2, atol=1e-9)
    assert body_angles_of([(tracks, plain)]).empty


def test_a_belt_of_one_speed_is_no_axis_to_fit_on():
    """Means of so many strides at 300 differ in their last digit: no reason to refuse the gait."""
    tables, _ = two_groups()
    order = tables.strides.groupby(["animal", "trial"]).ngroup()
    strides = tables.strides.assign(speed=300.0 + 1e-13 * order)
    assert strides["speed"].nunique() > 2
    found, notes = statistics_tables(dataclasses.replace(tables, strides=strides))
    assert "against_speed" not in found
    assert notes == []
    assert "animals" in found
