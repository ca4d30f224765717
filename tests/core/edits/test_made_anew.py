"""Corrections that were saved with other tracks are not made in new ones without a word."""

import numpy as np
import pytest

from pawnb.core.edits.log import EditLog, Move, Swap, replay
from pawnb.core.edits.made_anew import same_places
from pawnb.errors import InputError
from pawnb.schema import ORIGIN_CODE, make_tracks


def still(offset=0.0):
    """Two points that stand in one view."""
    tracks = make_tracks(
        np.arange(8), ["FL", "FR"], fps=100.0, views=("side",), space=("x", "y"), unit="px"
    )
    tracks["image_position"].values[..., 0] = np.array([10.0, 30.0])[:, None] + offset
    tracks["image_origin"].values[:] = ORIGIN_CODE["measured"]
    return tracks


@pytest.fixture
def corrected(tmp_path):
    """The file of an exchange and of a place, made in tracks that stand at their places."""

    def write(*edits):
        path = tmp_path / "edits.jsonl"
        log = EditLog(still(), path)
        for edit in edits:
            log.apply(edit)
        return path, log

    return write


SWAP = Swap(frame=4, first="FL", second="FR")
MOVE = Move(frame=2, view="side", point="FL", u=12.0, v=12.0)


def test_an_exchange_in_tracks_that_were_made_anew_is_said(corrected):
    path, _ = corrected(MOVE, SWAP)
    (note,) = EditLog(still(offset=1.0), path, before=still).notes
    assert note == (
        "The trial was tracked anew, and the 2 corrections saved before are made in the new "
        "tracks, too; look whether this is still needed: FL and FR exchanged from frame 4 on."
    )


def test_places_are_right_in_any_tracks_but_are_to_be_looked_at(corrected):
    path, _ = corrected(MOVE)
    (note,) = EditLog(still(offset=1.0), path, before=still).notes
    assert note.startswith("The trial was tracked anew, and the correction saved before is made")
    assert note.endswith("; look at them.")


def test_nothing_is_said_of_the_tracks_in_which_they_were_made(corrected):
    path, log = corrected(SWAP)
    assert EditLog(still(), path, before=still).notes == []
    # nor of tracks that contain them, nor where the tracks from before were not kept
    assert EditLog(log.stamped(), path, before=lambda: still(offset=1.0)).notes == []
    assert EditLog(still(offset=1.0), path).notes == []


def test_tracks_from_before_that_cannot_be_read_do_not_keep_a_review_from_opening(corrected):
    def broken():
        raise InputError("tracks.before.nc: cut short.")

    path, _ = corrected(SWAP)
    (note,) = EditLog(still(), path, before=broken).notes
    assert note.endswith("is not known: tracks.before.nc: cut short.")


def test_files_that_round_hold_the_same_places(corrected):
    assert same_places(still(), still(offset=1 / 4096))
    assert not same_places(still(), still(offset=0.01))
    path, _ = corrected(SWAP)
    np.testing.assert_array_equal(  # what is said changes nothing
        replay(still(1.0), path)["image_position"],
        EditLog(still(1.0), path, before=still).tracks["image_position"],
    )
