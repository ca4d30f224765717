"""Joints in space: sight lines, arches, equations, and exact pictures of known joints."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pawnb.core import dlt
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import ImageEvidence
from pawnb.core.pose.poses import joint_positions, natural_pose
from pawnb.core.pose.space.arch import arch, arch_angle, slide
from pawnb.core.pose.space.fitter import make_space_fitter
from pawnb.core.pose.space.frame import SpaceFrame, even_arches, known_without_picture
from pawnb.core.pose.space.geometry import SightLines, check_second_view
from pawnb.core.pose.space.model import first_view_places, make_model
from pawnb.core.pose.space.picture_kernels import add_known, ground_cost
from pawnb.core.pose.space.settings import SpaceSettings
from pawnb.core.pose.species_file import load_species
from pawnb.core.pose.track_result import plain_track
from pawnb.core.rig import Rig
from pawnb.errors import CalibrationError, InputError

# from above and from the side, 2 px a mm, without perspective; and the same seen from 400 mm
TOP = np.array([2.0, 0, 0, 100, 0, -2.0, 0, 300, 0, 0, 0])
SIDE = np.array([2.0, 0, 0, 100, 0, 0, -2.0, 90, 0, 0, 0])
TOP_NEAR = np.array([2.0, 0, -100 / 400, 100, 0, -2.0, -300 / 400, 300, 0, 0, -1 / 400])
SIDE_NEAR = np.array([2.0, -0.3, 0, 100, 0, -0.1, -2.0, 90, 0, -1 / 900, 0])
VIEWS = ("top", "side")


@given(
    xyz=st.tuples(st.floats(0, 120), st.floats(0, 120), st.floats(-5, 30)),
    near=st.booleans(),
)
def test_a_point_is_met_again_at_its_height_on_its_sight_line(xyz, near):
    coefs = TOP_NEAR if near else TOP
    lines = SightLines(coefs, np.array([50.0, 60.0, 5.0]), np.array([0.0, 0.0, 1.0]))
    point = np.array(xyz)
    uv = dlt.project(coefs, point)[0]
    np.testing.assert_allclose(lines.at(uv, lines.height(point)), point, atol=1e-8)
    # any other place on the line looks the same
    np.testing.assert_allclose(dlt.project(coefs, lines.at(uv, 11.0))[0], uv, atol=1e-8)


def test_heights_grow_towards_up_and_unknown_places_stay_unknown():
    lines = SightLines(TOP, np.zeros(3), np.array([0.0, 0.0, 1.0]))
    np.testing.assert_allclose(lines.axis, [0, 0, 1])
    assert np.isnan(lines.at(np.array([np.nan, 4.0]), 1.0)).all()


def test_a_second_view_that_shows_no_heights_is_refused():
    lines = SightLines(TOP, np.zeros(3), np.array([0.0, 0.0, 1.0]))
    check_second_view(lines, SIDE, VIEWS)
    with pytest.raises(CalibrationError, match="'top' and 'side' look in nearly the same dir"):
        check_second_view(lines, TOP, VIEWS)


def test_an_arch_is_as_long_as_its_leg():
    """A half circle's chord is 2/pi of its length."""
    assert arch_angle(2 / np.pi) == pytest.approx(np.pi / 2)
    lengths = np.full(400, np.pi / 400)
    out, up = arch(lengths, 2.0, 0.0)
    assert up.max() == pytest.approx(1.0, abs=1e-3)
    assert out[200] == pytest.approx(0.5)
    places = np.stack([2.0 * out, up])
    assert np.hypot(*np.diff(places, axis=1)).sum() == pytest.approx(np.pi, rel=1e-3)


def test_an_arch_ends_where_it_should_even_beyond_its_reach():
    out, up = arch(np.array([2.0, 1.0, 1.0]), 7.0, -1.0)
    assert (out[0], out[-1], up[0], up[-1]) == pytest.approx((0, 1, 0, -1))
    assert (np.diff(out) > 0).all()


def test_points_slide_along_a_bent_line():
    line = np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 1.0]])
    np.testing.assert_allclose(slide(line, np.array([0.5, 0.875])), [[2, 0], [3, 0.5]])


