"""A contact sheet: frames of a trial with its tracks on one picture."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np

from pawnb.core.video import open_views
from pawnb.errors import InputError
from pawnb.files import write_whole
from pawnb.schema import Tracks
from pawnb.schema.arguments import checked_arguments
from pawnb.trial import Trial, load_trial
from pawnb.workflow.export.marks import TRAIL, Marks
from pawnb.workflow.export.tiles import Tiles, best_columns

_FRAMES = 12
_SHEET_GAP_PX = 10


@checked_arguments
def export_sheet(
    trial: Trial | str | Path,
    tracks: Tracks,
    path: str | Path,
    *,
    frames: Sequence[int] | None = None,
    views: Sequence[str] | None = None,
    width: int = 640,
    trail: int = TRAIL,
) -> Path:
    """Write frames with their tracks side by side into one picture (png).

    Parameters
    ----------
    trial : Trial, str or Path
        The trial, its ``trial.toml``, or the folder that holds it.
    tracks : xarray.Dataset
        Its tracks.
    path : str or Path
        The picture, ``.png``.
    frames : sequence of int, optional
        Which frames; default 12, evenly spaced over the tracks.
    views : sequence of str, optional
        Which views, in which order; default all.
    width : int
        Width of each frame, px.
    trail : int
        Frames of the past that trails show; 0 shows none.

    Returns
    -------
    Path
        The picture.

    Raises
    ------
    InputError
        If a frame is not in the recording, a view is unknown, or the picture cannot be written.

    Examples
    --------
    >>> pawnb.export_sheet(trial, tracks, "sample/sheet.png", frames=[0, 20, 40]).name
    'sheet.png'
    """
    path, trial = Path(path), trial if isinstance(trial, Trial) else load_trial(trial)
    if path.suffix.lower() != ".png":
        raise InputError(f"{path.name}: a contact sheet is written as .png; give it that ending.")
    marks = Marks.of_tracks(tracks)
    with open_views(trial) as shown:
        last = min(int(marks.frames[-1]), shown.n_frames - 1)
        evenly = np.linspace(max(int(marks.frames[0]), shown.first_frame), last, _FRAMES)
        chosen = (
            sorted(set(evenly.round().astype(int).tolist())) if frames is None else list(frames)
        )
        wrong = [frame for frame in chosen if not shown.first_frame <= frame < shown.n_frames]
        if wrong or not chosen:
            raise InputError(
                f"frames are {chosen}; expected some of {shown.first_frame} to "
                f"{shown.n_frames - 1}."
            )
        tiles = Tiles(shown, marks, shown=views, width=width, trail=trail)
        across, down = tiles.size
        columns = best_columns([tiles.size] * len(chosen))
        rows = -(-len(chosen) // columns)
        sheet = np.full(
            (
                rows * (down + _SHEET_GAP_PX) - _SHEET_GAP_PX,
                columns * (across + _SHEET_GAP_PX) - _SHEET_GAP_PX,
                3,
            ),
            255,
            np.uint8,
        )
        for k, frame in enumerate(chosen):
            top, left = (
                k // columns * (down + _SHEET_GAP_PX),
                k % columns * (across + _SHEET_GAP_PX),
            )
            sheet[top : top + down, left : left + across] = tiles.picture(frame)
    done, data = cv2.imencode(".png", cv2.cvtColor(sheet, cv2.COLOR_RGB2BGR))
    if not done:
        raise InputError(
            f"{path.name}: a picture of {sheet.shape[1]} x {sheet.shape[0]} px is too large."
        )
    return write_whole(path, data.tobytes())
