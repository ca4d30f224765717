"""The terms of the 2009 energy against values worked out by hand, and Table 3.3."""

from dataclasses import dataclass

import numpy as np
import pytest
from painted_spider import PaintedReader, paint, random_pose
from scipy import ndimage

from pawnb.core.pose.background import Background, mean_background
from pawnb.core.pose.contrast import neighbour_costs, squared_gradient
from pawnb.core.pose.poses import Poses
from pawnb.core.pose.pullar2009.energy import Pullar2009Energy
from pawnb.core.pose.pullar2009.energy_view import explain_energy
from pawnb.core.pose.pullar2009.likelihood import (
    background_cost,
    subject_box,
    subject_cost,
    subject_statistics,
)
from pawnb.core.pose.pullar2009.mincut import cut_grid, grid_energy
from pawnb.core.pose.pullar2009.settings import Pullar2009Settings
from pawnb.core.pose.pullar2009.sticks import pose_vector
from pawnb.core.pose.species_file import load_species
from pawnb.errors import InputError

SIZE = (260, 220)


@dataclass
class Scene:
    animal: object
    pose: Poses
    picture: np.ndarray
    background: Background


@pytest.fixture(scope="module")
def scene():
    rng = np.random.default_rng(5)
    animal = load_species("dolomedes")
    pose = random_pose(animal, rng, frame=0, xy=(128.0, 110.0), heading_deg=15.0, scale=1.2)
    empty = PaintedReader([paint(animal, None, SIZE, rng) for _ in range(8)])
    picture = paint(animal, pose, SIZE, rng)
    return Scene(animal, pose, picture, mean_background(empty, range(8)))


def energy_of(scene, **settings):
    return Pullar2009Energy(
        scene.animal, scene.pose, picture=scene.picture, background=scene.background,
        settings=Pullar2009Settings(**settings),
    )  # fmt: skip


def test_background_cost_is_the_gaussians_negative_logarithm():
    empty = Background(mean=np.array([[100.0, 50.0]]), sd=np.array([[2.0, 0.1]]), n_frames=9,
                       source="")  # fmt: skip
    cost = background_cost(np.array([[110, 53]], np.uint8), empty, sd_floor_grey=1.5)
    # by hand: 10² / (2 * 2²) + log 2; 3² / (2 * 1.5²) + log 1.5 (floor)
    np.testing.assert_allclose(cost, [[12.5 + np.log(2), 2 + np.log(1.5)]], rtol=1e-6)


def test_gaussian_subject_is_on_the_same_scale():
    cost = subject_cost(np.array([[40, 60]]), mean=50.0, sd=5.0)
    np.testing.assert_allclose(cost, 2 + np.log(5), rtol=1e-6)


def test_subject_box_and_statistics_of_a_dark_square():
    cost = np.full((40, 60), 0.5)
    cost[10:20, 30:45] = 100.0
    picture = np.full((40, 60), 200.0)
    picture[10:20, 30:45] = np.tile([40.0, 42.0, 44.0], (10, 5))
    assert subject_box(cost) == (30, 10, 45, 20)
    mean, sd, box = subject_statistics(picture, cost, box_share=0.9)
    assert box == (30, 10, 45, 20)
    assert mean == 42.0
    assert sd == pytest.approx(np.std([40, 42, 44] * 50, ddof=1))


def test_a_flat_frame_has_no_subject():
    with pytest.raises(InputError, match="nothing stands out"):
        subject_box(np.full((5, 6), 2.0))


def test_sobel_and_the_costs_of_neighbours():
    ramp = np.tile(np.arange(8, dtype=np.uint8) * 3, (6, 1))
    # Eq. 3.13 on a slope of 3: (1 + 2 + 1) * 2 px * 3 = 24
    np.testing.assert_allclose(squared_gradient(ramp)[:, 1:-1], 24.0**2)
    right, down = neighbour_costs(ramp, ising=5.0, contrast=7.0, edge_grey=20.0)
    assert right.shape == (6, 7)
    assert down.shape == (5, 8)
    # erratum 11: the exponent takes g squared
    expected = 5 + 7 * np.exp(-(24**2) / (2 * 20**2))
    np.testing.assert_allclose(right[:, 1:-1], expected, rtol=1e-6)
    np.testing.assert_allclose(down[:, 1:-1], expected, rtol=1e-6)


def test_parameters_are_estimated_as_in_table_3_3(scene):
    p = energy_of(scene).parameters
    cost = background_cost(scene.picture, scene.background, sd_floor_grey=1.0)
    sigma = cost.std(dtype=float)
    assert p.sigma == pytest.approx(sigma, rel=1e-5)
    assert p.ising == pytest.approx(sigma / 2, rel=1e-5)
    assert p.contrast == pytest.approx(2 * sigma, rel=1e-5)
    # legs 4: 2.7 mm from the axis, 40.0 mm long (Table 3.1), 1.2 px per mm
    assert p.thickness_px == pytest.approx(2 * (2.7 + 40.0) * 1.2 / 200)
    assert p.steepness == pytest.approx(sigma / p.thickness_px, rel=1e-5)
    # painted: dark 45 in the body, paler legs
    assert 45 < p.subject_mean < 110


