"""The stick animal as arrays for compiled loops, and its pose as one vector.

Everything here is in *working pixels*: the view reduced by a whole factor, whose pixel (0, 0)
is the mean of the first square of view pixels.

A pose is a vector: x, y, heading, then for each leg the angles of its *links* and the logarithms
of their foreshortening. A link is what moves as one piece: a segment that turns about a free
joint, and the segments after it whose joints are fixed. The foreshortening multiplies the
lengths of a link's segments in the picture; it is below 1 where the link is raised.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pawnb.arrays import FloatArray, IntArray
from pawnb.core.pose.animal import Leg, StickAnimal
from pawnb.core.pose.fit.parameters import FITTING
from pawnb.core.pose.poses import Poses

N_BODY = 3
"""Layout: numbers of the pose vector before the legs: x, y, heading."""
_SHORTEST_SEGMENT = 1e-3
"""Guard: segments are no shorter, of their length or px, as their logarithm is taken."""


class PoseLayout(NamedTuple):
    """The animal in working pixels; the leg arrays are padded to the most links or segments.

    Attributes
    ----------
    side, attach, n_links, n_segments, first : ndarray
        Of each leg: 1 right or -1 left, the body-coxa joint (forward, right), its links, its
        segments, and where its numbers begin in the pose vector.
    link, turn, length : ndarray, shape (legs, segments)
        Of each segment: its link, its turn from the link's direction (radians, positive
        forwards), its length where it lies flat.
    radius, dark : ndarray, shape (legs, segments + 1)
        Half the thickness, and the darkness relative to the background, at the ends of segments.
    ellipse : ndarray, shape (parts, 7)
        Centre forward and right, half axes along and across, darkness of its rim, how much broader
        the part is in front of its middle than behind, as an egg is (its half width at the share a
        of its half length is the half axis across times 1 + egg * a), and darkness of its middle.
        Where parts in front and behind meet at the origin, the last row is the waist that joins
        them there.
    """

    side: np.ndarray
    attach: np.ndarray
    n_links: np.ndarray
    n_segments: np.ndarray
    first: np.ndarray
    link: np.ndarray
    turn: np.ndarray
    length: np.ndarray
    radius: np.ndarray
    dark: np.ndarray
    ellipse: np.ndarray


def make_layout(
    animal: StickAnimal, *, px_per_unit: float, dark: float | None = None, size: float = 1.0
) -> PoseLayout:
    """Return the animal as its species file has it.

    Parameters
    ----------
    animal : StickAnimal
        The animal.
    px_per_unit : float
        Working pixels per unit of the species file's lengths.
    dark : float
        Darkness relative to the background, of which legs keep a part at the tip; default the
        parameter ``dark``.
    size : float
        Factor of all thicknesses.

    Returns
    -------
    PoseLayout
        The arrays.
    """
    legs, dark = animal.legs, FITTING.dark if dark is None else dark
    most = max(len(leg.segments) for leg in legs)
    link, turn = np.zeros((len(legs), most), np.int64), np.zeros((len(legs), most))
    length, radius = np.zeros((len(legs), most)), np.zeros((len(legs), most + 1))
    for i, leg in enumerate(legs):
        n = len(leg.segments)
        link[i, :n], turn[i, :n] = links_of(leg)
        length[i, :n] = np.array(leg.lengths) * px_per_unit
        radius[i, : n + 1] = np.array(leg.widths) * (0.5 * size * px_per_unit)
    paler = np.ones((len(legs), most + 1))
    for i, leg in enumerate(legs):
        nodes = len(leg.segments) + 1
        paler[i, :nodes] = np.linspace(1.0, FITTING.tip_dark, nodes)
    n_links = np.array([int(links_of(leg)[0][-1]) + 1 for leg in legs])
    body = [(*part.centre, part.length / 2, part.width / 2) for part in animal.body]
    darkness = np.full(len(body), dark)
    ellipse = np.column_stack(
        [np.array(body) * px_per_unit, darkness, np.zeros(len(body)), darkness]
    )
    beside = ellipse[meeting(ellipse) != 0.0]
    if len(beside):
        half, across = (
            FITTING.waist_length * beside[:, 2].min(),
            FITTING.waist_width * beside[:, 3].min(),
        )
        ellipse = np.vstack([ellipse, [0.0, 0.0, half, across, dark, 0.0, dark]])
    return PoseLayout(
        side=np.array([leg.side for leg in legs], dtype=float),
        attach=np.array([leg.attach for leg in legs]) * px_per_unit,
        n_links=n_links,
        n_segments=np.array([len(leg.segments) for leg in legs]),
        first=N_BODY + 2 * np.concatenate([[0], np.cumsum(n_links)[:-1]]),
        link=link,
        turn=turn,
        length=length,
        radius=radius,
        dark=dark * paler,
        ellipse=ellipse,
    )


def meeting(ellipse: FloatArray) -> FloatArray:
    """Return which parts of the body meet at the origin: 1 in front of it, -1 behind, 0 if not.

    Parameters
    ----------
    ellipse : ndarray, shape (parts, 7)
        The parts as the species file has them.

    Returns
    -------
    ndarray, shape (parts,)
        All 0 where the parts that end at the origin are all on one side of it.
    """
    forward, right, half, across = ellipse.T[:4]
    ends_there = np.abs(np.abs(forward) - half) <= FITTING.layout_meets * half
    side = np.where(
        ends_there & (np.abs(right) <= FITTING.layout_meets * across), np.sign(forward), 0.0
    )
    return side if {-1.0, 1.0} <= set(side) else np.zeros(len(side))


def links_of(leg: Leg) -> tuple[IntArray, FloatArray]:
    """Return the link of each segment, and its turn from the link's direction in radians.

    A leg whose first joint is fixed has its first free joint counted from the natural
    orientation of those before, so the turns of its first link hold them.
    """
    link, turn = np.zeros(len(leg.segments), np.int64), np.zeros(len(leg.segments))
    current, fixed = -1, 0.0
    for j, free in enumerate(leg.free):
        if free:
            current += 1
        else:
            fixed += leg.natural_deg[j]
        link[j], turn[j] = max(current, 0), np.radians(fixed)
    return link, turn


def pose_vectors(animal: StickAnimal, poses: Poses, *, factor: int = 1) -> FloatArray:
    """Return poses as vectors in working pixels, shape (n, n_parameters).

    Parameters
    ----------
    animal : StickAnimal
        The animal.
    poses : Poses
        Its poses, px of the view.
    factor : int
        View pixels along each side of a working pixel.

    Returns
    -------
    ndarray
        Angles in radians; a link's foreshortening is that of its segments together.
    """
    parts = [(poses.xy - (factor - 1) / 2) / factor, np.radians(poses.heading_deg)[:, None]]
    joint = segment = 0
    flat = animal.lengths * poses.scale[:, None]
    for leg in animal.legs:
        link, _ = links_of(leg)
        n = int(link[-1]) + 1
        parts.append(np.radians(poses.angles_deg[:, joint : joint + n]))
        of_leg = slice(segment, segment + len(link))
        whole = np.stack([flat[:, of_leg][:, link == k].sum(axis=1) for k in range(n)], axis=1)
        seen = np.stack(
            [poses.lengths_px[:, of_leg][:, link == k].sum(axis=1) for k in range(n)], axis=1
        )
        parts.append(np.log(np.maximum(seen, _SHORTEST_SEGMENT * whole) / whole))
        joint, segment = joint + n, segment + len(link)
    return np.concatenate(parts, axis=1)


def leg_numbers(layout: PoseLayout, leg: int, joints: FloatArray, *, heading: float) -> FloatArray:
    """Return a leg's part of the pose vector that puts the ends of its links at places.

    Parameters
    ----------
    layout : PoseLayout
        The animal.
    leg : int
        Which leg.
    joints : ndarray, shape (segments + 1, 2)
        Places of its joints and tip, working px; those within a link only as far as it can bend.
    heading : float
        Of the body, radians.

    Returns
    -------
    ndarray, shape (2 links,)
        Angles, radians, and logarithms of foreshortening.
    """
    n = int(layout.n_segments[leg])
    link = layout.link[leg, :n]
    first = np.flatnonzero(np.diff(link, prepend=-1))
    steps = joints[np.append(first[1:], n)] - joints[first]
    flat = np.add.reduceat(layout.length[leg, :n] * np.exp(1j * layout.turn[leg, :n]), first)
    direction = np.arctan2(steps[:, 1], steps[:, 0])
    forwards = np.pi / 2 - layout.side[leg] * (direction - heading) - np.angle(flat)
    turns = (np.diff(forwards, prepend=0.0) + np.pi) % (2 * np.pi) - np.pi
    return np.concatenate(
        [turns, np.log(np.maximum(np.hypot(*steps.T), _SHORTEST_SEGMENT) / np.abs(flat))]
    )


def poses_of_vectors(
    animal: StickAnimal,
    vectors: FloatArray,
    *,
    frames: IntArray,
    scale: float,
    factor: int = 1,
) -> Poses:
    """Return pose vectors as poses: the inverse of :func:`pose_vectors`.

    Parameters
    ----------
    animal : StickAnimal
        The animal.
    vectors : ndarray, shape (n, n_parameters)
        Pose vectors in working pixels.
    frames : ndarray of int, shape (n,)
        Frame numbers.
    scale : float
        View pixels per unit of the species file's lengths.
    factor : int
        View pixels along each side of a working pixel.

    Returns
    -------
    Poses
        px of the view.
    """
    angles, lengths, at = [], [], N_BODY
    for leg in animal.legs:
        link, _ = links_of(leg)
        n = int(link[-1]) + 1
        angles.append(np.degrees(vectors[:, at : at + n]))
        shorter = np.exp(vectors[:, at + n : at + 2 * n])[:, link]
        lengths.append(shorter * np.array(leg.lengths) * scale)
        at += 2 * n
    return Poses(
        frames=np.asarray(frames),
        xy=vectors[:, :2] * factor + (factor - 1) / 2,
        heading_deg=np.degrees(vectors[:, 2]),
        scale=np.full(len(vectors), float(scale)),
        angles_deg=np.concatenate(angles, axis=1),
        lengths_px=np.concatenate(lengths, axis=1),
    )
