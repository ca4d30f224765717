"""Tracks of LocoMouse: the ``.mat`` with ``final_tracks``, bottom and side view of one mouse."""

from __future__ import annotations

import io
import zlib
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import loadmat
from scipy.io.matlab import MatReadError

from pawnb.errors import InputError
from pawnb.files import read_bytes
from pawnb.io.hdf5 import HDF5_FAULTS
from pawnb.io.points import build_tracks
from pawnb.io.unread import AS_TABLE
from pawnb.schema import Tracks
from pawnb.schema.arguments import checked_arguments

POINTS = ("FR", "HR", "FL", "HL", "snout")
"""Points of ``final_tracks`` in their order (LocoMouse, MTF_export_figures.m)."""

VIEWS = ("bottom", "side")

_EXPECTED = "the .mat that LocoMouse writes (MATLAB 5)"
_ARRAYS = ("final_tracks", "tracks_tail")
_MOST_BYTES = 2**28


@checked_arguments
def read_locomouse(path: str | Path, *, fps: float) -> Tracks:
    """Read tracks of LocoMouse.

    Parameters
    ----------
    path : str or Path
        A ``.mat`` with ``final_tracks``, numbers of shape (3, 5, n_frames): x along the corridor,
        y in the view from below and z in the view from the side, px from 1, of FR, HR, FL, HL and
        snout; perhaps ``tracks_tail`` of the same kind.
    fps : float
        Frames per second of the recording; the file does not say.

    Returns
    -------
    xarray.Dataset
        Tracks in the views ``bottom`` (x, y) and ``side`` (x, z), px from 0; points of the tail are
        ``tail_1`` and so on. LocoMouse gives no confidence. A view in which a point was not found
        lacks it there only.

    Raises
    ------
    InputError
        If the file is missing, damaged or of another kind.

    Examples
    --------
    >>> from scipy.io import savemat
    >>> savemat("clip.mat", {"final_tracks": np.arange(45.0).reshape(3, 5, 3)})
    >>> pawnb.io.read_locomouse("clip.mat", fps=400.0)["view"].values.tolist()
    ['bottom', 'side']
    """
    where = Path(path).name
    found = _load(path)
    if "final_tracks" not in found:
        raise InputError(
            f"{where}: no final_tracks in it; expected {_EXPECTED}. Of another program, as DANNCE "
            f"or LEAP: {AS_TABLE}."
        )
    names, parts = list(POINTS), [_numbers(found["final_tracks"], where)]
    if parts[0].shape[1] != len(POINTS):
        raise InputError(
            f"{where}: final_tracks has {parts[0].shape[1]} points; expected {', '.join(POINTS)}."
        )
    if "tracks_tail" in found:
        tail = _numbers(found["tracks_tail"], where)
        if tail.shape[2] == parts[0].shape[2]:
            names += [f"tail_{k + 1}" for k in range(tail.shape[1])]
            parts.append(tail)
    xyz = np.concatenate(parts, axis=1).transpose(2, 1, 0) - 1.0  # frame, point, axis
    place = np.stack([xyz[..., [0, 1]], xyz[..., [0, 2]]], axis=1)[:, :, :, None]
    return build_tracks(
        np.arange(len(place)),
        place,
        points=names,
        fps=fps,
        unit="px",
        program="LocoMouse",
        where=where,
        views=VIEWS,
    )


def _load(path: str | Path) -> dict[str, Any]:
    """Return the arrays of tracks in a file of MATLAB."""
    where = Path(path).name
    data = read_bytes(path, expected=_EXPECTED, most_bytes=_MOST_BYTES)
    _check_sizes(data, where)
    try:
        # arrays by name only: other variables, of classes that exist in MATLAB alone, stay unread
        return loadmat(io.BytesIO(data), variable_names=_ARRAYS)
    except (*HDF5_FAULTS, NotImplementedError, MatReadError, zlib.error, EOFError) as error:
        reason = " ".join(str(error).split())[:100] or type(error).__name__
        raise InputError(
            f"{where}: damaged or of another kind ({reason}); expected {_EXPECTED}: copy it again "
            "from where it is whole."
        ) from None


def _check_sizes(data: bytes, where: str) -> None:
    """Refuse a file whose parts do not fit into it, or unpack to more than a recording has.

    A MAT-file of version 5 is a head of 128 bytes, then parts of a kind (4 bytes), a length (4)
    and data; kind 15 is compressed (MATLAB, "MAT-File Format", 1-11).
    """
    at, order = 128, "little" if data[126:128] == b"IM" else "big"
    while at + 8 <= len(data):
        kind = int.from_bytes(data[at : at + 4], order)  # type: ignore[arg-type]
        length = int.from_bytes(data[at + 4 : at + 8], order)  # type: ignore[arg-type]
        at += 8
        if at + length > len(data) or kind not in (14, 15):
            raise InputError(
                f"{where}: damaged, cut short or of another kind; expected {_EXPECTED}."
            )
        if kind == 15:
            unpack = zlib.decompressobj()
            try:
                unpacked = unpack.decompress(data[at : at + length], _MOST_BYTES)
            except zlib.error:
                raise InputError(
                    f"{where}: damaged, a part cannot be unpacked; copy it again."
                ) from None
            if len(unpacked) >= _MOST_BYTES:
                raise InputError(
                    f"{where}: a part unpacks to more than 256 MB; expected {_EXPECTED}."
                )
        at += length


def _numbers(values: Any, where: str) -> np.ndarray:
    """Return an array of shape (3, n_points, n_frames)."""
    if not (isinstance(values, np.ndarray) and values.dtype.kind in "fiu" and values.ndim == 3):
        raise InputError(
            f"{where}: final_tracks is no array of 3 dimensions; expected {_EXPECTED}."
        )
    if values.shape[0] != 3:
        raise InputError(f"{where}: final_tracks has shape {values.shape}; expected 3 axes first.")
    return np.asarray(values, dtype=float)
