"""Films side by side in the benchmark of rendered scenes."""

import argparse

import cv2
import numpy as np
import pandas as pd
import pytest


def test_films_side_by_side():
    from whole_accuracy import side_by_side

    rows = [
        ("synthetic-normal-31", 819, 1, 100, False),
        ("synthetic-normal-32", 819, 2, 300, False),  # 3 of 400
        ("synthetic-normal-31-h264-crf23", 820, 30, 100, False),
        ("synthetic-normal-32-h264-crf23", 820, 300, 300, True),
        ("synthetic-hard-31", 819, 5, 100, False),
    ]
    columns = ["trial", "width", "n_wrong", "n_labels", "refused"]
    assert side_by_side(pd.DataFrame(rows, columns=columns)).split("\n") == [
        "| scenes | px wide | colour | h264-crf23 |",
        "|---|---|---|---|",
        "| normal | 820 | 7.5 | 825.0 (1 of 2 refused) |",
        "| hard | 820 | 50.0 |  |",
    ]


def test_verdicts_stand_beside_what_is_wrong():
    from whole_accuracy import side_by_side

    rows = [
        ("synthetic-normal-31", 819, 1, 100, False, "good"),
        ("synthetic-normal-32", 819, 2, 300, False, "look"),
        ("synthetic-normal-33", 819, 0, 100, False, "good"),
    ]
    columns = ["trial", "width", "n_wrong", "n_labels", "refused", "verdict"]
    table = side_by_side(pd.DataFrame(rows, columns=columns))
    assert table.split("\n")[-1] == "| normal | 820 | 6.0 (2 good, 1 look) |"


@pytest.mark.slow
def test_each_scene_is_rendered_as_each_film_and_kept(tmp_path):
    from whole_accuracy import add_scene_arguments, refused, trials

    from pawnb.core.video import open_views
    from pawnb.trial import load_trial

    parser = argparse.ArgumentParser()
    add_scene_arguments(parser)
    words = ["--films", "colour", "grey,h264-crf23", "--frames", "2", "--scales", "0.1"]
    asked = parser.parse_args([*words, "--difficulty", "easy", "--seeds", "3"])
    paths = list(trials(asked, tmp_path))
    names = [load_trial(path).name for path in paths]
    assert names == ["synthetic-easy-03", "synthetic-easy-03-grey-h264-crf23"]
    with open_views(load_trial(paths[0])) as colour, open_views(load_trial(paths[1])) as film:
        assert colour.n_frames == film.n_frames == 2
        for name in colour.names:
            grey = film.readers[name].read(1)
            # H.264 has even sizes only, and is a few levels off
            h, w = colour.readers[name].height, colour.readers[name].width
            assert np.ptp(grey.astype(int), axis=2).max() <= 2
            was = cv2.cvtColor(colour.readers[name].read(1), cv2.COLOR_RGB2GRAY)
            assert np.abs(grey[:h, :w, 0].astype(float) - was).mean() < 5
    times = [path.stat().st_mtime_ns for path in paths]
    assert [path.stat().st_mtime_ns for path in trials(asked, tmp_path)] == times

    truth = pd.read_csv(paths[0].parent / "truth" / "tracks.csv")
    right = truth["view"].isin(["cam1", "cam2"])  # which follow the right paws only
    seen = truth["visible"].eq(1) & (right == truth["point"].str.endswith("R"))
    row = refused(load_trial(paths[0]))
    assert row["n_wrong"] == row["n_labels"] == seen.sum()
