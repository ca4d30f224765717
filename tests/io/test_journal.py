"""Lines of records: what is written is read back, and what does not fit is named."""

from __future__ import annotations

from dataclasses import dataclass, field

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
    page=st.integers(),
    height=st.floats(allow_nan=False, allow_infinity=False),
    text=st.text(),
    author=st.none() | st.text(),
    loud=st.booleans(),
    sizes=st.dictionaries(st.text(), st.floats(allow_nan=False, allow_infinity=False)),
)


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


def test_a_file_of_another_kind_is_refused(tmp_path):
    path = tmp_path / "notes.jsonl"
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match=r"notes.jsonl: not UTF-8 text .* a file of edits\?"):
        Journal(path, LINES, made_in="book")
