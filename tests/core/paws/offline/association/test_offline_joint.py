"""Points that look alike are told apart over the whole recording."""

from __future__ import annotations

import numpy as np
import pytest

from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.association.associate import ViewEvidence, associate
from pawnb.core.paws.offline.association.joint import paint_names, tell_apart
from pawnb.core.paws.offline.association.tracklets import ViewTracklet
from pawnb.core.paws.offline.detection.evidence import bump_at
from pawnb.core.paws.offline.parameters import AssociationParameters, IdentityParameters

N, RADIUS, SPACING = 31, 2.5, 3
H, W = 24, 60
LEG, OTHER = 2, 5
"""Numbers of the points; they need not begin at 0."""
PARAMETERS = IdentityParameters()


def truth(t):
    """Two that pass each other about row 15: one goes right, one left."""
    return {LEG: np.array([15.0 + t, 12.0]), OTHER: np.array([45.0 - t, 12.0])}


def maps(place_of, height):
    """Return a map of bumps for every row, 0 elsewhere."""
    return np.stack([height * bump_at((H, W), place_of(t), 1.5) for t in range(N)])


@pytest.fixture
def scene(make_stack):
    """Both look like either; what was found until now turns back where they meet."""
    stack = make_stack(np.zeros((N, H * SPACING, W * SPACING), np.uint8), spacing=SPACING)
    forward = np.zeros_like(np.asarray(stack.forward))
    for t in range(N - 1):
        for point, step in ((LEG, 1.0), (OTHER, -1.0)):
            x, y = truth(t)[point].astype(int)
            forward[t, y - 3 : y + 4, x - 2 : x + 3, 0] = step
    backward = -np.concatenate([forward[:1], forward[:-1]])
    object.__setattr__(stack, "forward", forward)
    object.__setattr__(stack, "backward", backward)
    both = maps(lambda t: truth(t)[LEG], 1.0) + maps(lambda t: truth(t)[OTHER], 1.0)
    looks = {p: np.clip(4 * both, 0.01, 4).astype(np.float32) for p in (LEG, OTHER)}
    turned = {
        LEG: maps(lambda t: truth(t)[LEG if t < 15 else OTHER], 0.08),
        OTHER: maps(lambda t: truth(t)[OTHER if t < 15 else LEG], 0.08),
    }
    masses = {
        p: (m / m.sum(axis=(1, 2), keepdims=True)).astype(np.float32) for p, m in turned.items()
    }
    return stack, looks, masses


def clicks(stack, rows):
    return Annotations(
        {t: {p: stack.picture_of(place, t) for p, place in truth(t).items()} for t in rows}
    )


def even():
    return {p: np.full((H, W), 1 / (H * W), np.float32) for p in (LEG, OTHER)}


def found(scene, rows):
    stack, looks, masses = scene
    ones = {p: np.ones((N, H, W), np.float32) for p in looks}
    tracklets, names, _ = tell_apart(
        stack, clicks(stack, rows), masses=masses, others=ones, looks=looks, prior=even(),
        trust=0.5, radius=RADIUS, parameters=PARAMETERS,
    )  # fmt: skip
    return {
        (int(t), int(name)): place
        for one, name in zip(tracklets, names, strict=True)
        if name >= 0
        for t, place in zip(one.rows, one.places, strict=True)
    }


@pytest.mark.parametrize("row", [2, 28])
def test_two_that_pass_each_other_keep_their_names_from_one_clicked_frame(scene, row):
    places = found(scene, [row])
    for t in (0, 5, 25, 30):
        for point, place in truth(t).items():
            np.testing.assert_allclose(places[t, point], place, atol=1.0)


def test_never_two_names_in_one_place(scene):
    places = found(scene, [2])
    for t in range(N):
        if (t, LEG) in places and (t, OTHER) in places:
            assert np.linalg.norm(places[t, LEG] - places[t, OTHER]) >= RADIUS


def test_what_lasts_beside_one_leg_is_the_other_though_it_looks_like_that_one(make_stack):
    """The look of one was learnt alone: it says the same of both, and little of the other."""
    stack = make_stack(np.zeros((N, H * SPACING, W * SPACING), np.uint8), spacing=SPACING)
    at = {LEG: np.array([15.0, 12.0]), OTHER: np.array([45.0, 12.0])}
    both = sum(maps(lambda t, p=p: at[p], 1.0) for p in at)
    looks = {
        LEG: np.clip(8 * both, 0.01, 8).astype(np.float32),
        OTHER: np.full((N, H, W), 0.02, np.float32),
    }
    where_clicked = Annotations({2: {LEG: stack.picture_of(at[LEG], 2)}})
    ones = {p: np.ones((N, H, W), np.float32) for p in looks}
    tracklets, names, _ = tell_apart(
        stack, where_clicked, masses={p: one / (H * W) for p, one in ones.items()}, others=ones,
        looks=looks, prior=even(), trust=1.0, radius=RADIUS, parameters=PARAMETERS,
    )  # fmt: skip
    named = {int(name): one for one, name in zip(tracklets, names, strict=True) if name >= 0}
    for point, place in at.items():
        np.testing.assert_allclose(named[point].places[15], place, atol=0.5)


