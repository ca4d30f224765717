"""Loops over numbers, compiled: numba, the compiled code kept on disk for the next run."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar, cast

import numba

_F = TypeVar("_F", bound=Callable)


def compiled(function: _F) -> _F:
    """Compile a function of arrays and numbers when it is first called.

    While it runs, other threads run too. The code is kept beside the module, or else in the
    user's cache folder; where neither can be written, it is compiled again in every session.

    Parameters
    ----------
    function : callable
        What to compile.

    Returns
    -------
    callable
        The same, fast.
    """
    try:
        return cast("_F", numba.njit(cache=True, nogil=True, error_model="numpy")(function))
    except RuntimeError:  # numba: "cannot cache function: no locator available"
        return cast("_F", numba.njit(nogil=True, error_model="numpy")(function))
