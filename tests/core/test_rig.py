"""Rigs: read, converted between pixel conventions, fitted; directions and epipolar lines."""

from __future__ import annotations

import dataclasses

import numpy as np
import pandas as pd
import pytest

from pawnb.core import dlt
from pawnb.core.calibration.rig_from_points import fit_rig
from pawnb.core.reconstruct import triangulate_tracks
from pawnb.core.rig import Rig, load_rig, require_rig
from pawnb.errors import CalibrationError, InputError
from pawnb.io.coefs import write_coefs
from pawnb.schema import ORIGIN_CODE, make_tracks
from pawnb.trial import Animal, Calibration, Trial, View

SIZE = (2048, 700)


def look_at(position, target, *, focal_px=1500.0, centre=(1024.0, 350.0)):
    """Coefficients of a pinhole camera at ``position`` that looks at ``target``, Z up."""
    position, target = np.asarray(position, float), np.asarray(target, float)
    z = target - position
    z /= np.linalg.norm(z)
    x = np.cross(z, [0.0, 0.0, 1.0])
    x /= np.linalg.norm(x)
    R = np.stack([x, np.cross(z, x), z])
    K = np.array([[focal_px, 0, centre[0]], [0, focal_px, centre[1]], [0, 0, 1]])
    P = K @ np.c_[R, -R @ position]
    return (P / P[2, 3]).ravel()[:11]


@pytest.fixture
def treadmill():
    """Two cameras on each side of a belt along X: cam1, cam2 at -Y, cam3, cam4 at +Y.

    From -Y (the animal's right when it runs along +X) it faces right in the picture.
    """
    positions = [[-300, -700, 250], [300, -700, 250], [-300, 700, 250], [300, 700, 250]]
    coefs = np.stack([look_at(p, [0, 0, 20]) for p in positions], axis=1)
    return Rig(("cam1", "cam2", "cam3", "cam4"), coefs)


def write_trial(folder, coefs, views, **calibration):
    """A trial in ``folder`` whose DLTcoefs.csv holds ``coefs``."""
    np.savetxt(folder / "DLTcoefs.csv", coefs, delimiter=",", fmt="%.17g")
    return Trial(
        kind="paws", name="t", fps=250.0, animal=Animal(id="m"), folder=folder, views=views,
        calibration=Calibration(dlt="DLTcoefs.csv", **calibration),
    )  # fmt: skip


def plain_views(rig):
    return tuple(View(name=name, video=f"{name}.avi") for name in rig.names)


# --- reading -------------------------------------------------------------------------------


