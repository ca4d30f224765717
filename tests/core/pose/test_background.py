"""Presence and background on painted recordings whose empty frames are known."""

import cv2
import numpy as np
import pytest
from painted_spider import PaintedReader, paint, panel
from scipy import stats

from pawnb.core.pose.background import (
    QUANTISATION_SD,
    find_background,
    mean_background,
    median_background,
)
from pawnb.core.pose.poses import natural_pose
from pawnb.core.pose.presence import find_animal_frames, prediction_limit
from pawnb.core.pose.species_file import load_species
from pawnb.errors import InputError, InputWarning
from pawnb.trial import View

SIZE = (240, 160)


def recording(where, *, seed=0, noise=2.0):
    """Paint a recording: place of the animal in each frame, None for an empty frame."""
    rng = np.random.default_rng(seed)
    animal = load_species("dolomedes")
    pictures = []
    for at in where:
        pose = None if at is None else natural_pose(animal, xy=at, scale=0.9)
        pictures.append(paint(animal, pose, SIZE, rng, noise=noise))
    return PaintedReader(pictures)


def run(n, start=20.0, step=8.0):
    return [(start + step * i, 80.0) for i in range(n)]


def test_frames_with_the_animal_are_found():
    reader = recording([None] * 8 + run(12, start=-10, step=12) + [None] * 6)
    presence = find_animal_frames(reader)
    assert (presence.first, presence.last) == (8, 19)
    assert not presence.has_animal[:5].any()
    empty = set(presence.empty_frames(guard=2))
    assert empty <= {0, 1, 2, 3, 4, 5, 22, 23, 24, 25}
    assert empty >= {0, 1, 2, 3, 4}


def test_difference_is_the_sum_over_pixels():
    pictures = [np.full((4, 5), value, np.uint8) for value in (10, 11, 9, 10, 11, 40)]
    presence = find_animal_frames(PaintedReader(pictures))
    np.testing.assert_allclose(presence.difference, [0, 20, 20, 0, 20, 600])
    # by hand: differences 20, 20, 0, 20 of the four frames after the first
    assert presence.known_mean == 15
    limit = 15 + stats.t.ppf(0.99, 3) * 10 * np.sqrt(1 + 1 / 4)
    assert presence.threshold == pytest.approx(limit)
    assert list(presence.has_animal) == [False] * 5 + [True]


@pytest.mark.slow
def test_prediction_limit_holds_for_empty_frames():
    # erratum 12: a confidence limit of the mean would flag a tenth and more of empty frames
    rng = np.random.default_rng(3)
    flagged = np.mean(
        [v[-1] > prediction_limit(v[:-1], confidence=0.99) for v in rng.normal(5, 2, (20000, 9))]
    )
    assert flagged == pytest.approx(0.01, abs=0.002)


@pytest.mark.parametrize(
    ("kwargs", "words"),
    [
        ({"known": (0, 2)}, "three or more"),
        ({"known": (8, 14)}, "empty frames 8 to 13: the recording has frames 0 to 9;"),
        ({"confidence": 99.0}, "between 0.5 and 1"),
    ],
)
def test_bad_questions_are_refused(kwargs, words):
    with pytest.raises(InputError, match=words):
        find_animal_frames(recording([None] * 10), **kwargs)


def test_mean_and_sd_of_empty_frames():
    rng = np.random.default_rng(1)
    pictures = rng.integers(90, 110, (6, 7, 9)).astype(np.uint8)
    background = mean_background(PaintedReader(pictures), [0, 1, 2, 4, 5])
    used = pictures[[0, 1, 2, 4, 5]].astype(float)
    np.testing.assert_allclose(background.mean, used.mean(axis=0), atol=1e-4)
    np.testing.assert_allclose(
        background.sd, np.maximum(used.std(axis=0, ddof=1), QUANTISATION_SD), atol=1e-4
    )
    assert background.n_frames == 5
    assert background.source == "frames 0 to 2, 4 to 5"


def test_median_of_a_run_is_the_empty_scene():
    reader = recording(run(25, start=10, step=9))
    background = median_background(reader)
    assert np.abs(background.mean - panel(SIZE)).mean() < 1.0
    assert np.median(background.sd) == pytest.approx(2.0, rel=0.25)


@pytest.mark.parametrize("inverted", [False, True])
def test_an_animal_that_is_nearly_always_there_is_told_from_the_empty_scene(inverted):
    # it walks a third of its length: parts of the picture are covered in 80 % of the frames
    reader = recording(run(40, start=90.0, step=0.6))
    empty = mean_background(recording([None] * 12), range(12)).mean
    if inverted:  # a light animal on dark ground
        reader = PaintedReader([255 - picture for picture in reader.pictures])
        empty = 255.0 - empty
    found = median_background(reader)
    pictures = np.stack(reader.pictures).astype(float)
    covered = (np.abs(pictures - empty) > 25).mean(axis=0)
    known = covered < 0.8
    assert (covered[known] > 0.6).sum() > 50
    assert np.abs(found.mean - empty)[known].max() < 10
    # nor is it any worse where the animal never was
    assert np.abs(found.mean - empty)[covered == 0].mean() < 1
    assert found.sd[known].max() < 15


