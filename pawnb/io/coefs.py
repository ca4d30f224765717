"""``DLTcoefs.csv``: 11 rows, one column a view in the order of the views, no header."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from pawnb.arrays import FloatArray
from pawnb.errors import CalibrationError
from pawnb.io.tables import read_table_text, write_text
from pawnb.schema.arguments import checked_arguments

_LARGEST = 1e12
"""Above it, image positions cannot be told to a fraction of a pixel in double precision."""


@checked_arguments
def read_coefs(path: Path, names: Sequence[str]) -> FloatArray:
    """Read ``DLTcoefs.csv``: 11 rows, one column a view, no header.

    Parameters
    ----------
    path : Path
        The file.
    names : sequence of str
        The views its columns belong to.

    Returns
    -------
    ndarray, shape (11, n_views)
        The coefficients as they are written.

    Raises
    ------
    CalibrationError
        If the file is missing or is not that, or a number is too large for a camera.

    Examples
    --------
    >>> coefs = np.zeros((11, 2))
    >>> coefs[[0, 5]] = 10.0
    >>> path = pawnb.io.write_coefs(coefs, "DLTcoefs.csv")
    >>> pawnb.io.read_coefs(path, ["cam1", "cam2"]).shape
    (11, 2)
    """
    path = Path(path)
    expected = "the csv with the DLT coefficients that [calibration] dlt names"
    text = read_table_text(path, expected=expected, error=CalibrationError)
    try:
        table = pd.read_csv(io.StringIO(text), header=None, dtype=str, skipinitialspace=True)
    except (pd.errors.ParserError, pd.errors.EmptyDataError):
        raise CalibrationError(
            f"{path.name}: not a table of numbers; expected 11 rows, one column a view, no header."
        ) from None
    coefs = table.apply(pd.to_numeric, errors="coerce").to_numpy(float)
    if coefs.shape != (11, len(names)):
        raise CalibrationError(
            f"{path.name}: {coefs.shape[0]} rows and {coefs.shape[1]} columns; expected 11 rows "
            f"and {len(names)} columns, one for each view ({', '.join(names)}), and no header."
        )
    bad = np.argwhere(~np.isfinite(coefs))
    if len(bad):
        row, column = bad[0]
        raise CalibrationError(
            f"{path.name}: row {row + 1}, column {column + 1} is "
            f"{_word(table.to_numpy()[row, column])}; expected a number."
        )
    if np.abs(coefs).max() > _LARGEST:
        row, column = np.unravel_index(np.abs(coefs).argmax(), coefs.shape)
        raise CalibrationError(
            f"{path.name}: row {row + 1}, column {column + 1} is {coefs[row, column]:g}; no camera "
            "has such a coefficient: calibrate again, or copy the file anew."
        )
    return coefs


@checked_arguments
def write_coefs(coefs: FloatArray, path: str | Path) -> Path:
    """Write DLT coefficients, whole or not at all.

    Parameters
    ----------
    coefs : ndarray, shape (11, n_views)
        The coefficients; reading gives exactly the same numbers.
    path : str or Path
        The file, usually ``DLTcoefs.csv``.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    CalibrationError
        If there are not 11 rows of finite numbers.

    Examples
    --------
    >>> coefs = np.zeros((11, 2))
    >>> coefs[[0, 5]] = 10.0  # two cameras that look along Z: 10 px per mm
    >>> pawnb.io.write_coefs(coefs, "DLTcoefs.csv").name
    'DLTcoefs.csv'
    """
    coefs = np.asarray(coefs, dtype=float)
    if coefs.ndim != 2 or coefs.shape[0] != 11 or not np.isfinite(coefs).all():
        raise CalibrationError(
            f"DLT coefficients have shape {coefs.shape}; expected 11 rows of finite numbers, one "
            "column a view."
        )
    lines = [",".join(repr(float(x)) for x in row) for row in coefs]
    return write_text("\n".join(lines) + "\n", path)


def _word(value: object) -> str:
    """Say what a cell holds."""
    return "empty" if pd.isna(value) else repr(value)  # type: ignore[call-overload]
