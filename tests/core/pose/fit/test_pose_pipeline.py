"""The steps of the pose tracker: each returns a new state and changes nothing in the one before."""

from __future__ import annotations

import dataclasses
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))
from painted_walk import painted_walk

from pawnb.core.frame_checkpoint import KeptFrames
from pawnb.core.pose.fit import pipeline
from pawnb.core.pose.fit.rendering.canvas import Canvas
from pawnb.core.pose.fit.sequence.between_annotations import Ways
from pawnb.core.pose.fit.settings import PoseSettings
from pawnb.core.pose.fit.state import PoseFitState, PoseRecording
from pawnb.core.pose.fit.steps import Steps

STEPS = (
    "fit_starts", "follow", "learn_what_hides", "fit_starts_again", "follow", "learn_appearance",
    "fit_together",
)  # fmt: skip
"""In their order, where something hides legs."""


def recording(n=4):
    """Return a painted walk from two start poses, and its steps as they are counted."""
    animal, poses, reader, background = painted_walk(n)
    counted = []
    steps = Steps(2 * n + n - 1, lambda done, total: counted.append((done, total)))
    given = PoseRecording(
        frame=reader.frame,
        ways=Ways(lambda numbers: map(reader.frame, numbers), steps, KeptFrames()),
        frames=(0, n),
        start=poses.take([0, n - 1]),
        reference=poses.take([0]),
        animal=animal,
        background=background,
        settings=PoseSettings(),
    )
    return given, counted


def contents(value):
    """Return all that a state holds, as plain values; the room to paint on does not count."""
    if isinstance(value, (PoseRecording, Canvas)):
        return None
    if isinstance(value, np.ndarray):
        return value.shape, value.tobytes()
    if dataclasses.is_dataclass(value):
        return {f.name: contents(getattr(value, f.name)) for f in dataclasses.fields(value)}
    if isinstance(value, dict):
        return {key: contents(item) for key, item in value.items()}
    if isinstance(value, (tuple, list)):
        return [contents(item) for item in value]
    return repr(value)


@pytest.mark.slow
def test_no_step_writes_into_the_state_that_it_is_given(monkeypatch):
    given, counted = recording()
    called = []

    def watch(name):
        step = getattr(pipeline, name)

        def watched(state):
            before = contents(state)
            after = step(state)
            assert contents(state) == before, name
            assert isinstance(after, PoseFitState)
            assert contents(after) != before, f"{name} learnt nothing"
            called.append(name)
            return after

        monkeypatch.setattr(pipeline, name, watched)

    for name in set(STEPS):
        watch(name)
    # as if a small marker were fixed to the body
    marker = np.zeros((301, 301), bool)
    marker[148:153, 120:126] = True
    monkeypatch.setattr(pipeline, "find_attached_clutter", lambda *_: marker)
    state = pipeline.run_pipeline(given)
    assert called == list(STEPS)
    assert state.passes == 2
    assert [one.frame for one in state.frames] == [0, 1, 2, 3]
    assert len(state.final_fits) == len(state.poses) == 4
    # two ways of 4 frames and 3 between the starts, twice over the ways, and 4 fits together
    assert counted[-1][1] == 2 * 4 + 3 + 4 + 3


@pytest.mark.slow
def test_what_is_fixed_to_nothing_needs_no_second_pass():
    state = pipeline.run_pipeline(recording(3)[0])
    assert state.passes == 1
    assert state.fitter.clutter.attached is None
