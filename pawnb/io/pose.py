"""Poses as csv: ``start_pose.csv`` to begin with, ``pose.csv`` as a run writes it.

Nothing is known here of animals: the names of legs, joints and segments are given. A joint
is ``<leg>_<joint>``, a segment ``<leg>_<segment>``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from pawnb.errors import InputError, did_you_mean
from pawnb.io.start_films import lines_of, read_films, write_films
from pawnb.io.tables import read_cells, read_numbers, write_table
from pawnb.schema import check_columns

POSE_COLUMNS = ("frame", "x", "y", "heading", "scale")
"""Columns that every table of poses has; those of the joints depend on the animal."""

_ANGLE_DECIMALS, _LENGTH_DECIMALS = 4, 4
_LENGTHS = ("_scale", "_px", "_sd")
"""How columns of proportions, projected lengths and standard deviations end."""


@dataclass(frozen=True, kw_only=True)
class PoseNames:
    """The names that the columns of poses may have.

    Parameters
    ----------
    legs : tuple of str
        Legs, such as ``L1``.
    joints : tuple of str
        Joints that turn, as ``<leg>_<joint>``.
    segments : tuple of str
        Segments, as ``<leg>_<segment>``.
    """

    legs: tuple[str, ...]
    joints: tuple[str, ...]
    segments: tuple[str, ...]

    @property
    def lengths(self) -> tuple[str, ...]:
        """Columns of projected lengths, px."""
        return tuple(f"{name}_px" for name in self.segments)

    @property
    def factors(self) -> tuple[str, ...]:
        """Columns of an animal's own proportions."""
        return tuple(f"{name}_scale" for name in (*self.legs, *self.segments))

    @property
    def sd(self) -> tuple[str, ...]:
        """Columns of standard deviations."""
        return tuple(f"{name}_sd" for name in ("x", "y", "heading", *self.joints))


def read_pose(path: str | Path, *, names: PoseNames, other_legs: bool = False) -> pd.DataFrame:
    """Read ``start_pose.csv`` or ``pose.csv``.

    Parameters
    ----------
    path : str or Path
        A csv with the columns frame, x, y (the origin of the body's frame, px), heading
        (degrees from +u towards +v) and scale (px per unit of the species file), and where
        known a column for each joint (degrees), ``<leg>_scale`` and ``<leg>_<segment>_scale``
        (factors of lengths; 0: the leg is missing), ``<leg>_<segment>_px`` and ``..._sd``.
    names : PoseNames
        The names that columns may have.
    other_legs : bool
        Whether columns of further legs are left out instead of refused: the file is of an
        animal with all its legs, and this one lacks some.

    Returns
    -------
    pandas.DataFrame
        The same columns as numbers, a row a frame, frames ascending; an empty cell is NaN.

    Raises
    ------
    InputError
        If the file is missing, a column is unknown or missing, a cell is no number, a frame is
        there twice or negative, scale is not above 0, or there is no row.
    """
    where = Path(path).name
    cells = read_cells(path, POSE_COLUMNS)
    known = (*POSE_COLUMNS, *names.joints, *names.factors, *names.lengths, *names.sd)
    if other_legs:
        cells = cells[[c for c in cells.columns if c in known or not _of_a_leg(c, names, known)]]
    for column in cells.columns:
        if column not in known:
            raise InputError(
                f"{where}: unknown column {column!r}{did_you_mean(str(column), known)}; expected "
                f"{', '.join(POSE_COLUMNS)} and joints such as {', '.join(names.joints[:3])}; a "
                "pose of another species does not fit: pose the animal anew, or name that species."
            )
    columns = {
        str(name): read_numbers(
            cells, str(name), where=where, whole=name == "frame", empty=name not in POSE_COLUMNS
        )
        for name in cells.columns
    }
    table = pd.DataFrame(columns).sort_values("frame", kind="stable", ignore_index=True)
    return check_pose(table, names=names, where=where)


def _of_a_leg(column: str, names: PoseNames, known: Sequence[str]) -> bool:
    """Tell whether some leg of the animal has a column that ends like this one."""
    _, _, ending = column.partition("_")
    return any(f"{leg}_{ending}" in known for leg in names.legs)


def check_pose(table: pd.DataFrame, *, names: PoseNames, where: str) -> pd.DataFrame:
    """Return a table of poses unchanged if it can be one.

    Parameters
    ----------
    table : pandas.DataFrame
        As :func:`read_pose` returns it.
    names : PoseNames
        The names that columns may have.
    where : str
        How messages name the table.

    Returns
    -------
    pandas.DataFrame
        The same table.

    Raises
    ------
    InputError
        As :func:`read_pose`.
    """
    check_columns(table, POSE_COLUMNS, where=where, cells=False)
    if table.empty:
        raise InputError(f"{where}: no rows; expected the pose of the animal in one frame or more.")
    frames = table["frame"].to_numpy()
    if frames.min() < 0:
        raise InputError(f"{where}: frame {frames.min()}; frames are counted from 0.")
    twice = table["frame"].duplicated()
    if twice.any():
        raise InputError(
            f"{where}: frame {table['frame'][twice].iloc[0]} is there twice; keep one of them."
        )
    numbers = table[[name for name in POSE_COLUMNS if name != "frame"]].to_numpy(dtype=float)
    if not np.isfinite(numbers).all():
        row = int(np.argmax(~np.isfinite(numbers).all(axis=1)))
        raise InputError(
            f"{where}: frame {frames[row]}: x, y, heading or scale is not a number; give all four."
        )
    positive = ["scale", *(name for name in names.lengths if name in table)]
    for name in positive:
        bad = table[name] <= 0
        if bad.any():
            raise InputError(
                f"{where}: frame {table['frame'][bad].iloc[0]}, {name} is "
                f"{table[name][bad].iloc[0]:g}; expected px above 0."
            )
    _check_factors(table, names, where)
    return table


