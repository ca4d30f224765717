"""Wings painted on a walking spider are found, its legs are not, and what hides a leg hides it."""

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1]))
from painted_walk import PaintedReader, painted_walk, walking_poses

from pawnb.core.frame_checkpoint import KeptFrames
from pawnb.core.pose.fit.candidates.candidate_sets import only_candidate
from pawnb.core.pose.fit.layout import pose_vectors
from pawnb.core.pose.fit.learning.attached_clutter import find_attached_clutter
from pawnb.core.pose.fit.learning.clutter import Clutter
from pawnb.core.pose.fit.learning.pose_prior import learn_pose_prior
from pawnb.core.pose.fit.observation import evidence_of, near_body, observe
from pawnb.core.pose.fit.prepare import prepare_fitter
from pawnb.core.pose.fit.settings import PoseSettings
from pawnb.core.pose.fit.tracker import track_pose
from pawnb.core.pose.poses import tip_positions
from pawnb.core.pose.species_file import load_species

N = 30
WING = (-26.0, 14.0, 30.0, 9.0)
"""Of each wing: middle backwards and to the side, half length and half width, px."""


def on_wings(pose, shape):
    """Return where the wings of a pose vector lie: bool, (H, W)."""
    v, u = np.mgrid[: shape[0], : shape[1]]
    du, dv = u - pose[0], v - pose[1]
    x = du * np.cos(pose[2]) + dv * np.sin(pose[2]) - WING[0]
    y = np.abs(-du * np.sin(pose[2]) + dv * np.cos(pose[2])) - WING[1]
    return (x / WING[2]) ** 2 + (y / WING[3]) ** 2 < 1


def recording(poses=None, *, winged):
    """Return an animal, its poses, and a reader of its frames and the background."""
    animal, poses, reader, background = painted_walk(N, poses=poses)
    vectors = pose_vectors(animal, poses)
    images = reader.images
    if winged:  # opaque, as a fly's are where the light comes from above
        wing = np.uint8(0.6 * background.mean)
        images = [
            np.where(on_wings(pose, image.shape), wing, image)
            for pose, image in zip(vectors, images, strict=True)
        ]
    return animal, poses, PaintedReader(images), background


def walk(poses=None, *, winged):
    """Return a fitter, what each frame leaves open, and the true pose vectors."""
    animal, poses, reader, background = recording(poses, winged=winged)
    vectors = pose_vectors(animal, poses)
    fitter, _ = prepare_fitter(
        reader.frame(0), poses.at_frame(0), animal=animal, background=background,
        settings=PoseSettings(),
    )  # fmt: skip
    found = []
    for t, pose in enumerate(vectors):
        _, image, box = observe(fitter, reader.frame(t), pose)
        found.append(only_candidate(fitter, t, pose, image=image, box=box))
    return fitter, found, vectors


@pytest.fixture(scope="module")
def winged():
    return walk(winged=True)


def still_poses():
    """Return poses of an animal that is carried along, all its legs held still."""
    poses = walking_poses(load_species("dolomedes"), N)
    poses.angles_deg[:] = poses.angles_deg[0]
    poses.lengths_px[:] = poses.lengths_px[0]
    return poses


@pytest.mark.parametrize("moving", [True, False])
def test_wings_are_found_and_legs_are_not(winged, moving):
    fitter, found, vectors = winged if moving else walk(still_poses(), winged=True)
    attached_clutter = find_attached_clutter(fitter, found, vectors)
    half = len(attached_clutter) // 2
    pose = np.array([half, half, 0.0])
    wings = on_wings(pose, attached_clutter.shape)
    assert np.mean(attached_clutter[wings]) > 0.95
    assert np.mean(wings[attached_clutter]) > 0.3  # the rest is the body
    tips = [joints[0, :8] for joints in found[0].joints]
    for chain in tips:
        ahead = chain - vectors[0, :2]
        cos, sin = np.cos(vectors[0, 2]), np.sin(vectors[0, 2])
        x, y = ahead[:, 0] * cos + ahead[:, 1] * sin, -ahead[:, 0] * sin + ahead[:, 1] * cos
        outer = np.round(np.column_stack([x, y])[-3:]).astype(int) + half
        far = [not wings[b - 6 : b + 7, a - 6 : a + 7].any() for a, b in outer]
        assert not attached_clutter[outer[:, 1], outer[:, 0]][far].any()


