"""Estimates of views as Tracks: a sound place in space shows where a view does not see it."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from scipy.optimize import least_squares

from pawnb.core.paws.layout import Placement, make_layout
from pawnb.core.paws.maghsoudi2019.settings import Maghsoudi2019Settings
from pawnb.core.paws.offline.output import write_tracks
from pawnb.core.paws.offline.pipeline import ViewTrack
from pawnb.core.paws.request import TrackingRequest
from pawnb.core.rig import Rig
from pawnb.schema import ORIGIN_CODE

SIZE = (120, 90)
XYZ = np.array([[3.0, 2.0, -4.0], [2.0, 2.5, -3.0], [1.0, 3.0, -2.0]])
"""One point in three frames, mm."""


def look_at(position):
    """Projection matrix (3, 4) of a camera that looks at the origin from a position, Z up."""
    position = np.asarray(position, float)
    z = -position / np.linalg.norm(position)
    x = np.cross(z, [0.0, 0.0, 1.0])
    x /= np.linalg.norm(x)
    R = np.stack([x, np.cross(z, x), z])
    K = np.array([[300.0, 0, 60.0], [0, 300.0, 45.0], [0, 0, 1]])
    return K @ np.c_[R, -R @ position]


CAMERAS = {
    name: look_at(position)
    for name, position in {
        "left": (-60, -100, 0), "right": (60, -100, 30), "top": (0, -60, 110)
    }.items()
}  # fmt: skip
RIG = Rig(tuple(CAMERAS), np.stack([(P / P[2, 3]).ravel()[:11] for P in CAMERAS.values()], axis=1))


def shown(xyz, P):
    """Picture of a place by the projection matrix itself."""
    u, v, w = P @ np.append(xyz, 1)
    return np.array([u, v]) / w


TRUTH = np.stack([[shown(xyz, P) for P in CAMERAS.values()] for xyz in XYZ])
"""(frames, views, 2) by the projection matrices themselves."""


@pytest.fixture
def layout(array_views):
    films = {name: np.zeros((3, SIZE[1], SIZE[0]), np.uint8) for name in CAMERAS}

    def start(points):
        rows = [
            (0, name, point, *TRUTH[0, v]) for v, name in enumerate(CAMERAS) for point in points
        ]
        return pd.DataFrame(rows, columns=["frame", "view", "point", "u", "v"])

    return lambda rig, points=("FR",): make_layout(
        array_views(films),
        start(points),
        TrackingRequest(frames=(0, 3), fps=100.0, rig=rig),
        settings=Maghsoudi2019Settings(),
    )


def found(chance, uv=TRUTH):
    """Return tracks of the views; chance (frames, views)."""
    chance = np.broadcast_to(chance, (3, 3)).astype(float)
    return [
        ViewTrack(uv[:, v, None].copy(), chance[:, v, None].copy(), np.ones((3, 1)))
        for v in range(3)
    ]


def written(layout, tracks, rig=RIG, placed=None):
    task = TrackingRequest(frames=(0, 3), fps=100.0, rig=rig)
    return write_tracks(tracks, layout(rig), task, placed=placed or {})


def origins(tracks):
    codes = tracks["image_origin"].isel(individual=0, keypoint=0).to_numpy()
    names = {code: name for name, code in ORIGIN_CODE.items()}
    return [[names[int(code)] for code in row] for row in codes]


def test_places_in_space_are_those_of_which_the_views_are_pictures(layout):
    tracks = written(layout, found(0.9))
    place = tracks["position"].isel(individual=0, keypoint=0).to_numpy()
    np.testing.assert_allclose(place, XYZ, atol=1e-6)
    assert origins(tracks) == [["measured"] * 3] * 3
    assert (tracks["sd"].to_numpy() > 0).all()


def test_places_in_space_are_as_vague_as_the_views_disagree(layout):
    """Off by up to 8 px where each states 1 px; the sum of squares by SciPy's least squares."""
    apart = TRUTH.copy()
    apart[1, 0] += (0.0, -4.0)
    apart[1, 1] += (0.0, 8.0)

    def off(xyz):
        return np.concatenate([shown(xyz, P) for P in CAMERAS.values()]) - apart[1].ravel()

    solved = least_squares(off, XYZ[1])
    variance = np.linalg.inv(solved.jac.T @ solved.jac).diagonal() * (2 * solved.cost / 3)
    sd = written(layout, found(0.9, apart))["sd"].isel(individual=0, keypoint=0).to_numpy()
    np.testing.assert_allclose(sd[1], np.sqrt(variance), rtol=0.05)
    agreed = written(layout, found(0.9))["sd"].isel(individual=0, keypoint=0).to_numpy()
    np.testing.assert_allclose(sd[[0, 2]], agreed[[0, 2]])
    assert (sd[1] > 2 * agreed[1]).all()


