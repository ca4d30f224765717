"""What a run writes: each file whole or absent, with its provenance beside it."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pawnb.errors import InputError
from pawnb.io import native
from pawnb.schema import Tracks
from pawnb.trial import Trial
from pawnb.workflow.provenance import build_provenance, trial_checksums, write_provenance

RESULTS_FOLDER = "results"


def describe_trial(tracks: Tracks, trial: Trial) -> Tracks:
    """Return Tracks that carry what gait needs to know of the trial.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks of this trial; not modified.
    trial : Trial
        The trial.

    Returns
    -------
    xarray.Dataset
        Tracks with the attribute ``trial``: a JSON text with name, animal, belt speed,
        forward, up and facing, so that a ``tracks.nc`` can be analysed without its trial.
    """
    record: dict[str, Any] = {
        "name": trial.name,
        "animal": {
            "id": trial.animal.id,
            "species": trial.animal.species,
            "group": trial.animal.group,
            "body": list(trial.animal.body),
            **trial.animal.extra,
        },
        "facing": {v.name: v.facing for v in trial.views if v.facing is not None},
    }
    if trial.calibration is not None:
        record["forward"] = list(trial.calibration.forward)
        record["up"] = list(trial.calibration.up)
    if isinstance(trial.belt_speed, float):
        record["belt_speed"] = trial.belt_speed
    elif trial.belt_speed is not None:
        table = native.read_belt_speed(trial.path(trial.belt_speed))
        record["belt_speed"] = {name: table[name].tolist() for name in ("frame", "speed")}
    return tracks.assign_attrs(trial=json.dumps(record, sort_keys=True))


def results_folder(trial: Trial, out: str | Path | None = None) -> Path:
    """Return the folder for results: ``out``, or ``results`` beside the trial."""
    return Path(out) if out is not None else trial.folder / RESULTS_FOLDER


def write_track_results(
    tracks: Tracks, trial: Trial, out: str | Path, *, command: Sequence[str] | None = None
) -> Path:
    """Write ``tracks.nc``, ``tracks.csv``, ``points3d.csv`` and ``provenance.json``.

    Parameters
    ----------
    tracks : xarray.Dataset
        What was tracked.
    trial : Trial
        The trial, whose inputs are hashed into the provenance.
    out : str or Path
        The folder; it is made where it is absent.
    command : sequence of str, optional
        The command line.

    Returns
    -------
    Path
        The folder.
    """
    out = make_folder(out)
    native.write_tracks(tracks, out / "tracks.nc")
    native.write_table(native.tracks_table(tracks), out / "tracks.csv")
    if tracks.sizes["space"] == 3:
        native.write_table(native.points3d_table(tracks), out / "points3d.csv")
    steps = json.loads(tracks.attrs["provenance"]).get("steps", [])
    record = build_provenance(
        command=command,
        inputs=trial_checksums(trial),
        settings=next((s["settings"] for s in reversed(steps) if "settings" in s), {}),
        steps=steps,
    )
    write_provenance(record, out / "provenance.json")
    return out


def make_folder(path: str | Path) -> Path:
    """Make a folder for results, or say why it cannot be."""
    path = Path(path)
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"{path}: cannot make this folder ({error.strerror}); choose another with --out."
        ) from None
    return path
