"""How far joints move, and which share of what they could (paper 2009, §4.2.5, §5.5)."""

from __future__ import annotations

import re
from collections.abc import Iterable

import numpy as np
import pandas as pd

from pawnb.arrays import FloatArray
from pawnb.errors import InputError
from pawnb.gait.legs import find_leg_place, sort_legs
from pawnb.gait.locomotion.seen_part import seen_part
from pawnb.schema import Tracks, check_columns
from pawnb.schema.arguments import checked_arguments
from pawnb.signals import find_runs, smooth_spline
from pawnb.signals.splines import LEAST_SAMPLES

ANGLE_COLUMNS = ("animal", "trial", "leg", "joint", "angle_deg")
EXTREME_COLUMNS = (
    "animal", "trial", "leg", "pair", "joint", "n_frames", "max_deg", "min_deg", "range_deg",
)  # fmt: skip
RANGE_COLUMNS = (
    "joint", "pair", "n_animals", "max_mean_deg", "max_sd_deg", "min_mean_deg", "min_sd_deg",
    "range_mean_deg", "range_sd_deg", "mechanical_deg", "share_percent",
    "mechanical_low_deg", "mechanical_high_deg",
)  # fmt: skip
JOINTS = ("BC", "CT", "TF", "FP", "PT", "TM", "MT")
"""Joints of a spider's leg from the body outwards, in the names of ``pose.csv``."""
_NOT_ANGLES = ("_sd", "_px", "_scale")


@checked_arguments
def get_joint_angles(
    pose: Tracks | pd.DataFrame,
    *,
    animal: str | None = None,
    trial: str = "trial",
    smooth: bool = False,
) -> pd.DataFrame:
    """Take the joint angles out of Tracks, or out of the table of ``pose.csv``.

    Parameters
    ----------
    pose : xarray.Dataset or pandas.DataFrame
        Tracks with ``joint_angle`` (joints named ``<leg>_<joint>``), or a table with a column
        for each, in degrees.
    animal : str, optional
        Name of the animal; default that of the Tracks. A table needs one. Of Tracks with
        several animals, the one to take; default all.
    trial : str
        Name of the trial.
    smooth : bool
        Smooth every joint over time first (:func:`pawnb.signals.smooth_spline`, the cut-off
        chosen for each by generalised cross-validation). Extremes are the frames with the
        worst errors: of angles as they are tracked every range comes out too wide, the more
        so the longer one looks. Stretches of fewer than five frames are left out then.

    Returns
    -------
    pandas.DataFrame
        ``ANGLE_COLUMNS``, a row for each frame and joint that has an angle.

    Raises
    ------
    InputError
        If there is no joint angle, or no name for the animal of a table.
    """
    if isinstance(pose, pd.DataFrame):
        if animal is None:
            raise InputError("joint angles: give the animal, for pose.csv does not name it.")
        tables = {animal: pose}
    else:
        if "joint_angle" not in pose:
            raise InputError(
                "joint angles: these tracks have no joint_angle; expected those of a jointed "
                "animal (kind 'pose')."
            )
        tables = {
            str(name): _angle_table(pose.sel(individual=[name]))
            for name in pose["individual"].to_numpy()
            if animal is None or str(name) == animal
        }
    parts = []
    for name, table in tables.items():
        for column in table.columns:
            found = re.fullmatch(r"(?P<leg>.+)_(?P<joint>[^_]+)", str(column))
            if found is None or str(column).endswith(_NOT_ANGLES):
                continue
            angles = _angles_of(table, column, smooth=smooth)
            place = {"animal": name, "trial": trial, **found.groupdict()}
            parts.append(pd.DataFrame({**place, "angle_deg": angles}, index=range(len(angles))))
    if not any(len(part) for part in parts):
        raise InputError(
            "joint angles: none found; expected columns or joints named <leg>_<joint>, such as "
            "L1_BC."
        )
    return pd.concat(parts, ignore_index=True)[list(ANGLE_COLUMNS)]


def _angle_table(pose: Tracks) -> pd.DataFrame:
    """Return the angles of one animal, a column a joint, where it is seen."""
    seen, _ = seen_part(pose)
    values = seen["joint_angle"].isel(individual=0).transpose("time", "joint")
    return pd.DataFrame(values.to_numpy(), columns=seen["joint"].to_numpy())


def _angles_of(table: pd.DataFrame, column: str, *, smooth: bool) -> FloatArray:
    """Return the angles of one joint in the frames that have one."""
    angles = pd.to_numeric(table[column])
    if smooth:
        if "frame" in table:  # a table has no rows for frames without a pose
            angles = angles.set_axis(table["frame"].astype(int))
            angles = angles.reindex(range(angles.index.min(), angles.index.max() + 1))
        values = angles.to_numpy(dtype=float)
        known = find_runs(np.isfinite(values))
        # five samples are the least of a spline
        if any(stop - start >= LEAST_SAMPLES for start, stop in known):
            # the spline is the same in any unit of time
            angles = pd.Series(smooth_spline(values, fs_hz=1.0))
    return angles.dropna().to_numpy(dtype=float)