def test_coefficients_are_read_in_the_order_of_the_views(tmp_path, treadmill):
    trial = write_trial(tmp_path, treadmill.coefs, plain_views(treadmill), unit="cm")
    rig = load_rig(trial)
    assert rig.names == ("cam1", "cam2", "cam3", "cam4")
    np.testing.assert_array_equal(rig.coefs, treadmill.coefs)
    assert (rig.unit, rig.forward, rig.up) == ("cm", (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    assert not rig.coefs.flags.writeable


def test_saved_coefficients_are_the_same_to_the_last_bit(tmp_path, treadmill):
    trial = write_trial(tmp_path, np.zeros((11, 4)), plain_views(treadmill))
    write_coefs(treadmill.coefs, tmp_path / "DLTcoefs.csv")
    assert load_rig(trial) == treadmill
    assert sorted(p.name for p in tmp_path.iterdir()) == ["DLTcoefs.csv"]
    with pytest.raises(CalibrationError, match=r"shape \(10, 4\); expected 11 rows of finite"):
        write_coefs(treadmill.coefs[:10], tmp_path / "DLTcoefs.csv")


@pytest.mark.parametrize("calibration", [None, Calibration(px_per_unit=4.8)])
def test_without_dlt_there_is_no_rig(calibration):
    trial = Trial(
        kind="paws", name="run 3", fps=1.0, animal=Animal(id="a"), calibration=calibration
    )
    assert load_rig(trial) is None
    with pytest.raises(CalibrationError, match=r"^trial 'run 3' has no DLT calibration; add \[cal"):
        require_rig(trial)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1,2,3\n" * 11, r"DLTcoefs.csv: 11 rows and 3 columns; expected 11 rows and 4 columns, "
         r"one for each view \(cam1, cam2, cam3, cam4\), and no header."),
        ("1,2,3,4\n" * 12, "12 rows and 4 columns; expected 11 rows and 4"),
        ("1,2,3,4\n" * 10 + "1,2,x,4\n", "row 11, column 3 is 'x'; expected a number."),
        ("1,2,3,4\n" * 10 + "1,2,,4\n", "row 11, column 3 is empty; expected a number."),
        ("1,2,3,4\n" * 10 + "1,2,inf,4\n", "row 11, column 3 is 'inf'"),
        ("", "not a table of numbers; expected 11 rows, one column a view, no header."),
        ("1,2,3,4\n" * 10 + "1,2,3,4,5,6\n", "not a table of numbers"),
    ],
)  # fmt: skip
def test_bad_files_are_refused_in_one_sentence(tmp_path, treadmill, text, message):
    trial = write_trial(tmp_path, treadmill.coefs, plain_views(treadmill))
    (tmp_path / "DLTcoefs.csv").write_text(text)
    with pytest.raises(CalibrationError, match=message):
        load_rig(trial)


def test_a_missing_file_is_named(tmp_path, treadmill):
    trial = write_trial(tmp_path, treadmill.coefs, plain_views(treadmill))
    (tmp_path / "DLTcoefs.csv").unlink()
    with pytest.raises(
        CalibrationError,
        match=r"DLTcoefs.csv: no such file; expected .* that \[calibration\] dlt names",
    ):
        load_rig(trial)


# --- pixels of the file, of the view, and upwards ---------------------------------------------


def cloud(n=20):
    return np.random.default_rng(0).uniform(-40, 40, (n, 3))


def test_coefficients_of_the_whole_picture_follow_crop_and_mirror(tmp_path, treadmill):
    # what a crop from (100, 60) to (1500, 500) does to a pixel, and then a mirror: the
    # cropped picture is 1400 px wide, so column u becomes 1399 - u
    views = (
        View(name="cam1", video="a", crop=(100, 60, 1500, 500)),
        View(name="cam2", video="a", crop=(100, 60, 1500, 500), mirror=True),
        View(name="cam3", video="a", mirror=True),
        View(name="cam4", video="a"),
    )
    trial = write_trial(tmp_path, treadmill.coefs, views, pixels="file")
    rig = load_rig(trial, sizes=dict.fromkeys(treadmill.names, SIZE))
    whole, seen = treadmill.project(cloud()), rig.project(cloud())
    np.testing.assert_allclose(seen[:, 0], whole[:, 0] - [100, 60], atol=1e-7)
    np.testing.assert_allclose(seen[:, 1, 0], 1399 - (whole[:, 1, 0] - 100), atol=1e-7)
    np.testing.assert_allclose(seen[:, 1, 1], whole[:, 1, 1] - 60, atol=1e-7)
    np.testing.assert_allclose(seen[:, 2, 0], 2047 - whole[:, 2, 0], atol=1e-7)
    np.testing.assert_allclose(seen[:, 3], whole[:, 3], atol=1e-7)
    np.testing.assert_allclose(rig.triangulate(seen).xyz, cloud(), atol=1e-6)
    # the same trial with coefficients that belong to the views already: nothing changes
    same = load_rig(
        dataclasses.replace(trial, calibration=Calibration(dlt="DLTcoefs.csv")), sizes=None
    )
    np.testing.assert_array_equal(same.coefs, treadmill.coefs)


