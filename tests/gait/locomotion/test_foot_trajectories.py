"""Feet out of Tracks: which space, which animal, how sure."""

from __future__ import annotations

import numpy as np
import pytest

from pawnb.errors import InputError
from pawnb.gait.locomotion.foot_trajectories import (
    get_foot_paths,
    least_confidence,
    notes_on_confidence,
    notes_on_doubtful_places,
    notes_on_placeholders,
    notes_on_views,
)
from pawnb.schema import make_tracks


def test_feet_come_from_the_space_that_saw_them_best():
    tracks = make_tracks(np.arange(10), ["FR", "FL", "HR"], fps=100.0, views=["a", "b"], unit="mm")
    tracks["position"].data[:, :, 0, 0] = 1.0
    tracks["position"].data[:2, :, 1, 0] = 1.0  # in two frames of ten only
    tracks["confidence"].data[:] = 1.0
    tracks["image_position"].data[:, 1, :, 1, 0] = 7.0
    tracks["image_position"].data[:4, 0, :, 1, 0] = 5.0
    tracks["image_confidence"].data[:] = 1.0
    spaces = get_foot_paths(tracks, {"FR": "FR", "FL": "FL", "HR": "HR"})
    assert [(s.source, s.unit, s.legs) for s in spaces] == [
        ("position", "mm", ("FR",)), ("b", "px", ("FL",)),
    ]  # fmt: skip
    assert spaces[0].positions.shape == (10, 3, 1)
    assert (spaces[1].positions == 7.0).all()


def test_unsure_positions_are_missing():
    tracks = make_tracks(np.arange(4), ["FR"], fps=100.0, space=("x", "y"))
    tracks["position"].data[:] = 1.0
    tracks["confidence"].data[:, 0, 0] = [0.2, 0.9, 0.6, np.nan]
    (paths,) = get_foot_paths(tracks, {"FR": "FR"}, min_confidence=0.6)
    assert np.isfinite(paths.positions[:, 0, 0]).tolist() == [False, True, True, True]


def test_bad_input_is_refused():
    tracks = make_tracks(np.arange(4), ["FR"], fps=100.0)
    with pytest.raises(InputError, match=r"^leg 'FR': the tracks have no point 'RF'"):
        get_foot_paths(tracks, {"FR": "RF"})
    with pytest.raises(InputError, match=r"^no individual 'x'; the tracks have animal\.$"):
        get_foot_paths(tracks, {"FR": "FR"}, individual="x")


def test_a_low_confidence_is_only_spoken_of_where_the_tracks_tell_one():
    tracks = make_tracks(
        np.arange(10), ["FR"], fps=100.0, unit="px", source_software="Ensemble Kalman Smoother"
    )
    tracks["position"].data[:] = 1.0
    least = least_confidence(tracks, None)
    assert least == 0.6
    tracks["confidence"].data[:] = 0.7
    (note,) = notes_on_confidence(tracks, least)
    assert note == "positions with a confidence below 0.6 count as missing."
    for none in (np.nan, 0.0):
        tracks["confidence"].data[:] = none
        (note,) = notes_on_confidence(tracks, least)
        assert "tell no confidence" in note
    assert not notes_on_confidence(tracks, least_confidence(tracks, 0.0))


def test_views_that_the_gait_is_not_taken_from_are_said():
    tracks = make_tracks(np.arange(10), ["FR", "FL"], fps=100.0, views=["a", "b", "c"])
    tracks["image_position"].loc[{"view": ["a", "b"]}] = 5.0
    legs = {"FR": "FR", "FL": "FL"}
    (said,) = notes_on_views(tracks, get_foot_paths(tracks, legs))
    assert said.startswith("the gait is that seen in a alone; b is not used, as the views are not")
    # both are used where a leg is seen in the other one only, and space goes before all views
    tracks["image_position"].loc[{"view": "a", "keypoint": "FL"}] = np.nan
    assert notes_on_views(tracks, get_foot_paths(tracks, legs)) == []
    tracks["position"].data[:] = 1.0
    assert notes_on_views(tracks, get_foot_paths(tracks, legs)) == []


def test_feet_where_lost_points_are_put_are_told():
    tracks = make_tracks(np.arange(10), ["FR", "FL"], fps=100.0, space=("x", "y"), unit="px")
    tracks["position"].data[:] = 5.0
    legs = {"FR": "FR", "FL": "FL"}
    tracks["position"].data[:2, :, 0] = 0.0
    tracks["position"].data[:, 0, 1] = 0.0  # along an edge, and not in the corner
    assert notes_on_placeholders(get_foot_paths(tracks, legs)) == []
    tracks["position"].data[4:6, :, 0] = 0.0
    tracks["position"].data[4:7, :, 1] = -1.0
    zero, minus = notes_on_placeholders(get_foot_paths(tracks, legs))
    assert zero.startswith("exactly at (0, 0): FR in 4 frames. So some programs")
    assert minus.startswith("exactly at (-1, -1): FL in 3 frames.")


@pytest.mark.parametrize(
    ("program", "least"),
    [("LightningPose", 0.6), ("DeepLabCut/LightningPose", 0.6), ("Lightning Pose", 0.6),
     ("SLEAP", 0.0), ("Anipose", 0.0), ("pawnb", 0.0)],
)  # fmt: skip
def test_programs_are_known_as_movement_calls_them(program, least):
    # movement 0.17, io/load.py: "LightningPose" and "DeepLabCut/LightningPose"
    tracks = make_tracks(range(2), ["FR"], fps=100.0, source_software=program)
    assert least_confidence(tracks, None) == least


def doubtful(program="Anipose"):
    """100 places of two feet: FR doubted in a fifth of them in every way, FL in two."""
    tracks = make_tracks(range(100), ["FR", "FL"], fps=100.0, unit="mm", source_software=program)
    tracks["position"].data[:] = 1.0
    tracks["confidence"].data[:] = 0.9
    tracks["confidence"].data[:20, 0], tracks["confidence"].data[:2, 1] = 0.1, 0.1
    tracks["residual"].data[:] = 2.0
    tracks["residual"].data[20:40, 0] = 30.0
    tracks["n_views"] = tracks["residual"] * 0 + 3.0
    tracks["n_views"].data[40:60, 0] = np.nan
    return tracks


def test_places_that_anipose_doubts_are_said():
    told = {"legs": {"FR": "FR", "FL": "FL"}, "individual": "animal"}
    low, few, far = notes_on_doubtful_places(doubtful(), **told, least=0.0)
    assert low.startswith("FR 20 % of the places count though they have a confidence below 0.6")
    assert few.startswith("FR 20 % of the places count though they have been seen by fewer than")
    assert far.startswith("FR 20 % of the places count though they have a reprojection error")
    assert notes_on_doubtful_places(doubtful(), **told, least=0.6) == [few, far]
    assert notes_on_doubtful_places(doubtful("table").drop_vars("n_views"), **told, least=0.0) == [
        low
    ]
    for program in ("SLEAP", "pawnb"):
        assert notes_on_doubtful_places(doubtful(program), **told, least=0.0) == []
