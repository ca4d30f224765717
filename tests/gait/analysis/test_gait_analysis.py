"""The whole analysis: walks with known answers, real steps, bad input."""

from __future__ import annotations

import dataclasses

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from walking import Walk

from pawnb.errors import InputError, InputWarning
from pawnb.gait import EventSettings, analyse, analyse_events, pool
from pawnb.schema import (
    DROPPED_COLUMNS,
    EVENTS_COLUMNS,
    PHASE_SUMMARY_COLUMNS,
    PHASES_COLUMNS,
    STRIDES_COLUMNS,
    make_tracks,
)
from pawnb.trial import Animal, Calibration, Trial, View

DURATION = 3.0
DUTIES = [0.5, 0.6, 0.75]


def make_trial(**fields):
    base = {"kind": "tracks", "name": "t1", "fps": 250.0, "animal": Animal(id="m07")}
    return Trial(**{**base, **fields})


def event_errors(tables, walk, *, event, fps=250.0):
    """Differences to the nearest exact event, in frames."""
    which = {"AEP": 0, "PEP": 1, "TD": 0, "LO": 1}[event]
    kind = walk.exact_extremes if event in ("AEP", "PEP") else walk.exact_contacts
    errors = []
    for leg in walk.phases:
        exact = kind(leg, DURATION + 1)[which]
        own = tables.events.query("leg == @leg and event == @event")["time_s"].to_numpy()
        assert len(own) >= len(kind(leg, DURATION)[which]) - 2
        errors += [(t - exact[np.argmin(np.abs(exact - t))]) * fps for t in own]
    return np.array(errors)


@pytest.mark.slow
@pytest.mark.parametrize("duty", DUTIES)
@pytest.mark.parametrize("treadmill", [True, False])
def test_known_walk_with_noise(duty, treadmill):
    walk = Walk(duty=duty)
    belt = walk.speed if treadmill else None
    tables = analyse(walk.tracks(treadmill=treadmill, noise=0.5), belt_speed=belt)
    for event in ("AEP", "PEP"):
        errors = event_errors(tables, walk, event=event)
        assert abs(np.median(errors)) < 0.5
        assert np.abs(errors).max() < 2.5
    assert tables.strides["duty_factor"].mean() == pytest.approx(walk.exact_duty, abs=0.01)
    assert tables.strides["period_s"].mean() == pytest.approx(walk.period, rel=0.002)
    assert tables.strides["speed"].mean() == pytest.approx(walk.speed, rel=0.01)
    assert tables.strides["stride_length"].mean() == pytest.approx(90.0, rel=0.01)
    assert tables.strides["step_displacement"].mean() == pytest.approx(90.0, rel=0.01)
    summary = tables.phase_summary.set_index(["leg", "reference"])
    diagonal = {("FR", "HL"): 0.0, ("FL", "HR"): 0.0}
    other = dict.fromkeys([("FL", "FR"), ("HL", "HR"), ("FR", "HR"), ("FL", "HL")], 0.5)
    for pair, phase in {**diagonal, **other}.items():
        error = (summary.loc[pair, "mean_strides"] - phase + 0.5) % 1 - 0.5
        assert error == pytest.approx(0.0, abs=0.02)
        assert summary.loc[pair, "pattern_strides"] == ("anti-phase" if phase else "in-phase")
    method = tables.events.query("event == 'AEP'")["method"].iloc[0]
    assert method == f"fore-aft position ({'laboratory' if treadmill else 'mean of the feet'})"


@pytest.mark.slow
@pytest.mark.parametrize("duty", DUTIES)
def test_ground_and_treadmill_agree(duty):
    walk = Walk(duty=duty)
    belt, ground = (
        analyse(walk.tracks(treadmill=t, noise=0.2), belt_speed=walk.speed if t else None)
        for t in (True, False)
    )
    assert len(belt.strides) == len(ground.strides)
    np.testing.assert_allclose(
        belt.strides["duty_factor"], ground.strides["duty_factor"], atol=0.01
    )
    np.testing.assert_allclose(belt.strides["period_s"], ground.strides["period_s"], atol=0.002)
    # legs of a diagonal step together: whether the last AEP falls into the last stride is chance
    both = belt.phases.merge(ground.phases, on=["leg", "reference", "stride"])
    assert len(both) >= len(belt.phases) - 4
    difference = both["phase_x"].to_numpy() - both["phase_y"].to_numpy()
    np.testing.assert_allclose((difference + 0.5) % 1 - 0.5, 0.0, atol=0.01)


