"""DLT mathematics against DLTdv, StereoMorph and a calibrated cage, and its invariances."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from cage import read_cage
from hypothesis import given, settings
from hypothesis import strategies as st

from pawnb.core import dlt
from pawnb.errors import CalibrationError


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


@st.composite
def rigs(draw, n_min=2, n_max=4):
    """Cameras on a ring of 600-1200 mm round the origin, each looking near the origin."""
    n = draw(st.integers(n_min, n_max))
    views = []
    for i in range(n):
        turn = 2 * np.pi * (i + draw(st.floats(0, 0.5))) / (n + 0.7)
        radius = draw(st.floats(600, 1200))
        height = draw(st.floats(-200, 400))
        target = [draw(st.floats(-50, 50)) for _ in range(3)]
        position = [radius * np.cos(turn), radius * np.sin(turn), height]
        views.append(look_at(position, target, focal_px=draw(st.floats(500, 3000))))
    return np.stack(views, axis=1)


def cloud(seed, n=25, size=100.0):
    """``n`` points spread evenly in a cube of ``size`` mm about the origin."""
    return np.random.default_rng(seed).uniform(-size / 2, size / 2, (n, 3))


seeds = st.integers(0, 2**32 - 1)

# --- known answers ---------------------------------------------------------------------


def read_dltdv(folder, trial):
    """Coefficients, image positions (frames, 12, 4, 2), xyz (frames, 12, 3) and residuals."""
    coefs = np.loadtxt(folder / f"{trial}_DLTcoefs.csv", delimiter=",")
    uv = pd.read_csv(folder / f"{trial}_xypts.csv").to_numpy()[:, 1:].reshape(-1, 12, 4, 2)
    xyz = pd.read_csv(folder / f"{trial}_xyzpts.csv").to_numpy()[:, 1:].reshape(-1, 12, 3)
    residual = pd.read_csv(folder / f"{trial}_xyzres.csv").to_numpy()[:, 1:]
    return coefs, uv, xyz, residual


@pytest.mark.parametrize("trial", ["1864_1x", "1894_1.5x"])
def test_triangulate_agrees_with_dltdv_where_views_are_missing(real_data, trial):
    # jumping spider digitised in DLTdv: 12 points seen by 2, 3 or 4 of 4 cameras
    coefs, uv, xyz, residual = read_dltdv(real_data("salticid-4cam-dlt"), trial)
    found = dlt.triangulate(coefs, uv)
    known = np.isfinite(xyz).all(axis=-1)
    assert known.sum() > 400
    assert set(np.unique(found.n_views[known])) == {2, 3, 4}
    np.testing.assert_allclose(found.xyz[known], xyz[known], atol=1e-5, rtol=0)
    np.testing.assert_allclose(found.dltres[known], residual[known], atol=2e-6, rtol=0)
    assert (found.n_views[~known] < 2).all()
    assert np.isnan(found.xyz[~known]).all()
    # perturbed twin: coefficients off by 1e-5 of their size are noticed
    off = dlt.triangulate(coefs * (1 + 1e-5 * np.eye(11, 4)), uv)
    assert np.abs(off.xyz[known] - xyz[known]).max() > 1e-5


@pytest.mark.parametrize(
    ("grid", "spacing_mm", "sd_mm"),
    # 21 x 14 printed corners, distances along the rows of the first grid of each kind
    # (SOURCE.txt: 6.350 +- 0.013 and 4.221 +- 0.017 mm)
    [("cal_a1", 6.350, 0.013), ("test_cal_a1", 4.221, 0.017)],
)
def test_grid_spacing_of_stereomorph(real_data, grid, spacing_mm, sd_mm):
    folder = real_data("stereomorph-dlt")
    coefs = np.loadtxt(folder / "cal_coeffs.txt")
    uv = np.stack([np.loadtxt(folder / f"{grid}_v{v}.txt") for v in (1, 2)], axis=1)

    def steps(coefs):
        corners = dlt.triangulate(coefs, uv).xyz.reshape(14, 21, 3)
        return np.linalg.norm(np.diff(corners, axis=1), axis=-1)

    assert steps(coefs).mean() == pytest.approx(spacing_mm, abs=5e-4)
    assert steps(coefs).std() == pytest.approx(sd_mm, abs=6e-4)
    off = coefs.copy()
    off[[0, 1, 2, 4, 5, 6], 0] *= 1.0005  # perturbed twin
    assert steps(off).mean() != pytest.approx(spacing_mm, abs=5e-4)


def test_every_grid_of_stereomorph_has_its_spacing(real_data):
    folder = real_data("stereomorph-dlt")
    coefs = np.loadtxt(folder / "cal_coeffs.txt")
    for k in range(1, 9):
        uv = np.stack([np.loadtxt(folder / f"cal_a{k}_v{v}.txt") for v in (1, 2)], axis=1)
        corners = dlt.triangulate(coefs, uv).xyz.reshape(14, 21, 3)
        for axis in (0, 1):
            steps = np.linalg.norm(np.diff(corners, axis=axis), axis=-1)
            assert steps.mean() == pytest.approx(6.350, abs=0.003)
            assert steps.std() < 0.02


def test_landmarks_of_stereomorph(real_data):
    # named skull landmarks in both views; their 3D by StereoMorph, to 3 decimals
    folder = real_data("stereomorph-dlt")
    coefs = np.loadtxt(folder / "cal_coeffs.txt")
    tables = [
        pd.read_csv(folder / f"lm_2d_a2_v{v}.txt", sep="\t", header=None, index_col=0)
        for v in (1, 2)
    ]
    truth = pd.read_csv(folder / "lm_3d_a2.txt", sep="\t", header=None, index_col=0)
    names = [
        name
        for name in tables[0].index.intersection(tables[1].index).intersection(truth.index)
        if not name[-4:].isdigit()  # points of curves are matched along epipolar lines there
    ]
    assert len(names) > 10
    uv = np.stack([t.loc[names].to_numpy(float) for t in tables], axis=1)
    found = dlt.triangulate(coefs, uv).xyz
    np.testing.assert_allclose(found, truth.loc[names].to_numpy(float), atol=1e-3)
    assert np.abs(1.0001 * found - truth.loc[names].to_numpy(float)).max() > 1e-3


def test_four_camera_cage(real_data):
    # a mouse in a cage, 15 proofread points in four cameras; the data's own 3D points are
    # homogeneous least squares in units of the focal length (medians 8.8, 4.1, 9.5, 3.3 px
    # and Nose-TTI 74.7 mm, SOURCE.txt)
    coefs, uv, xyz, names = read_cage(real_data("mouse-4cam-cage"))
    theirs = dlt.reprojection_error(coefs, xyz, uv)
    np.testing.assert_allclose(np.nanmedian(theirs, axis=(0, 1)), [8.8, 4.1, 9.5, 3.3], atol=0.1)
    found = dlt.triangulate(coefs, uv, refine=True)
    both = np.isfinite(xyz).all(axis=-1) & (found.n_views > 1)
    assert both.sum() == 1800
    seen = np.isfinite(uv).all(axis=-1)
    squares = np.where(seen, theirs**2, 0).sum(axis=-1)
    ours = found.residual_px**2 * found.n_views
    assert (ours[both] <= squares[both] * (1 + 1e-6)).all()  # nothing reprojects better
    assert np.median(np.linalg.norm(found.xyz - xyz, axis=-1)[both]) < 1.5  # of some 500 mm
    nose, tail = names.index("Nose"), names.index("TTI")
    length = np.linalg.norm(found.xyz[:, nose] - found.xyz[:, tail], axis=-1)
    assert np.nanmedian(length) == pytest.approx(74.7, abs=1.5)  # residuals are 3 to 10 px
    assert np.nanmedian(length * 1.03) != pytest.approx(74.7, abs=1.5)  # perturbed twin


def test_linear_solution_is_biased_where_one_camera_is_near_the_origin(real_data):
    # this calibration has its origin at a camera: linear equations then count camera 4 alone
    coefs, uv, _, _ = read_cage(real_data("mouse-4cam-cage"))
    plain = dlt.triangulate(coefs, uv)
    best = dlt.triangulate(coefs, uv, refine=True)
    error = np.nanmedian(dlt.reprojection_error(coefs, plain.xyz, uv), axis=(0, 1))
    assert error[3] < 0.5 < 10 < error[2]
    assert np.nanmedian(best.residual_px) < 0.9 * np.nanmedian(plain.residual_px)


def test_fit_with_published_coefficients(real_data):
    # points made by the DLTdv coefficients must give these coefficients back
    folder = real_data("salticid-4cam-dlt")
    truth = np.loadtxt(folder / "1864_1x_DLTcoefs.csv", delimiter=",")
    xyz = cloud(3, n=12, size=20.0)
    for i in range(4):
        fit = dlt.fit_dlt(xyz, dlt.project(truth, xyz)[:, i])
        np.testing.assert_allclose(fit.coefs, truth[:, i], rtol=1e-6)
        # perturbed twin: one click that is 0.1 px off is noticed
        uv = dlt.project(truth, xyz)[:, i]
        uv[3, 0] += 0.1
        off = np.abs(dlt.fit_dlt(xyz, uv).coefs / truth[:, i] - 1)
        assert off.max() > 1e-6


# --- properties ------------------------------------------------------------------------


@settings(max_examples=60, deadline=None)
@given(rigs(), seeds)
def test_project_then_triangulate_gives_the_points_back(coefs, seed):
    xyz = cloud(seed)
    found = dlt.triangulate(coefs, dlt.project(coefs, xyz))
    np.testing.assert_allclose(found.xyz, xyz, atol=1e-6)
    assert found.residual_px.max() < 1e-6
    assert (found.n_views == coefs.shape[1]).all()


@settings(max_examples=40, deadline=None)
@given(rigs(3, 4), seeds)
def test_missing_views_are_as_if_the_rig_had_none(coefs, seed):
    rng = np.random.default_rng(seed)
    uv = dlt.project(coefs, cloud(seed)) + rng.normal(0, 2, (25, coefs.shape[1], 2))
    hidden = rng.random(uv.shape[:2]) < 0.4
    uv[hidden] = np.nan
    found = dlt.triangulate(coefs, uv)
    for k in range(len(uv)):
        seen = ~hidden[k]
        assert found.n_views[k] == seen.sum()
        if seen.sum() < 2:
            assert np.isnan(found.xyz[k]).all()
            assert np.isnan([found.residual_px[k], found.dltres[k]]).all()
            continue
        # numpy's own least squares on the equations of the views that see the point
        L, (u, v) = coefs[:, seen], uv[k, seen].T
        A = np.r_[(L[0:3] - u * L[8:11]).T, (L[4:7] - v * L[8:11]).T]
        b = np.r_[u - L[3], v - L[7]]
        x, *_ = np.linalg.lstsq(A, b, rcond=None)
        np.testing.assert_allclose(found.xyz[k], x, atol=1e-6)
        n = seen.sum()
        assert found.dltres[k] == pytest.approx(np.sqrt(((A @ x - b) ** 2).sum() / (2 * n - 3)))
        gap = dlt.project(L, x) - uv[k, seen]
        assert found.residual_px[k] == pytest.approx(np.sqrt((gap**2).sum() / n))


@settings(max_examples=60, deadline=None)
@given(rigs(1, 1), seeds, st.integers(6, 30))
def test_exact_points_give_the_coefficients_back(coefs, seed, n):
    xyz = cloud(seed, n=n)
    fit = dlt.fit_dlt(xyz, dlt.project(coefs, xyz)[:, 0])
    assert fit.residual_px.max() < 1e-6
    elsewhere = cloud(seed + 1)
    np.testing.assert_allclose(
        dlt.project(fit.coefs, elsewhere), dlt.project(coefs, elsewhere), atol=1e-2
    )


@settings(max_examples=40, deadline=None)
@given(rigs(1, 1), seeds, st.floats(1e-3, 1e3), st.tuples(*[st.floats(-100, 100)] * 3))
def test_fit_does_not_depend_on_unit_and_origin(coefs, seed, scale, shift):
    xyz = cloud(seed)
    uv = dlt.project(coefs, xyz)[:, 0] + np.random.default_rng(seed).normal(0, 1, (25, 2))
    plain = dlt.fit_dlt(xyz, uv)
    moved = dlt.fit_dlt((xyz + shift) * scale, uv)
    np.testing.assert_allclose(moved.residual_px, plain.residual_px, atol=1e-6)
    other = cloud(seed + 1)
    np.testing.assert_allclose(
        dlt.project(moved.coefs, (other + shift) * scale), dlt.project(plain.coefs, other),
        atol=1e-4,
    )  # fmt: skip


@settings(max_examples=30, deadline=None)
@given(rigs(1, 1), seeds)
def test_refining_lowers_the_reprojection_error_to_a_minimum(coefs, seed):
    rng = np.random.default_rng(seed)
    xyz = cloud(seed)
    uv = dlt.project(coefs, xyz)[:, 0] + rng.normal(0, 1, (25, 2))
    linear = dlt.fit_dlt(xyz, uv, refine=False)
    best = dlt.fit_dlt(xyz, uv)
    cost = (best.residual_px**2).sum()
    assert cost <= (linear.residual_px**2).sum() + 1e-9
    for _ in range(10):  # no direction leads further down
        step = 1e-5 * rng.normal(size=11) * best.coefs
        assert (
            dlt.reprojection_error(best.coefs + step, xyz, uv[:, None]) ** 2
        ).sum() > cost - 1e-9


def test_noise_of_known_size_is_found_in_the_residuals():
    coefs = look_at([0, 800, 200], [0, 0, 0])
    xyz = cloud(5, n=400)
    noise = np.random.default_rng(0).normal(0, 1.5, (400, 2))
    fit = dlt.fit_dlt(xyz, dlt.project(coefs, xyz)[:, 0] + noise)
    # 800 values, 11 of them spent on coefficients
    assert np.sqrt((fit.residual_px**2).sum() / (800 - 11)) == pytest.approx(1.5, abs=0.1)


@settings(max_examples=40, deadline=None)
@given(rigs(1, 1), seeds)
def test_transform_image_is_the_homography_of_the_projection(coefs, seed):
    H = np.array([[-1.0, 0, 639], [0, 1, -30], [0, 0, 1]])
    xyz = cloud(seed)
    u, v = dlt.project(coefs, xyz)[:, 0].T
    moved = dlt.project(dlt.transform_image(coefs[:, 0], H), xyz)[:, 0]
    np.testing.assert_allclose(moved, np.c_[639 - u, v - 30], atol=1e-8)


def test_affine_views_work():
    # two scaled orthographic views: from the side (X, -Z) and from below (X, Y)
    side = np.array([2.0, 0, 0, 10, 0, 0, -2.0, 200, 0, 0, 0])
    below = np.array([2.0, 0, 0, 10, 0, 2.0, 0, 40, 0, 0, 0])
    coefs = np.stack([side, below], axis=1)
    xyz = cloud(1)
    uv = dlt.project(coefs, xyz)
    np.testing.assert_allclose(uv[:, 0], np.c_[2 * xyz[:, 0] + 10, 200 - 2 * xyz[:, 2]])
    np.testing.assert_allclose(dlt.triangulate(coefs, uv).xyz, xyz, atol=1e-9)
    fit = dlt.fit_dlt(xyz, uv[:, 0])
    np.testing.assert_allclose(fit.coefs, side, atol=1e-8)


@settings(max_examples=30, deadline=None)
@given(rigs(2, 4), seeds)
def test_refined_points_have_the_smallest_reprojection_error(coefs, seed):
    rng = np.random.default_rng(seed)
    uv = dlt.project(coefs, cloud(seed)) + rng.normal(0, 2, (25, coefs.shape[1], 2))
    uv[0, 0] = np.nan
    plain, best = dlt.triangulate(coefs, uv), dlt.triangulate(coefs, uv, refine=True)
    known = best.n_views > 1
    assert (best.residual_px[known] <= plain.residual_px[known]).all()
    for _ in range(10):  # no direction leads further down
        near = best.xyz + rng.normal(0, 0.05, best.xyz.shape)
        error = dlt.reprojection_error(coefs, near, uv)
        worse = np.sqrt(np.nanmean(error[known] ** 2, axis=-1))
        assert (worse >= best.residual_px[known] - 1e-9).all()


# --- what cannot be known is said, not guessed -------------------------------------------


def test_one_view_gives_no_position():
    coefs = np.stack([look_at([0, 800, 0], [0, 0, 0]), look_at([800, 1, 0], [0, 0, 0])], axis=1)
    uv = dlt.project(coefs, cloud(0, n=3))
    uv[0, 1] = np.nan
    uv[1] = np.nan
    uv[2, 0, 1] = np.nan  # half a position is none
    found = dlt.triangulate(coefs, uv)
    assert found.n_views.tolist() == [1, 0, 1]
    assert np.isnan(found.xyz).all()
    assert np.isnan(found.residual_px).all()


def test_rays_that_do_not_cross_give_no_position():
    view = look_at([0, 800, 0], [0, 0, 0])
    coefs = np.stack([view, view], axis=1)
    found = dlt.triangulate(coefs, dlt.project(coefs, cloud(0)))
    assert (found.n_views == 2).all()
    assert np.isnan(found.xyz).all()


def test_shapes_travel():
    coefs = np.stack([look_at([0, 800, 0], [0, 0, 0]), look_at([800, 1, 0], [0, 0, 0])], axis=1)
    xyz = cloud(0, n=24).reshape(4, 3, 2, 3)
    uv = dlt.project(coefs, xyz)
    assert uv.shape == (4, 3, 2, 2, 2)
    found = dlt.triangulate(coefs, uv)
    assert found.xyz.shape == (4, 3, 2, 3)
    assert found.residual_px.shape == found.dltres.shape == found.n_views.shape == (4, 3, 2)
    assert dlt.triangulate(coefs, uv[:0]).xyz.shape == (0, 3, 2, 3)
    assert dlt.triangulate(coefs, uv[0, 0, 0]).n_views.shape == ()


def test_wrong_shapes_are_refused():
    with pytest.raises(CalibrationError, match=r"^DLT coefficients have shape \(12, 2\); exp"):
        dlt.project(np.zeros((12, 2)), np.zeros(3))
    with pytest.raises(CalibrationError, match="for the 2 views of the calibration"):
        dlt.triangulate(np.zeros((11, 2)), np.zeros((5, 3, 2)))
    with pytest.raises(CalibrationError, match=r"expected \(n, 3\) and \(n, 2\)"):
        dlt.fit_dlt(np.zeros((7, 3)), np.zeros((6, 2)))


def _planar():
    return cloud(0) * [1, 1, 0] + [0, 0, 4]


def _tilted_plane():
    return _planar() @ np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]


def _line():
    return np.outer(np.arange(10), [1, 2, 3])


def _duplicated():
    return np.repeat(cloud(0, n=5), 4, axis=0)


def _all_but_one():
    return np.r_[_planar(), [[0, 0, 30.0]]]


def _two_lines():
    t = np.linspace(-40, 40, 9)[:, None]
    return np.r_[t * [1, 0, 0], t * [0, 1, 0] + [0, 0, 30]]


def _with_nan():
    xyz = cloud(0)
    xyz[3, 1] = np.nan
    return xyz


@pytest.mark.parametrize(
    ("points", "reason"),
    [
        (lambda: cloud(0, n=5), "5 calibration points; at least 6 are needed"),
        (_planar, "the calibration points lie in one plane; add points in front of or behind"),
        (_tilted_plane, "the calibration points lie in one plane"),
        (_line, "the calibration points lie on one line"),
        (_duplicated, "20 calibration points, but only 5 different positions"),
        (_all_but_one, "all calibration points but one lie in one plane"),
        (_two_lines, "the calibration points do not determine the view"),
        (_with_nan, "calibration point 4 has a coordinate that is not a number"),
    ],
)
def test_degenerate_points_are_refused_with_the_reason(points, reason):
    xyz = points()
    uv = dlt.project(look_at([300, 800, 200], [0, 0, 0]), np.nan_to_num(xyz))[:, 0]
    with pytest.raises(CalibrationError, match=reason):
        dlt.fit_dlt(xyz, uv)


def test_clicks_on_one_line_are_refused():
    xyz = cloud(0)
    with pytest.raises(CalibrationError, match="clicks of the calibration points lie on one line"):
        dlt.fit_dlt(xyz, np.outer(np.arange(25.0), [1, 2]))


def test_clicks_that_belong_to_other_points_are_refused():
    xyz = cloud(0, n=8)
    uv = np.random.default_rng(2).uniform(0, 1000, (8, 2))
    with pytest.raises(CalibrationError, match="some would lie behind the camera"):
        dlt.fit_dlt(xyz, uv)


def test_thin_frames_are_not_refused():
    # a frame 2 % as deep as it is long is poor but usable
    xyz = cloud(0) * [1, 1, 0.02]
    coefs = look_at([300, 800, 200], [0, 0, 0])
    fit = dlt.fit_dlt(xyz, dlt.project(coefs, xyz)[:, 0])
    np.testing.assert_allclose(fit.coefs, coefs, rtol=1e-4, atol=1e-6)


def test_world_origin_beside_the_camera_is_refused():
    # the camera stands at (0, 800, 0) and looks along -Y; its image plane through the
    # camera holds the point that is made the origin here
    xyz = cloud(0)
    uv = dlt.project(look_at([0, 800, 0], [0, 0, 0]), xyz)[:, 0]
    with pytest.raises(CalibrationError, match="move the origin into the filmed space"):
        dlt.fit_dlt(xyz - [100, 800, 50], uv)


def test_mirrored_space_is_told_from_space_as_it_is():
    """det(R) of a rotation is 1 (Hartley & Zisserman 2004, 6.2), that of a mirrored one -1."""
    about = np.random.default_rng(1).uniform(-40, 40, (6, 3))
    as_it_is = look_at([200, -800, 150], [0, 0, 0])
    flipped = np.array([[-1.0, 0, 2048], [0, 1, 0], [0, 0, 1]])  # what a mirror shows
    mirrored = dlt.transform_image(as_it_is, flipped)
    parallel = np.r_[1.06, 0, 0, 5, 0, 0, -1, 168, 0, 0, 0]
    coefs = np.stack([as_it_is, mirrored, parallel], axis=1)
    assert dlt.handedness(coefs, about).tolist() == [1, -1, 0]
    # axes named so that they are left-handed: y to the other side
    other = coefs[:, :1].copy()
    other[[1, 5, 9]] *= -1
    assert dlt.handedness(other, about * [1, -1, 1]).tolist() == [-1]
    # seen from far behind the origin, where the last row of P changes its sign
    behind = look_at([0, 900, 100], [0, 2000, 0])
    assert dlt.handedness(behind[:, None], about + np.array([0, 2000, 0])).tolist() == [1]


def test_perspective_that_was_fitted_to_errors_does_not_tell_a_mirror():
    rng = np.random.default_rng(5)
    xyz = rng.uniform(-40, 40, (20, 3))
    told = []
    for _ in range(20):  # parallel lines of sight, clicked with an error of 2 px
        uv = xyz[:, [0, 2]] * [2.0, -2.0] + rng.normal(0.0, 2.0, (20, 2))
        told += dlt.handedness(dlt.fit_dlt(xyz, uv).coefs[:, None], xyz).tolist()
    assert -1 not in told


@given(rigs(n_min=3), seeds)
@settings(max_examples=20)
def test_weighed_alike_points_do_not_depend_on_where_the_origin_lies(coefs, seed):
    rng = np.random.default_rng(seed)
    xyz = cloud(seed, n=5)
    uv = dlt.project(coefs, xyz) + rng.normal(0, 5.0, (5, coefs.shape[1], 2))
    move = np.array([300.0, -120.0, 80.0])
    shift = np.eye(4)
    shift[:3, 3] = move  # points are counted from elsewhere: X = X' + move
    moved = []
    for column in coefs.T:
        P = dlt.to_matrix(column) @ shift
        moved.append((P / P[2, 3]).ravel()[:11])
    moved = np.stack(moved, axis=1)
    even = dlt.triangulate(coefs, uv, even=True).xyz
    np.testing.assert_allclose(dlt.triangulate(moved, uv, even=True).xyz + move, even, atol=1e-5)
    plain = dlt.triangulate(coefs, uv).xyz
    assert np.abs(dlt.triangulate(moved, uv).xyz + move - plain).max() > 1e-3  # DLTdv's do


def test_views_without_perspective_are_not_scaled():
    affine = np.array(
        [[2.0, 0, 0, 5, 0, 0, -2, 7, 0, 0, 0], [0, 2.0, 0, 5, 0, 0, -2, 7, 0, 0, 0]]
    ).T
    uv = dlt.project(affine, cloud(0)) + np.random.default_rng(0).normal(0, 1, (25, 2, 2))
    even, plain = (dlt.triangulate(affine, uv, even=one).xyz for one in (True, False))
    np.testing.assert_array_equal(even, plain)
