"""Strides nested in animals, on real cycles scored by hand; contact on a real fly."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from pawnb.gait import analyse
from pawnb.gait.contacts import contact_agreement
from pawnb.gait.groups import compare_groups
from pawnb.gait.mixed import fit_mixed
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
    agreement = contact_agreement(tables.events, contacts, fps=100.0, start="AEP", end="PEP")
    agreement = agreement.set_index("leg")
    # the hind left leg's contact by hand has long gaps, says the data set
    good = agreement.drop(index="LH")
    assert (good["agreement"] > 0.75).all()
    assert good["kappa"].median() > 0.4
    assert good["td_shift_s"].abs().median() <= 0.02  # two frames
    np.testing.assert_allclose(good["duty_found"], good["duty_by_hand"], atol=0.2)
