"""Units of length, where a file says one and a trial another."""

from __future__ import annotations

from pawnb.errors import InputError, InputWarning
from pawnb.input_warnings import warn_of_input

MM_PER_UNIT = {"um": 1e-3, "µm": 1e-3, "mm": 1.0, "cm": 10.0, "m": 1e3, "in": 25.4}

_SHORT = {
    word: unit
    for unit, names in {
        "m": ("m", "meter", "meters", "metre", "metres"),
        "cm": ("cm", "centimeter", "centimeters", "centimetre", "centimetres"),
        "mm": ("mm", "millimeter", "millimeters", "millimetre", "millimetres"),
        "um": ("um", "micrometer", "micrometers", "micrometre", "micrometres", "micron", "microns"),
        "in": ("in", "inch", "inches"),
    }.items()
    for word in names
}  # fmt: skip
"""Units written out, as NWB asks for them, or in capitals."""


def short_unit(said: str) -> str:
    """Return a unit of length as it is called here.

    Parameters
    ----------
    said : str
        Unit as a file calls it, such as ``meters`` or ``MM``.

    Returns
    -------
    str
        Such as ``m``; one that is not known stays as it is.
    """
    said = said.strip()
    return _SHORT.get(said.lower(), said)


def tell_no_unit(where: str, why: str = "", *, stacklevel: int) -> None:
    """Warn that lengths without a unit are taken to be in mm.

    Parameters
    ----------
    where : str
        How the message names the file.
    why : str
        Why it says none, if that is known.
    stacklevel : int
        How far up the caller is whom the warning is for.

    Warns
    -----
    InputWarning
        Always.
    """
    warn_of_input(
        f"{where}: positions in space without a unit{why and f', {why}'}: lengths are taken to be "
        "in mm. Where they are in another, name the file in a trial.toml of kind 'tracks' with its "
        'unit below [calibration] (unit = "m"), or give unit to load_tracks.',
        InputWarning,
        stacklevel=stacklevel + 1,
    )


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
