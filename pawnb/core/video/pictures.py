"""Folders and globs of pictures, read as if they were a video."""

from __future__ import annotations

import contextlib
import glob
import re
from collections import defaultdict
from pathlib import Path

import cv2
import numpy as np
from PIL import Image

from pawnb.arrays import IntArray
from pawnb.core.pixels.colour import GreyPicture, PackedPicture, Picture
from pawnb.core.video.tiff import ODD, n_pictures
from pawnb.errors import VideoError
from pawnb.files import read_bytes
from pawnb.input_warnings import hide_warnings_of

SUFFIXES = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp")


def is_glob(name: str) -> bool:
    """Tell whether a path holds wildcards."""
    return any(c in name for c in "*?[")


def is_animated(path: Path) -> bool:
    """Tell whether a file is a PNG of several pictures: a film, by its chunk of animation."""
    if path.suffix.lower() != ".png" or not path.is_file():
        return False
    with path.open("rb") as file:
        head = file.read(_HEAD_BYTES)
    return head.startswith(b"\x89PNG") and b"acTL" in head.partition(b"IDAT")[0]


def _pattern(path: Path) -> str:
    """Return a glob in which only what is no folder that exists is a pattern."""
    folder = next(parent for parent in path.parents if parent.is_dir())
    return str(Path(glob.escape(str(folder))) / path.relative_to(folder))


def natural_key(name: str) -> tuple[tuple[str, int, str], ...]:
    """Return a sort key under which frame2 comes before frame10."""
    parts = re.findall(r"(\D*)(\d*)", name)
    return tuple((text.casefold(), int(number or -1), text) for text, number in parts)


_STORED_BITS, _CAMERA_BITS = 16, (10, 12, 14)
"""Of a pixel: those stored, and those that cameras fill, from the lowest on."""

_HEAD_BYTES = 65536
"""Of a PNG, in which it is said before the first picture whether more follow."""

_LOOKED_AT = 9
"""Pictures, over all of the recording, in which it is looked how many bits are in use."""

_ORIENTATION = 0x0112
"""Tag of EXIF: 1 is as it lies, 2 to 8 turned or mirrored."""


