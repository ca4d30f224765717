"""Cameras that are known come back from a wand that OpenCV projects by them."""

import numpy as np
import pytest
from board_scene import NAMES, SIZE, shown, true_cameras

from pawnb.core.calibration.rig_from_wand import WandSightings, calibrate_by_wand
from pawnb.core.lens import Lens
from pawnb.errors import CalibrationError

LENGTH = 100.0
N = 30


def wand(*, bent=False, noise_px=0.2, n=N, change=None, smooth=False):
    """The true cameras, both ends in space, and what was seen of them."""
    rng = np.random.default_rng(0)
    cameras = [(K, D if bent else np.zeros(5), R, t) for K, D, R, t in true_cameras()]
    middle, along = rng.uniform(-90.0, 90.0, (n, 3)), rng.normal(size=(n, 3))
    if smooth:
        t = np.linspace(0.0, 6.0, n)
        middle = 80.0 * np.stack([np.sin(1.3 * t), np.sin(2.1 * t + 1), np.sin(3.1 * t)], axis=1)
        across = np.sin(2 * t)
        along = np.stack([across * np.cos(t), across * np.sin(1.7 * t), np.cos(2 * t)], axis=1)
    along *= LENGTH / 2 / np.linalg.norm(along, axis=1, keepdims=True)
    xyz = np.stack([middle - along, middle + along], axis=1)
    uv = np.stack([shown(camera, xyz.reshape(-1, 3)).reshape(n, 2, 2) for camera in cameras])
    uv += rng.normal(0.0, noise_px, uv.shape)
    if change is not None:
        change(uv)
    lenses = tuple(Lens(matrix=tuple(map(tuple, K)), distortion=tuple(D)) for K, D, _, _ in cameras)
    seen = WandSightings(
        names=NAMES, sizes=(SIZE,) * 3, length=LENGTH, uv=uv, lenses=lenses if bent else ()
    )
    return cameras, seen


def spans(cameras):
    """Distances between the cameras, which do not depend on the axes."""
    eyes = [-R.T @ t for R, t in cameras]
    return [np.linalg.norm(eyes[i] - eyes[j]) for i, j in ((0, 1), (0, 2), (1, 2))]


@pytest.mark.slow
def test_focal_lengths_and_places_come_back():
    true, seen = wand()
    fit = calibrate_by_wand(seen)
    focal = [camera.matrix[0, 0] for camera in fit.cameras]
    np.testing.assert_allclose(focal, (520.0, 560.0, 600.0), rtol=0.02)
    expected = spans([(R, t) for _, _, R, t in true])
    np.testing.assert_allclose(
        spans([(c.rotation, c.translation) for c in fit.cameras]), expected, rtol=0.02
    )
    assert fit.errors["error_px"].median() < 0.4
    assert not fit.errors["set_aside"].any()
    # z is up in the pictures: a step along it goes up (v falls) in each
    for camera in fit.cameras:
        step = camera.rotation @ [0.0, 0.0, 1.0]
        assert step[1] < -0.7


@pytest.mark.slow
def test_known_lenses_are_kept_and_frames_that_do_not_agree_are_named():
    def spoil(uv):
        uv[1, 7] += 9.0
        uv[2, 11] = uv[2, 11, ::-1].copy()  # ends swapped
        uv[0, 20:25] = np.nan

    true, seen = wand(bent=True, change=spoil)
    fit = calibrate_by_wand(seen)
    aside = fit.errors[fit.errors["set_aside"]]
    assert sorted(zip(aside["view"], aside["frame"], strict=True)) == [("middle", 7), ("right", 11)]
    assert [camera.matrix[0, 0] for camera in fit.cameras] == [520.0, 560.0, 600.0]
    expected = spans([(R, t) for _, _, R, t in true])
    np.testing.assert_allclose(
        spans([(c.rotation, c.translation) for c in fit.cameras]), expected, rtol=0.01
    )


def test_what_does_not_determine_the_cameras_is_told():
    def rare(uv):
        uv[:, 9:] = np.nan

    def apart(uv):
        uv[2, :] = np.nan
        uv[2, :4] = 100.0

    with pytest.raises(CalibrationError, match="seen by two views in 9 frames; at least 10"):
        calibrate_by_wand(wand(change=rare)[1])
    with pytest.raises(CalibrationError, match="no arrangement of the views fits the wand"):
        calibrate_by_wand(wand(change=apart, bent=True)[1])
    _, seen = wand()
    alone = WandSightings(names=("left",), sizes=(SIZE,), length=LENGTH, uv=seen.uv[:1])
    with pytest.raises(CalibrationError, match=r"one view only \(left\)"):
        calibrate_by_wand(alone)


@pytest.mark.slow
@pytest.mark.parametrize("how", ["later", "mirrored"])
def test_a_view_that_does_not_agree_is_told(how):
    """Cameras came out with errors of many px, or of no frame of a view at all."""

    def spoil(uv):
        # a wand that goes on its way smoothly, of which one view is late or mirrored
        if how == "later":
            uv[2, 3:] = uv[2, :-3].copy()
        else:
            uv[2, ..., 0] = SIZE[0] - 1 - uv[2, ..., 0]

    with pytest.raises(
        CalibrationError, match=r"^view '\w+' agrees with the others in \d+ of \d+ frames"
    ):
        calibrate_by_wand(wand(change=spoil, smooth=True, n=60)[1])