@pytest.mark.slow
def test_contact_lies_between_the_extremes_and_the_truth():
    # a minimum-jerk foot creeps in and out of contact; see find_contacts for what is left
    walk = Walk(duty=0.6)
    tables = analyse(walk.tracks(noise=0.2), belt_speed=walk.speed)
    down = event_errors(tables, walk, event="TD")
    up = event_errors(tables, walk, event="LO")
    assert -3.5 < np.median(down) < 0.0
    assert 0.0 < np.median(up) < 3.5
    contact = tables.strides["contact_duty_factor"].mean()
    assert walk.duty < contact < walk.exact_duty - 0.02
    assert set(tables.events.query("event == 'TD'")["method"]) == {"foot speed and height"}
    flat = analyse(walk.tracks(noise=0.2), belt_speed=walk.speed, settings={"use_height": False})
    assert set(flat.events.query("event == 'TD'")["method"]) == {"foot speed"}


def test_events_alternate_within_each_leg():
    tables = analyse(Walk().tracks(noise=2.0, seed=3), belt_speed=300.0)
    for pair in (("AEP", "PEP"), ("TD", "LO")):
        for _, own in tables.events[tables.events["event"].isin(pair)].groupby("leg"):
            names = own["event"].to_numpy()
            assert (own["time_s"].diff().dropna() > 0).all()
            assert (names[1:] != names[:-1]).all()


def test_tables_have_their_columns_and_frames_match_times():
    tables = analyse(Walk().tracks(first_frame=100), belt_speed=300.0, trial=make_trial())
    for table, columns in (
        (tables.events, EVENTS_COLUMNS), (tables.strides, STRIDES_COLUMNS),
        (tables.phases, PHASES_COLUMNS), (tables.phase_summary, PHASE_SUMMARY_COLUMNS),
        (tables.dropped, DROPPED_COLUMNS),
    ):  # fmt: skip
        assert list(table.columns)[: len(columns)] == list(columns)
    np.testing.assert_allclose(tables.events["frame"] / 250.0, tables.events["time_s"])
    assert tables.events["frame"].min() > 100
    assert set(tables.strides["animal"]) == {"m07"}
    assert set(tables.strides["trial"]) == {"t1"}
    assert list(dict.fromkeys(tables.events["leg"])) == ["FR", "HR", "FL", "HL"]


@pytest.mark.slow
@settings(max_examples=8, deadline=None)
@given(st.floats(0.01, 100), st.integers(0, 5000), st.floats(-1000, 1000))
def test_unit_start_and_place_change_nothing(scale, first, place):
    walk = Walk(duty=0.65, phases={"FR": 0.0, "HR": 0.47, "FL": 0.5, "HL": 0.03})
    base = analyse(walk.tracks(duration=1.5), belt_speed=300.0)
    other = analyse(
        walk.tracks(duration=1.5, scale=scale, first_frame=first, origin=(place, 2 * place, 0.0)),
        belt_speed=300.0 * scale,
    )
    for name in ("duty_factor", "period_s", "contact_duty_factor"):
        np.testing.assert_allclose(base.strides[name], other.strides[name], atol=1e-6)
    np.testing.assert_allclose(
        base.strides["start_s"] + first / 250, other.strides["start_s"], atol=1e-6
    )
    np.testing.assert_allclose(
        scale * base.strides["stride_length"], other.strides["stride_length"], rtol=1e-6
    )
    np.testing.assert_allclose(base.phases["phase"], other.phases["phase"], atol=1e-6)


@pytest.mark.parametrize("angle", [0.0, 60.0, 135.0, 180.0, 270.0])
def test_direction_of_travel_is_found_on_the_ground(angle):
    axis = (np.cos(np.radians(angle)), np.sin(np.radians(angle)), 0.0)
    tables = analyse(Walk().tracks(treadmill=False, axis=axis))
    assert tables.strides["duty_factor"].mean() == pytest.approx(Walk().exact_duty, abs=0.01)
    assert tables.strides["speed"].mean() == pytest.approx(300.0, rel=0.01)


def test_drift_adds_to_the_belt():
    tables = analyse(Walk().tracks(drift=30.0), belt_speed=300.0)
    assert tables.strides["speed"].mean() == pytest.approx(330.0, rel=0.01)


