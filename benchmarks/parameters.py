"""Parameters of the trackers: how many can be set, on what evidence, and which numbers cannot.

Prints for each stage how many of its parameters were measured, come from a source that is cited or
from mathematics, or were set by hand; then the other named numbers of the trackers' modules, by why
they are no parameters.

    python benchmarks/parameters.py [--all]
"""

from __future__ import annotations

import argparse
import inspect
import re
from collections import Counter

from pawnb.core.parameters import defaults_of, reasons_of
from pawnb.core.paws.tracker import trackers

EVIDENCE = (
    ("measured", r"[Mm]easured"),
    ("set by hand", r"[Ss]et by hand|not tuned"),
    ("cited or mathematics", r"\b(?:19|20)\d\d\b|OpenCV|[Mm]athematics"),
)
"""What a text says of its parameter, in the order in which it is looked for."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--all", action="store_true", help="print every text, too")
    is_whole = parser.parse_args().all
    every = [tracker for kind in ("paws", "pose") for tracker in trackers(kind).values()]
    total: Counter[str] = Counter()
    for stage in dict.fromkeys(stage for tracker in every for stage in tracker.stages):
        texts = texts_of(stage)
        counts = Counter(kind_of(text) for text in texts.values())
        total += counts
        print(f"{stage:18s} {len(texts):4d}  " + words(counts))
        for name, text in texts.items() if is_whole else ():
            print(f"    {name}: {text}")
    print(f"{'all stages':18s} {total.total():4d}  {words(total)}")
    for package in dict.fromkeys(package for t in every if t.stages for package in t.packages):
        reasons = reasons_of(package)
        counts = Counter(one.kind or "not said" for one in reasons for _ in one.names)
        print(f"\n{package}: {counts.total()} named numbers cannot be set: {words(counts)}")
        for reason in reasons:
            print(
                f"    {reason.kind:12s} {reason.module}: {', '.join(reason.names)}: {reason.text}"
            )


def texts_of(stage: str) -> dict[str, str]:
    """Return what the docstring of a stage says of each parameter."""
    doc = inspect.getdoc(type(defaults_of(stage))) or ""
    blocks = re.findall(r"^(\w[\w, ]*) : .*\n((?: {4}.*\n?|\n)+)", doc, re.M)
    return {name: " ".join(text.split()) for names, text in blocks for name in names.split(", ")}


def kind_of(text: str) -> str:
    """Return the kind of evidence that a text gives."""
    return next((kind for kind, words in EVIDENCE if re.search(words, text)), "not said")


def words(counts: Counter[str]) -> str:
    """Return counts in words, the largest first."""
    return ", ".join(f"{n} {kind}" for kind, n in counts.most_common())


if __name__ == "__main__":
    main()