def test_what_has_no_name_is_closed_to_points_that_are_seen_beside_it():
    places = np.stack([np.arange(10.0, 20.0), np.full(10, 10.0)], axis=1)
    still = np.zeros(2)
    one = ViewTracklet(0, places, still, still)
    beside, after = (
        ViewTracklet(begin, np.full((6, 2), (40.0, y)), still, still)
        for begin, y in ((5, 5.0), (9, 15.0))
    )
    factors = paint_names(
        (16, H, W), [one, beside, after], np.array([LEG, -1, -1]), points=[LEG, OTHER],
        radius=RADIUS, parameters=PARAMETERS,
    )  # fmt: skip
    assert factors[LEG][10, 5, 40] == pytest.approx(1 - PARAMETERS.closed)
    assert factors[LEG][14, 15, 40] == factors[OTHER][10, 5, 40] == 1


def test_what_is_decided_is_open_to_its_point_and_closed_to_others():
    still = np.zeros(2)
    one = ViewTracklet(1, np.array([[20.0, 10.0], [21.0, 10.0]]), still, still)
    unnamed = ViewTracklet(1, np.array([[40.0, 10.0]]), still, still)
    factors = paint_names(
        (4, H, W), [one, unnamed], np.array([LEG, -1]), points=[LEG, OTHER], radius=RADIUS,
        parameters=PARAMETERS,
    )  # fmt: skip
    assert factors[LEG][1, 10, 20] == pytest.approx(1 + PARAMETERS.gain)
    assert factors[OTHER][2, 10, 21] == pytest.approx(1 - PARAMETERS.closed)
    for of in factors.values():
        assert (of[[0, 3]] == 1).all()
        assert (of[:, :, 35:] == 1).all()


def test_with_it_posteriors_pass_where_without_it_they_turn_back(scene, make_stack):
    """Where they meet flow is that of the upper one alone, so that both are carried with it."""
    stack, looks, _ = scene
    stack.forward[12:18] = 1.0
    stack.backward[12:18] = -1.0
    ones = {p: np.ones((N, H, W), np.float32) for p in looks}
    view = ViewEvidence(
        stack, "side", (W * SPACING, H * SPACING), clicks(stack, [2]),
        looks, even(), looks, ones,
    )  # fmt: skip

    def right(**how):
        (posteriors,) = associate([view], radius=RADIUS, parameters=AssociationParameters(), **how)
        x, y = truth(25)[OTHER].astype(int)
        return posteriors[OTHER].mass[25, y - 2 : y + 3, x - 2 : x + 3].sum()

    assert right(identity=PARAMETERS) > 0.8
    assert right() < 0.7


def test_it_is_said_where_a_point_has_a_tracklet_and_how_surely(scene):
    """Where the two meet, one of them at most."""
    stack, looks, _ = scene
    ones = {p: np.ones((N, H, W), np.float32) for p in looks}
    view = ViewEvidence(
        stack, "side", (W * SPACING, H * SPACING), clicks(stack, [2]), looks, even(), looks, ones
    )
    (jointly,) = associate(
        [view], radius=RADIUS, parameters=AssociationParameters(), identity=PARAMETERS
    )
    sure = np.stack([jointly[p].name_share for p in (LEG, OTHER)])
    assert (sure[:, [0, 5, 25, 30]] > 0.5).all()
    assert not sure[:, 15].all()
    (alone,) = associate([view], radius=RADIUS, parameters=AssociationParameters())
    assert alone[LEG].name_share is None


def test_where_nothing_may_be_a_point_nothing_is_decided(make_stack):
    stack = make_stack(np.zeros((N, H * SPACING, W * SPACING), np.uint8), spacing=SPACING)
    nothing = {p: np.full((N, H, W), 1e-3, np.float32) for p in (LEG, OTHER)}
    tracklets, names, _ = tell_apart(
        stack, Annotations({}), masses={p: m / (H * W) for p, m in nothing.items()},
        others=nothing, looks=nothing, prior=even(), trust=0.5, radius=RADIUS,
        parameters=PARAMETERS,
    )  # fmt: skip
    assert tracklets == []
    assert not len(names)
