"""A film of a trial with its tracks, for a talk or a co-author."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from pawnb.core.video import open_views
from pawnb.errors import InputError
from pawnb.files import whole_file
from pawnb.schema import Tracks
from pawnb.schema.arguments import checked_arguments
from pawnb.synthetic.colour_video import H264VideoWriter
from pawnb.trial import Trial, load_trial
from pawnb.workflow.export.marks import TRAIL, Marks
from pawnb.workflow.export.tiles import Tiles

_CRF = 20


@checked_arguments
def export_film(
    trial: Trial | str | Path,
    tracks: Tracks,
    path: str | Path,
    *,
    frames: tuple[int, int] | range | None = None,
    views: Sequence[str] | None = None,
    play_fps: float = 25.0,
    width: int = 1280,
    trail: int = TRAIL,
    progress: Callable[[int, int], object] | None = None,
) -> Path:
    """Write a film of the views with tracks drawn over them (mp4, H.264).

    Parameters
    ----------
    trial : Trial, str or Path
        The trial, its ``trial.toml``, or the folder that holds it.
    tracks : xarray.Dataset
        Its tracks.
    path : str or Path
        The film, ``.mp4``; written whole or not at all.
    frames : tuple of int or range, optional
        First frame, and one past the last, or ``range(100, 160)``; default all that were tracked.
    views : sequence of str, optional
        Which views, in which order; default all.
    play_fps : float
        Frames that the film shows in a second; those of the recording show it as fast as it was.
    width : int
        Width of the film, px.
    trail : int
        Frames of the past that trails show; 0 shows none.
    progress : callable, optional
        ``progress(done, total)``, frame by frame.

    Returns
    -------
    Path
        The film.

    Raises
    ------
    InputError
        If the frames are not tracked, a view is unknown, or the film cannot be written.

    Examples
    --------
    >>> pawnb.export_film(trial, tracks, "sample/film.mp4", frames=(0, 20), width=640).name
    'film.mp4'
    """
    path, trial = Path(path), trial if isinstance(trial, Trial) else load_trial(trial)
    if path.suffix.lower() != ".mp4":
        raise InputError(f"{path.name}: a film is written as .mp4; give it that ending.")
    if not 0.1 <= play_fps <= 1000:
        raise InputError(f"play_fps is {play_fps}; expected 0.1 to 1000 frames a second.")
    marks = Marks.of_tracks(tracks)
    first, stop = _ends(frames) or (int(marks.frames[0]), int(marks.frames[-1]) + 1)
    with open_views(trial) as shown:
        stop = min(stop, shown.n_frames) if frames is None else stop
        if not shown.first_frame <= first < stop <= shown.n_frames:
            raise InputError(
                f"frames are {first} to {stop}; expected a part of {shown.first_frame} to "
                f"{shown.n_frames}, the first one first."
            )
        tiles = Tiles(shown, marks, shown=views, width=width, trail=trail)
        with (
            whole_file(path) as part,
            H264VideoWriter(part, size=tiles.size, fps=play_fps, crf=_CRF) as film,
        ):
            for frame, pictures in shown.frames(first, stop):
                film.write(tiles.picture(frame, pictures))
                if progress is not None:
                    progress(frame + 1 - first, stop - first)
    return path


def _ends(frames: tuple[int, int] | range | None) -> tuple[int, int] | None:
    """Return first frame and one past the last; None for all."""
    if frames is None:
        return None
    if isinstance(frames, range):
        given: Sequence[int] = (frames.start, frames.stop) if frames.step == 1 else tuple(frames)
    else:
        given = tuple(frames)
    if len(given) != 2:
        raise InputError(
            f"frames are {len(given)} numbers; a film shows frames that follow one another: give "
            "(first, one past the last), or range(first, one past the last)."
        )
    return given[0], given[1]
