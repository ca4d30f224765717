"""Work on several threads comes back in the order in which it was given."""

import time
from types import SimpleNamespace

import pytest

from pawnb.core.pose.fit.threads import on_threads, threaded


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
