"""Fixtures that tests of several widgets share."""

import pytest

import pawnb


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
