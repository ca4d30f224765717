"""Folders and globs of pictures."""

from __future__ import annotations

import warnings

import cv2
import numpy as np
import pytest
from PIL import Image
from video_clips import barcode, picture

from pawnb.core.video import open_view
from pawnb.core.video.pictures import PictureFolder, _is_whole, natural_key
from pawnb.core.video.stack import PictureStack
from pawnb.errors import VideoError
from pawnb.input_warnings import warn_of_input
from pawnb.trial import View


def write(folder, name, number=0, *, grey=False):
    image = picture(number)[..., ::-1]
    ok, data = cv2.imencode((folder / name).suffix, image[..., 1] if grey else image)
    assert ok
    (folder / name).parent.mkdir(exist_ok=True)
    (folder / name).write_bytes(data.tobytes())


def numbers(path):
    source = PictureFolder(path)
    return [
        barcode(source.grab(k).region(0, 0, source.width, source.height))
        for k in range(source.n_frames)
    ]


def refusal(path):
    with pytest.raises(VideoError) as caught:
        PictureFolder(path)
    return str(caught.value)


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".tif", ".bmp", ".PNG"])
def test_numbers_decide_the_order(tmp_path, suffix):
    for k in (8, 9, 10, 11):
        write(tmp_path, f"frame{k}{suffix}", k)
    assert numbers(tmp_path) == [8, 9, 10, 11]


def test_lossless_pictures_come_back_in_rgb(tmp_path):
    write(tmp_path, "a0.png", 5)
    write(tmp_path, "a1.png", 6)
    with open_view(View(name="cam1", video="."), tmp_path) as reader:
        assert np.array_equal(reader.read(1), picture(6))


def test_grey_and_sixteen_bit_pictures(tmp_path):
    for k in range(3):
        cv2.imwrite(str(tmp_path / f"a{k}.png"), picture(k)[..., 1].astype(np.uint16) * 256 + 77)
    source = PictureFolder(tmp_path)
    assert not source.is_colour
    assert np.array_equal(source.grab(2).region(0, 0, 160, 64), picture(2)[..., 1])


def test_names_outside_ascii(tmp_path):
    for k in range(2):
        write(tmp_path, f"Mäuse/läuft_{k}.png", k)
    assert numbers(tmp_path / "Mäuse") == [0, 1]


def test_a_glob_picks_one_series(tmp_path):
    for k in range(3):
        write(tmp_path, f"cam1_{k:03d}.png", k)
        write(tmp_path, f"cam2_{k:03d}.png", 100 + k)
    assert numbers(tmp_path / "cam2_*.png") == [100, 101, 102]
    assert refusal(tmp_path) == (
        f"{tmp_path}: two pictures have the same number (cam1_000.png, ...), as if there were "
        'several series; name one by a glob, for instance video = "frames/cam1_*.png".'
    )


def test_several_series_are_refused(tmp_path):
    for k in range(2):
        write(tmp_path, f"left{k}.png")
        write(tmp_path, f"right{k}.png")
    assert "several series of pictures (left0.png and right0.png, ...)" in refusal(tmp_path)


def test_a_lone_background_is_left_out_and_said(tmp_path):
    for k in range(3):
        write(tmp_path, f"frame{k:05d}.png", k)
    write(tmp_path, "background.png", 999)
    assert numbers(tmp_path) == [0, 1, 2]
    assert PictureFolder(tmp_path).notes == [
        f"{tmp_path}: background.png is not part of the numbered series and is left out."
    ]


@pytest.mark.parametrize("step", [1, 10])
def test_a_missing_number_is_named(tmp_path, step):
    for k in (0, 1, 2, 4, 5):
        write(tmp_path, f"frame{k * step:03d}.png")
    assert refusal(tmp_path) == (
        f"{tmp_path}: frame 3 is missing, between frame{2 * step:03d}.png and "
        f"frame{4 * step:03d}.png; put the picture back or number the pictures without a gap."
    )


def test_every_tenth_picture_is_no_gap(tmp_path):
    for k in range(4):
        write(tmp_path, f"frame{k * 10}.png", k * 10)
    assert numbers(tmp_path) == [0, 10, 20, 30]