def test_without_wings_nothing_is_found(winged):
    fitter, found, vectors = walk(winged=False)
    assert find_attached_clutter(fitter, found, vectors) is None
    assert (
        find_attached_clutter(winged[0], winged[1][:10], winged[2][:10]) is None
    )  # too few frames


def test_what_is_fixed_hides_legs(winged):
    fitter, found, vectors = winged
    attached = Clutter(attached=find_attached_clutter(fitter, found, vectors))
    fitter = fitter.with_clutter(attached)
    image_evidence = evidence_of(fitter, vectors[5], image=found[5].grey, box=found[5].box)
    # the wings in the crop, without their edge
    place = vectors[5] - np.concatenate([found[5].box[:2], np.zeros(len(vectors[5]) - 2)])
    wings = on_wings(place, image_evidence.seen.shape)
    body = near_body(fitter, vectors[5], image_evidence)
    hidden = image_evidence.weight == 0
    assert np.mean(hidden[wings & ~body]) > 0.9  # edges are rounded to pixels
    assert not hidden[body].any()
    assert (image_evidence.seen[hidden] == 0).all()


def test_habits_are_those_of_legs_that_are_well_seen():
    fitter, found, vectors = walk(winged=False)
    front, second = fitter.index.numbers[0], fitter.index.numbers[1]
    partner = fitter.animal.leg_names.index("R1")
    wrong = vectors.copy()
    for numbers in (front, fitter.index.numbers[partner]):
        wrong[:, numbers[0]] += 0.7  # beside the leg: nothing is seen of it there
    learnt = learn_pose_prior(fitter, found, wrong)
    assert (learnt.anatomy.middle[front] == fitter.anatomy.middle[front]).all()
    assert not len(learnt.usual_poses[0])
    sides = [fitter.animal.leg_names.index(name) for name in ("L2", "R2")]
    own = np.concatenate([vectors[:, fitter.index.numbers[i]] for i in sides])
    # not in every frame is each leg well seen
    assert np.abs(learnt.anatomy.middle[second] - np.median(own, axis=0)).max() < 0.12
    usual = learnt.usual_poses[1]
    assert len(usual) == 10
    assert len(np.unique(usual.round(6), axis=0)) == 10
    assert (usual > own.min(axis=0) - 1e-9).all()
    assert (usual < own.max(axis=0) + 1e-9).all()
    assert np.ptp(usual[:, 0]) > 0.8 * np.ptp(own[:, 0])


@pytest.mark.slow
def test_an_animal_with_wings_is_followed_twice_and_goes_on_after_an_interruption(tmp_path):
    animal, poses, reader, background = recording(winged=True)
    ways, done = [], []

    def tracked(kept, stop=None):
        return track_pose(
            reader, poses.at_frame(0), animal=animal, background=background, frames=(0, N),
            kept=kept, stop=stop, progress=lambda i, n: done.append((i, n)),
        )  # fmt: skip

    class Told(KeptFrames):
        def keep(self, way, frame, found):
            ways.append((way, frame))
            super().keep(way, frame, found)

    whole = tracked(Told())
    assert ways == [("from 0", i) for i in range(N)] + [("again from 0", i) for i in range(N)]
    assert done[-1] == (3 * N, 3 * N)
    assert (
        np.median(np.hypot(*(tip_positions(animal, whole.poses) - tip_positions(animal, poses)).T))
        < 1.0
    )
    ways.clear()
    with Told(tmp_path / "kept.bin", depends_on="this") as kept:
        tracked(kept, stop=lambda: len(ways) >= N + N // 2)
    interrupted = len(ways)
    assert N < interrupted < 2 * N
    with Told(tmp_path / "kept.bin", depends_on="this") as kept:
        later = tracked(kept)
    assert len(ways) == 2 * N
    np.testing.assert_array_equal(later.poses.angles_deg, whole.poses.angles_deg)
