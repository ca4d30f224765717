"""Films that are cut are told from those that are not; where they are cut is known."""

from __future__ import annotations

import numpy as np
import pytest

from pawnb.core.video import open_views
from pawnb.core.video.doubts.cuts import (
    WatchedViews,
    cuts_in_words,
    find_leaps,
    tell_cuts,
    with_cuts,
)
from pawnb.core.video.file import VideoFile
from pawnb.schema import make_tracks
from pawnb.synthetic.colour_video import H264VideoWriter
from pawnb.trial import Animal, Trial, View


def test_a_change_twice_as_large_as_any_about_it_is_a_leap():
    changes = np.array([3.0, 4.0] * 20)
    assert find_leaps(changes) == []
    changes[17] = 9.0
    assert find_leaps(changes) == [17]
    # a flash leaps twice, and what begins to move goes on moving
    changes[18] = 8.0
    assert find_leaps(changes) == []
    assert find_leaps(np.array([1.0] * 20 + [8.0] * 20)) == []


def test_noise_and_the_ends_of_a_film_tell_nothing():
    still = np.full(40, 0.02)
    still[20] = 0.9  # a key picture of a film in which nothing moves
    assert find_leaps(still) == []
    limb = np.full(40, 0.5)
    limb[20] = 1.2  # a limb in a large picture that is elsewhere at once
    assert find_leaps(limb) == []
    ends = np.full(40, 2.0)
    ends[[2, 37]] = 30.0
    assert find_leaps(ends) == []
    assert find_leaps(np.array([])) == []


def trial(tmp_path, video, n, **more):
    view = View(name="side", video=video.name, points=("nose",), **more)
    return Trial(
        kind="paws", name="t", fps=24.0, animal=Animal(id="m"), folder=tmp_path, views=(view,),
        frames=(0, n),
    )  # fmt: skip


def read_all(own, views, **options):
    watched = WatchedViews(views)
    assert [i for i, _ in watched.frames(0, views.n_frames, **options)] == list(
        range(views.n_frames)
    )
    return watched.find_cuts(own)


@pytest.mark.slow
@pytest.mark.parametrize("clip", ["horse_walk/side.mp4", "mouse_openfield_top/top.mp4"])
def test_a_real_film_of_which_frames_were_cut_out(real_data, tmp_path, clip):
    """Frames 40 to 69 are left out: what was frame 70 is the first after the cut."""
    film = VideoFile(real_data("real-clips") / clip)
    first = 90 if film.width < 300 else 600
    for cut in (False, True):
        chosen = [*range(first, first + 40), *range(first + (70 if cut else 40), first + 110)]
        path = tmp_path / f"{cut}.mp4"
        with H264VideoWriter(path, size=(film.width, film.height), fps=24, crf=23) as writer:
            for k in chosen:
                picture = film.grab(k).region(0, 0, film.width, film.height)
                grey = picture if picture.ndim == 3 else np.repeat(picture[..., None], 3, axis=2)
                writer.write(np.ascontiguousarray(grey))
        own = trial(tmp_path, path, len(chosen))
        with open_views(own) as views:
            cuts = read_all(own, views)
            assert cuts == ({"side": [40]} if cut else {})
            told = tell_cuts(views, cuts)
        assert len(told) == cut
        assert all("True.mp4 leaps from frame 39 to 40: the film is" in one for one in told)


def test_where_the_animal_comes_after_frames_that_are_said_to_be_empty_is_no_cut(tmp_path):
    rng = np.random.default_rng(2)
    empty = rng.integers(60, 90, (48, 64, 3)).astype(np.uint8)
    animal = empty.copy()
    animal[10:40, 10:50] = 220
    with H264VideoWriter(tmp_path / "film.mp4", size=(64, 48), fps=24, crf=18) as writer:
        for k in range(40):
            writer.write(empty if k < 20 else animal)
    for empty_frames, found in ((None, {"side": [20]}), ((0, 20), {}), ((0, 10), {"side": [20]})):
        own = trial(tmp_path, tmp_path / "film.mp4", 40, background_frames=empty_frames)
        with open_views(own) as views:
            assert read_all(own, views) == found


def test_films_are_looked_at_in_parts_and_again_but_not_where_they_are_decoded_in_part(tmp_path):
    rng = np.random.default_rng(2)
    one, other = rng.integers(0, 255, (2, 48, 64, 3)).astype(np.uint8)
    with H264VideoWriter(tmp_path / "film.mp4", size=(64, 48), fps=24, crf=18) as writer:
        for k in range(40):
            writer.write(one if k < 20 else other)
    own = trial(tmp_path, tmp_path / "film.mp4", 40)
    with open_views(own) as views:
        assert read_all(own, views, partly=True) == {}
        watched = WatchedViews(views)
        for begin, end in ((0, 18), (14, 40), (0, 40)):
            for _ in watched.frames(begin, end):
                pass
        assert watched.find_cuts(own) == {"side": [20]}


def test_tracks_say_it_only_of_a_cut_that_they_cross():
    tracks = make_tracks(range(20, 60), ["a"], fps=50.0, views=["side"], space=("x", "y"))
    words = ["the film of view side is cut, or leaps, from frame 39 to 40"]
    assert cuts_in_words(with_cuts(tracks, {"side": [40, 80]})) == words
    assert cuts_in_words(with_cuts(tracks, {"side": [20]})) == []
    assert cuts_in_words(with_cuts(tracks, {})) == []
    in_space = make_tracks(range(20, 60), ["a"], fps=50.0)
    in_space = in_space.drop_vars([name for name in ("view",) if name in in_space.coords])
    assert cuts_in_words(with_cuts(in_space, {"side": [40]})) == []
