"""Benchmarks are scripts in a folder of their own, which import each other by name."""

from pathlib import Path

import pytest


@pytest.fixture(autouse=True)
def _on_the_path(monkeypatch):
    monkeypatch.syspath_prepend(str(Path(__file__).parents[2] / "benchmarks"))
