"""What was put in place by hand, read from Tracks: by clicks at the start, and by corrections."""

from __future__ import annotations

import numpy as np
import pandas as pd

from pawnb.io import native
from pawnb.schema import START_COLUMNS, Tracks
from pawnb.trial import Trial
from pawnb.workflow.results import provenance_steps


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
    table = table[(table["origin"] == "edited") & table["u"].notna()]
    names = zip(map(trial.view, table["view"]), table["point"], strict=True)
    tracked = np.array([not v.points or point in v.points for v, point in names], dtype=bool)
    return table.loc[tracked, list(START_COLUMNS)].reset_index(drop=True)


def clicks_begun_with(tracks: Tracks) -> pd.DataFrame | None:
    """Return the clicks that tracks were begun with; None where their record lacks them."""
    made = [step for step in provenance_steps(tracks) if step["step"] == "track"]
    if not made:
        return None
    return pd.DataFrame(made[-1]["start"], columns=list(START_COLUMNS))