@checked_arguments
def joint_extremes(angles: pd.DataFrame, *, trim: float = 0.0) -> pd.DataFrame:
    """Find the greatest and least angle of every joint in every trial.

    Parameters
    ----------
    angles : pandas.DataFrame
        ``ANGLE_COLUMNS``, from :func:`get_joint_angles`; several animals and trials can be
        joined with ``pandas.concat``.
    trim : float
        Share of the frames left out at each end. 0 takes the extremes themselves, as the
        paper does: then a single wrong frame decides. 0.01 leaves the outermost hundredth out.

    Returns
    -------
    pandas.DataFrame
        ``EXTREME_COLUMNS``. ``pair`` is the leg's place from the front, or the leg's name
        where the name says none.

    Raises
    ------
    InputError
        If a column is missing, there is no angle, or ``trim`` is not from 0 to below 0.5.
    """
    check_columns(angles, ANGLE_COLUMNS, where="joint angles")
    if len(angles) == 0 or not 0.0 <= trim < 0.5:
        raise InputError(
            f"joint angles: {len(angles)} angles, trim {trim}; expected at least one angle, and "
            "trim from 0 to below 0.5."
        )
    groups = angles.groupby(["animal", "trial", "leg", "joint"], sort=True)["angle_deg"]
    table = pd.DataFrame(
        {
            "n_frames": groups.size(),
            "max_deg": groups.quantile(1.0 - trim),
            "min_deg": groups.quantile(trim),
        }
    ).reset_index()
    table["range_deg"] = table["max_deg"] - table["min_deg"]
    table["pair"] = [_pair(leg) for leg in table["leg"]]
    return table[list(EXTREME_COLUMNS)]


@checked_arguments
def joint_range_table(
    angles: pd.DataFrame, *, mechanical: pd.DataFrame | None = None, trim: float = 0.0
) -> pd.DataFrame:
    """Average the joints' extremes over animals (paper 2009, Tables 4.6 and 5.1).

    The extremes of an animal are means over its trials and over both legs of a pair; mean and
    standard deviation are then over animals, each of which counts once.

    Parameters
    ----------
    angles : pandas.DataFrame
        ``ANGLE_COLUMNS``.
    mechanical : pandas.DataFrame, optional
        The whole range that each joint could move: ``joint``, ``leg`` (or ``pair``),
        ``range_deg``, and optionally ``natural_deg``, the angle in the middle of it. Of both
        legs of a pair, the mean is taken.
    trim : float
        See :func:`joint_extremes`.

    Returns
    -------
    pandas.DataFrame
        ``RANGE_COLUMNS``: joints from the body outwards, pairs from the front. Standard
        deviations are NaN with one animal; ``share_percent`` is the mean range of the
        mechanical one, NaN where that is not known or 0. It can pass 100: mechanical limits
        are measured on other animals, and tracking errors widen a range.

    Raises
    ------
    InputError
        If a column is missing, there is no angle, or a mechanical range is negative.
    """
    extremes = joint_extremes(angles, trim=trim)
    names = ["max_deg", "min_deg", "range_deg"]
    animals = extremes.groupby(["joint", "pair", "animal"], sort=True)[names].mean()
    groups = animals.groupby(["joint", "pair"], sort=True)
    table = pd.DataFrame({"n_animals": groups.size()})
    for name in names:
        short = name.removesuffix("_deg")
        table[f"{short}_mean_deg"] = groups[name].mean()
        table[f"{short}_sd_deg"] = groups[name].std(ddof=1)
    table = table.reset_index()
    known = _mechanical_ranges(mechanical)
    keys = list(zip(table["joint"], table["pair"], strict=True))
    whole = np.array([known.get(key, (np.nan, np.nan)) for key in keys])
    table["mechanical_deg"] = whole[:, 0]
    table["mechanical_low_deg"] = whole[:, 1] - whole[:, 0] / 2.0
    table["mechanical_high_deg"] = whole[:, 1] + whole[:, 0] / 2.0
    possible = table["mechanical_deg"].where(table["mechanical_deg"] > 0.0)
    table["share_percent"] = 100.0 * table["range_mean_deg"] / possible
    order = {name: k for k, name in enumerate([*JOINTS, *_others(table["joint"])])}
    pairs = {name: k for k, name in enumerate(_sort_pairs(table["pair"]))}
    table = table.iloc[np.lexsort((table["pair"].map(pairs), table["joint"].map(order)))]
    return table[list(RANGE_COLUMNS)].reset_index(drop=True)


def _mechanical_ranges(
    mechanical: pd.DataFrame | None,
) -> dict[tuple[str, str], tuple[float, float]]:
    """Return the mechanical range, and the angle in its middle, by joint and pair of legs."""
    if mechanical is None:
        return {}
    if "pair" in mechanical:
        table = mechanical.assign(pair=mechanical["pair"].astype(str))
    else:
        check_columns(mechanical, ("joint", "leg", "range_deg"), where="mechanical ranges")
        table = mechanical.assign(pair=[_pair(str(leg)) for leg in mechanical["leg"]])
    check_columns(table, ("joint", "range_deg"), where="mechanical ranges")
    if not (table["range_deg"] >= 0.0).all():
        raise InputError("mechanical ranges: a range is negative or missing; expected degrees.")
    if "natural_deg" not in table:
        table = table.assign(natural_deg=np.nan)
    means = table.groupby(["joint", "pair"])[["range_deg", "natural_deg"]].mean().reset_index()
    keys = zip(means["joint"].astype(str), means["pair"], strict=True)
    values = zip(means["range_deg"].astype(float), means["natural_deg"].astype(float), strict=True)
    return dict(zip(keys, values, strict=True))


def _pair(leg: str) -> str:
    """Return the place of a leg from the front, or its name."""
    place = find_leg_place(leg)
    return leg if place is None else str(place.rank)


def _others(joints: Iterable[str]) -> list[str]:
    """Return names of joints that are not a spider's, in alphabetical order."""
    return sorted(set(joints) - set(JOINTS))


def _sort_pairs(pairs: Iterable[str]) -> list[str]:
    """Return pairs by number, then names."""
    numbers = sorted((p for p in set(pairs) if p.isdigit()), key=int)
    return [*numbers, *sort_legs(p for p in pairs if not p.isdigit())]
