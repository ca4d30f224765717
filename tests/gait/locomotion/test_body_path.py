"""An animal that drifts on its belt: strides against those of the synthetic mouse that does not.

The paths of the feet are those of the rendered scene's model of gait, seen from the side in px;
drift, noise and gaps are added. The constants were set before; the forms of drift and the seed
here are others than those on which the way was first tried.
"""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from scipy.signal import find_peaks

from pawnb.gait import analyse
from pawnb.gait.events.event_settings import EventSettings
from pawnb.gait.locomotion.body_path import is_carried, is_roaming, points_of_body
from pawnb.gait.locomotion.foot_trajectories import FootPaths, get_foot_paths
from pawnb.io.formats import read_any_tracks
from pawnb.kinematics import smooth_path
from pawnb.schema import ORIGIN_CODE, make_tracks
from pawnb.synthetic.gait_model import plan_gait
from pawnb.synthetic.scene import LEGS, SceneSettings
from pawnb.synthetic.truth import paw_positions

pytestmark = pytest.mark.slow  # scenes are rendered and tracked

FS, FRAMES, PX = 100.0, 400, 3.0
T = np.arange(FRAMES) / FS
DRIFTS_MM = {
    "none": 0 * T,
    "slow": 55 * np.sin(2 * np.pi * 0.2 * T + 1) + 20 * np.sin(2 * np.pi * 0.45 * T),
    "to and fro": 40 * np.sin(2 * np.pi * 0.6 * T),
    "steady": 50 * T,
    "falls back and catches up": np.interp(
        T, [0, 1.4, 1.8, 3.2, 3.6, 9], [55, -60, 60, -50, 50, 50]
    ),
}


def recording(drift, *, points=(), belt=True, noise_px=1.0, seed=7):
    """Tracks of four feet and other points; ``belt=False``: the same animal on the ground."""
    scene = SceneSettings(belt_speed_mm_s=250.0, fps=FS, seed=seed, drift_mm=5.0)
    gait = plan_gait(scene, FRAMES / FS)
    now = gait.earliest_s + T
    feet = paw_positions(gait, scene, now)
    body = gait.body.value("forward", now)
    rng = np.random.default_rng(seed)
    paths = {leg: feet[:, k, [0, 2]] for k, leg in enumerate(LEGS)}
    shoulder = {leg: body + (15.5 if leg[0] == "F" else -18.5) for leg in LEGS}
    known = {
        "snout": np.stack([body + 45, 0 * T + 20], 1),
        "tailbase": np.stack([body - 42, 0 * T + 25], 1),
        "knee HR": np.stack([0.7 * paths["HR"][:, 0] + 0.3 * shoulder["HR"], 0 * T + 9], 1),
        "corner": np.stack([120 - DRIFTS_MM[drift], 0 * T], 1),
    }
    paths |= {name: known[name] for name in points}
    tracks = make_tracks(np.arange(FRAMES), list(paths), fps=FS, space=("x", "y"), unit="px")
    moved = DRIFTS_MM[drift] + (0.0 if belt else 250.0 * T)
    for k, path in enumerate(paths.values()):
        xy = np.stack([300 + PX * (path[:, 0] + moved), 200 - PX * path[:, 1]], axis=1)
        xy += noise_px * rng.standard_normal(xy.shape)
        if k % 2:
            start = int(rng.integers(50, FRAMES - 50))
            xy[start : start + 4] = np.nan
        tracks["position"].data[:, :, k, 0] = xy
    tracks["confidence"].data[:] = 1.0
    tracks["origin"].data[:] = ORIGIN_CODE["measured"]
    return tracks


@pytest.mark.parametrize("belt_speed", [None, 250.0 * PX])
@pytest.mark.parametrize("points", [(), ("snout", "tailbase", "knee HR", "corner")])
@pytest.mark.parametrize("drift", ["slow", "to and fro", "steady", "falls back and catches up"])
def test_a_drifting_animal_keeps_its_strides(drift, points, belt_speed):
    clean = analyse(recording("none"), legs=LEGS, belt_speed=belt_speed)
    tables = analyse(recording(drift, points=points), legs=LEGS, belt_speed=belt_speed)
    # 0 to 35 of these were found, with negative speeds where no belt speed was given
    assert len(tables.strides) >= 0.95 * len(clean.strides) > 50
    assert (tables.strides["speed"] > 0).all()
    for name, atol in (("duty_factor", 0.01), ("frequency_hz", 0.1), ("contact_duty_factor", 0.03)):
        assert tables.strides[name].mean() == pytest.approx(clean.strides[name].mean(), abs=atol)
    (said,) = [note for note in tables.notes if "drifts in the picture, as on a treadmill" in note]
    assert ("'snout', 'tailbase'" in said) == bool(points)
    assert "corner" not in said
    assert "knee" not in said
    method = tables.events.loc[tables.events["event"] == "AEP", "method"].iloc[0]
    assert method == f"fore-aft position ({'other points' if points else 'mean of the feet'})"
    if belt_speed is None:
        assert tables.strides["speed"].mean() == pytest.approx(250.0 * PX, rel=0.05)


