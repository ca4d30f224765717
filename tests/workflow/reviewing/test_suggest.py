"""Which frames to click next: tracks whose chances are given, and gains worked out by hand."""

from __future__ import annotations

import json

import numpy as np
import pandas as pd
import pytest

import pawnb
from pawnb import cli
from pawnb.core.paws.offline.quality.assessment import CALIBRATED
from pawnb.errors import InputError
from pawnb.schema import ORIGIN_CODE, add_provenance, make_tracks
from pawnb.trial import Animal, Trial, View, load_trial
from pawnb.workflow.provenance.results import write_track_results
from pawnb.workflow.reviewing.suggest import gain_by_frame

N = 200
POINTS = ("FR", "HR", "FL")
H = 10.0  # at 10 frames per second 1 s are 10 frames


def unit(d):
    """What a click d frames away mends of a label."""
    return np.exp(-np.abs(d) / H)


@pytest.fixture
def trial(tmp_path):
    (tmp_path / "trial.toml").write_text(
        '[trial]\nkind = "paws"\nname = "t"\nfps = 10.0\n[animal]\nid = "m"\n'
        '[[views]]\nname = "side"\nvideo = "side.avi"\npoints = ["FR", "HR", "FL"]\n'
    )
    return load_trial(tmp_path)


def tracks_with(chance, *, views=("side",), first=0, fps=10.0, clicked=()):
    """Points 80 px apart that stand still: labels of the given chances (n, P) in every view."""
    chance = np.asarray(chance, dtype=float)
    tracks = make_tracks(
        range(first, first + len(chance)), POINTS, fps=fps, views=list(views), space=("x", "y")
    )
    for p in range(len(POINTS)):
        for name in ("image_position", "position"):
            tracks[name][..., 0, p, :] = 20.0 + 80.0 * p
            tracks[name][..., 1, p, :] = 30.0
    tracks["image_origin"][:] = ORIGIN_CODE["measured"]
    tracks["image_confidence"][:] = chance[:, None, :, None]
    tracks["image_confidence"].attrs[CALIBRATED] = 1
    start = [
        {"frame": f, "view": "side", "point": point, "u": 1.0, "v": 1.0} for f, point in clicked
    ]
    return add_provenance(tracks, step="track", method="pawnb", settings={}, inputs={}, start=start)


def sure_but(**low):
    """Chances of 1 but in the rows and with the values given for a point: ``FR=[(a, b, 0.2)]``."""
    chance = np.ones((N, len(POINTS)))
    for point, stretches in low.items():
        for begin, end, value in stretches:
            chance[begin:end, POINTS.index(point)] = value
    return chance


def test_the_middle_of_the_stretch_is_named_with_the_labels_that_it_mends(trial):
    """0.8 labels wrong in each of five frames: 0.8 (1 + 2 exp(-0.1) + 2 exp(-0.2)) = 3.56."""
    tracks = tracks_with(sure_but(HR=[(100, 105, 0.2)]))
    found = pawnb.suggest_frames(trial, tracks)
    assert list(found.columns) == ["frame", "points", "gain"]
    assert found.iloc[0].tolist() == [102, "HR", 3.6]
    assert len(found) == 1  # nothing else within reach is left
    later = pawnb.suggest_frames(trial, tracks_with(sure_but(HR=[(100, 105, 0.2)]), first=1000))
    assert later["frame"].tolist() == [1102]


def test_each_frame_is_chosen_given_the_earlier_ones(trial):
    """A long stretch of one point, from row 20 to 60, and a short one of another."""
    tracks = tracks_with(sure_but(FR=[(20, 61, 0.0)], HR=[(120, 125, 0.0)]))
    found = pawnb.suggest_frames(trial, tracks, n=4)
    s, left, free = np.arange(20, 61), np.ones(41), np.ones(41, dtype=bool)
    for row in found.query("points == 'FR'").itertuples():
        gains = np.array([(left * unit(s - t)).sum() for t in s]) * free
        assert row.gain == pytest.approx(gains.max(), abs=0.051)
        assert gains[row.frame - 20] == pytest.approx(gains.max())  # sides may be alike
        left *= 1.0 - unit(s - row.frame)
        free &= np.abs(s - row.frame) > 5
    assert found["frame"][0] == 40
    short = found.query("points == 'HR'")
    assert short["frame"].tolist() == [122]
    assert short["gain"].iloc[0] == pytest.approx(unit(np.arange(-2, 3)).sum(), abs=0.05)
    assert len(found) == 4
    assert found["gain"].is_monotonic_decreasing


