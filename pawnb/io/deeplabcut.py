"""Tracks of DeepLabCut, and of Lightning Pose and its smoother, which write the same tables."""

from __future__ import annotations

import csv
import io
import itertools
import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pandas as pd

from pawnb.arrays import FloatArray
from pawnb.errors import InputError
from pawnb.io.hdf5 import is_hdf5, open_hdf5
from pawnb.io.pandas_hdf5 import Column, read_pandas_frame
from pawnb.io.points import build_tracks
from pawnb.io.tables import read_table_text
from pawnb.schema import Tracks
from pawnb.schema.arguments import checked_arguments

GROUP = "df_with_missing"
"""Where DeepLabCut puts its table in an h5 file."""

DEEPLABCUT = "DeepLabCut"
"""What tracks are said to be of, unless another program's scorer is named."""

SCORER = "scorer"
"""Attribute of Tracks that keeps who scored or predicted the points."""

LABELS_GROUP = "keypoints"
"""Where newer programs put labels."""

PICTURES = "labelled_pictures"
"""Attribute of Tracks that keeps how labelled pictures are called: ``.../img%04d.png``."""

POINTS_OF = "points_of_individuals"
"""Attribute of Tracks that keeps, as JSON, which points each animal has where not all have all:
those that are there once (DeepLabCut's unique bodyparts) are of an animal ``single``."""

ONE = "individual_0"
"""The animal of a file that names none."""

SMOOTHER = "ensemble-kalman_tracker"
"""The scorer of what the Ensemble Kalman Smoother (EKS) of Lightning Pose's authors writes."""

_LIGHTNING_POSE = re.compile(r"(heatmap|regression)\w*_tracker")
"""Scorers of Lightning Pose: kinds of its models."""
_OF_SMOOTHER = re.compile(r"[xyz]_(ens_median|ens_var|posterior_var|var)|zscore|nll")
"""What EKS writes beside the smoothed positions: its releases differ."""
_LEVELS = (("scorer", "bodyparts", "coords"), ("scorer", "individuals", "bodyparts", "coords"))
_EXPECTED = "a csv or h5 as DeepLabCut writes it"
_FRAMES = "numbers of frames, as in the file of predictions for a video"
_NUMBER = re.compile(r"(\d+)(?=\D*$)")


@checked_arguments
def read_deeplabcut(path: str | Path, *, fps: float, unit: str = "mm") -> Tracks:
    """Read tracks of DeepLabCut, or of Lightning Pose and its Ensemble Kalman Smoother.

    Parameters
    ----------
    path : str or Path
        The csv (header lines scorer, individuals for several animals, bodyparts, coords) or
        the h5 of the same video. The first column (the index) is the number of the frame. Of
        what the smoother writes, the smoothed positions are taken; medians and variances of
        its networks are left out.
    fps : float
        Frames per second of the recording; the file does not say.
    unit : str
        Unit of length of points in space (coords x, y, z).

    Returns
    -------
    xarray.Dataset
        Tracks in px, confidence is the file's likelihood (unknown where the smoother gave 0 to
        every point, as some of its releases do). Pixels are taken as they are. An animal that
        DeepLabCut 3 filled up, with -1 or 0 for x, y and likelihood, is missing.
        Frames without a row are missing, and the provenance says which they are.

    Raises
    ------
    InputError
        If the file is missing, damaged or not of DeepLabCut, a cell is no number, a point is
        there twice, or frames do not rise.

    Notes
    -----
    Attributes of the h5 are pickles. They are never unpickled: see
    :mod:`pawnb.io.pickled_values`.

    Examples
    --------
    >>> tracks = pawnb.io.read_deeplabcut("sample/m01DLC.csv", fps=200.0)
    >>> tracks.attrs["source_software"]
    'DeepLabCut'
    """
    path = Path(path)
    frames, columns, values = (_read_h5 if is_hdf5(path) else _read_csv)(path)
    tracks = _build(path.name, frames, columns, values, fps=fps, unit=unit)
    return tracks.assign_attrs({SCORER: columns[0][0]})


