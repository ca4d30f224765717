"""Two ways through a recording are gone at once, and end together where one fails."""

import threading
import time

import pytest

from pawnb.core.pose.fit.sequence.parallel import side_by_side
from pawnb.core.pose.fit.steps import Steps


def test_two_ways_are_gone_at_the_same_time():
    met = threading.Barrier(2, timeout=5)  # breaks if one waits for the other to end

    def way(name):
        met.wait()
        return name

    assert side_by_side(lambda: way("back"), lambda: way("on"), Steps(2)) == ("back", "on")


@pytest.mark.parametrize("fails", [0, 1])
def test_where_one_way_fails_the_other_ends_soon(fails):
    steps = Steps(2)

    def fail():
        raise ValueError("no such frame")

    def go_on():
        until = time.monotonic() + 5
        while not steps.stopped():
            assert time.monotonic() < until, "nobody said stop"
            time.sleep(0.01)

    work = [go_on, go_on]
    work[fails] = fail
    with pytest.raises(ValueError, match="no such frame"):
        side_by_side(*work, steps)


@pytest.mark.slow
def test_where_telling_fails_while_one_way_waits_the_other_ends_soon():
    def broken(*_):
        raise KeyboardInterrupt

    steps = Steps(2, broken)
    began = time.monotonic()

    def go_on():
        while not steps.stopped() and time.monotonic() < began + 5:
            time.sleep(0.01)

    with pytest.raises(KeyboardInterrupt):
        side_by_side(go_on, lambda: None, steps)
    assert steps.stopped()
