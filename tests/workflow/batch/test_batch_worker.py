"""What the process of one trial answers."""

import threading

import pytest

from pawnb.core.video import ViewSet
from pawnb.workflow.batch import worker


@pytest.mark.slow
@pytest.mark.parametrize(
    ("after", "said", "judged"),
    [(0, "interrupted before the first frame was tracked", False), (6, "6 frames, ", True)],
)
def test_a_trial_that_had_only_begun_is_not_judged(
    small_trial, tmp_path, monkeypatch, after, said, judged
):
    stop, plain = threading.Event(), ViewSet.frames

    def frames(self, start, end, **options):
        for i, pictures in plain(self, start, end, **options):
            if i == after:
                stop.set()  # Ctrl-C meanwhile
            yield i, pictures

    monkeypatch.setattr(ViewSet, "frames", frames)
    order = {
        "trial": str(small_trial), "method": "pawnb", "settings": {}, "command": [],
        "out": str(tmp_path / "results"),
    }  # fmt: skip
    answer = worker._track(order, stop)
    assert answer["status"] == "stopped"
    assert answer["said"].startswith(said)
    assert ("verdict" in answer) == judged
