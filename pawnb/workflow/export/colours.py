"""Colours of points over the video: those of the legs are the same as in the figures."""

from __future__ import annotations

from collections.abc import Iterable

from pawnb.figures.style import colour_legs
from pawnb.gait.analysis.leg_names import guess_legs

OTHERS = ("#F0E442", "#FFFFFF", "#7FD6C2")
"""Yellow, white, a pale green: points that are no legs, such as nose and ears."""


def point_colours(points: Iterable[str]) -> dict[str, str]:
    """Give each point its colour.

    Parameters
    ----------
    points : iterable of str
        Names in the order in which they are listed everywhere. Those that other programs'
        users gave to feet (``hindpaw_left``) have the colour of their leg. Where no name says
        which leg it is, all points are coloured as legs.

    Returns
    -------
    dict of str to str
        ``#rrggbb`` by name, see :func:`pawnb.figures.style.colour_legs`; points beside the legs
        have others. They repeat where there are many; the names stand beside the points.
    """
    named = list(points)
    legs = {point: leg for leg, point in guess_legs(named).items()} or {p: p for p in named}
    colours = colour_legs(list(legs.values()))
    others = [point for point in named if point not in legs]
    spare = {point: OTHERS[k % len(OTHERS)] for k, point in enumerate(others)}
    return {point: spare[point] if point in spare else colours[legs[point]] for point in named}
