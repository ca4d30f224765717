"""Colour on crops: textbook conversion, and any crop is a part of the whole."""

from __future__ import annotations

from fractions import Fraction

import av
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pawnb.core.pixels.colour import GreyPicture, LazyPicture, PackedPicture
from pawnb.core.pixels.planes import picture_of_frame, picture_of_planes
from pawnb.core.pixels.yuv import YuvPicture, reduce_region

STEPS = {"yuv444p": (1, 1), "yuv422p": (2, 1), "yuv420p": (2, 2), "yuv440p": (1, 2),
         "yuv411p": (4, 1), "yuv410p": (4, 4)}  # fmt: skip

# R'G'B' from Y'CbCr as printed: BT.601-7 and BT.709-6 (1.402 = 2 (1 - 0.299), ...);
# the video-range figures 298.082/256 ... are those of the standards' 8-bit equations
TEXTBOOK = {
    ("bt601", True): (0, [[1, 0, 1.402], [1, -0.344136, -0.714136], [1, 1.772, 0]]),
    ("bt601", False): (
        16,
        [[1.164384, 0, 1.596027], [1.164384, -0.391762, -0.812968], [1.164384, 2.017232, 0]],
    ),
    ("bt709", True): (0, [[1, 0, 1.5748], [1, -0.187324, -0.468124], [1, 1.8556, 0]]),
    ("bt709", False): (
        16,
        [[1.164384, 0, 1.792741], [1.164384, -0.213249, -0.532909], [1.164384, 2.112402, 0]],
    ),
}


