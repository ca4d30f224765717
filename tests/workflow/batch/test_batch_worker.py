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


def _order_of(trial, out, settings):
    return {
        "trial": str(trial), "method": "pawnb", "settings": settings, "command": [],
        "out": str(out),
    }  # fmt: skip


@pytest.mark.slow
def test_what_another_batch_has_tracked_since_it_was_ordered_is_not_tracked_again(
    small_spider, tmp_path
):
    """Of a scheduler 64 trials wait: two batches of one study tracked each of them twice."""
    quick = {"choose_path": False}
    order = _order_of(small_spider, tmp_path / "results", quick)
    assert worker._track(order, threading.Event())["status"] == "tracked"
    file = tmp_path / "results" / "tracks.nc"
    before = file.stat()
    answer = worker._track(order, threading.Event())
    assert answer["status"] == "skipped"
    assert answer["verdict"] == "good"
    assert (file.stat().st_ino, file.stat().st_mtime_ns) == (before.st_ino, before.st_mtime_ns)


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (MemoryError(), "the memory was too small for it: let fewer trials run at once"),
        (OSError(28, "No space left on device", "a.bin"), "a.bin: No space left on device"),
    ],
)
def test_a_full_memory_or_disk_is_said_in_words(small_spider, tmp_path, monkeypatch, error, said):
    def track(*_trial, **_options):
        raise error

    monkeypatch.setattr(worker, "track", track)
    answer = worker._track(_order_of(small_spider, tmp_path / "results", {}), threading.Event())
    assert answer["status"] == "failed"
    assert answer["said"].startswith(said)
