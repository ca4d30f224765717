"""How long a person has worked: what counts, and what is kept."""

import json

import pytest

from pawnb.core.edits.working_time import PAUSE_S, WorkingTime


def work(time, clock, *gaps):
    for gap in gaps:
        clock[0] += gap
        time.hear()


def test_gaps_count_and_pauses_do_not_over_sessions_and_windows(tmp_path):
    clock, path = [5.0], tmp_path / "minutes.jsonl"
    first = WorkingTime(path, clock=lambda: clock[0])
    work(first, clock, 3.0, 4.0)  # what lies before the first thing done is not known
    assert first.seconds == 4.0
    assert not path.exists()
    work(first, clock, PAUSE_S + 1, 6.5)
    assert [json.loads(line) for line in path.read_text().splitlines()] == [
        {"edit": "worked", "seconds": 10.5}
    ]
    # another window has the time so far, and both write behind each other
    second = WorkingTime(path, clock=lambda: clock[0])
    work(second, clock, 1.0, 2.0, 30.0)
    work(first, clock, 5.0)  # 38 s after its last: no pause
    first.keep()
    second.keep()
    again = WorkingTime(path, clock=lambda: clock[0])
    assert again.seconds == pytest.approx(10.5 + 32.0 + 38.0)
    assert again.minutes == pytest.approx(80.5 / 60)


def test_a_file_that_is_none_or_cannot_be_written_stops_nobody(tmp_path):
    clock, path = [0.0], tmp_path / "minutes.jsonl"
    path.write_text("not ours\n")
    time = WorkingTime(path, clock=lambda: clock[0])
    work(time, clock, 1.0, 50.0)
    time.keep()
    assert time.seconds == 50.0
    assert path.read_text() == "not ours\n"
