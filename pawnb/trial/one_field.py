"""One field of the text of a ``trial.toml``, everything else in it left as it is."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Mapping, Sequence
from typing import Any


def with_field(
    text: str,
    section: str,
    name: str,
    *,
    value: str | float | Sequence[int] | None,
    item: int | None = None,
) -> str:
    """Return the text of a trial with another field in a section.

    What a person wrote in another way than line by line may come out wrong: see
    :func:`says` before it is written.

    Parameters
    ----------
    text : str
        The text of a ``trial.toml``.
    section : str
        The section, as ``calibration``.
    name : str
        The field.
    value : str, float, sequence of int or None
        What it is to be; None takes it out.
    item : int, optional
        Of a section that is there several times, as ``[[views]]``, which one; the first is 0.

    Returns
    -------
    str
        The text, with the section at its end where it had none.
    """
    line = "" if value is None else f"{name} = {json.dumps(value, ensure_ascii=False)}\n"
    head = re.escape(f"[{section}]" if item is None else f"[[{section}]]")
    sections = list(re.finditer(rf"^{head}[^\n]*\n((?:(?!\[).*\n?)*)", text, re.MULTILINE))
    if item is not None and item >= len(sections):
        return text
    if not sections:
        return f"{text.rstrip()}\n\n[{section}]\n{line}" if line else text
    found = sections[item or 0]
    body = found.group(1)
    changed, count = re.subn(
        rf"^{name}[ \t]*=[^\n]*?([ \t]*#[^\n]*)?(\n|\Z)",
        lambda old: line and f"{line[:-1]}{old.group(1) or ''}\n",
        body,
        flags=re.MULTILINE,
    )
    if not count:
        changed = f"{line}{body}"
    return text[: found.start(1)] + changed + text[found.end(1) :]


def says(text: str, expected: Mapping[str, Any]) -> bool:
    """Tell whether a text of a trial says what it is meant to, and nothing else."""
    try:
        return tomllib.loads(text) == expected
    except tomllib.TOMLDecodeError:
        return False
