"""Compiled loops over the entropy-coded bits of a baseline JPEG picture.

What a bit means is not known without reading all bits before it. So a picture is
read through once, as quickly as that can be done when coefficients are not wanted: several
symbols at one look into a table. What is kept is where each unit of blocks begins and the
mean levels there; from then on any unit can be decoded by itself.

Bits are looked at through a window of 64, the next one at its upper end. It is moved on where
fewer than ``LOOKED_AT`` are left in it, and before a symbol that the tables do not tell: with
its value it has up to 27 bits. What counts bits has no sign: an index that may be negative is
tested each time.
"""

from __future__ import annotations

import sys
from typing import Any

import numpy as np

from pawnb.core.compiled import compiled
from pawnb.core.jpeg.table_kernels import LOOKED_AT, MOST_AC, MOST_DC, Tables

LANE_BITS = 4
LANES = 1 << LANE_BITS
"""Blocks whose coefficients lie side by side, to be transformed at once."""
MOST_BITS = 27
"""Most bits of a symbol with its value in 8-bit pictures: a code of 16, a value of 11."""
_DOWN = np.uint64(64 - LOOKED_AT)
_LAST = np.uint64(64 - LOOKED_AT)
_0, _1, _3, _6, _8, _63, _64 = (np.uint64(n) for n in (0, 1, 3, 6, 8, 63, 64))
_RST, _EOI = 0xD0, 0xD9
_GREY_DC = 1024
"""DC of a block of 128: samples are coded as differences from it (T.81, A.3.1)."""
_LITTLE = sys.byteorder == "little"
_ONES, _HIGHS = np.uint64(0x0101010101010101), np.uint64(0x8080808080808080)
_BYTE = np.uint64(255)


@compiled
def _long(
    bits: Any,
    row: int,
    is_ac: bool,
    one: np.ndarray,
    ends: np.ndarray,
    offsets: np.ndarray,
    values: np.ndarray,
) -> Any:
    """Return what ``whole`` would say of the symbol at the upper end of ``bits``; 0 for none."""
    entry = np.int64(one[row, bits >> _DOWN])
    if entry == 0:
        for n in range(LOOKED_AT + 1, 17):
            code = np.int64(bits >> np.uint64(64 - n))
            if code < ends[row, n]:
                entry = np.int64(values[row, code + offsets[row, n]]) * 256 + n
                break
    symbol, length = entry >> 8, entry & 255
    size, run = (symbol & 15, symbol >> 4) if is_ac else (symbol, 0)
    if length == 0 or size > (MOST_AC if is_ac else MOST_DC) or (size == 0 and 0 < run < 15):
        return 0
    # T.81, F.2.2.1, EXTEND
    value = np.int64(bits << np.uint64(length) >> _1 >> np.uint64(63 - size))
    value = value if 2 * value >= 1 << size else value - (1 << size) + 1
    passed = 0 if is_ac and symbol == 0 else run + 1
    return value * 65536 + passed * 256 + length + size


@compiled
def take_words(
    data: np.ndarray, eights: np.ndarray, begin: int, words: np.ndarray, restarts: np.ndarray
) -> int:
    """Take the entropy-coded bits out of a picture's bytes (ITU-T T.81, B.1.1.5).

    Parameters
    ----------
    data : ndarray of uint8
        The picture.
    eights : ndarray of uint64
        The same, eight bytes a number.
    begin : int
        Where its entropy-coded bytes begin.
    words : ndarray of uint64
        To be filled with their bits, the first at the upper end, without the zero that follows
        each 255 and without markers; after the last there are zeros up to the end of its word.
        No shorter than ``eights``, and one more.
    restarts : ndarray of int32
        To be filled: how many bytes come before each restart marker.

    Returns
    -------
    int
        How many bytes there are up to the marker that ends the picture; -1 where another
        marker or the end of the data comes first, or there are other restart markers.
    """
    n_restarts = 0
    n_words: Any = 0
    bits = _0  # of a word that is not full
    held = _0
    at = begin
    while at < len(data) - 1:
        if at & 7 == 0 and at + 8 < len(data):
            eight = _in_order(eights[at >> 3])
            # no byte is 255: none of the others' is 0
            if (~eight - _ONES) & eight & _HIGHS == 0:
                words[n_words] = bits | (eight >> held)
                bits = eight << _1 << (_63 - held)
                n_words += 1
                at += 8
                continue
        byte = data[at]
        at += 1
        if byte == 255:
            marker = data[at]
            at += 1
            if marker == _RST + (n_restarts & 7) and n_restarts < len(restarts):
                restarts[n_restarts] = 8 * n_words + np.int64(held >> _3)
                n_restarts += 1
                continue
            if marker != 0:
                words[n_words] = bits
                n = 8 * n_words + np.int64(held >> _3)
                return n if marker == _EOI and n_restarts == len(restarts) else -1
        held += _8
        bits |= np.uint64(byte) << (_64 - held)
        if held == _64:
            words[n_words] = bits
            n_words += 1
            bits = held = _0
    return -1


@compiled
def _in_order(eight: Any) -> Any:
    """Return eight bytes with the first at the upper end."""
    if not _LITTLE:
        return eight
    out = _0
    for n in range(8):
        out |= ((eight >> np.uint64(8 * n)) & _BYTE) << np.uint64(56 - 8 * n)
    return out


@compiled
def _window(words: np.ndarray, at: Any) -> Any:
    """Return the 64 bits from one on, the first at the upper end."""
    word, low = at >> _6, at & _63
    return (words[word] << low) | (words[word + _1] >> _1 >> (_63 - low))


