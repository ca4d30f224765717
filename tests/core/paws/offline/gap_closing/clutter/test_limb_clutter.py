"""Limbs: detections that always lie at the same place from a paw are that paw's."""

import numpy as np
from pipeline_states import known_state

from pawnb.core.paws.offline.detection.colour.observations import Observations
from pawnb.core.paws.offline.gap_closing.clutter.limb_clutter import learn_limb_clutter
from pawnb.core.paws.offline.gap_closing.gap_closing import close_gaps
from pawnb.core.paws.offline.projection import Projection
from pawnb.core.paws.offline.scene.motion_model import MotionModel

THICKNESS = np.array([8.0])
WRIST = np.array([-6.0, -9.0])


def sights_of(at, n_points, detection_probability=1.0):
    """Detections (n, C, 2) of one view, NaN where there is none, the same for every point."""
    there = np.isfinite(at[..., 0])
    at = np.nan_to_num(at)
    return Observations(
        at[:, None], np.repeat(at[:, None, None], n_points, axis=1),
        np.full((len(at), 1, at.shape[1]), detection_probability), there[:, None],
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
    observations = sights_of(at, 2)
    limb_clutter = learn_limb_clutter(
        places[:, :, None], np.ones((n, 2)), observations, paw_width_px=THICKNESS
    )
    negative_log_odds = limb_clutter.negative_log_odds(
        places[:, 0, None], observations, 0, paw_width_px=THICKNESS
    )[:, 0]
    # 200 sightings of it, where another paw is assumed once in a whole field of bins
    assert np.median(negative_log_odds[:, 2]) > 3.0
    assert np.median(negative_log_odds[:, 3:]) < 0.1
    # far from the first paw nothing is its limb, and the second has none
    assert (negative_log_odds[:, 1] == 0).all()
    tracked_in_view = limb_clutter.negative_log_odds(
        places[:, 1, None], observations, 1, paw_width_px=THICKNESS
    )
    assert np.quantile(tracked_in_view, 0.9) < 0.5


def test_what_is_not_believed_teaches_nothing():
    places, at = walking()
    observations = sights_of(at, 2)
    limb_clutter = learn_limb_clutter(
        places[:, :, None], np.zeros((len(places), 2)), observations, paw_width_px=THICKNESS
    )
    assert (limb_clutter.cost == 0).all()


def test_what_looks_better_than_a_wrist_is_none():
    places, at = walking()
    n = len(places)
    poor, good = (sights_of(at, 2, detection_probability) for detection_probability in (0.05, 0.9))
    limb_clutter = learn_limb_clutter(
        places[:, :, None], np.ones((n, 2)), poor, paw_width_px=THICKNESS
    )
    uv = places[:, 0, None]
    assert (
        np.median(limb_clutter.negative_log_odds(uv, poor, 0, paw_width_px=THICKNESS)[:, 0, 2])
        > 3.0
    )
    assert (limb_clutter.negative_log_odds(uv, good, 0, paw_width_px=THICKNESS)[:, 0, 2] == 0).all()


def test_a_paw_beside_another_is_not_learnt_as_its_limb():
    # the second paw is always where a wrist would be: who is near is left out of the count
    places, at = walking()
    places[:, 1] = places[:, 0] + WRIST
    at[:, 1] = places[:, 1]
    at[:, 2] = np.nan
    limb_clutter = learn_limb_clutter(
        places[:, :, None], np.ones((len(places), 2)), sights_of(at[:, :2], 2),
        paw_width_px=THICKNESS,
    )  # fmt: skip
    assert (limb_clutter.cost == 0).all()


def test_a_paw_hidden_beside_another_does_not_take_its_wrist():
    places, at = walking(n=120, apart=200.0)
    # for a while the second paw is occluded where the first one's wrist is
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
    observations = sights_of(at, 2, detection_probability=0.5)
    motion_model = MotionModel(
        acceleration=1.0,
        jerk=0.6,
        speed=12.0,
        substrate_velocity=np.zeros(2),
        axes=np.array([[1.0, 0.0], [0.0, -1.0]]),
        substrate=-1000.0,
        body_scale=150.0,
        paw_width=8.0,
    )

    def taken(first, last):
        state = known_state(chosen[first:last], np.zeros((last - first, 2), bool))
        part = Observations(
            *(
                getattr(observations, f)[first:last]
                for f in ("raw", "at", "detection_probability", "is_there")
            )
        )
        choice = close_gaps(
            state,
            part,
            geometry=Projection(None),
            paw_width_px=THICKNESS,
            tracked_in_view=np.ones((2, 1), bool),
            motion_model=motion_model,
        ).choice
        return (choice[60 - first : 80 - first, 1, 0] == 1).mean()

    # without the frames that show the wrist alone it is taken for the paw
    assert taken(45, 95) > 0.5
    assert taken(0, 120) < 0.2
