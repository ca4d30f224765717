"""Two clicks a known length apart, or a grid of known spacing: the scale of a view."""

from __future__ import annotations

from typing import Any

import numpy as np

from pawnb.core.pose.pixel_scale import PxPerUnit, scale_from_clicks, scale_from_grid
from pawnb.errors import InputError

SCALE_ENDS = ("end 1", "end 2")
_SCALE_COLOUR = "#f0e442"


class ScaleClicks:
    """The two ends of a known length.

    Attributes
    ----------
    ends : dict of str to tuple of float
        u, v of the ends clicked so far, px.
    length : float
        How far apart they are, in the unit of the trial.
    found : PxPerUnit or None
        The scale of a grid that was found instead.
    """

    def __init__(self, length: float = 10.0) -> None:
        self.ends: dict[str, tuple[float, float]] = {}
        self.length = length
        self.found: PxPerUnit | None = None

    def click(self, u: float, v: float) -> None:
        """Place the next end; both placed, the nearer one moves there."""
        free = [name for name in SCALE_ENDS if name not in self.ends]
        near = min(SCALE_ENDS, key=lambda name: self._far(name, u, v)) if not free else free[0]
        self.ends[near], self.found = (u, v), None

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
        self.ends[name], self.found = (u, v), None

    def take_grid(self, grey: np.ndarray) -> None:
        """Measure a grid whose lines are the known length apart.

        Parameters
        ----------
        grey : ndarray, shape (H, W), uint8
            The picture that shows it.

        Raises
        ------
        InputError
            If no grid is found that can be measured.
        """
        self.found, self.ends = scale_from_grid(grey, spacing=self.length), {}

    def set_length(self, length: float) -> None:
        """Say how far apart the ends are; raises InputError unless it is above 0."""
        if not length > 0:
            raise InputError(f"the known length is {length:g}; expected more than 0.")
        self.length, self.found = length, None

    def result(self) -> PxPerUnit | None:
        """Return the scale, or None before a grid is found or both ends are clicked."""
        if self.found is not None:
            return self.found
        if len(self.ends) < len(SCALE_ENDS):
            return None
        first, second = (self.ends[name] for name in SCALE_ENDS)
        return scale_from_clicks(first, second, distance=self.length)

    def prompt(self, unit: str) -> str:
        """Say what to do next."""
        if self.found is not None:
            return "A grid was found; press Enter to use its scale, or click two ends instead."
        if len(self.ends) < len(SCALE_ENDS):
            end = "one end" if not self.ends else "the other end"
            return f"Click {end} of a length that you know."
        return f"Say how many {unit} that is, drag an end to adjust it, then press Enter."

    def marks(self) -> dict[str, Any]:
        """Return what is drawn over the view."""
        points = [
            {"id": name, "u": u, "v": v, "colour": _SCALE_COLOUR}
            for name, (u, v) in self.ends.items()
        ]
        both = [[u, v] for u, v in self.ends.values()]
        lines = [{"at": both, "colour": _SCALE_COLOUR}] if len(both) == len(SCALE_ENDS) else []
        free = [name for name in SCALE_ENDS if name not in self.ends]
        return {"points": points, "lines": lines, "chips": [], "asks": free[0] if free else None}

    def _far(self, name: str, u: float, v: float) -> float:
        """Return the squared distance of an end from a place."""
        return (self.ends[name][0] - u) ** 2 + (self.ends[name][1] - v) ** 2
