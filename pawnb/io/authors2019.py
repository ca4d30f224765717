"""Tracks in the csv files of the 2019 paper's authors (four cameras, several markers a leg).

A trial is four files, ``cam{1,3}.{f,h}.<animal>.<condition>.<stamp>.csv``: cameras 1 and 2
on one side of the belt and 3 and 4 on the other; f the front leg (shoulder, elbow, hand), h
the hind leg (iliac crest, hip, knee, ankle, toe). Five lines of settings come first. Each
marker has four columns, Y before X, for the first and then the second camera. Beside them
lie ``DLT.<trial>.csv`` and ``Speed_Time.<trial>.csv``.

**Pixels.** The authors triangulate with v = 700 - Y for all cameras, u = X for cameras 1 and
2 and u = 2048 - X for 3 and 4, whose pictures they mirrored before tracking. Here every
view is as filmed, in pawnb's pixels (u right, v down, (0, 0) the centre of the top-left
pixel): cameras 3 and 4 are mirrored back, and :func:`read_authors_dlt` moves the
coefficients so that exactly the authors' points in space result.

**Sides.** The space of their rig is right-handed (the determinants of all four projection
matrices have the sign of unmirrored pictures), Z is up, and the animal faces +X: shoulders
are ahead of hips along X, and feet on the belt are carried towards -X. Left is then up ×
forward = +Y. Cameras 1 and 2 stand at Y = +0.7 m and track the leg with the larger Y: they
see the **left** side, cameras 3 and 4 the right.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd

from pawnb.arrays import BoolArray, FloatArray, IntArray
from pawnb.errors import InputError
from pawnb.io.coefs import read_coefs
from pawnb.io.tables import read_cells, read_numbers
from pawnb.schema import (
    ORIGIN_CODE,
    Tracks,
    add_provenance,
    check_frames,
    make_tracks,
    note_absent,
)

VIEWS = ("cam1", "cam2", "cam3", "cam4")
HEADER_LINES = 5
SIZE = (2048, 700)

MARKERS = {"f": ("Shoulder", "Elbow", ""), "h": ("Asis", "Hip", "Knee", "Ankle", "")}
_SIDES = {1: "L", 3: "R"}
_NAME = re.compile(
    r"cam(?P<cam>[13])\.(?P<part>[fh])\.(?P<trial>(?P<animal>[^.]+)\..*?"
    r"(?P<stamp>\d{4}-\d\d-\d\d_\d\d_\d\d_\d\d))\.csv"
)
_REACH = 3
"""Frames before and after a row that it is compared with."""
_EDGE = 4.0
"""How much further a row may be off where it has neighbours on one side only."""


def read_authors_trial(
    folder: str | Path,
    stamp: str | None = None,
    *,
    size: tuple[int, int] = SIZE,
    fps: float = 250.0,
    row_px: float | None = 15.0,
) -> Tracks:
    """Read the four files of one trial.

    Parameters
    ----------
    folder : str or Path
        The folder that holds them.
    stamp : str, optional
        Date and time in the file names, ``2018-06-08_13_29_13``; not needed where the folder
        holds one trial.
    size : tuple of int
        Width and height of the pictures in px.
    fps : float
        Frames per second; the authors' rig runs at 250.
    row_px : float, optional
        Rows that their program wrote wrongly are set missing: rows in which half of the
        markers of a camera lie further than this from the median of the three frames
        before and after (four times as far at the ends, where one side only is known).
        None keeps every row.

    Returns
    -------
    xarray.Dataset
        Tracks with image positions in four views and positions in space still missing;
        :func:`pawnb.core.reconstruct.triangulate_tracks` fills them. Feet are FL, HL, FR and
        HR (hand and toe), other markers FL_Shoulder, FL_Elbow, HL_Asis, HL_Hip, HL_Knee,
        HL_Ankle and so on. Confidence is 1: tracks were corrected by hand. The rows that
        were set missing are listed in the provenance under ``refused``.

    Raises
    ------
    InputError
        If a file is missing or is not of that format, or ``stamp`` fits no trial.
    """
    files = _find_files(Path(folder), stamp)
    width = size[0]
    parts = {}
    for (cam, part), path in files.items():
        frames, uv = _read_file(path, MARKERS[part])
        if cam == 3:
            uv[:, :, 0] = width - 1 - uv[:, :, 0]
        parts[cam, part] = (frames, uv)
    every = np.unique(np.concatenate([frames for frames, _ in parts.values()]))
    frames = np.arange(every[0], every[-1] + 1)
    matched = _NAME.fullmatch(files[1, "f"].name)
    animal = matched["animal"] if matched else "animal"
    points = [name for cam in (1, 3) for part in "fh" for name in point_names(cam, part)]
    tracks = make_tracks(
        frames, points, fps=fps, views=VIEWS, individual=animal, unit="mm",
        source_software="Kinematic-Software (Haji Maghsoudi et al. 2019)",
    )  # fmt: skip
    refused: dict[str, list[int]] = {}
    for (cam, part), (own_frames, uv) in parts.items():
        bad = _find_bad_rows(uv, row_px)
        uv[bad] = np.nan
        for k in range(2):
            if bad[:, k].any():
                refused[f"cam{cam + k}.{part}"] = own_frames[bad[:, k]].tolist()
        columns = [points.index(name) for name in point_names(cam, part)]
        _enter(tracks, own_frames - frames[0], slice(cam - 1, cam + 1), columns, uv)
    tracks = note_absent(tracks, every, file=f"the files of {matched['stamp'] if matched else ''}")
    return add_provenance(
        tracks,
        step="read",
        files=[path.name for path in files.values()],
        row_px=row_px,
        refused=refused,
    )


def read_authors_dlt(path: str | Path, *, size: tuple[int, int] = SIZE) -> FloatArray:
    """Read ``DLT.<trial>.csv`` into the pixels of :func:`read_authors_trial`.

    Parameters
    ----------
    path : str or Path
        A csv of 11 rows and four columns, one a camera.
    size : tuple of int
        Width and height of the pictures in px.

    Returns
    -------
    ndarray, shape (11, 4)
        DLT coefficients in mm and px (u right, v down) for cam1 .. cam4.

    Raises
    ------
    CalibrationError
        If the file is missing or is not that.
    """
    coefs = read_coefs(Path(path), VIEWS)
    P = np.concatenate([coefs, np.ones((1, 4))]).T.reshape(4, 3, 4)
    P[:, 1] = size[1] * P[:, 2] - P[:, 1]  # v = height - v of the authors
    P[2:, 0] -= P[2:, 2]  # u = u of the authors - 1: they mirror with width - X
    return P.reshape(4, 12)[:, :11].T.copy()


def read_authors_speed(path: str | Path) -> pd.DataFrame:
    """Read ``Speed_Time.<trial>.csv``: the belt, and the animal on it.

    Parameters
    ----------
    path : str or Path
        A csv with ``Frame_Num, Time_Stamp, Real_Speed, Belt_Speed`` (s, m/s). Empty lines at
        its end are skipped.

    Returns
    -------
    pandas.DataFrame
        ``frame``; ``speed`` of the belt in mm/s, as it was commanded; ``animal_speed``, of
        the animal relative to the belt, mm/s (the authors add the movement of its body
        to the commanded speed); ``time_s`` from the first row.

    Raises
    ------
    InputError
        If the file is missing, lacks a column, or holds something that is not a number.
    """
    where = Path(path).name
    columns = ("Frame_Num", "Time_Stamp", "Real_Speed", "Belt_Speed")
    cells = read_cells(path, columns)
    cells = cells[(cells[list(columns)] != "").any(axis=1)]
    time = read_numbers(cells, "Time_Stamp", where=where)
    return pd.DataFrame(
        {
            "frame": read_numbers(cells, "Frame_Num", where=where, whole=True),
            "speed": 1000.0 * read_numbers(cells, "Belt_Speed", where=where),
            "animal_speed": 1000.0 * read_numbers(cells, "Real_Speed", where=where),
            "time_s": time - time[:1].sum(),
        }
    )


def list_authors_trials(folder: str | Path) -> list[str]:
    """List the stamps of the trials that a folder holds.

    Parameters
    ----------
    folder : str or Path
        The folder.

    Returns
    -------
    list of str
        Date and time in the file names, sorted.
    """
    found = (_NAME.fullmatch(path.name) for path in Path(folder).glob("cam[13].[fh].*.csv"))
    return sorted({match["stamp"] for match in found if match})


def trial_stamp(name: str) -> str | None:
    """Return the stamp in the name of one of the authors' files, or None for other names."""
    matched = _NAME.fullmatch(name)
    return matched["stamp"] if matched else None


