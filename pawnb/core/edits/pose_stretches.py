"""Corrections of a jointed animal over a stretch: legs exchanged, interpolated, taken away."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import PchipInterpolator

from pawnb.arrays import BoolArray
from pawnb.core.edits.copies import copy_tracks
from pawnb.core.edits.records import Delete, Hide, Interpolate, Swap
from pawnb.core.edits.stretches import EDITED, KNOTS_BESIDE, MISSING, PREDICTED, rows_of_edit
from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.as_tracks import BODY_POINT, animal_of, poses_of, tracks_from_poses
from pawnb.core.pose.poses import Poses, joint_positions, poses_from_joints
from pawnb.core.pose.track_result import plain_track
from pawnb.errors import InputError
from pawnb.schema import Tracks


def edit_legs(tracks: Tracks, edit: Swap | Interpolate | Hide | Delete) -> Tracks:
    """Return Tracks of a jointed animal with one or two legs corrected over a stretch.

    Exchanged legs change places: each has the joints and the tip of the other, from its own
    place on the body. Interpolated, the joints of a leg turn smoothly (PCHIP) from what is known
    at either side, through what was posed by hand within. Hidden or deleted, its joints and tip
    are missing.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks of one jointed animal; not modified.
    edit : Swap, Interpolate, Hide or Delete
        The correction; its points are legs.

    Returns
    -------
    xarray.Dataset
        New Tracks.

    Raises
    ------
    InputError
        If there is no such leg or frame, legs of different make are exchanged, the poses are in
        space, or nothing is known at a side.
    """
    new, animal = copy_tracks(tracks), animal_of(tracks)
    rows = rows_of_edit(new, edit)
    if isinstance(edit, Hide | Delete):
        hide_leg(new, rows, edit.point)
        return new
    if new.sizes["space"] == 3:
        raise InputError("poses in space are not exchanged or interpolated; track them again.")
    if isinstance(edit, Swap):
        _swap_legs(new, animal, rows, (edit.first, edit.second))
    else:
        _interpolate_leg(new, animal, rows, edit.point)
    return new


def hide_leg(tracks: Tracks, rows: slice, leg: str) -> None:
    """Take the joints and the tip of a leg away over some rows, in place.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks of one jointed animal.
    rows : slice
        Which rows.
    leg : str
        Which leg.
    """
    at = _points_of(tracks, leg)
    for prefix in ("", "image_"):
        tracks[f"{prefix}position"].values[rows][..., at, :] = np.nan
        tracks[f"{prefix}origin"].values[rows][..., at, :] = MISSING
        tracks[f"{prefix}confidence"].values[rows][..., at, :] = 0.0


def _points_of(tracks: Tracks, leg: str) -> BoolArray:
    """Return which points belong to a leg: its tip and its joints."""
    names = animal_of(tracks).leg_names
    if leg not in names:
        raise InputError(f"the animal has no leg {leg!r}; expected {', '.join(names)}.")
    points = [str(name) for name in tracks["keypoint"].to_numpy()]
    return np.array([p == leg or p.startswith(f"{leg}.") for p in points])


def _swap_legs(tracks: Tracks, animal: StickAnimal, rows: slice, legs: tuple[str, str]) -> None:
    """Exchange two legs over some rows, in place."""
    pair = [_leg_number(animal, leg) for leg in legs]
    if pair[0] == pair[1]:
        raise InputError(f"a leg cannot be exchanged with itself ({legs[0]!r}).")
    if len({len(animal.legs[i].segments) for i in pair}) > 1:
        raise InputError(f"{legs[0]} and {legs[1]} have different numbers of segments.")
    part = poses_of(tracks.isel(time=rows))
    places = joint_positions(animal, part.poses)
    places[:, pair, 1:] = places[:, pair[::-1], 1:]
    origin, confidence = part.origin.copy(), part.confidence.copy()
    origin[:, pair], confidence[:, pair] = origin[:, pair[::-1]], confidence[:, pair[::-1]]
    bent = _bent(animal, part.poses, places, pair)
    _put(tracks, animal, rows, bent, pair, origin=origin, confidence=confidence)


def _bent(animal: StickAnimal, poses: Poses, places: np.ndarray, legs: list[int]) -> Poses:
    """Return poses whose given legs have their joints at ``places``."""
    new = poses_from_joints(
        animal, places, frames=poses.frames, xy=poses.xy, heading_deg=poses.heading_deg,
        scale=poses.scale,
    )  # fmt: skip
    angles, lengths = poses.angles_deg.copy(), poses.lengths_px.copy()
    for i in legs:
        joints, segments = _columns(animal, i)
        angles[:, joints] = new.angles_deg[:, joints]
        lengths[:, segments] = new.lengths_px[:, segments]
    return Poses(frames=poses.frames, xy=poses.xy, heading_deg=poses.heading_deg,
                 scale=poses.scale, angles_deg=angles, lengths_px=lengths)  # fmt: skip


def _interpolate_leg(tracks: Tracks, animal: StickAnimal, rows: slice, leg: str) -> None:
    """Lead the joints of a leg smoothly over some rows, in place."""
    i = _leg_number(animal, leg)
    joints, segments = _columns(animal, i)
    whole = poses_of(tracks)
    poses, origin = whole.poses, whole.origin[:, i]
    values = np.column_stack([poses.angles_deg[:, joints], poses.lengths_px[:, segments]])
    known = np.isfinite(values).all(axis=1) & np.isfinite(poses.xy).all(axis=1)
    known &= origin != MISSING
    within = np.zeros(len(known), dtype=bool)
    within[rows] = True
    known &= ~within | (origin == EDITED)
    before = np.flatnonzero(known & (np.arange(len(known)) < rows.start))[-KNOTS_BESIDE:]
    after = np.flatnonzero(known & (np.arange(len(known)) >= rows.stop))[:KNOTS_BESIDE]
    knots = np.concatenate([before, np.flatnonzero(known & within), after])
    new = np.flatnonzero(within & ~known & np.isfinite(poses.xy).all(axis=1))
    new = new[(new > knots.min(initial=len(known))) & (new < knots.max(initial=-1))]
    if not len(new):
        first, last = (int(poses.frames[r]) for r in (rows.start, rows.stop - 1))
        raise InputError(
            f"{leg} is not known both before frame {first} and after frame {last}, so there is "
            "nothing to interpolate between; pose it in the first and last frame of the stretch."
        )
    n = int(np.sum(joints))
    at_knots = values[knots]
    at_knots[:, :n] = np.degrees(np.unwrap(np.radians(at_knots[:, :n]), axis=0))
    smooth = PchipInterpolator(poses.frames[knots], at_knots)(poses.frames[new])
    angles, lengths = poses.angles_deg.copy(), poses.lengths_px.copy()
    angles[np.ix_(new, joints)], lengths[np.ix_(new, segments)] = smooth[:, :n], smooth[:, n:]
    place = np.searchsorted(knots, new)
    confidence = np.minimum(
        whole.confidence[knots[place - 1], i], whole.confidence[knots[place], i]
    )
    made = Poses(frames=poses.frames, xy=poses.xy, heading_deg=poses.heading_deg,
                 scale=poses.scale, angles_deg=angles, lengths_px=lengths)  # fmt: skip
    codes = np.full((len(new), len(animal.legs)), PREDICTED, dtype=np.int8)
    sure = np.repeat(confidence[:, None], len(animal.legs), axis=1)
    _put(tracks, animal, new, made.take(new), [i], origin=codes, confidence=sure)


def _put(
    tracks: Tracks,
    animal: StickAnimal,
    rows: slice | np.ndarray,
    poses: Poses,
    legs: list[int],
    *,
    origin: np.ndarray,
    confidence: np.ndarray,
) -> None:
    """Write some legs of poses into rows of tracks; all else stays, to the last bit."""
    flat = tracks_from_poses(
        animal,
        plain_track(animal, poses, origin=origin, confidence=confidence),
        fps=float(tracks.attrs["fps"]),
        view=str(tracks["view"].to_numpy()[0]),
        individual=str(tracks["individual"].to_numpy()[0]),
        px_per_unit=tracks.attrs.get("px_per_unit"),
        unit=str(tracks.attrs["units"]),
    )
    for i in legs:
        at = _points_of(tracks, animal.leg_names[i])
        joints, segments = _columns(animal, i)
        which = {"keypoint": at, "joint": joints, "segment": segments}
        for name, variable in tracks.data_vars.items():
            dim = next((dim for dim in which if dim in variable.dims), None)
            if dim is None or "time" not in variable.dims:
                continue
            axes = [variable.dims.index("time"), variable.dims.index(dim)]
            values = np.moveaxis(variable.values, axes, [0, 1])
            # what the method told of its doubts does not describe what a person has made of it
            part: np.ndarray | float = np.nan
            if name in flat and not str(name).endswith("sd"):
                part = np.moveaxis(flat[name].values, axes, [0, 1])[:, which[dim]]
            index = np.arange(len(values))[rows]
            values[np.ix_(index, np.flatnonzero(which[dim]))] = part


def _columns(animal: StickAnimal, leg: int) -> tuple[BoolArray, BoolArray]:
    """Return which free joints and which segments are those of a leg."""
    name = f"{animal.legs[leg].name}_"
    joints, segments = (
        np.array([one.startswith(name) for one in names])
        for names in (animal.joints, animal.segments)
    )
    return joints, segments


def _leg_number(animal: StickAnimal, leg: str) -> int:
    """Return the number of a leg; raises InputError where there is none of that name."""
    if leg not in animal.leg_names:
        words = f" ({BODY_POINT} is moved frame by frame)" if leg == BODY_POINT else ""
        raise InputError(
            f"the animal has no leg {leg!r}; expected {', '.join(animal.leg_names)}{words}."
        )
    return list(animal.leg_names).index(leg)
