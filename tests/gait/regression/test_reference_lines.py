"""Reference lines: the published equations, and that they agree with each other."""

from __future__ import annotations

import pytest

from pawnb.errors import InputError
from pawnb.gait.regression.reference_lines import least_stable_duty_factor, trot_gallop_transition
from pawnb.gait.regression.scaling import EXPECTED_EXPONENTS
from pawnb.gait.support import wave_gait_margin


def test_transition_at_one_kilogram_is_the_constant_of_each_law():
    found = trot_gallop_transition(1.0)
    assert found.speed_m_s == pytest.approx(1.53, abs=0.005)  # 5.5 km/h
    assert found.frequency_hz == pytest.approx(4.48, abs=0.005)  # 269 a minute
    assert found.stride_length_m == 0.35


@pytest.mark.parametrize("mass_kg", [0.03, 0.3, 9.0, 680.0])
def test_speed_is_frequency_times_length_over_the_animals_of_the_paper(mass_kg):
    """Mice to horses; the three laws were fitted one by one."""
    found = trot_gallop_transition(mass_kg)
    assert found.frequency_hz * found.stride_length_m == pytest.approx(found.speed_m_s, rel=0.05)


def test_exponents_are_those_of_table_4_4():
    """Pullar (2009) quotes them as Heglund et al. 1974."""
    expected = {
        row.parameter: row.exponent
        for row in EXPECTED_EXPONENTS
        if row.source == "Heglund et al. 1974"
    }
    one, ten = trot_gallop_transition(1.0), trot_gallop_transition(10.0)
    assert ten.speed_m_s / one.speed_m_s == pytest.approx(10 ** expected["speed"])
    assert ten.frequency_hz / one.frequency_hz == pytest.approx(10 ** expected["frequency_hz"])
    assert ten.stride_length_m / one.stride_length_m == pytest.approx(
        10 ** expected["stride_length"]
    )


@pytest.mark.parametrize(("n_legs", "duty"), [(4, 0.75), (6, 0.5), (8, 0.375)])
def test_duty_factor_of_static_instability(n_legs, duty):
    """0.375 of eight legs: Pullar (2009), section 4.2.2; 0.5 of six: Ting et al. (1994)."""
    assert least_stable_duty_factor(n_legs) == duty
    assert wave_gait_margin(duty, n_legs=n_legs) == 0.0


def test_what_cannot_be_is_refused():
    with pytest.raises(InputError, match="mass_kg is 0"):
        trot_gallop_transition(0.0)
    with pytest.raises(InputError, match="n_legs is 2; a wave gait needs four"):
        least_stable_duty_factor(2)
