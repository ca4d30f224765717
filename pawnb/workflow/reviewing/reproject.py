"""Tracks of a trial, shown in every view (2019 paper, Fig. 8)."""

from __future__ import annotations

from pathlib import Path

from pawnb.core.reproject import reproject_tracks
from pawnb.core.rig import require_rig
from pawnb.core.video import open_views
from pawnb.schema import Tracks
from pawnb.trial import Trial, load_trial
from pawnb.workflow.provenance.results import write_track_results


def reproject(
    trial: Trial | str | Path, tracks: Tracks, *, out: str | Path | None = None
) -> Tracks:
    """Show the points of a trial also in the views that do not track them.

    Parameters
    ----------
    trial : Trial, str or Path
        The trial, with its calibration.
    tracks : xarray.Dataset
        Its tracks. After tracking again, or corrections, call this again.
    out : str or Path, optional
        Folder for the results.

    Returns
    -------
    xarray.Dataset
        Tracks; see :func:`pawnb.core.reproject.reproject_tracks`.

    Raises
    ------
    CalibrationError
        If the trial has no calibration of its views.
    InputError
        If the tracks have no positions in space.
    """
    if not isinstance(trial, Trial):
        trial = load_trial(trial)
    with open_views(trial) as views:
        shown = {name: (r.width, r.height) for name, r in views.readers.items()}
        files = {name: (r.source.width, r.source.height) for name, r in views.readers.items()}
    rig = require_rig(trial, sizes=files)
    tracks = reproject_tracks(tracks, rig, sizes=shown)
    if out is not None:
        write_track_results(tracks, out, rig=rig)
    return tracks
