"""Going on with a run that was interrupted, for methods that go from frame to frame."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pawnb.core.paws.stretch import keep_rows
from pawnb.io.native import read_tracks
from pawnb.schema import Tracks
from pawnb.workflow.results import provenance_steps


def unfinished_tracks(folder: Path, step: Mapping[str, Any]) -> Tracks | None:
    """Return the tracks of an interrupted run, if the same run is asked for again.

    Parameters
    ----------
    folder : Path
        Folder of its results.
    step : mapping
        The record of the run that is asked for, without ``complete``, which stays open.

    Returns
    -------
    xarray.Dataset or None
        The frames that are done; None where there are none, where the run was whole, where
        they have been corrected since, or where anything but the command line differs: a
        video, a click, a setting, a version.
    """
    path = folder / "tracks.nc"
    if not path.exists():
        return None
    tracks = read_tracks(path)
    made = provenance_steps(tracks)[-1]
    asked = json.loads(json.dumps({**step, "command": made["command"], "complete": False}))
    return tracks if asked == {name: made.get(name) for name in asked} else None


def join_earlier(earlier: Tracks, tracks: Tracks) -> Tracks:
    """Return tracks whose frames before the last earlier one are as they were.

    The last earlier frame is where tracking went on: it is taken from the new tracks.
    """
    frames = tracks["frame"].to_numpy()
    keep = frames < earlier["frame"].to_numpy()[-1]
    kept = keep[:, None].repeat(tracks.sizes["keypoint"], axis=1)
    joined = keep_rows(earlier.assign_attrs(tracks.attrs), tracks, kept)
    # one record for the one run, which the caller makes
    return joined.assign_attrs(provenance="{}")