@checked_arguments
def read_collected(path: str | Path, *, fps: float) -> Tracks:
    """Read labels for training: DeepLabCut's ``CollectedData_<scorer>``, or Lightning Pose's.

    Parameters
    ----------
    path : str or Path
        The csv or h5, whose rows are named by pictures such as
        ``labeled-data/clip/img0012.png``; the last number in the name is that of the frame.
    fps : float
        Frames per second of the recording.

    Returns
    -------
    xarray.Dataset
        Tracks in px without confidence (a person put the points); frames that nobody labelled
        are missing. How pictures are called is kept in the attribute ``labelled_pictures``.

    Raises
    ------
    InputError
        If the file is of another kind, a picture has no number, or two have the same, as
        pictures of several videos do.

    Examples
    --------
    >>> few = tracks.isel(time=[0, 10])
    >>> path = pawnb.io.write_collected(few, "CollectedData_me.csv")
    >>> labels = pawnb.io.read_collected(path, fps=200.0)
    >>> labels["keypoint"].equals(tracks["keypoint"])
    True
    """
    path = Path(path)
    rows, columns, values = (_read_h5 if is_hdf5(path) else _read_csv)(path, labels=True)
    names = ["/".join(row) for row in rows]
    found = [_NUMBER.search(name) for name in names]
    folders = {name.rpartition("/")[0] for name in names}
    if not all(found) or len(folders) != 1:
        raise InputError(
            f"{path.name}: labels of {', '.join(sorted(folders)) or 'no picture'}; expected those "
            "of the pictures of one video, named by their frames as img0012.png is."
        )
    numbers = [m[1] for m in found if m is not None]
    frames = np.array([int(number) for number in numbers])
    order = np.argsort(frames, kind="stable")
    tracks = _build(path.name, frames[order], columns, values[order], fps=fps, unit="px")
    first = names[0]
    at = _NUMBER.search(first)
    width = f"0{len(numbers[0])}" if len(set(map(len, numbers))) == 1 else ""
    pattern = f"{first[: at.start(1)]}%{width}d{first[at.end(1) :]}" if at else ""
    return tracks.assign_attrs({SCORER: columns[0][0], PICTURES: pattern})


def _build(
    where: str,
    frames: np.ndarray,
    columns: Sequence[Column],
    values: FloatArray,
    *,
    fps: float,
    unit: str,
) -> Tracks:
    """Make Tracks of a table whose columns have names of three or four levels."""
    if not {len(name) for name in columns} <= {3, 4} or len(set(map(len, columns))) != 1:
        raise InputError(
            f"{where}: columns have {len(columns[0])} levels; expected scorer, (individuals,) "
            "bodyparts, coords. Of another program: write its points as csv with frame and "
            "<point>_x, <point>_y (and _z) of each."
        )
    named = [(c[1] if len(c) == 4 else ONE, c[-2], c[-1]) for c in columns]
    kept = [i for i, name in enumerate(named) if not _OF_SMOOTHER.fullmatch(name[2])]
    named, values = [named[i] for i in kept], values[:, kept]
    _check_columns(named, where, list(dict.fromkeys(c[0] for c in columns)))
    individuals, points = (list(dict.fromkeys(c[i] for c in named)) for i in (0, 1))
    axes = "xyz" if any(c[2] == "z" for c in named) else "xy"
    place = {c: i for i, c in enumerate(named)}
    padded = np.column_stack([values, np.full(len(values), np.nan)])

    def picked(axis: str) -> FloatArray:
        # a point that one animal does not have is missing in it: the last column
        at = [[place.get((who, p, axis), -1) for who in individuals] for p in points]
        return padded[:, np.array(at)]

    scorer = columns[0][0]
    said = picked("likelihood") if any(c[2] == "likelihood" for c in named) else None
    if said is not None and scorer == SMOOTHER and not np.nan_to_num(said).any():
        said = None
    places = np.stack([picked(axis) for axis in axes], axis=-1)
    if said is not None:  # DeepLabCut 3 fills up animals that it did not find: all -1, or all 0
        every = np.concatenate([places, said[..., None]], axis=-1)
        lost = (every == -1).all(axis=-1) | (every == 0).all(axis=-1)
        places = np.where(lost[..., None], np.nan, places)
    tracks = build_tracks(
        frames,
        places,
        said,
        points=points,
        fps=fps,
        unit="px" if axes == "xy" else unit,
        program=program_of(scorer),
        where=where,
        individuals=individuals,
    )
    own = {who: [p for p in points if (who, p, "x") in place] for who in individuals}
    if all(own[who] == points for who in individuals):
        return tracks
    return tracks.assign_attrs({POINTS_OF: json.dumps(own)})


