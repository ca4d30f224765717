"""Crop, mirror, lens and offset of views; views side by side, read ahead in threads."""

from __future__ import annotations

import gc
import threading
import weakref
from dataclasses import replace

import av
import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from video_clips import barcode, damage, packet_bytes, picture, write_clip, write_h264, write_mjpeg

from pawnb.core.lens import Lens, StraightPicture
from pawnb.core.video import VideoFile, open_view, open_views
from pawnb.core.video import file as file_module
from pawnb.core.video import views as views_module
from pawnb.core.video.doubts.one_film import tell_same_films
from pawnb.core.video.viewset import READ_AHEAD
from pawnb.errors import InputError, VideoError
from pawnb.trial import Animal, Calibration, Trial, View

LENS = Lens(
    matrix=((120.0, 0.0, 79.5), (0.0, 118.0, 31.5), (0.0, 0.0, 1.0)),
    distortion=(-0.3, 0.08, 0.0, 0.0),
)


def trial_of(folder, *views, **more):
    return Trial(
        kind="paws", name="t", fps=50.0, animal=Animal(id="m"), folder=folder, views=views, **more
    )


def cam(number, **more):
    return View(name=f"cam{number}", video=f"cam{number}.avi", **more)


@pytest.fixture(scope="module")
def clips(tmp_path_factory):
    """cam1.avi and cam2.avi with 40 frames, cam3.avi with 37; grey.mkv with 6."""
    folder = tmp_path_factory.mktemp("clips")
    for name, n in (("cam1", 40), ("cam2", 40), ("cam3", 37)):
        write_mjpeg(folder / f"{name}.avi", n=n)
    write_clip(folder / "grey.mkv", codec="ffv1", pix_fmt="gray", n=6)
    return folder


@pytest.mark.slow
@settings(max_examples=40, deadline=None)
@given(data=st.data())
def test_a_view_is_debayered_straightened_cropped_and_mirrored_in_that_order(clips, data):
    """The same operations on whole pictures, one after the other, give the same view."""
    u0, v0 = data.draw(st.integers(0, 158)), data.draw(st.integers(0, 62))
    u1, v1 = data.draw(st.integers(u0 + 1, 160)), data.draw(st.integers(v0 + 1, 64))
    bayer = data.draw(st.sampled_from([None, "rggb", "gbrg"]))
    lens = data.draw(st.sampled_from([None, LENS]))
    mirror = data.draw(st.booleans())
    view = View(name="a", video="grey.mkv", crop=(u0, v0, u1, v1), bayer=bayer, mirror=mirror)
    plain = View(name="a", video="grey.mkv", bayer=bayer)
    with open_view(view, clips, lens=lens) as reader, open_view(plain, clips) as whole:
        expected = whole.read(4)
        if lens is not None:
            picture = whole.frame(4)._picture
            expected = StraightPicture(picture, lens).region(0, 0, 160, 64)
        expected = expected[v0:v1, u0:u1]
        expected = expected[:, ::-1] if mirror else expected
        assert (reader.width, reader.height) == (u1 - u0, v1 - v0)
        assert reader.is_colour == (bayer is not None)
        assert np.array_equal(reader.read(4), expected)
        left, top = data.draw(st.integers(0, u1 - u0 - 1)), data.draw(st.integers(0, v1 - v0 - 1))
        right = data.draw(st.integers(left + 1, u1 - u0))
        bottom = data.draw(st.integers(top + 1, v1 - v0))
        part = reader.frame(4).crop(left, top, right, bottom)
        assert np.array_equal(part, expected[top:bottom, left:right])


def test_a_view_opened_again_shows_the_same_and_is_closed_by_itself(clips):
    view = cam(1, crop=(8, 4, 90, 60), mirror=True)
    with open_view(view, clips, lens=LENS, fps=50.0) as reader:
        with reader.again() as other:
            np.testing.assert_array_equal(other.read(7), reader.read(7))
            np.testing.assert_array_equal(other.time_s, reader.time_s)
        assert reader.read(8) is not None
        with pytest.raises(VideoError, match="closed"):
            other.read(8)


