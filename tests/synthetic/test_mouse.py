"""The body of the synthetic mouse: in one piece, on the belt, with its paws where truth says."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from pawnb.synthetic.gait_model import plan_gait
from pawnb.synthetic.mouse import BODY, EAR, LANDMARKS, LIMB, PAW, TAIL, Mouse
from pawnb.synthetic.scene import LEGS, scene_settings
from pawnb.synthetic.truth import paw_positions

TIMES = np.arange(1.0, 1.25, 0.012)  # a stride and more


@pytest.fixture(scope="module", params=[0, 7])
def run(request):
    """A mouse that runs for a stride: (settings, gait, meshes)."""
    settings = scene_settings("hard", changes={"seed": request.param, "size": 1.1})
    gait = plan_gait(settings, 1.0)
    mouse = Mouse(settings, gait)
    return settings, gait, [mouse.mesh(t) for t in TIMES]


def vertices_of(mesh, part):
    return mesh.vertices[np.unique(mesh.faces[mesh.part == part])]


def test_the_tracked_point_lies_inside_its_paw(run):
    settings, gait, meshes = run
    truth = paw_positions(gait, settings, TIMES)
    for number, leg in enumerate(LEGS):
        for mesh, point in zip(meshes, truth[:, number], strict=True):
            paw = vertices_of(mesh, PAW[leg])
            assert (paw.min(axis=0) < point).all()
            assert (point < paw.max(axis=0)).all()
            assert cKDTree(paw).query(point)[0] < 2.5 * settings.size


def test_landmarks_lie_on_what_is_drawn(run):
    """The nose is the foremost of the body; the tail begins at the body and ends at its tip."""
    settings, gait, meshes = run
    mouse = Mouse(settings, gait)
    ahead = np.array([settings.direction, 0.0, 0.0])
    for mesh, time_s in zip(meshes, TIMES, strict=True):
        at = dict(zip(LANDMARKS, mouse.landmarks(time_s), strict=True))
        body, tail, ear = (vertices_of(mesh, part) for part in (BODY, TAIL, EAR))
        assert np.linalg.norm(body[np.argmax(body @ ahead)] - at["nose"]) < 2.0 * settings.size
        near = [cKDTree(tail).query(at[name])[0] for name in ("tail_base", "tail_tip")]
        assert max(near) < 4.0 * settings.size
        assert (tail @ ahead).max() - at["tail_base"] @ ahead < 4.0 * settings.size
        far = np.linalg.norm(tail - at["tail_base"], axis=1).max()
        assert far - np.linalg.norm(at["tail_tip"] - at["tail_base"]) < 3.0 * settings.size
        for name, side in (("ear_L", 1.0), ("ear_R", -1.0)):
            own = ear[side * settings.direction * (ear[:, 1] - at["nose"][1]) > 0]
            assert np.linalg.norm(own.mean(axis=0) - at[name]) < 3.0 * settings.size


def test_nothing_sinks_into_the_belt_and_standing_paws_touch_it(run):
    _, gait, meshes = run
    for mesh, time_s in zip(meshes, TIMES, strict=True):
        assert mesh.vertices[:, 2].min() > -0.4
        for leg in LEGS:
            lowest = vertices_of(mesh, PAW[leg])[:, 2].min()
            phase = gait.legs[leg].phase(np.array([time_s]))[0]
            if phase < 1.0:
                assert lowest < 0.8
            elif 1.3 < phase < 1.6:
                assert lowest > 1.0


def test_legs_hang_together_and_on_the_body(run):
    settings, _, meshes = run
    for mesh in meshes:
        limbs, body = cKDTree(vertices_of(mesh, LIMB)), cKDTree(vertices_of(mesh, BODY))
        for leg in LEGS:
            assert limbs.query(vertices_of(mesh, PAW[leg]))[0].min() < 1.0 * settings.size
        near_body = body.query(vertices_of(mesh, LIMB))[0]
        assert (near_body < 3.0).sum() > 200


def test_normals_are_unit_vectors(run):
    _, _, meshes = run
    np.testing.assert_allclose(np.linalg.norm(meshes[0].normals, axis=1), 1.0, atol=1e-6)


def test_running_the_other_way_is_the_same_turned_about():
    meshes = []
    for direction in (1, -1):
        settings = scene_settings("normal", changes={"direction": direction})
        meshes.append(Mouse(settings, plan_gait(settings, 0.5)).mesh(1.1))
    there, back = meshes
    np.testing.assert_allclose(back.vertices, there.vertices * [-1.0, -1.0, 1.0], atol=1e-9)
    np.testing.assert_array_equal(back.faces, there.faces)