class _Empty:
    """A frame of one grey."""

    def reduced(self, u0, v0, u1, v1, *, factor):
        return np.full(((v1 - v0) // factor, (u1 - u0) // factor), 200.0)


def _scene(*, near=False, seed=0):
    """Return a fitter, a frame, its exact second picture, and the true unknowns of an animal."""
    rng = np.random.default_rng(seed)
    animal = load_species("dolomedes")
    coefs = np.stack([TOP_NEAR, SIDE_NEAR] if near else [TOP, SIDE], axis=1)
    rig = Rig(VIEWS, coefs)
    pose = natural_pose(animal, xy=(240.0, 150.0), heading_deg=20.0, scale=2.0 * 0.9)
    # as a leg lies in an arch, it is shorter from above
    poses = dataclasses.replace(pose, lengths_px=0.85 * pose.lengths_px)
    track = plain_track(animal, poses)
    sizes = ((400, 350), (400, 130))
    model = make_model(animal, track, rig, views=VIEWS, sizes=sizes, settings=SpaceSettings())
    places, precision = first_view_places(model, track)
    np.testing.assert_allclose(places, joint_positions(animal, poses))
    background = SimpleNamespace(mean=np.full((130, 400), 200.0), sd=np.ones((130, 400)))
    model = model.changed(ground=float(model.lines.height(np.zeros(3))))
    fitter = make_space_fitter(model, background, _Empty())
    body = float(model.lines.height(np.array([0.0, 0.0, 6.0])))
    box = (0, 0, 400, 130)
    one = SpaceFrame(poses.xy[0], 20.0, places[0], precision[0], np.zeros((130, 400)), box)
    slid, heights = even_arches(fitter.model, one, body)
    # knees a little higher or lower than an even arch has them
    heights[:, 2:6] += rng.uniform(-1.5, 1.5, (len(heights), 1))
    joints = model.lines.at(slid, heights)
    lengths = np.linalg.norm(np.diff(joints, axis=1), axis=-1)
    fitter = fitter.with_model(model.changed(lengths=lengths))
    one = dataclasses.replace(one, places=dlt.project(model.lines.coefs, joints)[..., 0, :])
    truth = np.concatenate([[body], joints.ravel()])
    blank = ImageEvidence(np.zeros((130, 400)), np.full((130, 400), 60.0), np.zeros(2))
    seen = fitter.painted(one, blank, truth)[0]
    return fitter, one, blank._replace(seen=seen), truth


@pytest.mark.slow
@pytest.mark.parametrize("near", [False, True])
def test_exact_places_lengths_and_picture_give_the_joints_back(near):
    """From even arches; of a leg span of 75 mm the median within 0.2 mm, all within 2 mm."""
    fitter, one, image_evidence, truth = _scene(near=near)
    known = known_without_picture(fitter.model, one, expected=None, expected_sd=1.0)
    found, cost = fitter.refine(
        one, image_evidence, fitter.guess(one, image_evidence, truth[0]), known=known, coarse=True
    )
    off = np.linalg.norm((found - truth)[1:].reshape(-1, 3), axis=1)
    assert np.median(off) < 0.2
    assert off.max() < 2.0
    assert (
        cost < fitter.equations(one, image_evidence, truth, known=known, blur=fitter.blur)[0] + 1.0
    )


@pytest.mark.slow
def test_the_body_is_found_where_the_second_view_shows_it():
    fitter, one, image_evidence, truth = _scene()
    heights = truth[0] + np.arange(-8.0, 9.0)
    assert fitter.body_height(one, image_evidence, heights) == pytest.approx(truth[0])


@pytest.mark.slow
def test_the_gradient_is_that_of_the_cost():
    """Central differences of what is known without the picture, near and off the truth."""
    fitter, one, _, truth = _scene()
    rng = np.random.default_rng(1)
    expected = np.concatenate([[1.0], np.zeros(truth[1::3].size)])
    known = known_without_picture(fitter.model, one, expected=expected, expected_sd=2.0)
    x = truth + rng.normal(0, 0.5, len(truth))
    layout, n = fitter.model.layout, len(x)

    def cost(x):
        return add_known(layout, x, known, np.zeros((n, n)), np.zeros(n))

    gradient = np.zeros(n)
    add_known(layout, x, known, np.zeros((n, n)), gradient)
    for k in [*rng.choice(n, 40, replace=False).tolist(), 0]:
        step = np.zeros(n)
        step[k] = 1e-5
        slope = (cost(x + step) - cost(x - step)) / 2e-5
        assert gradient[k] == pytest.approx(slope, rel=1e-4, abs=1e-3)


@pytest.mark.slow
def test_equations_are_solved_leg_by_leg_as_in_one():
    fitter, one, image_evidence, truth = _scene()
    known = known_without_picture(fitter.model, one, expected=None, expected_sd=1.0)
    _, matrix, vector = fitter.equations(
        one, image_evidence, truth + 0.2, known=known, blur=fitter.blur
    )
    damped = matrix + 0.1 * np.diag(np.diag(matrix))
    both = fitter.solve(matrix, vector, 0.1)
    np.testing.assert_allclose(both, np.linalg.solve(damped, vector), rtol=1e-5, atol=1e-9)


def test_a_foot_is_on_the_ground_or_lifted_and_nothing_is_below():
    assert ground_cost(-3.0, True, 2.0) == ground_cost(-3.0, False, 2.0) == 4.5
    assert ground_cost(3.0, False, 2.0) == 0.0
    assert ground_cost(50.0, True, 2.0) == pytest.approx(2.0, rel=0.01)  # half the square of 2


def test_an_animal_that_the_second_view_cannot_show_is_told():
    animal = load_species("dolomedes")
    track = plain_track(animal, natural_pose(animal, xy=(900.0, 150.0), scale=2.0))
    rig = Rig(VIEWS, np.stack([TOP, SIDE], axis=1))
    with pytest.raises(InputError, match="view 'side' does not show the places"):
        make_model(
            animal, track, rig, views=VIEWS, sizes=((1000, 350), (400, 130)),
            settings=SpaceSettings(),
        )  # fmt: skip


def test_the_body_is_an_ellipsoid_seen_from_the_side():
    """Walking along u, a part is as long as it is and as high as its thickness says; 2 px a mm."""
    model = _scene()[0].model.changed(thickness=np.array([0.5, 0.5]), lift=np.array([1.0, 0.0]))
    xy = np.array([240.0, 150.0])
    parts = model.body_parts(xy, 0.0, 3.0)
    body = model.lines.at(xy, 3.0)
    for part, ellipse, lift in zip(model.animal.body, parts, (1.0, 0.0), strict=True):
        half = 0.9 * np.array([part.length, 0.5 * part.width]) / 2 * 2.0
        np.testing.assert_allclose(ellipse[7:9], half, rtol=1e-6)
        np.testing.assert_allclose(ellipse[4:7], [half[0] ** -2, 0, half[1] ** -2], atol=1e-6)
        np.testing.assert_allclose(ellipse[2:4], [0.0, -2.0], atol=1e-9)
        middle = dlt.project(SIDE, body + np.array([0.9 * part.centre[0], 0, lift]))[0]
        np.testing.assert_allclose(ellipse[:2] + 3.0 * ellipse[2:4], middle, atol=1e-6)
