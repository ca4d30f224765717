"""Tracks, table columns and settings: what is right passes, what is wrong is named."""

from __future__ import annotations

import json
from dataclasses import dataclass

import numpy as np
import pandas as pd
import pytest

from pawnb import schema
from pawnb.core.paws.maghsoudi2019.settings import Maghsoudi2019Settings
from pawnb.core.paws.offline.settings import OfflineSettings
from pawnb.core.pose.fit.settings import PoseSettings
from pawnb.core.pose.pullar2009.settings import Pullar2009Settings
from pawnb.core.pose.space.settings import SpaceSettings
from pawnb.errors import InputError


def test_new_tracks_follow_their_own_schema():
    tracks = schema.make_tracks([5, 6, 7], ["FR", "HR"], fps=250, views=["a", "b"], unit="mm")
    assert schema.check_tracks(tracks) is tracks
    assert tracks.sizes == {
        "time": 3, "space": 3, "keypoint": 2, "individual": 1, "view": 2, "image_space": 2,
    }  # fmt: skip
    np.testing.assert_allclose(tracks.time, [0.020, 0.024, 0.028])
    assert np.isnan(tracks.position).all()
    assert (tracks.origin == schema.ORIGIN_CODE["missing"]).all()
    assert tracks.origin.attrs["flag_meanings"].split() == list(schema.ORIGINS)


def test_time_stamps_replace_frame_over_fps():
    tracks = schema.make_tracks([0, 1], ["p"], fps=100, time_s=np.array([0.0, 0.013]))
    assert tracks.time.to_numpy().tolist() == [0.0, 0.013]


def test_every_fault_of_tracks_is_named_at_once():
    tracks = schema.make_tracks([0], ["p"], fps=100).drop_vars(["origin", "frame"])
    tracks["position"] = tracks["position"].transpose("space", "time", "keypoint", "individual")
    tracks.attrs["fps"] = 0
    with pytest.raises(InputError) as caught:
        schema.check_tracks(tracks, where="x.nc")
    assert str(caught.value) == (
        "x.nc: not Tracks as pawnb writes them: no variable 'origin'; 'position' has dimensions "
        "('space', 'time', 'keypoint', 'individual') instead of ('time', 'space', 'keypoint', "
        "'individual'); attribute fps is 0 instead of a positive number; no coordinate 'frame' "
        "along time. Make them with pawnb.schema.make_tracks or a reader of pawnb.io."
    )
    with pytest.raises(InputError, match=r"expected Tracks .* found dict"):
        schema.check_tracks({})


def test_provenance_grows_and_leaves_the_old_tracks_alone():
    old = schema.make_tracks([0], ["p"], fps=100)
    new = schema.add_provenance(
        schema.add_provenance(old, step="track", method="paper"), step="edit"
    )
    steps = json.loads(new.attrs["provenance"])["steps"]
    assert steps == [{"method": "paper", "step": "track"}, {"step": "edit"}]
    assert old.attrs["provenance"] == "{}"


def test_a_missing_column_names_the_likely_one():
    table = pd.DataFrame({"frame": [0], "view": ["a"], "points": ["FR"], "u": [1], "v": [2]})
    with pytest.raises(InputError) as caught:
        schema.check_columns(table, schema.START_COLUMNS, where="start.csv")
    assert str(caught.value) == (
        "start.csv: column 'point' is missing (is it in column 'points'?); expected frame, view, "
        "point, u, v, found frame, view, points, u, v."
    )
    assert schema.check_columns(table, ["u", "v"], where="x") is table


def test_phase_summary_has_animals_first_then_strides():
    # design, section 5: the second set of columns has the same names with _strides
    first = schema.PHASE_SUMMARY_COLUMNS[4:12]
    assert schema.PHASE_SUMMARY_COLUMNS[:4] == ("leg", "reference", "n", "n_animals")
    assert schema.PHASE_SUMMARY_COLUMNS[12:20] == tuple(f"{name}_strides" for name in first)
    further = ("moore_r", "moore_p", "note", "r_low", "r_high", "r_low_strides", "r_high_strides")
    assert schema.PHASE_SUMMARY_COLUMNS[20:] == further


@dataclass(frozen=True)
class Example:
    count: int = 1
    weights: tuple[float, ...] = (1.0,)
    window: tuple[int, int] = (70, 40)
    limit: float | None = None
    mode: str = "a"
    on: bool = False


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ({}, Example()),
        ({"count": "3"}, Example(count=3)),
        ({"count": 3.0}, Example(count=3)),
        ({"weights": "[2, 0, 4]"}, Example(weights=(2.0, 0.0, 4.0))),
        ({"window": [1, 2]}, Example(window=(1, 2))),
        ({"limit": "2.5", "mode": "b"}, Example(limit=2.5, mode="b")),
        ({"limit": "none"}, None),
        ({"limit": None, "on": "True"}, Example(on=True)),
        ({"mode": "3"}, Example(mode="3")),
    ],
)
def test_plain_values_become_settings(values, expected):
    if expected is None:
        with pytest.raises(InputError, match="limit is 'none'; expected a number"):
            schema.build_settings(Example, values, where="--set")
    else:
        assert schema.build_settings(Example, values, where="--set") == expected


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (
            {"cout": 1},
            "--set: unknown name 'cout' (did you mean 'count'?); known are count, limit, mode, "
            "on, weights, window.",
        ),
        ({"count": 1.5}, "--set: count is 1.5; expected a whole number."),
        ({"count": True}, "--set: count is True; expected a whole number."),
        ({"weights": 3}, "--set: weights is 3; expected a list, each item a number."),
        ({"window": [1]}, "--set: window is [1]; expected a list of 2, each a whole number."),
        ({"on": 1}, "--set: on is 1; expected true or false."),
        ({"mode": 3}, "--set: mode is 3; expected text."),
    ],
)
def test_settings_that_make_no_sense_are_refused(values, message):
    with pytest.raises(InputError) as caught:
        schema.build_settings(Example, values, where="--set")
    assert str(caught.value) == message


