"""Going on with a run that was interrupted, for methods that go from frame to frame."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pawnb.core.checkpoint import code_checksum
from pawnb.core.frame_checkpoint import KeptFrames
from pawnb.core.paws.retracked_span import keep_rows
from pawnb.errors import InputError, InputWarning, ResumptionWarning
from pawnb.input_warnings import warn_of_input
from pawnb.io.native import read_tracks
from pawnb.schema import Tracks
from pawnb.workflow.provenance.results import provenance_steps

KEPT_FILE = "unfinished.bin"
"""What a run on a jointed animal has found, frame by frame, until it is whole."""

_PARTS_OF_STEP = {
    "start": "another start pose",
    "method": "another method",
    "parameters": "other parameters",
    "constants": "other parameters",
    "frames": "other frames",
    "inputs": "other files",
    "trial": "another trial.toml",
    "versions": "other versions",
    "code": "another version of pawnb",
}


def open_kept_frames(folder: Path | None, step: Mapping[str, Any]) -> KeptFrames:
    """Return what an interrupted run on a jointed animal has found; what follows is kept there.

    Parameters
    ----------
    folder : Path or None
        Folder of its results; None to keep nothing.
    step : mapping
        The record of the run that is asked for.

    Returns
    -------
    KeptFrames
        Empty where there are none, or where anything but the command line differs: a video,
        the start pose, a setting, a version. Remove it once the run is whole.

    Warns
    -----
    ResumptionWarning
        If the run goes on with an earlier one, or begins anew because that was another.
    """
    if folder is None:
        return KeptFrames()
    asked = {name: value for name, value in step.items() if name != "command"}
    asked["code"] = code_checksum("pawnb.core.pose")
    line = json.dumps(asked, sort_keys=True)
    kept = KeptFrames(folder / KEPT_FILE, depends_on=line)
    if kept.other is not None:
        warn_of_input(
            f"the run that was interrupted in {folder} had {_differing(kept.other, line)}; "
            "tracking begins anew.",
            ResumptionWarning,
            stacklevel=3,
        )
    elif kept.frames:
        first, last = step["frames"]
        warn_of_input(
            f"going on with the run that was interrupted in {folder}: {len(kept.frames)} of "
            f"{last - first} frames were found before.",
            ResumptionWarning,
            stacklevel=3,
        )
    return kept


def _differing(before: str, now: str) -> str:
    """Return in words what two runs do not share, of which these are the records."""
    try:
        old, new = json.loads(before), json.loads(now)
        names = [name for name in new if old.get(name) != new[name]]
        settings = old["settings"] | new["settings"]
        other = [n for n in settings if old["settings"].get(n, ...) != new["settings"].get(n, ...)]
    except (ValueError, TypeError, KeyError, AttributeError):
        return "a record that cannot be read"
    parts = [_PARTS_OF_STEP[name] for name in _PARTS_OF_STEP if name in names]
    # another method has other settings, and another version may change the code
    if other and "method" not in names:
        parts.insert(0, f"other settings ({', '.join(sorted(other))})")
    return " and ".join(parts) or "another beginning"


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
    try:
        tracks = read_tracks(path)
    except InputError:  # damaged: this run makes them again
        return None
    made = provenance_steps(tracks)[-1]
    asked = json.loads(json.dumps({**step, "command": made["command"], "complete": False}))
    return tracks if asked == {name: made.get(name) for name in asked} else None


def whole_tracks_stay(folder: Path) -> bool:
    """Say, and warn, whether a folder holds whole tracks that an interrupted run must not replace.

    Parameters
    ----------
    folder : Path
        Folder of its results.

    Returns
    -------
    bool
        False where there are none, or where they are unfinished themselves.

    Warns
    -----
    InputWarning
        That the tracks in the folder are those of the earlier run.
    """
    path = folder / "tracks.nc"
    if not path.exists():
        return False
    try:
        made = [step for step in provenance_steps(read_tracks(path)) if step["step"] == "track"]
    except InputError:  # damaged
        return False
    if not made or not made[-1].get("complete"):
        return False
    warn_of_input(
        f"interrupted: the tracks in {folder} are whole and of an earlier run; they stay until a "
        "run comes to its end.",
        InputWarning,
        stacklevel=3,
    )
    return True


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
