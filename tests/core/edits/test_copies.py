"""Copies of long tracks: alike, apart, and of memory that goes back to the system."""

import ctypes
import mmap
import sys

import numpy as np
import pytest
import xarray as xr
from test_edits import FlatRig, wand

from pawnb.core.edits.copies import copy_tracks, give_back_memory
from pawnb.core.edits.log import EditLog, Move
from pawnb.schema import make_tracks


def long_tracks(n=40_000):
    tracks = make_tracks(range(n), ["P", "Q"], fps=100.0, views=["a", "b"], unit="mm")
    rng = np.random.default_rng(0)
    tracks["image_position"].values[...] = rng.normal(size=tracks["image_position"].shape)
    return tracks.assign_attrs(provenance='{"steps": []}')


def memory_of(values):
    """What an array's memory is of."""
    base = values
    while isinstance(base, np.ndarray) and base.base is not None:
        base = base.base
    return base.obj if isinstance(base, memoryview) else base


@pytest.mark.slow
def test_a_copy_is_alike_and_shares_nothing():
    tracks = long_tracks()
    new = copy_tracks(tracks)
    xr.testing.assert_identical(new, tracks)
    for name, variable in tracks.variables.items():
        assert new[name].dtype == variable.dtype
        if name in tracks.data_vars:
            assert not np.shares_memory(new[name].values, variable.values)
            assert new[name].encoding == variable.encoding
    before = tracks.copy(deep=True)
    new["image_position"].values[3] = 7.0
    new["image_origin"].values[3] = 1
    new["image_position"].attrs["note"] = "of the copy"
    xr.testing.assert_identical(tracks, before)


def test_large_arrays_have_pages_of_their_own_and_small_ones_not():
    new = copy_tracks(long_tracks())
    assert isinstance(memory_of(new["image_position"].values), mmap.mmap)  # 2.5 MB
    assert not isinstance(memory_of(new["image_origin"].values), mmap.mmap)  # 160 kB
    # and so again: also a copy of a copy
    assert isinstance(memory_of(copy_tracks(new)["image_position"].values), mmap.mmap)


def test_undo_and_redo_of_long_tracks_leave_every_state_as_it_was():
    log = EditLog(long_tracks(), rig=FlatRig())
    states = [log.tracks]
    for frame in (5, 20_000, 39_999):
        log.apply(Move(frame=frame, view="a", point="P", u=1.0 + frame, v=2.0))
        states.append(log.tracks)
    kept = [state.copy(deep=True) for state in states]
    for k in (2, 1, 0):
        log.undo()
        xr.testing.assert_identical(log.tracks, kept[k])
    for k in (1, 2, 3):
        log.redo()
        xr.testing.assert_identical(log.tracks, kept[k])
    # what was handed out before is not changed by what came later
    for state, was in zip(states, kept, strict=True):
        xr.testing.assert_identical(state, was)


def test_short_tracks_are_copied_as_well():
    tracks = wand()
    xr.testing.assert_identical(copy_tracks(tracks), tracks)


@pytest.mark.parametrize("platform", ["linux", "darwin", "win32"])
def test_free_memory_is_given_back_where_the_c_library_can(monkeypatch, platform):
    asked = []

    class Library:
        def malloc_trim(self, kept):
            asked.append(kept)
            return 1

    monkeypatch.setattr(ctypes, "CDLL", lambda _name: Library())
    monkeypatch.setattr(sys, "platform", platform)
    assert give_back_memory() == (platform == "linux")
    assert asked == [0] * (platform == "linux")
    # another C library, as that of Alpine, has no such function
    monkeypatch.setattr(ctypes, "CDLL", lambda _name: object())
    assert not give_back_memory()
