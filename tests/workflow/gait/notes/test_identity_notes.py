"""Animals that are pieces of one, found twice, or exchanged, as the tracks were made to be."""

from __future__ import annotations

import numpy as np
import pytest
from trotting import walking_tracks

from pawnb.workflow.gait.notes.identity_notes import notes_on_identities

N = 240
CUT = 120


def two_animals(*, apart=600.0):
    """Two mice that trot side by side, ``apart`` px from each other, the second 10 frames on."""
    both = walking_tracks("t", "m").isel(individual=[0, 0], time=slice(0, N)).copy(deep=True)
    both = both.assign_coords(individual=["m1", "m2"])
    place = both["position"].to_numpy()
    place[..., 1] = np.roll(place[..., 1], 10, axis=0)
    place[:, 0, :, 1] += apart
    return both


def said(tracks):
    return list(notes_on_identities("two.slp", tracks))


def test_two_animals_that_are_what_they_are_called_are_not_doubted():
    assert said(two_animals()) == []
    one = two_animals()
    one["position"].to_numpy()[40:120, ..., 0] = np.nan  # absent for a while
    assert said(one) == []
    assert said(one.isel(individual=[0])) == []


def test_names_that_were_exchanged_are_told_with_the_frame():
    tracks = two_animals()
    place = tracks["position"].to_numpy()
    place[CUT:] = place[CUT:, ..., ::-1].copy()
    (note,) = said(tracks)
    assert note.startswith("two.slp: m1 and m2 take each other's place once, first from frame 119 ")
    place[CUT + 50 :] = place[CUT + 50 :, ..., ::-1].copy()
    place[CUT - 3 : CUT + 2, ..., 1] = np.nan  # one of them is hidden while they cross
    (note,) = said(tracks)
    assert "take each other's place 2 times, first from frame 116 to 122" in note


@pytest.mark.parametrize("part", [slice(60, 100), slice(0, N)])
def test_an_animal_that_was_found_twice_is_told(part):
    # as SLEAP finds one animal twice: two instances, some px apart
    tracks = two_animals()
    place = tracks["position"].to_numpy()
    noise = np.random.default_rng(0).normal(0.0, 0.5, place[part, ..., 0].shape)
    place[part, ..., 1] = place[part, ..., 0] + noise
    n = len(place[part])
    (note,) = said(tracks)
    assert f"lie on one another in {n} of the {N} frames in which both are seen" in note
    assert f"first in frame {part.start}: one animal was found twice" in note


@pytest.mark.parametrize(("overlap", "often"), [(0, "never"), (5, "hardly ever")])
def test_pieces_of_one_track_are_told_also_where_they_overlap(overlap, often):
    tracks = two_animals()
    place = tracks["position"].to_numpy()
    place[CUT + overlap :, ..., 0] = np.nan
    place[:CUT, ..., 1] = np.nan
    (note,) = said(tracks)
    assert note.startswith(f"two.slp: m1 and m2 are {often} seen in one frame. Where they are pie")


def test_tracks_of_the_pictures_alone_are_looked_at_in_every_view():
    tracks = two_animals()
    both = tracks["position"].to_numpy()
    shown = np.stack([both, both], axis=1)[:, :, :2]
    shown[:, 1, ..., 1] = shown[:, 1, ..., 0]  # in the second view they are one
    order = ("time", "view", "image_space", "keypoint", "individual")
    tracks = tracks.drop_vars([v for v in tracks.variables if "image" in str(v)])
    tracks = tracks.assign(image_position=(order, shown))
    tracks["position"].to_numpy()[:] = np.nan
    assert said(tracks) == []  # half of the points are apart
    shown[:, 0, ..., 1] = shown[:, 0, ..., 0]
    assert len(said(tracks.assign(image_position=(order, shown)))) == 1
