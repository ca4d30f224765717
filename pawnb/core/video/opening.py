"""Opening what the views of a trial name: a video file, a folder or a glob of pictures."""

from __future__ import annotations

import contextlib
from pathlib import Path

from pawnb.core.lens import Lens, lenses_of_views
from pawnb.core.video.file import VideoFile
from pawnb.core.video.pictures import SUFFIXES, PictureFolder, is_animated, is_glob
from pawnb.core.video.stack import PictureStack
from pawnb.core.video.tiff import n_pictures
from pawnb.core.video.views import Source, ViewReader
from pawnb.core.video.viewset import ViewSet
from pawnb.errors import VideoError
from pawnb.trial import Trial, View

_CAMERAS = {
    ".cine": ("Phantom", "Phantom Camera Control (PCC)"),
    **dict.fromkeys((".mraw", ".cih", ".cihx"), ("Photron", "Photron FASTCAM Viewer (PFV)")),
    ".seq": ("Norpix", "StreamPix"),
}
"""Endings of the files of cameras' own programs: whose, and which program saves them otherwise."""


def open_view(
    view: View, folder: Path, *, lens: Lens | None = None, fps: float | None = None
) -> ViewReader:
    """Open one view.

    Parameters
    ----------
    view : View
        What was filmed: a video file, a folder or a glob of pictures, and what to show.
    folder : Path
        Folder that ``view.video`` is relative to.
    lens : Lens, optional
        Distortion to remove.
    fps : float, optional
        Frames per second of the recording; without it ``time_s`` is the file's own time.

    Returns
    -------
    ViewReader
        The open view; frame 0 is the first of the file.

    Raises
    ------
    VideoError
        If the video is missing or damaged, or the crop reaches outside the picture.
    """
    return _reader(view, _open_source(view, Path(folder)), lens, fps)


def open_views(trial: Trial, *, share_memory: bool = False) -> ViewSet:
    """Open every view of a trial; views of one file share its decoder.

    Parameters
    ----------
    trial : Trial
        What was filmed.
    share_memory : bool
        Whether the memory for stepping back, 64 MB a file, is one for all files: enough for a
        person who looks at the frames; who reads them all backwards wants more.

    Returns
    -------
    ViewSet
        The open views, a context manager; its ``notes`` say what a user should know.

    Raises
    ------
    VideoError
        If a video is missing or damaged, a crop reaches outside its picture, or
        ``trial.frames`` asks for frames that a view does not have.
    InputError
        If the lens file is wrong or lacks a view.
    """
    if not trial.views:
        raise VideoError(f"trial {trial.name!r} has no views; add [[views]] to its trial.toml.")
    lenses = lenses_of_views(trial, [view.name for view in trial.views])
    sources: dict[str, Source] = {}
    n_files = len({view.video for view in trial.views}) if share_memory else 1
    with contextlib.ExitStack() as on_error:
        readers = {}
        for view in trial.views:
            if view.video not in sources:
                sources[view.video] = _open_source(view, trial.folder, n_files)
                on_error.callback(sources[view.video].close)
            source = sources[view.video]
            readers[view.name] = _reader(view, source, lenses.get(view.name), trial.fps)
        views = ViewSet(readers, fps=trial.fps, offsets={v.name: v.offset for v in trial.views})
        if trial.frames is not None:
            views.check_range(*trial.frames)
        on_error.pop_all()
    return views


def _reader(view: View, source: Source, lens: Lens | None, fps: float | None) -> ViewReader:
    """Make the reader of a view, and close its file if it does not fit the view."""
    with contextlib.ExitStack() as on_error:
        on_error.callback(source.close)
        reader = ViewReader(view, source, lens=lens, fps=fps)
        on_error.pop_all()
    return reader


def _open_source(view: View, folder: Path, n_files: int = 1) -> Source:
    """Open what a view names, by what it is; messages begin with the view's name."""
    path = folder / view.video
    try:
        if path.is_dir() or (is_glob(view.video) and not path.exists()):
            return PictureFolder(path)
        if path.exists() and path.suffix.lower() in SUFFIXES and not is_animated(path):
            return PictureStack(path) if n_pictures(path) > 1 else PictureFolder(path)
        return VideoFile(path, n_files=n_files)
    except VideoError as error:
        words = _of_a_camera(path) or str(error)
        raise VideoError(f"view {view.name!r}: {words}") from None


def _of_a_camera(path: Path) -> str:
    """Say how to save what a camera's own program wrote, where that cannot be read."""
    if path.suffix.lower() not in _CAMERAS or not path.is_file() or not path.stat().st_size:
        return ""
    maker, program = _CAMERAS[path.suffix.lower()]
    kinds = ", but for cine files of 8, 10 or 16 bits a pixel that are whole"
    return (
        f"{path}: {maker}'s own format, which is not read{kinds * (maker == 'Phantom')}; save the "
        f"recording in {program} as AVI (uncompressed or Motion JPEG) or as TIFF, and name that."
    )
