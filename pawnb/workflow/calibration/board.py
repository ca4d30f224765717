"""``pawnb calibrate --board``: views calibrated, or cameras judged, by pictures of a board."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pandas as pd

from pawnb.core.calibration.corners import FEWEST_CORNERS, CornerFinder, other_boards
from pawnb.core.calibration.rig_from_boards import (
    BoardFit,
    Sightings,
    calibrate_by_boards,
    find_outlying_views,
    judge_by_boards,
    sides_in_space,
    tell_disagreement,
)
from pawnb.core.video import ViewReader, open_view
from pawnb.core.video.pictures import PictureFolder
from pawnb.errors import CalibrationError, InputError, did_you_mean
from pawnb.io.boards import Board, read_board
from pawnb.io.cameras import read_cameras
from pawnb.trial import View
from pawnb.workflow.calibration.written import Written, find_copies, write_calibration

MOST_SHOTS = 100
"""Pictures of a film that are looked at, evenly over it: more say nothing new."""

_MOST_TRIED = 8
"""Pictures in which boards of other squares are looked for where the board is in none."""

_OTHER_MARKER = 0.2
"""Markers that are so much longer or shorter than they should be are doubted (by hand: corners
of markers are found on whole pixels, and small ones come out some pixels too short)."""


@dataclass(frozen=True, kw_only=True)
class BoardCalibration:
    """Views calibrated, or cameras judged, by a board.

    Parameters
    ----------
    fit : BoardFit
        The cameras, and the error of each shot.
    sides : ndarray
        Distances of neighbouring corners as triangulated, in the unit of the board.
    square : float
        What they should be.
    remarks : tuple of str
        What a person should know: shots set aside, views that do not belong.
    written : Written or None
        The files; None where cameras were judged only.
    """

    fit: BoardFit
    sides: np.ndarray
    square: float
    remarks: tuple[str, ...]
    written: Written | None

    @property
    def views(self) -> pd.DataFrame:
        """A row a view: ``view, n_shots, n_corners, rms_px, worst_px, focal_px, lens``."""
        rows = []
        for i, camera in enumerate(self.fit.cameras):
            model = self.fit.lenses[i].model if self.fit.lenses else "as given"
            rows.append(
                {"view": camera.name, **self.fit.of_view(camera.name),
                 "focal_px": float(camera.matrix[0, 0]), "lens": model}
            )  # fmt: skip
        return pd.DataFrame(rows)

    @property
    def is_sound(self) -> bool:
        """Whether all views agree."""
        return not find_outlying_views(self.fit.shots) and tell_disagreement(self.fit) is None

    def text(self) -> str:
        """Return the error of each view, remarks and the lines of ``trial.toml``."""
        lines = [
            f"{row.view}: {row.n_shots} pictures of the board, corner error {row.rms_px:.2f} px "
            f"RMS, at most {row.worst_px:.2f} px; focal length {row.focal_px:.0f} px; lens: "
            f"{row.lens}"
            for row in self.views.itertuples()
        ]
        off = self.sides - self.square
        lines.append(
            f"in space: {len(off)} sides of squares of {self.square:g} are "
            f"{np.median(self.sides):.3f} long (median), off by {np.sqrt(np.mean(off**2)):.3f} RMS"
        )
        if self.fit.floor is not None:
            lines.append(
                f"axes: the board of picture {self.fit.floor} (from 0): x to the right and y up on "
                "it, z towards who looks at it, zero in its lower left corner"
            )
        lines += self.remarks
        return "\n".join(lines + (self.written.lines() if self.written else []))

    def table(self) -> dict[str, Any]:
        """Return what was found as plain values and tables."""
        return {
            "views": self.views,
            "shots": self.fit.shots,
            "square": self.square,
            "square_median": float(np.median(self.sides)),
            "square_rms": float(np.sqrt(np.mean((self.sides - self.square) ** 2))),
            "floor": self.fit.floor,
            "remarks": list(self.remarks),
            "files": self.written.files() if self.written else [],
        }


def calibrate_from_board(
    board: Board | str | Path,
    pictures: Mapping[str, str | Path],
    *,
    out: str | Path | None = None,
    floor: int | None = None,
    most_shots: int = MOST_SHOTS,
    progress: Callable[[int, int], None] | None = None,
) -> BoardCalibration:
    """Calibrate views by a checkerboard or ChArUco board that was shown to them.

    Parameters
    ----------
    board : Board, str or Path
        The board, or its ``board.toml``.
    pictures : mapping
        View to its pictures: a video, a folder or a glob. Pictures of one number are of one
        instant.
    out : str or Path, optional
        The file to write, usually ``DLTcoefs.csv``; ``lenses.toml`` is written beside it.
    floor : int, optional
        Number (from 0) of the picture whose board gives the axes; default the first that most
        views see.
    most_shots : int
        Of longer films so many frames are looked at, evenly over the film.
    progress : callable, optional
        Called with (done, total) pictures.

    Returns
    -------
    BoardCalibration
        The cameras, the error of each view and shot, and what was set aside.

    Raises
    ------
    InputError
        If the board, a picture or a name is wrong.
    CalibrationError
        If the board is not found, or the views do not agree.
    """
    sightings, shots, notes = find_boards(board, pictures, most_shots=most_shots, progress=progress)
    fit = calibrate_by_boards(sightings, floor=floor if floor is None else _place(shots, floor))
    fit = numbered(fit, shots)
    written = None if out is None else write_calibration(fit.cameras, out)
    doubt = tell_disagreement(fit)
    remarks = (*notes, *_set_aside(fit.shots), *([] if doubt is None else [f"look: {doubt}"]))
    return _result(fit, sightings, remarks, written)


def judge_cameras(
    cameras: str | Path,
    board: Board | str | Path,
    pictures: Mapping[str, str | Path],
    *,
    most_shots: int = MOST_SHOTS,
    progress: Callable[[int, int], None] | None = None,
) -> BoardCalibration:
    """Tell whether another program's cameras show a board where it was.

    Parameters
    ----------
    cameras : str or Path
        Their file (:func:`pawnb.io.cameras.read_cameras`).
    board, pictures, most_shots, progress
        As for :func:`calibrate_from_board`; views are called as the cameras are.

    Returns
    -------
    BoardCalibration
        The error of each view and shot; views that do not belong are named in ``remarks``.

    Raises
    ------
    InputError
        If a view has no camera, or a file is wrong.
    """
    found = {camera.name: camera for camera in read_cameras(cameras)}
    for name in pictures:
        if name not in found:
            raise InputError(
                f"{Path(cameras).name}: no camera {name!r}{did_you_mean(name, found)}; there are "
                f"{', '.join(found)}: give the pictures of each as {next(iter(found))}=PATH."
            )
    sightings, shots, notes = find_boards(board, pictures, most_shots=most_shots, progress=progress)
    fit = numbered(judge_by_boards([found[name] for name in pictures], sightings), shots)
    remarks = [*notes]
    copies = find_copies(list(found.values()))
    for view in find_outlying_views(fit.shots):
        twins = [a if b == view else b for a, b in copies if view in (a, b)]
        copied = f", and is a copy of that of {twins[0]!r}" if twins else ""
        remarks.append(
            f"view {view!r} does not belong to the others: its camera shows the corners "
            f"{fit.of_view(view)['rms_px']:.1f} px (RMS) from where they were filmed{copied}; "
            "calibrate it again."
        )
    return _result(fit, sightings, tuple(remarks), None)


def find_boards(
    board: Board | str | Path,
    pictures: Mapping[str, str | Path],
    *,
    most_shots: int = MOST_SHOTS,
    progress: Callable[[int, int], None] | None = None,
) -> tuple[Sightings, np.ndarray, list[str]]:
    """Find a board in the pictures of each view.

    Parameters
    ----------
    board, pictures, most_shots, progress
        As for :func:`calibrate_from_board`.

    Returns
    -------
    sightings : Sightings
        Corners by view and shot.
    shots : ndarray of int
        The picture that each shot is.
    notes : list of str
        What a person should know of the files.

    Raises
    ------
    CalibrationError
        If there is one view only, or the board is in no picture of a view.
    InputError
        If folders hold different numbers of pictures.
    """
    board = board if isinstance(board, Board) else read_board(board)
    if len(pictures) < 2:
        raise CalibrationError(
            f"one view only ({', '.join(pictures)}): where a point is in space is told by two or "
            "more; for a single view, measure px_per_unit."
        )
    readers = {name: _open(name, path) for name, path in pictures.items()}
    try:
        n, notes = _n_instants(readers)
        notes += [note for reader in readers.values() for note in reader.source.notes]
        shots = np.unique(np.linspace(0, n - 1, min(n, max(most_shots, 1))).astype(int))
        finder = CornerFinder(board)
        uv = np.full((len(readers), len(shots), finder.n_corners, 2), np.nan)
        for v, reader in enumerate(readers.values()):
            for s, index in enumerate(shots):
                uv[v, s] = finder.find(_grey(reader, int(index)))
                if progress is not None:
                    progress(v * len(shots) + s + 1, len(readers) * len(shots))
            if (np.isfinite(uv[v, ..., 0]).sum(axis=-1) < FEWEST_CORNERS).all():
                raise _none_found(board, reader, shots)
        notes += _other_marker(board, finder.marker_side())
        sizes = tuple((reader.width, reader.height) for reader in readers.values())
    finally:
        for reader in readers.values():
            reader.close()
    sightings = Sightings(
        names=tuple(pictures),
        sizes=sizes,
        corners=board.corners(),
        uv=uv,
        may_be_turned=finder.may_be_turned,
    )
    return sightings, shots, notes


def _other_marker(board: Board, side: float) -> list[str]:
    """Doubt a length of markers that does not go with that of squares."""
    if board.marker is None or not abs(side / board.marker - 1.0) > _OTHER_MARKER:
        return []
    return [
        f"look: markers are {side:.3g} long where squares are {board.square:g}, and marker_length "
        f"is {board.marker:g}: measure both on the board, with its black edge, and mend board.toml"
    ]


def _none_found(board: Board, reader: ViewReader, shots: np.ndarray) -> CalibrationError:
    """Make the error for a view without the board: boards of other squares are looked for."""
    kind = "checkerboard" if board.marker is None else "ChArUco board"
    said = f"expected a {kind} of {board.columns} x {board.rows} squares"
    tried = shots[np.unique(np.linspace(0, len(shots) - 1, _MOST_TRIED).astype(int))]
    pictures = [_grey(reader, int(index)) for index in tried]
    for other in other_boards(board):
        finder = CornerFinder(other)
        if any(np.isfinite(finder.find(picture)).any() for picture in pictures):
            return CalibrationError(
                f"no board is found in view {reader.name!r} in any of {len(shots)} pictures: "
                f"{said}, but one of {other.columns} x {other.rows} is there: board_x and board_y "
                "count squares, black and white ones, and not the corners between them; mend "
                "board.toml."
            )
    return CalibrationError(
        f"no board is found in view {reader.name!r} in any of {len(shots)} pictures; {said}, whole "
        "and sharp: check board.toml and the pictures."
    )


def _open(name: str, path: str | Path) -> ViewReader:
    """Open the pictures of a view, as filmed."""
    return open_view(View(name=name, video=str(Path(path).absolute())), Path())


def _n_instants(readers: Mapping[str, ViewReader]) -> tuple[int, list[str]]:
    """Return how many instants all views have."""
    counts = {name: reader.n_frames for name, reader in readers.items()}
    least = min(counts.values())
    if least == max(counts.values()):
        return least, []
    said = ", ".join(f"{name} {n}" for name, n in counts.items())
    if any(isinstance(reader.source, PictureFolder) for reader in readers.values()):
        raise InputError(
            f"the views have different numbers of pictures ({said}), so that it is not known which "
            "were taken together; keep one of each view for each instant."
        )
    return least, [
        f"the films are of different length ({said}): frames of one number are taken to be of one "
        f"instant, and those after {least} are left out"
    ]


def _grey(reader: ViewReader, index: int) -> np.ndarray:
    """Return a picture in grey."""
    image = reader.frame(index).image()
    return cv2.cvtColor(image, cv2.COLOR_RGB2GRAY) if image.ndim == 3 else image


def _place(shots: np.ndarray, picture: int) -> int:
    """Return which shot a picture is."""
    at = np.flatnonzero(shots == picture)
    if not len(at):
        raise CalibrationError(
            f"picture {picture} gives no axes: looked at were {len(shots)} pictures, {shots[0]} to "
            f"{shots[-1]} (counted from 0)."
        )
    return int(at[0])


def numbered(fit: BoardFit, shots: np.ndarray) -> BoardFit:
    """Call the shots of a fit by the numbers of their pictures.

    Parameters
    ----------
    fit : BoardFit
        The fit.
    shots : ndarray of int
        The picture that each shot is.

    Returns
    -------
    BoardFit
        The same fit with those numbers.
    """
    floor = None if fit.floor is None else int(shots[fit.floor])
    table = fit.shots.assign(shot=shots[fit.shots["shot"].to_numpy(int)])
    return replace(fit, shots=table, floor=floor)


def _set_aside(shots: pd.DataFrame) -> list[str]:
    """Return sentences that name the shots which were set aside."""
    said = []
    for view, rows in shots[shots["set_aside"]].groupby("view", sort=False):
        each = ", ".join(f"{r.shot} ({r.rms_px:.1f} px)" for r in rows.itertuples())
        said.append(f"set aside in view {view!r}, as it does not agree with the others: {each}")
    return said


def _result(
    fit: BoardFit, sightings: Sightings, remarks: Sequence[str], written: Written | None
) -> BoardCalibration:
    """Measure the squares in space and put everything together."""
    square = float(np.linalg.norm(sightings.corners[1] - sightings.corners[0]))
    sides = sides_in_space(fit, sightings.corners)
    return BoardCalibration(
        fit=fit, sides=sides, square=square, remarks=tuple(remarks), written=written
    )