def test_a_pixel_of_a_picture_goes_where_the_rig_says(tmp_path, treadmill):
    # rendered truth: one bright pixel, cropped and mirrored as arrays
    point = np.array([5.0, -3.0, 12.0])
    u, v = np.rint(treadmill.project(point)[0]).astype(int)
    picture = np.zeros((SIZE[1], SIZE[0]))
    picture[v, u] = 1
    u0, v0, u1, v1 = 800, 100, 1300, 600
    row, column = np.argwhere(picture[v0:v1, u0:u1][:, ::-1])[0]
    views = (View(name="cam1", video="a", crop=(u0, v0, u1, v1), mirror=True),)
    trial = write_trial(tmp_path, treadmill.coefs[:, :1], views, pixels="file")
    found = load_rig(trial).project(point)[0]
    np.testing.assert_allclose(found, [column, row], atol=0.5)


def test_v_up_is_that_of_dltdv_7(tmp_path, treadmill):
    # DLTdv 7 counts from 1 at the centre of the bottom-left pixel: the top-left pixel of a
    # picture 700 px high is (1, 700), the one right of it (2, 700), the bottom row is v = 1
    up = np.stack(
        [
            dlt.transform_image(L, np.array([[1.0, 0, 1], [0, -1, 700], [0, 0, 1]]))
            for L in treadmill.coefs.T
        ],
        axis=1,
    )
    uv = treadmill.project(cloud())
    np.testing.assert_allclose(
        dlt.project(up, cloud()), np.stack([uv[..., 0] + 1, 700 - uv[..., 1]], -1), atol=1e-7
    )
    trial = write_trial(tmp_path, up, plain_views(treadmill), v="up")
    rig = load_rig(trial, sizes=dict.fromkeys(treadmill.names, SIZE))
    np.testing.assert_allclose(rig.project(cloud()), uv, atol=1e-7)


def test_v_up_of_a_cropped_view(tmp_path, treadmill):
    view = View(name="cam1", video="a", crop=(100, 60, 1500, 500))
    coefs = treadmill.coefs[:, :1]
    whole = dlt.project(coefs, cloud())[:, 0]
    flip = {h: np.array([[1.0, 0, 1], [0, -1, h], [0, 0, 1]]) for h in (700, 440)}
    shift = np.array([[1.0, 0, -100], [0, 1, -60], [0, 0, 1]])
    of_file = dlt.transform_image(coefs[:, 0], flip[700])[:, None]
    of_view = dlt.transform_image(coefs[:, 0], flip[440] @ shift)[:, None]
    for pixels, values, sizes in (("file", of_file, {"cam1": SIZE}), ("view", of_view, None)):
        trial = write_trial(tmp_path, values, (view,), pixels=pixels, v="up")
        found = load_rig(trial, sizes=sizes).project(cloud())[:, 0]
        np.testing.assert_allclose(found, whole - [100, 60], atol=1e-7)


@pytest.mark.parametrize(
    ("calibration", "view", "why"),
    [
        ({"v": "up"}, View(name="cam1", video="a"), 'v = "up"'),
        ({"v": "up", "pixels": "file"}, View(name="cam1", video="a", crop=(0, 0, 9, 9)), "v = "),
        ({"pixels": "file"}, View(name="cam1", video="a", mirror=True), "mirror = true"),
    ],
)
def test_a_size_that_is_needed_is_asked_for(tmp_path, treadmill, calibration, view, why):
    trial = write_trial(tmp_path, treadmill.coefs[:, :1], (view,), **calibration)
    with pytest.raises(CalibrationError, match=f"view 'cam1': the size of its picture.*{why}"):
        load_rig(trial)
    assert load_rig(trial, sizes={"cam1": SIZE}) is not None


# --- the rig itself -----------------------------------------------------------------------------


