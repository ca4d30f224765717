"""What several commands have in common: ``--json``, ``-q``, ``-v``, and names that were meant."""

from __future__ import annotations

import argparse
import json
import math
import re
from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from pawnb.errors import did_you_mean

WITH_JSON = ("check", "gait", "evaluate", "compare", "batch", "calibrate", "selfcheck")
_SHOWN_ONLY = {"-q", "--quiet", "-v", "--verbose", "--json"}
_CHOICE = re.compile(r"invalid choice: '(.*?)' \(choose from (.*)\)", re.DOTALL)
_UNKNOWN = re.compile(r"unrecognized arguments: (--[\w-]+)")


def add_shared_options(commands: Mapping[str, argparse.ArgumentParser]) -> None:
    """Give every command ``-q`` and ``-v``, and ``--json`` to those that print what they found.

    Parameters
    ----------
    commands : mapping
        Name to parser.
    """
    for name, command in commands.items():
        loud = command.add_mutually_exclusive_group()
        loud.add_argument(
            "-q", "--quiet", action="store_true", help="say nothing but errors; the status tells"
        )
        loud.add_argument(
            "-v", "--verbose", action="store_true", help="say where in the code an error arose"
        )
        if name in WITH_JSON:
            command.add_argument("--json", action="store_true", help="print JSON instead of words")


def command_first(words: list[str]) -> list[str]:
    """Put ``-q``, ``-v`` and ``--json`` behind the command, also where they stand before it.

    Parameters
    ----------
    words : list of str
        Words after ``pawnb``.

    Returns
    -------
    list of str
        The same words, in the order that the parser knows.
    """
    at = next((i for i, word in enumerate(words) if word not in _SHOWN_ONLY), len(words))
    return [*words[at : at + 1], *words[:at], *words[at + 1 :]]


def of_results(words: list[str]) -> list[str]:
    """Return a command line without what shapes no result: how much is said, and in which form."""
    return [word for word in words if word not in _SHOWN_ONLY]


def name_meant(message: str, known: Mapping[str, Any]) -> str:
    """Return what argparse says, with the name that was probably meant.

    Parameters
    ----------
    message : str
        What argparse says.
    known : mapping
        Options of the command by name.

    Returns
    -------
    str
        The message; of an unknown name a near one is suggested.
    """
    choice, unknown = _CHOICE.search(message), _UNKNOWN.search(message)
    if choice is not None:
        names = [name.strip(" '\"") for name in choice.group(2).split(",")]
        hint = did_you_mean(choice.group(1), names)
        return message.replace(" (choose from", f"{hint} (choose from", 1)
    if unknown is not None:
        return message + did_you_mean(unknown.group(1), known)
    return message


def print_json(**found: Any) -> None:
    """Print what was found as one JSON object; tables are lists of rows, missing values null.

    Parameters
    ----------
    **found
        Names to plain values or tables.
    """
    plain = {name: _plain(value) for name, value in found.items()}
    print(json.dumps(plain, ensure_ascii=False))


def _plain(value: Any) -> Any:
    """Return a value that JSON can hold."""
    if isinstance(value, pd.DataFrame):
        rows = value.astype(object).where(value.notna(), None)
        return [{str(k): _plain(v) for k, v in row.items()} for row in rows.to_dict("records")]
    if isinstance(value, Mapping):
        return {str(name): _plain(one) for name, one in value.items()}
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value
