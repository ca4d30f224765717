"""``pawnb check`` finds what is missing or wrong before any work is done."""

from __future__ import annotations

import json
import os
import re
import shutil

import cv2
import numpy as np
import pandas as pd
import pytest

from pawnb.core.video import open_views
from pawnb.errors import InputError
from pawnb.schema import add_provenance, make_tracks
from pawnb.trial import load_trial
from pawnb.widgets import ClickInitialiser
from pawnb.workflow.checking.check import check_trial
from pawnb.workflow.provenance.results import write_track_results


@pytest.mark.slow
def test_a_whole_trial_has_no_faults(rendered_trial):
    report = check_trial(rendered_trial)
    assert report.faults == []
    assert report.doubts == []
    text = report.text()
    for words in (
        "kind paws, animal synthetic-01, 250 frames per second",
        "belt speed 300 mm/s",
        "view cam4: 40 frames of 410 x 140 px, colour",
        "DLT of 4 views, unit mm",
        "start: 8 clicks on FR, HR, FL, HL in frame 0",
    ):
        assert f"ok    {words}" in text


def change(folder, file, old, new):
    path = folder / file
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))


@pytest.mark.parametrize(
    ("file", "old", "new", "fault"),
    [
        ("trial.toml", 'video = "cam2.avi"', 'video = "cam9.avi"', "cam9.avi"),
        ("trial.toml", 'dlt = "DLTcoefs.csv"', 'dlt = "DLT.csv"', "DLT.csv"),
        ("trial.toml", "[start]", "[tracking]\nwindw = 1\n[start]", "unknown name 'windw'"),
        ("trial.toml", "fps = 250.0", "fps = 250.0\nframes = [0, 50]", "has no frame 49"),
        ("start.csv", "frame,view,point,u,v", "frame,view,paw,u,v", "column 'point' is missing"),
        ("start.csv", "0,cam1,FR,", "0,cam1,FR,9", "outside the picture"),
    ],
)
def test_each_fault_is_found(small_trial, file, old, new, fault):
    change(small_trial, file, old, new)
    report = check_trial(small_trial)
    assert len(report.faults) == 1
    assert fault in report.faults[0]
    assert "MEND" in report.text()
    assert report.verdict().startswith("trial 'synthetic-normal-01' cannot be worked on yet: ")


def test_what_a_crop_keeps_is_said(small_trial):
    """x, y, width and height are four numbers, too: the size shows what was understood."""
    change(
        small_trial,
        "trial.toml",
        'video = "cam1.avi"',
        'video = "cam1.avi"\ncrop = [10, 5, 300, 100]',
    )
    assert (
        "view cam1: 40 frames of 290 x 95 px (crop: u 10 to 299 and v 5 to 99 of 410 x 140 px), "
        "colour"
    ) in check_trial(small_trial).found
    change(small_trial, "trial.toml", "[10, 5, 300, 100]", "[310, 5, 100, 120]")
    with pytest.raises(
        InputError, match=r"if 100 and 120 are its width and height, write \[310, 5, 410, 125\]"
    ):
        check_trial(small_trial)


@pytest.mark.slow
def test_a_grey_film_that_is_stored_in_colour_is_said_to_be_grey(small_trial):
    grey = np.tile(np.linspace(0, 255, 410).astype(np.uint8), (140, 1))
    code = cv2.VideoWriter.fourcc(*"MJPG")
    film = cv2.VideoWriter(str(small_trial / "cam1.avi"), code, 100.0, (410, 140))
    for _ in range(40):
        film.write(cv2.merge([grey] * 3))
    film.release()
    found = check_trial(small_trial).found
    assert "view cam1: 40 frames of 410 x 140 px, grey, stored in colour" in found
    assert "view cam2: 40 frames of 410 x 140 px, colour" in found


