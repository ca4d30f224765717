"""Tubes and meshes."""

import numpy as np
import pytest

from pawnb.synthetic.surfaces import MeshBuilder, rotation, swept_tube, tube_faces, tube_surface


def straight_tube(rings=9, segments=24):
    line = np.column_stack([np.linspace(0.0, 8.0, rings), np.zeros(rings), np.zeros(rings)])
    radius = np.full(rings, 2.0)
    return swept_tube(line, np.array([0.0, 1.0, 0.0]), (radius, radius), segments=segments)


def test_a_straight_round_tube_is_a_cylinder_with_outward_normals():
    vertices, normals = straight_tube()
    radial = vertices * [0.0, 1.0, 1.0]
    np.testing.assert_allclose(np.linalg.norm(radial, axis=1), 2.0)
    np.testing.assert_allclose(normals, radial / 2.0, atol=1e-12)


def test_faces_are_turned_outwards():
    vertices, normals = straight_tube()
    faces = tube_faces(9, 24)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    turned = np.cross(b - a, c - a)
    assert (np.einsum("ij,ij->i", turned, normals[faces[:, 0]]) > 0).all()
    # lateral area of the cylinder: 2 pi r l, less what 24 corners cut off
    area = np.linalg.norm(turned, axis=1).sum() / 2
    assert area == pytest.approx(2 * np.pi * 2 * 8, rel=0.01)


def test_skin_coordinates_meet_without_a_seam():
    skin = tube_surface(np.array([0.0, 1.0]), 12.0, 6).reshape(2, 6, 2)
    steps = np.abs(np.diff(np.append(skin[0, :, 1], skin[0, 0, 1])))
    np.testing.assert_allclose(steps, 2.0)


def test_rotation_lifts_the_head_and_turns_it_left():
    head = np.array([1.0, 0.0, 0.0])
    assert (rotation(0.0, 0.2, 0.0) @ head)[2] == pytest.approx(np.sin(0.2))
    assert (rotation(0.0, 0.0, 0.2) @ head)[1] == pytest.approx(np.sin(0.2))
    turn = rotation(0.3, -0.4, 0.5)
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(turn) == pytest.approx(1.0)


def test_builder_joins_parts_and_asks_for_what_is_fixed_once():
    asked = []

    def fixed():
        asked.append(1)
        return np.array([[0, 1, 2]]), np.ones((3, 3)), np.zeros((3, 2)), np.zeros(3)

    builder = MeshBuilder()
    for frame in range(2):
        for part in (4, 7):
            builder.add(part, np.full((3, 3), float(frame)), np.zeros((3, 3)), fixed=fixed)
        mesh = builder.mesh()
        np.testing.assert_array_equal(mesh.faces, [[0, 1, 2], [3, 4, 5]])
        np.testing.assert_array_equal(mesh.part, [4, 7])
        assert (mesh.vertices == frame).all()
    assert len(asked) == 2
