"""Where the numbers of the body and of each leg are in a pose vector, and what is painted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pawnb.arrays import BoolArray, IntArray
from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.fit.layout import N_BODY, PoseLayout
from pawnb.core.pose.fit.learning.anatomy import parameter_kinds


@dataclass(frozen=True, eq=False)
class PoseIndex:
    """Places in the pose vector of an animal.

    Attributes
    ----------
    n : int
        Length of the vector.
    angles, lengths : ndarray of int
        Where angles and foreshortenings are.
    everything, body : ndarray of int
        All places, and those of the body.
    numbers : tuple of ndarray of int, shape (2 links,)
        Of each leg, where its part is.
    neighbours : tuple of list of int
        Of each leg, those beside it on the same side.
    sides : tuple of list of int
        The legs of each side.
    partner : ndarray of int, shape (legs,)
        The leg of the other side that looks alike, or the leg itself.
    all_shown, body_shown : ndarray of bool, shape (legs + 1,)
        Which legs, and last the body, are painted: all, or the body alone.
    only : tuple of ndarray of bool, shape (legs + 1,)
        Of each leg: it and the body.
    """

    n: int
    angles: IntArray
    lengths: IntArray
    everything: IntArray
    body: IntArray
    numbers: tuple[IntArray, ...]
    neighbours: tuple[list[int], ...]
    sides: tuple[list[int], ...]
    partner: IntArray
    all_shown: BoolArray
    body_shown: BoolArray
    only: tuple[BoolArray, ...]


def partners(animal: StickAnimal) -> IntArray:
    """Return, for each leg, the leg of the other side that looks alike, or itself."""
    mirrored = animal.mirrored_names()
    names = animal.leg_names
    out = []
    for i, leg in enumerate(animal.legs):
        j = names.index(mirrored.get(leg.name, leg.name))
        alike = len(animal.legs[j].segments) == len(leg.segments)
        out.append(j if alike else i)
    return np.array(out)


def index_pose(animal: StickAnimal, layout: PoseLayout) -> PoseIndex:
    """Return where the parts of an animal are in its pose vector.

    Parameters
    ----------
    animal : StickAnimal
        The animal.
    layout : PoseLayout
        The same as arrays.

    Returns
    -------
    PoseIndex
        The places.
    """
    angles, lengths = parameter_kinds(animal)
    n, n_legs = N_BODY + len(angles) + len(lengths), len(animal.legs)
    parts = np.arange(n_legs + 1)
    return PoseIndex(
        n=n,
        angles=angles,
        lengths=lengths,
        everything=np.arange(n),
        body=np.arange(N_BODY),
        numbers=tuple(
            np.arange(first, first + 2 * links)
            for first, links in zip(layout.first, layout.n_links, strict=True)
        ),
        neighbours=tuple(
            [j for j in (i - 1, i + 1) if 0 <= j < n_legs and layout.side[j] == layout.side[i]]
            for i in range(n_legs)
        ),
        sides=tuple(
            [i for i, s in enumerate(layout.side) if s == which] for which in np.unique(layout.side)
        ),
        partner=partners(animal),
        all_shown=np.ones(n_legs + 1, bool),
        body_shown=parts == n_legs,
        only=tuple(np.isin(parts, (i, n_legs)) for i in range(n_legs)),
    )
