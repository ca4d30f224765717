"""A stick animal that a person poses: its joints, its own proportions, what dragging does.

Every change gives a new pose; :mod:`pawnb.widgets.stick_session` keeps them and their file.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.handles import beyond_range, handles, leg_places, reach_tip, turn_joint
from pawnb.core.pose.pose_table import animal_factors
from pawnb.core.pose.poses import Poses
from pawnb.errors import InputError

LEAST_FACTOR, MOST_FACTOR = 0.2, 3.0
"""Legs are made no shorter and no longer than so many times their length."""


@dataclass(frozen=True)
class LegPose:
    """How one leg is bent, and how it differs from its species.

    Parameters
    ----------
    angles_deg : ndarray, shape (n_segments,)
        Every joint, also those that do not turn.
    raised : ndarray, shape (n_segments,)
        Length in the picture over the segment's length: below 1 where it is raised.
    own : ndarray, shape (n_segments,)
        The animal's own length over the species' length.
    missing : bool
        Whether the animal has lost it.
    """

    angles_deg: np.ndarray
    raised: np.ndarray
    own: np.ndarray
    missing: bool = False


@dataclass(frozen=True)
class StickPose:
    """One animal in one frame, as a person poses it.

    Parameters
    ----------
    species : StickAnimal
        The animal as its species file describes it.
    xy : tuple of float
        The origin of the body's frame, px.
    heading_deg, scale : float
        Direction of the body; px per unit.
    legs : mapping
        Leg to its pose.
    """

    species: StickAnimal
    xy: tuple[float, float]
    heading_deg: float
    scale: float
    legs: Mapping[str, LegPose] = field(default_factory=dict)

    # --- where it is ----------------------------------------------------------------------

    def on_body(self, x: float, y: float) -> np.ndarray:
        """Return a place of the body's frame (forward, right; units) in px."""
        turn = np.radians(self.heading_deg)
        cos, sin = np.cos(turn), np.sin(turn)
        return np.array(self.xy) + self.scale * np.array([x * cos - y * sin, x * sin + y * cos])

    def steps_px(self, name: str) -> np.ndarray:
        """Return the lengths of a leg's segments in the picture, px."""
        pose = self.legs[name]
        lengths = np.array(self.species.leg(name).lengths)
        return np.asarray(self.scale * lengths * pose.own * pose.raised)

    def places(self, name: str) -> np.ndarray:
        """Return joints and tip of a leg, shape (n_segments + 1, 2), px."""
        leg = self.species.leg(name)
        return leg_places(
            leg,
            self.on_body(*leg.attach),
            heading_deg=self.heading_deg,
            angles_deg=self.legs[name].angles_deg,
            steps_px=self.steps_px(name),
        )

    def beyond(self) -> dict[str, float]:
        """Return the joints beyond their range, as ``<leg>.<joint>``, and by how much, degrees."""
        out: dict[str, float] = {}
        for leg in self.species.legs:
            if not self.legs[leg.name].missing:
                over = beyond_range(leg, self.legs[leg.name].angles_deg)
                out |= {
                    f"{leg.name}.{joint}": float(by)
                    for joint, by in zip(leg.joints, over, strict=True)
                    if by > 0.5
                }
        return out

    # --- what a person does ---------------------------------------------------------------

    def drag(self, handle: str, u: float, v: float, *, whole: bool = True) -> StickPose:
        """Return the pose after a handle was dragged.

        Parameters
        ----------
        handle : str
            ``body``, ``heading``, ``span``, a joint ``<leg>.<joint>``, or a leg's name: its tip.
        u, v : float
            Where it was dragged to, px.
        whole : bool
            Whether the whole leg follows its tip, or only the last joint turns.

        Returns
        -------
        StickPose
            The new pose.

        Raises
        ------
        InputError
            If there is no such handle.
        """
        step = np.array([u, v]) - self.xy
        if handle == "body":
            return replace(self, xy=(float(u), float(v)))
        if handle == "heading":
            return replace(self, heading_deg=float(np.degrees(np.arctan2(step[1], step[0]))))
        if handle == "span":
            return replace(self, scale=max(2 * float(np.hypot(*step)) / self.species.span, 1e-3))
        name = handle.split(".")[0]
        leg = self.species.leg(name)
        places = handles(leg)
        if handle not in places:
            raise InputError(
                f"{handle} cannot be dragged; expected body, heading, span, or one of "
                f"{', '.join(places)}."
            )
        pose = self.legs[name]
        if handle == name and whole:
            angles = reach_tip(
                leg,
                self.on_body(*leg.attach),
                heading_deg=self.heading_deg,
                angles_deg=pose.angles_deg,
                steps_px=self.steps_px(name),
                to=np.array([u, v]),
            )
        else:
            angles = turn_joint(
                leg, self.places(name), pose.angles_deg, at=places[handle], to=np.array([u, v])
            )
        return self.with_leg(name, replace(pose, angles_deg=angles))

    def with_leg(self, name: str, pose: LegPose) -> StickPose:
        """Return the pose with another pose of one leg."""
        return replace(self, legs={**self.legs, name: pose})

    def length_of(self, name: str) -> float:
        """Return the factor of a leg's length."""
        lengths = np.array(self.species.leg(name).lengths)
        return float(lengths @ self.legs[name].own / lengths.sum())

    def lengthened(self, name: str, factor: float) -> StickPose:
        """Return the pose with a leg of ``factor`` times its species' length.

        Parameters
        ----------
        name : str
            The leg.
        factor : float
            1 is the length in the species file; proportions of its segments stay.

        Returns
        -------
        StickPose
            The new pose.

        Raises
        ------
        InputError
            If the factor is not between 0.2 and 3.
        """
        if not LEAST_FACTOR <= factor <= MOST_FACTOR:
            raise InputError(
                f"the length of {name} is multiplied by {factor:g}; expected "
                f"{LEAST_FACTOR:g} to {MOST_FACTOR:g} (or say that the leg is missing)."
            )
        pose = self.legs[name]
        return self.with_leg(name, replace(pose, own=pose.own * factor / self.length_of(name)))

    def with_missing(self, name: str, *, missing: bool) -> StickPose:
        """Return the pose with a leg lost, or there again.

        Raises
        ------
        InputError
            If it would be the last leg.
        """
        rest = [n for n, pose in self.legs.items() if not pose.missing and n != name]
        if missing and not rest:
            raise InputError(f"{name} is the last leg; an animal needs at least one.")
        return self.with_leg(name, replace(self.legs[name], missing=missing))

    def straightened(self, name: str) -> StickPose:
        """Return the pose with one leg at its natural orientation, flat in the picture."""
        leg = self.species.leg(name)
        fresh = replace(
            self.legs[name],
            angles_deg=np.array(leg.natural_deg, dtype=float),
            raised=np.ones(len(leg.lengths)),
        )
        return self.with_leg(name, fresh)

    def mirrored(self, side: int) -> StickPose:
        """Return the pose with the legs of one side like those of the other.

        Parameters
        ----------
        side : {-1, 1}
            The side that is copied: left or right.

        Returns
        -------
        StickPose
            The new pose: angles, lengths and missing legs.

        Raises
        ------
        InputError
            If no leg has a partner on the other side.
        """
        partners = self.species.mirrored_names()
        legs = dict(self.legs)
        for leg in self.species.legs:
            if leg.side == side and leg.name in partners:
                legs[partners[leg.name]] = self.legs[leg.name]
        if not partners:
            raise InputError(f"{self.species.name}: no leg has a partner on the other side.")
        return replace(self, legs=legs)

    def built_like(self, other: StickPose) -> StickPose:
        """Return the pose of an animal with the proportions and missing legs of another pose."""
        legs = {
            name: replace(pose, own=other.legs[name].own, missing=other.legs[name].missing)
            for name, pose in self.legs.items()
        }
        return replace(self, legs=legs)

    # --- in and out -----------------------------------------------------------------------

    def animal(self) -> StickAnimal:
        """Return the animal with its own legs and proportions."""
        lost = [name for name, pose in self.legs.items() if pose.missing]
        factors = {
            f"{leg.name}_{segment}": float(own)
            for leg in self.species.legs
            if leg.name not in lost
            for segment, own in zip(leg.segments, self.legs[leg.name].own, strict=True)
        }
        animal = self.species.without(lost) if lost else self.species
        return animal.resized(factors)

    def poses(self, frame: int) -> Poses:
        """Return it as the pose of one frame of :meth:`animal`."""
        kept = [leg for leg in self.species.legs if not self.legs[leg.name].missing]
        free = [self.legs[leg.name].angles_deg[np.array(leg.free)] for leg in kept]
        return Poses(
            frames=np.array([frame]),
            xy=np.array([self.xy], dtype=float),
            heading_deg=np.array([self.heading_deg], dtype=float),
            scale=np.array([self.scale], dtype=float),
            angles_deg=np.concatenate(free)[None],
            lengths_px=np.concatenate([self.steps_px(leg.name) for leg in kept])[None],
        )


