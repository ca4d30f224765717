"""The few exceptions pawnb raises on purpose.

Each message is one sentence that says what was found, what was expected and
how to mend it. The command line prints it and exits with status 2.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable

_MOST_SIGNS = 2000


class PawnbError(Exception):
    """Base of every error that pawnb raises on purpose.

    A message that holds what a damaged file holds may be of any length: of one longer than
    2000 signs the beginning and the end are kept.

    Examples
    --------
    >>> try:
    ...     pawnb.load_trial("no-such-folder")
    ... except pawnb.PawnbError as error:
    ...     print("no-such-folder" in str(error))
    True
    """

    def __init__(self, message: str = "") -> None:
        if len(message) > _MOST_SIGNS:
            message = f"{message[: _MOST_SIGNS // 2]} ... {message[-_MOST_SIGNS // 4 :]}"
        super().__init__(message)


class InputError(PawnbError, ValueError):
    """Something the user gave (a file, a setting, a click) cannot be used as it is.

    Examples
    --------
    >>> try:
    ...     pawnb.View(name="cam1", video="cam1.avi", facing=2)
    ... except pawnb.InputError as error:
    ...     print(error)
    facing is 2; expected 1 (right) or -1 (left).
    """


class VideoError(InputError):
    """A video cannot be opened, is damaged, or lacks the frame that was asked for."""


class CalibrationError(InputError):
    """Calibration is missing, or its points do not determine a camera."""


class BusyError(InputError):
    """Another process, window or machine is writing there; nothing is wrong with what was given."""


class InputWarning(UserWarning):
    """Something the user gave is used, but not as it was probably meant (a file cut short)."""


class ResumptionWarning(InputWarning):
    """A run goes on with an interrupted one, or begins anew: no part of what it finds."""


class QualityWarning(InputWarning):
    """Tracks were made, and most of them are expected to be wrong."""


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Return `` (did you mean 'x'?)`` for the nearest known name, or an empty string.

    Parameters
    ----------
    name : str
        What was found.
    known : iterable of str
        What is allowed.

    Returns
    -------
    str
        The hint with a leading blank, or ``""`` where nothing is near.
    """
    names = list(known)
    # RF for FR, fr for FR: too short for likeness to tell
    near = [one for one in names if sorted(one.casefold()) == sorted(name.casefold())][:1]
    near = near or difflib.get_close_matches(name, names, n=1, cutoff=0.6)
    return f" (did you mean {near[0]!r}?)" if near else ""
