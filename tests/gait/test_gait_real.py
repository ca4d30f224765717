"""Real recordings: events scored by hand, gait read off a figure, what rats are known to do."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from pawnb.gait import analyse, pool
from pawnb.io import authors2019
from pawnb.io.formats import read_any_tracks
from pawnb.schema import make_tracks
from pawnb.trial import Animal, Trial

FLY_LEGS = ("LF", "LM", "LH", "RF", "RM", "RH")


def tracks_of(positions, fps, unit, space=("x", "y", "z")):
    """Tracks from a mapping of leg to (n, d) positions."""
    n = len(next(iter(positions.values())))
    tracks = make_tracks(np.arange(n), list(positions), fps=fps, unit=unit, space=space)
    for k, path in enumerate(positions.values()):
        tracks["position"].data[:, :, k, 0] = path
    tracks["confidence"].data[:] = 1.0
    return tracks


@pytest.fixture
def fly(real_data):
    """A fly that walks on a ball: claws in space, and contact scored by hand."""
    folder = real_data("fly-6leg-contact")
    pose = pd.read_csv(folder / "fly1_pose_aligned.csv").iloc[:599]
    claws = {leg: pose[[f"{leg}_Claw_{a}" for a in "xyz"]].to_numpy() for leg in FLY_LEGS}
    contact = pd.read_csv(folder / "ground_truth_contact_fly1.csv")
    return tracks_of(claws, 100.0, "mm"), contact


@pytest.mark.slow
def test_contact_of_a_real_fly(fly):
    tracks, contact = fly
    events = analyse(tracks).events
    for leg in FLY_LEGS:
        change = np.diff(contact[leg].to_numpy())
        for event, sign in (("TD", 1), ("LO", -1)):
            scored = np.flatnonzero(change == sign) + 0.5
            own = events[(events["leg"] == leg) & (events["event"] == event)]
            found = own["frame"].to_numpy()
            # four of the 27 steps of RM, small ones on the spot in a slow turn, are not told
            assert len(found) >= 0.8 * len(scored)
            error = np.array([t - scored[np.argmin(np.abs(scored - t))] for t in found])
            error = error[np.abs(error) < 5]  # the scored trace of LH has long gaps
            assert len(error) >= 0.85 * len(found)
            # a swing lasts four frames of 10 ms
            assert abs(np.median(error)) < 1.3
            assert np.median(np.abs(error)) < 1.3


@pytest.mark.slow
def test_stride_frequency_and_phases_of_a_real_fly(fly):
    # lift-offs scored by hand give RF relative to LF 0.544 (r 0.94), RH to LH 0.513 (r 0.80);
    # see circular-worked-examples; AEP is another event, so the means need only be near
    tracks, contact = fly
    tables = analyse(tracks, pairs=[("RF", "LF"), ("RH", "LH")])
    summary = tables.phase_summary.set_index(["leg", "reference"])
    assert summary.loc[("RF", "LF"), "mean_strides"] == pytest.approx(0.544, abs=0.08)
    assert summary.loc[("RH", "LH"), "mean_strides"] == pytest.approx(0.513, abs=0.08)
    assert (summary["pattern_strides"] == "anti-phase").all()
    lifts = np.flatnonzero(np.diff(contact["RF"].to_numpy()) == -1)
    period = tables.strides.query("leg == 'RF'")["period_s"].median()
    assert period == pytest.approx(np.median(np.diff(lifts)) / 100, rel=0.1)


def test_landings_of_a_real_mouse_on_the_ground(real_data):
    # where the curve of FR turns level in the authors' figure x_vs_t, read by eye (+- 10 frames)
    landings = [145, 298, 475, 628, 784, 975, 1155]
    table = pd.read_csv(real_data("mouse-locomouse") / "tracks.csv")
    paws = {
        leg: table[[f"{leg}_x", f"{leg}_y_bottom"]].to_numpy() for leg in ("FR", "HR", "FL", "HL")
    }
    tables = analyse(tracks_of(paws, 400.0, "px", space=("x", "y")))
    found = tables.events.query("leg == 'FR' and event == 'TD'")["frame"].to_numpy()
    np.testing.assert_allclose(found, landings, atol=10)
    # it goes 1250 px in 1313 frames of 1/400 s
    assert tables.strides["speed"].mean() == pytest.approx(1250 / 1313 * 400, rel=0.05)
    # what was not tracked is said, and no stride runs across it
    lost = tables.dropped.query("what == 'track'")
    assert {"HR", "HL"} == set(lost["leg"])
    assert tables.strides["period_s"].max() < 0.6


@pytest.mark.slow
def test_gait_does_not_depend_on_how_the_camera_was_turned(real_data):
    # a mouse in an open field, with gaps where the network was not sure of snout, tail and paws
    tracks = read_any_tracks(real_data("mouse-openfield-dlc") / "raw_clip1DLC.csv", fps=60.0)
    place = tracks["position"].where(tracks["confidence"] >= 0.6)
    angle = np.radians(30.0)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    found = []
    for matrix in (np.eye(2), turn):
        turned = tracks.copy(deep=True)
        turned["position"].data = np.einsum("ij,tj...->ti...", matrix, place.data)
        found.append(analyse(turned).strides)
    columns = ["period_s", "duty_factor", "contact_duty_factor", "speed", "stride_length"]
    assert len(found[0]) > 200
    np.testing.assert_allclose(found[1][columns], found[0][columns], rtol=1e-6)


@pytest.mark.slow
def test_known_gait_of_real_rats(real_data):
    # trials at about 0.28 m/s; rats trot or walk there: a few strides a second, duty factor
    # between 0.5 and 0.8, left and right half a cycle apart, diagonal feet nearly together
    folder = real_data("rat-4cam-tracks")
    parts = []
    for stamp in ("2018-06-08_13_41_22", "2018-06-08_13_42_28"):
        tracks = authors2019.read_authors_trial(folder, stamp)
        trial = Trial(kind="tracks", name=stamp, fps=250.0, animal=Animal(id="rat2"))
        # feet as each camera saw them: the timing of steps needs no calibration
        parts.append(analyse(tracks, trial=trial))
    tables = pool(parts)
    assert 45 <= len(tables.strides) <= 70
    by_leg = tables.strides.groupby("leg")
    assert by_leg["frequency_hz"].mean().between(2.0, 3.0).all()
    assert by_leg["duty_factor"].mean().between(0.5, 0.8).all()
    summary = tables.phase_summary.set_index(["leg", "reference"])
    for pair in (("FL", "FR"), ("HL", "HR")):
        assert summary.loc[pair, "mean_strides"] == pytest.approx(0.5, abs=0.06)
        assert summary.loc[pair, "r_strides"] > 0.9
    for pair in (("FR", "HL"), ("FL", "HR")):
        mean = summary.loc[pair, "mean_strides"]
        near = abs(mean - round(mean))
        assert near < 0.2
        pattern = "in-phase" if near <= 0.1 else "shifted"
        assert summary.loc[pair, "pattern_strides"] == pattern
    assert (tables.phase_summary["n_animals"] == 1).all()
