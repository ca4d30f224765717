"""Tracks for the 2019 paper's authors: the four csv files of a trial. See ``authors2019.py``."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pawnb.errors import InputError
from pawnb.io.authors2019 import MARKERS, SIZE, VIEWS, point_names, split_name
from pawnb.io.outgoing import Outgoing, take_view, views_of, word
from pawnb.io.tables import write_text
from pawnb.schema import ORIGIN_CODE, Tracks
from pawnb.schema.arguments import checked_arguments

_UNKNOWN = (
    "Written by pawnb; how the markers were tracked is not known here",
    "Number of markers {n}",
    "SLIC parameters not known",
    "Window size not known",
    "Paths of the pictures not known",
)
"""The five lines of settings that come before the columns."""


@checked_arguments
def write_authors_trial(
    tracks: Tracks, path: str | Path, *, size: tuple[int, int] = SIZE
) -> list[Path]:
    """Write the four files of one trial.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks of one animal, with points in the views cam1 to cam4, called as
        :func:`pawnb.io.authors2019.read_authors_trial` calls them.
    path : str or Path
        One of the four, ``cam1.f.<animal>.<condition>.<stamp>.csv``: the others are written
        beside it.
    size : tuple of int
        Width and height of the pictures in px.

    Returns
    -------
    list of Path
        The files. Cameras 3 and 4 are mirrored as the authors do, and a missing point is an empty
        cell. Names of pictures and settings of their tracker are not known and left empty. Points
        that were predicted in views of the other side of the animal have no column there.

    Raises
    ------
    InputError
        If the name is not one of theirs, or the tracks hold what these files have no column for.

    Examples
    --------
    >>> trial = pawnb.schema.make_tracks(range(3), ["FL", "HR"], fps=250.0, views=["cam1", "cam3"])
    >>> trial["image_position"][:] = 100.0
    >>> trial["image_origin"][:, 0, 0] = trial["image_origin"][:, 1, 1] = 1  # measured
    >>> name = "cam1.f.rat2.Week0.2018-06-08_13_30_12.csv"
    >>> len(pawnb.io.write_authors_trial(trial, name))
    4
    """
    path = Path(path)
    trial = split_name(path.name)
    if trial is None:
        raise InputError(
            f"{path.name}: the 2019 authors name a file cam1.f.<animal>.<condition>.<stamp>.csv, "
            "the stamp as 2018-06-08_13_30_12; name OUT so: the other three are named alike."
        )
    views = {view: take_view(tracks, view) for view in views_of(tracks)}
    _check_fits(views, path.name)
    files = []
    for cam in (1, 3):
        for part in "fh":
            text = _file_text(views, cam, part, size[0])
            files.append(write_text(text, path.with_name(f"cam{cam}.{part}.{trial}.csv")))
    return files


def _check_fits(views: dict[str, Outgoing], where: str) -> None:
    """Refuse tracks with views, points or animals that have no column."""
    other = [view or "(no name)" for view in views if view not in VIEWS]
    if other or not views:
        raise InputError(
            f"{where}: the 2019 authors have views {', '.join(VIEWS)}, and these tracks "
            f"{', '.join(other) or 'no view'}; choose another format."
        )
    known = {cam: {n for part in "fh" for n in point_names(cam, part)} for cam in (1, 3)}
    for view, own in views.items():
        own.only_animal("a trial of the 2019 authors")
        nowhere = [point for point in own.points if point not in known[1] | known[3]]
        if nowhere:
            raise InputError(
                f"{where}: the 2019 authors have no marker {nowhere[0]!r}; they have the feet "
                "FL, HL, FR, HR and FL_Shoulder, FL_Elbow, HL_Asis, HL_Hip, HL_Knee, HL_Ankle, ..."
            )
        measured = own.tracks["image_origin"].transpose("time", "keypoint", "individual")
        seen = (measured.to_numpy()[:, :, 0] == ORIGIN_CODE["measured"]).any(axis=0)
        side = known[1 if view in VIEWS[:2] else 3]
        wrong = [p for p, s in zip(own.points, seen, strict=True) if s and p not in side]
        if wrong:
            raise InputError(
                f"{where}: {wrong[0]} was tracked in {view}, where the 2019 authors have the "
                f"{'left' if side is known[1] else 'right'} legs only; choose another format."
            )


def _file_text(views: dict[str, Outgoing], cam: int, part: str, width: int) -> str:
    """Return one file: five lines of settings, then a row for every frame."""
    frames = next(iter(views.values())).frames
    columns, values = [], []
    for letter, point in zip("MNOPQ", point_names(cam, part), strict=False):
        for number, second in ((cam, ""), (cam + 1, "2")):
            place = np.full((len(frames), 2), np.nan)
            own = views.get(f"cam{number}")
            if own is not None and point in own.points:
                place = own.place[:, own.points.index(point), 0].copy()
            if cam == 3:
                place[:, 0] = width - 1 - place[:, 0]
            columns += [f"{axis} Coordinate {letter}{second}" for axis in "YX"]
            values += [place[:, 1], place[:, 0]]
    head = [line.format(n=len(MARKERS[part])) for line in _UNKNOWN]
    names = ["Frames", "First Camera Frames Name", "Second Camera Frames Name", *columns]
    rows = [
        ",".join([str(frame), "", "", *(word(x) for x in row)])
        for frame, row in zip(frames, np.stack(values, axis=1), strict=True)
    ]
    return "\n".join([*head, ",".join(names), *rows]) + "\n"