def program_of(scorer: str) -> str:
    """Return the program that calls its predictions so.

    Parameters
    ----------
    scorer : str
        First line of the header.

    Returns
    -------
    str
        Lightning Pose, its Ensemble Kalman Smoother, or else DeepLabCut.
    """
    if scorer == SMOOTHER:
        return "Ensemble Kalman Smoother"
    return "Lightning Pose" if _LIGHTNING_POSE.fullmatch(scorer) else DEEPLABCUT


def dataframe_of(file: h5py.File) -> h5py.Group | None:
    """Return where the table of an open file lies.

    Parameters
    ----------
    file : h5py.File
        The file.

    Returns
    -------
    h5py.Group or None
        DeepLabCut's own, else the only table whose columns have levels, by whatever name a script
        kept it; None where there is none, or several.
    """
    tables = {
        name: item
        for name, item in file.items()
        if isinstance(item, h5py.Group) and "pandas_type" in item.attrs
    }
    named = next((tables[name] for name in (GROUP, LABELS_GROUP) if name in tables), None)
    others = [item for item in tables.values() if "axis0_level0" in item or "table" in item]
    return others[0] if named is None and len(others) == 1 else named


def _read_h5(path: Path, *, labels: bool = False) -> tuple[Any, list[Column], FloatArray]:
    """Return frames (of labels: names of rows), columns and numbers of an h5."""
    with open_hdf5(path, expected=_EXPECTED) as file:
        group = dataframe_of(file)
        if group is None:
            raise InputError(f"{path.name}: no {GROUP} in it; expected {_EXPECTED}.")
        index, columns, values = read_pandas_frame(group, where=path.name)
    if isinstance(index, list) is not labels:
        raise InputError(
            f"{path.name}: rows are named by {'numbers' if labels else 'pictures or words'}; "
            f"expected {'pictures, as in labels for training' if labels else _FRAMES}."
        )
    return index, columns, values


def _read_csv(path: Path, *, labels: bool = False) -> tuple[Any, list[Column], FloatArray]:
    """Return frames (of labels: names of rows), columns and numbers of a csv."""
    text = read_table_text(path, expected=_EXPECTED)
    head = list(itertools.islice(csv.reader(io.StringIO(text)), 4))
    levels = tuple(row[0].strip() for row in head if row)
    header = next((known for known in _LEVELS if levels[: len(known)] == known), None)
    if header is None:
        raise InputError(
            f"{path.name}: lines begin with {', '.join(levels)}; expected the header lines "
            "scorer, (individuals,) bodyparts, coords of DeepLabCut."
        )
    n_header = len(header)
    skip = 1
    if labels:  # a picture's name may take three cells
        skip = next((i for i, cell in enumerate(head[0][1:], start=1) if cell.strip()), 1)
    names = [[cell.strip() for cell in row[skip:]] for row in head[:n_header]]
    width = len(names[0])
    if width == 0 or any(len(row) != width for row in names):
        raise InputError(f"{path.name}: header lines of different length; expected {_EXPECTED}.")
    columns = list(zip(*names, strict=True))
    if any(column[0] == "set" and not column[-1] for column in columns):
        raise InputError(
            f"{path.name}: predictions of Lightning Pose for its training pictures (column 'set'); "
            "expected those of a video, as in its folder video_preds."
        )
    if not labels:
        body = _numbers(text, n_header, width + 1, names[-2:], path.name)
        return body[:, 0], columns, body[:, 1:]
    lines = [line for line in text.split("\n") if line.strip()][n_header:]
    rows = [tuple(cell.strip() for cell in line.split(",")[:skip]) for line in lines]
    # the number of the line in place of the picture: one way of reading the cells
    plain = [f"{i},{','.join(line.split(',')[skip:])}" for i, line in enumerate(lines)]
    filled = "\n".join([*text.split("\n")[:n_header], *plain])
    return rows, columns, _numbers(filled, n_header, width + 1, names[-2:], path.name)[:, 1:]


