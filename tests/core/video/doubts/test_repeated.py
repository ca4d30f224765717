"""Films that stand still, or show pictures again, are told from those whose animal rests."""

from __future__ import annotations

import itertools

import av
import numpy as np
import pytest

from pawnb.core.video import open_views
from pawnb.core.video.doubts.repeated import (
    find_freezes,
    freezes_of_views,
    repeats_every,
    tell_freezes,
    tell_repeats,
)
from pawnb.core.video.file import VideoFile
from pawnb.synthetic.colour_video import H264VideoWriter, JpegVideoWriter
from pawnb.trial import Animal, Trial, View

N = 90
FROZEN = [*range(40), *[39] * 8, *range(48, N)]
TWICE = [k for k in range(N) for _ in (0, 1)]
AS_TELEVISION = [k for k in range(N) for _ in range(2 if k % 4 == 3 else 1)]


def walking(n=N, *, rests=range(0)):
    """Pictures with noise of a ground over which a patterned square goes by 2 px a frame."""
    rng = np.random.default_rng(1)
    ground = rng.integers(60, 90, (96, 240, 3)).astype(np.uint8)
    animal = rng.integers(100, 230, (24, 30, 3)).astype(np.uint8)
    at = 4.0
    for k in range(n):
        picture = ground.copy()
        picture[40:64, int(at) : int(at) + 30] = animal
        yield (picture + rng.integers(0, 25, picture.shape)).astype(np.uint8)
        at += 0.0 if k in rests else 2.0


def write(path, pictures, order, *, crf=None):
    pictures = list(pictures)
    size = pictures[0].shape[1], pictures[0].shape[0]
    writer = (
        JpegVideoWriter(path, size=size, fps=60)
        if crf is None
        else H264VideoWriter(path, size=size, fps=60, crf=crf)
    )
    with writer:
        for k in order:
            writer.write(np.ascontiguousarray(pictures[k]))
    return path


@pytest.mark.slow
@pytest.mark.parametrize("crf", [None, 23])
def test_a_film_that_stands_still_while_the_animal_goes_on_is_found(tmp_path, crf):
    path = tmp_path / ("film.avi" if crf is None else "film.mp4")
    film = VideoFile(write(path, walking(), FROZEN, crf=crf))
    assert find_freezes(film, 0, film.n_frames) == [(40, 48)]
    assert find_freezes(film, 60, film.n_frames) == []
    assert repeats_every(film, 0, film.n_frames) is None


@pytest.mark.slow
def test_two_copies_or_a_film_that_ends_in_copies_are_no_freeze_and_three_are(tmp_path):
    for copies, found in ((2, []), (3, [(40, 43)])):
        order = [*range(40), *[39] * copies, *range(40 + copies, N)]
        film = VideoFile(write(tmp_path / f"{copies}.avi", walking(), order))
        assert find_freezes(film, 0, N) == found
    film = VideoFile(write(tmp_path / "end.avi", walking(), [*range(60), *[59] * 30]))
    assert find_freezes(film, 0, N) == []


@pytest.mark.slow
def test_a_film_as_it_is_and_an_animal_that_slows_down_and_rests_are_not_told(tmp_path):
    film = VideoFile(write(tmp_path / "film.avi", walking(), range(N)))
    assert find_freezes(film, 0, N) == []
    assert repeats_every(film, 0, N) is None
    # it stops for good: nothing is shown that went on meanwhile
    film = VideoFile(write(tmp_path / "rest.avi", walking(rests=range(60, N)), range(N)))
    assert find_freezes(film, 0, N) == []


@pytest.mark.slow
@pytest.mark.parametrize(("order", "cycle"), [(TWICE, 2), (AS_TELEVISION, 5)])
def test_a_film_that_was_saved_at_another_rate_is_found(tmp_path, order, cycle):
    film = VideoFile(write(tmp_path / "film.avi", walking(), order))
    assert repeats_every(film, 0, film.n_frames) == cycle
    assert find_freezes(film, 0, film.n_frames) == []


def test_it_is_said_once_a_film_in_frames_of_the_trial(tmp_path):
    write(tmp_path / "film.avi", walking(), FROZEN)
    views = tuple(
        View(name=name, video="film.avi", points=("a",), crop=crop, offset=30)
        for name, crop in (("left", (0, 0, 120, 96)), ("right", (120, 0, 240, 96)))
    )
    trial = Trial(
        kind="paws", name="t", fps=60.0, animal=Animal(id="a"), folder=tmp_path, views=views
    )
    with open_views(trial) as opened:
        # file frames 30 to 54 are asked for; frames 0 to 24 of the file have no freeze
        freezes = freezes_of_views(trial, opened, start=0, stop=25)
        assert freezes == {"left": [(10, 18)], "right": [(10, 18)]}
        (said,) = tell_freezes(opened, freezes)
        assert "stands still in frames 10 to 17: " in said
        assert tell_repeats(trial, opened, start=0, stop=60) == []
        many = {"left": [(10, 18), (20, 24), (30, 40), (50, 53), (55, 59)]}
        (said,) = tell_freezes(opened, many)
        assert "in frames 10 to 17, 20 to 23, 30 to 39 and 2 more times: " in said


@pytest.mark.slow
def test_a_film_shown_twice_says_how_many_pictures_are_new(tmp_path):
    write(tmp_path / "film.avi", walking(), TWICE)
    view = View(name="side", video="film.avi", points=("a",))
    trial = Trial(
        kind="paws", name="t", fps=60.0, animal=Animal(id="a"), folder=tmp_path, views=(view,)
    )
    with open_views(trial) as opened:
        (said,) = tell_repeats(trial, opened, start=0, stop=2 * N)
    assert "every picture twice" in said
    assert "of 60 pictures a second only 30 are new" in said


@pytest.mark.slow
def test_a_film_with_every_fifth_picture_again_behind_a_part_without_is_told(tmp_path):
    # 24 pictures a second made 30 have four of five new: 48 of 60; the trial begins behind 60
    write(tmp_path / "film.avi", walking(), [*range(60), *reversed(AS_TELEVISION)])
    view = View(name="side", video="film.avi", points=("a",), offset=60)
    trial = Trial(
        kind="paws", name="t", fps=60.0, animal=Animal(id="a"), folder=tmp_path, views=(view,)
    )
    with open_views(trial) as opened:
        (said,) = tell_repeats(trial, opened, start=0, stop=100)
    assert "one picture of every 5 again" in said
    assert "of 60 pictures a second only 48 are new" in said


@pytest.mark.slow
def test_real_films_as_they_are_neither_stand_still_nor_repeat(real_data):
    films = sorted(real_data("real-clips").glob("*/*.mp4"))
    assert films
    for path in films:
        film = VideoFile(path)
        stop = min(film.n_frames, 400)
        assert (find_freezes(film, 0, stop), repeats_every(film, 0, stop)) == ([], None), path


@pytest.mark.slow
def test_a_real_film_that_was_doubled_or_stood_still_is_found(tmp_path, real_data):
    path = real_data("real-clips/horse_walk/side.mp4")
    with av.open(str(path)) as container:
        frames = itertools.islice(container.decode(video=0), 85, 85 + N)
        pictures = [frame.to_ndarray(format="rgb24") for frame in frames]
    film = VideoFile(write(tmp_path / "frozen.mp4", pictures, FROZEN, crf=28))
    assert find_freezes(film, 0, N) == [(40, 48)]
    film = VideoFile(write(tmp_path / "twice.mp4", pictures, TWICE, crf=28))
    assert repeats_every(film, 0, 2 * N) == 2
