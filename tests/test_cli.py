"""The commands as a user types them: output, files, exit status, one sentence on errors."""

from __future__ import annotations

import os
import shlex
import subprocess
import sys

import pandas as pd
import pytest

from pawnb import cli
from pawnb.io.native import write_tracks
from pawnb.schema import make_tracks
from pawnb.trial import load_trial
from pawnb.workflow import lab


def run(capsys, *words):
    status = cli.main([str(word) for word in words])
    captured = capsys.readouterr()
    return status, captured.out, captured.err


def test_a_reader_that_leaves_changes_neither_status_nor_work(tmp_path, monkeypatch):
    """As in ``pawnb check TRIAL 2>&1 | true``."""
    (tmp_path / "trial.toml").write_text(
        '[trial]\nkind = "tracks"\nname = "t"\nfps = 250.0\n[animal]\nid = "m"\n'
        '[tracks]\nfile = "tracks.nc"\n'
    )
    tracks = make_tracks(range(9), ["FR", "FL"], fps=250.0, space=("x", "y"))
    tracks["position"][:] = 1.0
    write_tracks(tracks, tmp_path / "tracks.nc")
    for folder, status in ((tmp_path, 0), (tmp_path / "none", 2)):
        read_end, write_end = os.pipe()
        os.close(read_end)
        with open(write_end, "w") as pipe, monkeypatch.context() as patch:  # noqa: PTH123
            patch.setattr("sys.stdout", pipe)
            patch.setattr("sys.stderr", pipe)
            assert cli.main(["check", str(folder)]) == status


def test_a_name_that_the_output_cannot_take_ends_no_command(tmp_path, monkeypatch):
    """As in ``pawnb check TRIAL > check.txt`` on Windows, which has 8 bits for a sign there."""
    (tmp_path / "trial.toml").write_text(
        '[trial]\nkind = "tracks"\nname = "小鼠-ä"\nfps = 250.0\n[animal]\nid = "m"\n'
        '[tracks]\nfile = "tracks.nc"\n',
        encoding="utf-8",
    )
    tracks = make_tracks(range(9), ["FR", "FL"], fps=250.0, space=("x", "y"))
    tracks["position"][:] = 1.0
    write_tracks(tracks, tmp_path / "tracks.nc")
    with (tmp_path / "check.txt").open("w", encoding="cp1252") as file, monkeypatch.context() as p:
        p.setattr("sys.stdout", file)
        assert cli.main(["check", str(tmp_path)]) == 0
    said = (tmp_path / "check.txt").read_text(encoding="cp1252")
    assert said.startswith(r"trial \u5c0f\u9f20-ä")


@pytest.mark.slow
def test_demo_check_track_gait_in_a_row(tmp_path, capsys):
    out = tmp_path / "demo"
    status, said, _ = run(
        capsys, "demo", "paws", "--out", out, "--frames", 60, "--scale", 0.15, "--seed", 3
    )
    assert status == 0
    assert f"pawnb track {out}" in said
    assert len(pd.read_csv(out / "truth" / "points3d.csv")) == 60 * 4
    status, said, _ = run(capsys, "check", out)
    assert status == 0
    assert "view cam1: 60 frames" in said
    status, said, err = run(capsys, "track", out, "--set", "max_hypotheses=12")
    assert (status, err) == (0, "")
    assert "tracked 60 frames" in said
    assert (out / "results" / "tracks.nc").exists()
    status, said, _ = run(capsys, "gait", out)
    assert status == 0
    assert (out / "results" / "strides.csv").exists()
    assert (
        out / "results" / "figures" / "gait_diagram_synthetic-03_synthetic-normal-03.png"
    ).exists()


