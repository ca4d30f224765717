"""The pass backwards, on a follower that finds what is expected: answers worked out by hand."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from pawnb.core.pose.fit.candidates import viterbi_path

FITTER = SimpleNamespace(
    index=SimpleNamespace(numbers=(np.array([1]), np.array([2])), lengths=np.array([3])),
    anatomy=None,
)
"""Two legs of one number each, after a place and a length."""


class Backwards:
    """A follower of n frames, in which a pose moves by 10 a frame and its length by 1."""

    fitter = FITTER

    def __init__(self, n):
        self.kept = [
            SimpleNamespace(
                pose=np.array([10.0 * t, 10.0 * t, -10.0 * t, 1.0 * t]),
                grey=np.zeros((2, 2)), box=None, frame=t, legs=[[np.zeros(1)], [np.zeros(1)]],
            )
            for t in range(n)
        ]  # fmt: skip
        self.expected = {}

    def priors(self, _):
        return None, None

    def fit_from(self, expected, _image_evidence):
        self.expected[len(self.expected)] = expected
        return expected


@pytest.fixture(autouse=True)
def no_pictures(monkeypatch):
    monkeypatch.setattr(viterbi_path, "evidence_of", lambda *_: None)


@pytest.fixture
def added(monkeypatch):
    """Record the candidates that are added, by frame."""
    found = {}

    def add(_fitter, choices, extra, **_):
        found[choices.frame] = {leg: [float(x[0]) for x in poses] for leg, poses in extra.items()}

    monkeypatch.setattr(viterbi_path, "add_candidates", add)
    return found


def test_a_doubtful_frame_is_expected_where_the_sure_frames_after_it_come_from(added):
    follower = Backwards(5)
    viterbi_path._second_pass(follower, [1])
    # frame 2 is at 20 and frame 3 at 30: nine tenths of that step back from 20; lengths stay
    np.testing.assert_allclose(follower.expected[0], [11.0, 11.0, -11.0, 2.0])
    assert added == {1: {0: [11.0], 1: [-11.0]}}


def test_neighbouring_doubtful_frames_are_followed_on_from_what_was_found(added):
    follower = Backwards(5)
    viterbi_path._second_pass(follower, [1, 2])
    # at 30, the step from 40 to 30: 30 - 9 = 21; then the step from 30 to 21: 21 - 0.9 * 9
    assert added[2][0] == [21.0]
    assert added[1][0] == [pytest.approx(12.9)]


def test_the_last_frame_has_none_after_it(added):
    follower = Backwards(3)
    viterbi_path._second_pass(follower, [2])
    assert added == {2: {0: [20.0], 1: [-20.0]}}
    viterbi_path._second_pass(follower, [1])
    assert added[1][0] == [20.0]  # one frame after it tells a place, but no speed


def test_a_lost_leg_is_followed_back_until_it_is_known(monkeypatch):
    """From frame 4 on it is at 8.0; frame 1 knows that place already."""
    follower = Backwards(6)
    looked = []

    def fit_leg(_fitter, _pose, leg, *, guess, **_):
        looked.append(leg)
        return np.array([8.0])

    def add(_fitter, choices, extra, **_):
        if choices.frame != 1:
            choices.legs[1].append(extra[1][0])

    monkeypatch.setattr(viterbi_path, "fit_leg", fit_leg)
    monkeypatch.setattr(viterbi_path, "add_candidates", add)
    viterbi_path._trace(follower, 1, 4, np.array([8.0]))
    assert looked == [1, 1, 1]  # frames 3, 2 and 1, and not 0
    assert [len(choices.legs[1]) for choices in follower.kept] == [1, 1, 2, 2, 1, 1]