def test_a_video_that_is_cut_short_is_doubted(small_trial):
    video = small_trial / "cam3.avi"
    video.write_bytes(video.read_bytes()[: video.stat().st_size // 2])
    report = check_trial(small_trial)
    assert any(f"{video} is cut short: it promises 40 frames" in doubt for doubt in report.doubts)


@pytest.mark.parametrize(
    ("file", "word"),
    [
        ("cam2.avi", "video file"),
        ("start.csv", "frame, view, point, u, v"),
        ("DLTcoefs.csv", "DLT"),
    ],
)
@pytest.mark.parametrize("kind", ["pipe", "device", "folder"])
def test_what_is_no_file_is_a_fault_at_once(small_trial, file, word, kind):
    """A named pipe would be waited for, a device be read, for ever."""
    path = small_trial / file
    path.unlink()
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "device":
        path.symlink_to("/dev/zero")
    else:
        path.mkdir()
    (fault, *_) = check_trial(small_trial).faults
    assert file in fault
    assert kind in fault or (kind, file) == ("folder", "cam2.avi")
    if kind != "folder":
        assert word in fault


@pytest.mark.slow
def test_a_click_on_another_point_is_doubted(small_trial):
    lines = (small_trial / "start.csv").read_text().splitlines()
    row = next(k for k, line in enumerate(lines) if line.startswith("0,cam1,FR"))
    frame, view, point, u, v = lines[row].split(",")
    lines[row] = ",".join([frame, view, point, u, str(float(v) - 60)])
    (small_trial / "start.csv").write_text("\n".join(lines) + "\n")
    (doubt,) = check_trial(small_trial).doubts
    assert doubt.startswith("start clicks of FR in frame 0 disagree between the views by ")


@pytest.mark.slow
def test_coefficients_that_show_one_view_mirrored_are_doubted(small_trial):
    coefs = np.loadtxt(small_trial / "DLTcoefs.csv", delimiter=",")
    below = np.append(coefs[8:11, 2], 1.0)
    coefs[0:4, 2] = 409.0 * below - coefs[0:4, 2]  # u counted from the right, 410 px wide
    np.savetxt(small_trial / "DLTcoefs.csv", coefs, delimiter=",")
    doubts = check_trial(small_trial).doubts
    assert any("mirrored in cam3 and as it is in cam1, cam2, cam4" in one for one in doubts)


@pytest.mark.slow
def test_coefficients_in_the_order_of_other_views_are_doubted(small_trial):
    """Cameras on both sides, counted from the other end: clicks agree and all is turned round."""
    coefs = np.loadtxt(small_trial / "DLTcoefs.csv", delimiter=",")
    np.savetxt(small_trial / "DLTcoefs.csv", coefs[:, ::-1], delimiter=",")
    doubts = check_trial(small_trial).doubts
    (said,) = [one for one in doubts if one.startswith("in frame 0 the animal is turned round")]
    assert said.endswith("or the columns of the calibration are in another order than the views")


@pytest.mark.slow
def test_a_unit_in_which_no_animal_is_that_large_is_doubted(small_trial):
    coefs = np.loadtxt(small_trial / "DLTcoefs.csv", delimiter=",")
    coefs[[0, 1, 2, 4, 5, 6, 8, 9, 10]] *= 1000.0  # as a program writes that counts in metres
    np.savetxt(small_trial / "DLTcoefs.csv", coefs, delimiter=",")
    (doubt,) = check_trial(small_trial).doubts
    assert re.match(r"the clicked points lie 0\.0\d+ mm apart: \[calibration\] unit is not", doubt)
    change(small_trial, "trial.toml", 'unit = "mm"', 'unit = "m"')
    assert check_trial(small_trial).doubts == []


def test_the_scale_of_a_single_view_is_said_and_doubted(small_trial, tmp_path):
    start = (small_trial / "start.csv").read_text().splitlines()
    own = [line for line in start if line.startswith(("frame", "0,cam1"))]
    (tmp_path / "start.csv").write_text("\n".join(own) + "\n")
    (tmp_path / "trial.toml").write_text(
        '[trial]\nkind = "paws"\nname = "one"\nfps = 250.0\n[start]\npoints = "start.csv"\n'
        f'[[views]]\nname = "cam1"\nvideo = "{(small_trial / "cam1.avi").as_posix()}"\n'
        'points = ["FR", "HR"]\n[calibration]\npx_per_unit = 0.82\nunit = "mm"\n'
    )
    report = check_trial(tmp_path)
    assert "scale: 0.82 px per mm, so that view cam1 is 500 x 171 mm large" in report.found
    assert not any("px" in doubt for doubt in report.doubts)
    change(tmp_path, "trial.toml", "= 0.82", "= 1220.0")  # of µm
    assert any("clicked points lie 0.0" in doubt for doubt in check_trial(tmp_path).doubts)


@pytest.mark.slow
def test_lenses_of_pictures_of_another_size_are_doubted(small_trial):
    lens = "matrix = [[900.0, 0, 205], [0, 900.0, 70], [0, 0, 1]]\ndistortion = [0, 0, 0, 0]\n"
    sizes = ("410, 140", "820, 280", "410, 140", "410, 140")
    (small_trial / "lenses.toml").write_text(
        "".join(f"[cam{k + 1}]\n{lens}size = [{size}]\n" for k, size in enumerate(sizes))
    )
    change(small_trial, "trial.toml", 'unit = "mm"', 'unit = "mm"\nlens = "lenses.toml"')
    (doubt,) = check_trial(small_trial).doubts
    assert doubt.startswith(
        "lenses.toml: camera 'cam2' was calibrated with pictures of 820 x 280 px, and the video of "
        "that view has 410 x 140"
    )


@pytest.mark.slow
def test_left_paws_under_the_names_of_right_ones_are_doubted(small_trial):
    change(small_trial, "trial.toml", 'unit = "mm"\n', 'unit = "mm"\nup = [0, 0, -1]\n')
    (doubt,) = check_trial(small_trial).doubts
    assert doubt.startswith("in frame 0 left paws lie ")
    assert "[calibration] up is the wrong way round" in doubt


def test_views_without_calibration_and_many_clicked_frames_are_said(small_trial):
    change(small_trial, "trial.toml", '[calibration]\ndlt = "DLTcoefs.csv"\nunit = "mm"\n', "")
    start = small_trial / "start.csv"
    start.write_text(start.read_text().rstrip() + "\n7,cam1,FR,100,60\n30,cam2,HR,100,60\n")
    report = check_trial(small_trial)
    assert report.faults == []
    assert report.doubts == [
        "no calibration: each view is tracked by itself, and positions will be in px"
    ]
    assert "start: 10 clicks on FR, HR, FL, HL in frames 0, 7, 30" in report.found


def test_a_belt_that_runs_forwards_is_doubted(small_trial):
    change(small_trial, "trial.toml", "belt_speed = 300.0", "belt_speed = -300.0")
    assert any("belt speed is -300" in doubt for doubt in check_trial(small_trial).doubts)


def test_missing_tracks_and_belt_of_a_trial_made_elsewhere(tmp_path):
    (tmp_path / "trial.toml").write_text(
        '[trial]\nkind = "tracks"\nfps = 100\n[treadmill]\nbelt_speed = "belt.csv"\n'
        '[tracks]\nfile = "x.nc"\n'
    )
    report = check_trial(tmp_path)
    assert len(report.faults) == 2
    assert "belt.csv: no such file" in report.faults[0]
    assert "x.nc: no such tracks" in report.faults[1]


def test_clicks_after_the_end_are_found(small_trial):
    start = small_trial / "start.csv"
    start.write_text(start.read_text().replace("\n0,", "\n9999,"))
    report = check_trial(small_trial)
    assert any("clicked in frame 9999, outside frames" in fault for fault in report.faults)


def test_tracks_made_elsewhere_are_read_as_gait_will(tmp_path):
    trial = tmp_path / "trial.toml"
    trial.write_text('[trial]\nkind = "tracks"\nfps = 100\n[tracks]\nfile = "x.csv"\n')
    table = tmp_path / "x.csv"
    table.write_text("frame,hindpaw_R_x,hindpaw_R_y\n0,1,2\n1,2,3\n")
    found = check_trial(trial).found
    assert any("x.csv: 2 frames, positions in px" in line for line in found)
    assert "legs: HR is 'hindpaw_R'" in found
    table.write_text("frame,hindpaw_R_x,hindpaw_R_y\n0,,\n1,,\n")
    assert check_trial(trial).faults == ["x.csv: no point has a position in any frame."]
    table.write_text("frame,pow_x,pow_y\n0,1,2\n1,2,3\n")
    assert "named like a leg" in check_trial(trial).faults[0]
    table.write_text("something else\n")
    assert "not tracks that are read here" in check_trial(trial).faults[0]


@pytest.mark.slow
def test_tracks_that_are_there_are_read(small_trial):
    results = small_trial / "results"
    results.mkdir()
    (results / "tracks.nc").write_text("not tracks")
    report = check_trial(small_trial)
    (doubt,) = report.doubts
    assert doubt.startswith("results/tracks.nc cannot be read, so the trial counts as not tracked:")
    assert "not a netCDF file" in doubt
    assert "delete it and track again" in doubt
    assert "tracked already" not in report.text()
    tracks = make_tracks(range(7), ["FR"], fps=250.0, individual="m", unit="mm")
    step = {"step": "track", "complete": True, "inputs": {}, "settings": {}}
    (results / "tracks.nc").unlink()  # else a copy is kept of what no run wrote
    write_track_results(add_provenance(tracks, **step), results)
    report = check_trial(small_trial)
    assert report.doubts == []
    assert "ok    tracked already: results/tracks.nc, 7 frames" in report.text()
    write_track_results(add_provenance(tracks, **step | {"complete": False}), results)
    (doubt,) = check_trial(small_trial).doubts
    assert doubt == "results/tracks.nc is of a run that was interrupted; track again to go on"
    write_track_results(add_provenance(tracks, **step), results)
    (results / "tracks.csv").write_text("changed in another program")
    (doubt,) = check_trial(small_trial).doubts
    assert doubt.startswith(f"{results}: not as pawnb track left it (changed: tracks.csv)")
    (results / "tracks.nc").unlink()
    (doubt,) = check_trial(small_trial).doubts
    assert doubt.startswith(f"{results}: not as pawnb track left it (missing: tracks.nc)")


@pytest.mark.slow
def test_tracks_of_pictures_that_lay_on_their_side_are_told(small_trial):
    """Made before pawnb heeded how a phone was held, or with the flag taken out of the file."""
    trial = load_trial(small_trial)
    with open_views(trial) as views:
        sizes = {name: [r.width, r.height] for name, r in views.readers.items()}
    tracks = make_tracks(range(7), ["FR"], fps=trial.fps, individual="m", unit="mm")
    first = next(iter(sizes))
    for turned in (False, True):
        shown = sizes | ({first: sizes[first][::-1]} if turned else {})
        made = tracks.assign_attrs(pictures_px=json.dumps(shown))
        write_track_results(made, small_trial / "results")
        told = [doubt for doubt in check_trial(small_trial).doubts if "other pixels" in doubt]
        assert len(told) == turned
    width, height = sizes[first]
    assert f"tracked in pictures of {height} x {width} px (before it was heeded how" in told[0]


@pytest.mark.slow
def test_paws_of_the_colour_of_their_surroundings_are_doubted(small_trial):
    """Clicks on the belt instead of on paws: what is about the animal has the same colour."""
    report = check_trial(small_trial)
    assert not any("hardly differ" in doubt for doubt in report.doubts)
    clicks = pd.read_csv(small_trial / "start.csv")
    clicks["v"] += 25.0  # below the animal
    clicks.to_csv(small_trial / "start.csv", index=False)
    said = [doubt for doubt in check_trial(small_trial).doubts if "hardly differ" in doubt]
    assert len(said) == 1
    assert "cam1" in said[0]
    assert said[0].endswith("painted paws help"), "the report adds no second full stop"


def test_a_wrong_setting_of_the_analysis_is_found_before_the_trial_is_tracked(small_trial):
    with (small_trial / "trial.toml").open("a") as file:
        file.write("\n[gait]\nmin_stanse_s = 0.02\n")
    faults = check_trial(small_trial).faults
    assert [fault.split(";")[0] for fault in faults] == [
        "[gait]: unknown setting 'min_stanse_s' (did you mean 'min_stance_s'?)"
    ]


def test_cameras_of_pictures_of_another_size_are_doubted(rendered_trial, tmp_path):
    """The videos are 410 x 140 px; of cam2 it is said, of cam1 the size fits."""
    cameras = "".join(
        f'[cam_{k}]\nname = "cam{k + 1}"\nsize = [{size}]\n'
        f"matrix = [[300.0, 0, 205.0], [0, 300.0, 70.0], [0, 0, 1]]\n"
        f"distortions = [0, 0, 0, 0, 0]\nrotation = [0.0, {0.2 * k}, 0.0]\n"
        f"translation = [{10.0 * k}, 0.0, 500.0]\n"
        for k, size in enumerate(("410, 140", "820, 280"))
    )
    (tmp_path / "cal.toml").write_text(cameras)
    views = "".join(
        f'[[views]]\nname = "{name}"\nvideo = "{(rendered_trial / f"{name}.avi").as_posix()}"\n'
        for name in ("cam1", "cam2")
    )
    shutil.copy(rendered_trial / "truth" / "tracks.csv", tmp_path)
    (tmp_path / "trial.toml").write_text(
        '[trial]\nname = "t"\nkind = "tracks"\nfps = 100\n[tracks]\nfile = "tracks.csv"\n'
        f'{views}[calibration]\nanipose = "cal.toml"\n'
    )
    report = check_trial(tmp_path)
    (doubt,) = [doubt for doubt in report.doubts if "calibrated with pictures" in doubt]
    assert "camera 'cam2' was calibrated with pictures of 820 x 280 px" in doubt
    assert "the video of that view has 410 x 140" in doubt


@pytest.mark.slow
def test_one_film_given_for_two_views_is_doubted(small_trial):
    """A copy under another name: every view was fine, and so was the trial."""
    shutil.copy(small_trial / "cam1.avi", small_trial / "cam2.avi")
    doubts = check_trial(small_trial).doubts
    assert any("views cam1 and cam2 begin with the same picture" in doubt for doubt in doubts)


@pytest.mark.slow
def test_films_exchanged_after_they_were_clicked_are_doubted(small_trial):
    """The widget keeps in which film a click was made; names swapped in trial.toml, then files."""
    clicks = pd.read_csv(small_trial / "start.csv")
    (small_trial / "start.csv").unlink()
    widget = ClickInitialiser(small_trial)
    for row in clicks.itertuples():
        widget.session.go(row.frame)
        widget.session.place(row.view, row.point, row.u, row.v)
    widget.close()
    # the file of clicks is as the guide has it
    assert list(pd.read_csv(small_trial / "start.csv")) == ["frame", "view", "point", "u", "v"]
    text = (small_trial / "trial.toml").read_text()

    def exchanged():
        return [d for d in check_trial(small_trial).doubts if "made in another film" in d]

    assert not exchanged()
    names = {"cam1.avi": "cam2.avi", "cam2.avi": "cam1.avi"}
    swapped = re.sub("cam[12].avi", lambda name: names[name[0]], text)
    (small_trial / "trial.toml").write_text(swapped)
    first, second = exchanged()
    assert first.startswith("the clicks of view cam1 were made in another film than it shows now")
    assert "it shows the film of cam1" in second
    again = ClickInitialiser(small_trial)
    assert "clicks of view cam1 were made in another film" in again.status
    again.session.place("cam1", "FR", 100.0, 80.0)  # which makes the others no better
    again.close()
    assert len(exchanged()) == 2


@pytest.mark.slow
def test_a_film_that_looks_interlaced_though_it_does_not_say_so_is_doubted(small_trial):
    """Every other row of each picture from the next one, as of a camera that filmed in fields."""
    with open_views(load_trial(small_trial)) as views:
        pictures = [views.readers["cam1"].read(k) for k in range(40)]
    folder = small_trial / "woven"
    folder.mkdir()
    for k, (one, other) in enumerate(zip(pictures, [*pictures[1:], pictures[-1]], strict=True)):
        one[1::2] = other[1::2]
        cv2.imwrite(str(folder / f"{k:03d}.png"), one[..., ::-1])
    change(small_trial, "trial.toml", 'video = "cam1.avi"', 'video = "woven"')
    (said,) = [d for d in check_trial(small_trial).doubts if "looks interlaced" in d]
    assert "ffmpeg -i IN -vf bwdif=mode=send_field" in said


@pytest.mark.slow
def test_two_points_clicked_on_one_place_are_doubted(small_trial):
    clicks = pd.read_csv(small_trial / "start.csv")
    places = clicks.set_index(["view", "point"])
    for k, row in clicks[clicks["point"] == "HR"].iterrows():
        clicks.loc[k, ["u", "v"]] = places.loc[(row["view"], "FR"), ["u", "v"]].to_numpy() + 0.5
    clicks.to_csv(small_trial / "start.csv", index=False)
    doubts = check_trial(small_trial).doubts
    assert any("FR and HR lie on one place in cam1 and cam2" in doubt for doubt in doubts)
