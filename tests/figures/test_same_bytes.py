"""The same table drawn twice gives the same bytes: every figure; and every table its csv."""

from __future__ import annotations

import itertools
import os
import subprocess
import sys
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
from walking import Walk

import pawnb
from pawnb import figures
from pawnb.errors import InputError
from pawnb.gait import analyse, pool
from pawnb.gait.coordination import coordination_tables
from pawnb.gait.strides.durations import compare_legs
from pawnb.io.tables import write_table
from pawnb.schema import make_tracks
from pawnb.trial import Animal, Trial
from pawnb.workflow.gait import save_figures
from pawnb.workflow.gait.drawing.draw_figure import draw_figure
from pawnb.workflow.gait.drawing.drawings import gait_drawings
from pawnb.workflow.gait.drawing.overview_drawings import overview_drawings
from pawnb.workflow.gait.drawing.save_figures import save_figure
from pawnb.workflow.gait.statistics import statistics_tables

mpl.use("Agg")
FS = 250.0
T = np.arange(200) / FS
WAVE = 20.0 * np.sin(2 * np.pi * 3 * T) + np.random.default_rng(0).normal(0, 0.5, len(T))
SPECIES = pd.DataFrame(
    {"name": list("abcd"), "group": list("ppqq"), "mass": [1.0, 3.0, 9.0, 20.0],
     "speed": [10.0, 14.0, 19.0, 30.0]}
)  # fmt: skip
PLACES = pd.DataFrame(
    [(p, f, f + k, np.sin(f / 9 + k), k) for k, p in enumerate(("FR", "HR")) for f in range(40)],
    columns=["point", "frame", "x", "y", "z"],
)
ANGLES = pd.DataFrame(
    [(a, "t", leg, "BC", 20 * np.sin(f / 7 + k)) for k, a in enumerate("mn")
     for leg in ("L1", "R1") for f in range(50)],
    columns=["animal", "trial", "leg", "joint", "angle_deg"],
)  # fmt: skip


@pytest.fixture(scope="module")
def tables():
    """Four mice in two groups, at speeds of their own, two trials each."""
    parts, groups = [], {}
    for k in range(4):
        for t in range(2):
            speed = 150.0 + 60.0 * k + 20.0 * t
            trial = Trial(kind="tracks", name=f"t{t}", fps=FS, animal=Animal(id=f"m{k}"),
                          belt_speed=speed, tracks_file="x.nc")  # fmt: skip
            walk = Walk(speed=speed, period=0.3 - 0.0003 * speed)
            parts.append(analyse(walk.tracks(duration=0.8, noise=0.2, seed=k), trial=trial))
            groups[f"m{k}", f"t{t}"] = "ab"[k % 2]
    return pool(parts), groups


def pose():
    tracks = make_tracks([4], ["L1", "L1.BC"], fps=100, views=["top"], space=("x", "y"))
    tracks["image_position"].data[0, 0, :, :, 0] = [[0.0, 8.0], [25.0, 20.0]]
    return tracks


def methods():
    rows = [("a", "paper", 3.0, 5.0), ("b", "slic-3d", 9.0, 4.0)]
    trials = pd.DataFrame(rows, columns=["trial", "method", "major_per_1000", "minor_per_1000"])
    trials = trials.assign(time_s_per_1000=60.0, major_alone_per_1000=4.0, minor_alone_per_1000=6.0)
    columns = ["trial", "method", "view", "point", "kind", "n", "mean_px"]
    return trials, pd.DataFrame([("a", "paper", "c", "FR", "front", 9, 2.0)], columns=columns)


def frames(tables):
    return figures.build_template_fit_table(
        np.arange(40), np.column_stack((WAVE[:40], WAVE[40:80])),
        np.column_stack((WAVE[:40], WAVE[40:80])) + 1.0, used=(0, 20), foretold=(20, 30),
    )  # fmt: skip


OTHERS = {
    "animal_presence": lambda _: figures.build_animal_presence_table(
        np.arange(6), [0, 5, 4, 90, 80, 6], threshold=9.5, has_animal=[0, 0, 0, 1, 1, 0]
    ),
    "bland_altman": lambda t: figures.build_bland_altman_table(
        t.strides, t.strides.assign(duty_factor=t.strides["duty_factor"] + WAVE[: len(t.strides)]),
        measures=["duty_factor"],
    ),
    "compare_methods": lambda _: figures.build_compare_methods_table(*methods()),
    "filter_effect": lambda _: figures.build_filter_effect_table(WAVE, fs_hz=FS, cutoff_hz=12.0),
    "joint_ranges": lambda _: figures.build_joint_ranges_table(ANGLES),
    "leg_angles": lambda _: pd.DataFrame({"time_s": T, "leg": "L2", "leg_angle": WAVE}),
    "paths_3d": lambda _: figures.build_paths_3d_table(PLACES),
    "pose_overlay": lambda _: figures.build_pose_overlay_table(pose(), frame=4),
    "residual_analysis": lambda _: figures.build_residual_analysis_table(
        pd.DataFrame({"L1": WAVE}), fs_hz=FS
    ),
    "scaling": lambda _: figures.build_scaling_table(SPECIES, size="mass", value="speed"),
    "template_fit": frames,
}  # fmt: skip
OF_ANALYSIS = sorted(
    name.removeprefix("plot_")
    for name in figures.__all__
    if name.startswith("plot_") and name.removeprefix("plot_") not in OTHERS
)
"""Figures that pawnb gait makes of its tables; a new one is tested as soon as it is there."""


