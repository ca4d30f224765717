"""The command that builds a stride template from a trial's tracks."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from pawnb.core.paws.template import load_template
from pawnb.core.rig import load_rig
from pawnb.errors import InputError
from pawnb.io.native import write_tracks
from pawnb.schema import ORIGIN_CODE, make_tracks
from pawnb.trial import load_trial
from pawnb.workflow.stride_template import build_template, main


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
