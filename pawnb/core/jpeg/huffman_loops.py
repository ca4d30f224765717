"""Compiled loops over the entropy-coded bits of a baseline JPEG picture.

A bit cannot be told from what it means without reading all bits before it. So a picture is
read through once, as quickly as that can be done when coefficients are not wanted: several
symbols at one look into a table. What is kept is where each unit of blocks begins and the
mean levels there; from then on any unit can be decoded by itself.

Bits are held in the upper end of a signed 64-bit number, at least 33 of them whenever a
symbol is read: the longest code with its value has 27.
"""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np

from pawnb.core.compiled import compiled

Tables: TypeAlias = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]

LOOKED_AT = 11
"""Bits that are looked up at once; what codes are longer is found by comparing."""
MOST_BITS = 27
"""Most bits of a symbol with its value in 8-bit pictures: a code of 16, a value of 11."""
_DOWN = 64 - LOOKED_AT
_MASK = (1 << LOOKED_AT) - 1
_RST, _EOI = 0xD0, 0xD9
_MOST_DC, _MOST_AC = 11, 10
_GREY = 1024
"""DC of a block of 128: samples are coded as differences from it (T.81, A.3.1)."""


@compiled
def fill_tables(
    counts: np.ndarray,
    values: np.ndarray,
    one: np.ndarray,
    several: np.ndarray,
    ends: np.ndarray,
    offsets: np.ndarray,
    is_ac: bool,
) -> bool:
    """Fill the tables of one Huffman code (ITU-T T.81, C.2 and F.2.2.3).

    Parameters
    ----------
    counts : ndarray of int, shape (17,)
        Number of codes of each length.
    values : ndarray of uint8, shape (256,)
        Symbols in the order of their codes.
    one : ndarray of uint16, shape (8192,)
        To be filled: symbol * 256 + length of the code, 0 where the code is longer than
        ``LOOKED_AT`` or there is none.
    several : ndarray of uint16, shape (8192,)
        To be filled for AC: coefficients passed + 64 * (whether the block ends) + 128 *
        bits passed, of as many whole symbols as the bits tell.
    ends, offsets : ndarray of int, shape (17,)
        To be filled: one past the last code of each length, and what is to be added to a
        code for the index of its symbol.
    is_ac : bool
        Whether symbols are those of AC coefficients.

    Returns
    -------
    bool
        Whether the code is possible.
    """
    one[:] = 0
    code = 0
    k = 0
    for length in range(1, 17):
        offsets[length] = k - code
        for _ in range(counts[length]):
            if code >= 1 << length:
                return False
            if length <= LOOKED_AT:
                first = code << (LOOKED_AT - length)
                one[first : first + (1 << (LOOKED_AT - length))] = values[k] * 256 + length
            code += 1
            k += 1
        ends[length] = code
        code <<= 1
    if is_ac:
        for bits in range(1 << LOOKED_AT):
            several[bits] = _several(bits, one)
    return True


@compiled
def _several(bits: Any, one: np.ndarray) -> Any:
    """Return the entry of the table of several symbols."""
    used = 0
    passed = 0
    ended = 0
    while used < LOOKED_AT:
        entry: Any = np.int64(one[(bits << used) & _MASK])
        length = entry & 255
        size = (entry >> 8) & 15
        run = entry >> 12
        if length == 0 or length > LOOKED_AT - used or size > _MOST_AC:
            break
        if size == 0 and run != 15:
            if run == 0:
                used += length
                ended = 1
            break
        if passed + run + 1 > 63:
            break
        used += length + size
        passed += run + 1
    return passed + 64 * ended + 128 * used


@compiled
def _symbol(
    bits: Any,
    row: int,
    one: np.ndarray,
    ends: np.ndarray,
    offsets: np.ndarray,
    values: np.ndarray,
) -> Any:
    """Return the symbol * 256 + length of the code at the upper end of ``bits``; 0 for none."""
    entry = np.int64(one[row, (bits >> _DOWN) & _MASK])
    if entry == 0:
        for length in range(LOOKED_AT + 1, 17):
            code = (bits >> (64 - length)) & ((1 << length) - 1)
            if code < ends[row, length]:
                return np.int64(values[row, code + offsets[row, length]]) * 256 + length
    return entry


@compiled
def _value(bits: Any, size: int) -> Any:
    """Return the value of ``size`` bits at the upper end (ITU-T T.81, F.2.2.1, EXTEND)."""
    mask = (1 << size) - 1
    value = (bits >> (63 - size) >> 1) & mask
    return value if bits < 0 else value - mask


@compiled
def take_words(data: np.ndarray, begin: int, words: np.ndarray, restarts: np.ndarray) -> int:
    """Take the entropy-coded bits out of a picture's bytes (ITU-T T.81, B.1.1.5).

    Parameters
    ----------
    data : ndarray of uint8
        The picture.
    begin : int
        Where its entropy-coded bytes begin.
    words : ndarray of uint8
        To be filled with them, without the zero that follows each 255 and without markers;
        no shorter than ``data``.
    restarts : ndarray of int32
        To be filled: how many bytes come before each restart marker.

    Returns
    -------
    int
        How many bytes there are up to the marker that ends the picture; -1 where another
        marker or the end of the data comes first, or there are other restart markers.
    """
    n = 0
    n_restarts = 0
    at = begin
    while at < len(data) - 1:
        byte = data[at]
        at += 1
        if byte == 255:
            marker = data[at]
            at += 1
            if marker == _RST + (n_restarts & 7) and n_restarts < len(restarts):
                restarts[n_restarts] = n
                n_restarts += 1
                continue
            if marker != 0:
                return n if marker == _EOI and n_restarts == len(restarts) else -1
        words[n] = byte
        n += 1
    return -1