def test_belt_that_speeds_up():
    frames = np.arange(750)
    table = pd.DataFrame({"frame": frames[::-1], "speed": (280.0 + frames * 40.0 / 749)[::-1]})
    tables = analyse(Walk().tracks(), belt_speed=table)
    assert tables.strides["speed"].mean() == pytest.approx(300.0, rel=0.02)
    own = tables.strides.query("leg == 'FR'")
    assert own["speed"].iloc[-1] - own["speed"].iloc[0] == pytest.approx(
        40.0 / 3.0 * (own["start_s"].iloc[-1] - own["start_s"].iloc[0]), rel=0.05
    )


@pytest.mark.slow
def test_belt_speed_in_another_unit_is_noticed():
    tables = analyse(Walk().tracks(), belt_speed=0.3)  # m/s where positions are mm
    assert any("check belt_speed and its unit" in note for note in tables.notes)
    # contact does not suffer: it is told from the feet's own stance
    right = analyse(Walk().tracks(), belt_speed=300.0)
    assert tables.strides["contact_duty_factor"].mean() == pytest.approx(
        right.strides["contact_duty_factor"].mean(), abs=0.01
    )
    assert not any("belt" in note for note in right.notes)


def test_unknown_belt_speed_comes_from_the_feet():
    tables = analyse(Walk().tracks())
    assert any("taken from the feet in stance" in note for note in tables.notes)
    assert tables.strides["speed"].mean() == pytest.approx(300.0, rel=0.01)


@pytest.mark.slow
def test_short_gaps_are_bridged_and_marked_long_ones_drop_strides():
    walk = Walk(duty=0.6)
    tracks = walk.tracks()
    frame = round(walk.exact_extremes("FR", DURATION)[0][3] * 250)
    tracks["position"].data[frame - 3 : frame + 3, :, 0, 0] = np.nan
    bridged = analyse(tracks, belt_speed=300.0)
    whole = analyse(walk.tracks(), belt_speed=300.0)
    assert len(bridged.strides) == len(whole.strides)
    marked = bridged.events[bridged.events["method"].str.contains("bridged gap")]
    assert marked[["leg", "event"]].to_numpy().tolist() == [["FR", "AEP"]]
    assert abs(marked["frame"].iloc[0] - frame) < 3

    tracks["position"].data[frame - 15 : frame + 15, :, 0, 0] = np.nan
    gappy = analyse(tracks, belt_speed=300.0)
    lost = gappy.dropped.query("leg == 'FR'")
    assert len(whole.strides) - len(gappy.strides) >= 2
    assert (lost["what"] == "track").sum() == 1
    assert (
        lost.query("what == 'track'")["why"].iloc[0].startswith("not tracked for 30 frames; gaps")
    )
    assert lost.query("what == 'stride'")["why"].str.contains("not tracked for 0.12").any()
    # no stride of the rest pretends to run across the gap
    own = gappy.strides.query("leg == 'FR'")
    assert own["period_s"].max() < 1.1 * walk.period


def test_one_frame_without_a_foot_is_one_frame():
    tracks = Walk().tracks()
    tracks["position"].data[0, :, 0, 0] = np.nan
    why = analyse(tracks, belt_speed=300.0).dropped.query("what == 'track'")["why"]
    assert why.tolist() == ["not tracked for 1 frame at the start"]


def test_hiding_half_of_a_swing_gives_no_event_there():
    walk = Walk(duty=0.6)
    tracks = walk.tracks()
    for lift in walk.exact_contacts("HR", DURATION)[1]:
        a = round(lift * 250)
        tracks["position"].data[a - 4 : a + 12, :, 1, 0] = np.nan
    tables = analyse(tracks, belt_speed=300.0)
    assert tables.strides.query("leg == 'HR'").empty
    assert (tables.dropped.query("leg == 'HR'")["what"] == "track").sum() >= 8
    assert len(tables.strides.query("leg == 'FL'")) >= 7


@pytest.mark.slow
def test_jumps_of_the_tracker_are_left_out_and_reported():
    tracks = Walk().tracks(noise=0.2)
    tracks["position"].data[[100, 333, 334, 500], :, 2, 0] += 40.0
    tables = analyse(tracks, belt_speed=300.0)
    jumps = tables.dropped.query("what == 'position'")
    assert jumps["leg"].tolist() == ["FL"] * 3
    np.testing.assert_allclose(jumps["start_s"] * 250, [100, 333, 500])
    clean = analyse(Walk().tracks(noise=0.2), belt_speed=300.0)
    np.testing.assert_allclose(
        tables.strides["duty_factor"], clean.strides["duty_factor"], atol=0.02
    )
    kept = analyse(tracks, belt_speed=300.0, settings={"jump_factor": None})
    assert kept.dropped.query("what == 'position'").empty