def test_subset_keeps_names_and_columns_together(treadmill):
    part = treadmill.subset(["cam4", "cam1"])
    assert part.names == ("cam4", "cam1")
    np.testing.assert_array_equal(part.coefs, treadmill.coefs[:, [3, 0]])
    with pytest.raises(CalibrationError, match="view 'cam9' is not calibrated"):
        treadmill.subset(["cam9"])


def test_a_rig_must_fit_its_names(treadmill):
    with pytest.raises(CalibrationError, match=r"shape \(11, 4\); expected 11 rows and one column"):
        Rig(("a", "b"), treadmill.coefs)
    with pytest.raises(CalibrationError, match="that of no camera"):
        Rig(("a",), np.full((11, 1), np.nan))


def test_facing_on_both_sides_of_a_treadmill(treadmill):
    assert [treadmill.facing(n) for n in treadmill.names] == [1, 1, -1, -1]
    backwards = dataclasses.replace(treadmill, forward=(-1.0, 0.0, 0.0))
    assert [backwards.facing(n) for n in treadmill.names] == [-1, -1, 1, 1]


def test_facing_of_a_mirrored_picture_turns(tmp_path, treadmill):
    views = tuple(View(name=n, video="a", mirror=True) for n in treadmill.names)
    trial = write_trial(tmp_path, treadmill.coefs, views, pixels="file")
    rig = load_rig(trial, sizes=dict.fromkeys(treadmill.names, SIZE))
    assert [rig.facing(n) for n in rig.names] == [-1, -1, 1, 1]


def test_facing_where_the_origin_is_behind_a_camera(treadmill):
    # the same cameras in coordinates whose origin lies 2 m behind cam1
    shift = np.array([-300.0, -2700.0, 250.0])
    move = np.eye(4)
    move[:3, 3] = shift
    coefs = []
    for L in treadmill.coefs.T:
        P = dlt.to_matrix(L) @ move
        coefs.append((P / P[2, 3]).ravel()[:11])
    moved = Rig(treadmill.names, np.stack(coefs, axis=1))
    np.testing.assert_allclose(moved.project(cloud() - shift), treadmill.project(cloud()))
    assert [moved.facing(n) for n in moved.names] == [1, 1, -1, -1]
    assert [moved.facing(n, at=-shift) for n in moved.names] == [1, 1, -1, -1]


def test_facing_of_affine_views():
    side = [2.0, 0, 0, 10, 0, 0, -2.0, 200, 0, 0, 0]
    below_mirrored = [-2.0, 0, 0, 400, 0, 2.0, 0, 40, 0, 0, 0]
    rig = Rig(("side", "below"), np.array([side, below_mirrored]).T)
    assert (rig.facing("side"), rig.facing("below")) == (1, -1)


def test_a_view_along_forward_faces_neither_way(treadmill):
    front = Rig(("front",), look_at([900, 0, 40], [0, 0, 20])[:, None])
    with pytest.raises(
        CalibrationError, match=r"view 'front': a step along forward .* give facing"
    ):
        front.facing("front")
    assert dataclasses.replace(front, forward=(0.0, 1.0, 0.0)).facing("front") == 1


def test_facing_of_the_real_rigs(real_data):
    # SOURCE.txt: the rats' pictures of cameras 3 and 4 were mirrored so that all face the
    # same way, so as filmed cameras 1, 2 see it face the other way than 3, 4
    coefs = np.loadtxt(
        real_data("rat-4cam-tracks") / "DLT.rat2.week0.2018-06-08_13_29_13.csv", delimiter=","
    )
    rig = Rig(("cam1", "cam2", "cam3", "cam4"), coefs)
    assert [rig.facing(n) for n in rig.names] == [-1, -1, 1, 1]
    side = real_data("mouse-side-bottom") / "DLT_affine_fitted_from_labels.csv"
    mouse = Rig(("cam1", "cam2"), np.loadtxt(side, delimiter=","))
    assert [mouse.facing(n) for n in mouse.names] == [1, 1]  # SOURCE.txt: world X is cam2 x


