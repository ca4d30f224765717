"""What counts as right in the benchmark of real clips, and its peers."""

import math

import cv2
import numpy as np
import pandas as pd
import pytest


def table(*rows):
    return pd.DataFrame(rows, columns=["frame", "view", "point", "u", "v"])


def test_clicked_frames_are_spread_evenly():
    from real_clip_marks import click_frames

    marks = table(*[(frame, "side", "FL", 0.0, 0.0) for frame in range(0, 100, 10)])
    # marks at 0, 10 ... 90: of two clicks each has five marks about it at best, its own in the
    # middle of them: (20 + 10 + 0 + 10 + 20) twice
    assert click_frames(marks, 2) == (20, 70)


def test_a_frame_in_which_all_points_are_marked_is_clicked_rather():
    from real_clip_marks import click_frames

    marks = table(
        *[(frame, "side", "FL", 0.0, 0.0) for frame in range(5)], (4, "side", "HL", 0.0, 0.0)
    )
    assert click_frames(marks, 1) == (4,)


def test_clicks_of_one_frame_are_those_of_the_clip(tmp_path):
    from real_clip_marks import Clip

    marks = table(*[(frame, "side", "FL", 10.0 * frame, 0.0) for frame in range(4)])
    marks.assign(visible=[1, 1, 1, 0]).to_csv(tmp_path / "marks.csv", index=False)
    table((3, "side", "FL", 31.0, 1.0)).to_csv(tmp_path / "start.csv", index=False)
    clip = Clip(tmp_path)
    assert clip.clicks(1)[["frame", "u"]].to_numpy().tolist() == [[3, 31.0]]
    assert clip.clicks(2)["frame"].tolist() == [0, 1]
    assert clip.clicks(3) is None  # three frames have visible marks: none would be left to judge


@pytest.mark.parametrize(("meta", "recording"), [('recording = "film"\n', "film"), ("", "clip_a")])
def test_a_clip_is_a_recording_of_its_own_unless_it_says_of_which_film_it_is(
    tmp_path, meta, recording
):
    from real_clip_marks import Clip

    folder = tmp_path / "clip_a"
    folder.mkdir()
    (folder / "meta.toml").write_text(meta + "threshold_px = 5.0\n")
    assert Clip(folder).recording == recording
    assert Clip(folder).threshold_px == 5.0


def test_marks_that_count_and_what_was_taken_for_what():
    from real_clip_marks import compare

    marks = table(
        (0, "side", "FL", 0.0, 0.0),  # clicked
        (5, "side", "FL", 10.0, 0.0),
        (5, "side", "FR", 50.0, 0.0),
        (5, "side", "HL", 90.0, 0.0),  # never clicked
        (6, "side", "FL", 10.0, 0.0),
    )
    clicks = table((0, "side", "FL", 0.0, 0.0), (0, "side", "FR", 40.0, 0.0))
    tracks = table((5, "side", "FL", 85.0, 0.0), (5, "side", "FR", 53.0, 4.0))
    tracks = tracks.assign(confidence=[0.9, 0.1], origin="measured")
    found = compare(marks, clicks, tracks, 5.0)
    assert found[["frame", "point", "ok", "took", "said"]].to_numpy().tolist() == [
        [5, "FL", False, "HL", False],
        [5, "FR", True, "", True],  # 3 and 4 px away: 5; confidence below 0.2
        [6, "FL", False, "", True],  # without a track
    ]
    assert not compare(marks, clicks, None, 5.0)["ok"].any()


def test_first_suspects_point_to_marks_near_them():
    from real_clip_marks import in_suspects

    found = table(*[(frame, "side", "FL", 0.0, 0.0) for frame in (3, 10, 14, 40)])
    rows = [(13, "side", "FL"), (41, "side", "FR"), (0, "", "")]
    rows += [(40, "side", "FL")] * 20  # beyond the first three, which are more than 5 % of 23
    suspects = pd.DataFrame(rows, columns=["frame", "view", "point"])
    assert in_suspects(found, suspects).tolist() == [True, True, True, False]


def test_auroc():
    from real_clip_marks import auroc

    # pairs of wrong and right: (3, 1) (3, 2) (2, 1) more, (2, 2) a tie: 3.5 of 4
    doubt, wrong = np.array([3.0, 2.0, 2.0, 1.0]), np.array([True, True, False, False])
    assert auroc(doubt, wrong) == pytest.approx(3.5 / 4)
    assert math.isnan(auroc(doubt, np.ones(4, bool)))


