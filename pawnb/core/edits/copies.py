"""Memory of long tracks goes back to the system as soon as it is not needed any more."""

from __future__ import annotations

import ctypes
import mmap
import sys

import numpy as np

from pawnb.arrays import AnyArray
from pawnb.schema import Tracks

_OWN_PAGES_BYTES = 1 << 20
"""Arrays from this size on have pages of their own, B: smaller ones would waste part of a page."""


def copy_tracks(tracks: Tracks) -> Tracks:
    """Return a deep copy of Tracks; nothing of it is shared with them.

    Each correction makes a copy and drops the one before. From ``malloc`` these were kept by the
    process: after two corrections of 100,000 frames (55 MB of tracks) 84 MB that nothing used.
    Large arrays therefore have memory of their own, which is given back with the array.

    Parameters
    ----------
    tracks : xarray.Dataset
        The tracks; not modified.

    Returns
    -------
    xarray.Dataset
        The copy.
    """
    data = {name: _own_pages(variable.values) for name, variable in tracks.data_vars.items()}
    return tracks.copy(deep=True, data=data)


def _own_pages(values: AnyArray) -> AnyArray:
    """Return a copy of an array, a large one in memory that is mapped for it alone."""
    if values.nbytes < _OWN_PAGES_BYTES or values.dtype.hasobject:
        return values.copy()
    if sys.platform == "win32":
        pages = mmap.mmap(-1, values.nbytes)
    else:  # private: a process that is forked must not write into it
        pages = mmap.mmap(-1, values.nbytes, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
    copy = np.frombuffer(pages, dtype=values.dtype).reshape(values.shape)
    copy[...] = values
    return copy


def give_back_memory() -> bool:
    """Give free memory that ``malloc`` keeps back to the system, where that is possible (Linux).

    Looking for doubtful labels and drawing lanes takes arrays of hundreds of megabytes for a moment
    in a long recording. What lies between things that stay is kept by glibc though it is free:
    21 MB after a reviewer of 100,000 frames is opened, 30 MB after a correction. It takes 25 ms.

    Returns
    -------
    bool
        Whether anything was given back.
    """
    if not sys.platform.startswith("linux"):
        return False
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)  # musl has none
    return trim is not None and bool(trim(0))