def test_body_points_give_the_frame():
    walk = Walk(duty=0.6)
    legs = walk.tracks(treadmill=False)
    frames = legs["frame"].to_numpy()
    turn = 0.6 * frames / frames[-1]  # the animal turns by 34 degrees on its way
    body = make_tracks(frames, ["rump", "nose"], fps=250.0, unit="mm")
    centre = walk.speed * frames / 250.0
    for k, ahead in enumerate((-30.0, 30.0)):
        body["position"].data[:, 0, k, 0] = centre + ahead
        body["position"].data[:, 1:, k, 0] = 0.0
    body["confidence"].data[:] = 1.0
    tracks = xr.concat([legs, body], dim="keypoint", join="outer")
    tracks.attrs = legs.attrs
    spin = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    about = np.stack([centre, 0 * centre])  # turn every point about the body's centre
    xy = tracks["position"].data[:, :2, :, 0] - about.T[:, :, None]
    tracks["position"].data[:, :2, :, 0] = np.einsum("ijn,njk->nik", spin, xy) + about.T[:, :, None]
    trial = make_trial(animal=Animal(id="a", body=("rump", "nose")))
    tables = analyse(tracks, trial=trial)
    assert set(tables.strides["leg"]) == {"FR", "HR", "FL", "HL"}
    extremes = tables.events.query("event == 'AEP'")
    assert set(extremes["method"]) == {"fore-aft position (body points)"}
    assert tables.strides["duty_factor"].mean() == pytest.approx(walk.exact_duty, abs=0.01)
    # the same stance, seen from the body: 40 mm further forward for the fore feet
    positions = extremes.groupby(extremes["leg"].str[0])["position"].mean()
    assert positions["F"] - positions["H"] == pytest.approx(40.0, abs=0.5)


def image_tracks(walk, *, mirrored):
    """Two uncalibrated side views, each of two feet; the second shows the animal mirrored."""
    source = walk.tracks(treadmill=True)
    views = ("cam1", "cam3")
    tracks = make_tracks(source["frame"].to_numpy(), list(walk.phases), fps=250.0, views=views)
    for k, leg in enumerate(walk.phases):
        view = 0 if leg.endswith("R") else 1
        sign = -1.0 if view == 1 and mirrored else 1.0
        path = source["position"].to_numpy()[:, :, k, 0]
        tracks["image_position"].data[:, view, 0, k, 0] = 600 + sign * 4.0 * path[:, 0]
        tracks["image_position"].data[:, view, 1, k, 0] = 500 - 4.0 * path[:, 2]
        tracks["image_confidence"].data[:, view, k, 0] = 1.0
    return tracks


@pytest.mark.parametrize("told", [True, False])
def test_uncalibrated_views_each_have_their_direction(told):
    walk = Walk(duty=0.6)
    views = tuple(
        View(name=n, video=f"{n}.avi", facing=f if told else None)
        for n, f in (("cam1", 1), ("cam3", -1))
    )
    trial = make_trial(kind="paws", views=views, belt_speed=300.0)
    tables = analyse(image_tracks(walk, mirrored=True), trial=trial)
    assert tables.strides["duty_factor"].mean() == pytest.approx(walk.exact_duty, abs=0.01)
    # the belt's mm/s mean nothing in px: 4 px per mm in these pictures
    assert tables.strides["speed"].mean() == pytest.approx(1200.0, rel=0.01)
    faces = [n for n in tables.notes if "faces" in n]
    assert len(faces) == (0 if told else 2)
    if not told:
        assert "faces right" in faces[0]
        assert "faces left" in faces[1]
    summary = tables.phase_summary.set_index(["leg", "reference"])
    assert summary.loc[("FL", "FR"), "mean_strides"] == pytest.approx(0.5, abs=0.01)


def test_wrong_direction_is_questioned():
    trial = make_trial(
        calibration=Calibration(dlt="d.csv", forward=(-1.0, 0.0, 0.0)), belt_speed=300.0
    )
    tables = analyse(Walk().tracks(), trial=trial)
    assert any("the wrong way round?" in note for note in tables.notes)