def test_every_parameter_can_be_set(scene):
    wanted = {"ising": 3.0, "contrast": 4.0, "edge_grey": 6.0, "thickness_px": 2.0, "steepness": 9}
    p = energy_of(scene, **wanted).parameters
    assert {name: getattr(p, name) for name in wanted} == wanted


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ({"ising": -1.0}, "'ising' is -1.0; expected a number, 0 or more"),
        ({"thickness_px": 0.0}, "'thickness_px' is 0.0; expected a number above 0"),
        ({"combinations": 0}, "'combinations' is 0; expected a number above 0"),
    ],
)
def test_impossible_settings_are_refused(setting, words):
    with pytest.raises(InputError, match=words):
        Pullar2009Settings(**setting)


@pytest.mark.slow
@pytest.mark.parametrize("subject", ["background mean", "gaussian"])
def test_crop_finds_the_same_labels_as_the_whole_picture(scene, subject):
    energy = energy_of(scene, subject=subject)
    vector = pose_vector(scene.pose)
    vector[:2] += [4.0, -3.0]
    frame = energy.frame(scene.picture, vector, slack_px=0.0)
    cut = energy.cut(frame, vector)
    # the same energy on the whole picture, with scipy's distance transform of exact distances
    p, sticks = energy.parameters, energy.sticks
    cost = background_cost(scene.picture, scene.background, sd_floor_grey=1.0)
    own = cost.mean(dtype=float) - cost
    if subject == "gaussian":
        own = subject_cost(scene.picture, mean=p.subject_mean, sd=p.subject_sd) - cost
    from pawnb.core.pose.pullar2009.sticks import distance_map

    away = distance_map((0, 0), cost.shape, vector[2], sticks.points(vector), sticks.n_links,
                        sticks.parts(vector), 1e3)  # fmt: skip
    own = own + p.steepness * (away - p.thickness_px)
    pairs = neighbour_costs(
        scene.picture, ising=p.ising, contrast=p.contrast, edge_grey=p.edge_grey
    )
    labels = cut_grid(own, *pairs)
    u0, v0, u1, v1 = frame.box
    assert (u1 - u0) * (v1 - v0) < labels.size
    rest = labels.copy()
    rest[v0:v1, u0:u1] = False
    assert not rest.any()
    np.testing.assert_array_equal(labels[v0:v1, u0:u1], cut.labels)


@pytest.mark.slow
def test_energy_is_the_sum_of_its_terms(scene):
    view = explain_energy(scene.picture, scene.pose, animal=scene.animal,
                          background=scene.background)  # fmt: skip
    assert set(view.terms) == {"likelihood", "shape prior", "Ising", "contrast", "joint ranges"}
    assert sum(view.terms.values()) == pytest.approx(view.energy, rel=1e-5)
    likelihood = np.where(view.segmentation, view.subject_cost, view.background_cost).sum()
    assert view.terms["likelihood"] == pytest.approx(likelihood, rel=1e-5)
    x = view.segmentation.astype(int)
    borders = np.abs(np.diff(x, axis=0)).sum() + np.abs(np.diff(x, axis=1)).sum()
    assert view.terms["Ising"] == pytest.approx(view.parameters.ising * borders)
    prior = np.where(view.segmentation, view.shape_prior, 1 - view.shape_prior)
    seen = prior > 1e-12
    assert view.terms["shape prior"] >= -np.log(prior[seen]).sum() * (1 - 1e-6)


@pytest.mark.slow
def test_segmentation_is_the_animal_and_prior_half_at_the_thickness(scene):
    view = explain_energy(scene.picture, scene.pose, animal=scene.animal,
                          background=scene.background)  # fmt: skip
    u0, v0, u1, v1 = view.box
    dark = scene.background.mean[v0:v1, u0:u1] - scene.picture[v0:v1, u0:u1] > 35
    overlap = (dark & view.segmentation).sum() / (dark | view.segmentation).sum()
    assert overlap > 0.85
    # Eq. 3.15: one half where the distance is d_r; distances from a raster of the prior's core
    core = view.shape_prior > 0.5
    away = ndimage.distance_transform_edt(~core)
    assert view.shape_prior[away > 2].max() < 1e-3
    assert view.shape_prior[core].min() > 0.5


def test_joints_beyond_their_range_cost_softly(scene):
    energy = energy_of(scene, limit_stiffness=2.0)
    vector = pose_vector(scene.pose)
    vector[3:] = energy.middle_deg
    assert energy.limits(vector) == 0
    # leg 2 of Table 4.6: 54 degrees where 14 + 65/2 = 46.5 is the end of the range (erratum 9)
    vector[3 + scene.animal.joints.index("L2_BC")] = 54.0
    assert energy.limits(vector) == pytest.approx(2.0 * energy.parameters.sigma * 7.5**2, rel=1e-6)


@pytest.mark.slow
def test_higher_ising_parameter_gives_smoother_borders(scene):
    def borders(ising):
        x = explain_energy(
            scene.picture, scene.pose, animal=scene.animal, background=scene.background,
            settings=Pullar2009Settings(ising=ising, contrast=0.0),
        ).segmentation.astype(int)  # fmt: skip
        return np.abs(np.diff(x, axis=0)).sum() + np.abs(np.diff(x, axis=1)).sum()

    assert borders(400.0) < borders(0.0)


def test_energy_of_labels_matches_the_cut(scene):
    energy = energy_of(scene)
    vector = pose_vector(scene.pose)
    frame = energy.frame(scene.picture, vector, slack_px=5.0)
    best = energy.cut(frame, vector)
    own = np.zeros_like(frame.own)
    assert grid_energy(best.labels, own, right=frame.right, down=frame.down)[1] > 0
    worse = energy.cut(frame, vector + np.r_[9.0, np.zeros(len(vector) - 1)])
    assert worse.energy > best.energy
