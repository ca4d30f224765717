"""What a pose tracker has found, kept in a file: what comes back, and for whom."""

import numpy as np
import pytest

from pawnb.core.frame_checkpoint import KeptFrames
from pawnb.errors import InputError


def found(seed):
    rng = np.random.default_rng(seed)
    return {
        "pose": rng.normal(size=5),
        "box": (3, 4, 50, 60),
        "legs": [rng.normal(size=(2, 3)), np.empty((0, 3))],
        "crossed": [[0, 1, np.array([[True, False]])]],
        "state": {"usual": np.array([np.inf, np.nan]), "lost": 1, "astray": [0.1, 1e-300]},
    }


def assert_same(record, expected):
    assert record["box"] == list(expected["box"])
    for key in ("pose",):
        np.testing.assert_array_equal(record[key], expected[key])
    for one, other in zip(record["legs"], expected["legs"], strict=True):
        assert one.shape == other.shape
        np.testing.assert_array_equal(one, other)
    (crossed,) = record["crossed"]
    assert crossed[:2] == [0, 1]
    assert crossed[2].dtype == bool
    np.testing.assert_array_equal(crossed[2], [[True, False]])
    np.testing.assert_array_equal(record["state"]["usual"], [np.inf, np.nan])
    assert record["state"]["lost"] == 1
    assert record["state"]["astray"] == [0.1, 1e-300]


def test_what_was_found_comes_back_to_the_last_bit(tmp_path):
    path = tmp_path / "results" / "kept.bin"
    with KeptFrames(path, depends_on="a") as kept:
        kept.keep("forwards", 7, found(1))
        kept.keep("backwards", 7, found(2))
    with KeptFrames(path, depends_on="a") as kept:
        assert kept.frames == {7}
        assert_same(kept.recall("forwards", 7), found(1))
        assert_same(kept.recall("backwards", 7), found(2))
        assert kept.recall("forwards", 8) is None
        kept.keep("forwards", 8, found(3))
    with KeptFrames(path, depends_on="a") as kept:
        assert_same(kept.recall("forwards", 8), found(3))
        assert kept.other is None
        kept.remove()
    assert not path.exists()


def test_another_run_finds_nothing_and_replaces_it_only_when_it_has_found_something(tmp_path):
    path = tmp_path / "kept.bin"
    with KeptFrames(path, depends_on="a") as kept:
        kept.keep("forwards", 7, found(1))
    with KeptFrames(path, depends_on="b") as kept:
        assert (kept.frames, kept.other) == (set(), "a")
    with KeptFrames(path, depends_on="a") as kept:
        assert kept.frames == {7}
    with KeptFrames(path, depends_on="b") as kept:
        kept.keep("forwards", 3, found(2))
    with KeptFrames(path, depends_on="b") as kept:
        assert kept.frames == {3}
        assert kept.recall("forwards", 7) is None


@pytest.mark.parametrize("damage", ["cut", "flip"])
def test_a_record_that_is_not_whole_is_dropped_and_written_again(tmp_path, damage):
    path = tmp_path / "kept.bin"
    with KeptFrames(path, depends_on="a") as kept:
        kept.keep("forwards", 7, found(1))
        length = path.stat().st_size
        kept.keep("forwards", 8, found(2))
    data = bytearray(path.read_bytes())
    if damage == "cut":
        del data[-3:]
    else:
        data[length + 30] ^= 1
    path.write_bytes(data)
    with KeptFrames(path, depends_on="a") as kept:
        assert kept.frames == {7}
        kept.keep("forwards", 8, found(3))
    with KeptFrames(path, depends_on="a") as kept:
        assert kept.frames == {7, 8}
        assert_same(kept.recall("forwards", 8), found(3))


def test_without_a_file_nothing_is_kept(tmp_path):
    kept = KeptFrames()
    kept.keep("forwards", 7, found(1))
    assert kept.recall("forwards", 7) is None
    assert list(tmp_path.iterdir()) == []


def test_a_place_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "results").write_text("a file, no folder")
    with pytest.raises(InputError, match=r"kept\.bin: cannot keep here what is done .* choose"):
        KeptFrames(tmp_path / "results" / "kept.bin", depends_on="a")
