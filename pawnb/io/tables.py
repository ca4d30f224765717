"""Tables as csv: read with checks that name file, row and column, written whole or not at all.

Every table that pawnb writes goes through :func:`write_table`; see :mod:`pawnb.files` for how
files become whole.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from pawnb.arrays import AnyArray
from pawnb.errors import InputError
from pawnb.files import check_file, read_text, write_whole
from pawnb.io.separators import header_lines, separator_of, with_commas
from pawnb.schema import MOST_FRAMES, check_columns

DECIMALS = {
    "u": 4, "v": 4, "confidence": 4, "residual_px": 4, "x": 6, "y": 6, "z": 6,
}  # fmt: skip
"""Decimals kept in csv: 0.0001 px and 0.000001 of the unit of length are far below what
any tracker can tell. Other columns are written in full."""

_LONGEST_LINE = 2**22


def write_text(text: str, path: str | Path) -> Path:
    """Write a text file whole or not at all.

    Parameters
    ----------
    text : str
        What to write, in UTF-8 with the line ends it has.
    path : str or Path
        The file; its folder must exist.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        If the folder does not exist, or the file cannot be written.
    """
    return write_whole(path, text.encode("utf-8"))


def write_table(table: pd.DataFrame, path: str | Path) -> Path:
    """Write a table as csv, whole or not at all, the same bytes for the same table.

    Parameters
    ----------
    table : pandas.DataFrame
        What to write; its index is left out. Columns named in ``DECIMALS`` are rounded (u, v,
        confidence and residual_px to 4 decimals, x, y and z to 6); other numbers are written
        with the fewest digits that give them back exactly. NaN is an empty cell.
    path : str or Path
        The file; its folder must exist.

    Returns
    -------
    Path
        The file.
    """
    rounded = table.copy()
    for name, decimals in DECIMALS.items():
        if name in rounded and pd.api.types.is_float_dtype(rounded[name]):
            rounded[name] = rounded[name].round(decimals) + 0.0  # + 0.0: no "-0.0"
    return write_text(rounded.to_csv(index=False, lineterminator="\n"), path)


def read_table_text(
    path: str | Path, *, expected: str, error: type[InputError] = InputError, skip_lines: int = 0
) -> str:
    r"""Read a csv as text.

    Parameters
    ----------
    path : str or Path
        The file.
    expected : str
        What it should be, for the message.
    error : type
        Kind of InputError to raise.
    skip_lines : int
        Lines before the first one of the table, which may hold anything.

    Returns
    -------
    str
        The whole text, without byte order mark, line ends as ``\\n``, commas between the cells and
        points in the numbers, also where the file has semicolons or tabs and decimal commas.

    Raises
    ------
    InputError
        If the file cannot be read as text, or it is not to be told which sign is its decimal mark.
    """
    text = read_text(path, expected=expected, error=error)
    name = Path(path).name
    if "\0" in text:
        raise error(f"{name}: not text, it holds zero bytes; expected {expected}.")
    return with_commas(text, where=name, first=skip_lines, error=error)


def read_column_names(path: str | Path, *, expected: str) -> list[str]:
    """Read the first line of a csv only: the names of its columns.

    Parameters
    ----------
    path : str or Path
        The file.
    expected : str
        What it should be, for messages.

    Returns
    -------
    list of str
        Names without blanks around them; none where the line is no text.

    Raises
    ------
    InputError
        If the file cannot be read.
    """
    path = check_file(path, expected=expected)
    try:
        with path.open("rb") as file:
            first = file.readline(_LONGEST_LINE).decode("utf-8-sig")
            if not header_lines(first):
                first = file.readline(_LONGEST_LINE).decode("utf-8-sig")
        cells = next(csv.reader([first], delimiter=separator_of(first)), [])
    except (OSError, UnicodeDecodeError, csv.Error):
        return []
    if "\0" in first:
        return []
    return [cell.strip() for cell in cells]


def read_cells(path: str | Path, columns: Sequence[str], *, skip_lines: int = 0) -> pd.DataFrame:
    """Read a csv as text cells and check that it has the expected columns.

    Parameters
    ----------
    path : str or Path
        The file.
    columns : sequence of str
        Columns that must be there.
    skip_lines : int
        Lines before the names of the columns.

    Returns
    -------
    pandas.DataFrame
        Every cell as text without blanks around it; empty cells are ``""``.

    Raises
    ------
    InputError
        If the file is missing, is not a csv, lacks a column, has two of one name, or a row has
        more cells than there are columns.
    """
    path = Path(path)
    described = f"the columns {', '.join(columns)}" if columns else "names of columns and rows"
    expected = f"a csv table with {described}"
    text = read_table_text(path, expected=expected, skip_lines=skip_lines)
    body = text.split("\n", skip_lines)[-1] if text.count("\n") >= skip_lines else ""
    try:
        # names of columns are read as a row of cells: pandas renames the second of two equal ones
        table = pd.read_csv(io.StringIO(body), header=None, dtype=str, keep_default_na=False)
    except (pd.errors.ParserError, pd.errors.EmptyDataError, csv.Error) as reason:
        where = re.search(r"in line (\d+), saw (\d+)", str(reason))
        if where is None:
            raise InputError(f"{path.name}: not a csv table; expected {described}.") from None
        raise InputError(
            f"{path.name}: line {int(where[1]) + skip_lines} has {where[2]} cells, more than there "
            f"are columns; expected {described}: mend that line."
        ) from None
    names = [str(name).strip() for name in table.iloc[0]]
    last = text.rpartition("\n")[2]
    if last and len(table) > 1 and '"' not in last and last.count(",") < len(names) - 1:
        raise InputError(
            f"{path.name}: the last line has {last.count(',') + 1} of {len(names)} cells, no end: "
            "the file was cut short; copy it again from where it is whole, or take that line out."
        )
    twice = [name for name in names if name and names.count(name) > 1]
    if twice:
        raise InputError(
            f"{path.name}: column {twice[0]!r} is there twice; keep one of them, or name them "
            "differently."
        )
    table = table.iloc[1:].reset_index(drop=True)
    empty = (table == "").all(axis=1).to_numpy()
    table = table.iloc[: int((~empty).nonzero()[0].max(initial=-1)) + 1]  # none below the last
    table.columns = pd.Index([name or f"Unnamed: {i}" for i, name in enumerate(names)])
    blank = [not name and not (table.iloc[:, i] != "").any() for i, name in enumerate(names)]
    table = table.loc[:, ~np.array(blank)]  # a comma at the end of every line
    table = check_columns(table, columns, where=path.name, cells=False)
    return table.apply(lambda column: column.str.strip())


def read_numbers(
    table: pd.DataFrame, column: str, *, where: str, whole: bool = False, empty: bool = False
) -> AnyArray:
    """Turn a column of text cells into numbers, or say which cell is not one.

    Parameters
    ----------
    table : pandas.DataFrame
        Text cells, as :func:`read_cells` gives them.
    column : str
        The column.
    where : str
        File name for the message.
    whole : bool
        Whether only whole numbers will do, such as those of frames; they are returned as int64.
    empty : bool
        Whether a cell may be empty; it becomes NaN.

    Returns
    -------
    ndarray, shape (n_rows,)
        The numbers.

    Raises
    ------
    InputError
        For the first cell that is not a (whole) finite number, or too large for that of a frame.
    """
    cells = table[column]
    values = pd.to_numeric(cells, errors="coerce").to_numpy(float)
    bad = ~np.isfinite(values)
    if empty:
        bad &= (cells != "").to_numpy(bool)
    if whole:
        bad |= (values != np.rint(values)) | (np.abs(values) > MOST_FRAMES)
    if bad.any():
        row = int(np.argmax(bad))
        found = repr(cells.iloc[row]) if cells.iloc[row] else "empty"
        kind = "a whole number" if whole else "a number"
        if whole and abs(values[row]) > MOST_FRAMES:
            kind = f"a whole number up to {MOST_FRAMES:,}"
        raise InputError(f"{where}: line {row + 2}, column {column!r} is {found}; expected {kind}.")
    return values.astype(np.int64) if whole else values