@pytest.mark.slow
def test_frames_left_out_and_uneven_times():
    walk = Walk(duty=0.6)
    whole = walk.tracks()
    keep = np.delete(np.arange(750), [50, 51, 300, 601])
    tables = analyse(whole.isel(time=keep), belt_speed=300.0)
    assert tables.strides["duty_factor"].mean() == pytest.approx(walk.exact_duty, abs=0.01)

    # the same walk, sampled at uneven times: the true times count, not the frame numbers
    fine = walk.tracks(fps=2500.0)
    rng = np.random.default_rng(0)
    index = np.sort(rng.choice(7000, 900, replace=False))
    uneven = fine.isel(time=index).assign_coords(frame=("time", np.arange(900)))
    uneven.attrs["fps"] = 900 / 2.8
    tables = analyse(uneven, belt_speed=300.0)
    assert tables.strides["period_s"].mean() == pytest.approx(0.3, rel=0.005)
    assert tables.strides["duty_factor"].mean() == pytest.approx(walk.exact_duty, abs=0.02)
    every_other = walk.tracks().isel(time=slice(None, None, 2))
    assert len(analyse(every_other, belt_speed=300.0).strides) == len(
        analyse(walk.tracks(), belt_speed=300.0).strides
    )


@pytest.mark.slow
def test_several_individuals_are_several_animals():
    a, b = Walk().tracks(), Walk(duty=0.75).tracks(seed=1)
    both = xr.concat([a, b.assign_coords(individual=["other"])], dim="individual")
    both.attrs = a.attrs
    tables = analyse(both, belt_speed=300.0)
    duty = tables.strides.groupby("animal")["duty_factor"].mean()
    assert duty["animal"] == pytest.approx(Walk().exact_duty, abs=0.01)
    assert duty["other"] == pytest.approx(Walk(duty=0.75).exact_duty, abs=0.01)
    assert (tables.phase_summary["n_animals"] == 2).all()


def test_a_leg_that_is_never_seen_is_reported():
    tracks = Walk().tracks()
    tracks["position"].data[:, :, 3, 0] = np.nan
    tables = analyse(tracks, belt_speed=300.0)
    assert ["HL", "leg", "never seen"] in tables.dropped[["leg", "what", "why"]].to_numpy().tolist()
    assert set(tables.strides["leg"]) == {"FR", "HR", "FL"}


@pytest.mark.slow
def test_names_of_legs_may_differ_from_points():
    tracks = Walk().tracks().assign_coords(keypoint=["rf", "rh", "lf", "lh"])
    legs = {"FR": "rf", "HR": "rh", "FL": "lf", "HL": "lh"}
    tables = analyse(tracks, belt_speed=300.0, legs=legs)
    assert list(dict.fromkeys(tables.strides["leg"])) == ["FR", "HR", "FL", "HL"]
    trial = make_trial(tracks_file="x.csv", tracks_legs=legs, belt_speed=300.0)
    assert len(analyse(tracks, trial=trial).strides) == len(tables.strides)


@pytest.mark.slow
def test_result_is_the_same_every_time():
    one, two = (analyse(Walk().tracks(noise=1.0), belt_speed=300.0) for _ in range(2))
    for name in ("events", "strides", "phases", "phase_summary", "dropped"):
        pd.testing.assert_frame_equal(getattr(one, name), getattr(two, name))


@pytest.mark.slow
def test_pooling_counts_animals_and_refuses_doubles():
    parts = [
        analyse(Walk().tracks(seed=i, noise=0.5), belt_speed=300.0,
                trial=make_trial(name=f"t{i}", animal=Animal(id=f"m{i // 2}")))
        for i in range(4)
    ]  # fmt: skip
    pooled = pool(parts)
    assert len(pooled.strides) == sum(len(p.strides) for p in parts)
    assert (pooled.phase_summary["n_animals"] == 2).all()
    assert pooled.phase_summary["rayleigh_p"].notna().all()
    with pytest.raises(InputError, match=r"^animal 'm0', trial 't0' is there twice; give every"):
        pool([parts[0], parts[0]])
    other = dataclasses.replace(parts[1], settings=EventSettings(use_height=False))
    with pytest.raises(InputError, match=r"^the analyses were made with different settings"):
        pool([parts[0], other])
    with pytest.raises(InputError, match=r"^nothing to pool"):
        pool([])