def test_background_comes_from_what_the_view_names(tmp_path):
    reader = recording([None] * 10 + run(20))
    named = View(name="top", video="x.avi", background_frames=(0, 8))
    assert find_background(reader, named, folder=tmp_path).source == "frames 0 to 7"
    found = find_background(reader, View(name="top", video="x.avi"), folder=tmp_path)
    # the recording's ten empty frames, two left out before the animal comes
    assert found.source == "frames 0 to 7"
    wrong = View(name="top", video="x.avi", background_frames=(25, 40))
    with pytest.raises(InputError, match="frames 0 to 29; name frames within it"):
        find_background(reader, wrong, folder=tmp_path)


def test_background_picture_keeps_its_values_and_takes_its_noise_from_the_recording(tmp_path):
    reader = recording([None] * 10 + run(20), noise=3.0)
    reader.lens = None
    cv2.imwrite(str(tmp_path / "empty.png"), np.round(panel(SIZE)).astype(np.uint8))
    view = View(name="top", video="x.avi", background="empty.png")
    background = find_background(reader, view, folder=tmp_path)
    np.testing.assert_array_equal(background.mean, np.round(panel(SIZE)))
    assert np.median(background.sd) == pytest.approx(3.0, rel=0.2)
    assert background.doubt == ""
    cv2.imwrite(str(tmp_path / "empty.png"), np.zeros((100, 240), np.uint8))
    with pytest.raises(InputError, match="240 x 100 px, but the view is 240 x 160"):
        find_background(reader, view, folder=tmp_path)


def test_picture_of_the_whole_camera_is_cropped_and_mirrored_as_the_view(tmp_path):
    whole = np.random.default_rng(0).integers(0, 255, (200, 300)).astype(np.uint8)
    cv2.imwrite(str(tmp_path / "empty.png"), whole)
    reader = recording([None] * 3)
    reader.lens = None
    view = View(name="top", video="x.avi", background="empty.png", crop=(20, 10, 260, 170),
                mirror=True)  # fmt: skip
    background = find_background(reader, view, folder=tmp_path)
    np.testing.assert_array_equal(background.mean, whole[10:170, 20:260][:, ::-1])


def test_no_empty_frames_is_said_and_the_median_offered(tmp_path):
    reader = recording(run(25, start=10, step=9))
    with pytest.warns(InputWarning, match="no empty frames.*median of 25 frames"):
        background = find_background(reader, View(name="top", video="x"), folder=tmp_path)
    assert np.abs(background.mean - panel(SIZE)).mean() < 1.0
    assert "name empty frames (background_frames)" in background.doubt


def test_a_recording_in_which_nothing_moves_is_said(tmp_path):
    # the known frames' differences are equal, so that no other frame can be different by chance
    reader = PaintedReader([np.full((30, 40), 90, np.uint8)] * 12)
    with pytest.warns(InputWarning, match="nothing moves"):
        background = find_background(reader, View(name="top", video="x"), folder=tmp_path)
    assert background.n_frames == 12
    assert background.doubt.startswith("nothing moves")


def test_an_animal_that_comes_and_stays_does_not_make_the_empty_frames_doubtful(tmp_path):
    # the median shows the animal here, for it stays most of the time
    reader = recording([None] * 10 + [(120.0, 80.0)] * 30)
    background = find_background(reader, View(name="top", video="x"), folder=tmp_path)
    assert background.source == "frames 0 to 7"


def test_how_far_the_search_for_empty_frames_is_counts_the_frames_read(tmp_path):
    reader = recording([None] * 10 + run(20))
    view, told, read = View(name="top", video="x.avi"), [], []
    frame = reader.frame
    reader.frame = lambda index: read.append(index) or frame(index)
    found = find_background(reader, view, folder=tmp_path, progress=lambda *at: told.append(at))
    assert [done for done, _ in told] == list(range(1, len(read) + 1))
    assert {30 + 5 + 30 + 30} == {total for _, total in told}  # sampled, known, all, empty
    assert len(read) > 60
    alone = find_background(reader, view, folder=tmp_path)
    np.testing.assert_array_equal(found.mean, alone.mean)
    assert (found.source, found.doubt) == (alone.source, alone.doubt)
    cv2.imwrite(str(tmp_path / "empty.png"), np.round(panel(SIZE)).astype(np.uint8))
    reader.lens, told = None, []
    for named in ({"background": "empty.png"}, {"background_frames": (0, 8)}):
        view = View(name="top", video="x.avi", **named)
        find_background(reader, view, folder=tmp_path, progress=lambda *at: told.append(at))
        assert told[-1] == (told[-1][1], told[-1][1])  # all of what is read here


def test_an_animal_that_never_moves_is_said(tmp_path):
    reader = recording([(120.0, 80.0)] * 30)
    with pytest.warns(InputWarning, match="nothing moves in frames 0 to 29"):
        find_background(reader, View(name="top", video="x"), folder=tmp_path)
