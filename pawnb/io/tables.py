"""Tables as csv: read with checks that name file, row and column, written whole or not at all.

Every table that pawnb writes goes through :func:`write_table`; see :mod:`pawnb.files` for how
files become whole.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from pawnb.errors import InputError
from pawnb.files import write_whole
from pawnb.schema import check_columns

DECIMALS = {
    "u": 4, "v": 4, "confidence": 4, "residual_px": 4, "x": 6, "y": 6, "z": 6,
}  # fmt: skip
"""Decimals kept in csv: 0.0001 px and 0.000001 of the unit of length are far below what
any tracker can tell. Other columns are written in full."""


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
        If the file is missing, is not a csv, or lacks a column.
    """
    path = Path(path)
    try:
        table = pd.read_csv(
            io.StringIO(path.read_text(encoding="utf-8-sig")),
            dtype=str,
            keep_default_na=False,
            skiprows=skip_lines,
        )
    except FileNotFoundError:
        raise InputError(f"{path}: no such file.") from None
    except (IsADirectoryError, PermissionError) as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}).") from None
    except (pd.errors.ParserError, pd.errors.EmptyDataError, UnicodeDecodeError):
        expected = f"the columns {', '.join(columns)}" if columns else "names of columns and rows"
        raise InputError(f"{path.name}: not a csv table; expected {expected}.") from None
    table.columns = table.columns.str.strip()
    table = check_columns(table, columns, where=path.name)
    return table.apply(lambda column: column.str.strip())


def read_numbers(
    table: pd.DataFrame, column: str, *, where: str, whole: bool = False, empty: bool = False
) -> np.ndarray:
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
        Whether only whole numbers will do; they are returned as int64.
    empty : bool
        Whether a cell may be empty; it becomes NaN.

    Returns
    -------
    ndarray, shape (n_rows,)
        The numbers.

    Raises
    ------
    InputError
        For the first cell that is not a (whole) finite number.
    """
    cells = table[column]
    values = pd.to_numeric(cells, errors="coerce").to_numpy(float)
    bad = ~np.isfinite(values)
    if empty:
        bad &= (cells != "").to_numpy(bool)
    if whole:
        bad |= values != np.rint(values)
    if bad.any():
        row = int(np.argmax(bad))
        found = repr(cells.iloc[row]) if cells.iloc[row] else "empty"
        kind = "a whole number" if whole else "a number"
        raise InputError(f"{where}: line {row + 2}, column {column!r} is {found}; expected {kind}.")
    return values.astype(np.int64) if whole else values
