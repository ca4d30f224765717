"""Tracks of DeepLabCut: csv or h5, one animal or several."""

from __future__ import annotations

import csv
import io
import itertools
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from pawnb.errors import InputError
from pawnb.io.hdf5 import open_hdf5
from pawnb.io.pandas_hdf5 import Column, read_pandas_frame
from pawnb.io.points import build_tracks
from pawnb.io.tables import read_table_text
from pawnb.schema import Tracks

GROUP = "df_with_missing"
"""Where DeepLabCut puts its table in an h5 file."""

_LEVELS = (("scorer", "bodyparts", "coords"), ("scorer", "individuals", "bodyparts", "coords"))
_ONE = "individual_0"
_EXPECTED = "a csv or h5 as DeepLabCut writes it"


def read_deeplabcut(path: str | Path, *, fps: float, unit: str = "mm") -> Tracks:
    """Read tracks of DeepLabCut.

    Parameters
    ----------
    path : str or Path
        The csv (header lines scorer, individuals for several animals, bodyparts, coords) or
        the h5 of the same video. The first column (the index) is the number of the frame.
    fps : float
        Frames per second of the recording; the file does not say.
    unit : str
        Unit of length of points in space (coords x, y, z).

    Returns
    -------
    xarray.Dataset
        Tracks in px, confidence is DeepLabCut's likelihood. Pixels are taken as they are.
        Frames without a row are missing, and the provenance says which they are.

    Raises
    ------
    InputError
        If the file is missing, damaged or not of DeepLabCut, a cell is no number, a point is
        there twice, or frames do not rise.

    Notes
    -----
    Attributes of the h5 are pickles. They are never unpickled: see
    :mod:`pawnb.io.pickled_values`.

    Examples
    --------
    >>> tracks = pawnb.io.read_deeplabcut("sample/m01DLC.csv", fps=200.0)
    >>> tracks.attrs["source_software"]
    'DeepLabCut'
    """
    path = Path(path)
    frames, columns, values = (_read_csv if path.suffix == ".csv" else _read_h5)(path)
    if not {len(name) for name in columns} <= {3, 4} or len(set(map(len, columns))) != 1:
        raise InputError(
            f"{path.name}: columns have {len(columns[0])} levels; expected scorer, (individuals,) "
            "bodyparts, coords."
        )
    named = [(c[1] if len(c) == 4 else _ONE, c[-2], c[-1]) for c in columns]
    _check_columns(named, path.name)
    individuals, points = (list(dict.fromkeys(c[i] for c in named)) for i in (0, 1))
    axes = "xyz" if any(c[2] == "z" for c in named) else "xy"
    place = {c: i for i, c in enumerate(named)}
    padded = np.column_stack([values, np.full(len(values), np.nan)])

    def picked(axis: str) -> np.ndarray:
        # a point that one animal does not have is missing in it: the last column
        at = [[place.get((who, p, axis), -1) for who in individuals] for p in points]
        return padded[:, np.array(at)]

    return build_tracks(
        frames,
        np.stack([picked(axis) for axis in axes], axis=-1),
        picked("likelihood") if any(c[2] == "likelihood" for c in named) else None,
        points=points,
        fps=fps,
        unit="px" if axes == "xy" else unit,
        program="DeepLabCut",
        where=path.name,
        individuals=individuals,
    )


def _read_h5(path: Path) -> tuple[np.ndarray, list[Column], np.ndarray]:
    """Return frames, columns and numbers of an h5."""
    with open_hdf5(path, expected=_EXPECTED) as file:
        group = file.get(GROUP)
        if group is None:
            raise InputError(f"{path.name}: no {GROUP} in it; expected {_EXPECTED}.")
        return read_pandas_frame(group, where=path.name)


def _read_csv(path: Path) -> tuple[np.ndarray, list[Column], np.ndarray]:
    """Return frames, columns and numbers of a csv."""
    text = read_table_text(path, expected=_EXPECTED)
    head = list(itertools.islice(csv.reader(io.StringIO(text)), 4))
    levels = tuple(row[0].strip() for row in head if row)
    header = next((known for known in _LEVELS if levels[: len(known)] == known), None)
    if header is None:
        raise InputError(
            f"{path.name}: lines begin with {', '.join(levels)}; expected the header lines "
            "scorer, (individuals,) bodyparts, coords of DeepLabCut."
        )
    names = [[cell.strip() for cell in row[1:]] for row in head[: len(header)]]
    width = len(names[0])
    if width == 0 or any(len(row) != width for row in names):
        raise InputError(f"{path.name}: header lines of different length; expected {_EXPECTED}.")
    body = _numbers(text, len(header), width + 1, names[-2:], path.name)
    return body[:, 0], list(zip(*names, strict=True)), body[:, 1:]


def _numbers(
    text: str, n_header: int, width: int, names: Sequence[Sequence[str]], where: str
) -> np.ndarray:
    """Return the rows below the header as numbers, or say which cell is none."""
    lines = [(i, line) for i, line in enumerate(text.split("\n"), start=1) if line.strip()]
    lines = lines[n_header:]
    if not lines:
        raise InputError(f"{where}: no rows below the header; expected one for each frame.")
    for i, line in lines:
        if line.count(",") != width - 1:
            raise InputError(
                f"{where}: line {i} has {line.count(',') + 1} cells; expected {width} as in the "
                "header: copy the file again from where it is whole, or mend that line."
            )
    table = pd.read_csv(
        io.StringIO("\n".join(line for _, line in lines)),
        header=None,
        names=list(range(width)),
        quoting=csv.QUOTE_NONE,
        skipinitialspace=True,
        low_memory=False,
    )
    for column in range(width):
        cells = table[column]
        cells = cells.astype(str) if cells.dtype == bool else cells  # "True" is no number
        numbers = pd.to_numeric(cells, errors="coerce").to_numpy(dtype=float)
        bad = (~np.isfinite(numbers) & cells.notna().to_numpy()) | (
            np.isnan(numbers) if column == 0 else False
        )
        if bad.any():
            row = int(np.argmax(bad))
            what = "the frame" if column == 0 else " ".join(part[column - 1] for part in names)
            raise InputError(
                f"{where}: line {lines[row][0]}, {what} is {_said(cells.iloc[row])}; expected "
                + ("a whole number." if column == 0 else "a number, or an empty cell.")
            )
        table[column] = numbers
    return table.to_numpy(dtype=float)


def _said(cell: object) -> str:
    """Say what a cell holds."""
    text = str(cell)
    if re.search(r"\.(png|jpe?g|tiff?|bmp)$", text):
        return f"the picture {text!r}, as in labels for training"
    return "empty" if pd.isna(cell) else repr(text)  # type: ignore[call-overload]


def _check_columns(named: Sequence[tuple[str, str, str]], where: str) -> None:
    """Refuse columns that are there twice, unknown coordinates, and points with half a place."""
    known = ("x", "y", "z", "likelihood")
    seen: set[tuple[str, str, str]] = set()
    for who, point, axis in named:
        of = f"{point} {axis}" if who == _ONE else f"{who} {point} {axis}"
        if (who, point, axis) in seen:
            raise InputError(
                f"{where}: column {of} is there twice; keep one of them, or name the points "
                "differently."
            )
        if axis not in known:
            raise InputError(f"{where}: column {of}; expected coords {', '.join(known)}.")
        seen.add((who, point, axis))
    for who, point, _ in named:
        for axis in ("x", "y"):
            if (who, point, axis) not in seen:
                raise InputError(f"{where}: column {axis} of point {point!r} is missing.")
