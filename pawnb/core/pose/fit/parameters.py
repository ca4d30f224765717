"""Parameters of the stage ``fitting``, each with unit and evidence."""

from __future__ import annotations

from dataclasses import dataclass

from pawnb.core.parameters import in_force


@dataclass(frozen=True)
class FittingParameters:
    """The fit of a single frame.

    Parameters
    ----------
    cover_px : float
        What is nearer to the prediction is kept out of the estimate of the light. Set by hand.
    body_margin_px : float
        How far from its place the body's edge may be, working px. Set by hand.
    no_leg : float
        Painted where a leg would not be seen: darker than any. Set by hand.
    body_blurs : tuple[float, ...]
        Half widths of the blur, working px, with which the body alone is fitted, one after the
        other. Set by hand.
    body_surely_px : tuple[float, ...]
        A body that lies, with each of these blurs, no further than this from its expected place is
        in it: the legs then say where it is more precisely than its outline does. A wide blur, with
        which the legs pull at the body's outline, is trusted only where it is nearer. Set by hand.
    fitter_wider : float
        A disc of so many thicknesses is no part of legs, even where two lie side by side. Set by
        hand.
    fitter_enough, enough_of_body : float
        A fit ends when a step lowers its cost by less; that of the body alone earlier, as whole
        pixels will do. Set by hand.
    reach_more, reach_more_px : float
        The part of a frame that is looked at: so many times as far as the longest leg reaches, and
        so many working px more. Set by hand.
    dark, tip_dark : float
        Darkness of the animal before anything is learnt, and that of a leg's tip in that of its
        beginning. Set by hand.
    light_from : float
        Half the side of the square about the body's middle from which it is seen whether the animal
        is darker than the background, in lengths of the body. Set by hand.
    outer_share : float
        Part of a leg, from the tip inwards, whose support is taken by itself. Set by hand.
    support_least_dark, support_as_dark : float
        Least darkness that is expected of a leg, and the share of it from which on a body under it
        looks the same without the leg. Set by hand.
    layout_meets : float
        A part whose near end is no further from the origin, half lengths, ends there. Set by hand.
    waist_length, waist_width : float
        Size of the waist relative to the smaller part beside it; its width is learnt. Set by hand.
    on_animal : float
        Least share of the body's darkness at its place in a start frame. Set by hand.
    tracker_sure, tracker_doubtful : float
        Support of a leg's outer third from which it is sure, and below which it is not there. Set
        by hand.
    light_percentile : float
        How light a light animal is: a percentile of that square. Set by hand.
    rounds : int
        Steps of a fit at most, where nothing else is said. Set by hand.
    """

    cover_px: float = 7.0
    body_margin_px: float = 3.0
    no_leg: float = 2.0
    body_blurs: tuple[float, ...] = (6.0, 2.0)
    body_surely_px: tuple[float, ...] = (1.5, 3.0)
    fitter_wider: float = 2.2
    fitter_enough: float = 0.5
    enough_of_body: float = 5.0
    reach_more: float = 1.03
    reach_more_px: float = 6.0
    dark: float = 0.8
    tip_dark: float = 0.6
    light_from: float = 0.15
    outer_share: float = 0.33
    support_least_dark: float = 0.05
    support_as_dark: float = 0.7
    layout_meets: float = 0.1
    waist_length: float = 0.35
    waist_width: float = 0.2
    on_animal: float = 0.5
    tracker_sure: float = 0.85
    tracker_doubtful: float = 0.35
    light_percentile: float = 75.0
    rounds: int = 6


FITTING = in_force("fitting", FittingParameters())
"""The values in force; see :func:`pawnb.core.parameters.in_force`."""
