"""What theory and other animals would lead one to expect: lines to draw beside one's own data."""

from __future__ import annotations

from typing import NamedTuple

from pawnb.errors import InputError
from pawnb.schema.arguments import checked_arguments

_LEAST_STABLE_LEGS = 3


class TrotGallop(NamedTuple):
    """Where quadrupeds of a mass change from trot to gallop.

    Attributes
    ----------
    speed_m_s : float
        Speed, m/s.
    frequency_hz : float
        Strides a second.
    stride_length_m : float
        Stride length, m.
    """

    speed_m_s: float
    frequency_hz: float
    stride_length_m: float


@checked_arguments
def trot_gallop_transition(mass_kg: float) -> TrotGallop:
    """Compute speed, stride frequency and stride length at the transition from trot to gallop.

    Heglund, Taylor & McMahon (1974, Science 186: 1112), from mice, rats, dogs and horses:
    5.5 M^0.24 km/h, 269 M^-0.14 strides a minute, 0.35 M^0.38 m. Pullar (2009, Fig. 4.6) draws them
    beside spiders, of which nothing says that they have to follow.

    Parameters
    ----------
    mass_kg : float
        Mass of the animal, kg.

    Returns
    -------
    TrotGallop
        The transition.

    Raises
    ------
    InputError
        If the mass is not above 0.

    Examples
    --------
    >>> round(pawnb.gait.regression.reference_lines.trot_gallop_transition(0.03).frequency_hz, 1)
    7.3
    """
    if not mass_kg > 0.0:
        raise InputError(f"mass_kg is {mass_kg}; expected a number above 0.")
    return TrotGallop(
        speed_m_s=5.5 / 3.6 * mass_kg**0.24,
        frequency_hz=269.0 / 60.0 * mass_kg**-0.14,
        stride_length_m=0.35 * mass_kg**0.38,
    )


@checked_arguments
def least_stable_duty_factor(n_legs: int) -> float:
    """Compute the duty factor below which a wave gait is statically unstable.

    Three feet have to be on the ground: 3 / n, which is 0.75 of four legs (McGhee & Frank 1968,
    Math. Biosci. 3: 331), 0.5 of six (Ting, Blickhan & Full 1994, J. Exp. Biol. 197: 251) and 0.375
    of eight. It is where :func:`pawnb.gait.support.wave_gait_margin` is 0.

    Parameters
    ----------
    n_legs : int
        Number of legs, 4 or more.

    Returns
    -------
    float
        Duty factor, a fraction.

    Raises
    ------
    InputError
        If there are fewer than four legs.

    Examples
    --------
    >>> pawnb.gait.regression.reference_lines.least_stable_duty_factor(4)
    0.75
    """
    if n_legs < 4:
        raise InputError(f"n_legs is {n_legs}; a wave gait needs four legs or more.")
    return _LEAST_STABLE_LEGS / n_legs
