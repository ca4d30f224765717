"""Work on two threads: in order, at once, and nothing that fails is passed over."""

import threading

import pytest

from pawnb.core.parallel import on_threads


def test_results_come_in_the_order_of_the_items():
    met = threading.Barrier(2, timeout=20)

    def work(item):
        met.wait()  # goes on only if another is worked on at the same time
        return item**2

    assert on_threads(work, range(8)) == [0, 1, 4, 9, 16, 25, 36, 49]
    assert on_threads(work, []) == []
    assert on_threads(lambda _: threading.current_thread(), [1]) == [threading.current_thread()]


def test_what_fails_is_told():
    with pytest.raises(ZeroDivisionError):
        on_threads(lambda item: 1 / item, [1, 0, 2])