def test_attributes_of_tracks_are_those_of_the_contract():
    # design.md, section 2: fps, units, provenance as one JSON string
    tracks = schema.make_tracks([0], ["FR"], fps=250, views=["a"], unit="mm")
    assert tracks.attrs["fps"] == 250.0
    assert tracks.attrs["units"] == tracks["position"].attrs["units"] == "mm"
    assert tracks["image_position"].attrs["units"] == "px"
    assert isinstance(tracks.attrs["provenance"], str)


@pytest.mark.parametrize(
    ("cls", "value"),
    [
        (OfflineSettings, {"max_hypotheses": -4}),
        (OfflineSettings, {"noise": 0.0}),
        (OfflineSettings, {"occlusion_onset_cost": float("nan")}),
        (Maghsoudi2019Settings, {"scale": 0.0}),
        (PoseSettings, {"candidates": -1}),
        (PoseSettings, {"working_span_px": float("inf")}),
        (Pullar2009Settings, {"steepness": -0.1}),
        (SpaceSettings, {"length_sd": 0.0}),
    ],
)
def test_settings_out_of_range_are_refused_by_every_tracker(cls, value):
    name = next(iter(value))
    with pytest.raises(InputError, match=rf"{name}'? is .*; expected a number"):
        schema.build_settings(cls, value, where="settings")
    schema.build_settings(cls, {}, where="settings")  # the defaults are within


def test_stride_limits_that_leave_nothing_between_are_refused():
    with pytest.raises(InputError, match="'shortest_stride_s' is 2, not below"):
        OfflineSettings(shortest_stride_s=2.0)


def seconds(tracks, times):
    return tracks.assign_coords(time=times)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        # what pandas makes of times; taken as numbers, strides would last nanoseconds
        (lambda t: seconds(t, pd.to_timedelta(t.time, unit="s")), "times are of type timedelta64"),
        (lambda t: seconds(t, t.frame.to_numpy()), "times run at 1 frames a second instead of 250"),
        (lambda t: seconds(t, 1000.0 * t.time.to_numpy()), "times run at 0.25 frames a second"),
        (lambda t: t.drop_vars("time"), "no coordinate 'time' in seconds"),
        (lambda t: t.isel(space=[1, 0, 2]), "'space' is y, x, z instead of x, y, z"),
        (lambda t: t.sel(space=["x", "z"]), "'space' is x, z instead of x, y\\."),
        (lambda t: t.isel(image_space=[1, 0]), "'image_space' is v, u instead of u, v"),
        (lambda t: t.assign_coords(keypoint=["FR", "FR"]), "keypoint 'FR' is there twice"),
        (lambda t: t.assign_coords(individual=[7]), "names along 'individual' are no text"),
        (lambda t: t.assign_attrs(provenance="{"), "attribute provenance is no JSON object"),
        (lambda t: t.assign_attrs(provenance="[]"), "attribute provenance is no JSON object"),
    ],
)
def test_tracks_whose_labels_were_changed_are_refused(change, message):
    tracks = schema.make_tracks(range(9), ["FR", "HR"], fps=250, views=["a"])
    with pytest.raises(InputError, match=message):
        schema.check_tracks(change(tracks))


def test_time_stamps_of_a_film_and_frames_between_are_fine():
    tracks = schema.make_tracks([3, 5, 7, 13], ["FR"], fps=250, time_s=np.array([0, 2, 5, 9]) / 90)
    assert schema.check_tracks(tracks) is tracks
    schema.check_tracks(tracks.assign_coords(space=["X", "Y", "Z"], frame=tracks.frame * 1.0))


@pytest.mark.parametrize(
    ("frames", "points", "message"),
    [
        ([0, 1.5], ["FR"], r"frames hold 1\.5; expected whole numbers"),
        (["0", "1"], ["FR"], r"frames are '0' \.\.\.; expected whole numbers"),
        ([0, 1], "FR", r"points is 'FR'; expected a list of names, as \['FR'\]"),
    ],
)
def test_new_tracks_of_what_is_no_frame_or_no_list_are_refused(frames, points, message):
    with pytest.raises(InputError, match=message):
        schema.make_tracks(frames, points, fps=250)


def test_what_is_no_table_or_has_a_column_twice_is_refused():
    table = pd.DataFrame({"leg": ["FR"], "phase": [0.5]})
    with pytest.raises(InputError, match=r"^x: expected a table \(pandas.DataFrame\), found dict"):
        schema.check_columns(table.to_dict(), ["leg"], where="x")
    twice = pd.concat([table, table[["leg"]]], axis=1)
    with pytest.raises(InputError, match=r"^x: column 'leg' is there twice; keep one of them"):
        schema.check_columns(twice, ["leg"], where="x")
    schema.check_columns(twice, ["phase"], where="x")


def test_settings_that_are_no_names_and_values_are_refused():
    with pytest.raises(InputError, match=r"^gait: settings are 'x'; expected names and values"):
        schema.build_settings(Example, "x", where="gait")
