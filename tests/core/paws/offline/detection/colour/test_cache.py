"""Detections that are kept: what comes back, for whom, and from a file that was cut short."""

from dataclasses import dataclass

import numpy as np
import pytest

from pawnb.core.paws.offline.detection.colour.cache import DetectionCache
from pawnb.core.paws.offline.detection.colour.detections import ColourDetections


@dataclass
class Look:
    table: np.ndarray
    shrink: int


LOOK = Look(np.arange(6.0), 2)


def frames_of(n, seed=0):
    rng = np.random.default_rng(seed)
    return [
        [
            ColourDetections(rng.normal(size=(rng.integers(0, 5), 8)).astype(np.float32))
            for _ in range(3)
        ]
        for _ in range(n)
    ]


def assert_same(found, expected):
    assert len(found) == len(expected)
    for here, wanted in zip(found, expected, strict=True):
        for rows, rows_wanted in zip(here, wanted, strict=True):
            assert rows.table.dtype == np.float32
            np.testing.assert_array_equal(rows.table, rows_wanted.table)


def fill(path, frames, *depends_on, source="film"):
    with DetectionCache(path, source=source) as store:
        found = store.begin(3, *depends_on)
        for rows in frames:
            store.add(rows)
        return found


def test_what_was_found_comes_back_and_goes_on(tmp_path):
    path, frames = tmp_path / "candidates.bin", frames_of(7)
    assert fill(path, frames[:4], 0, [LOOK]) == []
    assert_same(fill(path, frames[4:], 0, [LOOK]), frames[:4])
    assert_same(DetectionCache(path, source="film").begin(3, 0, [LOOK]), frames)


@pytest.mark.parametrize(
    "other",
    [
        {"look": Look(np.arange(6.0) + 1e-9, 2)},
        {"look": Look(np.arange(6.0), 3)},
        {"first": 1},
        {"source": "another film"},
    ],
)
def test_another_search_starts_anew(tmp_path, other):
    path, frames = tmp_path / "candidates.bin", frames_of(3)
    fill(path, frames, 0, [LOOK])
    given = {"look": LOOK, "first": 0, "source": "film", **other}
    key = (given["first"], [given["look"]])
    new = frames_of(2, seed=1)
    assert fill(path, new, *key, source=given["source"]) == []
    assert_same(DetectionCache(path, source=given["source"]).begin(3, *key), new)


@pytest.mark.parametrize("damage", ["cut", "flip", "no first line", "empty"])
def test_a_damaged_end_is_dropped_and_written_again(tmp_path, damage):
    path, frames = tmp_path / "candidates.bin", frames_of(6)
    fill(path, frames[:5], 0, [LOOK])
    length = len(path.read_bytes())
    fill(path, frames[5:], 0, [LOOK])
    data = bytearray(path.read_bytes())
    kept = 5
    if damage == "cut":
        data = data[:-3]
    elif damage == "flip":
        data[length + 9] ^= 1
    else:
        data, kept = data[3:] if damage == "no first line" else bytearray(), 0
    path.write_bytes(bytes(data))
    assert_same(fill(path, frames[kept:], 0, [LOOK]), frames[:kept])
    assert_same(DetectionCache(path, source="film").begin(3, 0, [LOOK]), frames)


def test_without_a_file_candidates_stay_in_memory():
    store, frames = DetectionCache(source="film"), frames_of(3)
    assert store.begin(3, 0, [LOOK]) == []
    for rows in frames:
        store.add(rows)
    store.close()
    assert_same(store.begin(3, 0, [LOOK]), frames)
    assert store.begin(3, 1, [LOOK]) == []
