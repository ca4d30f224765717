"""What the compiled loops of multiple hypothesis tracking are given of the stage's parameters."""

from __future__ import annotations

from typing import NamedTuple

from pawnb.core.paws.offline.gap_closing.parameters import GAP_CLOSING


class MHTParameters(NamedTuple):
    """Parameters of multiple hypothesis tracking; costs are minus log-probabilities.

    Those after the first six are the ``mht_...`` of the stage, where unit and evidence stand.

    Parameters
    ----------
    jerk : float
        Usual standard deviation of the change of acceleration from frame to frame.
    impulse : float
        Standard deviation of the change of speed where a point manoeuvres.
    noise : float
        Standard deviation of a place that is certain.
    reach : float
        A point does not go farther than this while no tracklet is certain.
    rising, swinging : int
        Frames after lift-off in which a paw may look poor, and in which it swings for certain.
    impulse_cost, good, bad, bad_cost, clutter, seen, seen_across, occlusion_onset_cost, \
    occlusion_frame_cost, reappearance_cost, sideways, hold, slip, lifting, covered, alike, gate, \
    out_of_reach_cost, pruning_cost : float
        As of the stage.
    most, most_within : int
        As of the stage.
    """

    jerk: float
    impulse: float
    noise: float
    reach: float
    rising: int
    swinging: int
    impulse_cost: float
    good: float
    bad: float
    bad_cost: float
    clutter: float
    seen: float
    seen_across: float
    occlusion_onset_cost: float
    occlusion_frame_cost: float
    reappearance_cost: float
    sideways: float
    hold: float
    slip: float
    lifting: float
    covered: float
    alike: float
    gate: float
    out_of_reach_cost: float
    pruning_cost: float
    most: int
    most_within: int


def mht_parameters(
    *, jerk: float, impulse: float, noise: float, reach: float, rising: int, swinging: int
) -> MHTParameters:
    """Return the parameters for points that move so, with those of the stage that are in force.

    Parameters
    ----------
    jerk, impulse, noise, reach : float
        See :class:`MHTParameters`.
    rising, swinging : int
        See there.

    Returns
    -------
    MHTParameters
        All of them.
    """
    own = (jerk, impulse, noise, reach, rising, swinging)
    names = MHTParameters._fields[len(own) :]
    return MHTParameters(*own, *(getattr(GAP_CLOSING, f"mht_{name}") for name in names))