def split_name(name: str) -> str | None:
    """Return what the names of a trial's files share, ``<animal>.<condition>.<stamp>``.

    Parameters
    ----------
    name : str
        The name of one of its four files.

    Returns
    -------
    str or None
        None for other names.
    """
    matched = _NAME.fullmatch(name)
    return matched["trial"] if matched else None


def _find_files(folder: Path, stamp: str | None) -> dict[tuple[int, str], Path]:
    """Return the four files of a trial by camera (1, 3) and part (f, h)."""
    stamps = list_authors_trials(folder)
    if not stamps:
        raise InputError(
            f"{folder}: no trial of the 2019 authors; expected cam1.f.<animal>...csv and the like."
        )
    if stamp is None and len(stamps) > 1:
        raise InputError(f"{folder}: {len(stamps)} trials; give the stamp, one of {stamps}.")
    stamp = stamp or stamps[0]
    if stamp not in stamps:
        raise InputError(f"{folder}: no trial {stamp!r}; there are {', '.join(stamps)}.")
    files = {}
    for cam, part in ((1, "f"), (1, "h"), (3, "f"), (3, "h")):
        found = sorted(folder.glob(f"cam{cam}.{part}.*{stamp}.csv"))
        if len(found) != 1:
            raise InputError(
                f"{folder}: {len(found)} files cam{cam}.{part}...{stamp}.csv; expected one."
            )
        files[cam, part] = found[0]
    return files


