"""Strides nested in animals, on real cycles scored by hand; contact on a real fly."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from pawnb.gait import analyse
from pawnb.gait.events.contacts import contact_agreement
from pawnb.gait.groups import compare_groups
from pawnb.gait.regression.mixed import fit_mixed
from pawnb.io.formats import read_any_tracks
from pawnb.schema import ORIGIN_CODE, make_tracks


@pytest.fixture
def cycles(real_data):
    """160 cycles of 20 mice; two blocks of rows that are no contrast, used as arithmetic only."""
    table = pd.read_csv(
        real_data("mouse-autogaita-beam") / "annotation_tidy.csv", dtype={"mouse": str}
    )
    block = table["genotype"].notna().map({True: "second", False: "first"})
    return table.rename(columns={"mouse": "animal"}).assign(group=block)


def test_animals_not_cycles_in_a_comparison_of_groups(cycles):
    # computed by the data set's curator: Welch's t on animals' means and on cycles
    found = compare_groups(cycles, ["duty"]).iloc[0]
    assert (found["n_animals_a"], found["n_animals_b"]) == (11, 9)
    assert (found["n_a"], found["n_b"]) == (77, 83)
    assert found["p"] == pytest.approx(0.003469, abs=1e-6)
    assert found["method"] == "Welch's t, 15.6 df"
    assert found["p_strides"] == pytest.approx(1.68e-5, rel=0.01)
    moved = cycles.assign(duty=cycles["duty"] + 0.01 * (cycles["group"] == "second"))
    assert compare_groups(moved, ["duty"]).iloc[0]["p"] != pytest.approx(0.003469, abs=1e-4)


def test_mixed_model_and_intraclass_correlation(cycles):
    # the curator's mixed model, duty ~ group + (1 | mouse), REML in statsmodels
    table = cycles.assign(second=(cycles["group"] == "second").astype(float))
    found = fit_mixed(table, "duty", ["second"])
    slope = found.terms.set_index("term").loc["second"]
    assert slope["estimate"] == pytest.approx(-0.064309, abs=1e-6)
    assert found.icc == pytest.approx(0.1977, abs=1e-4)
    # its p by a normal distribution, 0.0018; here degrees of freedom count animals, so larger
    assert 0.0018 < slope["p"] < 0.01


@pytest.mark.slow
def test_contact_told_from_positions_agrees_with_the_hand_on_a_fly(real_data):
    """A fly on a ball at 100 frames per second: events from the claws against contact by hand."""
    folder = real_data("fly-6leg-contact")
    pose = pd.read_csv(folder / "fly1_pose_aligned.csv")
    contacts = pd.read_csv(folder / "ground_truth_contact_fly1.csv")
    legs = ["LF", "LM", "LH", "RF", "RM", "RH"]
    tracks = make_tracks(pose["frame"], legs, fps=100.0, unit="mm")
    for k, leg in enumerate(legs):
        tracks["position"][:, :, k, 0] = pose[[f"{leg}_Claw_{a}" for a in "xyz"]].to_numpy()
    tracks["origin"][:] = ORIGIN_CODE["measured"]
    tracks["confidence"][:] = 1.0
    tables = analyse(tracks, settings={"substrate": "treadmill"})
    found = contact_agreement(tables.events, contacts, fps=100.0).set_index("leg")
    # measured 0.88-0.93 and 0.69-0.84; half of what disagrees is one frame next to a change
    assert (found["agreement"] > 0.87).all()
    assert (found["kappa"] > 0.65).all()
    assert (found["agreement_one_frame"] > 0.95).all()
    assert found[["td_shift_s", "lo_shift_s"]].abs().max(axis=None) < 0.0125  # a frame is 0.01
    np.testing.assert_allclose(found["duty_found"], found["duty_by_hand"], atol=0.07)
    assert found[["td_missed", "lo_missed"]].sum(axis=None) <= 0.1 * 2 * found["n_td"].sum()
    assert found[["td_extra", "lo_extra"]].sum(axis=None) <= 0.1 * 2 * found["n_td"].sum()


@pytest.mark.parametrize(("mouse", "run"), [("14", 3), ("15", 3), ("16", 18), ("17", 3)])
def test_swings_scored_by_hand_are_found_in_mice_on_a_beam(real_data, mouse, run):
    """Hind paws of DeepLabCut at 100 frames per second, swings scored by hand.

    The run of a fifth mouse (18) is left out: its paw stands still in the swings of the table
    and moves in the stances, and fits best 0.20 s later, so the table is of another stretch.
    """
    folder = real_data("mouse-autogaita-beam")
    (path,) = folder.glob(f"PCCD3_Mouse{mouse}_25mm_run{run}-6DLC_resnet50_SIMINew*.csv")
    tracks = read_any_tracks(path, fps=100.0)
    points = {str(p).strip(): str(p) for p in tracks["keypoint"].to_numpy()}
    legs = {"HR": points["Hind paw tao"], "FR": points["Front paw tao"]}
    events = analyse(tracks, legs=legs).events.query("leg == 'HR'")
    hand = pd.read_csv(folder / "annotation_tidy.csv", dtype={"mouse": str, "run": str})
    hand = hand[(hand["mouse"] == mouse) & (hand["run"] == str(run))]
    assert len(hand) in (3, 4)
    for event, column in (("LO", "swing_start_s"), ("TD", "swing_end_s")):
        times = events.loc[events["event"] == event, "time_s"].to_numpy()
        # the table's first frame is 1: the paw's speed fits its swings best one frame earlier
        scored = hand[column].to_numpy() - 0.01
        shift = np.array([times[np.argmin(np.abs(times - t))] - t for t in scored])
        assert abs(np.median(shift)) < 0.02  # two frames
        # one swing of 0.27 s by hand, twice as long as any other, holds a stop
        assert np.sort(np.abs(shift))[:-1].max() < 0.03