def _numbers(
    text: str, n_header: int, width: int, names: Sequence[Sequence[str]], where: str
) -> FloatArray:
    """Return the rows below the header as numbers, or say which cell is none."""
    lines = [(i, line) for i, line in enumerate(text.split("\n"), start=1) if line.strip()]
    lines = lines[n_header:]
    if not lines:
        raise InputError(f"{where}: no rows below the header; expected one for each frame.")
    for i, line in lines:
        if line.count(",") != width - 1:
            raise InputError(
                f"{where}: line {i} has {line.count(',') + 1} cells; expected {width} as in the "
                "header: copy the file again from where it is whole, or mend that line."
            )
    table = pd.read_csv(
        io.StringIO("\n".join(line for _, line in lines)),
        header=None,
        names=list(range(width)),
        quoting=csv.QUOTE_NONE,
        skipinitialspace=True,
        low_memory=False,
    )
    for column in range(width):
        cells = table[column]
        cells = cells.astype(str) if cells.dtype == bool else cells  # "True" is no number
        numbers = pd.to_numeric(cells, errors="coerce").to_numpy(dtype=float)
        bad = (~np.isfinite(numbers) & cells.notna().to_numpy()) | (
            np.isnan(numbers) if column == 0 else False
        )
        if bad.any():
            row = int(np.argmax(bad))
            what = "the frame" if column == 0 else " ".join(part[column - 1] for part in names)
            raise InputError(
                f"{where}: line {lines[row][0]}, {what} is {_said(cells.iloc[row])}; expected "
                + ("a whole number." if column == 0 else "a number, or an empty cell.")
            )
        table[column] = numbers
    return table.to_numpy(dtype=float)


def _said(cell: object) -> str:
    """Say what a cell holds."""
    text = str(cell)
    if re.search(r"\.(png|jpe?g|tiff?|bmp)$", text):
        return f"the picture {text!r}, as in labels for training"
    return "empty" if pd.isna(cell) else repr(text)  # type: ignore[call-overload]


def _check_columns(
    named: Sequence[tuple[str, str, str]], where: str, scorers: Sequence[str]
) -> None:
    """Refuse columns that are there twice, unknown coordinates, and points with half a place."""
    known = ("x", "y", "z", "likelihood")
    seen: set[tuple[str, str, str]] = set()
    for who, point, axis in named:
        of = f"{point} {axis}" if who == ONE else f"{who} {point} {axis}"
        if (who, point, axis) in seen:
            mend = "keep one of them, or name the points differently."
            if len(scorers) > 1:
                mend = f"keep the columns of one scorer, of {' and '.join(scorers)}."
            raise InputError(f"{where}: column {of} is there twice; {mend}")
        if axis not in known:
            raise InputError(f"{where}: column {of}; expected coords {', '.join(known)}.")
        seen.add((who, point, axis))
    for who, point, _ in named:
        for axis in ("x", "y"):
            if (who, point, axis) not in seen:
                raise InputError(f"{where}: column {axis} of point {point!r} is missing.")
