"""Fixtures shared by all tests; the folder of real data is looked up here only."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="session")
def real_data():
    """Return a function that gives a folder of real data, or skips the test, saying why."""
    home = Path(os.environ.get("PAWNB_TEST_DATA", ROOT.parent / "shared" / "data"))

    def find(name: str) -> Path:
        folder = home / name
        if not folder.exists():
            pytest.skip(f"real data {name!r} is not in {home} (set PAWNB_TEST_DATA)")
        return folder

    return find
