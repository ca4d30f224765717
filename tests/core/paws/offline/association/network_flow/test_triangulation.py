"""Places where detections of two views meet: points put in by projection come out again."""

import numpy as np

from pawnb.core import dlt
from pawnb.core.paws.offline.association.network_flow.triangulation import StereoMatcher, Volume
from pawnb.core.paws.offline.detection.colour.detections import ColourDetections
from pawnb.core.paws.offline.detection.colour.likelihood import AppearanceLikelihood

RNG = np.random.default_rng(3)


def camera(angle):
    """Coefficients of a camera that looks at the origin from 300 away, 5 px per unit there."""
    forward = np.array([-np.sin(angle), -np.cos(angle), 0.0])
    right = np.array([-np.cos(angle), np.sin(angle), 0.0])
    rotation = np.stack([right, [0.0, 0.0, -1.0], forward])
    intrinsic = np.array([[1500.0, 0.0, 500.0], [0.0, 1500.0, 300.0], [0.0, 0.0, 1.0]])
    P = intrinsic @ np.column_stack([rotation, [0.0, 0.0, 300.0]])
    return (P / P[2, 3]).ravel()[:11]


COEFS = np.stack([camera(angle) for angle in (0.0, 0.5, 1.1)], axis=1)
VOLUME = Volume(np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0]), (-30.0, 30.0), (-60.0, 60.0))


def candidates(uv):
    """Detections that look like ends pointing down, at some positions."""
    rows = np.zeros((len(uv), 8), np.float32)
    rows[:, :2], rows[:, 3], rows[:, 4], rows[:, 5] = uv, 3.0, 0.3, 5.0
    return ColourDetections(rows)


def pairing(**options):
    return StereoMatcher(
        COEFS, VOLUME, tolerance_px=np.full(3, 2.0),
        likelihood=AppearanceLikelihood([(0.0, 1.0)] * 3, np.full(3, 8.0)),
        **{"apart": 3.0, "most": 8, **options},
    )  # fmt: skip


def test_points_of_every_frame_come_out_in_that_frame():
    points = [RNG.uniform(-25, 25, (k, 3)) for k in (3, 0, 5, 1)]
    found = [[candidates(dlt.project(COEFS, x)[:, v]) for v in range(3)] for x in points]
    found[3][0] = ColourDetections.none()  # two views are enough
    places = pairing(most=60).places(found)
    assert len(places) == 4
    assert len(places[1].at) == 0
    for x, here in zip(points, places, strict=True):
        for point in x:
            # detections are kept as float32
            assert np.linalg.norm(here.at - point, axis=1).min() < 0.01
    # seen by all three views costs nothing, by two of them more
    nearest = np.linalg.norm(places[0].at - points[0][0], axis=1).argmin()
    assert places[0].cost[nearest] < 0.1 < places[3].cost.min()


def test_places_lie_apart_and_the_best_are_kept():
    x = np.array([[0.0, 0.0, 0.0], [20.0, 5.0, 10.0], [-20.0, -5.0, -10.0]])
    uv = dlt.project(COEFS, np.concatenate([x, x + 0.3]))
    [here] = pairing(most=60).places([[candidates(uv[:, v]) for v in range(3)]])
    away = np.linalg.norm(here.at[:, None] - here.at, axis=-1)
    assert away[~np.eye(len(away), dtype=bool)].min() >= 3.0
    assert (np.diff(here.cost) >= 0).all()
    [few] = pairing(most=2).places([[candidates(uv[:, v]) for v in range(3)]])
    np.testing.assert_array_equal(few.at, here.at[:2])


def test_what_lies_outside_the_volume_is_left_out():
    x = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 40.0]])
    uv = dlt.project(COEFS, x)
    [here] = pairing(most=60).places([[candidates(uv[:, v]) for v in range(3)]])
    assert VOLUME.holds(here.at).all()
    assert np.linalg.norm(here.at, axis=1).min() < 0.01
