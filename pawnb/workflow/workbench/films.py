"""Films of tracks that other programs made: which they are, and where corrections go."""

from __future__ import annotations

from pathlib import Path

from pawnb.errors import PawnbError
from pawnb.io.formats import recognise_format
from pawnb.trial import Trial
from pawnb.trial.file import VIDEO_ENDINGS
from pawnb.workflow.gait.sources import recording_name
from pawnb.workflow.reviewing.foreign import CORRECTED


def find_videos(folder: str | Path) -> list[Path]:
    """Return the video files that lie in a folder itself, in the order of their names."""
    folder = Path(folder)
    files = folder.iterdir() if folder.is_dir() else ()
    return sorted(file for file in files if file.suffix.lower() in VIDEO_ENDINGS)


def is_tracks_file(file: Path) -> bool:
    """Whether a file holds tracks that can be read."""
    try:
        recognise_format(file)
    except (PawnbError, OSError):
        return False
    return True


def film_of(file: Path) -> Path | None:
    """Return the video beside a file of tracks with whose name that of the file begins.

    Parameters
    ----------
    file : Path
        The file, such as ``m01DLC_resnet50.h5``.

    Returns
    -------
    Path or None
        Such as ``m01.avi``; None where there is none, or the file is not one of tracks.
    """
    if not is_tracks_file(file):
        return None
    name = recording_name(file, recognise_format(file))
    fits = [
        video
        for video in find_videos(file.parent)
        if name.startswith(video.stem) and not name[len(video.stem) :][:1].isalnum()
    ]
    return max(fits, key=lambda video: len(video.stem), default=None)


def films_of_tracks(trial: Trial) -> tuple[Path, ...]:
    """Return the films on which the tracks of a trial of kind ``tracks`` can be looked at.

    Parameters
    ----------
    trial : Trial
        The trial.

    Returns
    -------
    tuple of Path
        The videos of its views; where it names none, the one beside its file. Empty where there
        is none, or each view has a file of its own.
    """
    if trial.tracks_file is None:
        return ()
    named = tuple(trial.path(view.video) for view in trial.views if view.video)
    if named:
        return named if all(path.is_file() for path in named) else ()
    found = film_of(trial.path(trial.tracks_file))
    return () if found is None else (found,)


def first_file(file: Path) -> Path:
    """Return the file that was corrected, where a corrected one is named and that lies beside."""
    first = file.with_name(file.name.removeprefix(CORRECTED))
    return first if first.exists() else file
