"""Clicked frames left out in turn: what finds them is trusted."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from pawnb.core.paws.offline import weighing
from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.parameters import OfflineParameters, SceneParameters
from pawnb.core.paws.offline.view_input import ViewInput
from pawnb.core.paws.offline.weighing import weigh

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


@pytest.mark.parametrize("rows", [[4], [2, 11]])
def test_where_too_few_frames_stay_the_usual_trust_is_kept(view, rows):
    found = weigh([view(rows)], 1, PARAMETERS)
    assert found.trust == PARAMETERS.appearance.trust
    assert not len(found.found)


def test_appearance_is_trusted_where_it_finds_what_was_left_out(view):
    found = weigh([view([1, 5, 8, 12])], 1, PARAMETERS)
    assert found.trust > 0
    assert np.median(found.found) > 0.8
    assert len(found.found) == 4  # folds


def test_another_trust_must_be_clearly_better(view, monkeypatch):
    """Products of the chances: 0.05 + 0.5 against 0.05 + 0.55 is no reason, 0.9 against 0 is."""
    usual = PARAMETERS.appearance.trusts.index(PARAMETERS.appearance.trust)
    table = np.full((2, len(PARAMETERS.appearance.trusts)), 0.5)
    table[:, 0] = 0.55
    monkeypatch.setattr(weighing, "_left_out", lambda *a: table)
    assert weigh([view([4])], 1, PARAMETERS).trust == PARAMETERS.appearance.trust
    table[:, 0], table[:, usual] = 0.9, 0.0
    assert weigh([view([4])], 1, PARAMETERS).trust == PARAMETERS.appearance.trusts[0]
