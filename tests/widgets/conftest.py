"""Fixtures that tests of several widgets share."""

import threading

import pytest
from ipywidgets.widgets import widget as registry

import pawnb

_LONGEST_WAIT_S = 60.0


@pytest.fixture(autouse=True)
def _threads_end_with_their_test():
    """Close the widgets of a test, and wait for the threads that they leave.

    Filters of warnings belong to the process, and pandas changes them on every thread: one that
    still analyses while the next test begins takes that test's filters away when it is done.
    """
    widgets, threads = set(registry._instances), set(threading.enumerate())
    yield
    for name, widget in list(registry._instances.items()):
        if name not in widgets:
            widget.close()
    for thread in set(threading.enumerate()) - threads:
        if thread.name.startswith("pawnb-"):
            thread.join(_LONGEST_WAIT_S)


@pytest.fixture
def opened():
    """Open workbenches, and close them after the test."""
    benches = []

    def open_it(*args, **options):
        benches.append(pawnb.Workbench(*args, **options))
        return benches[-1]

    yield open_it
    for bench in benches:
        bench.close()
