"""How sure smoothed tracks are: their standard deviations as stated, and what speaks for doubt."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pawnb.arrays import BoolArray, FloatArray
from pawnb.core.paws.offline.detection.colour.observations import Observations
from pawnb.core.paws.offline.gap_closing.state import GapClosing
from pawnb.core.paws.offline.smoothing.association_odds import association_log_odds
from pawnb.core.paws.offline.smoothing.forward_backward_distance import (
    forward_backward_distance,
    leave_one_out,
)
from pawnb.core.paws.offline.smoothing.refinement import MeasurementModel, deviations
from pawnb.core.paws.offline.smoothing.tracks import SmoothedTracks
from pawnb.core.paws.offline.treadmill.parameters import TREADMILL


def with_diagnostics(
    smoothed: SmoothedTracks,
    observations: Observations,
    gap_closing: GapClosing,
    *,
    measurement: MeasurementModel,
    is_one_sided: bool,
) -> SmoothedTracks:
    """Return tracks with what is stated of how sure they are.

    Parameters
    ----------
    smoothed : SmoothedTracks
        The tracks, with what they were smoothed from.
    observations : Observations
        What every view shows.
    gap_closing : GapClosing
        What was taken where paths are not certain.
    measurement : MeasurementModel
        The views.
    is_one_sided : bool
        Whether the paws of one side only were clicked.

    Returns
    -------
    SmoothedTracks
        The same positions, with standard deviations, distances and odds.
    """
    smoothed = replace(
        smoothed, sd=stated_sd(smoothed.sd, gap_closing.is_open, is_one_sided=is_one_sided)
    )
    if smoothed.equations is None:
        return smoothed
    return replace(
        smoothed,
        forward_backward_distance=forward_backward_distance(smoothed.equations),
        association_log_odds=association_log_odds(
            smoothed.measured,
            leave_one_out(smoothed.x, smoothed.equations),
            observations,
            negative_log_odds=gap_closing.negative_log_odds,
            sigma=deviations(observations.detection_probability, measurement),
            geometry=measurement.geometry,
            paw_width_px=measurement.paw_width_px,
        ),
    )


def stated_sd(sd: FloatArray, is_open: BoolArray, *, is_one_sided: bool) -> FloatArray:
    """Return the standard deviations that are stated, given where places are certain.

    Parameters
    ----------
    sd : ndarray, shape (n, P, d)
        Those that were reckoned with.
    is_open : ndarray of bool, shape (n, P)
        Where places are not certain.
    is_one_sided : bool
        Whether the paws of one side only were clicked: then none is stated surer.

    Returns
    -------
    ndarray, shape (n, P, d)
        The standard deviations.
    """
    certain = np.zeros_like(is_open) if is_one_sided else ~is_open
    return np.where(certain[..., None], TREADMILL.pipeline_stated * sd, sd)