def moving_picture(n, px_a_frame):
    """Return noise that moves to the right, and nothing else."""
    noise = np.random.default_rng(0).uniform(0, 255, (80, 200)).astype(np.float32)
    wide = cv2.GaussianBlur(noise, (0, 0), 2.0)
    wide = np.clip(128 + 6 * (wide - wide.mean()), 0, 255).astype(np.uint8)
    return {k: np.roll(wide, px_a_frame * k, axis=1) for k in range(n)}


def test_lucas_kanade_both_ways_and_the_nearer_click_decides():
    from real_clip_peers import track_view

    pictures = moving_picture(11, 2)
    # the second click is 20 px beside: its half follows what is there
    clicks = table((2, "side", "FL", 60.0, 40.0), (8, "side", "FL", 92.0, 40.0))
    found = track_view("lk", pictures, clicks, px=8.0).set_index("frame")
    assert found.index.tolist() == list(range(11))
    truth = np.array([60 + 2 * (k - 2) + (20 if k > 5 else 0) for k in range(11)])
    np.testing.assert_allclose(found["u"], truth, atol=0.3)
    np.testing.assert_allclose(found["v"], 40.0, atol=0.3)


def test_peers_see_pictures_as_straight_as_pawnb_does(tmp_path):
    """A straight edge 30 px left of the middle, bent by k1 = -0.3 as OpenCV's model has it."""
    from real_clip_peers import lens_of, read_pictures

    (tmp_path / "cameras.toml").write_text(
        '[cam_0]\nname = "side"\nmatrix = [[100.0, 0, 80.0], [0, 100.0, 60.0], [0, 0, 1.0]]\n'
        "distortions = [-0.3, 0.0, 0.0, 0.0, 0.0]\n"
    )
    trial = {"calibration": {"anipose": "cameras.toml"}}
    lens = lens_of(tmp_path, trial, "side")
    assert lens_of(tmp_path, {}, "side") is None
    y, x = (np.indices((120, 160)) - np.array([60, 80])[:, None, None]) / 100.0
    # the radius of the filmed picture is r (1 - 0.3 r²) of the straight one: undone by iteration
    straight = x.copy()
    for _ in range(100):
        straight = x / (1 - 0.3 * straight**2 * (1 + (y / np.where(x == 0, 1e-9, x)) ** 2))
    filmed = np.where(straight < -0.3, 0, 255).astype(np.uint8)
    writer = cv2.VideoWriter(
        str(tmp_path / "side.avi"), cv2.VideoWriter.fourcc(*"MJPG"), 25, (160, 120)
    )
    writer.write(cv2.cvtColor(filmed, cv2.COLOR_GRAY2BGR))
    writer.release()

    def edge(pictures):
        return (pictures[0][20:100] < 128).sum(axis=1)

    bent = edge(read_pictures(tmp_path / "side.avi", None, None, grey=True))
    found = edge(read_pictures(tmp_path / "side.avi", None, None, grey=True, lens=lens))
    assert np.ptp(bent) >= 2
    assert np.abs(found - 50).max() <= 1


def test_a_trial_with_other_clicks_finds_its_files(tmp_path):
    from real_clip_marks import Clip
    from real_clips import write_trial

    from pawnb.trial import load_trial

    home, made = tmp_path / "clip", tmp_path / "made"
    home.mkdir(), made.mkdir()
    (home / "side.mp4").write_bytes(b"video")
    (home / "trial.toml").write_text(
        '[trial]\nkind = "paws"\nname = "x"\nfps = 24.0\n[animal]\nid = "a"\n'
        '[[views]]\nname = "side"\nvideo = "side.mp4"\npoints = ["FL"]\n'
    )
    clicks = table((1, "side", "FL", 2.0, 3.0))
    trial = load_trial(write_trial(Clip(home), clicks, made))
    assert (trial.folder / trial.views[0].video).read_bytes() == b"video"
    assert pd.read_csv(trial.folder / trial.start_points).equals(clicks)


def test_table_counts_a_refusal_as_nothing_right():
    from real_clips import Run, main_table

    ok = pd.DataFrame({"ok": [True, False]})
    none = pd.DataFrame({"ok": [False, False]})
    runs = [Run("a", 1, "pawnb", ok), Run("b", 1, "pawnb", none, refused="no"),
            Run("fly_ball_left", 1, "pawnb", ok)]  # fmt: skip
    shown = main_table(runs, [1], ["pawnb"]).set_index("clip")["1: pawnb"]
    assert shown.to_dict() == {
        "a": "50", "b": "refused", "fly_ball_left": "50", "mean": "33",
        "mean without fly_ball_left": "25",
    }  # fmt: skip