class PictureFolder:
    """Numbered pictures in a folder, in the order of their numbers.

    Parameters
    ----------
    path : str or Path
        A folder, or a glob such as ``frames/left_*.png``.

    Attributes
    ----------
    n_frames, width, height : int
        Number and size of the pictures, px.
    is_colour : bool
        Whether the first picture is in colour.
    stamps_s, filmed_fps : None
        Pictures carry no time.
    frame_bytes : ndarray of int, shape (n_frames,)
        Bytes of the file of each.
    is_variable_rate : bool
        False.
    notes : list of str
        What a user should know, in plain sentences.

    Raises
    ------
    VideoError
        If there is no picture, if a number is missing, or if the folder holds several
        series.

    Notes
    -----
    Frame 0 is the picture with the lowest number. Reading keeps no state, so any
    number of threads may read at once. 16-bit pictures keep their upper 8 bits, and where only
    10, 12 or 14 bits are in use, the upper 8 of these.
    """

    def __init__(self, path: str | Path) -> None:
        self.name = str(path)
        self.notes: list[str] = []
        self._files = self._list(Path(path))
        self.n_frames = len(self._files)
        self.notes += _turn_notes(self._files[0])
        self._bits = self._bits_in_use()
        first = self._load(0)
        self.width, self.height = first.width, first.height
        self.is_colour = first.is_colour
        self.stamps_s: np.ndarray | None = None
        self.filmed_fps: float | None = None
        self.frame_bytes: IntArray | None = np.array([path.stat().st_size for path in self._files])
        self.is_variable_rate = False

    def grab(self, index: int, *, partly: bool = False) -> Picture:  # noqa: ARG002
        """Return a picture, decoded whole; raises VideoError where it cannot be read."""
        picture = self._load(index)
        if (picture.width, picture.height) != (self.width, self.height):
            raise VideoError(
                f"{self._files[index]}: frame {index} is {picture.width} x {picture.height} px, "
                f"but frame 0 is {self.width} x {self.height}; all must be of one size."
            )
        if picture.is_colour != self.is_colour:
            kinds = ("grey", "in colour")
            raise VideoError(
                f"{self._files[index]}: frame {index} is {kinds[picture.is_colour]}, but frame 0 "
                f"is {kinds[self.is_colour]}; all must be of one kind."
            )
        return picture

    def again(self) -> PictureFolder:
        """Return this: reading keeps no state."""
        return self

    def close(self) -> None:
        """Do nothing: no file is kept open."""

    def _list(self, path: Path) -> list[Path]:
        """List the pictures in order and check that none is missing."""
        # not Path.glob: the pattern may be absolute
        names = path.iterdir() if path.is_dir() else map(Path, glob.glob(_pattern(path)))  # noqa: PTH207
        found = [p for p in names if p.suffix.lower() in SUFFIXES and not p.name.startswith(".")]
        if not found:
            raise VideoError(
                f"{self.name}: no pictures there; expected files that end in {', '.join(SUFFIXES)}."
            )
        found.sort(key=lambda p: natural_key(str(p)))
        n = n_pictures(found[0])
        if n > 1:
            raise VideoError(
                f"{found[0]} holds {n} pictures; expected one a file in a folder or glob. Name the "
                "file itself as the video."
            )
        return self._series(found)

    def _series(self, files: list[Path]) -> list[Path]:
        """Keep the one numbered series; refuse several, and refuse gaps."""
        series: dict[tuple[str, ...], list[Path]] = defaultdict(list)
        for file in files:
            series[tuple(re.split(r"\d+", str(file)))].append(file)
        numbered = {key: group for key, group in series.items() if len(group) > 1}
        if len(numbered) > 1:
            names = " and ".join(group[0].name for group in list(numbered.values())[:2])
            raise VideoError(
                f"{self.name}: several series of pictures ({names}, ...); name one by a glob, "
                'for instance video = "frames/cam1_*.png".'
            )
        if not numbered:
            return files
        (kept,) = numbered.values()
        left_out = [file.name for file in files if file not in kept]
        if left_out:
            self.notes.append(
                f"{self.name}: {', '.join(left_out)} is not part of the numbered series and is "
                "left out."
            )
        self._check_numbers(kept)
        return kept

    def _check_numbers(self, files: list[Path]) -> None:
        """Raise VideoError where the numbers repeat or one is missing."""
        numbers = np.array([[int(d) for d in re.findall(r"\d+", str(f))] for f in files])
        varying = np.flatnonzero((numbers != numbers[0]).any(axis=0))
        last = numbers[:, varying[-1]] if len(varying) else np.zeros(len(files), int)
        if len(np.unique(last)) < len(last):
            raise VideoError(
                f"{self.name}: two pictures have the same number "
                f"({files[0].name}, ...), as if there were several series; name one by a glob, "
                'for instance video = "frames/cam1_*.png".'
            )
        gaps = [np.flatnonzero(s != s.min()) for s in _steps_of_counters(numbers[:, varying])]
        # a clock beside the counter may jump: what is complete by one of them lacks nothing
        if gaps and all(map(len, gaps)):
            at = int(gaps[-1][0])
            raise VideoError(
                f"{self.name}: frame {at + 1} is missing, between {files[at].name} and "
                f"{files[at + 1].name}; put the picture back or number the pictures without a gap."
            )

    def _bits_in_use(self) -> int:
        """Return of how many bits the upper 8 are kept: fewer where some pictures have no more."""
        brightest = 0
        for index in np.unique(np.linspace(0, self.n_frames - 1, _LOOKED_AT).astype(int)):
            pixels = None
            with contextlib.suppress(VideoError):  # it is told when that picture is asked for
                pixels = self._pixels(int(index))
            if pixels is None:
                continue
            if pixels.dtype != np.uint16:
                return _STORED_BITS
            brightest = max(brightest, int(pixels.max()))
        bits = next((b for b in _CAMERA_BITS if 0 < brightest < 1 << b), _STORED_BITS)
        if bits < _STORED_BITS:
            self.notes.append(
                f"{self.name}: of the {_STORED_BITS} bits a pixel of its pictures no more than "
                f"{bits} are in use (brightest {brightest}); these are shown."
            )
        return bits

    def _pixels(self, index: int) -> np.ndarray | None:
        """Read one file: (H, W) or (H, W, 3 or 4) blue, green, red; None where it is damaged."""
        file = self._files[index]
        data = read_bytes(file, expected=f"the picture of frame {index}", error=VideoError)
        if data and _is_whole(data):
            # not cv2.imread: it cannot open names outside ASCII on Windows
            with contextlib.suppress(cv2.error):  # it says that it is larger than a picture can be
                return cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
        return None

    def _load(self, index: int) -> Picture:
        """Read and decode one picture."""
        file, pixels = self._files[index], self._pixels(index)
        if pixels is None:
            raise VideoError(
                f"{file}: frame {index} cannot be read as a picture; the file is damaged, cut "
                "short or of another kind."
            )
        if pixels.dtype == np.uint16:
            pixels = np.minimum(np.right_shift(pixels, self._bits - 8), 255).astype(np.uint8)
        if pixels.dtype != np.uint8:
            raise VideoError(
                f"{file}: frame {index} has pixels of type {pixels.dtype}; expected whole numbers "
                "of 8 or 16 bits."
            )
        if pixels.ndim == 2:
            return GreyPicture(pixels)
        return PackedPicture(pixels, (2, 1, 0))


def _steps_of_counters(numbers: IntArray) -> list[IntArray]:
    """Return the steps of those numbers in names that count pictures, not those of a clock.

    ``numbers`` (n_pictures, n_numbers) are those that differ. One alone is taken to count.
    """
    found = list(np.diff(numbers, axis=0).T)
    if len(found) == 1:
        return found
    rising = [steps for steps in found if len(steps) and steps.min() > 0]
    return [s for s in rising if not (s % s.min()).any() and np.median(s) == s.min()]


def _turn_notes(file: Path) -> list[str]:
    """Say that a picture is used as it lies in the file where it asks to be shown in another way.

    Cameras are calibrated in the pixels of their sensor, so a still is never turned; films are, as
    players show them.
    """
    if file.suffix.lower() not in (".jpg", ".jpeg"):
        return []  # of cameras and phones
    hide_warnings_of("PIL")  # of what else is odd in a picture it is told elsewhere
    with contextlib.suppress(*ODD), Image.open(file) as picture:
        asked = picture.getexif().get(_ORIENTATION, 1)
        if asked in range(2, 9):
            return [
                f"{file} asks to be shown turned or mirrored (EXIF orientation {asked}): "
                "pictures are used as they lie in the file, films as players show them. Where the "
                "one calibrates the other, save the pictures upright first."
            ]
    return []


def _is_whole(data: bytes) -> bool:
    """Tell whether a file ends as its kind should: cv2 fills what is cut off with grey."""
    if data.startswith(b"\xff\xd8"):
        return b"\xff\xd9" in data[-4096:]
    if data.startswith(b"\x89PNG"):
        return b"IEND" in data[-4096:]
    if data.startswith(b"BM"):
        return len(data) >= int.from_bytes(data[2:6], "little")
    return True
