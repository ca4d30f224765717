"""Parameters of the stage ``pullar2009``: what the thesis estimates, and what it leaves open."""

from __future__ import annotations

from dataclasses import dataclass

from pawnb.core.parameters import in_force


@dataclass(frozen=True)
class Pullar2009Parameters:
    """What is not in :class:`Pullar2009Settings`: ratios of Table 3.3, and steps around them.

    Parameters
    ----------
    ising_of_sigma : float
        K, in the standard deviation of the background's cost in the start frame. Pullar 2009,
        Table 3.3.
    contrast_of_sigma : float
        lambda, in the same. Pullar 2009, Table 3.3.
    thickness_of_span : float
        d_r, in the leg span. Pullar 2009, Table 3.3.
    slack_of_span : float
        How far parts may move from the guess in one frame before the crop is made anew, in the leg
        span. Set by hand.
    crops : int
        Crops that are made of a frame at most, each about the pose found in the one before. Set
        by hand.
    body_share : float
        Least share of the body's place that differs from the background in the start frame. Set
        by hand.
    beyond_of_span : float
        How far a leg may reach beyond the edge of the picture, in the longest leg pair. Set by
        hand: the stick animal's legs do not shorten when they are raised.
    raised : float
        Legs of a start pose may look this much shorter than they are. Set by hand.
    seen_share : float
        A leg of which less than this lies on subject pixels was not placed by the picture. Set by
        hand.
    lengths_from, lengths_to : float
        Shortest and longest length of a leg that are tried, in that of the start pose. Set by
        hand: a raised leg looks down to 0.6 long.
    lengths_step : float
        Step between lengths that are tried. Set by hand.
    lengths_rounds : int
        Turns of pose and lengths, at most. Set by hand.
    lengths_settled : float
        Lengths that change by less between two turns have settled. Set by hand: more than one
        ``lengths_step``, less than two.
    lengths_reach : float
        Pixels nearer than this to the shape may be its legs, in d_r. Set by hand.
    lengths_speck_px : int
        Dark spots of fewer pixels are no part of a leg. Set by hand.
    lengths_margin_of_span : float
        Room about the animal in which its legs are looked for, in the leg span. Set by hand.
    """

    ising_of_sigma: float = 0.5
    contrast_of_sigma: float = 2.0
    thickness_of_span: float = 1 / 200
    slack_of_span: float = 0.12
    crops: int = 3
    body_share: float = 0.5
    beyond_of_span: float = 0.04
    raised: float = 0.75
    seen_share: float = 0.3
    lengths_from: float = 0.6
    lengths_to: float = 1.1
    lengths_step: float = 0.02
    lengths_rounds: int = 4
    lengths_settled: float = 0.03
    lengths_reach: float = 5.0
    lengths_speck_px: int = 6
    lengths_margin_of_span: float = 0.15


PULLAR2009 = in_force("pullar2009", Pullar2009Parameters())
"""The parameters in force."""
