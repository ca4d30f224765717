"""Two patches of different texture are learnt in one picture and found in another."""

from __future__ import annotations

import numpy as np
import pytest

from pawnb.core.paws.offline.detection import appearance
from pawnb.core.paws.offline.detection.appearance import (
    TrainingFrame,
    appearance_maps,
    learn_appearance,
)
from pawnb.core.paws.offline.parameters import AppearanceParameters

PARAMETERS = AppearanceParameters(copies=4, background=250, networks=1, epochs=20)
# in the first picture, where they are learnt, and in the second, where they have changed sides
STRIPED, CHECKED = ((40, 50), (115, 60)), ((120, 50), (35, 45))


def picture(ground, striped, checked):
    """Two discs of 12 px radius: stripes 6 px wide, and a chequer of 3 px."""
    y, x = np.mgrid[: ground.shape[0], : ground.shape[1]]
    grey = ground.copy()
    for (u, v), pattern in (
        (striped, (y // 6) % 2),
        (checked, (x // 3 + y // 3) % 2),
    ):
        disc = np.hypot(x - u, y - v) < 12
        grey[disc] = np.where(pattern, 230, 60)[disc]
    return grey


@pytest.fixture(scope="module")
def stack(make_stack, make_texture):
    pairs = zip(STRIPED, CHECKED, strict=True)
    return make_stack(
        np.stack(
            [
                picture(make_texture(96, 160, seed=t, low=90, high=170), striped, checked)
                for t, (striped, checked) in enumerate(pairs)
            ]
        ),
        spacing=4,
    )


@pytest.fixture(scope="module")
def maps(stack):
    """Point 0 is striped, 2 is checked; point 1 was not clicked."""
    training_frame = TrainingFrame({0: np.array(STRIPED[0], float), 2: np.array(CHECKED[0], float)})
    classify = learn_appearance(stack, {0: training_frame}, n_points=3, parameters=PARAMETERS)
    return appearance_maps(stack, classify, points=[0, 1, 2], parameters=PARAMETERS)


@pytest.mark.parametrize(("point", "places"), [(0, STRIPED), (2, CHECKED)])
def test_each_is_found_where_it_was_learnt_and_where_it_went(maps, stack, point, places):
    for row, place in enumerate(places):
        y, x = np.unravel_index(maps[point][row].argmax(), stack.shape[1:])
        assert np.linalg.norm(stack.from_grid(np.array([x, y])) - place) < 10


def test_each_is_a_negative_of_the_other(maps, stack):
    for row in (0, 1):
        for place, own, other in ((STRIPED[row], 0, 2), (CHECKED[row], 2, 0)):
            x, y = np.round(stack.to_grid(np.array(place))).astype(int)
            disc = np.s_[row, y - 2 : y + 3, x - 2 : x + 3]
            assert maps[own][disc].mean() > 10 * maps[other][disc].mean()


def test_a_point_that_was_not_clicked_is_nowhere_and_ratios_are_bounded(maps):
    assert (maps[1] == np.float32(PARAMETERS.lowest)).all()
    for values in maps.values():
        assert values.min() >= np.float32(PARAMETERS.lowest)
        assert values.max() <= np.float32(PARAMETERS.highest)


def test_rows_that_are_asked_for_are_those_of_the_whole(maps, stack):
    training_frame = TrainingFrame({0: np.array(STRIPED[0], float), 2: np.array(CHECKED[0], float)})
    classify = learn_appearance(stack, {0: training_frame}, n_points=3, parameters=PARAMETERS)
    alone = appearance_maps(stack, classify, points=[2], parameters=PARAMETERS, rows=[1])
    assert list(alone) == [2]
    # and learning is deterministic; blurs differ in the last digits
    np.testing.assert_allclose(alone[2], maps[2][1:], rtol=1e-5)


def test_a_doubtful_place_is_no_background(stack, monkeypatch):
    """The chequer without a name is background, or, where it is said to be doubtful, left out."""
    taken = []
    monkeypatch.setattr(
        appearance, "train_classifier", lambda features, labels, **_: taken.append(labels)
    )
    every = AppearanceParameters(copies=1, background=10**6)
    for doubtful in ((), (np.array(CHECKED[0], float),)):
        training_frame = TrainingFrame({0: np.array(STRIPED[0], float)}, doubtful)
        learn_appearance(stack, {0: training_frame}, n_points=1, parameters=every)
    # places are 4 px apart, the radius is 10 px: the point's are those within 0.55 radii, and
    # up to 1 radius nothing is said; of the doubtful place up to 1.2 radii
    assert (taken[0] == 1).sum() == pytest.approx(np.pi * 5.5**2 / 16, abs=3)
    assert len(taken[0]) == pytest.approx(40 * 24 - np.pi * (10**2 - 5.5**2) / 16, abs=5)
    assert len(taken[0]) - len(taken[1]) == pytest.approx(np.pi * 12**2 / 16, abs=5)
