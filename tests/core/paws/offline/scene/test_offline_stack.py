"""Views as stacks: where marks of the view are in them, their flow, and what is read."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.parameters import SceneParameters
from pawnb.core.paws.offline.scene import stack as stack_module
from pawnb.core.paws.offline.scene.registration.body_frame import ViewBodyFrame
from pawnb.core.paws.offline.scene.stack import BodyStack, read_stacks

N = 40
T = np.arange(N) / (N - 1)
AXES = (30, 13)


def read(views, annotations, *, extent=80.0, advanced=lambda _: True, frames=None, **kept):
    return read_stacks(
        views, annotations, frames=frames or (0, views.n_frames),
        parameters=SceneParameters(extent=extent, spacing=3, **kept), advanced=advanced,
    )  # fmt: skip


# --- places and positions ------------------------------------------------------------------

numbers = st.floats(-500, 500)


@settings(max_examples=40)
@given(
    spacing=st.integers(1, 7), angle=st.floats(-4, 4), scale=st.floats(0.1, 2.5),
    shift=st.tuples(numbers, numbers), uv=st.lists(st.tuples(numbers, numbers), min_size=1),
)  # fmt: skip
def test_places_of_the_grid_and_positions_in_the_view_are_inverse(spacing, angle, scale, shift, uv):
    c, s = scale * np.cos(angle), scale * np.sin(angle)
    to_body = np.array([[[1.0, 0, 0], [0, 1, 0]], [[c, s, shift[0]], [-s, c, shift[1]]]])
    empty = np.zeros((1, 1, 1, 2), np.float32)
    body = ViewBodyFrame(np.zeros((2, 2)), np.array([0, angle]), "turns", pans=False)
    stack = BodyStack(
        np.zeros((2, 9, 9), np.uint8), None, to_body, empty, empty, spacing, body, scale, 60.0
    )
    uv = np.array(uv)
    place = stack.grid_of(uv, 1)
    np.testing.assert_allclose(stack.picture_of(place, 1), uv, atol=1e-6)
    np.testing.assert_allclose(
        stack.picture_of(place, np.ones(len(uv), int)), uv, atol=1e-6
    )  # a row for each
    np.testing.assert_allclose(stack.to_grid(stack.from_grid(place)), place, atol=1e-6)
    # the first place is the middle of its square of px
    np.testing.assert_array_equal(
        stack.from_grid([0, 2]), [spacing // 2, 2 * spacing + spacing // 2]
    )


# --- a mark in the view, and in the stack --------------------------------------------------


def path(kind):
    """Centre and angle of an animal."""
    if kind == "stays":
        return np.tile([90.0, 70.0], (N, 1)) + np.outer(np.sin(30 * T), [3, 1]), np.zeros(N)
    if kind == "follows":
        return np.stack([35 + 110 * T, np.full(N, 70.0)], axis=-1), np.zeros(N)
    angle = np.pi * T
    return np.stack([90 + 45 * np.sin(angle), 75 - 35 * np.cos(angle)], axis=-1), angle


def on_body(centre, angle, along, across):
    """Position of a place of the body in every picture."""
    c, s = np.cos(angle), np.sin(angle)
    return centre + np.stack([along * c - across * s, along * s + across * c], axis=-1)


def mark(pictures, uv):
    """Draw a dark dot of 3 px radius at a position between pixels in every picture."""
    y, x = np.mgrid[: pictures.shape[1], : pictures.shape[2]]
    pictures = pictures.astype(float)
    for picture, (u, v) in zip(pictures, uv, strict=True):
        share = np.exp(-((x - u) ** 2 + (y - v) ** 2) / (2 * 2.5**2))
        picture *= 1 - share[(...,) + (None,) * (picture.ndim - 2)]
    return np.round(pictures).astype(np.uint8)


def darkest(grey, near):
    """Return the centroid of what is dark within 12 px of a position (x, y)."""
    x0, y0 = np.round(near).astype(int) - 12
    part = grey[y0 : y0 + 25, x0 : x0 + 25].astype(float)
    dark = np.fmax(0.45 * part.max() - part, 0)
    y, x = np.mgrid[y0 : y0 + 25, x0 : x0 + 25]
    return np.array([(dark * x).sum(), (dark * y).sum()]) / dark.sum()


def clicks(centre, angle, row=20):
    placed = {0: on_body(centre, angle, -22, 0)[row], 1: on_body(centre, angle, 22, 0)[row]}
    return Annotations({row: placed})


@pytest.mark.parametrize("colour", [False, True])
@pytest.mark.parametrize("kind", ["stays", "follows", "turns"])
def test_a_dot_of_the_view_is_at_its_place_in_the_stack(film_animal, array_views, kind, colour):
    centre, angle = path(kind)
    pictures = film_animal(centre, angle, size=(180, 150), axes=AXES)
    if colour:  # reddish: the means of red and blue differ
        pictures = (pictures[..., None] * [1.0, 0.8, 0.6]).astype(np.uint8)
    uv = on_body(centre, angle, 8.3, -2.6)
    views = array_views({"side": mark(pictures, uv)})
    (stack,) = read(views, [clicks(centre, angle)])
    assert stack.body.kind == kind
    assert stack.scale == pytest.approx(80 / 44)  # the clicks lie 44 px apart
    assert stack.grey.shape[0] == N
    assert (stack.colour is not None) == colour
    if colour:
        assert stack.colour.shape == (*stack.grey.shape, 2)
    for row in (0, 13, 20, 39):
        expected = stack.from_grid(stack.grid_of(uv[row], row))
        np.testing.assert_allclose(darkest(stack.grey[row], expected), expected, atol=0.7)


@pytest.mark.parametrize("times", [2, 4])
def test_of_a_large_picture_that_is_shrunk_it_is_there_to_a_fifth_of_a_px(array_views, times):
    """Bright pictures with a dark dot; a click beside it and one ``times`` 80 px further."""
    size = (160 * times, 120 * times)
    y, x = np.mgrid[: size[1], : size[0]]
    uv = np.array([[70.3 * times, 60.9 * times], [75.1 * times, 50.2 * times]])
    pictures = [
        200 - 180 * np.exp(-((x - u) ** 2 + (y - v) ** 2) / (2 * (2.5 * times) ** 2)) for u, v in uv
    ]
    pictures = np.round(pictures).astype(np.uint8)
    pictures[:, : 20 * times] = 0  # so that no shade of the dot is stretched to black
    views = array_views({"top": pictures})
    placed = {0: np.array([40.0, 60.0]) * times, 1: np.array([120.0, 60.0]) * times}
    (stack,) = read(views, [Annotations({0: placed})])
    assert stack.scale == pytest.approx(1 / times)
    for row in (0, 1):
        expected = stack.from_grid(stack.grid_of(uv[row], row))
        np.testing.assert_allclose(darkest(stack.grey[row], expected), expected, atol=0.2)


def test_pictures_are_enlarged_at_most_so_much(array_views, make_texture):
    views = array_views({"side": np.stack([make_texture(60, 80)] * 2)})
    placed = Annotations({0: {0: np.array([30.0, 30.0]), 1: np.array([40.0, 30.0])}})
    (stack,) = read(views, [placed], largest_enlargement=1.5)
    assert stack.scale == 1.5
    # of a view that stays, nothing beside the picture is looked at
    low, high = stack.picture_of(np.array([[0, 0], np.array(stack.shape[:0:-1]) - 1]), 0)
    assert (low >= 0).all()
    assert (high <= [80, 60]).all()


# --- flow ----------------------------------------------------------------------------------


def test_flow_is_the_shift_in_places_both_ways(array_views, make_texture):
    """The whole picture goes 6 px right and 3 px up a frame; a place is 3 working px."""
    large = make_texture(160, 260, seed=3)
    pictures = [large[20 + 3 * t :, 60 - 6 * t :][:120, :160] for t in range(4)]
    placed = Annotations({0: {0: np.array([40.0, 60.0]), 1: np.array([120.0, 60.0])}})
    (stack,) = read(array_views({"side": np.stack(pictures)}), [placed])
    assert (stack.body.kind, stack.scale) == ("stays", 1.0)
    n, h, w = stack.shape
    assert stack.forward.shape == stack.backward.shape == (n - 1, h, w, 2)
    inner = np.s_[:, 5:-5, 5:-5]
    for flow, expected in ((stack.forward, [2.0, -1.0]), (stack.backward, [-2.0, 1.0])):
        found = np.median(flow[inner], axis=(1, 2))
        np.testing.assert_allclose(found, [expected] * (n - 1), atol=0.1)


# --- what is read --------------------------------------------------------------------------


@pytest.fixture
def two_views(array_views, make_texture):
    still = np.stack([make_texture(60, 80)] * 6)
    return array_views({"left": still, "right": still[:, ::-1].copy()})


CLICKED = Annotations({1: {0: np.array([20.0, 30.0]), 1: np.array([60.0, 30.0])}})


def test_a_view_without_clicks_is_left_out(two_views):
    (stack,) = read(two_views, [Annotations({}), CLICKED], extent=40.0)
    # the grey levels are stretched, and the last columns repeat those of the view
    right, left = (two_views.films[name][0].ravel() for name in ("right", "left"))
    shown = stack.grey[0, :60, :80].ravel()
    assert np.corrcoef(shown, right)[0, 1] > 0.95 > np.corrcoef(shown, left)[0, 1]
    assert len(read(two_views, [CLICKED, CLICKED], extent=40.0)) == 2


@pytest.mark.parametrize(("most", "steps"), [(1e9, [2, 4, 6]), (0, [1, 2, 3, 4, 5, 6])])
def test_frames_that_are_asked_for_are_read_once_or_where_memory_lacks_twice(
    two_views, monkeypatch, most, steps
):
    told = []

    def advanced(done):
        told.append(done)
        return True

    asked = {"frames": (2, 5), "extent": 40.0}
    expected = read(two_views, [CLICKED, CLICKED], **asked)
    monkeypatch.setattr(stack_module, "_KEPT_BYTES", most)
    stacks = read(two_views, [CLICKED, CLICKED], **asked, advanced=advanced)
    assert told == steps
    assert [stack.shape[0] for stack in stacks] == [3, 3]
    assert len(stacks[0].to_body) == 3
    for stack, other in zip(stacks, expected, strict=True):
        np.testing.assert_array_equal(stack.grey, other.grey)
        np.testing.assert_array_equal(stack.to_body, other.to_body)


@pytest.mark.parametrize("most", [1e9, 0])
@pytest.mark.parametrize("last", [1, 6, 7, 12])
def test_where_it_is_stopped_there_is_nothing(two_views, monkeypatch, last, most):
    monkeypatch.setattr(stack_module, "_KEPT_BYTES", most)
    assert read(two_views, [CLICKED, CLICKED], extent=40.0, advanced=lambda n: n < last) is None


def test_of_one_point_the_extent_is_that_of_the_picture(two_views):
    """0.4 of the shorter side, 60 px, are 24 px; 48 working px were asked for."""
    alone = Annotations({0: {0: np.array([20.0, 30.0])}, 3: {0: np.array([60.0, 30.0])}})
    assert read(two_views, [alone, Annotations({})], extent=48.0)[0].scale == pytest.approx(2)


@pytest.mark.parametrize("percents", [(1.0, 99.8), (0.0, 100.0), (37.5, 50.0)])
def test_percentiles_of_grey_values_are_those_that_numpy_sorts_out(percents):
    pictures = np.random.default_rng(3).gamma(2.0, 20.0, (4, 31, 17)).clip(0, 255).astype(np.uint8)
    wanted = np.percentile(pictures, percents)
    assert stack_module._percentiles(pictures, percents) == pytest.approx(wanted, abs=1e-9)
