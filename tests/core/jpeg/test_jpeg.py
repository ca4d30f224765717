"""Parts of JPEG pictures against FFmpeg's decoder, which decodes them whole."""

import tracemalloc

import av
import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pawnb.core.jpeg.coded import read_coded
from pawnb.core.jpeg.header import header_length, read_plan
from pawnb.core.pixels.planes import planes_of_frame

SAMPLINGS = {
    "444": (1, 1), "422": (2, 1), "420": (2, 2), "440": (1, 2), "411": (4, 1),
}  # fmt: skip


def noisy(width, height, *, seed=0):
    """A picture with smooth, flat and noisy parts: few and many coefficients."""
    rng = np.random.default_rng(seed)
    v, u = np.mgrid[:height, :width]
    rgb = np.stack([u * 255 // width, v * 255 // height, (u + v) % 256], axis=-1)
    rgb[height // 3 :, : width // 2] = rng.integers(0, 256, (height - height // 3, width // 2, 3))
    rgb[: height // 4, width // 2 :] = rng.integers(0, 256, 3)
    return rgb.astype(np.uint8)


def encoded(image, sampling="420", quality=90, **more):
    """A JPEG by libjpeg-turbo; ``more`` are names of OpenCV's options."""
    options = [cv2.IMWRITE_JPEG_QUALITY, quality]
    if image.ndim == 3:
        factor = getattr(cv2, f"IMWRITE_JPEG_SAMPLING_FACTOR_{sampling}")
        options += [cv2.IMWRITE_JPEG_SAMPLING_FACTOR, factor]
    for name, value in more.items():
        options += [getattr(cv2, f"IMWRITE_JPEG_{name}"), value]
    return cv2.imencode(".jpg", image, options)[1].tobytes()


def by_ffmpeg(data):
    """Planes as FFmpeg decodes them; None where it does not."""
    try:
        (frame,) = av.CodecContext.create("mjpeg", "r").decode(av.Packet(data))
    except (av.FFmpegError, ValueError):
        return None
    return None if frame.is_corrupt else planes_of_frame(frame)


def cut(planes, plan):
    """Planes without padding."""
    across, down = plan.steps
    chroma = (slice(-(-plan.height // down)), slice(-(-plan.width // across)))
    return [planes[0][: plan.height, : plan.width], *(plane[chroma] for plane in planes[1:])]


def assert_same(data):
    coded = read_coded(data)
    assert coded is not None
    own, origin = coded.planes(0, 0, coded.plan.width, coded.plan.height)
    assert origin == (0, 0)
    reference = by_ffmpeg(data)
    assert len(own) == len(reference)
    for a, b in zip(cut(own, coded.plan), cut(reference, coded.plan), strict=True):
        assert np.array_equal(a, b)
    return coded


@pytest.mark.parametrize("sampling", SAMPLINGS)
@pytest.mark.parametrize("quality", [4, 50, 90, 100])
@pytest.mark.parametrize("size", [(160, 64), (61, 83), (700, 17)])
def test_the_whole_is_what_ffmpeg_decodes(sampling, quality, size):
    coded = assert_same(encoded(noisy(*size), sampling, quality))
    assert coded.plan.steps == SAMPLINGS[sampling]
    assert (coded.plan.width, coded.plan.height) == size


@pytest.mark.parametrize("quality", [30, 100])
def test_grey_and_codes_made_for_the_picture(quality):
    image = noisy(161, 90)
    assert assert_same(encoded(image[..., 0], quality=quality)).plan.n_planes == 1
    assert_same(encoded(image, quality=quality, OPTIMIZE=1))


@pytest.mark.parametrize("interval", [1, 3, 11, 40, 1000])
def test_restart_markers(interval):
    assert_same(encoded(noisy(203, 117), "422", RST_INTERVAL=interval))


def test_extreme_levels():
    """Full black and white: the largest DC, and samples that are cut off at 0 and 255."""
    image = np.zeros((64, 96), np.uint8)
    image[:, 48:] = 255
    image[::3, ::5] ^= 255
    for quality in (1, 60, 100):
        assert_same(encoded(image, quality=quality))


@pytest.mark.parametrize("seed", range(8))
def test_full_blocks(seed):
    """At the best quality noise leaves no coefficient 0, so blocks end without a sign of it."""
    image = np.random.default_rng(seed).integers(0, 256, (96, 160, 3)).astype(np.uint8)
    assert_same(encoded(image, "422", 100, OPTIMIZE=seed % 2))
    # coefficients of one level: the last is often the only one in the high half
    assert_same(encoded(cv2.GaussianBlur(image, (3, 3), 0.6), "420", 97))


@settings(max_examples=30, deadline=None)
@given(data=st.data())
def test_a_part_is_that_part_of_the_whole(data):
    sampling = data.draw(st.sampled_from([*SAMPLINGS, "grey"]))
    image = noisy(203, 117)
    image = image[..., 1] if sampling == "grey" else image
    coded = read_coded(encoded(image, sampling))
    whole, _ = coded.planes(0, 0, 203, 117)
    u0, v0 = data.draw(st.integers(0, 202)), data.draw(st.integers(0, 116))
    u1, v1 = data.draw(st.integers(u0 + 1, 203)), data.draw(st.integers(v0 + 1, 117))
    part, (left, top) = coded.planes(u0, v0, u1, v1)
    assert left <= u0 < u1 <= left + part[0].shape[1]
    assert top <= v0 < v1 <= top + part[0].shape[0]
    assert part[0].shape[1] < u1 - u0 + 2 * coded.plan.unit[0]
    for c, (a, b) in enumerate(zip(part, whole, strict=True)):
        across, down = coded.plan.steps if c else (1, 1)
        v, u = top // down, left // across
        assert np.array_equal(a, b[v : v + a.shape[0], u : u + a.shape[1]])


def without(data, marker):
    """The picture without all segments of one kind."""
    kept, at, end = data[:2], 2, header_length(data)
    while at < end:
        after = at + 2 + int.from_bytes(data[at + 2 : at + 4], "big")
        kept += b"" if data[at + 1] == marker else data[at:after]
        at = after
    return kept + data[end:]


def test_codes_that_are_left_out_are_the_typical_ones():
    data = encoded(noisy(160, 64), "422")
    bare = without(data, 0xC4)
    assert len(bare) < len(data)
    assert_same(bare)


def test_what_is_not_understood_is_left_to_ffmpeg():
    image = noisy(160, 64)
    data = encoded(image)
    assert read_coded(data) is not None
    assert read_coded(encoded(image, PROGRESSIVE=1)) is None
    marked = encoded(image, RST_INTERVAL=2)
    assert read_coded(marked.replace(b"\xff\xd1", b"\xff\xd2", 1)) is None
    at = marked.index(b"\xff\xd1")
    assert read_coded(marked[:at] + marked[at + 2 :]) is None
    assert read_coded(without(data, 0xDB)) is None
    for end in (0, 1, 20, header_length(data) + 3, len(data) // 2, len(data) - 2):
        assert read_coded(data[:end]) is None
    assert read_coded(b"no picture at all") is None
    # padding after the picture, as AVI has it, is none of it
    assert_same(data + b"\x00")


def test_how_samples_are_shown_is_part_of_the_kind():
    data = encoded(noisy(160, 64))
    plain = read_plan(data[: header_length(data)]).kind
    other_size = encoded(noisy(168, 64))
    assert read_plan(other_size[: header_length(other_size)]).kind != plain
    studio = data[:2] + b"\xff\xfe\x00\x0bCS=ITU601" + data[2:]
    assert read_plan(studio[: header_length(studio)]).kind != plain
    comment = data[:2] + b"\xff\xfe\x00\x0bat 12:34." + data[2:]
    assert read_plan(comment[: header_length(comment)]).kind == plain
    coarser = encoded(noisy(160, 64), quality=40)
    assert read_plan(coarser[: header_length(coarser)]).kind == plain


@settings(max_examples=100, deadline=None)
@given(data=st.data())
def test_no_damage_leads_astray(data):
    """Most is seen; what is not leaves whole planes, as it does in FFmpeg."""
    picture = bytearray(encoded(noisy(96, 64), data.draw(st.sampled_from(["422", "420"])), 80))
    for _ in range(data.draw(st.integers(1, 3))):
        at = data.draw(st.integers(0, len(picture) - 1))
        picture[at] = data.draw(st.integers(0, 255))
    coded = read_coded(bytes(picture))
    if coded is not None and coded.plan.width * coded.plan.height < 10**6:
        own, _ = coded.planes(0, 0, coded.plan.width, coded.plan.height)
        assert cut(own, coded.plan)[0].shape == (coded.plan.height, coded.plan.width)


def test_damage_is_seen():
    """A byte changed in the middle shifts the bits after it: they end too early or too late."""
    data = encoded(noisy(160, 64), "422")
    seen = 0
    for at in range(header_length(data) + 50, len(data) - 400, 37):
        seen += read_coded(data[:at] + bytes([data[at] ^ 0x5A]) + data[at + 1 :]) is None
    tried = len(range(header_length(data) + 50, len(data) - 400, 37))
    assert seen > 0.8 * tried


@pytest.mark.slow
def test_tables_defined_over_and_over_take_no_memory():
    """20,000 Huffman codes in a header took 3.9 GB; of each name only the last one counts."""
    data = encoded(noisy(64, 48))
    at = data.index(b"\xff\xc4")
    decoy = b"\xff\xc4\x00\x14\x00\x01" + b"\0" * 15 + b"\x05"  # one code of 1 bit
    tracemalloc.start()
    try:
        plan = read_plan(data[:at] + decoy * 20_000 + data[at : header_length(data)])
        peak = tracemalloc.get_traced_memory()[1]
    finally:  # it slows down all tests that follow
        tracemalloc.stop()
    assert peak < 50e6
    expected = read_plan(data[: header_length(data)])
    for one, other in zip(plan.tables, expected.tables, strict=True):
        np.testing.assert_array_equal(one, other)
    assert_same(data[:at] + decoy * 20_000 + data[at:])
    assert read_plan(data[:at] + decoy * 200_000 + data[at : header_length(data)]) is None