# ---- events scored by hand -------------------------------------------------------------


def tardigrade(real_data):
    folder = real_data("tardigrade-8leg-events")
    return pd.read_csv(folder / "events_long.csv"), pd.read_csv(folder / "step_timing.csv")


DOWN_UP = {"down": "TD", "up": "LO"}


def test_every_step_of_the_tardigrade_is_reproduced(real_data):
    scored, published = tardigrade(real_data)
    tables = analyse_events(scored, event_names=DOWN_UP)
    assert len(published) == 95
    found = tables.strides.sort_values(["leg", "start_s"]).reset_index(drop=True)
    expected = published.sort_values(["legID", "DownTime"]).reset_index(drop=True)
    merged = expected.merge(
        found,
        left_on=["legID", expected["DownTime"].round(3)],
        right_on=["leg", found["start_s"].round(3)],
    )
    assert len(merged) == 95 == len(found)
    for ours, theirs in (
        ("stance_s", "stance"), ("swing_s", "swing"), ("period_s", "gait"), ("duty_factor", "duty"),
    ):  # fmt: skip
        np.testing.assert_allclose(merged[ours], merged[theirs], atol=1e-3)
    # a twin with one touch-down two thousandths late is noticed
    late = scored.copy()
    late.loc[late["event"] == "down", "time_s"] += 0.002
    again = analyse_events(late, event_names=DOWN_UP).strides
    assert np.abs(again["stance_s"].to_numpy() - tables.strides["stance_s"].to_numpy()).min() > 1e-3


def test_events_may_lack_what_can_be_filled_in():
    rows = [("FR", e, t) for e, t in (("TD", 0.1), ("LO", 0.2), ("TD", 0.4), ("LO", 0.5))]
    tables = analyse_events(pd.DataFrame(rows, columns=["leg", "event", "time_s"]))
    assert tables.strides["duty_factor"].tolist() == pytest.approx([1 / 3])
    assert tables.events["method"].unique().tolist() == ["scored"]
    assert tables.strides["speed"].isna().all()
    assert any("no pair of legs" in note for note in tables.notes)


@pytest.mark.slow
def test_written_events_give_the_same_strides():
    tables = analyse(Walk().tracks(noise=0.5), belt_speed=300.0)
    again = analyse_events(tables.events)
    columns = ["leg", "stride", "start_s", "period_s", "duty_factor", "contact_duty_factor"]
    pd.testing.assert_frame_equal(again.strides[columns], tables.strides[columns])
    pd.testing.assert_frame_equal(again.phases, tables.phases)


# ---- bad input ---------------------------------------------------------------------------


def bad(**changes):
    rows = {"leg": ["FR", "FR"], "event": ["TD", "LO"], "time_s": [0.1, 0.2]}
    return pd.DataFrame({**rows, **changes})


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: analyse_events(bad().drop(columns="event")), r"^events: column 'event' is"),
        (lambda: analyse_events(bad(event=["TD", "down"])), r"^events: unknown event 'down'; "
         r"expected AEP, PEP, TD, LO \(touch-down is TD, lift-off LO\)\. Say what it means"),
        (lambda: analyse_events(bad(time_s=["0.1", "x"])), r"^events: time_s in row 2 is 'x'; "),
        (lambda: analyse_events(bad().iloc[:0]), r"^events: the table has no rows"),
        (lambda: analyse(Walk().tracks(), legs=["FR", "XX"]),
         r"^leg 'XX': the tracks have no point 'XX'"),
        (lambda: analyse(Walk().tracks(), legs="FR"), r"^legs is 'FR'; expected a list of names"),
        (lambda: analyse_events(bad(event=["down", "LO"]), event_names={"down": "landing"}),
         r"^event_names: 'landing' is no event; expected AEP, PEP, TD, LO"),
        (lambda: analyse(Walk().tracks(), pairs=[("FR", "RF")]), r"^pairs: no leg 'RF'"),
        (lambda: analyse(Walk().tracks(), pairs=[("FR", "FR")]), r"^pairs: \('FR', 'FR'\) is"),
        (lambda: analyse(Walk().tracks(), forward=[1, 0]),
         r"^forward is \[1\.0, 0\.0\]; expected 3 numbers"),
        (lambda: analyse(Walk().tracks(), belt_speed=float("nan")), r"^belt_speed: a speed is"),
        (lambda: analyse(Walk().tracks(), belt_speed=pd.DataFrame({"frame": [0], "speed": [1]})),
         r"^belt_speed: frames 0 to 0; expected all from 0 to 749\.$"),
        (lambda: analyse(Walk().tracks(), trial=make_trial(belt_speed="no.csv")),
         r"no\.csv: no such table of belt speed; mend \[treadmill\] belt_speed\.$"),
        (lambda: analyse(Walk().tracks().assign_coords(keypoint=list("abcd"))),
         r"^these tracks: none of the points a, b, c, d is named like a leg"),
        (lambda: analyse(Walk().tracks().isel(time=[1, 0, 2])), r"frame 0 comes after frame 1"),
        (lambda: analyse(Walk().tracks().isel(time=[0, 1])), r"^these tracks: 2 frames; expec"),
        (lambda: analyse(Walk().tracks(), settings={"min_confidence": 1.0, "max_gap": 3}),
         r"^gait: unknown name 'max_gap' \(did you mean 'max_gap_s'\?\)"),
        (lambda: analyse(Walk().tracks().drop_vars("origin")), r"not Tracks as pawnb writes them"),
    ],
)  # fmt: skip
def test_bad_input_is_one_sentence(call, message):
    with pytest.raises(InputError, match=message):
        call()


