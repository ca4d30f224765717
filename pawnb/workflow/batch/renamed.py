"""Results of a trial whose animal, group or gait settings are described otherwise by now.

Groups are often told after tracking, when a study is unblinded. That changes no track: results are
brought to what the trial says, with the corrections in them, and nothing is tracked again.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from pawnb.errors import InputError
from pawnb.io.native import read_tracks, write_tracks
from pawnb.io.tables import write_table
from pawnb.schema import Tracks
from pawnb.trial import Trial
from pawnb.workflow.provenance.manifest import known_files, writing_results
from pawnb.workflow.provenance.notes import notes_table
from pawnb.workflow.provenance.record import trial_fingerprint
from pawnb.workflow.provenance.results import (
    describe_trial,
    described_trial,
    provenance_steps,
    tracking_notes,
)

_TRACKS = "tracks.nc"
_NOTES = "notes.csv"
_DESCRIBED = {"trial": "the trial's name", "animal": "the animal", "gait": "the settings of gait"}
"""Parts of a description that shape no track, and the words for them."""


def as_tracked_before(trial: Trial, out: Path) -> Trial | None:
    """Return a trial under the name, animal and group that its results were made with.

    Parameters
    ----------
    trial : Trial
        The trial, as it is described now.
    out : Path
        Folder of its results.

    Returns
    -------
    Trial or None
        None where there are no results, they do not say, or the animal's name chooses among
        predictions of several animals.
    """
    was = _described(out)
    if was is None or trial.detections:
        return None
    then = replace(trial.animal, id=was.animal.id, group=was.animal.group, extra=was.animal.extra)
    return replace(trial, name=was.name, animal=then)


def changed_words(trial: Trial, out: Path) -> str:
    """Say what is described otherwise than in the results; empty where nothing is."""
    tracks = _tracks_of(out)
    if tracks is None or "trial" not in tracks.attrs:
        return ""
    was = json.loads(tracks.attrs["trial"])
    now = json.loads(describe_trial(tracks, replace(trial, belt_speed=None)).attrs["trial"])
    return " and ".join(
        words for part, words in _DESCRIBED.items() if _said(was, part) != _said(now, part)
    )


def describe_anew(trial: Trial, out: Path) -> None:
    """Bring results to what their trial says of its name, animal, group and gait.

    Parameters
    ----------
    trial : Trial
        The trial, as it is described now.
    out : Path
        Folder of its whole results.

    Raises
    ------
    InputError
        If they cannot be read, or written.
    """
    tracks = read_tracks(out / _TRACKS)
    sizes = json.loads(tracks.attrs["pictures_px"]) if "pictures_px" in tracks.attrs else None
    tracks = describe_trial(tracks, trial, sizes=sizes)
    # in their order of before: the same bytes as of tracking anew
    names: dict[Any, Any] = {name: tracks[name].variable for name in tracks.coords}
    names["individual"] = ("individual", [trial.animal.id])
    tracks = tracks.drop_vars(list(names)).assign_coords(names)
    steps = provenance_steps(tracks)
    last = max(k for k, step in enumerate(steps) if step["step"] == "track")
    steps[last] = steps[last] | {"trial": trial_fingerprint(trial)}
    document = json.loads(tracks.attrs["provenance"]) | {"steps": steps}
    tracks.attrs["provenance"] = json.dumps(document, sort_keys=True)
    with writing_results(out, run="track", steps=steps) as staging:
        for name in known_files(out).files_of("track"):
            if name not in (_TRACKS, _NOTES):
                shutil.copyfile(out / name, staging / name)
        write_tracks(tracks, staging / _TRACKS)
        write_table(notes_table(tracking_notes(tracks)), staging / _NOTES)


def _tracks_of(out: Path) -> Tracks | None:
    """Return the tracks of results, or None where there are none that can be read."""
    try:
        return read_tracks(out / _TRACKS) if (out / _TRACKS).is_file() else None
    except InputError:
        return None


def _described(out: Path) -> Trial | None:
    """Return the trial that the tracks of results carry."""
    tracks = _tracks_of(out)
    if tracks is None:
        return None
    return described_trial(tracks, where=str(out / _TRACKS), folder=out)


def _said(document: Mapping[str, Any], part: str) -> Any:
    """Return what a description says: of the trial its name alone."""
    said = document.get(part) or {}
    return said.get("name") if part == "trial" else said
