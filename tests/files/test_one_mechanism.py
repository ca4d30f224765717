"""Whatever pawnb writes goes through :mod:`pawnb.files`: no other module does it by itself."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pawnb

PACKAGE = Path(pawnb.__file__).parent
WRITERS = {"fsync", "write_bytes", "write_text", "NamedTemporaryFile", "mkstemp"}
"""Methods and functions of the standard library that write a file, or give it its name."""
MAYBE = re.compile("|".join([*WRITERS, r"open\("]))
ELSEWHERE = {
    # whose turn it is in a first run: empty files in a temporary folder
    "core/first_run.py: open",
    # the encoder of videos opens the name that whole_file gives
    "synthetic/colour_video.py: open",
    "synthetic/grey_video.py: open",
}


def is_for_writing(call):
    """Say whether an open() is for anything but reading."""
    modes = [a.value for a in [*call.args, *(k.value for k in call.keywords if k.arg == "mode")]
             if isinstance(a, ast.Constant) and isinstance(a.value, str)]  # fmt: skip
    return any(set(mode) <= set("rwxab+t") and set(mode) & set("wxa+") for mode in modes)


def writes(tree, functions_of_pawnb=("write_text",)):
    """Yield the names of calls that write; functions called by their bare names are pawnb's own."""
    for call in ast.walk(tree):
        if not isinstance(call, ast.Call):
            continue
        bare = isinstance(call.func, ast.Name)
        name = call.func.id if bare else getattr(call.func, "attr", "")
        if name in WRITERS and not (bare and name in functions_of_pawnb):
            yield name
        if name == "open" and is_for_writing(call):
            yield name


def test_calls_that_write_are_found():
    right = "open(p); p.open('rb'); write_text(table, p)"
    assert list(writes(ast.parse(right))) == []
    wrong = "p.open('wb'); open(p, 'a'); p.write_text('x'); os.fsync(1)"
    found = sorted(writes(ast.parse(wrong)))
    assert found == ["fsync", "open", "open", "write_text"]


def test_only_files_writes_to_the_disk():
    texts = {path: path.read_text(encoding="utf-8") for path in PACKAGE.rglob("*.py")}
    found = {
        f"{path.relative_to(PACKAGE).as_posix()}: {name}"
        for path, text in texts.items()
        if "files" not in path.relative_to(PACKAGE).parts[:1] and MAYBE.search(text)
        for name in writes(ast.parse(text))
    }
    assert found == ELSEWHERE
