"""Where programs that use DLT coefficients begin to count pixels, and which way."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.dlt import transform_image
from pawnb.errors import InputError, did_you_mean

COEFFICIENTS = ("dltdv", "dltdv7", "easywand", "argus", "xmalab", "pawnb")
"""Whose DLT coefficients are known: DLTdv 8 counts pixels down from 1, DLTdv 7 and older,
easyWand and XMALab up from 1, Argus up from 0, pawnb down from 0."""

_COUNTED_DOWN = ("dltdv", "pawnb")
_COUNTED_FROM_0 = ("argus", "pawnb")


def check_program(program: str | None, *, where: str, option: str) -> str:
    """Refuse a program whose pixels are not known.

    Parameters
    ----------
    program : str or None
        Its name.
    where : str
        The file, for messages.
    option : str
        The option that says it, ``--from`` or ``--to``.

    Returns
    -------
    str
        One of :data:`COEFFICIENTS`.

    Raises
    ------
    InputError
        If it is none of them.
    """
    if program not in COEFFICIENTS:
        near = did_you_mean(program, COEFFICIENTS) if program else ""
        raise InputError(
            f"{where}: DLT coefficients do not say in whose pixels they are; say whose with "
            f"{option} {', '.join(COEFFICIENTS)}{near}."
        )
    return program


def move_coefs(
    coefs: FloatArray,
    program: str,
    heights_px: Sequence[int] | None,
    *,
    back: bool = False,
    where: str = "the coefficients",
) -> FloatArray:
    """Move coefficients from pawnb's pixels to those of a program, or back.

    Parameters
    ----------
    coefs : ndarray, shape (11, n_views)
        DLT coefficients.
    program : str
        One of :data:`COEFFICIENTS`.
    heights_px : sequence of int or None
        Heights of the pictures (one of all, or one a view), needed where v counts upwards.
    back : bool
        From the program's pixels to pawnb's.
    where : str
        The file, for messages.

    Returns
    -------
    ndarray, shape (11, n_views)
        The same cameras in the other pixels.

    Raises
    ------
    InputError
        If heights are needed and not given.
    """
    n = coefs.shape[1]
    up = program not in _COUNTED_DOWN
    if up and (heights_px is None or len(heights_px) not in (1, n)):
        raise InputError(
            f"{where}: {program} counts v upwards from the lower edge; give the height of the "
            f"pictures of its {n} cameras in px (--heights)."
        )
    first = 0.0 if program in _COUNTED_FROM_0 else 1.0
    columns = []
    for i, column in enumerate(coefs.T):
        H = np.array([[1.0, 0.0, first], [0.0, 1.0, first], [0.0, 0.0, 1.0]])
        if up and heights_px is not None:
            H[1] = [0.0, -1.0, heights_px[i if len(heights_px) > 1 else 0]]
        columns.append(transform_image(column, np.linalg.inv(H) if back else H))
    return np.stack(columns, axis=1)
