"""TIFF files of many pictures, as cameras and ImageJ write them, read as if they were a video."""

from __future__ import annotations

import contextlib
import threading
from pathlib import Path
from typing import Any

import numpy as np

from pawnb.core.video.pictures import PictureFolder
from pawnb.core.video.tiff import ODD, n_pictures, opened


class PictureStack(PictureFolder):
    """The pictures of one TIFF file, in the order of the file.

    Parameters
    ----------
    path : str or Path
        The file.

    Raises
    ------
    VideoError
        If the first picture cannot be read.

    Notes
    -----
    As for :class:`pawnb.core.video.pictures.PictureFolder`; one thread reads at a time.
    """

    def __init__(self, path: str | Path) -> None:
        self._lock = threading.Lock()
        self._closing = contextlib.ExitStack()
        self._file: Any = self._closing.enter_context(opened(Path(path)))
        super().__init__(path)

    def again(self) -> PictureStack:
        """Open the file once more."""
        return PictureStack(self.name)

    def close(self) -> None:
        """Close the file."""
        self._closing.close()

    def _list(self, path: Path) -> list[Path]:
        """Return the file once for each of its pictures."""
        return [path] * n_pictures(path)

    def _pixels(self, index: int) -> np.ndarray | None:
        """Return a picture with its channels as OpenCV has them."""
        with self._lock, contextlib.suppress(*ODD):
            self._file.seek(index)
            mode = self._file.mode
            if mode.startswith(("L", "I", "F")) and mode != "LA":
                pixels = np.asarray(self._file)
                return pixels.astype(pixels.dtype.newbyteorder("="))
            picture = self._file.convert("L" if mode == "1" else "RGB")
            return np.asarray(picture)[..., ::-1] if mode != "1" else np.asarray(picture)
        return None
