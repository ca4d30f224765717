"""The z-buffer, against the plainest possible loop over pixels and triangles."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from pawnb.synthetic.raster import barycentric, rasterise

W, H = 17, 13
# quarters and thirds of pixels never put a pixel centre exactly on an edge but rarely
triangles = arrays(float, (4, 3, 2), elements=st.floats(-6.0, 22.0).map(lambda x: x + 0.0137))
depths = arrays(float, (4, 3), elements=st.floats(1.0, 9.0))


def signed_area(a, b, c):
    return (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])


def covers(corners, inverse_depth, p):
    """Whether a triangle covers a point, 1 / depth there, and how near an edge the point is."""
    area = signed_area(*corners)
    if abs(area) < 1e-6:
        return False, 0.0, 0.0
    a, b, c = corners
    w = np.array([signed_area(p, b, c), signed_area(a, p, c), signed_area(a, b, p)]) / area
    return bool((w >= 0).all()), float(w @ inverse_depth), float(np.abs(w).min())


@pytest.mark.slow
@settings(max_examples=60, deadline=None)
@given(triangles, depths)
def test_every_pixel_shows_the_nearest_triangle_that_covers_its_centre(corners, depth):
    near = 1.0 / depth
    result = rasterise(corners, near, width=W, height=H)
    covered = set(zip(result.triangle.tolist(), result.pixel.tolist(), strict=True))
    for pixel in range(W * H):
        p = np.array([pixel % W, pixel // W], dtype=float)
        found = [covers(c, n, p) for c, n in zip(corners, near, strict=True)]
        if (
            any(abs(signed_area(*c)) < 1e-3 for c in corners)
            or min((f[2] for f in found), default=1.0) < 1e-7
        ):
            continue  # on an edge, or seen edge on: either answer is right
        assert {t for t, q in covered if q == pixel} == {t for t, f in enumerate(found) if f[0]}
        heights = [f[1] if f[0] else -np.inf for f in found]
        if max(heights) == -np.inf:
            assert result.winner[pixel] == -1
        else:
            shown = result.triangle[result.winner[pixel]]
            assert heights[shown] >= max(heights) - 1e-9


def test_nothing_outside_the_picture_and_nothing_from_nothing():
    away = np.array([[[-9.0, -9.0], [-2.0, -9.0], [-5.0, -1.0]]])
    result = rasterise(away, np.ones((1, 3)), width=W, height=H)
    assert len(result.pixel) == 0
    assert (result.winner == -1).all()
    empty = rasterise(np.zeros((0, 3, 2)), np.zeros((0, 3)), width=W, height=H)
    assert (empty.winner == -1).all()


@settings(max_examples=30, deadline=None)
@given(triangles)
def test_weights_restore_a_linear_function(corners):
    wide = [t for t in range(4) if abs(signed_area(*corners[t])) > 1.0]
    xy = np.array([[3.0, 4.0], [10.0, 2.0]])
    for t in wide:
        weights = barycentric(corners[t : t + 1], np.zeros(2, dtype=int), xy)
        np.testing.assert_allclose(weights.sum(axis=1), 1.0)
        np.testing.assert_allclose(weights @ corners[t], xy, atol=1e-6)
