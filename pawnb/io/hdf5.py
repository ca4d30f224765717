"""HDF5 from other programs, read with care: any fault of the file is one sentence.

A damaged file makes h5py raise errors of many kinds, or ask for more memory than any machine
has. A file may also name other files, which would then be read in its place. What pawnb reads
from HDF5 is read through here, as plain numbers and text only.
"""

from __future__ import annotations

import mmap
import struct
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import h5py
import numpy as np

from pawnb.arrays import AnyArray
from pawnb.errors import InputError
from pawnb.files import check_file

HDF5_FAULTS = (
    OSError, RuntimeError, ValueError, KeyError, IndexError, TypeError, AttributeError,
    MemoryError, OverflowError, AssertionError, SystemError,
)  # fmt: skip
"""What h5py and those who build on it raise where a file is damaged."""

_MOST_RATIO = 1100
"""gzip makes no data smaller than by this factor; more than that was never in the file."""

_SLACK_BYTES = 2**26
_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_HEAP = b"GCOL\1\0\0\0"
_MOST_ATTRIBUTE_BYTES = 2**24


def is_hdf5(path: str | Path) -> bool:
    """Say whether a file begins as HDF5 does.

    Parameters
    ----------
    path : str or Path
        The file.

    Returns
    -------
    bool
        True for HDF5; False also for what is no file, which whoever reads it says.
    """
    try:
        with check_file(path).open("rb") as file:
            return file.read(len(_SIGNATURE)) == _SIGNATURE
    except (InputError, OSError):
        return False


@contextmanager
def open_hdf5(path: str | Path, *, expected: str) -> Iterator[h5py.File]:
    """Open an HDF5 file for reading.

    Parameters
    ----------
    path : str or Path
        The file.
    expected : str
        What it should be, for messages: ``"the h5 file that SLEAP writes"``.

    Yields
    ------
    h5py.File
        The open file. It has neither links to other files nor data that is larger than the
        file can hold.

    Raises
    ------
    InputError
        If it is no regular file, no HDF5, damaged, or one of those; also where that is found
        out only while the caller reads.
    """
    path = check_file(path, expected=expected)
    with faults_in(path, expected=expected):
        _check_heaps(path)
        with h5py.File(path, "r") as file:
            _check_links(file, path)
            yield file


@contextmanager
def faults_in(path: Path, *, expected: str) -> Iterator[None]:
    """Turn what is raised where an HDF5 file is damaged into one sentence.

    Parameters
    ----------
    path : Path
        The file.
    expected : str
        What it should be.

    Raises
    ------
    InputError
        For every fault of the file.
    """
    try:
        yield
    except InputError:
        raise
    except HDF5_FAULTS as error:
        reason = " ".join(str(error).split())[:150] or type(error).__name__
        raise InputError(
            f"{path.name}: damaged or of another kind ({reason}); expected {expected}: copy it "
            "again from where it is whole, or write it anew."
        ) from None


def read_array(group: h5py.Group, name: str, *, where: str, ndim: int | None = None) -> AnyArray:
    """Read a dataset of numbers.

    Parameters
    ----------
    group : h5py.Group
        Where it lies.
    name : str
        Its name.
    where : str
        How messages name the file.
    ndim : int, optional
        The number of its dimensions.

    Returns
    -------
    ndarray
        Numbers, or records of them.

    Raises
    ------
    InputError
        If it is not there, or holds something else than numbers.
    """
    data = _dataset(group, name, where)
    kinds = [data.dtype[n].base.kind for n in data.dtype.names or ()] or [data.dtype.kind]
    if not set(kinds) <= set("iufb") or (ndim is not None and data.ndim != ndim):
        raise InputError(
            f"{where}: {name} is an array of {data.dtype} with shape {data.shape}; expected "
            f"numbers{f' in {ndim} dimensions' if ndim is not None else ''}."
        )
    return np.asarray(data[()])


def read_texts(group: h5py.Group, name: str, *, where: str) -> list[str]:
    """Read a dataset of text.

    Parameters
    ----------
    group : h5py.Group
        Where it lies.
    name : str
        Its name.
    where : str
        How messages name the file.

    Returns
    -------
    list of str
        The words.

    Raises
    ------
    InputError
        If it is not there, or holds something else than text.
    """
    data = _dataset(group, name, where)
    words = data.dtype.kind == "S" or h5py.check_string_dtype(data.dtype) is not None
    if data.size == 0:
        return []
    if not words or data.ndim != 1:
        raise InputError(f"{where}: {name} is an array of {data.dtype}; expected a list of names.")
    return [word.decode() if isinstance(word, bytes) else str(word) for word in data[()]]


