"""Detections kept while they are found, so that no frame is decoded twice.

A store holds the detections of consecutive frames, in memory and, where it has a path, in
a file that grows frame by frame. Its key is a checksum of all that they depend on: what
was filmed, the first frame, how and where is searched, and the code that does it. A run
that asks with the same key goes on where the last one ended; any other key starts it anew.

The file is a :class:`pawnb.core.checkpoint.RecordFile` with one record a frame: the number of
detections of each view (uint16) and the detections (float32, 8 each).
"""

from __future__ import annotations

import dataclasses
import hashlib
from pathlib import Path
from typing import Any

import numpy as np

from pawnb.core.checkpoint import RecordFile, code_checksum
from pawnb.core.closing import Closing
from pawnb.core.parameters import values_in_force
from pawnb.core.paws.offline.detection.colour.detections import N_COLUMNS, ColourDetections, InViews
from pawnb.core.paws.offline.detection.colour_parameters import COLOUR

_FIRST_LINE = "pawnb candidates 1 {key}"
_CODE_OF_COLOUR = (
    "photometry/background.py",
    "blob_detection.py",
    "colour_model.py",
    "photometry/colour_quantisation.py",
    "detections.py",
    "detector.py",
    "detector_kernels.py",
    "photometry/illumination.py",
    "scan.py",
)


class DetectionCache(Closing):
    """Detections of consecutive frames; a context manager.

    Parameters
    ----------
    path : Path, optional
        The file. Without it detections are kept in memory only.
    source : str
        What was filmed: changes whenever a picture of any view may.
    """

    def __init__(self, path: Path | None = None, *, source: str = "") -> None:
        self.path, self.source = path, source
        self._key = ""
        self._found: list[list[ColourDetections]] = []
        self._file: RecordFile | None = None
        self._remembered: tuple[str, Any] = ("", None)

    def remember(self, key: str, what: Any) -> None:
        """Keep, in memory and in place of the last one, what detections were found by."""
        self._remembered = key, what

    def recall(self, key: str) -> Any:
        """Return what was kept under the same key, or None."""
        return self._remembered[1] if self._remembered[0] == key else None

    def begin(self, n_views: int, *depends_on: Any) -> list[list[ColourDetections]]:
        """Return the detections that are there already, and get ready for more.

        Parameters
        ----------
        n_views : int
            Number of views.
        *depends_on
            All that the detections depend on besides the source: numbers, text, arrays,
            and lists and dataclasses of these.

        Returns
        -------
        list of list of ColourDetections
            For each frame in turn, the detections of each view.

        Raises
        ------
        InputError
            If the file cannot be read or written.
        """
        digest = hashlib.sha256()
        code = code_checksum("pawnb.core.paws.offline.detection.colour", _CODE_OF_COLOUR)
        how = repr(values_in_force(COLOUR))
        for item in (code, how, self.source, n_views, *depends_on):
            _feed(digest, item)
        key = digest.hexdigest()
        if key != self._key:
            self.close()
            self._key, self._found = key, []
            if self.path is not None:
                self._file = RecordFile(self.path, _FIRST_LINE.format(key=key))
                self._found = [_detections(record, n_views) for record in self._file.take_records()]
        return list(self._found)

    def add(self, detections: InViews) -> None:
        """Keep the detections of the next frame."""
        self._found.append(list(detections))
        if self._file is not None:
            numbers = np.array([len(one) for one in detections], "<u2")
            self._file.append(
                numbers.tobytes()
                + b"".join(np.ascontiguousarray(one.table, "<f4").tobytes() for one in detections)
            )

    def close(self) -> None:
        """Close the file; what is in memory can still be used."""
        if self._file is not None:
            self._file.close()


def _detections(record: bytes, n_views: int) -> list[ColourDetections]:
    """Return the detections of each view that a record holds."""
    numbers = np.frombuffer(record, "<u2", n_views)
    rows = np.frombuffer(record, "<f4", offset=numbers.nbytes).reshape(-1, N_COLUMNS)
    parts = np.split(rows.astype(np.float32), np.cumsum(numbers)[:-1])
    return [ColourDetections(part) for part in parts]


def _feed(digest: hashlib._Hash, item: Any) -> None:
    """Feed a value to a checksum, with its kind and shape."""
    if dataclasses.is_dataclass(item):
        digest.update(type(item).__name__.encode())
        for field in dataclasses.fields(item):
            _feed(digest, getattr(item, field.name))
    elif isinstance(item, np.ndarray):
        digest.update(f"{item.dtype.str}{item.shape}".encode())
        digest.update(np.ascontiguousarray(item).tobytes())
    elif isinstance(item, (list, tuple)):
        digest.update(f"[{len(item)}".encode())
        for part in item:
            _feed(digest, part)
    else:
        digest.update(f"{item!r};".encode())