@compiled
def scan_units(  # noqa: C901
    words: np.ndarray,
    n_bits: int,
    interval: int,
    restarts: np.ndarray,
    blocks: np.ndarray,
    tables: Tables,
    begins: np.ndarray,
    levels: np.ndarray,
) -> bool:
    """Read through a picture and note where its units of blocks begin.

    Parameters
    ----------
    words : ndarray of uint64
        The entropy-coded bits, followed by zeros for a whole unit of symbols and a word.
    n_bits : int
        How many bits there are.
    interval : int
        Units after which reading begins anew, at the next whole byte and at level 0.
    restarts : ndarray of int32
        Byte at which it does so each time.
    blocks : ndarray of int, shape (b, 6)
        For each block of a unit its component, DC table, AC table, table of heads, column and
        row.
    tables : tuple
        All codes, the first axis of each being the code (see
        :func:`~pawnb.core.jpeg.table_kernels.fill_tables`), and heads.
    begins : ndarray of int32, shape (n,)
        To be filled: first bit of each unit.
    levels : ndarray of int16, shape (n, components)
        To be filled: DC of each component before each unit.

    Returns
    -------
    bool
        Whether the bits are those of exactly so many units.
    """
    one, _, several, ends, offsets, values, heads = tables
    level = np.zeros(levels.shape[1], np.int64)
    at = _0
    end = np.uint64(n_bits)
    left = interval
    restart = 0
    for unit in range(len(begins)):
        if left == 0:
            begin = np.uint64(8 * restarts[restart])
            if begin - at >= _8:  # also where it lies before
                return False
            at = begin
            level[:] = 0
            left = interval
            restart += 1
        left -= 1
        begins[unit] = at
        if at > end:
            return False
        for c in range(len(level)):
            levels[unit, c] = level[c]
        for b in range(len(blocks)):
            bits = _window(words, at)
            entry: Any = np.int64(heads[blocks[b, 3], bits >> _DOWN])
            if entry == 0:
                entry = _long(bits, blocks[b, 1], False, one, ends, offsets, values)
                if entry == 0:
                    return False
                level[blocks[b, 0]] += entry >> 16
                entry = (entry & 255) << 7
            else:
                level[blocks[b, 0]] += entry >> 16
            shift = np.uint64((entry >> 7) & 31)
            used = shift
            passed = entry & 63
            ended = entry & 64
            code = blocks[b, 2]
            # not in a function of its own: it would be called, at thrice the time
            while ended == 0 and passed < 63:
                bits <<= shift
                if used > _LAST:
                    at += used
                    used = _0
                    bits = _window(words, at)
                entry = np.int64(several[code, bits >> _DOWN])
                shift = np.uint64(entry >> 7)
                ended = entry & 64
                # a block that is full has no end of block: what follows is the next one's
                if shift == 0 or passed + (entry & 63) + (ended >> 6) > 63:
                    at += used
                    used = _0
                    bits = _window(words, at)
                    entry = _long(bits, code, True, one, ends, offsets, values)
                    if entry == 0:
                        return False
                    shift = np.uint64(entry & 255)
                    more = (entry >> 8) & 255
                    ended = 64 if more == 0 else 0
                    passed += more
                else:
                    passed += entry & 63
                used += shift
            if passed > 63:
                return False
            at += used
    return bool(end - at < _8)


@compiled
def read_units(
    words: np.ndarray,
    begins: np.ndarray,
    levels: np.ndarray,
    blocks: np.ndarray,
    tables: Tables,
    scales: np.ndarray,
    lanes: np.ndarray,
    coefficients: np.ndarray,
) -> None:
    """Read the coefficients of units that lie side by side.

    Parameters
    ----------
    words, blocks, tables
        See :func:`scan_units`.
    begins : ndarray of int, shape (n,)
        First bit of each unit.
    levels : ndarray of int, shape (n, components)
        DC of each component before it.
    scales : ndarray of int32, shape (components, 64, 2)
        For each coefficient in the order of reading its place, row by row, and by what it
        is multiplied.
    lanes : ndarray of int, shape (b, 2)
        For each block of a unit, the first lane of the strips that it goes to, and its column
        in the unit.
    coefficients : ndarray of int16, shape (strips * 64 * LANES,)
        To be filled, zeros before: strip by strip and place by place, of LANES blocks side by
        side.
    """
    one, whole, _, ends, offsets, values, _ = tables
    level = np.zeros(levels.shape[1], np.int64)
    for unit in range(len(begins)):
        at = np.uint64(begins[unit])
        for c in range(len(level)):
            level[c] = levels[unit, c]
        for b in range(len(blocks)):
            c = blocks[b, 0]
            lane = unit * lanes[b, 1] + lanes[b, 0]
            first = (lane >> LANE_BITS) * (64 * LANES) + (lane & (LANES - 1))
            bits = _window(words, at)
            entry: Any = np.int64(whole[blocks[b, 1], bits >> _DOWN])
            if entry == 0:
                entry = _long(bits, blocks[b, 1], False, one, ends, offsets, values)
            level[c] += entry >> 16
            coefficients[first + LANES * scales[c, 0, 0]] = level[c] * scales[c, 0, 1] + _GREY_DC
            used = shift = np.uint64(entry & 255)
            code = blocks[b, 2]
            k = 0
            while k < 63:
                bits <<= shift
                if used > _LAST:
                    at += used
                    used = _0
                    bits = _window(words, at)
                entry = np.int64(whole[code, bits >> _DOWN])
                if entry == 0:
                    at += used
                    used = _0
                    bits = _window(words, at)
                    entry = _long(bits, code, True, one, ends, offsets, values)
                shift = np.uint64(entry & 255)
                used += shift
                passed = (entry >> 8) & 255
                k += passed
                if passed == 0 or k > 63:
                    break
                coefficients[first + LANES * scales[c, k, 0]] = (entry >> 16) * scales[c, k, 1]
            at += used