@compiled
def _bits_from(words: np.ndarray, begin: Any) -> tuple[Any, Any, Any]:
    """Return the bits from one on, the first being the highest, how many, and the word after."""
    at = begin >> 5
    return np.int64(words[at]) << (32 + (begin & 31)), 32 - (begin & 31), at + 1


@compiled
def _passed_by(entry: Any) -> tuple[Any, Any]:
    """Return the bits of one AC symbol and its value, 0 if it is none, and the places it passes.

    An end of block passes none.
    """
    size = (entry >> 8) & 15
    run = entry >> 12
    if (entry & 255) == 0 or size > _MOST_AC or (size == 0 and 0 < run < 15):
        return 0, 0
    return (entry & 255) + size, 0 if size == 0 and run == 0 else run + 1


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
    words : ndarray of uint32
        The entropy-coded bits, followed by zeros for a whole unit of symbols.
    n_bits : int
        How many bits there are.
    interval : int
        Units after which reading begins anew, at the next whole byte and at level 0.
    restarts : ndarray of int32
        Byte at which it does so each time.
    blocks : ndarray of int, shape (b, 5)
        For each block of a unit its component, DC table, AC table, column and row.
    tables : tuple
        ``one``, ``several``, ``ends``, ``offsets`` and ``values`` of all codes (see
        :func:`fill_tables`), the first axis being the code.
    begins : ndarray of int32, shape (n,)
        To be filled: first bit of each unit.
    levels : ndarray of int16, shape (n, components)
        To be filled: DC of each component before each unit.

    Returns
    -------
    bool
        Whether the bits are those of exactly so many units.
    """
    one, several, ends, offsets, values = tables
    level = np.zeros(levels.shape[1], np.int64)
    bits: Any = np.int64(0)
    held = 0
    at = 0
    left = interval
    restart = 0
    for unit in range(len(begins)):
        if left == 0:
            begin = 8 * restarts[restart]
            if not 0 <= begin - (32 * at - held) < 8:
                return False
            bits, held, at = _bits_from(words, begin)
            level[:] = 0
            left = interval
            restart += 1
        left -= 1
        begins[unit] = 32 * at - held
        if begins[unit] > n_bits:
            return False
        for c in range(len(level)):
            levels[unit, c] = level[c]
        for b in range(len(blocks)):
            if held <= 32:
                bits |= np.int64(words[at]) << (32 - held)
                at += 1
                held += 32
            code = blocks[b, 1]
            entry: Any = _symbol(bits, code, one, ends, offsets, values)
            length = entry & 255
            size = entry >> 8
            if length == 0 or size > _MOST_DC:
                return False
            level[blocks[b, 0]] += _value(bits << length, size)
            bits <<= length + size
            held -= length + size
            # not in a function of its own: it would be called, at thrice the time
            code = blocks[b, 2]
            passed = 0
            while passed < 63:
                if held <= 32:
                    bits |= np.int64(words[at]) << (32 - held)
                    at += 1
                    held += 32
                entry = np.int64(several[code, (bits >> _DOWN) & _MASK])
                used = entry >> 7
                ended = (entry >> 6) & 1
                # a block that is full has no end of block: what follows is the next one's
                if used == 0 or passed + (entry & 63) + ended > 63:
                    entry = _symbol(bits, code, one, ends, offsets, values)
                    used, more = _passed_by(entry)
                    if used == 0:
                        return False
                    ended = 1 if more == 0 else 0
                    passed += more
                else:
                    passed += entry & 63
                bits <<= used
                held -= used
                if ended:
                    break
            if passed > 63:
                return False
    return 0 <= n_bits - (32 * at - held) < 8


@compiled
def read_block(
    words: np.ndarray,
    begin: int,
    level: Any,
    codes: tuple[int, int, int],
    tables: Tables,
    scales: np.ndarray,
    coefficients: np.ndarray,
    first: int,
    apart: int,
) -> tuple[Any, Any]:
    """Read the coefficients of one block.

    Parameters
    ----------
    words, tables
        See :func:`scan_units`.
    begin : int
        Its first bit.
    level : int
        DC before it.
    codes : tuple of int
        Its component, DC table and AC table.
    scales : ndarray of int32, shape (components, 64, 2)
        For each coefficient in the order of reading its place, row by row, and by what it
        is multiplied.
    coefficients : ndarray of int16
        To be filled; zeros before.
    first, apart : int
        Where in it place 0 is, and how far apart places are.

    Returns
    -------
    end : int
        First bit after it.
    level : int
        Its DC.
    """
    one, _, ends, offsets, values = tables
    bits, held, at = _bits_from(words, begin)
    c, code, _ = codes
    k = 0
    while k < 64:
        if held <= 32:
            bits |= np.int64(words[at]) << (32 - held)
            at += 1
            held += 32
        entry = _symbol(bits, code, one, ends, offsets, values)
        length = entry & 255
        size = (entry >> 8) & 15
        run = entry >> 12
        bits <<= length
        value = _value(bits, size)
        bits <<= size
        held -= length + size
        if k == 0:
            level += value
            coefficients[first + apart * scales[c, 0, 0]] = level * scales[c, 0, 1] + _GREY
            code = codes[2]
        elif size == 0 and run == 0:
            break
        else:
            k += run
            coefficients[first + apart * scales[c, k, 0]] = value * scales[c, k, 1]
        k += 1
    return 32 * at - held, level
