"""Modules that have moved: an import from the former place is told the present one."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from importlib.abc import MetaPathFinder
from types import ModuleType


class _FormerPlaces(MetaPathFinder):
    """Asked last of all, where no module of that name was found."""

    def __init__(self, homes: Mapping[str, str]) -> None:
        self._homes = homes

    def find_spec(
        self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> None:
        """Raise where the name is that of a module that has moved."""
        del path, target
        if fullname in self._homes:
            raise ModuleNotFoundError(
                f"{fullname} is now {self._homes[fullname]}; import it from there.", name=fullname
            )


def answer_imports(homes: Mapping[str, str]) -> None:
    """From now on, say in one sentence where a module is that is imported from its former place.

    Parameters
    ----------
    homes : mapping of str to str
        Former full name of each module to its present one.
    """
    others = [f for f in sys.meta_path if type(f).__qualname__ != _FormerPlaces.__qualname__]
    sys.meta_path[:] = [*others, _FormerPlaces(homes)]
