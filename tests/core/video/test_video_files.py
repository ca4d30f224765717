"""The frame you ask for is the frame you get, whatever the container."""

from __future__ import annotations

import contextlib
import threading

import cv2
import numpy as np
import pytest
from video_clips import (
    H264,
    N,
    barcode,
    copy_packets,
    give_palette,
    picture,
    plain_reading,
    store,
    write_clip,
    write_h264,
    write_mjpeg,
)

from pawnb.core.video import VideoFile, open_view, open_views
from pawnb.core.video.packets import PacketIndex
from pawnb.trial import Animal, Trial, View

# every seventh picture comes late by one frame
UNEVEN = [k + k // 7 for k in range(N)]
OPEN_GOP = {"bf": "3", "g": "20", "x264-params": "open-gop=1:scenecut=0"}
ALL = list(range(N))


def edited(folder):
    """H.264 whose edit list hides the first 27 pictures, so that it begins between key frames."""
    whole = write_h264(folder / "whole.mp4")
    return copy_packets(whole, folder / "clip.mp4", skip_ticks=27 * 256)


def upside_down(folder):
    path = write_clip(folder / "clip.avi", codec="rawvideo", pix_fmt="bgr24", n=12)
    return store(path, bottom_up=True)


def write_pictures(folder):
    """Numbered without leading zeros: 10 must come after 9."""
    for k in range(12):
        cv2.imwrite(str(folder / f"frame{k + 7}.png"), picture(k)[..., ::-1])
    return folder


CLIPS = {
    "mjpeg-avi": (lambda d: write_mjpeg(d / "clip.avi"), ALL),
    "h264-mp4": (lambda d: write_h264(d / "clip.mp4"), ALL),
    "h264-avi": (lambda d: write_h264(d / "clip.avi"), ALL),
    "h264-ts": (lambda d: write_h264(d / "clip.ts"), ALL),
    "h264-raw": (lambda d: write_h264(d / "clip.h264"), ALL),
    "h264-open-gop-mp4": (lambda d: write_h264(d / "clip.mp4", options=OPEN_GOP), ALL),
    "h264-open-gop-avi": (lambda d: write_h264(d / "clip.avi", options=OPEN_GOP), ALL),
    "h264-variable-rate": (lambda d: write_h264(d / "clip.mp4", times=UNEVEN), ALL),
    "h264-edit-list": (edited, ALL[27:]),
    "mpeg4-avi": (
        lambda d: write_clip(
            d / "clip.avi", codec="mpeg4", pix_fmt="yuv420p", options={"bf": "2", "g": "12"}
        ),
        ALL,
    ),
    # a seek lands inside the picture before
    "mpeg2-program-stream": (
        lambda d: write_clip(
            d / "clip.mpg", codec="mpeg2video", pix_fmt="yuv420p", options={"bf": "2", "g": "12"}
        ),
        ALL,
    ),
    "ffv1-mkv": (lambda d: write_clip(d / "clip.mkv", codec="ffv1", pix_fmt="bgr0"), ALL),
    "raw-avi": (
        lambda d: write_clip(d / "clip.avi", codec="rawvideo", pix_fmt="bgr24", n=12),
        ALL[:12],
    ),
    "bottom-up-avi": (upside_down, ALL[:12]),
    "pictures": (write_pictures, ALL[:12]),
}


@pytest.fixture(scope="module", params=CLIPS)
def clip(request, tmp_path_factory):
    """A clip, and the numbers in its pictures in the order in which they are shown."""
    make, numbers = CLIPS[request.param]
    return request.param, make(tmp_path_factory.mktemp(request.param)), numbers


def opened(path):
    return open_view(View(name="cam1", video=path.name), path.parent)


def number_of(image, name):
    return barcode(image[::-1] if name == "bottom-up-avi" else image)


def test_sequential_reading_is_what_the_decoder_gives(clip):
    name, path, numbers = clip
    with opened(path) as reader:
        images = [reader.read(k) for k in range(reader.n_frames)]
    assert [number_of(image, name) for image in images] == numbers
    if path.is_file():
        plain = plain_reading(path)
        assert len(plain) == len(images)
        for ours, theirs in zip(images, plain, strict=True):
            # libswscale's fast conversion is rounded more coarsely
            assert np.abs(ours.astype(int) - theirs).max() <= 3


def test_random_order_is_bit_identical_to_sequential(clip):
    name, path, numbers = clip
    with opened(path) as reader:
        images = [reader.read(k) for k in range(reader.n_frames)]
    order = [*range(len(numbers)), *range(len(numbers))]
    np.random.default_rng(4).shuffle(order)
    with opened(path) as reader:
        for k in order:
            image = reader.read(k)
            assert number_of(image, name) == numbers[k], f"asked for {k}"
            assert np.array_equal(image, images[k])


def test_backwards_is_bit_identical(clip):
    _, path, numbers = clip
    with opened(path) as reader:
        images = [reader.read(k) for k in range(reader.n_frames)]
        for k in reversed(range(len(numbers))):
            assert np.array_equal(reader.read(k), images[k])


def test_several_threads_on_one_reader(clip):
    name, path, numbers = clip
    wrong = []

    def work(seed):
        draw = np.random.default_rng(seed)
        for _ in range(15):
            k = int(draw.integers(len(numbers)))
            if number_of(reader.read(k), name) != numbers[k]:
                wrong.append(k)

    with opened(path) as reader:
        threads = [threading.Thread(target=work, args=(seed,)) for seed in range(3)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    assert wrong == []


def count_decoding(monkeypatch):
    """Count how often a file begins to decode anew."""
    begun = []
    original = VideoFile._begin_at

    def counted(self, restart, first):
        begun.append(first)
        original(self, restart, first)

    monkeypatch.setattr(VideoFile, "_begin_at", counted)
    return begun


@pytest.mark.parametrize("suffix", ["mp4", "avi", "mkv"])
def test_a_seek_that_lands_too_late_is_noticed(tmp_path, monkeypatch, suffix):
    """Demuxers overshoot in some files: then the seek is tried further back."""
    path = write_h264(tmp_path / f"clip.{suffix}")
    original = PacketIndex.seek_ticks

    def overshooting(self, packet, *, step):
        return [original(self, 40, step=step)[0], *original(self, packet, step=step)]

    monkeypatch.setattr(PacketIndex, "seek_ticks", overshooting)
    with opened(path) as reader:
        assert [barcode(reader.read(k)) for k in (25, 3, 45, 20)] == [25, 3, 45, 20]


def test_where_no_seek_succeeds_reading_begins_at_the_start(tmp_path, monkeypatch):
    path = write_h264(tmp_path / "clip.avi")
    monkeypatch.setattr(PacketIndex, "seek_ticks", lambda self, packet, *, step: [])
    with opened(path) as reader:
        assert [barcode(reader.read(k)) for k in (25, 3, 45, 20)] == [25, 3, 45, 20]


@pytest.mark.parametrize("suffix", ["mp4", "avi"])
def test_sequential_reading_never_seeks_again(tmp_path, monkeypatch, suffix):
    path = write_h264(tmp_path / f"clip.{suffix}")
    begun = count_decoding(monkeypatch)
    with opened(path) as reader:
        for k in range(reader.n_frames):
            reader.frame(k)
    assert begun == [0]


def test_stepping_back_decodes_a_group_once(tmp_path, monkeypatch):
    path = write_h264(tmp_path / "clip.mp4")  # key frames at 0, 20, 40
    begun = count_decoding(monkeypatch)
    with opened(path) as reader:
        for k in reversed(range(reader.n_frames)):
            reader.frame(k)
    assert begun == [0, 40, 20, 0]


def test_time_stamps_of_a_variable_rate(tmp_path):
    path = write_h264(tmp_path / "clip.mp4", times=UNEVEN)
    with open_view(View(name="cam1", video=path.name), tmp_path, fps=50.0) as reader:
        assert reader.is_variable_rate
        # written at 50 ticks a second
        np.testing.assert_allclose(reader.time_s, np.array(UNEVEN) / 50, atol=1e-9)


@pytest.mark.parametrize(
    ("fps", "slower"),
    # filmed at 250 frames/s and played at 50; a camera that takes fewer frames than it says
    [(250.0, 5.0), (10.0, 0.2), (100.0, 1.0)],
)
def test_stamps_of_a_film_in_slow_motion_are_brought_to_the_time_of_filming(tmp_path, fps, slower):
    path = write_h264(tmp_path / "clip.mp4", times=UNEVEN)
    made = View(name="cam1", video=path.name)
    told = {"kind": "paws", "name": "t", "animal": Animal(id="a"), "folder": tmp_path}
    with open_views(Trial(**told, fps=fps, views=(made,))) as views:
        expected = np.array(UNEVEN) / 50 / slower
        np.testing.assert_allclose(views.time_s, expected - expected[0], atol=1e-9)
        (note,) = views.notes
        mean = (len(UNEVEN) - 1) / (UNEVEN[-1] - UNEVEN[0]) * 50
        assert f"mean {mean:.4g} frames/s, fps is {fps:.4g}" in note
        assert ("slower" in note) == (slower > 1)
        assert ("faster" in note) == (slower < 1)


@pytest.mark.parametrize(("fps", "is_said"), [(250.0, False), (50.0, False), (6.0, True)])
def test_a_film_that_would_be_played_faster_than_it_was_filmed_is_said(tmp_path, fps, is_said):
    """A phone's film of 240 frames/s, for which the usual 30 are given."""
    told = {"kind": "paws", "name": "t", "animal": Animal(id="a"), "folder": tmp_path, "fps": fps}
    write_h264(tmp_path / "clip.mp4")  # of 50 frames/s
    with open_views(Trial(**told, views=(View(name="v", video="clip.mp4"),))) as views:
        assert ["the file says 50 frames/s, but fps is 6:" in n for n in views.notes] == (
            [True] * is_said
        )


@pytest.mark.parametrize("fps", [50.0, 400.0])
def test_a_part_in_slow_motion_is_said(tmp_path, fps):
    """Phones save films that go over into slow motion and back; one frame in 20 may be dropped."""
    told = {"kind": "paws", "name": "t", "animal": Animal(id="a"), "folder": tmp_path, "fps": fps}
    notes = []
    for name, times in {
        "slow": [*range(20), *range(20, 180, 8), *range(180, 200)],
        "dropped": [k + 5 * (k // 20) for k in range(N)],
    }.items():
        write_h264(tmp_path / f"{name}.mp4", times=times)
        views = (View(name=name, video=f"{name}.mp4"),)
        with open_views(Trial(**told, views=views)) as opened_views:
            notes += opened_views.notes
    assert "34% of its frames last more than three times as long" in notes[0]
    assert "slow motion, times are wrong" in notes[0]
    assert "make a film of its own" not in notes[1]


@pytest.mark.parametrize("suffix", ["mp4", "avi"])
def test_time_of_a_constant_rate_is_frame_over_fps(tmp_path, suffix):
    """A high-speed clip plays at 50 frames/s and was filmed at 250."""
    write_h264(tmp_path / f"clip.{suffix}")
    view = View(name="cam1", video=f"clip.{suffix}")
    with open_view(view, tmp_path, fps=250.0) as reader:
        assert not reader.is_variable_rate
        np.testing.assert_allclose(reader.time_s, np.arange(N) / 250)
    with open_view(view, tmp_path) as reader:
        np.testing.assert_allclose(reader.time_s, np.arange(N) / 50, atol=1e-9)


def test_rounded_time_stamps_are_a_constant_rate(tmp_path):
    """Matroska rounds to ms: at 60 frames/s the steps are 16 and 17 ms."""
    path = write_clip(tmp_path / "clip.mkv", codec="ffv1", pix_fmt="bgr0", rate=60)
    with opened(path) as reader:
        assert not reader.is_variable_rate


def test_grey_format_gives_grey_pictures(tmp_path):
    path = write_clip(tmp_path / "clip.mkv", codec="ffv1", pix_fmt="gray", n=5)
    with opened(path) as reader:
        assert not reader.is_colour
        image = reader.read(3)
        assert image.shape == (64, 160)
        assert barcode(image) == 3


def test_grey_of_ten_bits_keeps_the_upper_eight(tmp_path):
    shallow = write_clip(tmp_path / "a.mkv", codec="ffv1", pix_fmt="gray", n=3)
    deep = write_clip(
        tmp_path / "b.mkv", codec="ffv1", pix_fmt="gray10le", n=3, options={"level": "3"}
    )
    with opened(shallow) as a, opened(deep) as b:
        assert not b.is_colour
        assert np.abs(a.read(2).astype(int) - b.read(2)).max() <= 1


@pytest.mark.parametrize("bottom_up", [False, True])
@pytest.mark.parametrize("colour", [False, True])
def test_uncompressed_avi_with_a_palette(tmp_path, bottom_up, colour):
    """Many cameras write 8-bit AVI with a palette of greys, stored bottom up."""
    path = write_clip(tmp_path / "clip.avi", codec="rawvideo", pix_fmt="gray", n=3)
    with opened(path) as reader:
        stored = reader.read(2)
    greys = np.repeat(np.arange(256, dtype=np.uint8)[:, None], 3, axis=1)
    palette = greys * [1, 0, 1] + [0, 7, 0] if colour else 255 - greys
    give_palette(path, palette)
    store(path, bottom_up=bottom_up)
    with opened(path) as reader:
        assert reader.is_colour == colour
        image = reader.read(2)
    expected = palette[stored] if colour else 255 - stored
    assert np.array_equal(image[::-1] if bottom_up else image, expected)


def test_real_clip_of_a_grey_mouse(real_data):
    """994 frames (SOURCE.txt), yuv420p with grey content: colour by its format."""
    folder = real_data("mouse-side-bottom")
    with open_view(View(name="side", video="test_vid.mp4"), folder) as reader:
        assert (reader.n_frames, reader.width, reader.height) == (994, 396, 406)
        assert reader.is_colour
        late = reader.read(700)
        early = reader.read(10)
        assert np.array_equal(reader.read(700), late)
        assert not np.array_equal(early, late)
        assert np.ptp(late.astype(int), axis=2).max() <= 4


def test_h264_options_make_b_frames(tmp_path):
    """The clips above test nothing unless pictures really are stored out of order."""
    import av

    with av.open(str(write_h264(tmp_path / "clip.mp4", options=H264))) as container:
        shown = [p.pts for p in container.demux(video=0) if p.size]
    assert shown != sorted(shown)


def write_two(path, *, is_cover):
    """Write a film and a single picture: before it as a film, or behind it as its cover."""
    import av

    sources = [write_mjpeg(path.parent / "a.mkv", n=1), write_h264(path.parent / "b.mkv")]
    with contextlib.ExitStack() as opened_files, av.open(str(path), "w") as out:
        inputs = [
            opened_files.enter_context(av.open(str(p))) for p in sources[:: -1 if is_cover else 1]
        ]
        copies = [out.add_stream_from_template(i.streams.video[0]) for i in inputs]
        if is_cover:
            copies[1].disposition = av.stream.Disposition.attached_pic.value
        for source, copy in zip(inputs, copies, strict=True):
            for packet in source.demux(video=0):
                if packet.size:
                    packet.stream = copy
                    out.mux(packet)
    return path


def test_a_cover_picture_is_no_film(tmp_path):
    video = VideoFile(write_two(tmp_path / "clip.mp4", is_cover=True))
    assert len(video._container.streams.video) == 2
    assert (video.n_frames, video.notes) == (N, [])


def test_of_several_films_in_a_file_it_is_said_which_is_used(tmp_path):
    video = VideoFile(write_two(tmp_path / "clip.mkv", is_cover=False))
    (note,) = video.notes
    assert "holds 2 films; the first is used (160 x 64 px, frames: 1)" in note
