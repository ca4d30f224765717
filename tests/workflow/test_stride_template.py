"""The command that builds a stride template from a trial's tracks."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from pawnb.core.paws.maghsoudi2019.template import average_strides, cut_strides, load_template
from pawnb.core.rig import load_rig
from pawnb.errors import InputError
from pawnb.io.native import write_tracks
from pawnb.schema import ORIGIN_CODE, make_tracks
from pawnb.synthetic import render_mouse_trial, scene_settings
from pawnb.synthetic.camera import make_cameras
from pawnb.synthetic.gait_model import plan_gait
from pawnb.synthetic.mouse import Mouse
from pawnb.synthetic.mouse_trial import find_start, tracked_legs
from pawnb.synthetic.scene import LEGS
from pawnb.synthetic.truth import paw_positions
from pawnb.trial import load_trial
from pawnb.workflow.stride_template import build_template, main
from pawnb.workflow.tracking.track import track

pytestmark = pytest.mark.slow  # scenes are rendered and tracked


def tracks_of(trial, *, period=40.0, n=250):
    """Paws that go round an ellipse, forwards as each camera sees it; v lags a quarter."""
    rig = load_rig(trial)
    tracks = make_tracks(
        np.arange(n), ["FR", "HR", "FL", "HL"], fps=trial.fps, views=rig.names, unit="mm"
    )
    angle = 2 * np.pi * np.arange(n) / period
    for v, view in enumerate(rig.names):
        for p in range(4):
            tracks["image_position"][:, v, 0, p, 0] = 200 + rig.facing(view) * 30 * np.cos(angle)
            tracks["image_position"][:, v, 1, p, 0] = 100 + 15 * np.sin(angle)
    # cam1 does not track the left paws: what stands there must not count
    tracks["image_position"][:, 0, :, 2, 0] *= np.linspace(0.1, 2.0, n)[:, None]
    tracks["image_origin"][:] = ORIGIN_CODE["measured"]
    return tracks


def test_the_command_writes_the_mean_stride(small_trial, tmp_path, capsys):
    trial = load_trial(small_trial)
    (small_trial / "results").mkdir(exist_ok=True)
    write_tracks(tracks_of(trial), small_trial / "results" / "tracks.nc")
    path = tmp_path / "template.json"
    assert main([str(small_trial), "-o", str(path)]) == 0
    # 250 frames hold 5 whole strides, in two views a side: 5 x 4 of each kind
    said = capsys.readouterr().out
    assert said == ("front: 20 strides, mean 0.160 s\nhind: 20 strides, mean 0.160 s\n")
    angle = 2 * np.pi * np.arange(50) / 50
    for own in load_template(path).kinds.values():
        expected = np.stack([np.cos(angle) / 2, np.sin(angle) / 4], axis=1)
        np.testing.assert_allclose(own.uv, expected, atol=0.01)


def test_bad_input_is_one_sentence(small_trial, tmp_path, capsys):
    assert main([str(small_trial), "-o", str(tmp_path / "t.json")]) == 2
    assert "tracks.nc" in capsys.readouterr().err
    trial = load_trial(small_trial)
    with pytest.raises(InputError, match="1 trials and 2 tracks; expected as many"):
        build_template([trial], tracks=[tracks_of(trial)] * 2)
    with pytest.raises(InputError, match="no complete stride of a front paw"):
        build_template([trial], tracks=[tracks_of(trial, n=30)])


@pytest.mark.parametrize("facing", [1, -1])
def test_tracks_of_another_program_will_do(tmp_path, facing, capsys):
    """A csv with two paws of one picture, and nothing that says where the animal faces.

    A paw swings forwards in a third of its stride and is carried back, at the belt's speed, in
    two thirds.
    """
    phase = np.arange(250) / 40.0 % 1.0
    u = np.where(phase < 1 / 3, -np.cos(3 * np.pi * phase), 1 - 3 * (phase - 1 / 3))
    v = np.where(phase < 1 / 3, -np.sin(3 * np.pi * phase), 0.0)
    table = pd.DataFrame({"frame": np.arange(250)})
    for point, lag in (("FR", 0), ("HR", 20)):
        table[f"{point}_x"] = 200 + facing * 30 * np.roll(u, lag)
        table[f"{point}_y"] = 100 + 12 * np.roll(v, lag)
    table.to_csv(tmp_path / "paws.csv", index=False)
    (tmp_path / "trial.toml").write_text(
        '[trial]\nkind = "tracks"\nname = "t"\nfps = 250.0\n[animal]\nid = "a"\n'
        '[tracks]\nfile = "paws.csv"\n'
    )
    assert main([str(tmp_path), "-o", str(tmp_path / "t.json")]) == 0
    said = capsys.readouterr().out.splitlines()
    assert [line.split(",")[1] for line in said] == [" mean 0.160 s"] * 2
    for own in load_template(tmp_path / "t.json").kinds.values():
        # begins at the front; back at first slowly, with the belt, and forwards in the last third
        assert own.uv[0, 0] == pytest.approx(0.5, abs=0.02)
        assert own.uv[17, 0] == pytest.approx(0.0, abs=0.06)
        assert own.uv[34, 0] == pytest.approx(-0.5, abs=0.06)
        assert own.uv[42, 1] < own.uv[17, 1]  # the paw is in the air: higher, so less v


def truth_of_demo(seed, *, frames=300):
    """Where the paws are in the pictures of ``pawnb demo paws``: no picture is made for it."""
    scene = scene_settings("normal", changes={"scale": 0.5, "seed": seed})
    gait = plan_gait(scene, frames / scene.fps)
    begin_s = find_start(Mouse(scene, gait), gait, scene)
    positions = paw_positions(gait, scene, begin_s + np.arange(frames) / scene.fps)
    cameras = make_cameras(scene)
    views = [camera.name for camera in cameras]
    tracks = make_tracks(np.arange(frames), list(LEGS), fps=scene.fps, views=views)
    tracks["image_origin"][:] = ORIGIN_CODE["measured"]
    for v, camera in enumerate(cameras):
        tracks["image_position"][:, v, :, :, 0] = np.swapaxes(camera.project(positions)[0], 1, 2)
    return tracks, {camera.name: tracked_legs(camera, scene) for camera in cameras}


def test_the_template_of_the_package_is_that_of_the_scenes_it_was_made_from():
    """CONTRIBUTING.md has the commands; their truth is what the tracks should have been."""
    strides = []
    for seed in range(6):
        tracks, tracked = truth_of_demo(seed)
        # the mouse of the demo runs towards +X, which these cameras see from its right and left
        facing = {view: 1 if "FR" in legs else -1 for view, legs in tracked.items()}
        kinds = {"FR": "front", "FL": "front", "HR": "hind", "HL": "hind"}
        strides.append(cut_strides(tracks, points=kinds, facing=facing, points_by_view=tracked))
    truth = average_strides(strides)
    for kind, own in load_template().kinds.items():
        true = truth.kinds[kind]
        assert own.n_strides == pytest.approx(true.n_strides, abs=2)
        assert own.period_s == pytest.approx(true.period_s, abs=0.001)
        # of the range of u, which is some 50 mm: 1.25 mm
        np.testing.assert_allclose(own.uv, true.uv, atol=0.025)


def test_tracks_of_the_default_method_and_the_truth_give_the_same_template(tmp_path):
    """Front paws are hidden in every stride: tracks bridge that, and the truth knows it."""
    trial = load_trial(render_mouse_trial(tmp_path / "mouse", frames=130, scale=0.3, seed=3))
    track(trial, out=trial.folder / "results", progress=lambda done, total: None)
    own, true = tmp_path / "own.json", tmp_path / "true.json"
    assert main([str(trial.folder), "-o", str(own)]) == 0
    assert main([str(trial.folder), "--tracks", "truth/tracks.csv", "-o", str(true)]) == 0
    for kind, expected in load_template(true).kinds.items():
        # one paw at least has a whole stride in 130 frames, in the two views of its side
        assert load_template(own).kinds[kind].n_strides == expected.n_strides >= 2
        np.testing.assert_allclose(load_template(own).kinds[kind].uv, expected.uv, atol=0.05)
