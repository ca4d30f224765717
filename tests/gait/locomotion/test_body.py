"""An animal that wanders, stops and goes: heading from its body, strides from its bouts only."""

import numpy as np
import pandas as pd
import pytest
from walking import Walk

from pawnb import gait
from pawnb.gait.analysis.leg_names import guess_body
from pawnb.io.formats import read_any_tracks
from pawnb.kinematics import is_wandering
from pawnb.schema import ORIGIN_CODE, make_tracks

FS, PERIOD_S, DUTY, SPEED = 100.0, 0.25, 0.6, 300.0
LAG = {"FL": 0.0, "FR": 0.5, "HL": 0.5, "HR": 0.0}
PLACE = {"FL": (30.0, -10.0), "FR": (30.0, 10.0), "HL": (-30.0, -12.0), "HR": (-30.0, 12.0)}
PAUSES_S = ((3.0, 5.0), (8.0, 9.5))


def wanderer(duration_s=12.0):
    """A trot along a circle of 400 px radius, standing still in the pauses, feet never slipping.

    The animal's own clock runs only while it goes; feet rest on the ground in stance and are
    carried to their next place in swing.
    """
    t = np.arange(0, duration_s, 1 / FS)
    going = np.ones(len(t), dtype=bool)
    for start, stop in PAUSES_S:
        going[(t >= start) & (t < stop)] = False
    clock = np.concatenate(([0.0], np.cumsum(going[:-1] / FS)))
    bend = SPEED * clock / 400.0

    def placed(at_clock, offset):
        turn = SPEED * at_clock / 400.0
        centre = np.stack([400 * np.sin(turn), 400 * (1 - np.cos(turn))], axis=-1)
        along = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
        across = np.stack([-np.sin(turn), np.cos(turn)], axis=-1)
        return centre + offset[0] * along + offset[1] * across

    points = {"snout": placed(clock, (60.0, 0.0)), "tailbase": placed(clock, (-45.0, 0.0))}
    for leg, lag in LAG.items():
        cycle = clock / PERIOD_S - lag
        k, x = np.floor(cycle), np.mod(cycle, 1.0)

        # a foothold is where the foot's place under the body is at mid-stance
        def hold(number, lag=lag, leg=leg):
            return placed((number + lag + DUTY / 2) * PERIOD_S, PLACE[leg])

        s = np.clip((x - DUTY) / (1 - DUTY), 0, 1)[:, None]
        ease = s**3 * (10 - 15 * s + 6 * s**2)
        points[leg] = hold(k) * (1 - ease) + hold(k + 1) * ease
    tracks = make_tracks(range(len(t)), list(points), fps=FS, space=("x", "y"))
    for i, place in enumerate(points.values()):
        tracks["position"][:, :, i, 0] = place
    tracks["origin"][:] = ORIGIN_CODE["measured"]
    tracks["confidence"][:] = 1.0
    return tracks, bend


def test_strides_of_a_wanderer_are_found_in_its_bouts_only():
    tracks, _ = wanderer()
    tables = gait.analyse(tracks)
    strides = tables.strides
    np.testing.assert_allclose(strides["period_s"], PERIOD_S, atol=0.02)
    assert len(strides) > 4 * 20
    end = strides["start_s"] + strides["period_s"]
    for start, stop in PAUSES_S:
        assert not ((strides["start_s"] < stop) & (end > start)).any()
    why = tables.dropped
    assert (why["what"] == "pause").sum() >= 4 * len(PAUSES_S)
    assert why["why"].str.contains("the animal stands").any()
    assert any("bouts of locomotion" in note for note in tables.notes)
    assert any("from 'tailbase' to 'snout'" in note for note in tables.notes)
    lags = tables.phase_summary.set_index(["leg", "reference"])["mean"]
    assert lags["FL", "FR"] == pytest.approx(0.5, abs=0.02)
    assert min(lags["FL", "HR"], 1 - lags["FL", "HR"]) < 0.02


def test_without_bouts_strides_reach_into_the_pauses():
    tracks, _ = wanderer()
    strides = gait.analyse(tracks, settings={"bouts": False}).strides
    assert strides["period_s"].max() > 1.0


def test_what_is_a_wanderer_and_what_is_a_body():
    tracks, _ = wanderer()
    names = [str(k) for k in tracks["keypoint"].to_numpy()]
    body = tracks["position"].isel(individual=0).to_numpy()[:, :, [1, 0]]
    assert is_wandering(body)
    assert not is_wandering(body[:40])  # a straight piece
    assert guess_body(names) == ("tailbase", "snout")
    assert guess_body(["Snout", "Butt/Proximal Tail", "Tail tip"]) == (
        "Butt/Proximal Tail", "Snout",
    )  # fmt: skip
    assert guess_body(["nose", "tail tip"]) is None


