"""A leg that was laid along a longer one for some frames is put back by the frames around."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest
from painted_walk import PX_PER_MM, painted_walk

from pawnb.core.pose.fit.candidates.candidate_sets import only_candidate
from pawnb.core.pose.fit.fitter import make_fitter
from pawnb.core.pose.fit.layout import make_layout, pose_vectors
from pawnb.core.pose.fit.learning.anatomy import anatomy
from pawnb.core.pose.fit.observation import crop_box
from pawnb.core.pose.fit.rendering.evidence import make_evidence
from pawnb.core.pose.fit.sequence import final_fit
from pawnb.core.pose.fit.sequence.final_fit import fit_all_frames
from pawnb.core.pose.fit.settings import PoseSettings

LEG, OTHER = 1, 2
MET = slice(12, 15)
"""Frames in which the short leg's tip lies on the longer leg."""


@pytest.fixture(scope="module")
def scene():
    """Return a fitter, the true pose vectors and the frames, in which leg 1 passes over leg 2."""
    animal, poses, _, _ = painted_walk(22)
    t = np.arange(22.0)
    angles, lengths = poses.angles_deg.copy(), poses.lengths_px.copy()
    for leg, turn, shorter in ((LEG, -3.0 * (t - 10.5) - 28.0, 0.75), (OTHER, 0.0 * t, 1.0)):
        angles[:, 5 * leg : 5 * leg + 5] = animal.natural_deg[5 * leg : 5 * leg + 5]
        angles[:, 5 * leg] += turn
        flat = shorter * animal.lengths[7 * leg : 7 * leg + 7] * PX_PER_MM
        lengths[:, 7 * leg : 7 * leg + 7] = flat
    poses = dataclasses.replace(poses, angles_deg=angles, lengths_px=lengths)
    _, _, reader, background = painted_walk(22, poses=poses)
    vectors = pose_vectors(animal, poses)
    settings = PoseSettings()
    evidence = make_evidence(background, factor=1, light=0.0, spread=settings.unexplained_sd)
    fitter = make_fitter(
        animal,
        make_layout(animal, px_per_unit=PX_PER_MM, dark=0.75),
        evidence=evidence,
        anatomy=anatomy(animal, vectors[0], foreshortening_sd=settings.foreshortening_sd),
        settings=settings,
    )
    found = []
    for i, vector in enumerate(vectors):
        box = crop_box(fitter, vector)
        image = evidence.pixels(reader.frame(i), box)
        found.append(only_candidate(fitter, i, vector, image=image, box=box))
    return fitter, vectors, found


def tips(fitter, vectors):
    return np.array([fitter.joints(v)[:, -1] for v in vectors])


@pytest.mark.slow
def test_a_leg_laid_along_a_longer_one_comes_back(scene):
    fitter, true, found = scene
    path, lengths = true.copy(), fitter.index.numbers[LEG][5:]
    for t in range(MET.start, MET.stop):
        path[t, lengths] = -0.02
        reach = fitter.joints(true[t])[OTHER, -1] - fitter.joints(true[t])[LEG, 0]
        along = fitter.joints(path[t])[LEG, -1] - fitter.joints(true[t])[LEG, 0]
        turn = np.arctan2(*reach[::-1]) - np.arctan2(*along[::-1])
        path[t, fitter.index.numbers[LEG][0]] -= fitter.layout.side[LEG] * turn
    before = np.hypot(*(tips(fitter, path) - tips(fitter, true))[MET, LEG].T)
    assert before.min() > 8.0
    final_fits = fit_all_frames(fitter, found, path)
    away = tips(fitter, [s.pose for s in final_fits]) - tips(fitter, true)
    assert np.hypot(*away[MET, LEG].T).max() < 3.0
    # all others stay where they are seen
    assert np.median(np.hypot(*away[2:-2].T)) < 0.3
    assert np.hypot(*away[2:-2, OTHER].T).max() < 2.0
    # and it is said that the end under the other leg is less sure
    sd = np.array([np.hypot(*s.places_sd[LEG, -1]) for s in final_fits])
    assert sd[MET].max() > 1.05 * np.median(sd)


def test_frames_apart_do_not_touch_each_other(scene):
    fitter, true, found = scene
    one = fit_all_frames(fitter, found[:8], true[:8])
    both = fit_all_frames(fitter, found[:8] + found[14:], np.concatenate([true[:8], true[14:]]))
    assert len(both) == 16
    # the learnt motion alone differs
    np.testing.assert_allclose([s.pose for s in both[:8]], [s.pose for s in one], atol=0.1)


def test_nothing_to_settle(scene):
    assert fit_all_frames(scene[0], [], np.empty((0, scene[0].index.n))) == []


def test_what_a_frame_would_gain_is_that_of_two_parabolas(monkeypatch):
    """Its own cost x**2 and the others' (x - 1)**2: 1 at 0, and 0.5 at the best place, 0.5."""
    one = SimpleNamespace(pose=np.zeros(1), precision=np.full((1, 1), 2.0), slope=np.zeros(1))
    said = np.ones((1, 1)), np.full((1, 1, 1), 2.0)
    monkeypatch.setattr(final_fit, "motion_messages", lambda *_: said)
    fitter = SimpleNamespace(index=SimpleNamespace(numbers=[np.array([0])], n=1))
    others = final_fit._from_others(fitter, [one], [np.zeros(1)], [np.array([0])])
    assert others.gain == pytest.approx([0.5])
    assert others.around[0, 0] == 1.0
