"""Colours of points that colour-blind readers can tell apart, on a green belt and on fur."""

from __future__ import annotations

from collections.abc import Iterable

from pawnb.core.paws.settings import PaperSettings

PALETTE = (
    "#E69F00",  # orange
    "#56B4E9",  # sky blue
    "#F0E442",  # yellow
    "#CC79A7",  # reddish purple
    "#FFFFFF",  # white
    "#D55E00",  # vermilion
    "#7FD6C2",  # pale bluish green
    "#0072B2",  # blue
)
"""After Okabe & Ito (2008), *Color Universal Design*, ordered so that neighbours differ
most and the green of a treadmill belt comes late and pale."""


def point_colours(points: Iterable[str]) -> dict[str, str]:
    """Give each point its colour.

    Paws come first: they look the same whether nose and ears are tracked as well or not.

    Parameters
    ----------
    points : iterable of str
        Names in the order in which they are listed everywhere.

    Returns
    -------
    dict of str to str
        ``#rrggbb`` by name; they repeat after eight points, which keep their names beside
        them in the picture.
    """
    named = list(points)
    kind = PaperSettings().kind
    ordered = sorted(named, key=lambda name: kind(name) == "other")
    colours = {name: PALETTE[place % len(PALETTE)] for place, name in enumerate(ordered)}
    return {name: colours[name] for name in named}
