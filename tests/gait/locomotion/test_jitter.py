"""Tracks that jitter: made walks, with the standard deviation of the jitter known."""

from __future__ import annotations

import numpy as np
import pytest
from walking import Walk

from pawnb import gait
from pawnb.gait.locomotion.jitter import jitter_of


def notes_of(noise_mm, *, fps=100.0, period=0.3):
    walk = Walk(period=period)
    tables = gait.analyse(walk.tracks(fps=fps, noise=noise_mm, duration=5.0, seed=1))
    return tables, [note for note in tables.notes if "from frame to frame" in note]


def test_the_standard_deviation_of_white_noise_is_found():
    noise = 2.0 * np.random.default_rng(0).standard_normal(20_000)
    assert jitter_of(noise) == pytest.approx(2.0, rel=0.03)
    # a slow motion adds nothing, a gap neither
    slow = 50.0 * np.sin(np.arange(20_000) / 30.0)
    noise[500:600] = np.nan
    assert jitter_of(noise + slow) == pytest.approx(2.0, rel=0.03)
    assert np.isnan(jitter_of(np.arange(5.0)))


@pytest.mark.slow
def test_strides_made_of_jitter_are_said():
    # 16 strides of each of four legs, less those that the ends cut; 10 % of 90 mm
    tables, said = notes_of(9.0)
    assert len(tables.strides) > 1.1 * 4 * (5.0 / 0.3 - 1)
    assert len(said) == 1
    assert "FR, HR, FL, HL jitter from frame to frame by 1" in said[0]


@pytest.mark.slow
@pytest.mark.parametrize(("fps", "period"), [(100.0, 0.2), (120.0, 0.3), (120.0, 0.2)])
def test_eight_percent_of_a_stride_are_said_too(fps, period):
    assert len(notes_of(0.08 * 300.0 * period, fps=fps, period=period)[1]) == 1


@pytest.mark.parametrize("noise_mm", [0.0, 0.5, 4.0])
def test_steady_tracks_are_not(noise_mm):
    tables, said = notes_of(noise_mm)
    assert said == []
    assert len(tables.strides) == pytest.approx(4 * (5.0 / 0.3 - 1), rel=0.06)


def test_few_frames_a_stride_are_not_taken_for_jitter():
    # 30 frames a second, four strides a second: the motion itself turns within some frames
    assert notes_of(0.1, fps=30.0, period=0.25)[1] == []
