"""The phase summary laid out for a page: its two sets of columns below each other."""

from __future__ import annotations

from typing import Any

import pandas as pd

from pawnb.workflow.provenance.report.html import MOST_ROWS, table, text

_COUNTED = (
    ("", "n_animals", "animals", "Each animal counts once."),
    ("_strides", "n", "strides", "Every stride counts, as if strides were independent."),
)
_COLUMN_WORDS = {
    "circular_sd": "circular SD", "rayleigh_z": "Rayleigh z", "rayleigh_p": "Rayleigh p",
    "moore_r": "Moore r", "moore_p": "Moore p", "pattern": "pattern",
}  # fmt: skip


def phase_tables(summary: pd.DataFrame) -> list[str]:
    """Lay out a phase summary: first animals, then strides, each no wider than a page.

    Parameters
    ----------
    summary : pandas.DataFrame
        ``phase_summary.csv``.

    Returns
    -------
    list of str
        HTML.
    """
    parts = []
    for ending, counted, word, said in _COUNTED:
        found = summary.rename(columns={f"{name}{ending}": f"own {name}" for name in _names()})
        if "own mean" not in found:
            continue
        rows = [_row(row, counted=counted, word=word) for row in found.to_dict(orient="records")]
        values = pd.DataFrame(rows).dropna(axis=1, how="all")
        parts += [f'<p class="small">{text(said)}</p>', table(values, most=MOST_ROWS)]
    return parts


def _names() -> list[str]:
    """Name the columns that either set has."""
    return ["mean", "ci_low", "ci_high", "r", "r_low", "r_high", *_COLUMN_WORDS]


def _row(row: dict[Any, Any], *, counted: str, word: str) -> dict[str, Any]:
    """Return one pair of legs.

    Parameters
    ----------
    row : dict
        A row of the summary, the columns of this set called ``own ...``.
    counted, word : str
        The column of their number, and what is counted.
    """
    own = {
        "leg to reference": f"{row['leg']} to {row['reference']}",
        word: row.get(counted),
        "mean phase (95 % interval)": _with_interval(row, "mean", "ci_low", "ci_high"),
        "r (95 % interval)": _with_interval(row, "r", "r_low", "r_high"),
    }
    return own | {said: row.get(f"own {name}") for name, said in _COLUMN_WORDS.items()}


def _with_interval(row: dict[Any, Any], value: str, low: str, high: str) -> str:
    """Return a value with its interval, where there is one."""
    found = [row.get(f"own {name}") for name in (value, low, high)]
    known = [f"{x:.3f}" if x is not None and pd.notna(x) else "" for x in found]
    return known[0] + (f" ({known[1]} to {known[2]})" if known[1] and known[2] else "")
