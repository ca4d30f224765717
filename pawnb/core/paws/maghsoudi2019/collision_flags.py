"""What a collision is made of: the paws that can collide, flags, and what becomes of paws."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

from pawnb.arrays import FloatArray, Points2D
from pawnb.core.paws.layout import Layout
from pawnb.core.paws.maghsoudi2019.template_fit import TemplateFit


class Candidates(Protocol):
    """What is needed of a detection: the places of the best superpixels, best first."""

    @property
    def places(self) -> Points2D:
        """Positions, px, shape (k, 2)."""
        ...


@dataclass(frozen=True)
class Undone:
    """A jump that was undone.

    Parameters
    ----------
    key : tuple of int
        View and point.
    rank : int
        Which of the best superpixels is taken instead: 1 is the second best.
    """

    key: tuple[int, int]
    rank: int


@dataclass(frozen=True)
class Resolved:
    """What becomes of a paw in a collision.

    Parameters
    ----------
    key : tuple of int
        View and point.
    rank : int or None
        Which of the best superpixels is taken; None where the paw is lost.
    place : ndarray, shape (2,)
        Where the template has it, px.
    """

    key: tuple[int, int]
    rank: int | None
    place: FloatArray


@dataclass
class Flag:
    """A collision of type II in a view (Flag_Collision).

    Parameters
    ----------
    fits : dict
        Front and hind paw to their fits.
    since : int
        When it began.
    lost : dict
        Paws that are not found to when they were lost.
    parted : int
        Frames since the paws were last near each other.
    """

    fits: dict[int, TemplateFit]
    since: int
    lost: dict[int, int] = field(default_factory=dict)
    parted: int = 0


def find_pairs(layout: Layout) -> tuple[tuple[int, int, int], ...]:
    """Return view, front and hind paw of each side in each view that knows its direction.

    Front and hind paw belong together if their names differ in the first letter only, or
    if they are the only ones in the view.
    """
    pairs = []
    for view, facing in enumerate(layout.facing):
        if not facing:
            continue
        front, hind = (
            [p for p, k in enumerate(layout.kinds) if k == kind and layout.tracked[view, p]]
            for kind in ("front", "hind")
        )
        alike = [
            (view, f, h)
            for f in front
            for h in hind
            if layout.points[f][1:].upper() == layout.points[h][1:].upper()
        ]
        if not alike and len(front) == len(hind) == 1:
            alike = [(view, front[0], hind[0])]
        pairs += alike
    return tuple(pairs)


def weights_in_collision(usual: tuple[float, ...], *, is_front: bool) -> tuple[float, ...]:
    """Return the weights of the features of a paw in collision (Algorithm 4).

    Parameters
    ----------
    usual : tuple of 8 float
        Its weights at other times.
    is_front : bool
        Whether it is a front paw.

    Returns
    -------
    tuple of 8 float
        For a front paw that of F1 (initial green) is one higher, that of F4 (previous hue) one
        lower, but not below 0, and that of F7 (corner) is 0; for a hind paw that of F3 (initial
        hue) is two higher. The paper's section 4.5 calls F1 "previously tracked" and F3 the
        first; Eq. 3 is followed.
    """
    w = list(usual)
    if is_front:
        w[0] += 1
        w[3] = max(w[3] - 1, 0.0)
        w[6] = 0.0
    else:
        w[2] += 2
    return tuple(w)