def test_frame_zero_of_the_trial_is_the_file_frame_of_the_offset(clips):
    with open_views(trial_of(clips, cam(1, offset=3), cam(2))) as views:
        assert views.names == ("cam1", "cam2")
        assert views.n_frames == 37
        frames = views.frame(10)
        assert {name: barcode(f.image()) for name, f in frames.items()} == {"cam1": 13, "cam2": 10}
        assert [f.index for f in frames.values()] == [10, 10]
        read = [barcode(f["cam1"].image()) for _, f in views.frames(30, 37)]
        assert read == list(range(33, 40))


@pytest.mark.parametrize(
    ("start", "stop", "step"), [(0, 40, 1), (39, -1, -1), (5, 30, 7), (4, 4, 1), (20, 3, -4)]
)
def test_frames_follow_range(clips, start, stop, step):
    with open_views(trial_of(clips, cam(1), cam(2))) as views:
        seen = [
            (k, *(barcode(f[name].image()) for name in ("cam1", "cam2")))
            for k, f in views.frames(start, stop, step=step)
        ]
    assert seen == [(k, k, k) for k in range(start, stop, step)]


def test_views_of_different_length_use_the_common_one_and_say_so(clips):
    with open_views(trial_of(clips, cam(1), cam(2), cam(3))) as views:
        assert views.n_frames == 37
        assert views.notes == [
            "cam3 has 37 frames, cam1 has 40: frames 37 to 39 are left out.",
            "cam3 has 37 frames, cam2 has 40: frames 37 to 39 are left out.",
        ]
        with pytest.raises(VideoError) as caught:
            views.frame(37)
        assert str(caught.value) == (
            f"view 'cam3': {clips / 'cam3.avi'} has no frame 37; it has 37 frames, 0 to 36."
        )
        with pytest.raises(VideoError):
            views.frames(30, 38)  # at once, not at the end of the work


def test_files_of_another_frame_rate_are_said(tmp_path):
    for number, rate in ((1, 100), (2, 50), (3, 101)):
        write_mjpeg(tmp_path / f"cam{number}.avi", n=10, rate=rate)
    with open_views(trial_of(tmp_path, cam(1), cam(2), cam(3))) as views:
        (said,) = [one for one in views.notes if one.startswith("the file of")]
    assert said.startswith("the file of cam2 has 50 frames/s, that of cam1 100: frames of one num")


def test_a_trial_that_asks_for_frames_that_are_not_there_is_refused(clips):
    with pytest.raises(VideoError, match=r"view 'cam3': .* has no frame 39; it has 37 frames"):
        open_views(trial_of(clips, cam(1), cam(3), frames=(0, 40)))
    open_views(trial_of(clips, cam(1), cam(3), frames=(0, 37))).close()


def test_a_view_that_begins_later(clips):
    with open_views(trial_of(clips, cam(1), cam(2, offset=-4))) as views:
        assert views.first_frame == 4
        assert views.notes == [
            "cam1 has 40 frames from frame 0 of the trial on, cam2 has 44: frames 40 to 43 are "
            "left out.",
            "cam2 begins at frame 4 of the trial: it lacks frames 0 to 3.",
        ]
        assert barcode(views.frame(4)["cam2"].image()) == 0
        with pytest.raises(VideoError, match=r"has no frame -1; .* \(frame 3 of the trial\)\."):
            views.frame(3)
    with pytest.raises(VideoError, match="view 'cam1' ends at frame 39 of the trial, before every"):
        open_views(trial_of(clips, cam(1), cam(2, offset=-40)))


