"""Limbs: candidates that always lie at the same place from a paw are that paw's."""

import numpy as np

from pawnb.core.paws.offline.detection.colour.observations import Sights
from pawnb.core.paws.offline.gap_closing.gap_closing import Known, bridge_gaps
from pawnb.core.paws.offline.gap_closing.limb_clutter import learn_limbs
from pawnb.core.paws.offline.projection import Geometry
from pawnb.core.paws.offline.scene.motion_model import Manner

THICKNESS = np.array([8.0])
WRIST = np.array([-6.0, -9.0])


def sights_of(at, n_points, quality=1.0):
    """Candidates (n, C, 2) of one view, NaN where there is none, the same for every point."""
    there = np.isfinite(at[..., 0])
    at = np.nan_to_num(at)
    return Sights(
        at[:, None], np.repeat(at[:, None, None], n_points, axis=1),
        np.full((len(at), 1, at.shape[1]), quality), there[:, None],
    )  # fmt: skip


def walking(n=200, apart=200.0):
    """Two paws far apart; the first has a wrist and there is clutter everywhere."""
    rng = np.random.default_rng(4)
    first = np.column_stack([2.0 * np.arange(n), np.zeros(n)])
    second = first + np.array([apart, 0.0])
    clutter = rng.uniform([-100, -100], [300 + 2.0 * n, 100], (n, 6, 2))
    wrist = first + WRIST + 0.5 * rng.normal(size=first.shape)
    at = np.concatenate([np.stack([first, second, wrist], axis=1), clutter], axis=1)
    return np.stack([first, second], axis=1), at


def test_a_wrist_is_found_and_clutter_is_none():
    places, at = walking()
    n = len(places)
    sights = sights_of(at, 2)
    limbs = learn_limbs(places[:, :, None], np.ones((n, 2)), sights, thickness_px=THICKNESS)
    against = limbs.against(places[:, 0, None], sights, 0, thickness_px=THICKNESS)[:, 0]
    # 200 sightings of it, where another paw is assumed once in a whole field of bins
    assert np.median(against[:, 2]) > 3.0
    assert np.median(against[:, 3:]) < 0.1
    # far from the first paw nothing is its limb, and the second has none
    assert (against[:, 1] == 0).all()
    own = limbs.against(places[:, 1, None], sights, 1, thickness_px=THICKNESS)
    assert np.quantile(own, 0.9) < 0.5


def test_what_is_not_believed_teaches_nothing():
    places, at = walking()
    sights = sights_of(at, 2)
    limbs = learn_limbs(
        places[:, :, None], np.zeros((len(places), 2)), sights, thickness_px=THICKNESS
    )
    assert (limbs.cost == 0).all()


def test_what_looks_better_than_a_wrist_is_none():
    places, at = walking()
    n = len(places)
    poor, good = (sights_of(at, 2, quality) for quality in (0.05, 0.9))
    limbs = learn_limbs(places[:, :, None], np.ones((n, 2)), poor, thickness_px=THICKNESS)
    uv = places[:, 0, None]
    assert np.median(limbs.against(uv, poor, 0, thickness_px=THICKNESS)[:, 0, 2]) > 3.0
    assert (limbs.against(uv, good, 0, thickness_px=THICKNESS)[:, 0, 2] == 0).all()


def test_a_paw_beside_another_is_not_learnt_as_its_limb():
    # the second paw is always where a wrist would be: who is near is left out of the count
    places, at = walking()
    places[:, 1] = places[:, 0] + WRIST
    at[:, 1] = places[:, 1]
    at[:, 2] = np.nan
    limbs = learn_limbs(
        places[:, :, None], np.ones((len(places), 2)), sights_of(at[:, :2], 2),
        thickness_px=THICKNESS,
    )  # fmt: skip
    assert (limbs.cost == 0).all()


def test_a_paw_hidden_beside_another_does_not_take_its_wrist():
    places, at = walking(n=120, apart=200.0)
    # for a while the second paw is hidden where the first one's wrist is
    for t in range(60, 80):
        places[t, 1] = places[t, 0] + WRIST + [1.0, 0.0]
        at[t, 1] = np.nan
    at[:, [1, 2]] = at[:, [2, 1]]
    places[40:60, 1] = places[40:60, 0] + WRIST + [1.0, 0.0]
    places[80:100, 1] = places[80:100, 0] + WRIST + [1.0, 0.0]
    at[40:60, 2] = places[40:60, 1]
    at[80:100, 2] = places[80:100, 1]
    at = at[:, :3]
    chosen = places.copy()
    chosen[60:80, 1] = np.nan
    sights = sights_of(at, 2, quality=0.5)
    manner = Manner(
        acceleration=1.0, jerk=0.6, speed=12.0, drift=np.zeros(2),
        axes=np.array([[1.0, 0.0], [0.0, -1.0]]), ground=-1000.0, span=150.0, thickness=8.0,
    )  # fmt: skip

    def taken(first, last):
        known = Known(chosen[first:last], np.zeros((last - first, 2), bool))
        part = Sights(
            *(getattr(sights, f)[first:last] for f in ("raw", "at", "quality", "is_there"))
        )
        choice = bridge_gaps(
            known, part, geometry=Geometry(None), thickness_px=THICKNESS,
            own=np.ones((2, 1), bool), manner=manner,
        ).choice  # fmt: skip
        return (choice[60 - first : 80 - first, 1, 0] == 1).mean()

    # without the frames that show the wrist alone it is taken for the paw
    assert taken(45, 95) > 0.5
    assert taken(0, 120) < 0.2
