"""Lines of records: what is written is read back, and what does not fit is named."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pawnb.errors import InputError
from pawnb.io.journal import Journal, LineFormat, enter_step, read_journal


@dataclass(frozen=True, kw_only=True)
class Note:
    page: int
    height: float
    text: str
    author: str | None = None
    loud: bool = False
    sizes: dict[str, float] = field(default_factory=dict)


LINES = LineFormat({"note": Note})
NOTES = st.builds(
    Note,
    page=st.integers(-(2**53), 2**53),
    height=st.floats(allow_nan=False, allow_infinity=False),
    text=st.text(),
    author=st.none() | st.text(),
    loud=st.booleans(),
    sizes=st.dictionaries(st.text(), st.floats(allow_nan=False, allow_infinity=False)),
)


@pytest.mark.slow
@given(NOTES)
def test_a_line_gives_back_the_record(note):
    line = LINES.to_line(note)
    assert "\n" not in line
    assert LINES.from_line(line, where="here") == note


def test_a_switch_that_is_off_is_left_out():
    note = Note(page=1, height=2.5, text="x")
    assert LINES.to_line(note) == (
        '{"edit": "note", "page": 1, "height": 2.5, "text": "x", "author": null, "sizes": {}}'
    )


@pytest.mark.parametrize(
    ("field", "value", "expected"),
    [
        ("page", "1.5", "a whole number"),
        ("page", "true", "a whole number"),
        ("page", "null", "a whole number"),
        ("height", '"1"', "a number"),
        ("height", "Infinity", "a number"),
        ("height", "false", "a number"),
        ("sizes", '{"a": "1"}', "numbers by name"),
        ("sizes", "[1]", "numbers by name"),
        ("text", "1", "text"),
        ("text", "null", "text"),
        ("author", "1", "text"),
        ("loud", "1", "true or false"),
        ("loud", "null", "true or false"),
    ],
)
def test_a_value_of_another_type_is_named(field, value, expected):
    fields = {"page": "1", "height": "1", "text": '"x"', field: value}
    inside = ", ".join(f'"{name}": {text}' for name, text in fields.items())
    with pytest.raises(InputError, match=f"here: {field} is .*; expected {expected}[.]"):
        LINES.from_line('{"edit": "note", ' + inside + "}", where="here")


@given(st.lists(st.sampled_from(["undo", "redo", "a"])))
def test_what_is_in_force_is_what_an_editor_would_show(steps):
    """The model: a list and a place in it, as in any editor."""
    past, future = [], []
    made, place = [], 0
    for number, step in enumerate(steps):
        entry = step if step != "a" else Note(page=number, height=0.0, text="")
        enter_step(past, future, entry)
        if step == "undo":
            place = max(place - 1, 0)
        elif step == "redo":
            place = min(place + 1, len(made))
        else:
            made, place = [*made[:place], entry], place + 1
        assert past == made[:place]
        assert future[::-1] == made[place:]


def test_a_file_says_what_was_open_when_another_window_has_changed_it(tmp_path):
    path = tmp_path / "notes.jsonl"
    first, second = (Journal(path, LINES, made_in="book") for _ in range(2))
    first.append(Note(page=1, height=0.0, text="x"))
    with pytest.raises(InputError, match="open the book again and repeat it"):
        second.append("undo")
    assert read_journal(path, LINES) == (first.entries, [])


def test_a_file_that_was_taken_away_is_not_begun_anew(tmp_path):
    journal = Journal(tmp_path / "notes.jsonl", LINES, made_in="book")
    journal.append("undo")
    journal.path.unlink()
    with pytest.raises(InputError, match="open the book again and repeat it"):
        journal.append("redo")
    assert list(tmp_path.iterdir()) == []


def test_lines_go_where_the_file_was_opened_wherever_the_notebook_goes(tmp_path, monkeypatch):
    """After ``%cd`` they went into a file of the same name below the other folder."""
    for name in ("m07", "elsewhere"):
        (tmp_path / name).mkdir()
    monkeypatch.chdir(tmp_path)
    journal = Journal("m07/results/notes.jsonl", LINES, made_in="book")
    monkeypatch.chdir(tmp_path / "elsewhere")
    journal.append("undo")
    assert read_journal(tmp_path / "m07" / "results" / "notes.jsonl", LINES) == (["undo"], [])
    assert list((tmp_path / "elsewhere").iterdir()) == []


def test_no_line_goes_where_a_folder_was_before_it_was_renamed(tmp_path):
    (tmp_path / "m07").mkdir()
    journal = Journal(tmp_path / "m07" / "results" / "notes.jsonl", LINES, made_in="book")
    (tmp_path / "m07").rename(tmp_path / "m08")
    with pytest.raises(InputError, match="m07: moved, renamed or deleted since"):
        journal.append("undo")
    assert [path.name for path in tmp_path.iterdir()] == ["m08"]


def test_a_file_of_another_kind_is_refused(tmp_path):
    path = tmp_path / "notes.jsonl"
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match=r"notes.jsonl: not lines of JSON; .* a file of edits\?"):
        Journal(path, LINES, made_in="book")
    path.write_bytes(b"\xff\xfe\x00\n")
    with pytest.raises(InputError, match=r"line 1: not UTF-8 text .* a file of edits\?"):
        Journal(path, LINES, made_in="book")


@pytest.mark.parametrize(
    "value",
    ["9" * 5000, "1" + "0" * 400, "9007199254740993", "[" * 100_000, '{"a":' * 100_000, "1e999",
     "[" * 900 + "]" * 900, '"' + "x" * 10**6 + '"'],
)  # fmt: skip
@pytest.mark.parametrize("place", ["page", "height", "edit", "y"])
def test_hostile_lines_are_one_short_sentence(tmp_path, place, value):
    path = tmp_path / "notes.jsonl"
    path.write_text('{"edit": "note", "' + place + '": ' + value + "}\n")
    with pytest.raises(InputError, match=r"notes.jsonl, line 1: ") as caught:
        Journal(path, LINES, made_in="book")
    assert len(str(caught.value)) < 300


@pytest.mark.parametrize("left", [b'{"edit": "no', b'{"edit": "note", "text": "\xc3', b"\0" * 9])
def test_what_a_crash_left_of_a_line_is_kept_and_nothing_before_it_is_lost(tmp_path, left):
    path = tmp_path / "notes.jsonl"
    first = Journal(path, LINES, made_in="book")
    first.append(Note(page=1, height=0.0, text="x"))
    with path.open("ab") as file:
        file.write(left)
    entries = [Note(page=1, height=0.0, text="x"), Note(page=2, height=0.0, text="y"), "undo"]
    # both who opened it before and who opens it now can go on
    first.append(entries[1])
    again = Journal(path, LINES, made_in="book")
    assert again.notes == []
    again.append("undo")
    assert read_journal(path, LINES) == (entries, [])
    assert left.decode(errors="backslashreplace") in [
        json.loads(line).get("text") for line in path.read_text().splitlines()
    ]


def test_a_line_without_its_end_counts_and_is_ended(tmp_path):
    path = tmp_path / "notes.jsonl"
    path.write_text('{"edit": "undo"}')  # an editor took the last end of line away
    journal = Journal(path, LINES, made_in="book")
    journal.append("redo")
    assert path.read_text() == '{"edit": "undo"}\n{"edit": "redo"}\n'


# 40 lines on a disk with room for some 10 of them; then there is room again
_FULL = """
import resource, sys
from pawnb.errors import InputError
from test_journal import LINES, Journal, Note
journal = Journal(sys.argv[1], LINES, made_in="book")
for page in range(40):
    soft = 1000 if page < 30 else resource.RLIM_INFINITY
    resource.setrlimit(resource.RLIMIT_FSIZE, (soft, resource.RLIM_INFINITY))
    try:
        journal.append(Note(page=page, height=0.5, text="x"))
        print(page)
    except InputError as error:
        print(error, file=sys.stderr)