# --- epipolar lines ----------------------------------------------------------------------------


def test_epipolar_line_holds_the_point_seen_in_the_other_view(treadmill):
    for point in cloud(10):
        uv = treadmill.project(point)
        ends = treadmill.epipolar_line("cam1", uv[0], "cam3", size=SIZE)
        along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
        off = uv[2] - ends[0]
        assert abs(off[0] * along[1] - off[1] * along[0]) < 1e-6
        on_border = np.isclose(ends, [-0.5, -0.5]) | np.isclose(
            ends, [SIZE[0] - 0.5, SIZE[1] - 0.5]
        )
        assert on_border.any(axis=1).all()
        assert (ends >= -0.5 - 1e-9).all()
        assert (ends <= np.array(SIZE) - 0.5 + 1e-9).all()


def test_the_nearest_point_in_sight_is_seen_there_and_lies_straight_across(treadmill):
    was = np.array([30.0, 5.0, 8.0])
    uv = treadmill.project(was)[0] + (15.0, -6.0)
    found = treadmill.nearest_in_sight("cam1", uv, xyz=was)
    np.testing.assert_allclose(treadmill.project(found)[0], uv, atol=1e-6)
    # any other point of that line, by the same uv from elsewhere, is farther away
    other = treadmill.nearest_in_sight("cam1", uv, xyz=was + np.array([0.0, 40.0, 0.0]))
    along = other - found
    assert np.linalg.norm(along) > 10
    assert abs(along @ (found - was)) < 1e-6 * np.linalg.norm(along) * np.linalg.norm(found - was)


def test_epipolar_lines_of_affine_views_are_parallel():
    side = [2.0, 0, 0, 10, 0, 0, -2.0, 200, 0, 0, 0]
    below = [2.0, 0, 0, 10, 0, 2.0, 0, 40, 0, 0, 0]
    rig = Rig(("side", "below"), np.array([side, below]).T)
    ends = rig.epipolar_line("side", (70.0, 33.0), "below", size=(396, 238))
    np.testing.assert_allclose(np.sort(ends, axis=0), [[70, -0.5], [70, 237.5]])


def test_no_epipolar_line_is_nan(treadmill):
    uv = treadmill.project(np.zeros(3))
    assert np.isnan(treadmill.epipolar_line("cam1", uv[0], "cam1", size=SIZE)).all()
    away = treadmill.epipolar_line("cam1", (1024, -90000), "cam3", size=(20, 20))
    assert np.isnan(away).all()


# --- fitting -----------------------------------------------------------------------------------


def calibration_tables(rig, n=25, noise=0.0):
    xyz = np.random.default_rng(1).uniform(-60, 60, (n, 3))
    points = pd.DataFrame(xyz, columns=list("xyz")).assign(point=[f"m{i}" for i in range(n)])
    uv = rig.project(xyz) + np.random.default_rng(2).normal(0, noise, (n, len(rig.names), 2))
    clicks = pd.DataFrame(
        [
            {"view": view, "point": f"m{i}", "u": uv[i, k, 0], "v": uv[i, k, 1]}
            for k, view in enumerate(rig.names)
            for i in range(n)
        ]
    )
    return points, clicks


def test_fit_rig_gives_the_rig_back_and_a_residual_for_each_click(treadmill):
    points, clicks = calibration_tables(treadmill)
    clicks = clicks[~((clicks["view"] == "cam2") & (clicks["point"] < "m15"))]  # some unseen
    rig, residuals = fit_rig(points, clicks, unit="cm", forward=(2, 0, 0))
    assert (rig.names, rig.unit, rig.forward) == (treadmill.names, "cm", (1.0, 0.0, 0.0))
    np.testing.assert_allclose(rig.coefs, treadmill.coefs, rtol=1e-6, atol=1e-9)
    assert list(residuals.columns) == ["view", "point", "residual_px"]
    assert len(residuals) == len(clicks)
    assert residuals["residual_px"].max() < 1e-6


