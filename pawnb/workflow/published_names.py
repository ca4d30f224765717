"""Who types a paper's name of a setting is told ours."""

from __future__ import annotations

from collections.abc import Iterable

from pawnb.core.paws.maghsoudi2019.settings import PUBLISHED_NAMES as PAW_NAMES
from pawnb.core.pose.pullar2009.settings import PUBLISHED_NAMES as POSE_NAMES
from pawnb.errors import InputError


def refuse_published_names(names: Iterable[str], *, pose: bool = False) -> None:
    """Refuse settings that bear a paper's name, saying what they are called here.

    Parameters
    ----------
    names : iterable of str
        Names of settings as somebody wrote them.
    pose : bool
        Whether they are for a jointed animal.

    Raises
    ------
    InputError
        For the first of them, however its letters are cased and joined.
    """
    papers = POSE_NAMES if pose else PAW_NAMES
    plain = {_plain(theirs): theirs for theirs in papers}
    for name in names:
        theirs = plain.get(_plain(name))
        # some are nearly ours: those are suggested anyway
        if theirs is not None and name not in papers.values():
            raise InputError(
                f"setting {name!r} is the paper's {theirs}, which is {papers[theirs]!r} here "
                "(method 'paper'); docs/published_methods.md has the others."
            )


def _plain(name: str) -> str:
    return name.lower().replace("_", "").replace("-", "")
