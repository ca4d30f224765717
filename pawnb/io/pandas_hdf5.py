"""A pandas DataFrame of numbers out of HDF5, by h5py alone.

pandas and PyTables unpickle attributes of the file when they open it, which runs any program
that somebody put there. The layouts are simple enough to read without them: "table", rows of a
compound type, and "fixed", an array for each axis and block (pandas, ``io/pytables.py``).
"""

from __future__ import annotations

from typing import Any

import h5py
import numpy as np

from pawnb.arrays import FloatArray
from pawnb.errors import InputError
from pawnb.io.hdf5 import read_array, read_attribute, read_texts
from pawnb.io.pickled_values import read_pickled_values

Column = tuple[str, ...]
Index = np.ndarray | list[Column]
"""Numbers of rows, or their names of one or several words."""


def read_pandas_frame(group: h5py.Group, *, where: str) -> tuple[Index, list[Column], FloatArray]:
    """Read a DataFrame whose columns have names of several levels.

    Parameters
    ----------
    group : h5py.Group
        The group that pandas made for it, in the format "table" or "fixed".
    where : str
        How messages name the file.

    Returns
    -------
    index : ndarray, shape (n_rows,), or list of tuple of str
        The index: numbers, or names.
    columns : list of tuple of str
        Names of the columns, one word a level.
    values : ndarray, shape (n_rows, n_columns)
        The numbers, in double precision.

    Raises
    ------
    InputError
        If it is neither of the two, or holds anything but numbers and names.
    """
    kind = read_attribute(group, "pandas_type", where=where)
    if kind == b"frame_table":
        return _read_table(group, where)
    if kind == b"frame":
        return _read_fixed(group, where)
    raise InputError(
        f"{where}: {group.name} is {kind.decode('utf-8', 'replace')!r}; expected a table of pandas."
    )


def _read_table(group: h5py.Group, where: str) -> tuple[Index, list[Column], FloatArray]:
    """Read the format "table": one compound type with the index and a field a block."""
    table = group.get("table")
    if not isinstance(table, h5py.Dataset) or not table.dtype.names:
        raise InputError(f"{where}: no table in {group.name}; expected that of a DataFrame.")
    if "index" not in table.dtype.names or table.dtype["index"].kind not in "iufS":
        raise InputError(f"{where}: rows have neither numbers nor names; expected frames.")
    index: Index
    if table.dtype["index"].kind == "S":
        rows = np.asarray(table[()])
        index = [(name.decode(),) for name in rows["index"].tolist()]
    else:
        rows = read_array(group, "table", where=where, ndim=1)
        index = rows["index"]
    axes = _unpickled(group, "non_index_axes", where)
    order = _columns(axes[0][1] if _is_pair(axes) else None, where)
    parts: dict[Column, np.ndarray] = {}
    for field in _unpickled(group, "values_cols", where):
        if not isinstance(field, str) or field not in table.dtype.names:
            raise InputError(f"{where}: no field {field!r} in {group.name}/table.")
        names = _columns(_unpickled(table, f"{field}_kind", where), where)
        _enter(parts, names, rows[field].reshape(len(rows), -1), where)
    return index, order, _in_order(parts, order, where)


def _read_fixed(group: h5py.Group, where: str) -> tuple[Index, list[Column], FloatArray]:
    """Read the format "fixed": arrays of index, levels and codes of the columns, and blocks."""
    index = _row_names(group, where)
    order = _levels(group, "axis0", where)
    parts: dict[Column, np.ndarray] = {}
    for i in range(len(group)):
        name = f"block{i}_values"
        if name not in group:
            break
        values = read_array(group, name, where=where, ndim=2)
        if values.shape[0] != len(index):
            values = values.T  # written by columns
        _enter(parts, _levels(group, f"block{i}_items", where), values, where)
    return index, order, _in_order(parts, order, where)


def _row_names(group: h5py.Group, where: str) -> Index:
    """Return the index of the format "fixed"."""
    if "axis1" not in group:
        return _levels(group, "axis1", where)
    axis = group["axis1"]
    if isinstance(axis, h5py.Dataset) and axis.dtype.kind == "S":
        return [(word,) for word in read_texts(group, "axis1", where=where)]
    return read_array(group, "axis1", where=where, ndim=1)


def _levels(group: h5py.Group, name: str, where: str) -> list[Column]:
    """Return the names of an axis of several levels: words by the codes that name them."""
    columns = []
    for level in range(len(group)):
        if f"{name}_level{level}" not in group:
            break
        words = np.array(read_texts(group, f"{name}_level{level}", where=where), dtype=object)
        codes = read_array(group, f"{name}_label{level}", where=where, ndim=1)
        if codes.size and not (codes.min() >= 0 and codes.max() < len(words)):
            raise InputError(f"{where}: damaged, {name} has names that are not in the file.")
        columns.append([str(word) for word in words[codes.astype(np.int64)]])
    return list(zip(*columns, strict=True))


def _unpickled(item: h5py.Group | h5py.Dataset, name: str, where: str) -> Any:
    """Return the plain values of a pickled attribute, as a list."""
    data = read_attribute(item, name, where=where)
    values = read_pickled_values(data, where=f"{where}, attribute {name}")
    if not isinstance(values, list):
        raise InputError(f"{where}: attribute {name} of {item.name} is no list.")
    return values


def _is_pair(axes: list[Any]) -> bool:
    """Say whether a list holds one pair of an axis and its names."""
    return len(axes) == 1 and isinstance(axes[0], tuple | list) and len(axes[0]) == 2


def _columns(values: Any, where: str) -> list[Column]:
    """Return names of columns, or say that they are none."""
    if isinstance(values, list) and all(
        isinstance(v, tuple) and v and all(isinstance(word, str) for word in v) for v in values
    ):
        return values
    raise InputError(f"{where}: columns are not named by tuples of words, as DeepLabCut does.")


def _enter(
    parts: dict[Column, np.ndarray], names: list[Column], values: np.ndarray, where: str
) -> None:
    """Enter the columns of a block."""
    if values.shape[1] != len(names):
        raise InputError(f"{where}: damaged, {len(names)} names for {values.shape[1]} columns.")
    parts.update(zip(names, values.T, strict=True))


def _in_order(parts: dict[Column, np.ndarray], order: list[Column], where: str) -> FloatArray:
    """Return the columns in the order of the DataFrame."""
    lost = [name for name in order if name not in parts]
    if lost or not order:
        raise InputError(f"{where}: damaged, no values of column {lost[0] if lost else ''}.")
    return np.column_stack([parts[name] for name in order]).astype(float)
