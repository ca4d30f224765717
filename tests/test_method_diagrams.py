"""The diagrams of trackers name what is there, and the text beneath them says the same."""

from __future__ import annotations

import ast
import re
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "docs"))

from method_stages import DIAGRAMS  # noqa: E402

PAGE = (ROOT / "docs" / "methods.md").read_text(encoding="utf-8")
PROSE, SOURCES = PAGE.split("## Sources")


def path_of(package, module):
    """Return the file of a module, named from a package or in full."""
    full = module if module.startswith("pawnb.") else f"{package}.{module}"
    folder = ROOT / Path(*full.split("."))
    return folder / "__init__.py" if folder.is_dir() else folder.with_suffix(".py")


def sections():
    """Return the text below each diagram, up to the next heading."""
    parts = re.split(r"^```\{stages\} (\S+)\n```\n", PROSE, flags=re.M)
    return {
        name: re.split(r"^#", text, flags=re.M)[0]
        for name, text in zip(parts[1::2], parts[2::2], strict=True)
    }


def test_every_diagram_is_on_the_page_once():
    assert sorted(re.findall(r"^```\{stages\} (\S+)$", PAGE, re.M)) == sorted(DIAGRAMS)


@pytest.mark.parametrize("name", DIAGRAMS)
def test_boxes_are_modules_and_arrows_are_classes_that_exist(name):
    diagram = DIAGRAMS[name]
    for stage in diagram.stages:
        assert path_of(diagram.package, stage.module).is_file(), stage.module
    for passed in diagram.types:
        module, _, own = passed.rpartition(".")
        tree = ast.parse(path_of(diagram.package, module).read_text(encoding="utf-8"))
        assert own in {node.name for node in tree.body if isinstance(node, ast.ClassDef)}, passed


@pytest.mark.parametrize("name", DIAGRAMS)
def test_the_text_below_a_diagram_has_its_stages(name):
    diagram, text = DIAGRAMS[name], sections()[name]
    said = re.findall(r"^\d+\. \*\*([\w ]+)\.\*\*", text, re.M)
    assert said == [stage.title for stage in diagram.stages]
    assert {end for loop in diagram.loops for end in (loop.begin, loop.end)} <= set(said)


@pytest.mark.parametrize("name", DIAGRAMS)
def test_citations_are_in_the_text_and_among_the_sources(name):
    text = " ".join(sections()[name].split())
    for stage in DIAGRAMS[name].stages:
        for cited in filter(None, stage.cites.split("; ")):
            author, year = cited.split()[0].rstrip(","), cited.split()[-1]
            if re.search(r"\b(19|20)\d\d\b", cited):
                year = re.search(r"\b(?:19|20)\d\d\b", cited).group()
                assert re.search(rf"^- {author}\b.*\({year}\)", SOURCES, re.M), cited
                assert re.search(rf"{author}\b[^()]*{year}", text), cited
            else:  # an equation, algorithm or section of the paper that the tracker is
                assert cited.split(",")[0] in text, cited
