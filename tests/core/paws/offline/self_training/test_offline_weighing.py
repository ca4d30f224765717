"""Clicked frames left out in turn: what finds them is trusted."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.parameters import OfflineParameters, SceneParameters
from pawnb.core.paws.offline.quality.left_out import LeftOutClick
from pawnb.core.paws.offline.quality.signs import SIGNS
from pawnb.core.paws.offline.self_training import weighing
from pawnb.core.paws.offline.self_training.weighing import Powers, Weighing, usual_powers, weigh
from pawnb.core.paws.offline.view_input import ViewInput

N = 15
PARAMETERS = OfflineParameters(
    scene=SceneParameters(spacing=4),
    appearance=dataclasses.replace(
        OfflineParameters().appearance, networks=1, copies=3, epochs=15, radius=6.0
    ),
)


@pytest.fixture
def view(make_texture, make_stack):
    """A patch that jumps to and fro too far for flow: only its texture tells where it is."""
    patch = make_texture(15, 15, seed=3, low=0, high=255)
    pictures = np.repeat(make_texture(60, 120, low=90, high=130)[None], N, axis=0)
    places = [(30 + 50 * (t % 2), 30) for t in range(N)]
    for t, (u, v) in enumerate(places):
        pictures[t, v - 7 : v + 8, u - 7 : u + 8] = patch

    def clicked(rows):
        marks = Annotations({t: {0: np.array(places[t], float)} for t in rows})
        return ViewInput("side", (120, 60), make_stack(pictures, spacing=4), marks)

    return clicked


USUAL = usual_powers(PARAMETERS)
MOTION, APPEARANCE = Powers(0.0), Powers(USUAL.appearance, motion=0.0)


def test_one_clicked_frame_shows_nothing(view):
    assert weigh([view([4])], 1, PARAMETERS) == Weighing(USUAL)


def test_of_two_clicked_frames_labels_are_learnt_but_no_powers(view):
    found = weigh([view([2, 11])], 1, PARAMETERS)
    assert found.powers == USUAL
    assert found.offsets.keys() == {0}


@pytest.mark.slow
def test_appearance_is_trusted_where_it_finds_what_was_left_out(view):
    found = weigh([view([1, 5, 8, 12])], 1, PARAMETERS)
    assert found.powers.appearance > 0
    # three of four are found, about as many as their signs say
    assert found.offsets[0] == pytest.approx(0.0, abs=0.3)


@pytest.fixture
def chosen(monkeypatch):
    """What is chosen where a left-out click is found as given, in three frames between others."""

    def choose(by_powers):
        tried = []

        class Frame:
            between = True

            def __init__(self, *_):
                pass

            def outcome(self, powers):
                tried.append(powers)
                found = by_powers.get(powers, 0.5)
                return [LeftOutClick(0, found, found > 0.5, np.zeros(len(SIGNS)))]

        monkeypatch.setattr(weighing, "_LeftOut", Frame)
        monkeypatch.setattr(weighing, "_left_out_rows", lambda *_: [4, 9, 12])
        return weigh([None], 1, PARAMETERS), set(tried)

    return choose


def test_other_powers_must_be_clearly_better(chosen):
    """Each counts log(0.95 / 0.05) = 2.9 where it is found with 0.9 and not with 0: three do, two
    would not.
    """
    assert chosen({MOTION: 0.55})[0].powers == USUAL
    assert chosen({MOTION: 0.9, USUAL: 0.0})[0].powers == MOTION


@pytest.mark.parametrize("alone", [MOTION, APPEARANCE])
def test_a_single_kind_that_finds_more_is_trusted_alone(chosen, alone):
    found, _ = chosen({alone: 1.0, USUAL: 0.0})
    assert found.powers == alone
    assert found.offsets[0] > chosen({})[0].offsets[0]  # what it finds tells of labels


def test_nothing_is_tried_where_nothing_can_be_clearly_better(chosen):
    assert chosen({USUAL: 0.9})[1] == {USUAL}