def test_time_of_a_trial(clips, tmp_path):
    with open_views(trial_of(clips, cam(1), cam(2))) as views:
        np.testing.assert_allclose(views.time_s, np.arange(40) / 50)
    uneven = [k + k // 7 for k in range(30)]
    write_h264(tmp_path / "cam1.mp4", n=30, times=uneven)
    view = View(name="cam1", video="cam1.mp4", offset=2)
    with open_views(trial_of(tmp_path, view)) as views:
        np.testing.assert_allclose(views.time_s, (np.array(uneven[2:]) - 2) / 50, atol=1e-9)
        # 29 steps take 33 ticks of 1/50 s
        assert views.notes == [
            "cam1: the frame rate varies (mean 43.94 frames/s, fps is 50); the file's own time "
            "stamps are used."
        ]


def test_views_of_one_file_are_decoded_once(clips, monkeypatch):
    grabbed = []
    original = VideoFile.grab
    monkeypatch.setattr(
        VideoFile, "grab", lambda self, k, **how: (grabbed.append(k), original(self, k, **how))[1]
    )
    left = View(name="left", video="cam1.avi", crop=(0, 0, 80, 64))
    right = View(name="right", video="cam1.avi", crop=(80, 0, 160, 64), mirror=True)
    with open_views(trial_of(clips, left, right)) as views:
        grabbed.clear()
        for _, frames in views.frames(0, 10):
            whole = np.hstack([frames["left"].image(), frames["right"].image()[:, ::-1]])
        assert grabbed == list(range(10))
        assert barcode(whole) == 9


def test_an_error_arrives_after_the_frames_before_it_with_view_and_number(tmp_path):
    for k in (1, 2):
        write_mjpeg(tmp_path / f"cam{k}.avi", n=20)
    start, size = packet_bytes(tmp_path / "cam2.avi", 12)
    damage(tmp_path / "cam2.avi", start, size)
    seen = []
    with open_views(trial_of(tmp_path, cam(1), cam(2))) as views:
        with pytest.raises(VideoError) as caught:
            seen += [k for k, _ in views.frames(0, 20)]
        for k, _ in views.frames(0, 12):
            seen.append(k)
    assert seen == list(range(12))
    assert str(caught.value) == (
        f"view 'cam2': {tmp_path / 'cam2.avi'}: frame 12 cannot be decoded; the file is damaged "
        "there or shortly before."
    )


def readers_at_work():
    return [t.name for t in threading.enumerate() if t.name.startswith("pawnb-")]


def test_leaving_early_stops_the_threads(clips):
    with open_views(trial_of(clips, cam(1), cam(2))) as views:
        ahead = views.frames(0, 40)
        next(ahead)
        assert len(readers_at_work()) == 2
        ahead.close()
        assert readers_at_work() == []
        for k, _ in views.frames(0, 40):
            if k == 3:
                break
        gc.collect()
        assert readers_at_work() == []


@pytest.mark.slow
@pytest.mark.parametrize("step", [1, -1])
def test_memory_stays_flat(tmp_path, monkeypatch, step):
    """Never more pictures alive than are waiting, being made and in the consumer's hands."""
    for k in (1, 2):
        write_h264(tmp_path / f"cam{k}.avi", n=300, options={"bf": "2", "g": "10"})
    alive = weakref.WeakSet()
    original = views_module.Frame.__init__

    class Counted(views_module.Frame):
        __slots__ = ("__weakref__",)

        def __init__(self, *args, **more):
            original(self, *args, **more)
            alive.add(self)

    monkeypatch.setattr(views_module, "Frame", Counted)
    most = 0
    with open_views(trial_of(tmp_path, cam(1), cam(2))) as views:
        numbers = (0, 300) if step == 1 else (299, -1)
        for _ in views.frames(*numbers, step=step):
            most = max(most, len(alive))
        kept = [len(reader.source._kept) for reader in views.readers.values()]
    assert 2 <= most <= 2 * (READ_AHEAD + 2)
    assert max(kept) <= 64


@pytest.mark.parametrize(("share", "kept"), [(False, 40), (True, 20)])
def test_memory_for_stepping_back_can_be_one_for_all_files(tmp_path, monkeypatch, share, kept):
    """Room for 40 pictures of one file is room for 20 of each of two."""
    monkeypatch.setattr(file_module, "_BLOCK_BYTES", 40 * 2 * 160 * 64)
    for k in (1, 2):
        write_h264(tmp_path / f"cam{k}.avi", n=60, options={"bf": "0", "g": "60"})
    with open_views(trial_of(tmp_path, cam(1), cam(2)), share_memory=share) as views:
        views.frame(59)
        views.frame(55)  # back: read again from the key frame, 0
        assert [len(r.source._kept) for r in views.readers.values()] == [kept, kept]


def test_lenses_are_looked_up_by_view(clips, tmp_path):
    lens = (
        "matrix = [[120.0, 0, 79.5], [0, 118.0, 31.5], [0, 0, 1]]\n"
        "distortion = [-0.3, 0.08, 0, 0]\n"
    )
    path = tmp_path / "lenses.toml"
    path.write_text(f"[cam1]\n{lens}")
    one = trial_of(clips, cam(1), calibration=Calibration(lens=str(path)))
    with open_views(one) as views, open_view(cam(1), clips, lens=LENS) as reader:
        assert np.array_equal(views.frame(3)["cam1"].image(), reader.read(3))
    two = trial_of(clips, cam(1), cam(2), calibration=Calibration(lens=str(path)))
    with pytest.raises(InputError) as caught:
        open_views(two)
    assert str(caught.value) == (
        f"{path}: no section [cam2] (did you mean 'cam1'?); expected one for each view."
    )


def test_a_trial_without_views(tmp_path):
    with pytest.raises(VideoError, match=r"trial 't' has no views; add \[\[views\]\]"):
        open_views(trial_of(tmp_path))


def test_one_film_given_for_two_views_is_said(tmp_path):
    """Copied, and compressed again; films of two cameras, or flat ones, are not said to be one."""
    rng = np.random.default_rng(5)
    shown = {
        1: cv2.GaussianBlur(rng.uniform(0, 255, (64, 160)), (0, 0), 3),
        2: cv2.GaussianBlur(rng.uniform(0, 255, (64, 160)), (0, 0), 3),
        3: np.full((64, 160), 9.0),
    }
    for name, kind, suffix in (("a", 1, "png"), ("b", 1, "jpg"), ("c", 2, "png"), ("d", 3, "png"),
                               ("e", 3, "png")):  # fmt: skip
        (tmp_path / name).mkdir()
        for k in range(2):
            cv2.imwrite(str(tmp_path / name / f"{k}.{suffix}"), shown[kind].astype(np.uint8))
    views = [View(name=name, video=name) for name in "abcde"]
    views.append(View(name="f", video="a", crop=(0, 0, 80, 64)))  # of one file by intent
    with open_views(trial_of(tmp_path, *views)) as opened:
        (said,) = tell_same_films(opened)
    assert said.startswith("the films of views a and b begin with the same picture: one film seems")


@pytest.mark.parametrize(("fps", "is_said"), [(30.0, True), (240.0, False), (960.0, True)])
def test_a_film_in_slow_motion_that_says_how_it_was_filmed_is_compared(tmp_path, fps, is_said):
    """Android writes com.android.capture.fps: with 30 given strides were eight times too long."""
    tagged = {"movflags": "use_metadata_tags"}
    with av.open(str(tmp_path / "cam1.mp4"), "w", options=tagged) as container:
        container.metadata["com.android.capture.fps"] = "240.000000"
        stream = container.add_stream("mpeg4", rate=30)
        stream.width, stream.height, stream.pix_fmt = 160, 64, "yuv420p"
        for k in range(6):
            container.mux(stream.encode(av.VideoFrame.from_ndarray(picture(k), format="rgb24")))
        container.mux(stream.encode())
    trial = trial_of(tmp_path, View(name="cam1", video="cam1.mp4"))
    with open_views(replace(trial, fps=fps)) as views:
        said = [note for note in views.notes if "filmed with 240 frames/s" in note]
    assert len(said) == is_said
