"""``pawnb calibrate``: coefficients come back from points that were projected by them."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from pawnb import cli
from pawnb.errors import InputError
from pawnb.io.coefs import read_coefs
from pawnb.workflow.calibration.calibrate import calibrate

# two cameras, 0.5 m away, that look along +Y and from 30 degrees beside it: u = f X / depth + u0
_ANGLES = (0.0, 30.0)
_FOCAL, _CENTRE, _AWAY = 1000.0, (512.0, 300.0), 500.0


def camera(xyz, angle_deg):
    """Project by hand (a pinhole, not pawnb's DLT)."""
    c, s = np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))
    x, depth = c * xyz[:, 0] + s * xyz[:, 1], -s * xyz[:, 0] + c * xyz[:, 1] + _AWAY
    return np.stack(
        [_CENTRE[0] + _FOCAL * x / depth, _CENTRE[1] - _FOCAL * xyz[:, 2] / depth], axis=1
    )


@pytest.fixture
def files(tmp_path):
    xyz = np.random.default_rng(4).uniform(-60.0, 60.0, (25, 3))
    points = pd.DataFrame(xyz, columns=["x", "y", "z"])
    points.insert(0, "point", [f"m{k}" for k in range(25)])
    points.to_csv(tmp_path / "points.csv", index=False)
    clicks = []
    for view, angle in zip(("side", "front"), _ANGLES, strict=True):
        uv = camera(xyz, angle)
        clicks.append(
            pd.DataFrame({"view": view, "point": points["point"], "u": uv[:, 0], "v": uv[:, 1]})
        )
    pd.concat(clicks).to_csv(tmp_path / "clicks.csv", index=False)
    return tmp_path / "points.csv", tmp_path / "clicks.csv"


def test_the_command_writes_what_projects_like_the_cameras(files, tmp_path, capsys):
    out = tmp_path / "DLTcoefs.csv"
    words = ["calibrate", *map(str, files), "-o", str(out), "--views", "front", "side"]
    assert cli.main(words) == 0
    said = capsys.readouterr().out
    assert "front: 25 points, reprojection error 0.000 px RMS" in said
    assert "m0 0.000, m1 0.000" in said
    coefs = read_coefs(out, ["front", "side"])
    X = np.array([[10.0, -20.0, 30.0]])
    for column, angle in zip(coefs.T, _ANGLES[::-1], strict=True):
        below = column[8:11] @ X[0] + 1.0
        u, v = column[0:3] @ X[0] + column[3], column[4:7] @ X[0] + column[7]
        np.testing.assert_allclose([[u / below, v / below]], camera(X, angle), atol=1e-6)


def test_a_bad_click_stands_out_and_bad_files_are_one_sentence(files, capsys):
    points, clicks = files
    table = pd.read_csv(clicks)
    table.loc[3, "u"] += 25.0
    table.to_csv(clicks, index=False)
    worst = calibrate(points, clicks).residuals
    assert worst.loc[worst["residual_px"].idxmax(), ["view", "point"]].tolist() == ["side", "m3"]
    with pytest.raises(
        InputError, match=r"^views side are named, but clicks\.csv has clicks in side, front"
    ):
        calibrate(points, clicks, views=["side"])
    clicks.write_text("view,point,u,v\nside,m0,1,x\n")
    assert cli.main(["calibrate", str(points), str(clicks)]) == 2
    said = capsys.readouterr().err
    assert said == "pawnb: clicks.csv: line 2, column 'v' is 'x'; expected a number.\n"


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda c: c.assign(v=600 - c["v"]), "mirrored in side, front: its axes"),
        (
            lambda c: c.assign(u=c["u"].where(c["view"] == "side", 1023 - c["u"])),
            "mirrored in front and as it is in side",
        ),
        (lambda c: c.assign(u=c["u"] + 25.0 * (c.index == 3)), "view 'side': point 'm3' lies 25.0"),
    ],
)
def test_clicks_that_fit_but_are_wrong_are_said(files, tmp_path, capsys, change, said):
    points, clicks = files
    out = ["-o", str(tmp_path / "DLTcoefs.csv")]
    assert cli.main(["calibrate", str(points), str(clicks), *out]) == 0
    told = capsys.readouterr().out
    assert "look:" not in told
    assert "its views in the order side, front" in told
    change(pd.read_csv(clicks)).to_csv(clicks, index=False)
    assert cli.main(["calibrate", str(points), str(clicks), *out]) == 0
    (line,) = [x for x in capsys.readouterr().out.splitlines() if x.startswith("look: ")]
    assert said in line


@pytest.mark.parametrize(
    "words",
    [["--lenses", "lenses.toml"], ["--size", "10x10"], ["--from", "dltdv7"], ["--heights", "9"]],
)
def test_an_option_that_would_not_be_heeded_is_refused(files, tmp_path, capsys, words):
    out = tmp_path / "DLTcoefs.csv"
    assert cli.main(["calibrate", *map(str, files), "-o", str(out), *words]) == 2
    assert f"{words[0]} is for " in capsys.readouterr().err
    assert not out.exists()
