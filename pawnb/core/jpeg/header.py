"""The headers of a JPEG picture: what its entropy-coded bits mean (ITU-T T.81, annex B).

Only what cameras write as Motion JPEG is understood: baseline pictures of 8 bits, grey or
luma and two chromas, in one scan. For anything else there is None, and it is left to a whole
decoder.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from pawnb.arrays import IntArray
from pawnb.core.jpeg.standard_codes import STANDARD_CODES
from pawnb.core.jpeg.table_kernels import LOOKED_AT, Tables, fill_heads, fill_tables

_SOF0, _DHT, _SOI, _SOS, _DQT, _DRI = 0xC0, 0xC4, 0xD8, 0xDA, 0xDB, 0xDD
_APP0, _APP14, _LAST_APP, _COM = 0xE0, 0xEE, 0xEF, 0xFE
_MOST_BLOCKS = 10
"""Blocks in a unit (T.81, B.2.3)."""
_WRONG_CODE = 0xFF
"""In place of the name of a Huffman code that is wrong."""
_MOST_HEADER_BYTES = 2**19
"""A picture with longer headers is left to FFmpeg; those of cameras have less than 1 kB."""
_STUDIO_RANGE = b"CS=ITU601"
"""A comment by which FFmpeg takes the samples to be 16..235."""


@dataclass(frozen=True)
class JpegHeader:
    """What the headers of a picture say, ready for the loops.

    Parameters
    ----------
    width, height : int
        Size, px.
    unit : tuple of int
        Width and height of a unit of blocks, px.
    steps : tuple of int
        Luma pixels a chroma sample spans along u and along v.
    columns, rows : int
        Units across and down.
    interval : int
        Units between restart markers; as many as there are where there is no marker.
    blocks, tables, scales
        See :func:`~pawnb.core.jpeg.huffman_kernels.scan_units` and
        :func:`~pawnb.core.jpeg.huffman_kernels.read_units`.
    kind : bytes
        All that tells how the samples are to be shown.
    """

    width: int
    height: int
    unit: tuple[int, int]
    steps: tuple[int, int]
    columns: int
    rows: int
    interval: int
    blocks: IntArray
    tables: Tables
    scales: IntArray
    kind: bytes

    @property
    def n_planes(self) -> int:
        """One for grey, three for colour."""
        return len(self.scales)


@dataclass
class _Segments:
    """What the marker segments hold, as bytes."""

    frame: bytes = b""
    scan: bytes = b""
    codes: bytes = b""
    scales: bytes = b""
    kind: bytes = b""
    interval: int = 0


def header_length(data: bytes) -> int:
    """Return how many bytes come before the entropy-coded ones; 0 where that is not certain."""
    at = 2
    while data[at : at + 1] == b"\xff" and at + 4 <= len(data):
        end = at + 2 + int.from_bytes(data[at + 2 : at + 4], "big")
        if data[at + 1] == _SOS:
            return end if end < len(data) else 0
        at = end
    return 0


@functools.lru_cache(maxsize=32)
def read_plan(header: bytes) -> JpegHeader | None:
    """Read the headers of a picture.

    Parameters
    ----------
    header : bytes
        The picture's bytes from its beginning up to the entropy-coded ones.

    Returns
    -------
    JpegHeader or None
        None where the picture is of a sort that is not understood here, or wrong.
    """
    segments = _segments(header) if len(header) <= _MOST_HEADER_BYTES else None
    if segments is None or len(segments.frame) < 6 or not segments.scan:
        return None
    parts = _components(segments)
    scales = _scales(segments.scales)
    if parts is None or any(part[3] not in scales for part in parts):
        return None
    pairs = [(part[4], 16 + part[5]) for part in parts]
    codes = _codes(segments.codes or STANDARD_CODES, tuple(dict.fromkeys(pairs)))
    if codes is None:
        return None
    which, tables = codes
    (_, across, down, *_), (_, few, low, *_) = parts[0], parts[-1]
    blocks = [
        (c, *which[pairs[c]], i, j)
        for c, (_, h, v, *_) in enumerate(parts)
        for j in range(v)
        for i in range(h)
    ]
    height, width = (int.from_bytes(segments.frame[i : i + 2], "big") for i in (1, 3))
    if len(blocks) > _MOST_BLOCKS or min(width, height) < 1:
        return None
    columns, rows = -(-width // (8 * across)), -(-height // (8 * down))
    return JpegHeader(
        width, height, (8 * across, 8 * down), (across // few, down // low), columns, rows,
        segments.interval or columns * rows, np.array(blocks, np.int64), tables,
        np.stack([scales[part[3]] for part in parts]), segments.kind,
    )  # fmt: skip


def _segments(header: bytes) -> _Segments | None:
    """Take the headers apart; None where there is something that is not understood."""
    if header[:2] != bytes((0xFF, _SOI)):
        return None
    found = _Segments()
    at = 2
    while at < len(header):
        marker = header[at + 1]
        end = at + 2 + int.from_bytes(header[at + 2 : at + 4], "big")
        body = header[at + 4 : end]
        at = end
        if marker == _SOF0 and not found.frame:
            found.frame = body
        elif marker == _SOS:
            found.scan = body
        elif marker == _DHT:
            found.codes += body
        elif marker == _DQT:
            found.scales += body
        elif marker == _DRI:
            found.interval = int.from_bytes(body[:2], "big")
        elif not (_APP0 <= marker <= _LAST_APP or marker == _COM):
            return None
        shown = marker in (_SOF0, _APP0, _APP14) or body.startswith(_STUDIO_RANGE)
        found.kind += bytes((marker,)) + body if shown else b""
    return found


def _components(segments: _Segments) -> list[tuple[int, int, int, int, int, int]] | None:
    """Return name, blocks across and down, scale, DC and AC code of every component."""
    frame, scan = segments.frame, segments.scan
    n = frame[5]
    if frame[0] != 8 or n not in (1, 3) or len(frame) != 6 + 3 * n or len(scan) != 4 + 2 * n:
        return None
    # a baseline scan of all components: everything else is progressive, or several scans
    if scan[0] != n or scan[1 + 2 * n :] != b"\x00\x3f\x00":
        return None
    parts = []
    for c in range(n):
        name, sampling, scale = frame[6 + 3 * c : 9 + 3 * c]
        if scan[1 + 2 * c] != name:
            return None
        dc, ac = divmod(scan[2 + 2 * c], 16)
        parts.append((name, sampling >> 4, sampling & 15, scale, dc, ac))
    most, least = parts[0][1:3], parts[-1][1:3]
    if n == 1:
        return parts if most == (1, 1) else None
    if (
        parts[1][1:3] != least
        or not all(most + least)
        or any(a % b for a, b in zip(most, least, strict=True))
    ):
        return None
    return parts


def _scales(body: bytes) -> dict[int, np.ndarray]:
    """Return place and scale (64, 2) of the coefficients of each quantisation table."""
    found = {}
    while len(body) >= 65 and body[0] < 4:  # 16-bit tables are not for 8-bit pictures
        scale = np.frombuffer(body, np.uint8, 64, 1)
        found[body[0]] = np.column_stack([_places(), scale]).astype(np.int32)
        body = body[65:]
    return {} if body else found


@functools.cache
def _places() -> IntArray:
    """Return where each coefficient of the zigzag (T.81, fig. 5) lies, row by row."""
    v, u = np.divmod(np.arange(64), 8)
    # along each diagonal, upwards on even ones and downwards on odd ones
    order = np.lexsort((np.where((u + v) % 2, v, u), u + v))
    return np.asarray((8 * v + u)[order])


@functools.lru_cache(maxsize=8)
def _codes(
    body: bytes, pairs: tuple[tuple[int, int], ...]
) -> tuple[dict[tuple[int, int], tuple[int, int, int]], Tables] | None:
    """Return the rows of each pair of DC and AC code in the tables, and the tables.

    AC codes are 16 + their number. A pair has a row for its DC code, for its AC code and for
    the two together; None where a code is wrong or lacking.
    """
    # a code may be defined again, any number of times: what counts is the last
    last = {name: (name, counts, symbols) for name, counts, symbols in _listed(body)}
    names = dict.fromkeys(name for pair in pairs for name in pair)
    if _WRONG_CODE in last or any(name not in last for name in names):
        return None
    listed = [last[name] for name in names]
    which = {name: row for row, name in enumerate(names)}
    n, size = len(listed), 1 << LOOKED_AT
    one, several = np.zeros((n, size), np.uint16), np.zeros((n, size), np.uint16)
    whole, heads = np.zeros((n, size), np.int32), np.zeros((len(pairs), size), np.int32)
    ends, offsets = np.zeros((n, 17), np.int64), np.zeros((n, 17), np.int64)
    values = np.zeros((n, 256), np.uint8)
    for row, (name, counts, symbols) in enumerate(listed):
        values[row, : len(symbols)] = symbols
        if not fill_tables(
            counts, values[row], one[row], whole[row], several[row], ends[row], offsets[row],
            name >= 16,
        ):  # fmt: skip
            return None
    for row, (dc, ac) in enumerate(pairs):
        fill_heads(whole[which[dc]], whole[which[ac]], heads[row])
    rows = {(dc, ac): (which[dc], which[ac], row) for row, (dc, ac) in enumerate(pairs)}
    return rows, (one, whole, several, ends, offsets, values, heads)


def _listed(body: bytes) -> Iterator[tuple[int, np.ndarray, np.ndarray]]:
    """Yield name, numbers of codes by length, and symbols of every code; a wrong one ends it."""
    at = 0
    while at < len(body):
        name = body[at]
        counts = np.frombuffer(body[at : at + 17].ljust(17, b"\x00"), np.uint8).astype(np.int64)
        counts[0] = 0
        n = int(counts.sum())
        if len(body) < at + 17 + n or n > 256 or name & 0xEC:
            yield _WRONG_CODE, counts, counts
            return
        yield name, counts, np.frombuffer(body, np.uint8, n, at + 17)
        at += 17 + n
