"""Suspects that sound tracks never show: pictures far from the track, leaps, other passes."""

import numpy as np
import pytest
from walking_tracks import RIG, put, walk

from pawnb.core.edits.effects import apply_edit
from pawnb.core.edits.log import Swap
from pawnb.core.suspects.frames import SuspectSettings, find_suspects
from pawnb.core.suspects.limits import collect_limits

PAW_PX = SuspectSettings(paw_px=20.0)


@pytest.fixture
def tracks():
    """The trot of walk(), with its uncertainty and residuals as the default method states them."""
    made, _ = walk()
    made.attrs["units"] = "mm"
    made["sd"] = made["position"].copy(data=np.full(made["position"].shape, 0.3))
    residual = np.random.default_rng(3).uniform(0.2, 0.8, made["image_confidence"].shape)
    made["image_residual"] = made["image_confidence"].copy(data=residual)
    return made


def rows_about(tracks, frame, **options):
    table = find_suspects(tracks, rig=RIG, settings=PAW_PX, **options)
    return table[table["frame"].between(frame - 5, frame + 5)]


def test_sound_tracks_show_none_of_it(tracks):
    shares = [share for doubt in collect_limits(tracks, paw_px=20.0)
              for share in doubt.measures.values()]  # fmt: skip
    # residuals of 0.8 px of a paw of 20; the trot's swing is no faster than its fast tenth
    assert np.nanmax(shares[0]) < 0.05
    assert np.nanmax(shares[1]) < 1.5
    said = "|".join(find_suspects(tracks, rig=RIG, settings=PAW_PX)["reason"])
    assert "leaps" not in said
    assert "from its place" not in said


@pytest.mark.parametrize(("px", "is_listed"), [(17.0, False), (40.0, True)])
def test_a_picture_that_shows_a_paw_elsewhere_than_its_track(tracks, px, is_listed):
    tracks["image_residual"].values[140, 1, 0, 0] = px
    rows = rows_about(tracks, 140)
    said = "|".join(rows["reason"])
    assert ("cam2 shows it 40 px from its place" in said) == is_listed
    if is_listed:
        first = find_suspects(tracks, rig=RIG, settings=PAW_PX).iloc[0]
        assert (first["point"], abs(first["frame"] - 140) <= 5) == ("FR", True)


def test_views_that_disagree_after_a_correction(tracks):
    """A corrected point has no residual in single pictures, but one over all."""
    tracks["image_residual"].values[140, :, 0, 0] = np.nan
    tracks["residual"].values[140, 0, 0] = 40.0
    assert "the views disagree about it by 40 px" in "|".join(rows_about(tracks, 140)["reason"])


def test_a_leap_is_told_in_the_unit_of_space(tracks):
    _, uv = walk()
    uv[140, :, 1] += [60.0, 0.0]
    put(tracks, uv)
    away = tracks["position"].isel(time=slice(139, 142), keypoint=1, individual=0).diff("time")
    [row] = [r for r in rows_about(tracks, 140).to_dict("records") if "leaps" in r["reason"]]
    assert row["point"] == "HR"
    told = float(row["reason"].split("leaps by ")[1].split(" mm")[0])
    # there or back, whichever is farther; the middle velocity of all paws is taken off
    assert told == pytest.approx(float(np.linalg.norm(away, axis=1).max()), abs=1.0)


def test_a_wrong_exchange_of_two_paws_comes_first(tracks):
    wrong = apply_edit(tracks, Swap(frame=170, first="FR", second="HR"), rig=RIG)
    first = find_suspects(wrong, rig=RIG, settings=PAW_PX).iloc[0]
    assert abs(first["frame"] - 170) <= 5
    assert "leaps" in first["reason"]


def test_an_animal_that_stands_still_does_not_leap_when_it_takes_one_step(tracks):
    _, uv = walk()
    still = np.broadcast_to(uv[:1], uv.shape).copy()
    # one step of 25 px in 10 frames, which is no faster than the trot's swing
    still[150:160, :, 0, 0] += np.linspace(0.0, 25.0, 10)[:, None]
    still[160:, :, 0, 0] += 25.0
    put(tracks, still)
    leap = collect_limits(tracks, paw_px=20.0)[1].measures["leap"]
    assert np.nanmax(leap) < 1.8


def test_another_pass_far_off_is_worth_a_look(tracks):
    other = tracks.copy(deep=True)
    other["image_position"].values[200:205, :, 0, 1, 0] += 60.0
    first = find_suspects(tracks, rig=RIG, settings=PAW_PX, other=other).iloc[0]
    assert 195 <= first["frame"] <= 210
    assert "two passes through the recording disagree by 60 px" in first["reason"]
    assert first["score"] > 0.3
