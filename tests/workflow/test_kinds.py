"""What is done by kind of trial is found once, and nothing asks for the kind again."""

from __future__ import annotations

import ast
import dataclasses
import re
from pathlib import Path

import pytest

import pawnb
from pawnb.errors import InputError
from pawnb.trial import Animal, Trial
from pawnb.trial.kinds import TRAITS
from pawnb.workflow.kinds import PointTrials, PoseTrials, TrialKind, kind_of

PACKAGE = Path(pawnb.__file__).parent


def trial(kind):
    return Trial(kind=kind, name="t", fps=100.0, animal=Animal(id="a"), folder=Path())


def compares_kind(tree):
    """Say whether the kind of a trial is compared with anything, or ``kind`` with one of them."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Compare):
            sides = (node.left, *node.comparators)
            parts = [part for side in sides for part in ast.walk(side)]
            values = {part.value for part in parts if isinstance(part, ast.Constant)}
            for side in sides:
                name = ast.unparse(side)
                if re.search(r"\btrials?(\[\d+\])?\.kind$", name):
                    return True
                if name.split(".")[-1] == "kind" and values & set(TRAITS):
                    return True
    return False


def test_each_kind_has_an_object_with_everything_that_is_asked_of_it():
    assert isinstance(kind_of(trial("paws")), PointTrials)
    assert isinstance(kind_of(trial("pose")), PoseTrials)
    asked = {name for name in vars(TrialKind) if not name.startswith("_")}
    assert len(asked) == 7
    for kind in (PointTrials, PoseTrials):
        assert asked <= set(vars(kind))


def test_starts_are_those_of_the_kind():
    both = {"start_points": "clicks.csv", "start_pose": "pose.csv"}
    for kind, file in (("paws", "clicks.csv"), ("pose", "pose.csv")):
        own = dataclasses.replace(trial(kind), **both)
        assert kind_of(own).start_file(own) == file


TRACKS = pawnb.schema.make_tracks([0, 1], ["FR"], fps=100.0)


@pytest.mark.parametrize(
    "call", [pawnb.track, pawnb.propose_start, lambda own: pawnb.retrack(own, TRACKS, 0)]
)
def test_what_another_program_has_tracked_is_refused(call):
    with pytest.raises(InputError) as refused:
        call(trial("tracks"))
    words = "trial 't' is of kind 'tracks'; tracking needs kind 'paws' or 'pose'."
    assert str(refused.value) == words


def test_a_comparison_is_found():
    assert compares_kind(ast.parse("if self.trial.kind == 'paws': pass"))
    assert compares_kind(ast.parse("a = 'pose' != trials[0].kind"))
    assert compares_kind(ast.parse("a = self.kind in ('paws', 'tracks')"))
    assert compares_kind(ast.parse("a = trial.kind == other"))
    assert not compares_kind(ast.parse("a = event.kind == 'td'; b = KINDS[trial.kind]"))


def test_nothing_asks_for_the_kind_of_a_trial():
    """A third kind is registered: in ``TRAITS``, among the trackers, and in ``kinds``."""
    texts = {path: path.read_text(encoding="utf-8") for path in PACKAGE.rglob("*.py")}
    found = {
        path.relative_to(PACKAGE).as_posix()
        for path, text in texts.items()
        if "kind" in text and compares_kind(ast.parse(text))
    }
    assert found == set()
