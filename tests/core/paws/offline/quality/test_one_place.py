"""Two names on one place in space."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from pawnb.core.paws.offline.quality.assessment import assess
from pawnb.schema import ORIGIN_CODE, make_tracks

N, FPS, MM = 200, 250.0, 4.0  # four pixels are a millimetre
CLICKS = pd.DataFrame(
    [(0, view, point, 0.0, 0.0) for view, point in
     [("right", "FR"), ("right", "HR"), ("left", "FL"), ("left", "HL")]],
    columns=["frame", "view", "point", "u", "v"],
)  # fmt: skip


def both_sides(*, rides=0, on=3):
    """Tracks of two views; a right paw is drawn in ``right`` only, a left one in ``left`` only.

    FR follows HL (or another, ``on``) for the last ``rides`` frames: no picture shows both.
    """
    tracks = make_tracks(np.arange(N), ["FR", "HR", "FL", "HL"], fps=FPS, views=["right", "left"])
    t = np.arange(N)[:, None]
    x = np.array([60.0, 0.0, 60.0, 0.0]) + 8.0 * np.sin(t / 20 + np.array([0, 2, 3, 1]))
    y = np.tile([0.0, 0.0, 25.0, 25.0], (N, 1))
    place = np.stack([x, y, np.zeros_like(x)], axis=-1)
    if rides:
        place[-rides:, 0] = place[-rides:, on]
    tracks["position"][:] = np.moveaxis(place, -1, 1)[..., None]
    for v, own in ((0, [0, 1]), (1, [2, 3])):
        for p in own:
            tracks["image_position"][:, v, 0, p, 0] = 100 + MM * place[:, p, 0]
            tracks["image_position"][:, v, 1, p, 0] = 300.0
            tracks["image_origin"][:, v, p, 0] = ORIGIN_CODE["measured"]
    tracks["image_confidence"][:] = 1.0
    tracks["origin"][:] = ORIGIN_CODE["measured"]
    return tracks


def right_of(tracks, point, clicks=CLICKS):
    """Return the expected share of right labels of a point, and what speaks against it."""
    own = next(p for p in assess(tracks, clicks=clicks).points if p.name == point)
    return own.expected_right, " ".join(own.reasons)


def test_a_paw_on_the_place_of_one_of_the_other_side_is_told():
    """At most one of two is right: half of the frames in which they share a place."""
    free, said = right_of(both_sides(), "FR")
    assert free > 0.9
    assert "one place" not in said
    shared, said = right_of(both_sides(rides=80), "FR")
    assert shared == pytest.approx(free * (1 - 0.5 * 80 / N), abs=0.03)
    assert "FR and HL lie on one place in 40 % of frames" in said


@pytest.mark.parametrize("rides", [3, 11])
def test_paws_that_pass_each_other_in_space_part_again(rides):
    """11 frames of 250 per second is the longest in the truth of nine rendered scenes."""
    assert "one place" not in right_of(both_sides(rides=rides), "FR")[1]


def test_two_front_paws_share_no_place_for_so_short():
    """In the truth of six rendered scenes none did in any frame; front and hind paw of a side do.

    FR rides on FL (2), or on HL (3), for 11 frames, 0.04 s: as long as where one was mistracked.
    """
    across, alike = (right_of(both_sides(rides=11, on=on), "FR")[0] for on in (3, 2))
    assert across - alike == pytest.approx(0.5 * 11 / (N - 1), abs=0.01)  # one frame was clicked


def test_points_that_were_clicked_side_by_side_may_stay_so():
    """Toes and heel of a foot are always near each other."""
    tracks = both_sides()
    tracks["position"][:, :, 2] = tracks["position"][:, :, 3].to_numpy() + 4.0
    assert "one place" not in right_of(tracks, "FL")[1]
    # 4 mm in each of three directions, of a body of 70: nearer than any two paws
    assert 4.0 * 3**0.5 < 0.12 * 60.0
