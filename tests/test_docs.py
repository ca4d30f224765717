"""The documentation names what is there: settings, their defaults, and files."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import pytest

from pawnb.core.paws import PaperSettings
from pawnb.core.paws.settings import PUBLISHED_NAMES as PAW_NAMES
from pawnb.core.pose.paper_settings import PUBLISHED_NAMES as POSE_NAMES
from pawnb.core.pose.paper_settings import PaperPoseSettings

ROOT = Path(__file__).resolve().parents[1]
METHODS = (ROOT / "docs" / "published_methods.md").read_text(encoding="utf-8")
PAWS, POSES = METHODS.split("## Poses")


def rows(text):
    """Return (paper's name, our names, default) of each row of the tables."""
    cells = [line.strip("|").split("|") for line in text.splitlines() if line.startswith("| ")]
    return [
        (name.strip(), re.findall(r"`(\w+)`", ours), default.strip())
        for name, ours, default, _ in cells
        if "`" in ours
    ]


@pytest.mark.parametrize(("text", "settings"), [(PAWS, PaperSettings), (POSES, PaperPoseSettings)])
def test_the_papers_names_stand_beside_settings_that_exist(text, settings):
    known = {field.name: field.default for field in dataclasses.fields(settings)}
    found = rows(text)
    assert len(found) > 7
    for _, names, default in found:
        assert set(names) <= set(known), names
        # numbers in the table are the defaults
        said = [float(word) for word in re.findall(r"(?<![\w./])\d+(?![\w./])", default)]
        value = known[names[0]]
        if isinstance(value, bool) or value is None or not said:
            continue
        own = value if isinstance(value, tuple) else [known[name] for name in names]
        assert said == [float(x) for x in own], names


@pytest.mark.parametrize(("text", "names"), [(PAWS, PAW_NAMES), (POSES, POSE_NAMES)])
def test_names_that_are_hinted_at_are_those_of_the_table(text, names):
    found = rows(text)
    for theirs, ours in names.items():
        assert any(theirs in re.split(r"[ ,()]+", row) and ours in own for row, own, _ in found)


def test_section_3_2_of_the_2019_paper_is_complete():
    """Its list of key parameters."""
    named = {name for name, _, _ in rows(PAWS)}
    assert named >= {
        "NumSLIC", "Collision_Threshold", "Start_Frame_Collision", "PawXWindowSize",
        "PawYWindowSize", "Weights_F", "Weights_H",
    }  # fmt: skip


@pytest.mark.parametrize("page", ["README.md", "CONTRIBUTING.md", *sorted(
    str(path.relative_to(ROOT)) for path in (ROOT / "docs").glob("*.md"))])  # fmt: skip
def test_files_that_are_named_are_there(page):
    text = (ROOT / page).read_text(encoding="utf-8")
    named = re.findall(r"`((?:docs|benchmarks|pawnb)/[\w/.]+)`", text)
    named += re.findall(r"python (benchmarks/\w+\.py)", text)
    for name in named:
        assert (ROOT / name).exists(), name
