"""Who types a paper's name of a setting, or a former one, is told the present one."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from pawnb.core.paws.tracker import trackers
from pawnb.errors import InputError


def refuse_published_names(names: Iterable[str], *, kind: str = "paws") -> None:
    """Refuse settings that bear a paper's name or a former one, saying what they are called.

    Parameters
    ----------
    names : iterable of str
        Names of settings as somebody wrote them.
    kind : str
        The kind of trial they are for.

    Raises
    ------
    InputError
        For the first of them, however its letters are cased and joined.
    """
    papers: dict[str, str] = {}
    for tracker in trackers(kind).values():
        papers |= tracker.published_names
    former = _former_names(kind)
    plain = {_plain(theirs): theirs for theirs in papers}
    for name in names:
        if name in former:
            raise InputError(f"setting {name!r} is called {former[name]!r} now.")
        theirs = plain.get(_plain(name))
        # some are nearly ours: those are suggested anyway
        if theirs is not None and name not in papers.values():
            raise InputError(
                f"setting {name!r} is the paper's {theirs}, which is {papers[theirs]!r} here "
                "(method 'paper'); docs/published_methods.md has the others."
            )


def with_present_names(settings: Mapping[str, Any], *, kind: str = "paws") -> dict[str, Any]:
    """Return settings that tracks record, those with a former name under the present one."""
    former = _former_names(kind)
    return {former.get(name, name): value for name, value in settings.items()}


def _former_names(kind: str) -> dict[str, str]:
    """Return what settings of the trackers of a kind were called, and are called now."""
    former: dict[str, str] = {}
    for tracker in trackers(kind).values():
        former |= tracker.former_names
    return former


def _plain(name: str) -> str:
    return name.lower().replace("_", "").replace("-", "")
