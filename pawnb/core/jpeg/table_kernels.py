"""Compiled loops that fill the tables by which the bits of a JPEG picture are read.

A table has an entry for every number of ``LOOKED_AT`` bits: what symbols they begin with. Many
programs write codes of their own for every picture, so these tables are filled once a frame.
"""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np

from pawnb.core.compiled import compiled

Tables: TypeAlias = tuple[
    np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray
]
"""``one``, ``whole``, ``several``, ``ends``, ``offsets`` and ``values`` of all codes, and
``heads`` of all pairs of codes; see :func:`fill_tables` and :func:`fill_heads`."""

LOOKED_AT = 11
"""Bits that are looked up at once; what codes are longer is found by comparing."""
MOST_DC, MOST_AC = 11, 10
"""Most bits of a value in 8-bit pictures (ITU-T T.81, tables F.1 and F.2)."""
_MASK = (1 << LOOKED_AT) - 1


@compiled
def fill_tables(
    counts: np.ndarray,
    values: np.ndarray,
    one: np.ndarray,
    whole: np.ndarray,
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
    one : ndarray of uint16, shape (2048,)
        To be filled: symbol * 256 + length of the code, 0 where the code is longer than
        ``LOOKED_AT`` or there is none.
    whole : ndarray of int32, shape (2048,)
        To be filled: value * 65536 + places passed * 256 + bits passed, of one symbol with its
        value; 0 where the bits do not tell it. The end of a block passes no place.
    several : ndarray of uint16, shape (2048,)
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
    whole[:] = 0
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
                _fill_whole(whole, first, length, np.int64(values[k]), is_ac)
            code += 1
            k += 1
        ends[length] = code
        code <<= 1
    if is_ac:
        for bits in range(1 << LOOKED_AT):
            several[bits] = _several(bits, 0, whole)
    return True


@compiled
def _fill_whole(whole: np.ndarray, first: int, length: int, symbol: Any, is_ac: bool) -> None:
    """Fill in one symbol with all of its values, from the first bits that begin with it on."""
    size = symbol & 15 if is_ac else symbol
    run = symbol >> 4 if is_ac else 0
    spare = LOOKED_AT - length - size
    if spare < 0 or size > (MOST_AC if is_ac else MOST_DC) or (size == 0 and 0 < run < 15):
        return
    passed = 0 if is_ac and symbol == 0 else run + 1
    for low in range(1 << size):
        value = low if 2 * low >= 1 << size else low - (1 << size) + 1
        entry = value * 65536 + passed * 256 + length + size
        at = first + (low << spare)
        whole[at : at + (1 << spare)] = entry


@compiled
def _several(bits: Any, used: Any, whole: np.ndarray) -> Any:
    """Return the entry of the table of several symbols, after bits that were used before."""
    passed: Any = 0
    ended = 0
    while used < LOOKED_AT:
        entry = np.int64(whole[(bits << used) & _MASK])
        length = entry & 255
        run = (entry >> 8) & 255
        # a block that is full has no end of block: what follows is the next one's
        if length == 0 or length > LOOKED_AT - used or passed + max(run, 1) > 63:
            break
        used += length
        passed += run
        if run == 0:
            ended = 1
            break
    return passed + 64 * ended + 128 * used


@compiled
def fill_heads(dc: np.ndarray, ac: np.ndarray, heads: np.ndarray) -> None:
    """Fill the table of how blocks begin that have their DC in one code and their AC in another.

    Parameters
    ----------
    dc, ac : ndarray of int32, shape (2048,)
        ``whole`` of both codes; see :func:`fill_tables`.
    heads : ndarray of int32, shape (2048,)
        To be filled: value of the DC * 65536 + what ``several`` says of what follows it, all
        bits passed; 0 where the bits do not tell the DC.
    """
    for bits in range(1 << LOOKED_AT):
        entry = np.int64(dc[bits])
        heads[bits] = 0
        if entry != 0:
            heads[bits] = (entry >> 16) * 65536 + _several(bits, entry & 255, ac)
