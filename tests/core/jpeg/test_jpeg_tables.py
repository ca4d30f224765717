"""Tables for many bits at once against reading them bit by bit, as ITU-T T.81 F.2.2 has it."""

import numpy as np
import pytest

from pawnb.core.jpeg.table_kernels import LOOKED_AT, fill_heads, fill_tables

DC = {0: 2, 1: 2, 3: 3, 6: 4, 2: 5, 11: 5}
"""Symbols and the lengths of their codes."""
AC = {
    # two bits would pass 32 places: a block is full before the bits are used up
    "long runs": {0xF0: 1, 0xE1: 2, 0x00: 3, 0x01: 4, 0x3A: 5, 0xA2: 6},
    "usual": {0x01: 2, 0x00: 2, 0x02: 3, 0x11: 4, 0x21: 5, 0xF0: 6, 0x05: 8, 0x1A: 12, 0x41: 14},
    # 0x70 stands for nothing, and a value of 12 bits is none of 8-bit pictures
    "wrong symbols": {0x01: 2, 0x70: 3, 0x0C: 3, 0x00: 3, 0x12: 4},
}


def codes_of(lengths):
    """Codes as words of 0 and 1, in the order of T.81, C.2: each one more than the one before."""
    code, before, found = 0, 0, {}
    for symbol, length in lengths.items():
        code <<= length - before
        found[f"{code:0{length}b}"] = symbol
        code, before = code + 1, length
    return found


def read(word, codes, *, is_ac):
    """The first symbol of a word as value, places passed and bits; None if it is not all there."""
    for end in range(1, len(word) + 1):
        if word[:end] in codes:
            symbol = codes[word[:end]]
            run, size = divmod(symbol, 16) if is_ac else (0, symbol)
            if end + size > len(word) or size > (10 if is_ac else 11):
                return None
            if size == 0 and is_ac and run != 15:
                return (0, 0, end) if run == 0 else None
            bits = word[end : end + size]
            # a value that begins with 0 is negative: all its bits are turned
            value = int(bits or "0", 2)
            if bits.startswith("0"):
                value = -int("".join("10"[int(b)] for b in bits), 2)
            return value, run + 1, end + size
    return None


def chain(word, codes, used=0):
    """Places passed, whether the block ends, and bits used, of as many symbols as there are."""
    passed = 0
    while (found := read(word[used:], codes, is_ac=True)) is not None:
        _, places, bits = found
        if places == 0:
            return (passed, 1, used + bits) if passed < 63 else (passed, 0, used)
        if passed + places > 63:
            break
        passed, used = passed + places, used + bits
    return passed, 0, used


def filled(lengths, *, is_ac):
    counts = np.bincount(list(lengths.values()), minlength=17).astype(np.int64)
    values = np.zeros(256, np.uint8)
    values[: len(lengths)] = list(lengths)
    n = 1 << LOOKED_AT
    one, several, whole = np.zeros(n, np.uint16), np.zeros(n, np.uint16), np.ones(n, np.int32)
    ends, offsets = np.zeros(17, np.int64), np.zeros(17, np.int64)
    assert fill_tables(counts, values, one, whole, several, ends, offsets, is_ac)
    return whole, several


def words():
    return [f"{bits:0{LOOKED_AT}b}" for bits in range(1 << LOOKED_AT)]


@pytest.mark.parametrize("name", AC)
def test_symbols_of_ac(name):
    codes = codes_of(AC[name])
    whole, several = filled(AC[name], is_ac=True)
    for bits, word in enumerate(words()):
        value, places, used = read(word, codes, is_ac=True) or (0, 0, 0)
        assert whole[bits] == value * 65536 + places * 256 + used
        passed, ended, used = chain(word, codes)
        assert several[bits] == passed + 64 * ended + 128 * used


@pytest.mark.parametrize("name", AC)
def test_heads_of_blocks(name):
    codes, dc_codes = codes_of(AC[name]), codes_of(DC)
    dc, _ = filled(DC, is_ac=False)
    ac, _ = filled(AC[name], is_ac=True)
    heads = np.ones(1 << LOOKED_AT, np.int32)
    fill_heads(dc, ac, heads)
    for bits, word in enumerate(words()):
        head = read(word, dc_codes, is_ac=False)
        if head is None:
            assert heads[bits] == dc[bits] == 0
            continue
        assert dc[bits] == head[0] * 65536 + 256 + head[2]
        passed, ended, used = chain(word, codes, head[2])
        assert heads[bits] == head[0] * 65536 + passed + 64 * ended + 128 * used


def test_too_many_codes_of_a_length():
    counts = np.zeros(17, np.int64)
    counts[2] = 5
    empty = [np.zeros(1 << LOOKED_AT, kind) for kind in (np.uint16, np.int32, np.uint16)]
    places = np.zeros(17, np.int64), np.zeros(17, np.int64)
    assert not fill_tables(counts, np.zeros(256, np.uint8), *empty, *places, True)
