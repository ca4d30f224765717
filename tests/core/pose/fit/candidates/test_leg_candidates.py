"""Of candidates on the same limb, the one that costs least is kept, whichever came first."""

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1]))
from painted_walk import painted_walk

from pawnb.core.pose.fit.candidates.candidate_sets import only_candidate
from pawnb.core.pose.fit.candidates.leg_candidates import with_candidates
from pawnb.core.pose.fit.candidates.weighing import side_energy
from pawnb.core.pose.fit.layout import leg_numbers
from pawnb.core.pose.fit.observation import observe
from pawnb.core.pose.fit.prepare import prepare_fitter
from pawnb.core.pose.fit.sequence.first_frame import first_darkness
from pawnb.core.pose.fit.settings import PoseSettings

LEG = 0


@pytest.fixture(scope="module")
def seen():
    animal, poses, reader, background = painted_walk(2)
    frame = reader.frame(0)
    fitter, pose = prepare_fitter(
        frame, poses.at_frame(0), animal=animal, background=background, settings=PoseSettings()
    )
    fitter = fitter.with_appearance(first_darkness(fitter, frame, pose))
    image_evidence, image, box = observe(fitter, frame, pose)
    return fitter, pose, image_evidence, image, box


@pytest.mark.parametrize("true_one_first", [True, False])
def test_joints_at_odd_places_along_a_limb_do_not_keep_the_better_pose_out(seen, true_one_first):
    fitter, pose, image_evidence, image, box = seen
    numbers = fitter.index.numbers[LEG]
    true = pose[numbers]
    odd = true.copy()
    n = len(numbers) // 2
    # one link much shorter and the next longer: nearly the same line, but not this animal's leg
    odd[n + 2 : n + 4] += [-0.22, 0.22]
    elsewhere = pose.copy()
    elsewhere[numbers[0]] += 0.6
    candidates = only_candidate(fitter, 0, elsewhere, image=image, box=box)
    for offered in [true, odd] if true_one_first else [odd, true]:
        candidates = with_candidates(
            fitter,
            candidates,
            {LEG: [offered]},
            image_evidence=image_evidence,
            prior=fitter.anatomy,
        )
    np.testing.assert_array_equal(candidates.legs[LEG], [elsewhere[numbers], true])


def test_a_leg_gains_nothing_on_the_limb_of_one_of_the_other_side(seen):
    fitter, pose, image_evidence, image, box = seen
    left, right = (fitter.animal.leg_names.index(name) for name in ("L1", "R1"))
    joints = fitter.joints(pose)
    across = joints[right].copy()
    across[0] = joints[left, 0]
    on_other = leg_numbers(fitter.layout, left, across, heading=float(pose[2]))
    alone = only_candidate(fitter, 0, pose, image=image, box=box)
    candidates = with_candidates(
        fitter, alone, {left: [on_other]}, image_evidence=image_evidence, prior=fitter.anatomy
    )
    assert not alone.is_open  # the frame given is not changed
    assert candidates.is_open
    unaware = side_energy(candidates, [left], 1.0, others={})
    aware = side_energy(candidates, [left], 1.0, others={right: 0})
    np.testing.assert_allclose(aware[0], unaware[0], atol=1.0)  # its own limb is its own
    gained = candidates.worth[left][1]
    assert gained < 0.4 * candidates.worth[right].min() < 0.0
    assert aware[1] - unaware[1] > 0.8 * abs(gained)