def _read_file(path: Path, markers: tuple[str, ...]) -> tuple[IntArray, FloatArray]:
    """Return frames (n,) and X, Y (n, 2 cameras, 2, markers) of one file; NaN where empty."""
    names = ["Frames"]
    for letter in "MNOPQ"[: len(markers)]:
        for camera in ("", "2"):
            names += [f"{axis} Coordinate {letter}{camera}" for axis in "YX"]
    cells = read_cells(path, names, skip_lines=HEADER_LINES)
    where = path.name
    frames = read_numbers(cells, "Frames", where=where, whole=True)
    check_frames(frames, where=where)
    values = np.stack([read_numbers(cells, n, where=where, empty=True) for n in names[1:]], axis=1)
    yx = values.reshape(len(frames), len(markers), 2, 2)
    return frames, yx[..., ::-1].transpose(0, 2, 3, 1).copy()


def point_names(cam: int, part: str) -> list[str]:
    """Return the names of the markers of one file, in its order.

    Parameters
    ----------
    cam : {1, 3}
        Its first camera.
    part : {"f", "h"}
        The front or the hind leg.

    Returns
    -------
    list of str
        ``FL_Shoulder, FL_Elbow, FL`` and the like.
    """
    leg = part.upper() + _SIDES[cam]
    return [f"{leg}_{marker}" if marker else leg for marker in MARKERS[part]]


def _find_bad_rows(uv: FloatArray, row_px: float | None) -> BoolArray:
    """Find rows where a camera's markers as a whole jump away from their neighbours.

    The authors' program sometimes writes a row of other positions into one frame, often
    every fifth, and starts some files with one: all markers of the file jump together,
    which no animal does.
    """
    n, cameras = uv.shape[:2]
    bad = np.zeros((n, cameras), dtype=bool)
    if row_px is None or n <= _REACH:
        return bad
    padding = np.full((_REACH, *uv.shape[1:]), np.nan)
    padded = np.concatenate([padding, uv, padding])
    places = [i for i in range(2 * _REACH + 1) if i != _REACH]
    around = np.stack([padded[i : i + n] for i in places])
    known = np.isfinite(around).any(axis=0)
    centre = np.full(uv.shape, np.nan)
    centre[known] = np.nanmedian(around[:, known], axis=0)
    distance = np.linalg.norm(uv - centre, axis=2)  # frames, cameras, markers
    limit = np.full((n, 1, 1), row_px)
    limit[:_REACH] *= _EDGE
    limit[-_REACH:] *= _EDGE
    # half of the markers or more; comparing NaN is false
    return (distance > limit).mean(axis=2) >= 0.5


def _enter(tracks: Tracks, at: IntArray, views: slice, columns: list[int], uv: np.ndarray) -> None:
    """Write one file's image positions into the Tracks."""
    seen = np.isfinite(uv).all(axis=2)  # frames, cameras, markers
    for k, column in enumerate(columns):
        tracks["image_position"].to_numpy()[at, views, :, column, 0] = np.where(
            seen[:, :, None, k], uv[..., k], np.nan
        )
        tracks["image_origin"].to_numpy()[at, views, column, 0] = (
            seen[..., k] * ORIGIN_CODE["measured"]
        )
        tracks["image_confidence"].to_numpy()[at, views, column, 0] = seen[..., k]


def refused_rows(tracks: Tracks) -> Mapping[str, list[int]]:
    """Return the frames that :func:`read_authors_trial` set missing, by camera and part.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks from :func:`read_authors_trial`.

    Returns
    -------
    mapping
        For instance ``{"cam1.h": [0]}``.
    """
    steps = json.loads(tracks.attrs["provenance"]).get("steps", [])
    return next((step["refused"] for step in steps if "row_px" in step), {})
