"""``pawnb calibrate --wand``: a table of two ends to coefficients, and what is wrong with it."""

from __future__ import annotations

import json

import numpy as np
import pandas as pd
import pytest
import tomli_w
from board_scene import NAMES, shown, true_cameras

from pawnb import cli
from pawnb.core.dlt import triangulate
from pawnb.core.lens import load_lenses
from pawnb.io.coefs import read_coefs


@pytest.fixture
def scene(tmp_path):
    """A table of both ends in 40 frames, the lenses, and the ends in space."""
    rng = np.random.default_rng(3)
    middle, along = rng.uniform(-90.0, 90.0, (40, 3)), rng.normal(size=(40, 3))
    along *= 50.0 / np.linalg.norm(along, axis=1, keepdims=True)
    xyz = np.stack([middle - along, middle + along], axis=1)
    rows = []
    lenses = {}
    for name, camera in zip(NAMES, true_cameras(), strict=True):
        uv = shown(camera, xyz.reshape(-1, 3)).reshape(40, 2, 2)
        rows += [
            (10 + f, name, end, *uv[f, e])
            for f in range(40)
            for e, end in enumerate(("red", "tip"))
        ]
        lenses[name] = {"matrix": camera[0].tolist(), "distortion": camera[1].tolist()}
    table = pd.DataFrame(rows, columns=["frame", "view", "point", "u", "v"])
    table.to_csv(tmp_path / "ends.csv", index=False)
    (tmp_path / "lenses_of_board.toml").write_text(tomli_w.dumps(lenses))
    return tmp_path, table, xyz


def test_distances_in_space_are_those_of_the_scene(scene, capsys):
    folder, table, xyz = scene
    out = folder / "DLTcoefs.csv"
    words = ["calibrate", str(folder / "ends.csv"), "--wand", "100", "--size", "640x480"]
    words += ["--lenses", str(folder / "lenses_of_board.toml"), "-o", str(out)]
    assert cli.main([*words, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["length_median"] == pytest.approx(100.0, abs=0.01)
    assert found["remarks"] == []
    assert {row["frame"] for row in found["frames"]} == set(range(10, 50))
    lenses, coefs = load_lenses(folder / "lenses.toml"), read_coefs(out, NAMES)
    uv = table.pivot_table(index=["frame", "point"], columns="view", values=["u", "v"])
    straight = np.stack(
        [lenses[n].straighten(np.stack([uv["u"][n], uv["v"][n]], axis=-1)) for n in NAMES], axis=1
    )
    mine = triangulate(coefs, straight, even=True).xyz
    true = xyz.reshape(-1, 3)
    # distances between any two places do not depend on the axes
    apart = np.linalg.norm(mine[:, None] - mine[None], axis=-1)
    np.testing.assert_allclose(apart, np.linalg.norm(true[:, None] - true[None], axis=-1), atol=0.1)
    assert cli.main(words) == 0
    assert "the wand of 100 is 100.000 long (median of 40)" in capsys.readouterr().out


def test_what_is_wrong_with_the_table_is_one_sentence(scene, capsys):
    folder, table, _ = scene
    path = folder / "ends.csv"

    def said(*words, table=table):
        table.to_csv(path, index=False)
        assert cli.main(["calibrate", str(path), *words]) == 2
        err = capsys.readouterr().err
        assert err.count("\n") == 1
        return err

    size = ("--size", "640x480")
    assert "--wand needs one csv of its two ends" in said("--wand", "100")
    assert "--size 640: expected WIDTHxHEIGHT" in said("--wand", "100", "--size", "640")
    assert "the wand is -1 long" in said("--wand", "-1", *size)
    assert "2 sizes of pictures for 3 views" in said("--wand", "100", *size, "640x480")
    assert "views a are named, but ends.csv has left, middle, right" in said(
        "--wand", "100", *size, "--views", "a"
    )
    turned = said("--wand", "100", "--size", "240x640")
    assert turned.startswith("pawnb: view 'left': u is ")
    assert "outside its picture of 240 x 640 px" in turned
    third = pd.concat([table, table.iloc[:1].assign(point="grip")])
    assert "3 points (red, tip, grip); expected two" in said("--wand", "100", *size, table=third)
    twice = pd.concat([table, table.iloc[:1]])
    assert "frame 10, view left, point red is there twice" in said(
        "--wand", "100", *size, table=twice
    )
    few = table[table["frame"] < 15]
    assert "seen by two views in 5 frames; at least 10" in said("--wand", "100", *size, table=few)
    (folder / "none.toml").write_text("[left]\nmatrix = [[9.0, 0.0, 1.0], [0.0, 9.0, 1.0], [0.0, 0.0, 1.0]]\ndistortion = [0.0, 0.0, 0.0, 0.0]\n")  # fmt: skip # noqa: E501
    assert "none.toml: no section [middle]" in said(
        "--wand", "100", *size, "--lenses", str(folder / "none.toml")
    )
