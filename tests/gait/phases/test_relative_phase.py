"""Continuous relative phase of signals whose phase is known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pawnb.errors import InputError
from pawnb.gait.phases.relative_phase import continuous_relative_phase, phase_angle

T = np.arange(400) / 100.0


@given(ahead=st.floats(0.0, 0.99), size=st.floats(0.1, 50.0))
def test_sinusoids_ahead_by_a_known_part_of_a_cycle(ahead, size):
    reference = np.cos(2 * np.pi * 2.0 * T) + 3.0
    found = continuous_relative_phase(size * np.cos(2 * np.pi * (2.0 * T + ahead)), reference)
    assert abs((found.mean - ahead + 0.5) % 1.0 - 0.5) < 0.01
    assert found.deviation_phase < 0.06


def test_phase_is_0_in_front_and_a_half_behind():
    phase = phase_angle(np.cos(2 * np.pi * 2.0 * T))
    assert abs((phase[200] + 0.5) % 1 - 0.5) < 0.01  # t = 2 s: an anterior extreme
    assert phase[225] == pytest.approx(0.5, abs=0.01)


def test_unsteady_coupling_has_a_greater_deviation():
    drift = np.cos(2 * np.pi * (2.0 * T + 0.1 * T))
    assert continuous_relative_phase(drift, np.cos(4 * np.pi * T)).deviation_phase > 0.08


def test_gaps_stay_gaps_and_strangers_are_refused():
    x = np.cos(4 * np.pi * T)
    x[100:150] = np.nan
    found = continuous_relative_phase(x, np.cos(4 * np.pi * T))
    assert np.isnan(found.phase[100:150]).all()
    assert np.isfinite(found.phase[200:]).all()
    with pytest.raises(InputError, match="expected two of one length"):
        continuous_relative_phase(x, x[:-1])
    with pytest.raises(InputError, match="never seen together"):
        continuous_relative_phase(x, np.full(len(x), np.nan))