def saved(make, folder):
    """Draw and save a figure; return the bytes of each file and of its table."""
    folder.mkdir()
    try:
        with figures.style():
            table, ax = make()
            files = save_figure(ax, folder / "one", record={"figure": "one"})
    finally:
        plt.close("all")
    return [path.read_bytes() for path in (*files, write_table(table, folder / "one.csv"))]


def check_same(make, tmp_path, monkeypatch):
    # png is the picture; that svg and pdf carry no time or chance is tested with the style
    monkeypatch.setattr(save_figures, "FORMATS", ("png",))
    figures.set_style(dpi=60)  # a seventh of the time
    try:
        assert saved(make, tmp_path / "first") == saved(make, tmp_path / "second")
    finally:
        figures.set_style()


@pytest.mark.slow
@pytest.mark.parametrize("kind", OF_ANALYSIS)
def test_figures_of_an_analysis_are_the_same_each_time(tables, kind, tmp_path, monkeypatch):
    analysis, groups = tables
    of_study = overview_drawings(analysis, groups=groups)
    drawings = itertools.chain(gait_drawings(analysis, groups=groups), of_study)
    drawing = next(one for one in drawings if one.kind == kind)
    check_same(drawing.draw, tmp_path, monkeypatch)


@pytest.mark.slow
def test_other_figures_are_identical_elsewhere_and_in_another_process(tables, tmp_path):
    """Of each its png, svg and pdf, and of a figure that takes a second table."""
    own = tmp_path / "own"
    figures.set_style(dpi=60)  # a seventh of the time
    try:
        for kind, build in OTHERS.items():
            draw_figure(kind, build(tables[0]), own / kind)
        events = tables[0].events.query("animal == 'm0' and trial == 't0'")
        options = {"events": events.assign(leg="L2")}
        draw_figure("leg_angles", OTHERS["leg_angles"](None), own / "with", **options)
        draw_figure("filter_effect", OTHERS["filter_effect"](None), own / "unit", unit="mm")
    finally:
        figures.set_style()
        plt.close("all")
    assert (own / "with_events.csv").exists()
    moved = own.rename(tmp_path / "moved")
    pictures = sorted(str(path) for path in moved.iterdir() if path.suffix != ".csv")
    assert len(pictures) == 3 * (len(OTHERS) + 2)
    done = subprocess.run(
        [sys.executable, "-m", "pawnb", "reproduce", *pictures], cwd=tmp_path, text=True,
        capture_output=True, check=False,
        env={**os.environ, "PYTHONPATH": str(Path(pawnb.__file__).parents[1])},
    )  # fmt: skip
    assert done.stdout.splitlines()[:-1] == [f"{path}: identical" for path in pictures], done.stderr
    table = moved / "scaling.csv"
    table.write_text(table.read_text().replace("30.0", "31.0"))
    with pytest.raises(InputError, match=r"scaling\.csv has changed since scaling\.png was made"):
        pawnb.reproduce(moved / "scaling.png")


def test_what_no_recipe_can_hold_is_one_sentence(tmp_path):
    table = OTHERS["animal_presence"](None)
    with pytest.raises(InputError, match=r"no figure 'animal_presense' \(did you mean 'animal_p"):
        draw_figure("animal_presense", table, tmp_path / "x")
    with pytest.raises(InputError, match="animal_presence has no option 'unit'; it takes none"):
        draw_figure("animal_presence", table, tmp_path / "x", unit="px")
    with pytest.raises(InputError, match="picture is a ndarray, which no recipe can hold"):
        draw_figure("pose_overlay", table, tmp_path / "x", picture=WAVE)
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_every_table_is_the_same_each_time(tables, tmp_path):
    analysis, groups = tables

    def written(folder):
        folder.mkdir()
        shuffled = dict(sorted(groups.items(), reverse=folder.name == "second"))
        found, _ = statistics_tables(analysis, groups=shuffled, angles=ANGLES)
        found |= coordination_tables(analysis)
        found |= {name: getattr(analysis, name) for name in ("events", "strides", "phases")}
        found |= {"phase_summary": analysis.phase_summary, "dropped": analysis.dropped}
        return {n: write_table(t, folder / f"{n}.csv").read_bytes() for n, t in found.items()}

    first, second = written(tmp_path / "first"), written(tmp_path / "second")
    assert len(first) >= 15
    assert first == second
    assert compare_legs(analysis.strides) == compare_legs(analysis.strides)
