"""Painting: joints as joint_positions has them, and slopes as finite differences give them."""

import numpy as np
import pytest

from pawnb.core.pose.fit.layout import make_layout, pose_vectors, poses_of_vectors
from pawnb.core.pose.fit.rendering import normal_equation_kernels
from pawnb.core.pose.fit.rendering import paint_kernels as loops
from pawnb.core.pose.poses import joint_positions, natural_pose
from pawnb.core.pose.species_file import load_species

BLUR = 2.0


def bent(species: str, seed: int = 0):
    animal = load_species(species)
    scale = 150.0 / animal.span
    layout = make_layout(animal, px_per_unit=scale, dark=0.8)
    layout.ellipse[:-1, 5] = 0.15
    layout.ellipse[-1, 3] *= 2.0  # a waist wider than its blur: distances are of first order
    pose = pose_vectors(
        animal, natural_pose(animal, xy=(90.3, 89.2), heading_deg=30.0, scale=scale)
    )[0]
    pose[3:] += np.random.default_rng(seed).normal(0, 0.1, len(pose) - 3)
    return animal, layout, pose, scale


@pytest.mark.parametrize("species", ["dolomedes", "spider", "insect"])
def test_vectors_and_poses_are_inverse_and_joints_agree(species):
    animal, layout, pose, scale = bent(species)
    poses = poses_of_vectors(animal, pose[None], frames=np.array([0]), scale=scale, factor=2)
    np.testing.assert_allclose(pose_vectors(animal, poses, factor=2)[0][:2], pose[:2])
    poses = poses_of_vectors(animal, pose[None], frames=np.array([0]), scale=scale)
    np.testing.assert_allclose(pose_vectors(animal, poses)[0], pose, atol=1e-12)
    canvas = loops.make_canvas(180, 180, layout)
    loops.paint(layout, pose, BLUR, np.zeros(2), *canvas)
    np.testing.assert_allclose(canvas[3], joint_positions(animal, poses)[0], atol=1e-9)


def test_a_wide_limb_is_as_dark_as_told_inside_and_clear_outside():
    _, layout, pose, _ = bent("dolomedes")
    canvas = loops.make_canvas(180, 180, layout)
    loops.paint(layout, pose, BLUR, np.zeros(2), *canvas)
    femur = canvas[3][0, 2:4].mean(axis=0).round().astype(int)
    s, t = 2, 0.5
    expected = layout.dark[0, s] * (1 - t) + layout.dark[0, s + 1] * t
    assert canvas[0][femur[1], femur[0]] == pytest.approx(expected, rel=0.02)
    assert canvas[0][2, 2] == 0.0
    assert canvas[1][2, 2] == loops.NOTHING


@pytest.mark.parametrize("tip", [120.0, 120.3, 120.5, 120.9])
def test_a_leg_ends_at_its_tip(tip):
    _, layout, _, _ = bent("dolomedes")
    layout.dark[:], layout.radius[:] = 0.8, 3.0
    value, owner, along, joints = loops.make_canvas(100, 180, layout)
    joints[0, :, 0], joints[0, :, 1] = np.linspace(30.0, tip, joints.shape[1]), 50.0
    loops.paint_leg(layout, joints[0], 0, BLUR, np.zeros(2), value, owner, along)
    # a band that ends at the tip holds, blurred or not, so much darkness from pixel 60 on
    assert value[50, 60:].sum() == pytest.approx(0.8 * (tip - 59.5), abs=0.02)
    assert value[50, round(tip + BLUR) + 1 :].max() == 0.0


def slopes(layout, pose):
    """The analytic change of every pixel with every number of the pose."""
    value, owner, along, joints = loops.make_canvas(180, 180, layout)
    loops.paint(layout, pose, BLUR, np.zeros(2), value, owner, along, joints)
    out = np.zeros((180, 180, len(pose)))
    row, which, pull = np.zeros(64), np.zeros(64, np.int64), np.zeros(4)
    turned = float(np.cos(pose[2])), float(np.sin(pose[2]))
    for v, u in zip(*np.nonzero(owner != loops.NOTHING), strict=True):
        piece = owner[v, u]
        if piece < 0:
            if loops.body_slope(layout, pose, -2 - piece, BLUR, float(u), float(v), *turned, row):
                out[v, u, :3] = row[:3]
            continue
        leg, s = piece // 64, piece % 64
        at = (layout, joints[leg], leg, s, along[v, u], BLUR, float(u), float(v))
        if loops.leg_pull(*at, pull):
            n = loops.leg_slope(layout, pose, joints[leg], leg, s, pull, row, which)
            assert (np.diff(which[:n]) > 0).all()
            out[v, u, which[:n]] = row[:n]
    return out


@pytest.mark.slow
@pytest.mark.parametrize("species", ["dolomedes", "insect"])
def test_slopes_agree_with_finite_differences(species):
    _, layout, pose, _ = bent(species)
    analytic = slopes(layout, pose)
    canvas = loops.make_canvas(180, 180, layout)
    step = 1e-5
    for k in range(len(pose)):
        pictures = []
        for sign in (1, -1):
            moved = pose.copy()
            moved[k] += sign * step
            loops.paint(layout, moved, BLUR, np.zeros(2), *canvas)
            pictures.append(canvas[0].copy())
        numeric = (pictures[0] - pictures[1]) / (2 * step)
        changed = np.abs(numeric) > 0
        # the rounding of the projection at tapered ends and the first-order distance to an
        # ellipse leave a few percent
        error = np.abs(analytic[..., k] - numeric)[changed]
        assert np.percentile(error, 95) < 0.05 * np.abs(numeric).max()
        assert np.abs(analytic[..., k] - numeric).max() < 0.25 * np.abs(numeric).max()


@pytest.mark.slow
@pytest.mark.parametrize("still", [[], [1, 3, -1]], ids=["all move", "some do not"])
@pytest.mark.parametrize("species", ["dolomedes", "insect"])
def test_equations_are_the_sums_over_pixels_of_their_slopes(species, still):
    _, layout, pose, _ = bent(species)
    moves = np.ones(len(layout.side) + 1, bool)
    moves[still] = False
    value, owner, along, joints = loops.make_canvas(180, 180, layout)
    loops.paint(layout, pose, BLUR, np.zeros(2), value, owner, along, joints)
    rng = np.random.default_rng(3)
    seen = value + rng.normal(0.0, 0.3, value.shape)
    weight = rng.uniform(20.0, 80.0, value.shape)
    matrix, vector = np.zeros((len(pose),) * 2), np.zeros(len(pose))
    cost = normal_equation_kernels.normal_equations(
        layout, pose, BLUR, np.zeros(2), value, owner, along, joints, seen, weight, 0.45,
        moves, matrix, vector,
    )  # fmt: skip
    np.testing.assert_allclose(cost, loops.picture_cost(value, owner, seen, weight, 0.45))
    # Gauss-Newton with the weights of iteratively reweighted least squares: Geman and McClure's
    # function has the weight 1 / (1 + (error / soft)^2)^2
    error = value - seen
    heeded = weight / (1.0 + (error / 0.45) ** 2) ** 2
    rows = slopes(layout, pose)
    of_legs = np.where(owner < 0, len(moves) - 1, owner // 64)
    rows[~moves[of_legs]] = 0.0
    expected = np.einsum("vu,vui,vuj->ij", heeded, rows, rows, optimize=True)
    np.testing.assert_allclose(matrix, np.tril(expected), atol=1e-8 * expected.max())
    gradient = np.einsum("vu,vui->i", heeded * error, rows)
    np.testing.assert_allclose(vector, gradient, atol=1e-8 * np.abs(gradient).max())