@pytest.mark.slow
def test_a_real_mouse_in_an_open_field_trots(real_data):
    """Mixed behaviour, DeepLabCut: in its bouts left and right alternate, diagonals go together
    (Hildebrand 1965: trot; mice at these speeds trot, Bellardita & Kiehn 2015)."""
    tracks = read_any_tracks(real_data("mouse-openfield-dlc") / "raw_clip1DLC.csv", fps=60.0)
    tables = gait.analyse(tracks)
    lags = tables.phase_summary.set_index(["leg", "reference"])["mean_strides"]
    for pair in (("FL", "FR"), ("HL", "HR")):
        assert lags[pair] == pytest.approx(0.5, abs=0.05)
    for pair in (("FR", "HL"), ("FL", "HR")):
        assert abs((lags[pair] + 0.5) % 1 - 0.5) < 0.12
    assert 2.5 < tables.strides["frequency_hz"].median() < 6.0
    assert len(tables.strides) > 200


def test_a_ball_that_stops_and_changes_speed_is_told_from_the_feet():
    # a tethered animal: its clock runs at 1, stands from 2 to 3 s, then runs at 0.5
    walk = Walk(period=0.25, duty=0.7, speed=200.0)
    t = np.arange(0, 6.0, 1 / FS)
    rate = np.select([t < 2.0, t < 3.0], [1.0, 0.0], 0.5)
    clock = np.concatenate(([0.0], np.cumsum(rate[:-1] / FS)))
    legs = list(walk.phases)
    tracks = make_tracks(range(len(t)), legs, fps=FS, space=("x", "y"), unit="mm")
    for k, leg in enumerate(legs):
        tracks["position"].data[:, 0, k, 0] = walk.foot(leg, clock)[0] - walk.speed * clock
        tracks["position"].data[:, 1, k, 0] = 10.0 * k
    tracks["origin"][:] = ORIGIN_CODE["measured"]
    tracks["confidence"][:] = 1.0
    tables = gait.analyse(tracks, settings={"substrate": "treadmill"})
    pause = tables.dropped[tables.dropped["what"] == "pause"]
    assert pause["start_s"].min() == pytest.approx(2.0, abs=0.2)
    assert pause["end_s"].max() == pytest.approx(3.0, abs=0.2)
    early = tables.strides[tables.strides["start_s"] < 1.6]
    late = tables.strides[tables.strides["start_s"] > 3.5]
    assert early["speed"].mean() == pytest.approx(200.0, rel=0.03)
    assert late["speed"].mean() == pytest.approx(100.0, rel=0.03)
    # one stride is 50 mm long at either speed; seven tenths of it the foot is down
    assert tables.strides["stride_length"].median() == pytest.approx(50.0, rel=0.03)
    assert early["contact_duty_factor"].mean() == pytest.approx(0.7, abs=0.05)
    assert late["contact_duty_factor"].mean() == pytest.approx(0.7, abs=0.05)
    assert any("belt speed about" in note for note in tables.notes)
    # with a belt that is stated nothing of the kind is assumed
    told = gait.analyse(tracks, belt_speed=200.0)
    assert not (told.dropped["what"] == "pause").any()


def ankles():
    """Points halfway between foot and body; the animal goes from 3 to 6 s and from 11 s on."""
    walk = Walk(period=1.0, speed=100.0)
    t = np.arange(0, 15.0, 1 / 25.0)
    going = (t >= 3.0) & (t < 6.0) | (t >= 11.0)
    clock = np.concatenate(([0.0], np.cumsum(going[:-1] / 25.0)))
    tracks = make_tracks(range(len(t)), list(walk.phases), fps=25.0, space=("x", "y"))
    rng = np.random.default_rng(0)
    for k, leg in enumerate(walk.phases):
        along = (walk.foot(leg, clock)[0] + walk.speed * clock) / 2 + 40.0 * (leg[0] == "F")
        path = np.column_stack((along, np.full(len(t), 15.0 if "L" in leg else -15.0)))
        tracks["position"].data[:, :, k, 0] = path + 2.0 * rng.standard_normal(path.shape)
    tracks["confidence"].data[:] = 1.0
    tracks["origin"].data[:] = ORIGIN_CODE["measured"]
    return tracks


def test_going_and_standing_is_not_taken_for_strides():
    """What the ankles share outweighs their steps, and in stance they go forwards, not at rest."""
    tables = gait.analyse(ankles())
    assert tables.strides["frequency_hz"].median() == pytest.approx(1.0, rel=0.1)
    assert len(tables.strides) >= 12
    assert any("2 bouts of locomotion" in note for note in tables.notes)


