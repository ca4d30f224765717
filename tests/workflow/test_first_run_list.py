"""The list of what a first run compiles holds what tracking calls, and how it calls it."""

import json
import subprocess
import sys

import pytest

from pawnb.core.first_run import LIST
from pawnb.synthetic import render_mouse_trial, render_spider_trial


@pytest.mark.slow
def test_all_that_tracking_calls_is_listed_as_it_is_called(tmp_path):
    """Else the first run would wait for it: it is compiled when it is called."""
    render_mouse_trial(tmp_path / "mouse", frames=60, scale=0.2, seed=0)
    render_spider_trial(tmp_path / "spider", frames=60, scale=0.3, seed=0)
    render_spider_trial(tmp_path / "two", frames=56, scale=0.4, seed=3, views=2)
    command = [sys.executable, "-m", "pawnb.workflow.first_run_list", "-o", "called.json"]
    subprocess.run([*command, "mouse", "spider", "two"], cwd=tmp_path, check=True)
    called = json.loads((tmp_path / "called.json").read_text(encoding="utf-8"))
    listed = json.loads(LIST.read_text(encoding="utf-8"))
    assert len(called["paws"]) > 10
    assert len(called["pose"]) > 20
    missing = [
        (kind, name, way)
        for kind, functions in called.items()
        for name, ways in functions.items()
        for way in ways
        if way not in listed[kind].get(name, [])
    ]
    assert not missing, "write the list again; CONTRIBUTING.md says how"
    superfluous = [
        (kind, name)
        for kind, functions in listed.items()
        for name in functions
        if name not in called[kind]
    ]
    assert not superfluous, "write the list again; CONTRIBUTING.md says how"