def test_a_view_that_does_not_see_the_point_shows_where_the_others_put_it(layout):
    astray = TRUTH.copy()
    astray[1, 2] += (30, -20)
    chance = np.full((3, 3), 0.9)
    chance[1, 2] = 0.2
    tracks = written(layout, found(chance, astray))
    uv = tracks["image_position"].isel(individual=0, keypoint=0).to_numpy()
    np.testing.assert_allclose(uv, TRUTH, atol=1e-4)
    assert origins(tracks)[1] == ["measured", "measured", "reprojected"]
    sure = tracks["image_confidence"].isel(individual=0, keypoint=0).to_numpy()
    # views are right together: odds 9, 9 and 1/4 have the geometric mean 20.25 ** (1 / 3)
    np.testing.assert_allclose(sure[1], 1 / (1 + 20.25 ** (-1 / 3)))
    np.testing.assert_allclose(sure[0], 0.9)


@pytest.mark.parametrize("own", [0.9, 0.3])
def test_a_view_that_has_the_point_elsewhere_is_doubted_or_shows_where_the_others_have_it(
    layout, own
):
    """Half a paw is 0.055 of the size of all four. Odds 9, 9 and 3/7 have a geometric mean."""
    points = ("FL", "FR", "HL", "HR")
    uv = np.array([[[shown(x, P) for x in here] for here in PAWS] for P in CAMERAS.values()])
    truth = uv[2, 1, 0].copy()
    uv[2, 1, 0] += (8, 0)
    chance = np.full(uv.shape[:3], 0.9)
    chance[2, 1, 0] = own
    tracks = [ViewTrack(*view, np.ones(view[1].shape)) for view in zip(uv, chance, strict=True)]
    task = TrackingRequest(frames=(0, 3), fps=100.0, rig=RIG)
    written_ = write_tracks(tracks, layout(RIG, points), task, placed={}).isel(individual=0)
    sure = written_["image_confidence"].to_numpy()
    if own > 0.5:
        assert sure[1, 2, 0] < 0.5
    else:
        np.testing.assert_allclose(sure[1, :, 0], 1 / (1 + (81 * 3 / 7) ** (-1 / 3)))
        np.testing.assert_allclose(written_["image_position"][1, 2, :, 0], truth, atol=1e-4)
    np.testing.assert_allclose(sure[[0, 2]], 0.9)
    np.testing.assert_allclose(sure[1, :, 1:], 0.9)


@pytest.mark.parametrize(("off_px", "alone"), [(20, True), (8, False)])
def test_a_view_whose_click_the_others_miss_does_not_show_where_they_put_the_point(
    layout, off_px, alone
):
    # the other views are sure of a place so far from what a person clicked in the third. Half a paw
    # is 1.2 px in pictures as small as these; no click is so exact
    points = ("FL", "FR", "HL", "HR")
    uv = np.array([[[shown(x, P) for x in here] for here in PAWS] for P in CAMERAS.values()])
    truth = uv[2, :, 0].copy()
    uv[2, :, 0] += (off_px, 0)
    chance = np.full(uv.shape[:3], 0.9)
    chance[2, 1:, 0] = 0.3
    tracks = [ViewTrack(*view, np.ones(view[1].shape)) for view in zip(uv, chance, strict=True)]
    clicks = [Placement(v, p, uv[v, 0, p]) for v in range(3) for p in range(4)]
    task = TrackingRequest(frames=(0, 3), fps=100.0, rig=RIG)
    own = write_tracks(tracks, layout(RIG, points), task, placed={0: clicks}).isel(individual=0)
    third = own.isel(time=slice(1, None), view=2, keypoint=0)
    if alone:
        np.testing.assert_array_equal(third["image_position"], uv[2, 1:, 0])
        np.testing.assert_allclose(third["image_confidence"], 0.3)
        assert (third["image_origin"] == ORIGIN_CODE["predicted"]).all()
    else:
        np.testing.assert_allclose(third["image_position"], truth[1:], atol=1e-4)
        assert (third["image_origin"] == ORIGIN_CODE["reprojected"]).all()
    # all else is as it is without
    np.testing.assert_allclose(own["image_confidence"][1:, :, 1:], 0.9)