def test_a_wrong_click_stands_out_in_the_residuals(treadmill):
    points, clicks = calibration_tables(treadmill, noise=0.3)
    clicks.loc[(clicks["view"] == "cam3") & (clicks["point"] == "m7"), "u"] += 40
    _, residuals = fit_rig(points, clicks)
    worst = residuals.loc[residuals["residual_px"].idxmax()]
    assert (worst["view"], worst["point"]) == ("cam3", "m7")
    assert worst["residual_px"] > 20


def test_fit_rig_names_the_view_that_cannot_be_fitted(treadmill):
    points, clicks = calibration_tables(treadmill)
    few = clicks[(clicks["view"] != "cam3") | (clicks["point"].isin(["m1", "m2", "m3"]))]
    with pytest.raises(CalibrationError, match=r"^view 'cam3': 3 calibration points; at least 6"):
        fit_rig(points, few)
    points["z"] = 0.0
    with pytest.raises(CalibrationError, match=r"^view 'cam1': the calibration points lie in one"):
        fit_rig(points, clicks)
    clicks.loc[0, "u"] = np.nan
    with pytest.raises(CalibrationError, match=r"^view 'cam1': calibration point 1 has a coord"):
        fit_rig(points, clicks)
    with pytest.raises(CalibrationError, match="no click at all"):
        fit_rig(points, clicks[:0])
    with pytest.raises(CalibrationError, match="three numbers, not all of them 0"):
        fit_rig(*calibration_tables(treadmill), up=(0, 0, 0))


def test_fit_rig_refuses_names_that_do_not_match(treadmill):
    points, clicks = calibration_tables(treadmill)
    with pytest.raises(InputError, match=r"point 'm24' has no known position.*add it to points3d"):
        fit_rig(points[:-1], clicks)
    with pytest.raises(InputError, match="clicks: cam1, m0 is there twice"):
        fit_rig(points, pd.concat([clicks, clicks[:1]]))
    with pytest.raises(InputError, match="points3d: m0 is there twice"):
        fit_rig(pd.concat([points, points[:1]]), clicks)
    with pytest.raises(InputError, match="clicks: column 'u' is missing"):
        fit_rig(points, clicks.drop(columns="u"))


# --- whole tracks ---------------------------------------------------------------------------------


