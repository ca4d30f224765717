"""What is said of cameras that have moved since they were calibrated, or are not in step."""

from __future__ import annotations

import json

import numpy as np
import pandas as pd

from pawnb.core.rig import Rig
from pawnb.core.suspects.moved_views import (
    MOVED_VIEWS,
    LaggingView,
    MovedView,
    find_moved_views,
    moved_views_of,
)
from pawnb.errors import InputWarning
from pawnb.input_warnings import warn_of_input
from pawnb.schema import Tracks


def tell_moved_views(
    tracks: Tracks, rig: Rig | None, *, where: str = "", clicks: pd.DataFrame | None = None
) -> Tracks:
    """Warn of views that do not fit the others over a recording.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks; not modified.
    rig : Rig, optional
        The calibrated views.
    where : str
        How a warning names the file, if it does.
    clicks : DataFrame, optional
        The start clicks: frame, view, point, u, v. What they show is carried, too, as a tracker
        may find nothing in a view that is far off; :func:`tell_moved_clicks` says it.

    Returns
    -------
    xarray.Dataset
        Tracks that carry what was found, for their verdict.

    Warns
    -----
    InputWarning
        A sentence for each view that does not fit.
    """
    found = moved_views_of(tracks, rig)
    for one in found:
        text = f"{where}: {one.sentence}." if where else f"{one.sentence}."
        warn_of_input(text, InputWarning, stacklevel=3)
    if rig is not None and clicks is not None and not any(isinstance(f, MovedView) for f in found):
        found += _moved_by_clicks(clicks, rig)
    if not found:
        return tracks
    return tracks.assign_attrs({MOVED_VIEWS: json.dumps([one.brief for one in found])})


def tell_moved_clicks(clicks: pd.DataFrame, rig: Rig) -> list[str]:
    """Say which view shows all clicks aside of where the others put them.

    Parameters
    ----------
    clicks : DataFrame
        The start clicks: frame, view, point, u, v.
    rig : Rig
        The calibrated views.

    Returns
    -------
    list of str
        At most one sentence.
    """
    return [f"start clicks: {one.sentence}" for one in _moved_by_clicks(clicks, rig)]


def _moved_by_clicks(clicks: pd.DataFrame, rig: Rig) -> list[MovedView | LaggingView]:
    """Return the view that clicks show to be off; nothing is said of time."""
    frames, row = np.unique(clicks["frame"].to_numpy(int), return_inverse=True)
    points = list(dict.fromkeys(clicks["point"]))
    uv = np.full((len(frames), len(points), len(rig.names), 2), np.nan)
    point = [points.index(name) for name in clicks["point"]]
    view = [rig.index(str(name)) for name in clicks["view"]]
    uv[row, point, view] = clicks[["u", "v"]].to_numpy(float)
    found = find_moved_views(uv, rig=rig, frames=frames, fps=1.0)
    return [one for one in found if isinstance(one, MovedView)]