def _check_factors(table: pd.DataFrame, names: PoseNames, where: str) -> None:
    """Refuse proportions that change from frame to frame or cannot be."""
    for name in names.factors:
        if name not in table:
            continue
        given = table[name].dropna().unique()
        if len(given) > 1:
            raise InputError(
                f"{where}: {name} is {given[0]:g} in one frame and {given[1]:g} in another; an "
                "animal keeps its proportions."
            )
        least = 0.0 if name.removesuffix("_scale") in names.legs else np.nextafter(0.0, 1.0)
        if len(given) and given[0] < least:
            raise InputError(
                f"{where}: {name} is {given[0]:g}; expected a factor above 0 (of a leg, 0 says "
                "that it is missing)."
            )


def proportions(table: pd.DataFrame, *, names: PoseNames) -> tuple[dict[str, float], list[str]]:
    """Return an animal's own proportions from a table of poses.

    Parameters
    ----------
    table : pandas.DataFrame
        As :func:`read_pose` returns it.
    names : PoseNames
        The names that columns may have.

    Returns
    -------
    factors : dict
        Leg or segment to the factor of its length.
    missing : list of str
        Legs that the animal has lost.
    """
    factors: dict[str, float] = {}
    for column in names.factors:
        given = table[column].dropna().to_list() if column in table else []
        if given:
            factors[column.removesuffix("_scale")] = float(given[0])
    missing = [leg for leg in names.legs if factors.get(leg) == 0.0]
    lost = tuple(f"{leg}_" for leg in missing)
    kept = {
        name: factor
        for name, factor in factors.items()
        if name not in missing and not name.startswith(lost)
    }
    return kept, missing


def films_of_poses(path: str | Path) -> dict[str, str]:
    """Return in which film each pose was made, as far as that is known.

    Parameters
    ----------
    path : str or Path
        ``start_pose.csv``. The films are in ``start_pose.films.json`` beside it, which the widget
        writes; of poses that others made or changed since it says nothing.

    Returns
    -------
    dict of str to str
        The line of a pose, without the animal's proportions, to the film's code
        (:func:`pawnb.core.video.doubts.exchanged_films.film_code`).
    """
    if not (known := read_films(path)):
        return {}
    try:
        return {line: known[line] for line in _pose_lines(path) if line in known}
    except InputError:  # the poses are read, and faults told, elsewhere
        return {}


def _pose_lines(path: str | Path) -> list[str]:
    """Return each pose of a file without lengths, which are of the animal and not of the frame."""
    cells = read_cells(path, POSE_COLUMNS)
    own = [name for name in cells if name in POSE_COLUMNS or not str(name).endswith(_LENGTHS)]
    return lines_of(cells[own])


def write_start_pose(
    table: pd.DataFrame,
    path: str | Path,
    *,
    factors: Mapping[str, float] | None = None,
    film: str = "",
    earlier_films: Mapping[str, str] | None = None,
) -> Path:
    """Write ``start_pose.csv``, whole or not at all.

    Parameters
    ----------
    table : pandas.DataFrame
        Columns frame, x, y, heading, scale and joints, a row a frame.
    path : str or Path
        The file.
    factors : mapping, optional
        Leg or segment to the factor of its length; 0 for a missing leg.
    film : str, optional
        Code of the film in which they were made; it goes into ``start_pose.films.json``.
    earlier_films : mapping of str to str, optional
        As :func:`films_of_poses` returned it: poses that are still as they were keep their film.

    Returns
    -------
    Path
        The file.
    """
    check_columns(table, POSE_COLUMNS, where="start pose")
    proportions = {f"{name}_scale": factor for name, factor in (factors or {}).items()}
    path = write_table(_rounded(table.assign(**proportions)), path)
    if film or earlier_films:
        write_films(path, [(x, (earlier_films or {}).get(x, film)) for x in _pose_lines(path)])
    return path


def write_pose(table: pd.DataFrame, path: str | Path, *, names: PoseNames) -> Path:
    """Write ``pose.csv`` in the order of the contract, whole or not at all.

    Parameters
    ----------
    table : pandas.DataFrame
        As :func:`read_pose` returns it; every joint and segment must be there.
    path : str or Path
        The file.
    names : PoseNames
        The names of legs, joints and segments.

    Returns
    -------
    Path
        The file.
    """
    order: Sequence[str] = ("frame", "x", "y", "heading", *names.joints, "scale", *names.lengths)
    check_columns(table, order, where="pose")
    extra = [name for name in names.sd if name in table]
    return write_table(_rounded(table[[*order, *extra]]), path)


def _rounded(table: pd.DataFrame) -> pd.DataFrame:
    """Round to what can be told: 0.0001 degree, 0.0001 px."""
    out = table.copy()
    for name in out.columns:
        if name in ("frame", "x", "y") or str(name).endswith("scale"):
            continue
        decimals = _LENGTH_DECIMALS if str(name).endswith("_px") else _ANGLE_DECIMALS
        out[name] = out[name].round(decimals) + 0.0
    return out
