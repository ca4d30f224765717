"""The stick animal: body ellipses and legs of straight segments, in the plane of the picture.

Pullar 2009, §3.3.1. In the body's frame x points forward and y to the animal's right, and
the origin is the cephalothorax-abdomen joint; seen from above that is a picture with u along
x and v along y, turned by the heading.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.errors import InputError, did_you_mean

RIGHT, LEFT = 1, -1


@dataclass(frozen=True, kw_only=True)
class Ellipse:
    """A part of the body that does not bend.

    Parameters
    ----------
    name : str
        For instance ``cephalothorax``.
    centre : tuple of float
        Centre in the body's frame: forward, right; unit of the species file.
    length, width : float
        Whole axes along and across the body.
    """

    name: str
    centre: tuple[float, float]
    length: float
    width: float


@dataclass(frozen=True, kw_only=True)
class Leg:
    """A leg: a chain of segments, each turned about the joint at its inner end.

    Parameters
    ----------
    name : str
        For instance ``L1``.
    side : {1, -1}
        1 on the animal's right, -1 on its left.
    attach : tuple of float
        Place of the body-coxa joint in the body's frame: forward, right.
    segments, joints : tuple of str
        Short names, from the body outwards: segment i turns about joint i.
    lengths : tuple of float
        Lengths of the segments, unit of the species file.
    natural_deg : tuple of float
        Natural orientation of each joint: the first from the perpendicular to the body's axis,
        the others from the segment before; positive forwards on both sides.
    range_deg : tuple of float
        Whole mechanical range of each joint, half of it to either side of its natural
        orientation (erratum to Table 3.2: it lists whole ranges).
    free : tuple of bool
        Joints that a tracker may turn; the others stay at their natural orientation.
    widths : tuple of float
        Thickness at the inner end of each segment, and at the tip.
    """

    name: str
    side: int
    attach: tuple[float, float]
    segments: tuple[str, ...]
    joints: tuple[str, ...]
    lengths: tuple[float, ...]
    natural_deg: tuple[float, ...]
    range_deg: tuple[float, ...]
    free: tuple[bool, ...]
    widths: tuple[float, ...]


@dataclass(frozen=True, kw_only=True)
class StickAnimal:
    """A jointed animal as its species file describes it.

    Parameters
    ----------
    name, title, unit, source : str
        Name of the species file, what to call the animal in words, the unit of its lengths,
        and where the numbers come from.
    body : tuple of Ellipse
        The body, front to rear.
    legs : tuple of Leg
        The legs, in the order of tables.

    Attributes
    ----------
    joints : tuple of str
        Free joints as ``<leg>_<joint>``, leg by leg from the body outwards.
    segments : tuple of str
        Segments as ``<leg>_<segment>``.
    """

    name: str
    title: str = ""
    unit: str = "mm"
    source: str = ""
    body: tuple[Ellipse, ...]
    legs: tuple[Leg, ...]
    joints: tuple[str, ...] = field(init=False)
    segments: tuple[str, ...] = field(init=False)

    def __post_init__(self) -> None:
        joints = [
            f"{leg.name}_{joint}"
            for leg in self.legs
            for joint, free in zip(leg.joints, leg.free, strict=True)
            if free
        ]
        object.__setattr__(self, "joints", tuple(joints))
        segments = [f"{leg.name}_{segment}" for leg in self.legs for segment in leg.segments]
        object.__setattr__(self, "segments", tuple(segments))

    @property
    def leg_names(self) -> tuple[str, ...]:
        """Names of the legs."""
        return tuple(leg.name for leg in self.legs)

    @property
    def n_dof(self) -> int:
        """Degrees of freedom: place (2), heading, and every free joint."""
        return 3 + len(self.joints)

    @property
    def natural_deg(self) -> FloatArray:
        """Natural orientation of the free joints, degrees, shape (n_joints,)."""
        return self._of_free("natural_deg")

    @property
    def range_deg(self) -> FloatArray:
        """Whole mechanical range of the free joints, degrees, shape (n_joints,)."""
        return self._of_free("range_deg")

    @property
    def lengths(self) -> FloatArray:
        """Lengths of all segments, shape (n_segments,)."""
        return np.array([length for leg in self.legs for length in leg.lengths])

    @property
    def span(self) -> float:
        """Leg span: twice the greatest length from the body's axis to the tip of a straight leg."""
        return 2.0 * max(abs(leg.attach[1]) + sum(leg.lengths) for leg in self.legs)

    @property
    def body_length(self) -> float:
        """Length of the body along its axis."""
        front = max(part.centre[0] + part.length / 2 for part in self.body)
        return front - min(part.centre[0] - part.length / 2 for part in self.body)

    def leg(self, name: str) -> Leg:
        """Return the leg of that name; raises InputError if there is none."""
        for leg in self.legs:
            if leg.name == name:
                return leg
        raise InputError(
            f"{self.name} has no leg {name!r}{did_you_mean(name, self.leg_names)}; "
            f"its legs are {', '.join(self.leg_names)}."
        )

    def without(self, legs: Sequence[str]) -> StickAnimal:
        """Return the animal without some of its legs; raises InputError for an unknown one."""
        lost = {self.leg(name).name for name in legs}
        if len(lost) == len(self.legs):
            raise InputError(f"{self.name}: every leg is said to be missing; keep at least one.")
        return dataclasses.replace(
            self, legs=tuple(leg for leg in self.legs if leg.name not in lost)
        )

    def resized(self, factors: Mapping[str, float]) -> StickAnimal:
        """Return the animal with some legs or segments longer or shorter.

        Parameters
        ----------
        factors : mapping
            ``<leg>`` or ``<leg>_<segment>`` to the factor of its length; a segment's factor
            comes on top of its leg's.

        Returns
        -------
        StickAnimal
            The changed animal.

        Raises
        ------
        InputError
            For an unknown name or a factor that is not positive.
        """
        known = (*self.leg_names, *self.segments)
        for name, factor in factors.items():
            if name not in known:
                raise InputError(
                    f"{self.name} has no leg or segment {name!r}{did_you_mean(name, known)}."
                )
            if not (np.isfinite(factor) and factor > 0):
                raise InputError(
                    f"{self.name}: the length of {name} is multiplied by {factor}; expected a "
                    "number above 0 (a missing leg is left out instead)."
                )

        def changed(leg: Leg) -> Leg:
            whole = factors.get(leg.name, 1.0)
            each = [whole * factors.get(f"{leg.name}_{segment}", 1.0) for segment in leg.segments]
            lengths = tuple(
                length * factor for length, factor in zip(leg.lengths, each, strict=True)
            )
            return dataclasses.replace(leg, lengths=lengths)

        return dataclasses.replace(self, legs=tuple(changed(leg) for leg in self.legs))

    def mirrored_names(self) -> dict[str, str]:
        """Map each leg to its partner on the other side: same place along the body."""
        partners = {}
        for leg in self.legs:
            for other in self.legs:
                across = (other.attach[0], -other.attach[1]) == tuple(leg.attach)
                if other.side == -leg.side and across:
                    partners[leg.name] = other.name
        return partners

    def _of_free(self, name: str) -> FloatArray:
        """Return one property of the free joints, leg by leg."""
        return np.array(
            [
                value
                for leg in self.legs
                for value, free in zip(getattr(leg, name), leg.free, strict=True)
                if free
            ],
            dtype=float,
        )