def random_planes(width, height, steps, seed=0):
    rng = np.random.default_rng(seed)
    small = (-(-height // steps[1]), -(-width // steps[0]))
    return [
        rng.integers(0, 256, shape, dtype=np.uint8) for shape in ((height, width), small, small)
    ]


def whole(picture):
    return picture.region(0, 0, picture.width, picture.height)


@pytest.mark.parametrize(("standard", "full_range"), TEXTBOOK)
def test_conversion_is_the_textbook_one(standard, full_range):
    luma, u, v = random_planes(64, 48, (1, 1))
    picture = YuvPicture(luma, u, v, steps=(1, 1), standard=standard, full_range=full_range)
    zero, matrix = TEXTBOOK[standard, full_range]
    yuv = np.stack([luma - float(zero), u - 128.0, v - 128.0], axis=-1)
    expected = np.clip(yuv @ np.array(matrix).T, 0, 255)
    # correctly rounded but for the last of the six binary digits kept
    assert np.abs(whole(picture) - expected).max() < 0.55


@pytest.mark.parametrize("name", STEPS)
def test_chroma_belongs_to_its_block(name):
    """One chroma sample colours the whole block of luma pixels it was averaged from."""
    steps = STEPS[name]
    planes = random_planes(21, 13, steps)
    picture = picture_of_planes(
        name, planes, width=21, height=13, standard="bt601", full_range=True
    )
    spread = [p.repeat(steps[1], 0).repeat(steps[0], 1)[:13, :21] for p in planes[1:]]
    plain = YuvPicture(planes[0], *spread, steps=(1, 1), full_range=True)
    assert np.array_equal(whole(picture), whole(plain))


def test_yuvj_formats_are_full_range_by_name():
    planes = random_planes(20, 10, (2, 2))
    size = {"width": 20, "height": 10, "standard": "bt601"}
    by_name = picture_of_planes("yuvj420p", planes, full_range=False, **size)
    by_tag = picture_of_planes("yuv420p", planes, full_range=True, **size)
    video = picture_of_planes("yuv420p", planes, full_range=False, **size)
    assert np.array_equal(whole(by_name), whole(by_tag))
    assert not np.array_equal(whole(by_name), whole(video))


@settings(max_examples=60, deadline=None)
@given(data=st.data())
def test_any_crop_is_that_part_of_the_whole(data):
    name = data.draw(st.sampled_from(sorted(STEPS)))
    width, height = data.draw(st.integers(1, 90)), data.draw(st.integers(1, 150))
    planes = random_planes(width, height, STEPS[name], seed=width * height)
    picture = picture_of_planes(
        name, planes, width=width, height=height, standard="bt709", full_range=False
    )
    u0 = data.draw(st.integers(0, width - 1))
    v0 = data.draw(st.integers(0, height - 1))
    u1, v1 = data.draw(st.integers(u0 + 1, width)), data.draw(st.integers(v0 + 1, height))
    assert np.array_equal(picture.region(u0, v0, u1, v1), whole(picture)[v0:v1, u0:u1])


@pytest.mark.parametrize("factor", [1, 2, 3, 4])
@pytest.mark.parametrize("name", sorted(STEPS))
def test_a_reduced_region_is_the_mean_of_squares(name, factor):
    u0, v0, u1, v1 = 8, 4, 8 + 12 * factor, 4 + 8 * factor
    # middling colours: what RGB cannot show is cut off before or after averaging
    planes = [p // 8 + 112 for p in random_planes(80, 60, STEPS[name])]
    picture = picture_of_planes(
        name, planes, width=80, height=60, standard="bt601", full_range=True
    )
    squares = picture.region(u0, v0, u1, v1).reshape(8, factor, 12, factor, 3)
    reduced = reduce_region(picture, (u0, v0, u1, v1), factor)
    # rounded twice: the planes by half a level, of which blue takes 1.77 times that of U
    np.testing.assert_allclose(reduced, squares.mean(axis=(1, 3)), atol=2.5)


def smooth(width, height):
    """A picture without sharp chroma edges, as a camera gives it."""
    v, u = np.mgrid[:height, :width]
    channels = (
        128 + 100 * np.sin(u / 31),
        128 + 90 * np.cos(v / 17),
        128 + 80 * np.sin((u + v) / 23),
    )
    return np.stack(channels, axis=-1).astype(np.uint8)


VIDEO_AND_FULL = [(name, r) for name in ("yuv420p", "yuv422p", "yuv444p") for r in (1, 2)]


@pytest.mark.parametrize(
    ("name", "color_range"), [*VIDEO_AND_FULL, ("yuvj420p", 2), ("yuvj422p", 2)]
)
@pytest.mark.parametrize("colorspace", [1, 5], ids=["bt709", "bt601"])
def test_agrees_with_libswscale(name, colorspace, color_range):
    frame = av.VideoFrame.from_ndarray(smooth(128, 64), format="rgb24").reformat(format=name)
    frame.colorspace, frame.color_range = colorspace, color_range
    frame.pts, frame.time_base = 0, Fraction(1, 50)
    ours = whole(picture_of_frame(frame)).astype(int)
    theirs = frame.reformat(
        format="rgb24", src_colorspace=colorspace, src_color_range=color_range, dst_color_range=2
    ).to_ndarray()
    assert np.abs(ours - theirs).max() <= 3
    # libswscale's fast path rounds down, ours to the nearest
    assert np.abs(ours - theirs).mean() < 1.5


@pytest.mark.parametrize(
    "name", ["rgb24", "bgr24", "rgba", "bgra", "argb", "abgr", "rgb0", "bgr0", "gbrp", "gray"]
)
def test_rgb_layouts_are_what_libswscale_reads(name):
    frame = av.VideoFrame.from_ndarray(smooth(50, 20), format="rgb24").reformat(format=name)
    picture = picture_of_frame(frame)
    image = whole(picture)
    expected = frame.to_ndarray(format="rgb24")
    assert not isinstance(picture, LazyPicture)
    assert picture.is_colour == (name != "gray")
    assert np.array_equal(image if picture.is_colour else image[..., None].repeat(3, 2), expected)
    assert np.array_equal(picture.region(7, 3, 30, 11), image[3:11, 7:30])


@pytest.mark.parametrize("name", ["yuv420p10le", "nv12", "rgb48le"])
def test_other_formats_are_converted_whole(name):
    frame = av.VideoFrame.from_ndarray(smooth(64, 32), format="rgb24").reformat(format=name)
    picture = picture_of_frame(frame)
    assert np.array_equal(whole(picture), frame.to_ndarray(format="rgb24"))
    assert np.array_equal(picture.region(7, 3, 30, 11), whole(picture)[3:11, 7:30])


@pytest.mark.parametrize(
    "picture",
    [
        GreyPicture(np.zeros((5, 5), np.uint8)),
        PackedPicture(np.zeros((5, 5, 3), np.uint8)),
        LazyPicture(5, 5, lambda: np.zeros((5, 5, 3), np.uint8)),
    ],
)
def test_a_region_is_a_fresh_array(picture):
    """Drawing on a crop must not change the frame."""
    part = picture.region(1, 1, 4, 4)
    part[...] = 9
    assert whole(picture).max() == 0
