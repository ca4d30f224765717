"""Poses over frames, and where they put every joint in the picture."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from pawnb.arrays import AnyArray, FloatArray, IntArray
from pawnb.core.pose.animal import StickAnimal
from pawnb.errors import InputError


@dataclass(frozen=True, kw_only=True)
class Poses:
    """The pose of one animal in n frames.

    Parameters
    ----------
    frames : ndarray of int, shape (n,)
        Frame numbers.
    xy : ndarray, shape (n, 2)
        The cephalothorax-abdomen joint, px of the view.
    heading_deg : ndarray, shape (n,)
        Direction of the body, degrees from +u towards +v.
    scale : ndarray, shape (n,)
        View pixels per unit of the species file's lengths.
    angles_deg : ndarray, shape (n, n_joints)
        Free joints in the order of :attr:`StickAnimal.joints`: the first of a leg from the
        perpendicular to the body's axis, the others from the segment before, positive forwards
        on both sides.
    lengths_px : ndarray, shape (n, n_segments)
        Projected lengths of the segments in the order of :attr:`StickAnimal.segments`; a
        segment that is raised is shorter than ``scale`` times its length.
    """

    frames: IntArray
    xy: FloatArray
    heading_deg: FloatArray
    scale: FloatArray
    angles_deg: FloatArray
    lengths_px: FloatArray

    def __len__(self) -> int:
        return len(self.frames)

    def take(self, which: AnyArray | slice | list[int]) -> Poses:
        """Return some of the frames: an index array, a mask or a slice."""
        return Poses(**{f.name: getattr(self, f.name)[which] for f in dataclasses.fields(self)})

    def at_frame(self, frame: int) -> Poses:
        """Return the pose of one frame (length 1, or 0 where there is none)."""
        return self.take(self.frames == frame)


def start_within(start: Poses, frames: tuple[int, int]) -> Poses:
    """Return the start poses within a range of frames, frames ascending.

    Parameters
    ----------
    start : Poses
        Poses to start from.
    frames : tuple of int
        First frame and one past the last.

    Returns
    -------
    Poses
        One frame or more.

    Raises
    ------
    InputError
        If none lies within.
    """
    inside = np.flatnonzero((start.frames >= frames[0]) & (start.frames < frames[1]))
    if not len(inside):
        raise InputError(
            f"the start pose is of frame {', '.join(map(str, start.frames))}, but frames "
            f"{frames[0]} to {frames[1] - 1} are tracked; give a start pose within them."
        )
    return start.take(inside[np.argsort(start.frames[inside])])


def join_poses(parts: list[Poses]) -> Poses:
    """Return poses of several stretches in one, in the order given."""
    names = [f.name for f in dataclasses.fields(Poses)]
    return Poses(**{n: np.concatenate([getattr(p, n) for p in parts]) for n in names})


def natural_pose(
    animal: StickAnimal,
    *,
    frame: int = 0,
    xy: tuple[float, float] = (0.0, 0.0),
    heading_deg: float = 0.0,
    scale: float = 1.0,
) -> Poses:
    """Return a pose with every joint at its natural orientation.

    Parameters
    ----------
    animal : StickAnimal
        The animal.
    frame : int
        Frame number.
    xy : tuple of float
        The cephalothorax-abdomen joint, px.
    heading_deg : float
        Direction of the body, degrees from +u towards +v.
    scale : float
        px per unit of the species file's lengths.

    Returns
    -------
    Poses
        One frame.
    """
    return Poses(
        frames=np.array([frame]),
        xy=np.array([xy], dtype=float),
        heading_deg=np.array([heading_deg], dtype=float),
        scale=np.array([scale], dtype=float),
        angles_deg=animal.natural_deg[None],
        lengths_px=scale * animal.lengths[None],
    )


def segment_directions(animal: StickAnimal, poses: Poses) -> FloatArray:
    """Return the direction of every segment, degrees from +u towards +v.

    Parameters
    ----------
    animal : StickAnimal
        The animal.
    poses : Poses
        Its poses.

    Returns
    -------
    ndarray, shape (n, n_segments)
        Directions, not wrapped.
    """
    directions, first = [], 0
    for leg in animal.legs:
        angles = np.tile(leg.natural_deg, (len(poses), 1))
        free = np.array(leg.free)
        angles[:, free] = poses.angles_deg[:, first : first + free.sum()]
        first += int(free.sum())
        forwards = np.cumsum(angles, axis=1)
        # a leg straight out to the right points a quarter turn clockwise from the heading;
        # turning forwards is anticlockwise there, and clockwise on the left
        directions.append(poses.heading_deg[:, None] + leg.side * (90.0 - forwards))
    return np.concatenate(directions, axis=1)


def joint_positions(animal: StickAnimal, poses: Poses) -> FloatArray:
    """Return where the joints and tips are in the picture.

    Parameters
    ----------
    animal : StickAnimal
        The animal.
    poses : Poses
        Its poses.

    Returns
    -------
    ndarray, shape (n, n_legs, most segments + 1, 2)
        u, v in px: the body-coxa joint, the joints outwards, the tip. NaN beyond the tip of a
        leg with fewer segments than the longest.
    """
    most = max(len(leg.segments) for leg in animal.legs)
    out = np.full((len(poses), len(animal.legs), most + 1, 2), np.nan)
    turn = np.radians(poses.heading_deg)
    cos, sin = np.cos(turn), np.sin(turn)
    angle = np.radians(segment_directions(animal, poses))
    steps = poses.lengths_px[..., None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    first = 0
    for i, leg in enumerate(animal.legs):
        n = len(leg.segments)
        x, y = leg.attach
        root = np.stack([x * cos - y * sin, x * sin + y * cos], axis=-1)
        out[:, i, 0] = poses.xy + poses.scale[:, None] * root
        out[:, i, 1 : n + 1] = out[:, i, :1] + np.cumsum(steps[:, first : first + n], axis=1)
        first += n
    return out


def tip_positions(animal: StickAnimal, poses: Poses) -> FloatArray:
    """Return the tips of the legs, shape (n, n_legs, 2), px."""
    places = joint_positions(animal, poses)
    last = [len(leg.segments) for leg in animal.legs]
    return places[:, np.arange(len(animal.legs)), last]


def poses_from_joints(
    animal: StickAnimal,
    places: FloatArray,
    *,
    frames: IntArray,
    xy: FloatArray,
    heading_deg: FloatArray,
    scale: FloatArray,
) -> Poses:
    """Return the poses whose joints lie at ``places``: the inverse of :func:`joint_positions`.

    Parameters
    ----------
    animal : StickAnimal
        The animal.
    places : ndarray, shape (n, n_legs, most segments + 1, 2)
        Joints and tips as :func:`joint_positions` gives them, px. Of the body-coxa joints only
        the segment that starts there is used.
    frames, xy, heading_deg, scale : ndarray
        Frame numbers, place, heading and scale, as in :class:`Poses`.

    Returns
    -------
    Poses
        Angles in [-180, 180); a joint that is not free gives its turn to the next free joint
        outwards, or where there is none, loses it.
    """
    angles, lengths = [], []
    for i, leg in enumerate(animal.legs):
        n = len(leg.segments)
        steps = np.diff(places[:, i, : n + 1], axis=1)
        lengths.append(np.hypot(steps[..., 0], steps[..., 1]))
        direction = np.degrees(np.arctan2(steps[..., 1], steps[..., 0]))
        forwards = 90.0 - leg.side * (direction - heading_deg[:, None])
        total = np.zeros(len(places))
        for j in range(n):
            if leg.free[j]:
                turn = (forwards[:, j] - total + 180.0) % 360.0 - 180.0
                angles.append(turn)
                total = total + turn
            else:
                total = total + leg.natural_deg[j]
    return Poses(
        frames=np.asarray(frames),
        xy=np.asarray(xy, dtype=float),
        heading_deg=np.asarray(heading_deg, dtype=float),
        scale=np.asarray(scale, dtype=float),
        angles_deg=np.stack(angles, axis=1),
        lengths_px=np.concatenate(lengths, axis=1),
    )


def leg_angles(animal: StickAnimal, poses: Poses) -> FloatArray:
    """Return the total angle of each leg (Pullar 2009, §3.6).

    Parameters
    ----------
    animal : StickAnimal
        The animal.
    poses : Poses
        Its poses.

    Returns
    -------
    ndarray, shape (n, n_legs)
        Angle between the line from the body-coxa joint to the tip and the perpendicular to the
        body's axis, degrees, positive forwards: that of tarsus, body-coxa joint and the
        contralateral body-coxa joint, 0 where the leg is perpendicular to the body.
    """
    places = joint_positions(animal, poses)
    reach = tip_positions(animal, poses) - places[:, :, 0]
    side = np.array([leg.side for leg in animal.legs])
    direction = np.degrees(np.arctan2(reach[..., 1], reach[..., 0]))
    angle = 90.0 - side * (direction - poses.heading_deg[:, None])
    return (angle + 180.0) % 360.0 - 180.0
