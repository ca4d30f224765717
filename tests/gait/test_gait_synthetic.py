"""The synthetic mouse on its treadmill: events and duty factors against exact truth.

The rendered scene's own model of gait gives paths and events; nothing is rendered here.
Its strides vary in period, duty factor and placement, and the body wanders on the belt.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from pawnb.gait import analyse
from pawnb.schema import make_tracks
from pawnb.synthetic.gait_model import plan_gait
from pawnb.synthetic.scene import LEGS, SceneSettings
from pawnb.synthetic.truth import events_truth, paw_positions

FRAMES = 500


def recording(noise_mm, **settings):
    """Tracks of a run with noise added, and the true events."""
    scene = SceneSettings(**settings)
    gait = plan_gait(scene, FRAMES / scene.fps)
    begin = gait.earliest_s
    positions = paw_positions(gait, scene, begin + np.arange(FRAMES) / scene.fps)
    tracks = make_tracks(np.arange(FRAMES), list(LEGS), fps=scene.fps, unit="mm")
    noise = noise_mm * np.random.default_rng(1).standard_normal((FRAMES, 3, len(LEGS)))
    tracks["position"].data[..., 0] = np.moveaxis(positions, 1, 2) + noise
    tracks["confidence"].data[:] = 1.0
    truth = events_truth(gait, scene, begin_s=begin, frames=FRAMES, animal="a", trial="t")
    return scene, tracks, truth


def errors(events, truth, event):
    """Differences to the nearest true event of the same leg, in frames."""
    out = []
    for leg in LEGS:
        exact, found = (
            t.loc[(t["leg"] == leg) & (t["event"] == event), "frame"].to_numpy()
            for t in (truth, events)
        )
        assert len(exact) - 2 <= len(found) <= len(exact)
        out += [t - exact[np.argmin(np.abs(exact - t))] for t in found]
    return np.array(out)


def mean_duty(truth, begin, end):
    """Mean duty factor of all true strides."""
    out = []
    for _, own in truth.groupby("leg"):
        start, stop = (own.loc[own["event"] == e, "frame"].to_numpy() for e in (begin, end))
        pairs = pairwise(start)
        out += [(stop[stop > a][0] - a) / (b - a) for a, b in pairs]
    return np.mean(out)


@pytest.mark.parametrize("speed", [100.0, 300.0, 600.0])
@pytest.mark.parametrize("noise", [0.0, 0.5])
def test_events_of_the_synthetic_mouse(speed, noise):
    scene, tracks, truth = recording(noise, belt_speed_mm_s=speed)
    tables = analyse(tracks, belt_speed=scene.belt_speed_mm_s)
    for event, bias, worst in (("AEP", 0.2, 3), ("PEP", 0.2, 3), ("TD", 1.3, 4), ("LO", 1.3, 4)):
        found = errors(tables.events, truth, event)
        assert abs(np.median(found)) < bias, event
        assert np.abs(found).max() < worst, event
    strides = tables.strides
    assert strides["duty_factor"].mean() == pytest.approx(mean_duty(truth, "AEP", "PEP"), abs=0.01)
    contact = strides["contact_duty_factor"].mean()
    assert contact == pytest.approx(mean_duty(truth, "TD", "LO"), abs=0.04)
    assert strides["speed"].mean() == pytest.approx(speed, rel=0.05)


@pytest.mark.slow
def test_a_mouse_that_runs_the_other_way_needs_its_direction():
    scene, tracks, truth = recording(0.3, direction=-1)
    tables = analyse(tracks, belt_speed=scene.belt_speed_mm_s, forward=(-1.0, 0.0, 0.0))
    assert tables.strides["duty_factor"].mean() == pytest.approx(
        mean_duty(truth, "AEP", "PEP"), abs=0.01
    )
    wrong = analyse(tracks, belt_speed=scene.belt_speed_mm_s)
    assert any("the wrong way round?" in note for note in wrong.notes)


def stopping_dead(*, fps, frequency_hz, duty, speed=300.0, seconds=2.0):
    """Feet with a half-cosine swing in the body's frame: at touch-down they are stopped at once."""
    t = np.arange(round(seconds * fps)) / fps
    tracks = make_tracks(np.arange(len(t)), list(LEGS), fps=fps, space=("x", "y"), unit="mm")
    reach = speed / frequency_hz * duty
    for k in range(len(LEGS)):
        x = np.mod(t * frequency_hz - (0.0, 0.5, 0.47, 0.03)[k], 1.0)
        swung = (1.0 - np.cos(np.pi * np.clip((x - duty) / (1.0 - duty), 0.0, 1.0))) / 2.0
        along = reach / 2.0 - speed * np.minimum(x, duty) / frequency_hz + reach * swung
        tracks["position"].data[:, :, k, 0] = np.column_stack([along, 0.0 * t])
    tracks["confidence"].data[:] = 1.0
    return tracks


@pytest.mark.slow
def test_a_foot_that_stops_dead_is_rounded_off_by_frames_and_low_pass():
    # what is left of the duty factors' errors is known, and where it comes from: it goes away
    # with frames and cut-off, so it is no fault of the way AEP and TD are defined
    errors = {}
    for fps, cutoff in ((250.0, None), (250.0, 110.0), (4000.0, 1000.0)):
        strides = analyse(
            stopping_dead(fps=fps, frequency_hz=5.0, duty=0.6, seconds=1.2),
            settings={"substrate": "treadmill", "cutoff_hz": cutoff},
        ).strides
        whole, contact = (strides[c].mean() - 0.6 for c in ("duty_factor", "contact_duty_factor"))
        errors[fps, cutoff] = whole, contact
        assert -0.03 < contact < 0.0 < whole < 0.03
    default, sharper, exact = errors.values()
    assert np.abs(default).min() > 0.02
    assert (np.abs(sharper) < 0.8 * np.abs(default)).all()
    assert np.abs(exact).max() < 0.004