@pytest.mark.slow
def test_tracking_again_says_which_corrections_the_new_tracks_lack(small_trial, capsys):
    """They are made again in the review only; who goes on to the gait would not have them."""
    file = small_trial / "trial.toml"
    file.write_text(file.read_text().replace("fps = 250.0", "fps = 250.0\nframes = [0, 6]"))
    (small_trial / "results").mkdir()
    move = '{"edit": "move", "frame": 2, "view": "cam1", "point": "FR", "u": 200.0, "v": 90.0}\n'
    (small_trial / "results" / "edits.jsonl").write_text(move)
    _, said, _ = run(capsys, "track", small_trial, "--method", "paper")
    assert "look: 1 correction is not in the tracks; open the review and press Save" in said


@pytest.mark.slow
def test_the_next_command_can_be_copied_where_folders_have_blanks(tmp_path, capsys):
    out = tmp_path / "my mice"
    _, said, _ = run(capsys, "demo", "paws", "--out", out, "--frames", 2, "--scale", 0.06)
    assert shlex.split(said.split("next: ")[1]) == ["pawnb", "track", str(out)]


@pytest.mark.slow
def test_demo_lists_its_variants_and_renders_them(tmp_path, capsys):
    with pytest.raises(SystemExit):
        cli.main(["demo", "--help"])
    said = " ".join(capsys.readouterr().out.split())
    assert all(name in said for name in ("grey:", "h264-crfNN:", "low-rate-K:", "glass-belt:"))
    status, _, _ = run(
        capsys, "demo", "paws", "--out", tmp_path, "--frames", 2, "--scale", 0.06,
        "--vary", "grey,low-rate",
    )  # fmt: skip
    assert status == 0
    trial = load_trial(tmp_path)
    assert (trial.name, trial.fps) == ("synthetic-normal-00-grey-low-rate", 50.0)


@pytest.mark.slow
def test_demo_spider_is_a_trial_with_its_truth(tmp_path, capsys):
    out = tmp_path / "spider"
    status, said, _ = run(capsys, "demo", "spider", "--out", out, "--frames", 70, "--scale", 0.15)
    assert status == 0
    assert f"pawnb track {out}" in said
    assert load_trial(out).kind == "pose"
    assert pd.read_csv(out / "truth" / "pose.csv")["frame"].max() == 69
    status, _, err = run(capsys, "demo", "spider", "--out", out, "--frames", 12)
    assert (status, err.count("\n")) == (2, 1)
    assert "never wholly in view" in err


def change(folder, file, old, new):
    path = folder / file
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))


@pytest.mark.parametrize(
    ("file", "old", "new", "options", "sentence"),
    [
        ("trial.toml", "cam2.avi", "none.avi", (), "no such file"),
        ("trial.toml", '[calibration]\ndlt = "DLTcoefs.csv"\nunit = "mm"\n', "",
         ("--method", "paper"),
         "has 4 views and no calibration"),
        ("start.csv", "0,cam1,FR,", "0,cam1,FR,5", (), "outside the picture"),
        ("start.csv", "0,cam1,FR,", "0,cam3,FL,", (), "is clicked twice"),
        ("start.csv", "frame,view,point", "frame,camera,point", (), "column 'view' is missing"),
        ("start.csv", "", "", ("--set", "windw_u_px=3"), "unknown name 'windw_u_px'"),
        ("start.csv", "", "", ("--set", "median_px"), "expected NAME=VALUE"),
        ("start.csv", "", "", ("--method", "best"), "unknown method 'best'"),
        ("trial.toml", "fps = 250.0", "", (), "fps is missing"),
    ],
)  # fmt: skip
def test_bad_input_ends_with_status_2_and_one_sentence(
    small_trial, capsys, file, old, new, options, sentence
):
    if old:
        change(small_trial, file, old, new)
    status, said, err = run(capsys, "track", small_trial, *options)
    assert status == 2
    assert said == ""
    assert err.startswith("pawnb: ")
    assert err.count("\n") == 1
    assert "Traceback" not in err
    assert not (small_trial / "results").exists()


def test_a_point_clicked_in_no_view_is_refused(small_trial, capsys):
    clicks = pd.read_csv(small_trial / "start.csv")
    clicks[clicks["point"] != "FR"].to_csv(small_trial / "start.csv", index=False)
    status, _, err = run(capsys, "track", small_trial)
    assert status == 2
    assert "FR" in err
    assert "no view" in err


