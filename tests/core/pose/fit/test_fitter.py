"""The start frame tells its blur, a body is found where it leapt to, hidden legs are not seen."""

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))
from painted_walk import painted_walk

from pawnb.core.pose.fit.prepare import prepare_fitter
from pawnb.core.pose.fit.sequence.first_frame import fit_start
from pawnb.core.pose.fit.settings import PoseSettings
from pawnb.core.pose.fit.support import leg_supports


@pytest.fixture(scope="module")
def started():
    animal, poses, reader, background = painted_walk(8)
    start = poses.at_frame(0)
    frame = reader.frame(0)
    fitter, vector = prepare_fitter(
        frame, start, animal=animal, background=background, settings=PoseSettings(blur_px=1.3)
    )
    pose, _ = fit_start(fitter, frame, vector)
    return fitter, pose, reader, animal


def test_blur_is_learnt_in_the_start_frame(started):
    fitter = started[0]
    # painted_walk paints with a half width of 1.8 px; the settings said 2.9; steps are of 15 %
    assert 1.8 * 0.8 < fitter.blur < 1.8 * 1.2


def test_a_body_that_leapt_is_found(started):
    fitter, pose, reader, _ = started
    for leap in ((12.0, 0.0), (-6.0, 9.0)):
        astray = pose.copy()
        astray[:2] += leap
        astray[2] += 0.15
        image_evidence, _, _ = fitter.look(reader.frame(0), astray, margin=np.inf)
        found = fitter.body_found(astray, image_evidence)
        assert np.hypot(*(found[:2] - pose[:2])) < 1.5
        assert abs(found[2] - pose[2]) < 0.05


def test_a_leg_on_the_body_has_no_support(started):
    fitter, pose, reader, _ = started
    image_evidence, _, _ = fitter.look(reader.frame(0), pose)
    assert (leg_supports(fitter, pose, image_evidence) > 0.8).all()
    folded = pose.copy()
    angles, lengths = np.split(fitter.numbers[1], 2)
    folded[angles] = [np.pi, 0.0, 0.0, 0.0, 0.0][: len(angles)]  # across the body
    folded[lengths] = -2.0
    assert np.isnan(leg_supports(fitter, folded, image_evidence)[1, 0])
