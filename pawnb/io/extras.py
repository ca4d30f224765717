"""Libraries that few need: each an extra of the package, named to whoever lacks it."""

from __future__ import annotations

import importlib
from types import ModuleType

from pawnb.errors import InputError


def need(module: str, extra: str, *, what: str) -> ModuleType:
    """Import a library of an extra, or say how to get it.

    Parameters
    ----------
    module : str
        Its name in Python.
    extra : str
        The extra of pawnb that brings it.
    what : str
        What it is needed for: "to write clip.slp".

    Returns
    -------
    module
        The library.

    Raises
    ------
    InputError
        If it is not installed.
    """
    found = None
    try:
        found = importlib.import_module(module)
    except ModuleNotFoundError as error:
        if error.name is None or error.name.split(".")[0] != module.split(".")[0]:
            raise  # it is there, but not what it needs
    if found is None or found.__file__ is None:  # no file: a folder of that name beside a notebook
        raise InputError(
            f"{module} is needed {what} and is not installed; install it with "
            f'python -m pip install "pawnb[{extra}]".'
        )
    return found