def seen_tracks(rig, n=30):
    """Two points that circle in space; FL is seen by cam3 and cam4 only, half the time by one."""
    t = np.arange(n) / n * 2 * np.pi
    xyz = np.stack(
        [np.c_[30 * np.cos(t), 10 + 0 * t, 10 * np.sin(t)], np.c_[t, -10 + 0 * t, 5 * t]], axis=1
    )
    tracks = make_tracks(np.arange(n), ["FR", "FL"], fps=100.0, views=rig.names, unit="px")
    uv = rig.project(xyz)  # time, point, view, uv
    uv[:, 1, :2] = np.nan
    uv[n // 2 :, 1, 2] = np.nan
    tracks["image_position"].to_numpy()[..., 0] = np.transpose(uv, (0, 2, 3, 1))
    seen = np.isfinite(uv).all(axis=-1).transpose(0, 2, 1)
    tracks["image_origin"].to_numpy()[..., 0] = seen
    tracks["image_confidence"].to_numpy()[..., 0] = np.where(seen, 0.5, 0)
    return tracks, xyz


def test_triangulate_tracks_fills_what_two_views_see(treadmill):
    tracks, xyz = seen_tracks(treadmill)
    found = triangulate_tracks(tracks, treadmill)
    position = found["position"].to_numpy()[..., 0].transpose(0, 2, 1)
    np.testing.assert_allclose(position[:, 0], xyz[:, 0], atol=1e-6)
    np.testing.assert_allclose(position[:15, 1], xyz[:15, 1], atol=1e-6)
    assert np.isnan(position[15:, 1]).all()
    assert (found["origin"].to_numpy()[15:, 1, 0] == ORIGIN_CODE["missing"]).all()
    assert (found["confidence"].to_numpy()[:15, :, 0] == 0.5).all()
    assert found.attrs["units"] == found["position"].attrs["units"] == "mm"
    assert np.isnan(tracks["position"]).all()  # the Tracks given are not changed


def test_triangulate_tracks_refuses_what_does_not_agree(treadmill):
    tracks, _ = seen_tracks(treadmill)
    tracks["image_position"].loc[{"time": tracks["time"][4], "view": "cam1", "keypoint": "FR"}] += (
        60
    )
    found = triangulate_tracks(tracks, treadmill, max_residual_px=10.0)
    origin = found["origin"].sel(keypoint="FR").to_numpy()[:, 0]
    assert np.flatnonzero(origin == ORIGIN_CODE["missing"]).tolist() == [4]
    assert '"refused": 1' in found.attrs["provenance"]


def test_triangulate_tracks_needs_views(treadmill):
    tracks, _ = seen_tracks(treadmill)
    with pytest.raises(InputError, match="needs Tracks with image positions"):
        triangulate_tracks(tracks.drop_vars("image_position"), treadmill)
    with pytest.raises(
        CalibrationError, match=r"^1 of the views cam1, cam2, cam3, cam4 are in the"
    ):
        triangulate_tracks(tracks, treadmill.subset(["cam2"]))


@pytest.mark.parametrize(
    ("row", "value"),
    [(0, 9e18), (8, 9e18), (3, -9e18), (10, 1e300), (0, float("nan")), (5, float("inf"))],
)
def test_a_coefficient_of_no_camera_is_named(treadmill, row, value):
    coefs = treadmill.coefs.copy()
    coefs[row, 1] = value
    with pytest.raises(CalibrationError, match=rf"^view 'cam2': the coefficient L{row + 1} is "):
        Rig(treadmill.names, coefs)


@pytest.mark.parametrize("rows", [range(11), range(3), (0, 1, 2, 4, 5, 6)])
def test_a_view_in_which_nothing_moves_is_no_camera(treadmill, rows):
    coefs = treadmill.coefs.copy()
    coefs[list(rows), 2] = 0.0
    with pytest.raises(CalibrationError, match=r"^view .cam3.: the coefficients L1 to L3 and "):
        Rig(treadmill.names, coefs)


def test_two_views_of_one_name_are_refused(treadmill):
    with pytest.raises(CalibrationError, match="two views have one name"):
        Rig(("cam1", "cam1", "cam3", "cam4"), treadmill.coefs)


def test_whatever_numbers_make_a_rig_can_be_used_without_a_foreign_error(treadmill):
    """Coefficients of any size that is let in: numbers, NaN or one sentence come out."""
    rng = np.random.default_rng(0)
    sizes = [1e12, -1e12, 1e9, 0.0, 1e-300, 5e-324, -1.0]
    uv = np.array([[10.0, 20.0], [30.0, 40.0], [50.0, 60.0], [70.0, 80.0]])
    made = 0
    for _ in range(100):
        coefs = treadmill.coefs.copy()
        for _ in range(rng.integers(1, 6)):
            coefs[rng.integers(11), rng.integers(4)] = sizes[rng.integers(len(sizes))]
        try:
            rig = Rig(treadmill.names, coefs)
        except CalibrationError:
            continue
        made += 1
        rig.project(np.ones((1, 3)))
        rig.triangulate(uv)
        rig.triangulate(uv, refine=True)
        rig.epipolar_line("cam1", uv[0], "cam2", size=SIZE)
        for name in rig.names:
            try:
                rig.facing(name)
            except CalibrationError:
                continue
    assert made > 30
