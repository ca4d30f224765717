"""Patches about the clicks are found again, and scores mean what they say."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.detection import correlation
from pawnb.core.paws.offline.detection.correlation import detect_by_correlation, scores_of_point
from pawnb.core.paws.offline.detection.evidence import Detections
from pawnb.core.paws.offline.parameters import CorrelationParameters

N = 12
PARAMETERS = CorrelationParameters(reach=1.0)  # the made stack says that its animal has 60 px
NOTHING = Detections(np.empty(0, int), np.empty(0, int), np.empty((0, 2)), np.empty(0), np.empty(0))


def way(t):
    """It jumps to and fro, too far for flow."""
    return np.array([40.0 + 44 * (t % 2), 40.0 + t])


def film(make_texture, *, degrees=0.0, seed=3, copies=(), shown=None):
    ground = make_texture(90, 130, low=60, high=160)
    patch = make_texture(41, 41, seed=seed, low=0, high=255)
    pictures = np.repeat(ground[None], N, axis=0)
    for t in range(N):
        turn = cv2.getRotationMatrix2D((20, 20), degrees * t, 1.0)
        turned = cv2.warpAffine(patch, turn, (41, 41), borderMode=cv2.BORDER_REPLICATE)[5:36, 5:36]
        for u, v in [way(t), *copies] if shown is None or t in shown else []:
            u, v = int(u), int(v)
            pictures[t, v - 15 : v + 16, u - 15 : u + 16] = turned
    return pictures


def find(stack, rows=(4,), followed=NOTHING):
    clicks = Annotations({row: {0: way(row)} for row in rows})
    return detect_by_correlation(stack, clicks, PARAMETERS, radius_px=8.0, followed=followed)


def best(found):
    """Return the likeliest place of every row."""
    return {
        t: found.uv[found.row == t][found.log_odds[found.row == t].argmax()]
        for t in np.unique(found.row)
    }


@pytest.mark.parametrize("degrees", [0.0, 2.0])
def test_a_patch_is_found_again_wherever_it_jumps_and_turned_a_little(
    make_stack, make_texture, degrees
):
    places = best(find(make_stack(film(make_texture, degrees=degrees))))
    assert sorted(places) == [t for t in range(N) if t != 4]
    for t, uv in places.items():
        np.testing.assert_allclose(uv, way(t), atol=1.6)


def test_where_nothing_stands_out_nothing_is_said(make_stack, make_texture):
    """The clicked patch is shown in the clicked frame only."""
    there = find(make_stack(film(make_texture))).log_odds
    nowhere = find(make_stack(film(make_texture, shown=(4,)))).log_odds
    assert np.exp(there).max() > 0.8 * (PARAMETERS.gain - 1)
    assert np.exp(nowhere).sum() < 0.5 * np.exp(there).sum()


def test_two_places_that_look_alike_are_both_taken(make_stack, make_texture):
    pictures = film(make_texture, copies=[(100, 70)])
    found = find(make_stack(pictures))
    for t in (0, 2, 6, 8):  # far from the copy
        places = found.uv[(found.row == t) & (found.log_odds > 0)]
        off = np.linalg.norm(places[:, None] - np.array([way(t), (100, 70)]), axis=-1).min(axis=0)
        assert (off < 2).all()


def test_scores_where_flow_is_sure_say_how_high_those_of_the_point_are():
    """A normal distribution with ten scores' worth of one of mean 4 and sd 1.5 beforehand."""
    assert scores_of_point(np.array([np.nan])) == (4.0, 1.5)
    seen = np.array([1.0, 3.0] * 15 + [np.nan])
    mean, sd = scores_of_point(seen)
    every = np.concatenate([[4 - 1.5, 4 + 1.5] * 5, seen[:-1]])
    assert mean == pytest.approx(every.mean())
    assert sd == pytest.approx(every.std())


def test_scores_are_read_where_flow_leads(make_stack, make_texture, monkeypatch):
    """High ones on the patch; none where flow is not sure."""
    stack, seen = make_stack(film(make_texture)), []
    monkeypatch.setattr(
        correlation, "scores_of_point", lambda own: seen.append(own) or scores_of_point(own)
    )
    rows = np.array([t for t in range(N) if t != 4])
    sure = np.where(rows < 6, 2.7, 0.1)
    followed = Detections(
        rows, np.zeros(len(rows), int), np.array([way(t) for t in rows]), sure, np.ones(len(rows))
    )
    find(stack, followed=followed)
    np.testing.assert_array_equal(np.isfinite(seen[0]), sure > 1)
    assert np.nanmin(seen[0]) > 4


def test_the_nearest_click_is_the_pattern(make_stack, make_texture):
    pictures = film(make_texture)
    pictures[6:] = film(make_texture, seed=8)[6:]
    one = best(find(make_stack(pictures), rows=(2,)))
    two = best(find(make_stack(pictures), rows=(2, 9)))
    assert max(np.linalg.norm(two[t] - way(t)) for t in two) < 2
    assert max(np.linalg.norm(one[t] - way(t)) for t in one if t >= 6) > 10
