"""Work on several threads comes back in the order in which it was given."""

import threading
import time
from types import SimpleNamespace

import pytest

from pawnb.core.pose.fit.parallel import on_threads, side_by_side, threaded
from pawnb.core.pose.fit.steps import Steps


def slow_square(number: int) -> int:
    time.sleep(0.01 * (5 - number))  # the first takes longest
    return number**2


@pytest.mark.parametrize("n", [0, 1, 2, 5])
def test_results_come_in_the_order_of_their_items(n):
    assert threaded(slow_square, range(n)) == [k**2 for k in range(n)]


def test_each_thread_has_a_fitter_of_its_own():
    made = []

    def twin():
        made.append(SimpleNamespace(busy=False))
        return made[-1]

    def work(own, number):
        assert not own.busy
        own.busy = True
        time.sleep(0.01)
        own.busy = False
        return number**2

    found = on_threads(SimpleNamespace(twin=twin), [4, 1, 3, 0], work)
    assert found == [16, 1, 9, 0]
    assert len(made) > 1


def test_what_goes_wrong_in_a_thread_is_said():
    with pytest.raises(ZeroDivisionError):
        threaded(lambda x: 1 / x, [1, 0, 2])


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