def read_attribute(item: h5py.Group | h5py.Dataset, name: str, *, where: str) -> bytes:
    """Read an attribute that is a text, as its bytes.

    Parameters
    ----------
    item : h5py.Group or h5py.Dataset
        What has the attribute.
    name : str
        Its name.
    where : str
        How messages name the file.

    Returns
    -------
    bytes
        What it holds, up to 16 MB.

    Raises
    ------
    InputError
        If it is not there, or is something else.
    """
    if name not in item.attrs:
        raise InputError(f"{where}: attribute {name} of {item.name} is missing.")
    kind = item.attrs.get_id(name)
    text = h5py.check_string_dtype(kind.dtype) is not None
    if not (text or kind.dtype.kind in "SV") or kind.shape != ():
        raise InputError(f"{where}: attribute {name} of {item.name} is no text.")
    value = item.attrs[name]
    if isinstance(value, h5py.Empty):
        return b""
    data = value.encode() if isinstance(value, str) else bytes(value)
    if len(data) > _MOST_ATTRIBUTE_BYTES:
        raise InputError(f"{where}: attribute {name} of {item.name} has {len(data)} bytes.")
    return data


def _dataset(group: h5py.Group, name: str, where: str) -> h5py.Dataset:
    """Return a dataset by name."""
    data = group.get(name)
    if not isinstance(data, h5py.Dataset) or data.shape is None:
        raise InputError(f"{where}: no array {name} in {group.name}.")
    return data


def _check_links(file: h5py.File, path: Path) -> None:
    """Refuse links out of the file, and data larger than the file can hold."""
    where, most = path.name, path.stat().st_size
    names: list[str] = []
    hard: list[bool] = []
    soft: list[bool] = []

    def note(link: bytes, info: h5py.h5l.LinkInfo) -> None:
        # h5py loses what is raised in here
        names.append(link.decode("utf-8", "replace"))
        # one by name within the file leads to what is looked at under its own name
        hard.append(info.type == h5py.h5l.TYPE_HARD)
        soft.append(info.type == h5py.h5l.TYPE_SOFT)

    file.id.links.visit(note, info=True)
    for name, direct, within in zip(names, hard, soft, strict=True):
        if within:
            continue
        if not direct:
            raise InputError(f"{where}: {name!r} links to elsewhere; only whole files are read.")
        item = file[name]
        if not isinstance(item, h5py.Dataset):
            continue
        if item.is_virtual or item.external:
            raise InputError(f"{where}: {name!r} lies in another file; only whole files are read.")
        if max(_text_lengths(item, path), default=0) > most:
            raise InputError(f"{where}: damaged, a text in {name!r} is longer than the file.")
        stored, size = item.id.get_storage_size(), item.dtype.itemsize * (item.size or 0)
        if size > _SLACK_BYTES + _MOST_RATIO * stored:
            raise InputError(
                f"{where}: damaged, {name!r} claims {size / 1e9:.1f} GB of which the file holds "
                f"{stored} bytes; copy it again from where it is whole."
            )


def _text_lengths(item: h5py.Dataset, path: Path) -> list[int]:
    """Return how long the texts of an array are said to be: HDF5 makes room for all of it."""
    text = h5py.check_string_dtype(item.dtype)
    offset = item.id.get_offset() if text is not None and text.length is None else None
    if offset is None:
        return []
    with path.open("rb") as file:
        file.seek(offset)
        # each is a length (4 bytes), the address of its heap (8) and its number there (4)
        found = file.read(16 * (item.size or 0))
    return [length for (length,) in struct.iter_unpack("<I12x", found[: len(found) // 16 * 16])]


def _check_heaps(path: Path) -> None:
    """Refuse a file whose heaps of texts are damaged: HDF5 reads such a heap for ever.

    A global heap is ``GCOL``, its version and size, and objects of a number, a size and their
    data; number 0 is the room that is left (HDF5 File Format Specification 3.0, III.E).
    """
    if path.stat().st_size == 0:
        return
    with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
        start = data.find(_HEAP)
        while start >= 0:
            (size,) = struct.unpack("<Q", data[start + 8 : start + 16].ljust(8, b"\xff"))
            at, end = start + 16, start + size
            while at + 16 <= end <= len(data):
                number, length = struct.unpack("<H6xQ", data[at : at + 16])
                at += length if number == 0 else 16 + (length + 7) // 8 * 8
                if length == 0 and number == 0:
                    break
            if not start + 16 < at <= end <= len(data) or end - at >= 16:
                raise InputError(
                    f"{path.name}: damaged, a heap of texts at byte {start} is broken; copy the "
                    "file again from where it is whole, or write it anew."
                )
            start = data.find(_HEAP, start + 4)