def test_check_of_a_broken_trial_has_status_2(small_trial, capsys):
    change(small_trial, "trial.toml", "cam2.avi", "none.avi")
    status, said, err = run(capsys, "check", small_trial)
    assert status == 2
    assert "MEND" in said
    assert err.count("\n") == 1


def test_words_that_make_no_command(capsys):
    with pytest.raises(SystemExit) as caught:
        cli.main(["trak", "x"])
    assert caught.value.code == 2
    err = capsys.readouterr().err
    assert err.startswith("pawnb: ")
    assert err.count("\n") == 1


@pytest.mark.slow
def test_python_m_pawnb_is_the_command():
    done = subprocess.run(
        [sys.executable, "-m", "pawnb", "--version"], capture_output=True, text=True, check=True
    )
    assert done.stdout.startswith("pawnb 0.")


def test_lab_opens_the_quick_start_on_this_machine_only():
    words = lab.lab_command(browser=False, port=8899)
    assert words[:4] == [sys.executable, "-m", "jupyter", "lab"]
    assert "--ip=127.0.0.1" in words
    assert "--no-browser" in words
    assert "--port=8899" in words
    assert any(word.endswith("00_quickstart.ipynb") for word in words)


@pytest.mark.slow
def test_lab_asks_nothing_about_news_and_writes_no_settings(monkeypatch):
    """What is switched off is read by JupyterLab's own server."""
    code = (
        "from jupyterlab_server.config import get_page_config as get; "
        "print(get([])['disabledExtensions'])"
    )
    monkeypatch.setenv("JUPYTER_CONFIG_PATH", "/somewhere")
    env = lab.lab_environment()
    assert env["JUPYTER_CONFIG_PATH"].split(os.pathsep)[1:] == ["/somewhere"]
    for given, off in ((os.environ, False), (env, True)):
        done = subprocess.run(
            [sys.executable, "-c", code],
            env=dict(given),
            capture_output=True,
            text=True,
            check=True,
        )
        assert ("@jupyterlab/apputils-extension:announcements" in done.stdout) is off


def test_lab_knows_our_notebooks_by_name(capsys):
    assert any(word.endswith("01_real_mouse_two_views.ipynb")
               for word in lab.lab_command("01_real_mouse_two_views.ipynb"))  # fmt: skip
    status, _, err = run(capsys, "lab", "02_nothing.ipynb")
    assert status == 2
    assert "02_nothing.ipynb: no such notebook; ours are 00_quickstart.ipynb" in err


def test_an_installed_pawnb_copies_its_notebooks_once(tmp_path, monkeypatch):
    package = tmp_path / "site-packages" / "pawnb"
    (package / "notebooks").mkdir(parents=True)
    (package / "notebooks" / "00_quickstart.ipynb").write_text("ours")
    monkeypatch.setattr(lab, "_PACKAGE", package)
    monkeypatch.chdir(tmp_path)
    folder = lab.notebooks_folder()
    assert (folder / "00_quickstart.ipynb").read_text() == "ours"
    (folder / "00_quickstart.ipynb").write_text("mine")
    assert (lab.notebooks_folder() / "00_quickstart.ipynb").read_text() == "mine"


