"""Trackers of both animals offer the same calls, and are found by kind and name."""

from __future__ import annotations

import dataclasses
import inspect

import pytest

from pawnb.core.parameters import defaults_of
from pawnb.core.paws import tracker as registry
from pawnb.core.paws.tracker import DEFAULT, Tracker, find_tracker, trackers
from pawnb.errors import InputError

EVERY = [tracker for kind in ("paws", "pose") for tracker in trackers(kind).values()]


def test_methods_are_those_of_the_documentation_and_the_default_comes_first():
    # docs/methods.md and docs/published_methods.md
    assert tuple(trackers("paws")) == ("pawnb", "paper", "slic-3d", "slic-2d")
    assert tuple(trackers("pose")) == ("pawnb", "paper")
    assert {next(iter(trackers(kind))) for kind in ("paws", "pose")} == {DEFAULT}
    assert trackers("tracks") == {}


@pytest.mark.parametrize("tracker", EVERY, ids=lambda t: f"{t.kind}-{t.name}")
@pytest.mark.parametrize("call", ["track", "resume", "retrack"])
def test_every_tracker_is_called_alike(tracker, call):
    """Arguments have the names of the protocol, in its order, and the same ones by keyword."""
    asked = inspect.signature(getattr(Tracker, call)).parameters.values()
    own = inspect.signature(getattr(type(tracker), call)).parameters.values()
    assert [(p.name, p.kind) for p in own] == [(p.name, p.kind) for p in asked]


@pytest.mark.parametrize("tracker", EVERY, ids=lambda t: f"{t.kind}-{t.name}")
def test_settings_and_stages_of_every_tracker_are_there(tracker):
    assert dataclasses.is_dataclass(tracker.settings)
    assert all(dataclasses.is_dataclass(defaults_of(stage)) for stage in tracker.stages)
    assert find_tracker(tracker.kind, tracker.name) is tracker


def test_an_unknown_method_is_answered_with_a_near_one():
    with pytest.raises(InputError, match=r"unknown method 'papr' \(did you mean 'paper'\?\)"):
        find_tracker("paws", "papr")
    with pytest.raises(InputError, match="expected pawnb, paper"):
        find_tracker("pose", "slic-3d")


def test_a_published_tracker_learns_only_where_it_is_asked_to(monkeypatch):
    """``retrack`` hands on what a correction says, ``track`` and ``resume`` know of none."""
    told = []
    monkeypatch.setattr(
        registry, "track_maghsoudi2019", lambda *_a, **named: told.append(named.get("learn_at"))
    )
    tracker = find_tracker("paws", "slic-2d")
    settings, kept = tracker.settings(), registry.KeptEvidence()
    tracker.track(None, None, None, settings=settings, kept=kept)
    tracker.resume(None, None, None, settings=settings, kept=kept)
    corrected = registry.Correction({"FR": 7})
    tracker.retrack(None, None, None, settings=settings, corrected=corrected)
    assert told == [None, None, {"FR": 7}]
