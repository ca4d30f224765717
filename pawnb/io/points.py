"""Tracks from the rows of a file: what every reader of points has in common."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from pawnb.arrays import AnyArray, FloatArray, IntArray
from pawnb.errors import InputError, InputWarning
from pawnb.input_warnings import warn_of_input
from pawnb.schema import (
    ORIGIN_CODE,
    Tracks,
    check_frames,
    every_frame,
    make_tracks,
    note_absent,
)

_NODE = re.compile(r"Node\(name=['\"](.+)['\"]\)")
_SAME_RATE = 1e-3
SLOWEST_FILM_HZ = 1.0
"""No gait is filmed at one frame a second: times so far apart count frames, or milliseconds."""


def build_tracks(
    frames: Sequence[int] | AnyArray,
    position: AnyArray,
    confidence: FloatArray | None = None,
    *,
    points: Sequence[str],
    fps: float,
    unit: str,
    program: str,
    where: str,
    individuals: Sequence[str] = ("animal",),
    views: Sequence[str] = (),
) -> Tracks:
    """Make Tracks of every frame from the rows of a file.

    Parameters
    ----------
    frames : sequence of int, shape (n_rows,)
        The frame of each row; they must rise.
    position : ndarray, shape (n_rows, [n_views,] n_points, n_individuals, 2 or 3)
        Positions; NaN where a point was not seen.
    confidence : ndarray, shape (n_rows, [n_views,] n_points, n_individuals), optional
        Confidence; without it, that of a point that was seen is NaN.
    points, individuals, views : sequence of str
        Names, each once. Without views, positions are ``position`` of the Tracks; with views
        they are image positions.
    fps : float
        Frames per second of the recording.
    unit : str
        Unit of positions that are not image positions.
    program : str
        Who made the file.
    where : str
        How messages name the file.

    Returns
    -------
    xarray.Dataset
        Tracks from the first frame to the last. Points of frames that have no row are missing,
        and the provenance says which frames those are.

    Raises
    ------
    InputError
        If frames do not rise, a name is there twice, a position is infinite, or there is no
        point.
    """
    for names, what in ((points, "point"), (individuals, "animal"), (views, "view")):
        check_names(names, what=what, where=where)
    if not points or not individuals:
        raise InputError(f"{where}: no point; expected the positions of one or more.")
    frames = check_frames(frames, where=where)
    check_finite(position, frames=frames, points=points, where=where)
    every = every_frame(frames)
    tracks = make_tracks(
        every,
        points,
        fps=fps,
        views=views,
        space=("x", "y") if position.shape[-1] == 2 and not views else ("x", "y", "z"),
        unit=unit,
        source_software=program,
    )
    if len(individuals) != 1:
        tracks = tracks.isel(individual=np.zeros(len(individuals), dtype=int)).copy(deep=True)
    tracks = tracks.assign_coords(individual=np.array(individuals, dtype=str))
    rows = np.searchsorted(every, frames)
    prefix = "image_" if views else ""
    known = np.asarray(np.isfinite(position).all(axis=-1))
    position = np.where(known[..., None], position, np.nan)
    if confidence is None:
        confidence = np.full(known.shape, np.nan)
    # the axis of x, y (u, v) comes before those of points and individuals
    tracks[f"{prefix}position"].to_numpy()[rows] = np.moveaxis(position, -1, -3)
    tracks[f"{prefix}confidence"].to_numpy()[rows] = np.where(known, confidence, 0.0)
    tracks[f"{prefix}origin"].to_numpy()[rows] = np.where(
        known, ORIGIN_CODE["measured"], ORIGIN_CODE["missing"]
    )
    return note_absent(tracks, frames, file=where)


def plain_name(name: str) -> str:
    """Return the name of a point without what some programs of SLEAP wrap around it.

    Parameters
    ----------
    name : str
        A name as it stands in a file, such as ``FR`` or ``Node(name='FR')``.

    Returns
    -------
    str
        The name alone.
    """
    wrapped = _NODE.fullmatch(name)
    return wrapped[1] if wrapped else name


def by_subject(labels: Sequence[str], place: FloatArray) -> tuple[list[str], list[str], FloatArray]:
    """Take markers called ``subject:marker``, as motion capture calls them, apart.

    Parameters
    ----------
    labels : sequence of str
        Names of the markers.
    place : ndarray, shape (n_rows, n_markers, n_axes)
        Their places.

    Returns
    -------
    list of str
        Points. Labels as they are, unless all name a subject but those that begin with ``*``,
        which nobody named.
    list of str
        Individuals: the subjects, or one of no name.
    ndarray, shape (n_rows, n_points, n_individuals, n_axes)
        Places, NaN for a marker that a subject does not have.
    """
    parts = [label.rpartition(":") for label in labels]
    named = [part for part in parts if not part[2].startswith("*")]
    if not named or not all(part[0] and part[2] for part in named):
        return list(labels), ["animal"], place[:, :, None]
    who = list(dict.fromkeys(part[0] for part in named))
    points = list(dict.fromkeys(part[2] for part in parts))
    found = np.full((len(place), len(points), len(who), place.shape[2]), np.nan)
    for k, (subject, _, point) in enumerate(parts):
        found[:, points.index(point), who.index(subject) if subject else 0] = place[:, k]
    return points, who, found


def check_names(names: Sequence[str], *, what: str, where: str) -> None:
    """Refuse names that are empty or there twice.

    Parameters
    ----------
    names : sequence of str
        Names of points, animals or views.
    what : str
        What they are names of.
    where : str
        How messages name the file.

    Raises
    ------
    InputError
        For the first such name.
    """
    seen: set[str] = set()
    for name in names:
        if not name.strip():
            raise InputError(f"{where}: a {what} has no name; give it one.")
        if name in seen:
            raise InputError(
                f"{where}: {what} {name!r} is there twice; keep one of them, or name them "
                "differently."
            )
        seen.add(name)


def check_finite(
    position: FloatArray, *, frames: IntArray, points: Sequence[str], where: str
) -> None:
    """Refuse infinite positions: they are no places, and no missing ones either.

    Parameters
    ----------
    position : ndarray, shape (n_rows, ..., n_points, n_individuals, n_axes)
        Positions; NaN is fine.
    frames : ndarray, shape (n_rows,)
        Frames of the rows.
    points : sequence of str
        Names of the points.
    where : str
        How the message names the file.

    Raises
    ------
    InputError
        For the first one.
    """
    infinite = np.isinf(position)
    if infinite.any():
        at = np.argwhere(infinite)[0]
        raise InputError(
            f"{where}: frame {frames[at[0]]}, point {points[at[-3]]!r} is at infinity; expected a "
            "number, or an empty cell where it was not seen."
        )


def tell_rate(
    where: str, said: float, fps: float | None, *, kept: bool = False, stacklevel: int
) -> None:
    """Warn where a file says another frame rate than is given.

    Parameters
    ----------
    where : str
        How the message names the file.
    said : float
        Frames per second that it says.
    fps : float, optional
        Those that are given.
    kept : bool
        Whether those of the file are used, as of one with times of its own; else the given ones.
    stacklevel : int
        How far up the caller is whom the warning is for.

    Warns
    -----
    InputWarning
        If they differ by more than a thousandth.
    """
    if fps is None or abs(fps - said) <= _SAME_RATE * said:
        return
    what = (
        f"which is used, and not the fps of {fps:g} that is given: correct it there where it is "
        "wrong."
        if kept
        else f"and fps is given as {fps:g}, which is used: all times and speeds follow from it; "
        "correct fps where the file is right."
    )
    warn_of_input(
        f"{where} says {said:g} frames per second, {what}", InputWarning, stacklevel=stacklevel + 1
    )