def test_a_belt_whose_speed_cannot_be_told_leaves_lengths_open():
    settings = {"substrate": "treadmill", "min_excursion": 20.0}
    strides = gait.analyse(ankles(), settings=settings).strides
    assert len(strides) >= 12
    assert strides[["speed", "stride_length", "step_length"]].isna().all(axis=None)


@pytest.mark.parametrize("smooth", [1, 9])
@pytest.mark.parametrize("belt_speed", [0.0, 200.0])
def test_feet_that_step_together_keep_their_frequency(smooth, belt_speed):
    """Hopping at 2.5 strides a second: feet part by what labels jitter, slowly or not."""
    t, f, fps = np.arange(0, 6.0, 0.01), 2.5, 100.0
    cycle = (t * f) % 1
    rng = np.random.default_rng(3)
    tracks = make_tracks(range(len(t)), ["HL", "HR"], fps=fps, space=("x", "y"))
    for k in range(2):
        x = np.where(cycle < 0.5, 20 - 80 * cycle, 80 * cycle - 60) + (200 - belt_speed) * t
        path = np.column_stack((x, np.full(len(t), 15.0 - 30.0 * k)))
        jitter = rng.standard_normal((len(t) + smooth - 1, 2))
        kernel = np.full(smooth, smooth**-0.5)
        path += np.stack([np.convolve(j, kernel, "valid") for j in jitter.T], axis=1)
        tracks["position"].data[:, :, k, 0] = path
    tracks["confidence"].data[:] = 1.0
    tracks["origin"].data[:] = ORIGIN_CODE["measured"]
    strides = gait.analyse(tracks).strides
    assert len(strides) >= 20
    assert strides["frequency_hz"].median() == pytest.approx(f, rel=0.05)


@pytest.mark.parametrize("stated", [True, False])
def test_a_belt_that_stops_makes_pauses_though_labels_jitter(stated):
    # the clock of walk and belt stands from 2 to 3 s and from 5 to 6.5 s; jitter of 0.3 mm at 200
    # frames a second moves standing feet by a quarter of the belt's speed, to and fro
    fs, walk = 200.0, Walk(period=0.25, duty=0.6, speed=300.0)
    t = np.arange(0, 8.5, 1 / fs)
    stands = ((t >= 2) & (t < 3)) | ((t >= 5) & (t < 6.5))
    clock = np.concatenate(([0.0], np.cumsum(~stands[:-1] / fs)))
    tracks = make_tracks(range(len(t)), list(walk.phases), fps=fs, space=("x", "y"), unit="mm")
    jitter = np.random.default_rng(0)
    for k, leg in enumerate(walk.phases):
        tracks["position"].data[:, 0, k, 0] = walk.foot(leg, clock)[0] - walk.speed * clock
        tracks["position"].data[:, 1, k, 0] = 10.0 * k
    tracks["position"].data[:] += 0.3 * jitter.standard_normal(tracks["position"].shape)
    tracks["origin"][:] = ORIGIN_CODE["measured"]
    tracks["confidence"][:] = 1.0
    belt = pd.DataFrame({"frame": range(len(t)), "speed": np.where(stands, 0.0, walk.speed)})
    strides = gait.analyse(tracks, belt_speed=belt if stated else None).strides
    assert len(strides) > 4 * 16
    np.testing.assert_allclose(strides["period_s"], 0.25, atol=0.01)
    np.testing.assert_allclose(strides["speed"], 300.0, rtol=0.03)


@pytest.mark.slow
def test_feet_alone_of_a_real_mouse_in_an_open_field_give_the_same_gait(real_data):
    """Without snout and tail it was taken to be on a treadmill, and had no stride at all."""
    tracks = read_any_tracks(real_data("mouse-openfield-dlc") / "raw_clip1DLC.csv", fps=60.0)
    feet = [str(k) for k in tracks["keypoint"].to_numpy() if "Paw" in str(k)]
    whole, alone = gait.analyse(tracks), gait.analyse(tracks.sel(keypoint=feet))
    assert len(alone.strides) > 0.9 * len(whole.strides)
    for name in ("period_s", "duty_factor", "speed"):
        expected = whole.strides[name].median()
        assert alone.strides[name].median() == pytest.approx(expected, rel=0.1)
    means = [
        t.phase_summary.set_index(["leg", "reference"])["mean_strides"] for t in (whole, alone)
    ]
    assert (((means[1] - means[0] + 0.5) % 1.0) - 0.5).abs().max() < 0.06