def test_tracks_without_any_position_are_refused():
    tracks = Walk().tracks()
    tracks["position"].data[:] = np.nan
    with pytest.raises(
        InputError, match=r"^animal 'animal': none of the legs FR, HR, FL, HL has a"
    ):
        analyse(tracks, belt_speed=300.0)


def test_a_table_of_belt_speed_that_is_none_is_said(tmp_path):
    (tmp_path / "belt.csv").write_text("frame,speed\n0,fast\n")
    trial = Trial(
        kind="tracks", name="t", fps=250.0, animal=Animal(id="a"), folder=tmp_path,
        belt_speed="belt.csv",
    )  # fmt: skip
    with pytest.raises(InputError, match=r"^belt\.csv: line 2, column 'speed' is 'fast'"):
        analyse(Walk().tracks(), trial=trial)


@pytest.mark.slow
def test_a_note_on_one_of_several_animals_says_whose_it_is():
    tracks = Walk().tracks(treadmill=True)
    short = tracks.copy(deep=True).assign_coords(individual=["brief"])
    short["position"].data[5:] = np.nan
    both = xr.concat([tracks, short], dim="individual", combine_attrs="override")
    (slow,) = [note for note in analyse(both, belt_speed=300.0).notes if "no stride freq" in note]
    assert slow.startswith("trial: brief: FR, HR, FL, HL (position): no stride frequency found")
    alike = xr.concat(
        [tracks, tracks.assign_coords(individual=["twin"])],
        dim="individual",
        combine_attrs="override",
    )
    assert analyse(alike, belt_speed=300.0).notes == analyse(tracks, belt_speed=300.0).notes


@pytest.mark.slow
def test_what_is_shown_of_the_tables_is_short_however_many_there_are():
    walk = Walk(duty=0.6)
    trials = [make_trial(animal=Animal(id=f"m{k}")) for k in range(3)]
    tracks = walk.tracks(treadmill=True)
    parts = [analyse(tracks, trial=trial, belt_speed=walk.speed) for trial in trials]
    tables = pool(parts)
    shown = repr(tables)
    assert len(shown) < 200
    assert shown.startswith("GaitTables(3 trials of 3 animals; events: ")
    assert f"strides: {len(tables.strides)} rows" in shown
    assert "corrected" not in shown


def test_a_trial_of_another_frame_rate_than_its_tracks_is_said():
    tracks = Walk().tracks()
    with pytest.warns(InputWarning, match="has 24 frames/s and these tracks 250: times are those"):
        analyse(tracks, trial=make_trial(fps=24.0))


@pytest.mark.slow
def test_a_belt_speed_in_another_unit_than_px_is_told_where_it_is_not_used():
    tracks = Walk().tracks(treadmill=True)
    tracks.attrs["units"] = "px"
    (said,) = (n for n in analyse(tracks, belt_speed=30.0).notes if "belt speed about" in n)
    assert "because the stated one, 30, does not fit them in px/s" in said
    (said,) = (n for n in analyse(tracks).notes if "belt speed about" in n)
    assert "because none is known in px/s" in said
