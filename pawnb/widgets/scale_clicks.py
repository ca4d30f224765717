"""Two clicks a known length apart: the scale of a view."""

from __future__ import annotations

from typing import Any

from pawnb.core.pose.pixel_scale import PxPerUnit, scale_from_clicks
from pawnb.errors import InputError

ENDS = ("end 1", "end 2")
_COLOUR = "#f0e442"


class ScaleClicks:
    """The two ends of a known length.

    Attributes
    ----------
    ends : dict of str to tuple of float
        u, v of the ends clicked so far, px.
    length : float
        How far apart they are, in the unit of the trial.
    """

    def __init__(self, length: float = 10.0) -> None:
        self.ends: dict[str, tuple[float, float]] = {}
        self.length = length

    def click(self, u: float, v: float) -> None:
        """Place the next end; both placed, the nearer one moves there."""
        free = [name for name in ENDS if name not in self.ends]
        near = min(ENDS, key=lambda name: self._far(name, u, v)) if not free else free[0]
        self.ends[near] = (u, v)

    def move(self, name: str, u: float, v: float) -> None:
        """Put one end elsewhere; raises InputError for an unknown one.

        Parameters
        ----------
        name : str
            Which end.
        u, v : float
            Place in the view, px.
        """
        if name not in self.ends:
            raise InputError(f"{name} was not clicked; click both ends of a known length.")
        self.ends[name] = (u, v)

    def set_length(self, length: float) -> None:
        """Say how far apart the ends are; raises InputError unless it is above 0."""
        if not length > 0:
            raise InputError(f"the known length is {length:g}; expected more than 0.")
        self.length = length

    def result(self) -> PxPerUnit | None:
        """Return the scale, or None before both ends are clicked."""
        if len(self.ends) < len(ENDS):
            return None
        first, second = (self.ends[name] for name in ENDS)
        return scale_from_clicks(first, second, distance=self.length)

    def prompt(self, unit: str) -> str:
        """Say what to do next."""
        if len(self.ends) < len(ENDS):
            end = "one end" if not self.ends else "the other end"
            return f"Click {end} of a length that you know."
        return f"Say how many {unit} that is, drag an end to adjust it, then press Enter."

    def marks(self) -> dict[str, Any]:
        """Return what is drawn over the view."""
        points = [
            {"id": name, "u": u, "v": v, "colour": _COLOUR} for name, (u, v) in self.ends.items()
        ]
        both = [[u, v] for u, v in self.ends.values()]
        lines = [{"at": both, "colour": _COLOUR}] if len(both) == len(ENDS) else []
        free = [name for name in ENDS if name not in self.ends]
        return {"points": points, "lines": lines, "chips": [], "asks": free[0] if free else None}

    def _far(self, name: str, u: float, v: float) -> float:
        """Return the squared distance of an end from a place."""
        return (self.ends[name][0] - u) ** 2 + (self.ends[name][1] - v) ** 2
