"""Lens distortion: where points go, crops, and the file that describes it."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pawnb.core.lens import Lens, StraightPicture, load_lenses
from pawnb.core.pixels.colour import GreyPicture, PackedPicture
from pawnb.errors import InputError

MATRIX = ((120.0, 0.0, 79.5), (0.0, 118.0, 47.5), (0.0, 0.0, 1.0))
BARREL = Lens(matrix=MATRIX, distortion=(-0.3, 0.08, 0.002, -0.001, 0.0))


def brown_conrady(lens, u, v):
    """Where a straight point is filmed: radial and tangential terms (Brown 1966)."""
    (fx, _, cx), (_, fy, cy), _ = lens.matrix
    k1, k2, p1, p2, k3 = lens.distortion
    x, y = (u - cx) / fx, (v - cy) / fy
    r2 = x * x + y * y
    radial = 1 + k1 * r2 + k2 * r2**2 + k3 * r2**3
    return (
        fx * (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + cx,
        fy * (y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + cy,
    )


def test_a_filmed_dot_comes_to_its_straight_place():
    for u, v in ((30.0, 20.0), (120.0, 70.0), (79.5, 47.5), (140.0, 15.0)):
        filmed = brown_conrady(BARREL, u, v)
        vv, uu = np.mgrid[:96, :160]
        dot = 250 * np.exp(-((uu - filmed[0]) ** 2 + (vv - filmed[1]) ** 2) / (2 * 1.5**2))
        picture = StraightPicture(GreyPicture(np.rint(dot).astype(np.uint8)), BARREL)
        image = picture.region(0, 0, 160, 96).astype(float)
        at = (image * uu).sum() / image.sum(), (image * vv).sum() / image.sum()
        assert np.hypot(at[0] - u, at[1] - v) < 0.1
        assert u == 79.5 or np.hypot(filmed[0] - u, filmed[1] - v) > 1  # it did move


def test_agrees_with_cv2_undistort():
    rng = np.random.default_rng(1)
    rgb = cv2.GaussianBlur(rng.integers(0, 256, (96, 160, 3), dtype=np.uint8), (0, 0), 2)
    ours = StraightPicture(PackedPicture(rgb), BARREL).region(0, 0, 160, 96)
    theirs = cv2.undistort(rgb, np.array(MATRIX), np.array(BARREL.distortion))
    assert np.abs(ours.astype(int) - theirs).max() <= 2


@settings(max_examples=60, deadline=None)
@given(data=st.data())
def test_a_crop_is_that_part_of_the_whole(data):
    sign = data.draw(st.sampled_from([-1.0, 1.0]))
    colour = data.draw(st.booleans())
    lens = Lens(matrix=MATRIX, distortion=(sign * 0.4, 0.1, 0.0, 0.0))
    rng = np.random.default_rng(3)
    pixels = rng.integers(0, 256, (96, 160, 3), dtype=np.uint8)
    picture = StraightPicture(
        PackedPicture(pixels) if colour else GreyPicture(pixels[..., 0].copy()), lens
    )
    u0, v0 = data.draw(st.integers(0, 159)), data.draw(st.integers(0, 95))
    u1, v1 = data.draw(st.integers(u0 + 1, 160)), data.draw(st.integers(v0 + 1, 96))
    everything = picture.region(0, 0, 160, 96)
    assert np.array_equal(picture.region(u0, v0, u1, v1), everything[v0:v1, u0:u1])


def test_load_lenses(tmp_path):
    path = tmp_path / "lenses.toml"
    path.write_text(
        "[cam1]\nmatrix = [[120.0, 0, 79.5], [0, 118.0, 47.5], [0, 0, 1]]\n"
        "distortion = [-0.3, 0.08, 0.002, -0.001, 0]\n"
    )
    assert load_lenses(path) == {"cam1": BARREL}


GOOD = "matrix = [[9, 0, 1], [0, 9, 1], [0, 0, 1]]"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[cam1]\ndistortion = [0, 0, 0, 0]", "[cam1]: matrix is None; expected 3 rows of 3."),
        (
            "[cam1]\nmatrix = [[0, 0, 1], [0, 9, 1], [0, 0, 1]]\ndistortion = [0, 0, 0, 0]",
            "[cam1]: matrix is [[0, 0, 1], [0, 9, 1], [0, 0, 1]]; expected [[fx, 0, cx], "
            "[0, fy, cy], [0, 0, 1]] with fx and fy above 0.",
        ),
        (
            f"[cam1]\n{GOOD}\ndistortion = [0, 0, 0]",
            "[cam1]: distortion is [0, 0, 0]; expected 4, 5, 8, 12 or 14 numbers.",
        ),
        (
            f"[cam1]\n{GOOD}\ndistorsion = [0, 0, 0, 0]",
            "[cam1]: unknown field 'distorsion' (did you mean 'distortion'?); known are matrix, "
            "distortion, size.",
        ),
        ("cam1 = 3", "[cam1]: expected a section with matrix and distortion."),
        (
            f"[cam_0]\nname = 'side'\n{GOOD}\ndistortions = [0, 0, 0, 0, 0]\n"
            "rotation = [0, 0, 0]\ntranslation = [0, 0, 0]",
            "holds whole cameras, as Anipose writes them; expected lenses alone. In a trial such a "
            'file is named by anipose = "lenses.toml" instead of dlt and lens.',
        ),
    ],
)
def test_wrong_lens_files_are_refused(tmp_path, text, message):
    path = tmp_path / "lenses.toml"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        load_lenses(path)
    assert str(caught.value) == f"lenses.toml: {message}"


def test_missing_lens_file(tmp_path):
    with pytest.raises(InputError, match=r"no such file; expected the lenses\.toml that"):
        load_lenses(tmp_path / "lenses.toml")
