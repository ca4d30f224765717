"""What was put in place by hand: by clicks at the start, and by corrections of Tracks."""

from __future__ import annotations

import numpy as np
import pandas as pd

from pawnb.core.video import ViewSet
from pawnb.errors import InputError
from pawnb.io import native
from pawnb.io.start import check_start, read_start
from pawnb.schema import START_COLUMNS, Tracks
from pawnb.trial import Trial
from pawnb.workflow.provenance.results import provenance_steps


def clicks_by_hand(trial: Trial, tracks: Tracks) -> pd.DataFrame:
    """Return every position that was put in place by hand, as start clicks.

    Parameters
    ----------
    trial : Trial
        The trial: what each view tracks.
    tracks : xarray.Dataset
        Its tracks.

    Returns
    -------
    DataFrame
        frame, view, point, u, v (px).
    """
    table = native.tracks_table(tracks)
    return _tracked(trial, table[(table["origin"] == "edited") & table["u"].notna()])


def clicks_learnt_from(tracks: Tracks) -> pd.DataFrame | None:
    """Return the clicks from which it was last learnt what paws look like.

    They are those that tracks were begun with, or those by hand when a person had it learnt anew.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks of method ``pawnb``.

    Returns
    -------
    DataFrame or None
        frame, view, point, u, v (px); None where the record of the tracks lacks their beginning.
    """
    steps = provenance_steps(tracks)
    if not any(step["step"] == "track" for step in steps):
        return None
    learnt = [
        step for step in steps
        if step["step"] == "track" or (step["step"] == "retrack" and step.get("learn"))
    ]  # fmt: skip
    return pd.DataFrame(learnt[-1]["start"], columns=list(START_COLUMNS))


def clicks_of_frame(trial: Trial, tracks: Tracks, frame: int) -> pd.DataFrame:
    """Return a frame of Tracks as start clicks: what each view tracks and has a position for.

    Parameters
    ----------
    trial : Trial
        The trial: what each view tracks.
    tracks : xarray.Dataset
        Its tracks.
    frame : int
        The frame.

    Returns
    -------
    DataFrame
        frame, view, point, u, v (px).
    """
    table = native.tracks_table(tracks.isel(time=tracks["frame"].to_numpy() == frame))
    known = table["u"].notna() & (table["origin"] != "reprojected")
    return _tracked(trial, table[known])


def start_clicks(trial: Trial, views: ViewSet, start: pd.DataFrame | None) -> pd.DataFrame:
    """Return the clicks that tracking begins with, checked against trial and pictures.

    Parameters
    ----------
    trial : Trial
        The trial.
    views : ViewSet
        Its opened views.
    start : DataFrame, optional
        Clicks that go before those of the trial's file.

    Returns
    -------
    DataFrame
        frame, view, point, u, v (px).

    Raises
    ------
    InputError
        If there are none, or they do not fit.
    """
    if start is None:
        file = trial.start_file()
        if file is None:
            raise InputError(
                f"trial {trial.name!r} has no start points; click them with "
                "pawnb.widgets.ClickInitialiser, or name a csv under [start] points."
            )
        start = read_start(trial.path(file), trial)
    sizes = {name: (r.width, r.height) for name, r in views.readers.items()}
    check_start(start, trial, sizes)
    return start


def _tracked(trial: Trial, table: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of a table of points that their views track, as start clicks."""
    names = zip(map(trial.view, table["view"]), table["point"], strict=True)
    tracked = np.array([not v.points or point in v.points for v, point in names], dtype=bool)
    return table.loc[tracked, list(START_COLUMNS)].reset_index(drop=True)