def test_any_chances_give_what_the_formula_gives(trial):
    """The first frame of drawn chances, by the sums as they are written, over all frames."""
    rng = np.random.default_rng(4)
    for _ in range(5):
        chance = np.ones((N, 3))
        for p in range(3):
            for begin in rng.choice(N // 10, 6, replace=False) * 10:  # sure for 3 rows between
                chance[begin : begin + 7, p] = rng.uniform(0.0, 0.8, 7)
        clicked = rng.choice(N, 3)
        rows = [f"{f},side,{point},1,1" for f, point in zip(clicked, POINTS, strict=True)]
        (trial.folder / "start.csv").write_text("\n".join(["frame,view,point,u,v", *rows]))
        gains = np.zeros((N, 3))
        for t in range(N):
            for p in range(3):
                if chance[t, p] < 0.9:
                    own = np.arange(t // 10 * 10, t // 10 * 10 + 10)
                    known = 1.0 - unit(own - clicked[p])
                    gains[t, p] = ((1.0 - chance[own, p]) * unit(own - t) * known).sum()
        named = (gains >= 0.5) & (gains >= 0.2 * gains.max(axis=1, keepdims=True))
        gain = np.where(named, gains, 0.0).sum(axis=1)
        for frame in clicked:
            gain[max(frame - 5, 0) : frame + 6] = 0.0
        found = pawnb.suggest_frames(trial, tracks_with(chance), n=1).iloc[0]
        assert found["frame"] == gain.argmax()
        assert found["gain"] == pytest.approx(gain.max(), abs=0.051)
        order = np.argsort(-gains[gain.argmax()])
        assert found["points"] == ", ".join(POINTS[p] for p in order if named[gain.argmax(), p])


def test_the_gain_of_every_frame_is_that_of_the_suggestion(trial):
    """At the middle and at the end of a stretch of five labels, of 0.8 wrong each."""
    tracks = tracks_with(sure_but(HR=[(100, 105, 0.2)]), first=1000)
    gain = gain_by_frame(trial, tracks)
    assert gain.index.tolist() == list(range(1000, 1000 + N))
    assert gain[1102] == gain.max() == pytest.approx(0.8 * unit(np.arange(-2, 3)).sum())
    assert gain[1104] == pytest.approx(0.8 * unit(np.arange(-4, 1)).sum())
    assert gain[1099] == gain[1105] == 0.0  # outside its stretch a click mends nothing


def test_a_point_is_sure_again_after_three_frames(trial):
    """Two stretches of 5 frames, with 2 sure ones between, are one; with 3 they are two."""
    one = pawnb.suggest_frames(
        trial, tracks_with(sure_but(FR=[(50, 55, 0.5), (57, 62, 0.5)])), n=1
    ).iloc[0]
    s = np.array([*range(50, 55), *range(57, 62)])
    assert one["gain"] == pytest.approx(0.5 * max(unit(s - t).sum() for t in s), abs=0.05)
    two = pawnb.suggest_frames(trial, tracks_with(sure_but(FR=[(50, 55, 0.5), (58, 63, 0.5)])), n=2)
    assert sorted(two["frame"]) == [52, 60]
    assert two["gain"].tolist() == pytest.approx([0.5 * unit(np.arange(-2, 3)).sum()] * 2, abs=0.05)


def test_the_points_that_need_a_click_are_named_the_neediest_first(trial):
    """FL loses 0.8 of a label a frame, FR 0.5; HR, with 0.11, is not worth a click."""
    chance = sure_but(FR=[(100, 111, 0.5)], FL=[(100, 111, 0.2)], HR=[(100, 111, 0.89)])
    found = pawnb.suggest_frames(trial, tracks_with(chance), n=1).iloc[0]
    assert found["points"] == "FL, FR"
    assert found["gain"] == pytest.approx(1.3 * unit(np.arange(-5, 6)).sum(), abs=0.05)


def test_what_was_clicked_since_counts_as_mended(trial):
    """A stretch of 21 rows: without further clicks its middle, 110, with one at its begin later."""
    chance = sure_but(HR=[(100, 121, 0.0)])
    s = np.arange(100, 121)
    gains = {t: ((1.0 - unit(s - 100)) * unit(s - t)).sum() for t in s if t > 105}
    later = max(gains, key=gains.get)
    assert later > 110
    assert pawnb.suggest_frames(trial, tracks_with(chance))["frame"][0] == 110
    file = trial.folder / "start.csv"
    file.write_text("frame,view,point,u,v\n0,side,FR,1,1\n0,side,FL,1,1\n100,side,HR,1,1\n")
    assert pawnb.suggest_frames(trial, tracks_with(chance))["frame"][0] == later
    # of a click that tracks were made from their chances say what it mended
    known = tracks_with(chance, clicked=[(100, "HR")])
    assert pawnb.suggest_frames(trial, known)["frame"][0] == 110
    file.unlink()
    corrected = tracks_with(chance)
    corrected["image_origin"][100, :, 1] = ORIGIN_CODE["edited"]
    assert pawnb.suggest_frames(trial, corrected)["frame"][0] == later


def test_frames_near_clicked_ones_are_not_suggested(trial):
    """Whichever point was clicked there; of those more than 5 away the nearest to the middle."""
    chance = sure_but(HR=[(100, 121, 0.0)])
    for point in ("HR", "FL"):
        found = pawnb.suggest_frames(trial, tracks_with(chance, clicked=[(109, point)]))
        assert found["frame"][0] == 115
        assert (np.abs(found["frame"] - 109) > 5).all()


def test_labels_of_every_view_count_but_not_where_a_point_was_never_found(trial):
    chance = sure_but(HR=[(100, 105, 0.2)])
    two = tracks_with(chance, views=("side", "below"))
    assert pawnb.suggest_frames(trial, two).iloc[0].tolist() == [102, "HR", 7.1]
    two["image_origin"][:, 1] = ORIGIN_CODE["reprojected"]
    assert pawnb.suggest_frames(trial, two).iloc[0].tolist() == [102, "HR", 3.6]


def test_tracks_of_other_methods_have_chances_too(trial):
    """HR is missing in the last 15 of 50 frames, at 100 a second: a click holds for 100 frames."""
    tracks = tracks_with(np.ones((50, 3)), fps=100.0)
    tracks["image_confidence"].attrs.clear()
    tracks["image_position"][35:, ..., 1, :] = np.nan
    tracks["image_origin"][35:, :, 1] = ORIGIN_CODE["missing"]
    gain = np.exp(-np.abs(np.arange(-7, 8)) / 100.0).sum()
    found = pawnb.suggest_frames(trial, tracks)
    assert found.iloc[0].tolist() == [42, "HR", round(gain, 1)]


def test_where_all_is_sure_nothing_is_suggested(trial):
    found = pawnb.suggest_frames(trial, tracks_with(np.full((N, 3), 0.95)))
    assert found.empty
    assert list(found.columns) == ["frame", "points", "gain"]


def test_what_cannot_be_suggested_is_said(trial):
    tracks = tracks_with(np.ones((N, 3)))
    with pytest.raises(InputError, match="n is 0; expected at least one frame"):
        pawnb.suggest_frames(trial, tracks, n=0)
    with pytest.raises(InputError, match="have no image positions"):
        pawnb.suggest_frames(trial, tracks.drop_vars("image_position"))
    pose = Trial(
        kind="pose", name="s", fps=20.0, animal=Animal(id="a"), views=(View(name="top", video="a"),)
    )
    with pytest.raises(InputError, match=r"trial 's' is of kind 'pose'; frames to click are "):
        pawnb.suggest_frames(pose, tracks)
    (trial.folder / "start.csv").write_text("frame,view,point,u,v\n0,side,FR,a,1\n")
    with pytest.raises(InputError, match="column 'u' is 'a'; expected a number"):
        pawnb.suggest_frames(trial, tracks)


@pytest.mark.slow
def test_the_command_prints_a_table_or_json(trial, capsys):
    assert cli.main(["suggest", str(trial.folder)]) == 2
    assert f"no such tracks; run pawnb track {trial.folder} first." in capsys.readouterr().err
    chance = sure_but(HR=[(100, 105, 0.2)], FR=[(100, 105, 0.4)], FL=[(20, 23, 0.3)])
    write_track_results(tracks_with(chance), trial.folder / "results")
    assert cli.main(["suggest", str(trial.folder)]) == 0
    table = capsys.readouterr().out.splitlines()
    assert [line.split() for line in table] == [
        ["frame", "points", "gain"], ["102", "HR,", "FR", "6.2"], ["21", "FL", "2.0"],
    ]  # fmt: skip
    assert cli.main(["suggest", str(trial.folder), "--json", "-n", "1"]) == 0
    assert json.loads(capsys.readouterr().out) == [
        {"frame": 102, "points": ["HR", "FR"], "gain": 6.2}
    ]
    other = trial.folder / "other"
    write_track_results(tracks_with(np.ones((N, 3))), other)
    assert cli.main(["suggest", str(trial.folder), "--results", str(other)]) == 0
    assert capsys.readouterr().out.startswith("no frame: further clicks are expected to mend less")
    assert cli.main(["suggest", str(trial.folder), "--results", str(other), "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == []


def test_it_can_be_given_the_folder_of_a_trial(trial):
    tracks = tracks_with(sure_but(HR=[(100, 105, 0.2)]))
    pd.testing.assert_frame_equal(
        pawnb.suggest_frames(trial.folder, tracks), pawnb.suggest_frames(trial, tracks)
    )
