"""Compiled loops from the bits of JPEG blocks to planes of samples.

The inverse transform is that of FFmpeg's ``simple_idct`` (Michael Niedermayer): two passes
of integers, cut to 11 and 20 binary digits. A part that is decoded here is therefore the
same, bit for bit, as that part of the picture decoded by FFmpeg. Sixteen blocks that lie
side by side are transformed at once, coefficient by coefficient: what is done for all of
them alike is what processors have wide instructions for.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from pawnb.core.compiled import compiled
from pawnb.core.jpeg.huffman_kernels import LANES, read_units
from pawnb.core.jpeg.table_kernels import Tables

_LANES_OF_BLOCK = 64 * LANES
STRIP_PX = 8 * LANES
"""Width of what is transformed at once, px."""
_LANES_OF_ROW = 8 * LANES
# round(cos(i pi / 16) sqrt(2) 2^14), less 1 for the fourth, as in FFmpeg
_W1, _W2, _W3, _W4, _W5, _W6, _W7 = 22725, 21407, 19266, 16383, 12873, 8867, 4520
_CUT_ROWS, _CUT_COLUMNS = 11, 20
_HALF_ROWS = 1 << (_CUT_ROWS - 1)
_HALF_COLUMNS = (1 << (_CUT_COLUMNS - 1)) // _W4


@compiled
def decode_units(
    words: np.ndarray,
    begins: np.ndarray,
    levels: np.ndarray,
    blocks: np.ndarray,
    tables: Tables,
    scales: np.ndarray,
    box: tuple[int, int, int, int],
    columns: int,
    planes: tuple[np.ndarray, np.ndarray, np.ndarray],
) -> None:
    """Decode a rectangle of units into planes.

    Parameters
    ----------
    words, begins, levels, blocks, tables
        As of :func:`~pawnb.core.jpeg.huffman_kernels.scan_units`.
    scales : ndarray of int32, shape (components, 64, 2)
        See :func:`~pawnb.core.jpeg.huffman_kernels.read_units`.
    box : tuple of int
        Column and row of the first unit, and of the one after the last.
    columns : int
        Units in a row of the picture.
    planes : tuple of ndarray, shape (h, w), uint8
        To be filled, with whole units and on the right whole strips of ``STRIP_PX``: three, of
        which the last two stay as they are in a grey picture.
    """
    left, top, right, bottom = box
    n = levels.shape[1]
    across, down, strips = _arrangement(blocks, n, right - left)
    coefficients = np.zeros(strips[n] * _LANES_OF_BLOCK, np.int16)
    middle, samples = np.zeros(_LANES_OF_BLOCK, np.int16), np.zeros(_LANES_OF_BLOCK, np.uint8)
    a_row = (strips[1:] - strips[:-1]) // down
    lanes = np.zeros((len(blocks), 2), np.int64)
    for b in range(len(blocks)):
        c = blocks[b, 0]
        lanes[b, 0] = LANES * (strips[c] + blocks[b, 5] * a_row[c]) + blocks[b, 4]
        lanes[b, 1] = across[c]
    for row in range(top, bottom):
        coefficients[:] = 0
        part = slice(row * columns + left, row * columns + right)
        read_units(
            words, begins[part], levels[part], blocks, tables, scales, lanes, coefficients
        )  # fmt: skip
        for c in range(n):
            for s in range(strips[c + 1] - strips[c]):
                at = (strips[c] + s) * _LANES_OF_BLOCK
                _transform_rows(coefficients[at : at + _LANES_OF_BLOCK], middle)
                _transform_columns(middle, samples)
                v, u = divmod(s, a_row[c])
                _put(samples, planes[c], 8 * ((row - top) * down[c] + v), STRIP_PX * u)


@compiled
def _arrangement(
    blocks: np.ndarray, n: int, units: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return blocks across and down in a unit, and the first strip, of each component.

    Each row of blocks of a component is cut into strips of LANES blocks.
    """
    across, down, strips = np.ones(n, np.int64), np.ones(n, np.int64), np.zeros(n + 1, np.int64)
    for b in range(len(blocks)):
        across[blocks[b, 0]] = blocks[b, 4] + 1
        down[blocks[b, 0]] = blocks[b, 5] + 1
    for c in range(n):
        strips[c + 1] = strips[c] + down[c] * ((units * across[c] + LANES - 1) // LANES)
    return across, down, strips


@compiled
def _evens(a: Any, x2: Any, x4: Any, x6: Any) -> tuple[Any, Any, Any, Any]:
    """Return the even parts of a transform of eight numbers."""
    return (
        np.int32(a + _W2 * x2 + _W4 * x4 + _W6 * x6),
        np.int32(a + _W6 * x2 - _W4 * x4 - _W2 * x6),
        np.int32(a - _W6 * x2 - _W4 * x4 + _W2 * x6),
        np.int32(a - _W2 * x2 + _W4 * x4 - _W6 * x6),
    )


@compiled
def _odds(x1: Any, x3: Any, x5: Any, x7: Any) -> tuple[Any, Any, Any, Any]:
    """Return the odd parts of a transform of eight numbers."""
    return (
        np.int32(_W1 * x1 + _W3 * x3 + _W5 * x5 + _W7 * x7),
        np.int32(_W3 * x1 - _W7 * x3 - _W1 * x5 - _W5 * x7),
        np.int32(_W5 * x1 - _W1 * x3 + _W7 * x5 + _W3 * x7),
        np.int32(_W7 * x1 - _W5 * x3 + _W3 * x5 - _W1 * x7),
    )


@compiled
def _transform_rows(x: np.ndarray, middle: np.ndarray) -> None:
    """Transform the rows of coefficients of LANES blocks."""
    for row in range(8):
        k = row * _LANES_OF_ROW
        for n in range(k, k + LANES):
            x0, x1 = np.int32(x[n]), np.int32(x[n + LANES])
            x2, x3 = np.int32(x[n + 2 * LANES]), np.int32(x[n + 3 * LANES])
            x4, x5 = np.int32(x[n + 4 * LANES]), np.int32(x[n + 5 * LANES])
            x6, x7 = np.int32(x[n + 6 * LANES]), np.int32(x[n + 7 * LANES])
            # a row of one level is 8 times that level, not 16383 / 2048 times
            flat = (x1 | x2 | x3 | x4 | x5 | x6 | x7) == 0
            a = np.int32(x0 << (_CUT_ROWS + 3)) if flat else np.int32(_W4 * x0 + _HALF_ROWS)
            a0, a1, a2, a3 = _evens(a, x2, x4, x6)
            b0, b1, b2, b3 = _odds(x1, x3, x5, x7)
            middle[n] = np.int32(a0 + b0) >> _CUT_ROWS
            middle[n + LANES] = np.int32(a1 + b1) >> _CUT_ROWS
            middle[n + 2 * LANES] = np.int32(a2 + b2) >> _CUT_ROWS
            middle[n + 3 * LANES] = np.int32(a3 + b3) >> _CUT_ROWS
            middle[n + 4 * LANES] = np.int32(a3 - b3) >> _CUT_ROWS
            middle[n + 5 * LANES] = np.int32(a2 - b2) >> _CUT_ROWS
            middle[n + 6 * LANES] = np.int32(a1 - b1) >> _CUT_ROWS
            middle[n + 7 * LANES] = np.int32(a0 - b0) >> _CUT_ROWS


@compiled
def _transform_columns(x: np.ndarray, samples: np.ndarray) -> None:
    """Transform the columns of LANES blocks to samples in the same order."""
    for column in range(8):
        k = column * LANES
        for n in range(k, k + LANES):
            x0, x1 = np.int32(x[n]), np.int32(x[n + _LANES_OF_ROW])
            x2, x3 = np.int32(x[n + 2 * _LANES_OF_ROW]), np.int32(x[n + 3 * _LANES_OF_ROW])
            x4, x5 = np.int32(x[n + 4 * _LANES_OF_ROW]), np.int32(x[n + 5 * _LANES_OF_ROW])
            x6, x7 = np.int32(x[n + 6 * _LANES_OF_ROW]), np.int32(x[n + 7 * _LANES_OF_ROW])
            a = np.int32(_W4 * np.int32(x0 + _HALF_COLUMNS))
            a0, a1, a2, a3 = _evens(a, x2, x4, x6)
            b0, b1, b2, b3 = _odds(x1, x3, x5, x7)
            samples[n] = _sample(np.int32(a0 + b0))
            samples[n + _LANES_OF_ROW] = _sample(np.int32(a1 + b1))
            samples[n + 2 * _LANES_OF_ROW] = _sample(np.int32(a2 + b2))
            samples[n + 3 * _LANES_OF_ROW] = _sample(np.int32(a3 + b3))
            samples[n + 4 * _LANES_OF_ROW] = _sample(np.int32(a3 - b3))
            samples[n + 5 * _LANES_OF_ROW] = _sample(np.int32(a2 - b2))
            samples[n + 6 * _LANES_OF_ROW] = _sample(np.int32(a1 - b1))
            samples[n + 7 * _LANES_OF_ROW] = _sample(np.int32(a0 - b0))


@compiled
def _sample(value: Any) -> Any:
    """Return a transformed number as a sample, 0 to 255."""
    return np.uint8(min(max(np.int32(value >> _CUT_COLUMNS), np.int32(0)), np.int32(255)))


@compiled
def _put(samples: np.ndarray, plane: np.ndarray, top: int, left: int) -> None:
    """Put the samples of LANES blocks side by side into a plane.

    How many is the same each time: then processors have wide instructions for it, at a
    fifteenth of the time.
    """
    for v in range(8):
        row = plane[top + v, left : left + STRIP_PX]
        for n in range(LANES):
            for u in range(8):
                row[8 * n + u] = samples[v * _LANES_OF_ROW + u * LANES + n]
