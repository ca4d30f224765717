"""Px per unit of a trial, from a grid of known spacing in its empty scene."""

from __future__ import annotations

from pathlib import Path

from pawnb.core.pose.grid import PxPerUnit, scale_from_grid
from pawnb.core.video import open_views
from pawnb.trial import Trial, load_trial
from pawnb.workflow.propose_pose import trial_background


def find_grid_scale(trial: Trial | str | Path, *, spacing: float) -> PxPerUnit:
    """Measure the grid under the animal in the empty scene of a trial's first view.

    Write ``px_per_unit`` into ``[calibration]`` of ``trial.toml`` to use it.

    Parameters
    ----------
    trial : Trial, str or Path
        The trial, its ``trial.toml``, or the folder that holds it.
    spacing : float
        Distance of neighbouring lines in the unit wanted, for instance 10 for a 1 cm grid
        in mm.

    Returns
    -------
    PxPerUnit
        The scale and its standard error.

    Raises
    ------
    InputError
        If there is no grid that can be measured.
    """
    trial = trial if isinstance(trial, Trial) else load_trial(trial)
    with open_views(trial) as views:
        return scale_from_grid(trial_background(trial, views).mean, spacing=spacing)
