"""Units of length, where a file says one and a trial another."""

from __future__ import annotations

from pawnb.errors import InputError

MM_PER_UNIT = {"um": 1e-3, "µm": 1e-3, "mm": 1.0, "cm": 10.0, "m": 1e3, "in": 25.4}


def units_per_unit(said: str, wanted: str, *, where: str) -> float:
    """Return by what lengths of one unit are multiplied to be in another.

    Parameters
    ----------
    said : str
        Unit of the lengths.
    wanted : str
        Unit that they are to be in.
    where : str
        How messages name the file.

    Returns
    -------
    float
        The factor, 1 where both are the same.

    Raises
    ------
    InputError
        If they differ and it is not known by what.
    """
    if said == wanted:
        return 1.0
    if said in MM_PER_UNIT and wanted in MM_PER_UNIT:
        return MM_PER_UNIT[said] / MM_PER_UNIT[wanted]
    raise InputError(
        f"{where}: positions are in {said!r}, and {wanted!r} is asked for; expected the same unit, "
        f"or two of {', '.join(MM_PER_UNIT)}: correct [calibration] unit, or leave it out."
    )