"""


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="limits of POSIX")
def test_after_a_full_disk_edits_go_on(tmp_path):
    path = tmp_path / "notes.jsonl"
    done = _run(_FULL, path)
    acknowledged = [int(line) for line in done.stdout.split()]
    assert acknowledged[-10:] == list(range(30, 40))
    assert 0 < acknowledged.index(30) < 30
    said = done.stderr.splitlines()
    assert len(said) == 40 - len(acknowledged)
    assert all("cannot be written (File too large)" in line for line in said)
    entries, notes = read_journal(path, LINES)
    assert [entry.page for entry in entries] == acknowledged
    assert notes == []


# as a person would: where another window was quicker, open the file again and repeat
_RACE = """
import sys
from pawnb.errors import InputError
from test_journal import LINES, Journal, Note
journal = Journal(sys.argv[1], LINES, made_in="book")
for page in range(60):
    while True:
        try:
            journal.append(Note(page=page, height=0.5, text=sys.argv[2]))
            break
        except InputError:
            journal = Journal(sys.argv[1], LINES, made_in="book")
print("done")
"""


@pytest.mark.slow
def test_no_line_is_lost_or_broken_between_two_writers(tmp_path):
    path = tmp_path / "notes.jsonl"
    started = [_start(_RACE, path, name) for name in "ab"]
    assert [process.communicate()[0] for process in started] == ["done\n"] * 2
    entries, notes = read_journal(path, LINES)
    assert notes == []
    for name in "ab":
        assert [e.page for e in entries if e.text == name] == list(range(60))
    assert len(path.read_text().splitlines()) == 120


def _start(code, *words):
    return subprocess.Popen(
        [sys.executable, "-c", code, *map(str, words)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=Path(__file__).parent,
    )  # fmt: skip


def _run(code, *words):
    process = _start(code, *words)
    out, errors = process.communicate()
    return subprocess.CompletedProcess(words, process.returncode, out, errors)
