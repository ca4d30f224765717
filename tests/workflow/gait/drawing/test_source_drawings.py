"""Figures of the tracks and of groups that pawnb gait draws, from paths that are known."""

from __future__ import annotations

import dataclasses

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
from test_gait_run import walking_tracks

from pawnb import schema
from pawnb.core.paws.maghsoudi2019.template import load_template
from pawnb.errors import InputError
from pawnb.gait import analyse, pool
from pawnb.trial import Animal, Trial
from pawnb.workflow.gait.drawing.drawings import gait_drawings
from pawnb.workflow.gait.drawing.source_drawings import SourceTracks, source_drawings

mpl.use("Agg")

FPS, HIDDEN = 250.0, (180, 195)
LEGS = {"FR": "FR", "HR": "HR"}


@pytest.fixture(autouse=True)
def closed_figures():
    yield
    plt.close("all")


def seen_tracks(*, hidden=HIDDEN):
    """Two paws that step as the template does, in one view; FR is predicted for 15 frames."""
    frames = np.arange(300)
    tracks = schema.make_tracks(frames, list(LEGS), fps=FPS, views=["cam1"])
    for k, kind in enumerate(("front", "hind")):
        template = load_template().kinds[kind]
        path = template.spline((frames / FPS / template.period_s + 0.3) % 1.0)
        tracks["image_position"].data[:, 0, :, k, 0] = [500.0, 300.0] + 120.0 * path * [-1.0, 1.0]
        tracks["image_confidence"].data[:, 0, k, 0] = 1.0
    tracks["image_origin"].data[:] = schema.ORIGIN_CODE["measured"]
    if hidden is not None:
        tracks["image_origin"].data[hidden[0] : hidden[1], 0, 0, 0] = schema.ORIGIN_CODE["resolved"]
    return tracks


def drawings(tracks, **options):
    source = SourceTracks(tracks=tracks, animal="m1", trial="t1", legs=LEGS)
    return {one.name: one for one in source_drawings([source], **options)}


def test_template_foretells_what_was_hidden():
    found = drawings(seen_tracks())
    assert list(found) == ["template_fit_m1_t1"]
    table, ax = found["template_fit_m1_t1"].draw()
    assert set(table["leg"]) == {"FR"}
    foretold = table[table["part"] == "foretold"]
    assert foretold["frame"].tolist() == list(range(*HIDDEN))
    # the paw steps as the template does, facing left: half a percent of its 120 px
    off = np.hypot(foretold["u"] - foretold["u_fit"], foretold["v"] - foretold["v_fit"])
    assert off.max() < 3.0
    used = table[table["part"] == "used for the fit"]
    assert used["frame"].max() == HIDDEN[0] - 1
    period = load_template().kinds["front"].period_s * FPS
    assert len(used) == pytest.approx(period, abs=1)
    assert ax.get_ylabel() == "u (px)"
    assert ax.get_title(loc="right") == "FR, view cam1"


def test_a_paw_that_was_never_hidden_shows_the_fit_to_its_last_stride():
    table, _ = drawings(seen_tracks(hidden=None))["template_fit_m1_t1"].draw()
    assert set(table["part"]) == {"used for the fit", "other"}
    assert table["frame"].max() == 299


def test_a_paw_that_stands_has_no_fit():
    tracks = seen_tracks()
    tracks["image_position"].data[:] = 7.0
    with pytest.raises(InputError, match=r"^template fit: \wR hardly moved in view cam1"):
        drawings(tracks)["template_fit_m1_t1"].draw()
    tracks["image_origin"].data[:] = schema.ORIGIN_CODE["missing"]
    with pytest.raises(InputError, match=r"^template fit: no paw was tracked for a whole stride"):
        drawings(tracks)["template_fit_m1_t1"].draw()


def test_paths_in_space_have_the_names_of_the_legs():
    tracks = walking_tracks("t1", "m1").assign_coords(keypoint=["a", "b", "FL", "HL"])
    legs = {"FR": "a", "HR": "b"}
    source = SourceTracks(tracks=tracks, animal="m1", trial="t1", legs=legs)
    (found,) = source_drawings([source])
    table, _ = found.draw()
    assert found.name == "paths_3d_m1_t1"
    assert table["point"].unique().tolist() == ["FR", "HR"]
    own = tracks["position"].sel(keypoint="a", space="x").to_numpy().ravel()
    np.testing.assert_allclose(table.loc[table["point"] == "FR", "x"], own, atol=1e-6)


@pytest.mark.slow
def test_groups_are_drawn_side_by_side():
    parts, groups = [], {}
    for group, belt in (("control", 300.0), ("lesion", 300.0)):
        for k in range(3):
            animal = f"{group}{k}"
            trial = Trial(kind="tracks", name="t", fps=FPS, animal=Animal(id=animal),
                          belt_speed=belt, tracks_file="x.nc")  # fmt: skip
            tracks = walking_tracks("t", animal)
            tracks = tracks.assign_coords(individual=[animal])
            parts.append(analyse(tracks, trial=dataclasses.replace(trial)))
            groups[animal, "t"] = group
    tables = pool(parts)
    names = {one.name: one for one in gait_drawings(tables, groups=groups)}
    wanted = {f"estimation_{m}" for m in ("speed", "frequency_hz", "stride_length", "duty_factor")}
    assert wanted <= set(names)
    table, ax = names["estimation_duty_factor"].draw()
    assert ax.get_ylabel() == "Duty factor (fraction)"
    difference = table[table["row"] == "difference"].iloc[0]
    assert (difference["group"], difference["n_animals"]) == ("lesion", 6)
    assert not wanted & {one.name for one in gait_drawings(tables)}
    one_group = dict.fromkeys(groups, "control")
    assert not wanted & {one.name for one in gait_drawings(tables, groups=one_group)}


def test_ranges_of_joints_are_drawn_where_there_are_angles():
    rows = [("a", "t", "L1", "BC", f, 10.0 * np.sin(f / 5)) for f in range(60)]
    columns = ["animal", "trial", "leg", "joint", "frame", "angle_deg"]
    found = drawings(seen_tracks(), angles=pd.DataFrame(rows, columns=columns))
    table, _ = found["joint_ranges"].draw()
    assert table["range_mean_deg"].max() == pytest.approx(20.0, abs=0.2)
