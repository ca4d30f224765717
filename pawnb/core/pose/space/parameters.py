"""Parameters of the stage ``space_fit``, each with unit and evidence."""

from __future__ import annotations

from dataclasses import dataclass

from pawnb.core.parameters import in_force


@dataclass(frozen=True)
class SpaceFitParameters:
    """How a pose in the first view is raised into space, beside :class:`.settings.SpaceSettings`.

    Parameters
    ----------
    animal_dark : float
        Darkness, of the animal's, from which a pixel may be its. Set by hand.
    dark_share : float
        A pixel is not the background where it differs from it by this share. Set by hand.
    dark_sds : float
        And by so many standard deviations of the background. Set by hand.
    strong_percentile : float
        Pixels that differ from the background most, a percentile: they tell whether the animal is
        dark or light. Set by hand.
    light_percentile : float
        How light a light animal is: a percentile of those pixels. Set by hand.
    margin_px : int
        What is cut out of the second view beside the animal, px. Set by hand.
    body_step : float
        Step with which the body is looked for, leg spans. Set by hand.
    coarse : float
        How much broader the blur of the first fit is, which draws from further away. Set by hand.
    rounds : int
        Steps of a fit at most. Set by hand.
    enough : float
        A step that lowers the cost (minus the logarithm of the likelihood) by less is the last. Set
        by hand.
    most_step : float
        Longest step of a fit, leg spans. Set by hand.
    lifted : float
        Standard deviations above the ground from which a foot counts as lifted. Set by hand.
    thickness : tuple of float
        Least, greatest and number of heights of body parts that are tried, as shares of their
        widths. Set by hand.
    first_thickness : float
        The same until it is learnt. Set by hand.
    pitches : tuple of float
        Least, greatest and number of rises of the body forwards that are tried, as shares of the
        way. Set by hand.
    pitch_sd : float
        Standard deviation of that. Set by hand.
    body_rounds : int
        Times that rise and heights are found in turn. Set by hand.
    leg_rounds : int
        Times that thickness and darkness of legs are found. Set by hand.
    same_length : float
        How far a leg's length may be from the species', as a share. Set by hand.
    length_seen : float
        How sure the median over frames of a leg's length is, as a share. Set by hand.
    length_least : float
        Added to the standard deviation of a segment's length, leg spans: short ones are known no
        better. Set by hand.
    projected_length_sd : float
        Standard deviation of a projected length about that in space, leg spans: half of what a
        place may be off across a leg. Set by hand.
    far_pictures : float
        Heights are looked for within so many widths of the first picture about the look point. Set
        by hand.
    least_change : float
        Least change in the second picture with height, as a share of the greatest of any direction.
        Set by hand.
    shown : float
        Least share of a leg's line that the second view must show for its heights to be measured.
        Set by hand.
    shown_dark : float
        Darkness, of the leg's, from which a place of its line counts as shown. Set by hand.
    learn_from : int
        Frames from which look and proportions are learnt. Set by hand.
    settle : int
        Times that all heights are fitted with those of the frames beside. Set by hand.
    """

    animal_dark: float = 0.2
    dark_share: float = 0.12
    dark_sds: float = 4.0
    strong_percentile: float = 98.0
    light_percentile: float = 75.0
    margin_px: int = 8
    body_step: float = 0.007
    coarse: float = 2.5
    rounds: int = 12
    enough: float = 0.05
    most_step: float = 0.04
    lifted: float = 2.0
    thickness: tuple[float, float, int] = (0.35, 1.25, 10)
    first_thickness: float = 0.7
    pitches: tuple[float, float, int] = (-0.3, 0.3, 13)
    pitch_sd: float = 0.15
    body_rounds: int = 2
    leg_rounds: int = 3
    same_length: float = 0.05
    length_seen: float = 0.02
    length_least: float = 1e-3
    projected_length_sd: float = 0.002
    far_pictures: float = 4.0
    least_change: float = 0.2
    shown: float = 0.5
    shown_dark: float = 0.5
    learn_from: int = 16
    settle: int = 2


IN_SPACE = in_force("space_fit", SpaceFitParameters())
"""The values in force; see :func:`pawnb.core.parameters.in_force`."""
