"""Poses as tables, and back: what ``start_pose.csv`` and ``pose.csv`` hold."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd

from pawnb.arrays import FloatArray
from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.poses import Poses
from pawnb.core.pose.track_result import PoseTrack
from pawnb.io.pose import PoseNames, proportions, read_pose, write_start_pose


def pose_names(animal: StickAnimal) -> PoseNames:
    """Return the names that the columns of an animal's poses may have."""
    return PoseNames(legs=animal.leg_names, joints=animal.joints, segments=animal.segments)


def read_start_pose(path: str | Path, species: StickAnimal) -> tuple[StickAnimal, Poses]:
    """Read ``start_pose.csv``: the poses to start from, and the animal's own proportions.

    Parameters
    ----------
    path : str or Path
        The file; see :func:`pawnb.io.pose.read_pose`.
    species : StickAnimal
        The animal as its species file describes it.

    Returns
    -------
    animal : StickAnimal
        With the legs and proportions that the file gives.
    poses : Poses
        Its poses, a row of the file each.

    Raises
    ------
    InputError
        As :func:`pawnb.io.pose.read_pose`, and if every leg is missing.
    """
    return poses_from_table(read_pose(path, names=pose_names(species)), species)


def write_start(
    path: str | Path,
    animal: StickAnimal,
    poses: Poses,
    *,
    species: StickAnimal | None = None,
    film: str = "",
    earlier_films: Mapping[str, str] | None = None,
) -> Path:
    """Write poses to start from as ``start_pose.csv``.

    Parameters
    ----------
    path : str or Path
        The file.
    animal : StickAnimal
        The animal with its own proportions.
    poses : Poses
        Its poses. Segments that are not as long in the picture as in the animal (raised ones)
        have their lengths written as ``<leg>_<segment>_px``.
    species : StickAnimal, optional
        The animal as its species file describes it, where it differs.
    film, earlier_films
        As for :func:`pawnb.io.pose.write_start_pose`.

    Returns
    -------
    Path
        The file.
    """
    factors = {} if species is None else animal_factors(animal, species)
    flat = poses.scale[:, None] * animal.lengths
    raised = np.any(np.abs(poses.lengths_px - flat) > 1e-3 * flat, axis=0)
    table = _columns(animal, poses).assign(
        **{
            f"{name}_px": poses.lengths_px[:, k]
            for k, name in enumerate(animal.segments)
            if raised[k]
        }
    )
    return write_start_pose(table, path, factors=factors, film=film, earlier_films=earlier_films)


def poses_from_table(table: pd.DataFrame, species: StickAnimal) -> tuple[StickAnimal, Poses]:
    """Return the animal and the poses that a table describes.

    Parameters
    ----------
    table : pandas.DataFrame
        As :func:`pawnb.io.pose.read_pose` returns it. A joint that is left out is at its
        natural orientation, a segment without a length in px lies in the picture's plane.
    species : StickAnimal
        The animal as its species file describes it.

    Returns
    -------
    animal : StickAnimal
        With its own legs and proportions.
    poses : Poses
        Its poses.
    """
    factors, missing = proportions(table, names=pose_names(species))
    animal = (species.without(missing) if missing else species).resized(factors)
    scale = table["scale"].to_numpy(dtype=float)
    angles = _filled(table, animal.joints, np.tile(animal.natural_deg, (len(table), 1)))
    lengths = _filled(
        table, [f"{name}_px" for name in animal.segments], scale[:, None] * animal.lengths
    )
    return animal, Poses(
        frames=table["frame"].to_numpy(dtype=np.int64),
        xy=table[["x", "y"]].to_numpy(dtype=float),
        heading_deg=table["heading"].to_numpy(dtype=float),
        scale=scale,
        angles_deg=angles,
        lengths_px=lengths,
    )


def pose_table(animal: StickAnimal, track: PoseTrack) -> pd.DataFrame:
    """Return a track as the table that ``pose.csv`` holds.

    Parameters
    ----------
    animal : StickAnimal
        The animal.
    track : PoseTrack
        Its poses.

    Returns
    -------
    pandas.DataFrame
        frame, x, y, heading, the joints, scale, ``<leg>_<segment>_px``, and where the method
        tells them ``x_sd``, ``y_sd``, ``heading_sd``, ``<leg>_<joint>_sd``.
    """
    poses, names = track.poses, pose_names(animal)
    table = _columns(animal, poses)
    table = table[["frame", "x", "y", "heading", *animal.joints, "scale"]]
    lengths = pd.DataFrame(poses.lengths_px, columns=list(names.lengths))
    parts = [table, lengths]
    sd = np.column_stack([track.xy_sd_px, track.heading_sd_deg, track.angles_sd_deg])
    if np.isfinite(sd).any():
        parts.append(pd.DataFrame(sd, columns=list(names.sd)))
    return pd.concat(parts, axis=1)


def animal_factors(animal: StickAnimal, species: StickAnimal) -> dict[str, float]:
    """Return what makes an animal of its species: factors of legs and segments, 0 if missing.

    Parameters
    ----------
    animal : StickAnimal
        The animal.
    species : StickAnimal
        Its species; :meth:`StickAnimal.resized` and :meth:`StickAnimal.without` gave the animal.

    Returns
    -------
    dict
        Leg to factor where all its segments have one, else segment to factor; those of 1 are
        left out.
    """
    factors: dict[str, float] = {}
    for leg in species.legs:
        if leg.name not in animal.leg_names:
            factors[leg.name] = 0.0
            continue
        ratio = np.divide(animal.leg(leg.name).lengths, leg.lengths)
        if np.allclose(ratio, 1.0, rtol=0, atol=1e-9):
            continue
        if np.ptp(ratio) < 1e-9:
            factors[leg.name] = round(float(ratio[0]), 9)
        else:
            factors |= {
                f"{leg.name}_{segment}": round(float(value), 9)
                for segment, value in zip(leg.segments, ratio, strict=True)
                if abs(value - 1.0) > 1e-9
            }
    return factors


def _columns(animal: StickAnimal, poses: Poses) -> pd.DataFrame:
    """Return frame, x, y, heading, scale and the joints as columns."""
    head = pd.DataFrame(
        {
            "frame": poses.frames,
            "x": poses.xy[:, 0],
            "y": poses.xy[:, 1],
            "heading": poses.heading_deg,
            "scale": poses.scale,
        }
    )
    return pd.concat([head, pd.DataFrame(poses.angles_deg, columns=list(animal.joints))], axis=1)


def _filled(
    table: pd.DataFrame, columns: list[str] | tuple[str, ...], usual: FloatArray
) -> FloatArray:
    """Return columns as (n, k), with ``usual`` where they are absent or empty."""
    given = table.reindex(columns=list(columns)).to_numpy(dtype=float)
    return np.where(np.isfinite(given), given, usual)