def test_what_is_hardly_likely_is_missing_and_what_was_placed_is_not(layout):
    placed = {2: [Placement(0, 0, TRUTH[2, 0] + 1)]}
    chance = np.array([[0.9] * 3, [0.3, 0.3, 0.01], [0.01] * 3])
    tracks = written(layout, found(chance), rig=None, placed=placed)
    assert origins(tracks) == [
        ["measured"] * 3,
        ["predicted", "predicted", "missing"],
        ["edited", "missing", "missing"],
    ]
    uv = tracks["image_position"].isel(individual=0, keypoint=0).to_numpy()
    np.testing.assert_allclose(uv[2, 0], TRUTH[2, 0] + 1)
    assert np.isnan(uv[2, 1:]).all()
    assert tracks["image_confidence"].isel(individual=0, keypoint=0)[2, 0] == 1


def seen_at(layout, xyz, chance, placed=None):
    """Write points seen by all views at places (frames, points, 3), as likely as chance (P,)."""
    points = ("FL", "FR", "HL", "HR")
    uv = np.array([[[shown(x, P) for x in here] for here in xyz] for P in CAMERAS.values()])
    tracks = [
        ViewTrack(own.copy(), np.broadcast_to(chance, own.shape[:2]).copy(), np.ones(own.shape[:2]))
        for own in uv
    ]
    task = TrackingRequest(frames=(0, 3), fps=100.0, rig=RIG)
    return write_tracks(tracks, layout(RIG, points), task, placed=placed or {})


PAWS = np.repeat([[[4.0, 2, 0], [4.0, -2, 0], [-4.0, 2, 0], [-4.0, -2, 0]]], 3, axis=0)
"""FL, FR, HL, HR, mm."""


def test_a_place_in_space_belongs_to_one_name(layout):
    shared = PAWS.copy()
    shared[1, 0] = shared[1, 1]
    tracks = seen_at(layout, shared, [0.1, 0.9, 0.9, 0.9])
    sure = tracks["image_confidence"].isel(individual=0)
    # 0.1 * 0.1 / 0.91: missing; 0.9 * 0.9 / 0.91
    assert (sure.sel(keypoint="FL").to_numpy()[1] == 0).all()
    assert np.isnan(tracks["image_position"].sel(keypoint="FL").to_numpy()[1]).all()
    np.testing.assert_allclose(sure.sel(keypoint="FR").to_numpy()[1], 0.81 / 0.91, atol=1e-6)
    np.testing.assert_allclose(sure.sel(keypoint="FL").to_numpy()[[0, 2]], 0.1)


def test_no_place_in_space_lies_beyond_the_body_but_one_that_was_placed(layout):
    astray = PAWS.copy()
    astray[1, 0] = (4, 30, 0)  # the body is 9 mm long
    tracks = seen_at(layout, astray, 0.9)
    known = np.isfinite(tracks["position"].sel(keypoint="FL").isel(individual=0).to_numpy())
    assert known.all(axis=1).tolist() == [True, False, True]
    placed = {1: [Placement(v, 0, shown(astray[1, 0], P)) for v, P in enumerate(CAMERAS.values())]}
    tracks = seen_at(layout, astray, 0.9, placed)
    found = tracks["position"].sel(keypoint="FL").isel(individual=0).to_numpy()
    np.testing.assert_allclose(found[1], (4, 30, 0), atol=1e-3)
