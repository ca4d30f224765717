"""The pass backwards, on a follower that finds what is expected: answers worked out by hand."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from pawnb.core.pose.fit.candidates import viterbi_path
from pawnb.core.pose.fit.sequence.state import Followed

FITTER = SimpleNamespace(
    index=SimpleNamespace(numbers=(np.array([1]), np.array([2])), lengths=np.array([3])),
    anatomy=None,
)
"""Two legs of one number each, after a place and a length."""


def followed(n):
    """Return n frames, in which a pose moves by 10 a frame and its length by 1."""
    frames = [
        SimpleNamespace(
            pose=np.array([10.0 * t, 10.0 * t, -10.0 * t, 1.0 * t]),
            grey=np.zeros((2, 2)), box=None, frame=t, legs=((np.zeros(1),), (np.zeros(1),)),
        )
        for t in range(n)
    ]  # fmt: skip
    return Followed(FITTER, tuple(frames), middle=np.zeros(1), jump_px=4.0)


@pytest.fixture(autouse=True)
def expected(monkeypatch):
    """Find every pose where it is expected; return these."""
    asked = []

    def fit_expected(_fitter, expected, **_):
        asked.append(expected)
        return expected

    monkeypatch.setattr(viterbi_path, "evidence_of", lambda *_, **__: None)
    monkeypatch.setattr(viterbi_path, "usual_anatomy", lambda *_: None)
    monkeypatch.setattr(viterbi_path, "expectation", lambda *_: None)
    monkeypatch.setattr(viterbi_path, "fit_expected", fit_expected)
    return asked


@pytest.fixture
def added(monkeypatch):
    """Let frames become the candidates that are added to them."""

    def add(_fitter, candidates, extra, **_):
        return {leg: [float(x[0]) for x in poses] for leg, poses in extra.items()}

    monkeypatch.setattr(viterbi_path, "with_candidates", add)


@pytest.mark.usefixtures("added")
def test_a_doubtful_frame_is_expected_where_the_sure_frames_after_it_come_from(expected):
    found = viterbi_path._second_pass(followed(5), [1])
    # frame 2 is at 20 and frame 3 at 30: nine tenths of that step back from 20; lengths stay
    np.testing.assert_allclose(expected[0], [11.0, 11.0, -11.0, 2.0])
    assert found == {1: {0: [11.0], 1: [-11.0]}}


@pytest.mark.usefixtures("added")
def test_neighbouring_doubtful_frames_are_followed_on_from_what_was_found():
    found = viterbi_path._second_pass(followed(5), [1, 2])
    # at 30, the step from 40 to 30: 30 - 9 = 21; then the step from 30 to 21: 21 - 0.9 * 9
    assert found[2][0] == [21.0]
    assert found[1][0] == [pytest.approx(12.9)]


@pytest.mark.usefixtures("added")
def test_the_last_frame_has_none_after_it():
    assert viterbi_path._second_pass(followed(3), [2]) == {2: {0: [20.0], 1: [-20.0]}}
    # one frame after it tells a place, but no speed
    assert viterbi_path._second_pass(followed(3), [1])[1][0] == [20.0]


def test_a_lost_leg_is_followed_back_until_it_is_known(monkeypatch):
    """From frame 4 on it is at 8.0; frame 1 knows that place already."""
    way = followed(6)
    looked = []

    def fit_leg(_fitter, _pose, leg, *, guess, **_):
        looked.append(leg)
        return np.array([8.0])

    def add(_fitter, candidates, extra, **_):
        if candidates.frame == 1:
            return candidates
        legs = (candidates.legs[0], (*candidates.legs[1], extra[1][0]))
        return SimpleNamespace(**vars(candidates) | {"legs": legs})

    monkeypatch.setattr(viterbi_path, "fit_leg", fit_leg)
    monkeypatch.setattr(viterbi_path, "with_candidates", add)
    after = viterbi_path._traced(way, [(1, 4, np.array([8.0]))])
    assert looked == [1, 1, 1]  # frames 3, 2 and 1, and not 0
    assert [len(one.legs[1]) for one in after.frames] == [1, 1, 2, 2, 1, 1]
    assert all(len(one.legs[1]) == 1 for one in way.frames)  # what was given is not changed
