"""Labels of frames in which a film stood still are not measured, whatever a tracker found."""

from __future__ import annotations

import numpy as np

from pawnb.core.paws.offline.quality.measures import CALIBRATED
from pawnb.core.video.doubts.frozen_labels import freezes_of_tracks, without_frozen
from pawnb.schema import ORIGIN_CODE, make_tracks
from pawnb.workflow.reviewing.quality import assess_quality

MEASURED, PREDICTED, EDITED = (ORIGIN_CODE[name] for name in ("measured", "predicted", "edited"))


def measured_tracks():
    """Twenty frames of two points, measured in two views."""
    tracks = make_tracks(range(100, 120), ["a", "b"], fps=50.0, views=["left", "right"])
    for name, value in (("confidence", 0.97), ("origin", MEASURED)):
        tracks[name][:] = value
        tracks[f"image_{name}"][:] = value
    tracks["position"][:] = 5.0
    tracks["image_position"][:] = np.arange(20.0).reshape(20, 1, 1, 1, 1)
    tracks["image_confidence"].attrs[CALIBRATED] = 1
    return tracks


def test_labels_in_a_freeze_are_predicted_without_confidence_but_what_a_person_placed():
    tracks = measured_tracks()
    tracks["image_origin"][12, 0, 1] = EDITED
    found = without_frozen(tracks, {"left": [(110, 114)]})
    frozen = found["image_origin"].to_numpy()[..., 0] == PREDICTED
    assert frozen[10:14, 0, 0].all()
    assert frozen[10:14, 0, 1].tolist() == [True, True, False, True]
    assert frozen.sum() == 7
    assert (found["image_confidence"].to_numpy()[..., 0][frozen] == 0.0).all()
    assert (found["image_confidence"].to_numpy()[..., 0][~frozen] == 0.97).all()
    # the other view has measured them: places in space stand
    assert (found["origin"] == MEASURED).all()
    assert found["image_position"].equals(tracks["image_position"])


def test_places_in_space_are_predicted_where_every_film_stood_still_and_the_verdict_falls():
    tracks = measured_tracks()
    found = without_frozen(tracks, {"left": [(105, 115)], "right": [(108, 115)]})
    in_space = (found["origin"] == PREDICTED).to_numpy()[:, 0, 0]
    assert np.flatnonzero(in_space).tolist() == list(range(8, 15))
    assert (found["confidence"].to_numpy()[in_space] == 0.0).all()
    assert assess_quality(tracks).verdict == "good"
    # 17 of 40 labels of each point were not seen
    worse = assess_quality(found)
    assert worse.verdict == "look"
    assert [round(point.measured, 3) for point in worse.points] == [0.575, 0.575]
    # and why: nobody looks for a fault of the tracker where the film is at fault
    assert worse.reasons[:2] == (
        "the film of view left stands still in frames 105 to 114",
        "the film of view right stands still in frames 108 to 114",
    )
    assert "the film of view left stands still" in worse.line()


def test_a_joint_that_needs_every_view_is_predicted_where_one_film_stood_still():
    found = without_frozen(measured_tracks(), {"right": [(108, 115)]}, needs_all=True)
    in_space = (found["origin"] == PREDICTED).to_numpy()[:, 0, 0]
    assert np.flatnonzero(in_space).tolist() == list(range(8, 15))
    assert (found["image_origin"].to_numpy()[:, 0] == MEASURED).all()


def test_without_a_freeze_tracks_stay_the_same():
    tracks = measured_tracks()
    assert without_frozen(tracks, {}) is tracks
    assert without_frozen(tracks, {"left": [(0, 20)]}) is tracks
    assert freezes_of_tracks(tracks) == {}


def test_tracks_know_where_their_films_stood_still():
    found = without_frozen(measured_tracks(), {"left": [(40, 50), (102, 104), (110, 114)]})
    assert freezes_of_tracks(found) == {"left": [(102, 104), (110, 114)]}
    assert freezes_of_tracks(found.isel(time=slice(0, 8))) == {"left": [(102, 104)]}
