"""Work on threads: in order, at once, and nothing that fails is passed over."""

import threading

import cv2
import numpy as np
import pytest
from threadpoolctl import ThreadpoolController, threadpool_limits

from pawnb.core.parallel import calls_on_one_thread, in_parts, on_threads
from pawnb.core.parameters import parameters_set
from pawnb.core.paws.offline.detection.parameters import LEARNT


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


def test_parts_come_in_order_with_the_parameters_in_force():
    with parameters_set({"learnt_detection": {"nowhere": 0.25}}):
        found = in_parts(lambda a, b: (a, b, LEARNT.nowhere), range(11), "abcdefghijk")
    assert found == [(i, one, 0.25) for i, one in enumerate("abcdefghijk")]
    assert in_parts(abs, []) == []
    with pytest.raises(ZeroDivisionError):
        in_parts(lambda item: 1 / item, [1, 0, 2])


def threads_of_products():
    """Return how many threads numpy's linear algebra may use."""
    assert np.dot([1.0], [1.0]) == 1.0  # loaded
    blas = ThreadpoolController().select(user_api="blas").info()
    return max(one["num_threads"] for one in blas)


def test_products_are_of_one_thread_until_the_last_block_ends():
    with threadpool_limits(3, user_api="blas"):
        first, second = calls_on_one_thread(), calls_on_one_thread()
        first.__enter__()
        assert threads_of_products() == 1
        second.__enter__()
        first.__exit__(None, None, None)  # they overlap, as on two threads
        assert threads_of_products() == 1
        second.__exit__(None, None, None)
        assert threads_of_products() == 3


@pytest.fixture
def three_of_opencv():
    before = cv2.getNumThreads()
    cv2.setNumThreads(3)
    yield
    cv2.setNumThreads(before)


@pytest.mark.usefixtures("three_of_opencv")
def test_opencv_is_of_one_thread_until_the_last_block_ends():
    first, second = calls_on_one_thread(), calls_on_one_thread()
    first.__enter__()
    second.__enter__()
    first.__exit__(None, None, None)
    assert cv2.getNumThreads() == 1
    second.__exit__(None, None, None)
    assert cv2.getNumThreads() == 3


def test_a_block_that_fails_gives_the_threads_back():
    with threadpool_limits(3, user_api="blas"):
        with pytest.raises(ZeroDivisionError), calls_on_one_thread():
            _ = 1 / 0
        assert threads_of_products() == 3