def stick_pose(species: StickAnimal, animal: StickAnimal, pose: Poses) -> StickPose:
    """Return the pose of one frame as one that a person can change.

    Parameters
    ----------
    species : StickAnimal
        The animal as its species file describes it.
    animal : StickAnimal
        The same with its own legs and proportions.
    pose : Poses
        One frame of ``animal``.

    Returns
    -------
    StickPose
        Legs that ``animal`` lacks are missing, at their natural orientation.
    """
    factors = animal_factors(animal, species)
    scale = float(pose.scale[0])
    legs, free_from, segment_from = {}, 0, 0
    for leg in species.legs:
        n = len(leg.segments)
        natural = np.array(leg.natural_deg, dtype=float)
        if leg.name not in animal.leg_names:
            legs[leg.name] = LegPose(natural, np.ones(n), np.ones(n), missing=True)
            continue
        each = [factors.get(f"{leg.name}_{segment}", 1.0) for segment in leg.segments]
        own = factors.get(leg.name, 1.0) * np.array(each)
        free = np.array(leg.free)
        natural[free] = pose.angles_deg[0, free_from : free_from + free.sum()]
        px = pose.lengths_px[0, segment_from : segment_from + n]
        legs[leg.name] = LegPose(natural, px / (scale * np.array(leg.lengths) * own), own)
        free_from += int(free.sum())
        segment_from += n
    xy = (float(pose.xy[0, 0]), float(pose.xy[0, 1]))
    return StickPose(species, xy, float(pose.heading_deg[0]), scale, legs)
