"""What the process of one trial answers."""

import threading

import pytest

from pawnb.schema import make_tracks
from pawnb.workflow.batch import worker

ORDER = {"trial": "t", "method": "pawnb", "settings": {}, "out": "t/results", "command": []}


@pytest.mark.parametrize(
    ("frames", "said", "verdict"),
    [(0, "interrupted before the first frame was tracked", ""), (3, "3 frames, t/results; ", None)],
)
def test_a_trial_that_had_only_begun_is_not_judged(monkeypatch, frames, said, verdict):
    stop = threading.Event()

    def track(_trial, **_options):
        stop.set()  # Ctrl-C meanwhile
        return make_tracks(range(frames), ["FR"], fps=25.0, views=["side"])

    monkeypatch.setattr(worker, "load_trial", lambda path: path)
    monkeypatch.setattr(worker, "track", track)
    answer = worker._track(ORDER, stop)
    assert answer["status"] == "stopped"
    assert answer["said"].startswith(said)
    assert verdict is None or answer.get("verdict", "") == verdict