@pytest.mark.parametrize("points", [(), ("snout",)])
@pytest.mark.parametrize("drift", ["none", "to and fro"])
def test_feet_land_at_the_same_places_about_the_body_whatever_they_are_seen_from(drift, points):
    scene = SceneSettings(belt_speed_mm_s=250.0, fps=FS, seed=7, drift_mm=5.0)
    gait = plan_gait(scene, FRAMES / FS)
    ahead = PX * paw_positions(gait, scene, gait.earliest_s + T)[:, :, 0]
    ahead -= ahead.mean()
    stride = int(FS / 4.6)
    strides = analyse(recording(drift, points=points), legs=LEGS).strides.groupby("leg")
    for k, leg in enumerate(LEGS):
        for column, sign in (("aep_position", 1), ("pep_position", -1)):
            peaks, _ = find_peaks(sign * ahead[:, k], distance=stride // 2)
            truth = np.median(ahead[peaks, k])
            assert strides[column].median()[leg] == pytest.approx(truth, abs=5 * PX)


def test_without_drift_the_feet_are_seen_from_the_laboratory():
    tables = analyse(recording("none", points=("snout", "tailbase")), legs=LEGS)
    assert "fore-aft position (laboratory)" in set(tables.events["method"])
    assert not any("drifts" in note for note in tables.notes)


def test_the_same_animal_on_the_ground_is_on_the_ground():
    tables = analyse(recording("none", points=("snout", "tailbase"), belt=False), legs=LEGS)
    assert not any("belt" in note or "drifts" in note for note in tables.notes)
    assert tables.strides["speed"].mean() == pytest.approx(250.0 * PX, rel=0.05)
    # speeding up and slowing down changes nothing of that
    slow = analyse(recording("slow", belt=False), legs=LEGS)
    assert not any("belt" in note for note in slow.notes)
    assert len(slow.strides) > 0.8 * len(tables.strides)


@pytest.mark.parametrize(("belt", "carried"), [(True, True), (False, False)])
def test_a_belt_carries_the_feet_that_stand_on_it(belt, carried):
    (feet,) = get_foot_paths(recording("slow", belt=belt), {leg: leg for leg in LEGS})
    path = smooth_path(feet.positions, cutoff_hz=1.5, fs_hz=FS)
    assert is_carried(feet, path, EventSettings()) is carried
    brief, way = feet.positions[:15], path[:15]
    cut = type(feet)(source=feet.source, unit=feet.unit, legs=feet.legs, positions=brief)
    assert is_carried(cut, way, EventSettings()) is None


def test_only_points_that_move_with_the_body_stand_for_it():
    names = ("snout", "tailbase", "knee HR", "corner")
    tracks = recording("slow", points=names)
    (feet,) = get_foot_paths(tracks, {leg: leg for leg in LEGS})
    (others,) = get_foot_paths(tracks, {name: name for name in names})
    found = points_of_body(feet, others, frequency_hz=4.6, fs_hz=FS)
    assert found is not None
    assert found.legs == ("snout", "tailbase")
    assert points_of_body(feet, None, frequency_hz=4.6, fs_hz=FS) is None
    assert points_of_body(feet, others, frequency_hz=np.nan, fs_hz=FS) is None


@pytest.mark.parametrize("mouse", ["15_25mm_run3-6", "18_25mm_run2-6"])
@pytest.mark.parametrize("stated", [True, False])
def test_real_mice_put_on_a_belt_keep_the_strides_they_have_on_the_ground(real_data, mouse, stated):
    """Runs over a beam, seen from the side, with a belt's speed taken off every position: the
    mice speed up and slow down, so that they drift. The strides on the ground are the truth."""
    legs = {"FR": "Front paw tao", "HR": "Hind paw tao"}
    (file,) = real_data("mouse-autogaita-beam").glob(f"*Mouse{mouse}*200000.csv")
    tracks = read_any_tracks(file, fps=100.0)
    ground = analyse(tracks, legs=legs).strides
    usual = float(ground["speed"].median())
    carried = tracks.copy(deep=True)
    step = xr.DataArray(usual * tracks["time"].to_numpy(), dims="time")
    hind = tracks["position"].sel(keypoint="Hind paw tao").isel(individual=0, space=0)
    sure = tracks["confidence"].sel(keypoint="Hind paw tao").isel(individual=0) > 0.9
    seen = hind.to_numpy()[sure.to_numpy()]
    towards = float(np.sign(np.median(seen[-100:]) - np.median(seen[:100])))
    first = tracks["space"].to_numpy()[0]
    carried["position"] = tracks["position"] - towards * step * (tracks["space"] == first)
    found = analyse(
        carried, legs=legs, forward=(towards, 0.0), belt_speed=usual if stated else None
    ).strides
    assert abs(len(found) - len(ground)) <= 1 < 0.2 * len(ground)
    assert found["speed"].median() == pytest.approx(usual, rel=0.1)
    assert found["duty_factor"].mean() == pytest.approx(ground["duty_factor"].mean(), abs=0.02)


def test_a_circle_of_five_reaches_is_roaming_one_of_three_and_a_long_line_are_not():
    # feet 1 from the body: the circle's width is its diameter, that of a line is 0
    turn = np.linspace(0.0, 2 * np.pi, 200)
    circle = np.column_stack((np.cos(turn), np.sin(turn)))
    reach = np.array([[1.0, -1.0, 0.0, 0.0], [0.0, 0.0, 1.0, -1.0]])
    for path, roams in (
        (2.5 * circle, True),
        (1.5 * circle, False),
        (circle * [100.0, 1.5], False),
    ):
        feet = FootPaths(
            source="position", unit="mm", legs=("FR", "HR", "FL", "HL"),
            positions=path[:, :, None] + reach,
        )  # fmt: skip
        assert is_roaming(feet, path) is roams