def test_no_pictures(tmp_path):
    assert refusal(tmp_path) == (
        f"{tmp_path}: no pictures there; expected files that end in .png, .jpg, .jpeg, .tif, "
        ".tiff, .bmp."
    )
    assert refusal(tmp_path / "*.png").startswith(f"{tmp_path / '*.png'}: no pictures there;")


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".bmp", ".tif"])
def test_a_picture_cut_short_is_refused(tmp_path, suffix):
    """cv2 would fill the missing part with grey without a word."""
    for k in range(3):
        write(tmp_path, f"a{k}{suffix}", k)
    file = tmp_path / f"a2{suffix}"
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    source = PictureFolder(tmp_path)
    source.grab(1)
    with pytest.raises(VideoError) as caught:
        source.grab(2)
    assert str(caught.value) == (
        f"{file}: frame 2 cannot be read as a picture; the file is damaged, cut short or of "
        "another kind."
    )


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".bmp"])
def test_is_whole(suffix):
    """Not left to cv2: some versions decode what is there and say nothing."""
    data = cv2.imencode(suffix, picture(3))[1].tobytes()
    assert _is_whole(data)
    assert not _is_whole(data[:-20])
    assert not _is_whole(data[: len(data) // 2])


def test_pictures_of_another_size_or_kind_are_refused(tmp_path):
    for k in range(3):
        write(tmp_path, f"a{k}.png", grey=k == 2)
    cv2.imwrite(str(tmp_path / "a1.png"), np.zeros((10, 20, 3), np.uint8))
    source = PictureFolder(tmp_path)
    with pytest.raises(VideoError, match="frame 1 is 20 x 10 px, but frame 0 is 160 x 64"):
        source.grab(1)
    with pytest.raises(VideoError, match="frame 2 is grey, but frame 0 is in colour"):
        source.grab(2)


def test_pictures_carry_no_time(tmp_path):
    for k in range(4):
        write(tmp_path, f"a{k}.png")
    view = View(name="cam1", video=".")
    with pytest.raises(VideoError, match="view 'cam1': pictures carry no time; give fps"):
        _ = open_view(view, tmp_path).time_s
    np.testing.assert_allclose(open_view(view, tmp_path, fps=8.0).time_s, [0, 0.125, 0.25, 0.375])


def test_natural_key():
    names = ["a10", "a9", "b1", "a", "A2"]
    assert sorted(names, key=natural_key) == ["a", "A2", "a9", "a10", "b1"]


def test_real_pictures_of_a_fly(real_data):
    """A numbered series beside background.png."""
    folder = real_data("flies-topview")
    with open_view(View(name="top", video="clip_inverted"), folder, fps=25.0) as reader:
        assert reader.n_frames > 100
        assert reader.read(7).shape[:2] == (reader.height, reader.width)
        assert "background.png" in reader.source.notes[0]


@pytest.mark.parametrize("orientation", [1, 3, 6])
def test_a_picture_that_is_to_be_shown_turned_is_used_as_it_lies_and_said(tmp_path, orientation):
    """Tag 0x0112 of EXIF, as phones write it: 3 is upside down, 6 a quarter turn."""
    image = Image.fromarray(picture(3))
    exif = image.getexif()
    exif[0x0112] = orientation
    image.save(tmp_path / "board1.jpg", exif=exif)
    source = PictureFolder(tmp_path)
    assert (source.width, source.height) == image.size
    assert barcode(source.grab(0).region(0, 0, *image.size)) == 3
    said = [note for note in source.notes if f"EXIF orientation {orientation}" in note]
    assert len(said) == (orientation != 1)


def write_stack(path, images, **more):
    """Write one TIFF of several pictures."""
    first, *others = [Image.fromarray(image) for image in images]
    first.save(path, save_all=True, append_images=others, **more)
    return path


@pytest.mark.parametrize("depth", ["colour", "grey", "12 bits", "16 bits"])
def test_a_stack_of_pictures_is_a_film(tmp_path, depth):
    images = [picture(k) for k in range(12)]
    if depth != "colour":
        images = [image[..., 1] for image in images]
    factor = {"12 bits": 16, "16 bits": 257}.get(depth)
    stored = [i.astype(np.uint16) * factor for i in images] if factor else images
    write_stack(tmp_path / "stack.tif", stored)
    with open_view(View(name="v", video="stack.tif"), tmp_path) as view:
        assert view.n_frames == 12
        assert view.is_colour == (depth == "colour")
        for k in np.random.default_rng(3).permutation(12):
            np.testing.assert_array_equal(view.read(k), images[k])
        with view.again() as other:
            np.testing.assert_array_equal(other.read(7), images[7])


def test_an_open_stack_hides_no_warnings(tmp_path):
    """Of two views, closed in the order in which they were opened, none was shown ever after."""
    paths = [write_stack(tmp_path / f"{n}.tif", [picture(k) for k in range(3)]) for n in "ab"]
    with warnings.catch_warnings(record=True) as shown:
        warnings.simplefilter("always")
        stacks = [PictureStack(path) for path in paths]
        warn_of_input("while they are open")
        for stack in stacks:
            stack.close()
        warn_of_input("afterwards")
    assert [str(one.message) for one in shown] == ["while they are open", "afterwards"]


def test_of_sixteen_bits_those_in_use_are_shown_and_it_is_said(tmp_path):
    """Cameras of 12 bits fill the lower 12 of 16: with the upper 8 of these all would be black."""
    for k in range(4):
        cv2.imwrite(str(tmp_path / f"{k}.tif"), picture(k)[..., 1].astype(np.uint16) * 16 + 7)
    source = PictureFolder(tmp_path)
    assert np.array_equal(source.grab(2).region(0, 0, 160, 64), picture(2)[..., 1])
    (note,) = source.notes
    assert "no more than 12 are in use" in note


@pytest.mark.parametrize("bits", [10, 12, 14])
def test_of_cameras_of_any_depth_the_bits_in_use_are_shown(tmp_path, bits):
    """The brightest of 10 bits was shown as 63 of 255, that of 14 too."""
    images = [(picture(k)[..., 1].astype(np.uint16) << bits - 8) + 1 for k in range(4)]
    write_stack(tmp_path / "stack.tif", images)
    with open_view(View(name="v", video="stack.tif"), tmp_path) as view:
        np.testing.assert_array_equal(view.read(2), picture(2)[..., 1])
        assert f"no more than {bits} are in use" in view.source.notes[0]


def test_channels_of_a_hyperstack_are_no_frames(tmp_path):
    """ImageJ's order is channel by channel: every other picture is of another camera or lamp."""
    path = tmp_path / "stack.tif"
    for axes, ok in (
        ("channels=2\nframes=3", False),
        ("slices=3\nframes=2", False),
        ("slices=6", True),
        ("channels=6\nhyperstack=true", True),
        ("channels=1\nslices=1\nframes=6", True),
    ):
        said = {270: f"ImageJ=1.53\nimages=6\n{axes}\nloop=false\n"}
        write_stack(path, [picture(k) for k in range(6)], tiffinfo=said)
        if ok:
            with open_view(View(name="v", video="stack.tif"), tmp_path) as view:
                assert view.n_frames == 6
        else:
            with pytest.raises(VideoError, match="a hyperstack of ImageJ"):
                open_view(View(name="v", video="stack.tif"), tmp_path)


def test_a_png_of_many_pictures_is_a_film(tmp_path):
    """Its first picture was taken for all of it."""
    first, *others = [Image.fromarray(picture(k)) for k in range(7)]
    first.save(tmp_path / "film.png", save_all=True, append_images=others, duration=40)
    with open_view(View(name="v", video="film.png"), tmp_path) as view:
        assert view.n_frames == 7
        for k in (0, 6, 2, 5):
            np.testing.assert_array_equal(view.read(k), picture(k))
    first.save(tmp_path / "one.png")
    with open_view(View(name="v", video="one.png"), tmp_path) as view:
        assert view.n_frames == 1


def test_a_picture_that_is_missing_is_seen_beside_a_clock_in_the_names(tmp_path):
    """Basler's pylon Viewer writes date, time and counter; a gap was passed over."""
    names = [f"cam_20240501_{120000000 + 33 * k + k % 3}_{k:04d}.png" for k in range(8)]
    for k, name in enumerate(names):
        write(tmp_path, name, k)
    assert numbers(tmp_path) == list(range(8))
    (tmp_path / names[5]).unlink()
    assert f"frame 5 is missing, between {names[4]} and {names[6]}" in refusal(tmp_path)


def test_a_clock_beside_the_counter_may_jump(tmp_path):
    for k in range(8):
        write(tmp_path, f"{k:04d}_{1000 + k + 5 * (k > 5)}.png", k)
    assert numbers(tmp_path) == list(range(8))


def test_a_stack_that_is_cut_short_or_imagej_s_own_is_refused(tmp_path):
    path = write_stack(tmp_path / "stack.tif", [picture(k) for k in range(9)])
    path.write_bytes(path.read_bytes()[: path.stat().st_size * 6 // 10])
    with pytest.raises(VideoError, match=r"breaks off after \d; the file is cut short"):
        open_view(View(name="v", video="stack.tif"), tmp_path)
    said = {270: "ImageJ=1.53\nimages=9000\nslices=9000\n"}
    write_stack(path, [picture(0)], tiffinfo=said)
    with pytest.raises(VideoError, match="ImageJ wrote 9000 pictures"):
        open_view(View(name="v", video="stack.tif"), tmp_path)


def test_stacks_in_a_folder_are_refused_and_thumbnails_are_none(tmp_path):
    for k in range(2):
        write_stack(tmp_path / f"a{k}.tif", [picture(k), picture(k + 1)])
    assert "a0.tif holds 2 pictures; expected one a file" in refusal(tmp_path)
    for k in range(2):
        write_stack(tmp_path / f"a{k}.tif", [picture(k), picture(k)[::4, ::4]])
    assert numbers(tmp_path) == [0, 1]


def test_brackets_in_the_name_of_a_folder_are_no_pattern(tmp_path):
    (tmp_path / "mouse [1]").mkdir()
    for k in range(3):
        write(tmp_path / "mouse [1]", f"{k}.png", k)
    assert numbers(tmp_path / "mouse [1]" / "?.png") == [0, 1, 2]
