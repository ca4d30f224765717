"""A pandas DataFrame of numbers into HDF5, by h5py alone: the layout "fixed" of pandas.

Nothing is pickled: of the two layouts of pandas this is the one whose names are arrays of text.
``pandas.read_hdf`` takes it, and with it every program that reads files of DeepLabCut
(pandas, ``io/pytables.py``; PyTables tells its objects by the attribute ``CLASS``).
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

import h5py
import numpy as np

from pawnb.arrays import FloatArray, IntArray

_NONE = np.bytes_(b"N.")
"""How PyTables writes that there is no name."""
_MOST_NAMES = 127
"""Codes of names are kept in one byte up to here, as pandas does."""


def pandas_frame_bytes(
    values: FloatArray,
    *,
    key: str,
    columns: Sequence[tuple[str, ...]],
    levels: Sequence[str],
    index: IntArray | Sequence[tuple[str, ...]],
) -> bytes:
    """Return a file that ``pandas.read_hdf`` reads as a DataFrame.

    Parameters
    ----------
    values : ndarray, shape (n_rows, n_columns)
        The numbers.
    key : str
        Name of the DataFrame in the file.
    columns : sequence of tuple of str
        Names of the columns, one word a level.
    levels : sequence of str
        Names of the levels.
    index : ndarray or sequence of tuple of str
        Whole numbers, or names of the rows of one or several words.

    Returns
    -------
    bytes
        The HDF5 file.
    """
    buffer = io.BytesIO()
    with h5py.File(buffer, "w", track_order=False) as file:
        _describe(file, "GROUP", PYTABLES_FORMAT_VERSION="2.1")
        group = file.create_group(key)
        _describe(
            group,
            "GROUP",
            pandas_type="frame",
            encoding="UTF-8",
            errors="strict",
            ndim=2,
            nblocks=1,
        )
        for axis in ("axis0", "block0_items"):
            _write_names(group, axis, columns, levels)
        if isinstance(index, np.ndarray):
            _set(group, {"axis1_variety": "regular"})
            _write_array(group, "axis1", index.astype(np.int64), kind="integer", name=None)
        elif all(len(row) == 1 for row in index):
            _set(group, {"axis1_variety": "regular"})
            words = _encoded([row[0] for row in index])
            _write_array(group, "axis1", words, kind="string", name=None, nan_rep="")
        else:
            _write_names(group, "axis1", index, [None] * len(index[0]))
        _write_array(group, "block0_values", np.asarray(values, dtype=np.float64))
    return buffer.getvalue()


def _write_names(
    group: h5py.Group,
    axis: str,
    names: Sequence[tuple[str, ...]],
    levels: Sequence[str | None],
) -> None:
    """Write names of several levels: the words of each level, and which of them each name has."""
    _set(group, {f"{axis}_variety": "multi", f"{axis}_nlevels": len(levels)})
    for i, level in enumerate(levels):
        words = list(dict.fromkeys(name[i] for name in names))
        place = {one: k for k, one in enumerate(words)}
        codes = np.array([place[name[i]] for name in names])
        small = np.int8 if len(words) <= _MOST_NAMES else np.int32
        named = {f"{axis}_name{level}": level}
        _write_array(
            group, f"{axis}_level{i}", _encoded(words), kind="string", name=level, nan_rep="",
            **named,
        )  # fmt: skip
        _write_array(group, f"{axis}_label{i}", codes.astype(small))


def _write_array(group: h5py.Group, where: str, data: np.ndarray, **attributes: Any) -> None:
    """Write an array as PyTables describes one."""
    item = group.create_dataset(where, data=data, track_times=False)
    _describe(item, "ARRAY", version="2.4", FLAVOR="numpy", **attributes)
    item.attrs["transposed"] = np.uint8(1)


def _describe(
    item: h5py.Group | h5py.Dataset, what: str, *, version: str = "1.0", **attributes: Any
) -> None:
    """Write the attributes by which PyTables knows its objects."""
    _set(item, {"CLASS": what, "TITLE": "", "VERSION": version, **attributes})


def _set(item: h5py.Group | h5py.Dataset, attributes: dict[str, Any]) -> None:
    """Set attributes as PyTables stores text, numbers and the absence of a name."""
    for name, value in attributes.items():
        if value is None:
            item.attrs[name] = _NONE
        elif value == "":
            item.attrs[name] = h5py.Empty("S1")
        elif isinstance(value, str):
            # of one length and in UTF-8: else PyTables gives bytes in place of text
            data = value.encode()
            item.attrs.create(name, data, dtype=h5py.string_dtype("utf-8", len(data)))
        else:
            item.attrs[name] = value


def _encoded(words: Sequence[str]) -> np.ndarray:
    """Return words as bytes of one length."""
    return np.array([word.encode() for word in words], dtype=np.bytes_)
