"""Which frames the look is learnt from again: sure ones where there are enough, spread evenly."""

from __future__ import annotations

from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
import pytest

from pawnb.core.pose.fit.learning import relearn
from pawnb.core.pose.fit.learning.clutter import Clutter
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import Prior


class Fitter(NamedTuple):
    """Stands for a fitter: how often appearance was learnt."""

    learnt: int = 0
    clutter: Clutter = Clutter()

    def with_clutter(self, clutter):
        return self._replace(clutter=clutter)


@pytest.mark.parametrize(("first_sure", "first_learnt"), [(70, 70), (95, 0)])
def test_sure_frames_are_learnt_from_unless_there_are_too_few(
    monkeypatch, first_sure, first_learnt
):
    """30 sure frames of 100 are enough, 5 are not: then all count."""
    asked = []

    def fit_all(_work, frames):
        asked.append(list(frames))
        return [(np.full(2, -1.0), None) for _ in frames]

    def learn(fitter, *_, **__):
        return fitter._replace(learnt=fitter.learnt + 1)

    monkeypatch.setattr(relearn, "on_threads", fit_all)
    monkeypatch.setattr(relearn, "fit_appearance", learn)
    monkeypatch.setattr(relearn, "usual_lengths", lambda *_: None)
    monkeypatch.setattr(relearn, "find_body_clutter", lambda *_: None)
    monkeypatch.setattr(relearn, "find_leg_clutter", lambda *_: None)
    monkeypatch.setattr(relearn, "counted", lambda _fitter, _pose, image_evidence: image_evidence)
    fitter = Fitter()
    found = [SimpleNamespace(is_open=i < first_sure) for i in range(100)]
    learnt, poses = relearn.learn_again(fitter, found, np.zeros((100, 2)))
    assert asked[0] == asked[1]  # two turns
    assert (fitter.learnt, learnt.learnt) == (0, 2)
    chosen = asked[0]
    assert (chosen[0], chosen[-1], len(chosen)) == (first_learnt, 99, 12)
    # nowhere more than a twelfth of the way to the next
    assert np.diff(chosen).max() <= np.ceil((99 - first_learnt) / 11)
    assert (poses[chosen] == -1.0).all()
    assert (np.delete(poses, chosen, axis=0) == 0.0).all()


def test_usual_lengths_are_medians():
    anatomy = Prior(*[np.zeros(3) for _ in Prior._fields])
    fitter = SimpleNamespace(anatomy=anatomy, index=SimpleNamespace(lengths=np.array([1, 2])))
    poses = np.array([[9.0, 1.0, -1.0], [9.0, 2.0, -2.0], [9.0, 7.0, -9.0]])
    np.testing.assert_array_equal(relearn.usual_lengths(fitter, poses).middle, [0.0, 2.0, -2.0])
