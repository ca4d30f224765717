"""TIFF files: how many pictures they hold."""

from __future__ import annotations

import contextlib
import re
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from PIL import Image

from pawnb.errors import VideoError
from pawnb.files import check_file
from pawnb.input_warnings import hide_warnings_of

_DESCRIPTION = 270
_AXES = re.compile(r"^(channels|slices|frames)=(\d+)", re.MULTILINE)
ODD = (OSError, ValueError, SyntaxError, KeyError, TypeError, EOFError, struct.error,
        Image.DecompressionBombError)  # fmt: skip
"""What Pillow raises for damaged files."""


def n_pictures(path: Path) -> int:
    """Return how many pictures of one size a file holds; 1 for what is no TIFF.

    A second picture of another size is a thumbnail, and does not count.

    Raises
    ------
    VideoError
        If the list of pictures breaks off, ImageJ wrote some that are not in it, or they are
        those of several channels or slices.
    """
    if path.suffix.lower() not in (".tif", ".tiff"):
        return 1
    with contextlib.ExitStack() as closing:
        try:
            file = closing.enter_context(opened(path))
        except ODD:
            return 1  # of a kind that Pillow does not know
        told = str(file.tag_v2.get(_DESCRIPTION, ""))
        said = re.search(r"^images=(\d+)", told, re.MULTILINE)
        n = _count(file, path)
    if n == 1 and said and int(said[1]) > 1:
        raise VideoError(
            f"{path}: ImageJ wrote {said[1]} pictures into it in a way that other programs do not "
            "read (above 4 GB); save it as an image sequence there, and name the folder."
        )
    axes = [a for a in _AXES.findall(told) if int(a[1]) > 1]
    if n > 1 and len(axes) > 1:
        counted = ", ".join(f"{size} {axis}" for axis, size in axes)
        raise VideoError(
            f"{path}: a hyperstack of ImageJ ({counted}), of which neighbouring pictures are no "
            "frames that follow each other; save one channel and slice as a stack of its own "
            "(Image > Duplicate), and name that."
        )
    return n


def _count(file: Any, path: Path) -> int:
    """Go from picture to picture up to the end, or to one of another size."""
    n, size = 1, file.size
    try:
        while True:
            file.seek(n)
            if file.size != size:
                return n
            n += 1
    except EOFError:
        return n
    except ODD:
        raise VideoError(
            f"{path}: the list of its pictures breaks off after {n}; the file is cut short or "
            "damaged, copy it once more."
        ) from None


@contextlib.contextmanager
def opened(path: Path) -> Iterator[Any]:
    """Open a picture without a word about what is odd in it."""
    check_file(path, expected="a TIFF file", error=VideoError)
    hide_warnings_of("PIL")
    with Image.open(path) as file:
        yield file