@pytest.mark.slow
def test_a_video_that_is_cut_short_is_used_and_said(small_trial, capsys):
    video = small_trial / "cam1.avi"
    video.write_bytes(video.read_bytes()[: video.stat().st_size // 2])
    status, said, err = run(capsys, "track", small_trial)
    assert status == 0
    assert "tracked 40 frames" not in said
    assert "pawnb: note: " in err
    assert "cam1.avi is cut short: it promises 40 frames and ends with frame " in err
    assert "are left out" in err


def test_convert_reads_another_program_and_asks_for_the_frame_rate(tmp_path, capsys):
    source, target = tmp_path / "clip.csv", tmp_path / "tracks.csv"
    source.write_text("scorer,n,n,n\nbodyparts,FR,FR,FR\ncoords,x,y,likelihood\n0,1.5,2.5,0.9\n")
    assert cli.main(["convert", str(source), str(target)]) == 2
    assert "--fps" in capsys.readouterr().err
    assert cli.main(["convert", str(source), str(target), "--fps", "50"]) == 0
    assert pd.read_csv(target)[["u", "v"]].to_numpy().tolist() == [[1.5, 2.5]]


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("demo", "paws", "--frames", "4", "--scale", "0.1", "--out", "file"), "Not a directory"),
        (("demo", "paws", "--vary", "grey, gray"), "variant 'gray' is unknown (did you mean"),
        (("demo", "spider", "--vary", "grey"), "only pawnb demo paws has variants"),
        (("convert", "points.csv", "file/tracks.nc", "--fps", "9"), "no such folder"),
        (("convert", "points.csv", "tracks.nc", "--fps", "-2"), "fps is -2; expected"),
        (("convert", "points.csv", "tracks.nc", "--fps", "nan"), "fps is nan; expected"),
        (("convert", ".", "tracks.nc"), "a folder; expected a file of tracks"),
        (("gait", "points.csv", "--fps", "0"), "fps is 0; expected"),
        (("gait", "points.csv", "--fps", "9", "--legs", "FR="), "--legs FR=: expected LEG=POINT"),
        (("gait", "noise.csv"), "noise.csv: not tracks that are read here; expected"),
        (("gait", "cam1.f.rat.2018-06-08_13_30_12.csv"), "a trial.toml of kind 'tracks'"),
        (("lab", "--port", "99999999", "--no-browser"), "port is 99999999; expected 1 to 65535"),
        (("batch", "none"), "1 of 1 trials failed: none: none: no such file"),
    ],
)
def test_bad_input_of_any_command_is_one_sentence(tmp_path, monkeypatch, capsys, words, sentence):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("not a folder")
    (tmp_path / "noise.csv").write_bytes(bytes(range(256)))
    (tmp_path / "cam1.f.rat.2018-06-08_13_30_12.csv").write_text("1,2\n")
    (tmp_path / "points.csv").write_text("frame,FR_x,FR_y\n0,1,2\n1,2,3\n")
    status, _, err = run(capsys, *words)
    assert (status, err.count("\n")) == (2, 1)
    assert err.startswith("pawnb: ")
    assert sentence in err


def test_what_the_system_refuses_is_one_sentence(tmp_path, monkeypatch, capsys):
    def full(*_args, **_more):
        raise OSError(28, "No space left on device", "tracks.nc.part")

    (tmp_path / "points.csv").write_text("frame,FR_x,FR_y\n0,1,2\n1,2,3\n")
    monkeypatch.setattr("pawnb.io.native.write_whole", full)
    status, _, err = run(
        capsys, "convert", tmp_path / "points.csv", tmp_path / "tracks.nc", "--fps", 9
    )
    assert (status, err.count("\n")) == (2, 1)
    assert err.startswith("pawnb: tracks.nc.part: No space left on device; ")


@pytest.mark.parametrize(
    "table",
    [
        ("frame,view,point,u,v,confidence,origin", "{},cam1,FR,,,0,missing"),
        ("frame,point,x,y,z,residual_px,origin", "{},FR,,,,,missing"),
        ("frame,FR_x,FR_y", "{},,"),
    ],
)
def test_tracks_without_a_single_position_are_refused_by_gait(tmp_path, capsys, table):
    head, row = table
    rows = [row.format(frame) for frame in range(9)]
    (tmp_path / "lost.csv").write_text("\n".join([head, *rows]) + "\n")
    status, _, err = run(capsys, "gait", tmp_path / "lost.csv", "--fps", 100)
    assert (status, err.count("\n")) == (2, 1)
    assert "none of the legs FR has a position in any frame" in err
