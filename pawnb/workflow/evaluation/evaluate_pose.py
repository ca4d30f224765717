"""The thesis's evaluations of poses without any truth, on a person's own recordings.

Pullar 2009, §4.1: how much the pose of an animal that keeps still varies (Table 4.1), and tracking
forwards against tracking in reverse (Table 4.2).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pawnb.core.paws.tracker import DEFAULT
from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.as_tracks import animal_of, is_pose, poses_of
from pawnb.core.pose.pose_table import pose_table
from pawnb.core.pose.poses import Poses, tip_positions
from pawnb.core.pose.track_result import plain_track
from pawnb.core.video import open_views
from pawnb.errors import InputError
from pawnb.input_warnings import hearing_input_warnings
from pawnb.io.tables import write_table
from pawnb.schema import Tracks
from pawnb.trial import Trial, load_trial
from pawnb.workflow.evaluation.against_truth import Evaluation
from pawnb.workflow.evaluation.pose_spread import build_jitter_table, compare_directions
from pawnb.workflow.progress import Progress
from pawnb.workflow.provenance.results import (
    make_folder,
    provenance_steps,
    read_result_tracks,
    results_folder,
)
from pawnb.workflow.start.propose_pose import pose_view
from pawnb.workflow.tracking.track import track


def evaluate_still(
    results: str | Path, *, frames: tuple[int, int], out: str | Path | None = None
) -> Evaluation:
    """Tell how much the pose varies over frames in which the animal keeps still (Table 4.1).

    Parameters
    ----------
    results : str or Path
        Folder of results, or a ``tracks.nc``.
    frames : tuple of int
        First and last frame in which it keeps still.
    out : str or Path, optional
        Folder to write ``evaluation_still.csv`` to.

    Returns
    -------
    Evaluation
        With the table ``still``.

    Raises
    ------
    InputError
        If these are not tracks of a jointed animal, if they have not all of these frames, or
        fewer than two poses there.
    """
    results = Path(results)
    tracks = read_result_tracks(results)
    animal, poses = animal_of(tracks), poses_of(tracks).poses
    first, last = frames
    known = poses.frames
    if not known.min() <= first <= last <= known.max():
        raise InputError(
            f"frames {first} to {last} were asked for; the results have frames {known.min()} to "
            f"{known.max()}: name the first and the last of those that are still."
        )
    inside = (poses.frames >= first) & (poses.frames <= last)
    table = build_jitter_table(animal, poses.take(inside))
    head = f"{int(inside.sum())} frames, {first} to {last}: standard deviation (range)"
    lines = [
        f"{_name(row)}: {row.sd:.3g} ({row.range:.3g}) {row.unit}" for row in table.itertuples()
    ]
    return _written(Evaluation("\n".join([head, *lines]), {"still": table}), out)


def evaluate_directions(
    trial: Trial | str | Path,
    *,
    method: str = DEFAULT,
    settings: Mapping[str, Any] | None = None,
    disturb_px: float = 0.0,
    disturb_deg: float = 0.0,
    seed: int = 0,
    out: str | Path | None = None,
    progress: Progress | None = None,
) -> Evaluation:
    """Track forwards from the first frame and in reverse from the last, and compare (Table 4.2).

    Both start from poses that tracking has found, in the trial's own results or, without them,
    from its start pose: in the first and the last frame that show every leg.

    Parameters
    ----------
    trial : Trial, str or Path
        A trial of kind ``pose``, its ``trial.toml``, or the folder that holds it.
    method : {"pawnb", "paper"}
        Method of the tracker.
    settings : mapping, optional
        Settings of the tracker.
    disturb_px, disturb_deg : float
        Standard deviation of what is added at random to each start pose: to x and y, and to
        heading and joints.
    seed : int
        Seed of that.
    out : str or Path, optional
        Folder to write ``evaluation_directions.csv`` to.
    progress : callable, optional
        As for :func:`pawnb.track`.

    Returns
    -------
    Evaluation
        With the table ``directions``.

    Raises
    ------
    InputError
        If the trial is of another kind, the disturbance is below 0, or the animal is found in
        fewer than two frames.
    """
    trial = trial if isinstance(trial, Trial) else load_trial(trial)
    both_ways = "; tracking both ways is compared for jointed animals, kind 'pose'."
    trial.must_be("pose", or_else=both_ways)
    if not (0 <= disturb_px < math.inf and 0 <= disturb_deg < math.inf):
        raise InputError(
            f"disturb is {disturb_px:g} px, {disturb_deg:g} degrees; expected numbers, 0 or more."
        )
    found = _found(trial, method, settings, progress)
    animal, poses = animal_of(found), poses_of(found).poses
    known = np.flatnonzero(_whole_in_view(trial, animal, poses))
    if len(known) < 2:
        raise InputError(
            f"trial {trial.name!r}: every leg is seen in {len(known)} frames; expected 2 or more."
        )
    ends = poses.take(known[:1]), poses.take(known[-1:])
    span = int(ends[0].frames[0]), int(ends[1].frames[0]) + 1

    def one_way(start: Poses) -> Any:
        table = pose_table(animal, plain_track(animal, start))
        with hearing_input_warnings(str, shown=False):  # said once already
            tracks = track(
                trial, method=method, settings=settings, start=table, frames=span,
                progress=progress,
            )  # fmt: skip
        return poses_of(tracks)

    table = compare_directions(
        one_way, ends, animal=animal, disturb_px=disturb_px, disturb_deg=disturb_deg, seed=seed
    )
    head = f"frames {span[0]} to {span[1] - 1}, forwards against reverse: RMS of the differences"
    lines = [f"{_name(row)}: {row.rms_difference:.3g} {row.unit}" for row in table.itertuples()]
    return _written(Evaluation("\n".join([head, *lines]), {"directions": table}), out)


def _found(
    trial: Trial, method: str, settings: Mapping[str, Any] | None, progress: Progress | None
) -> Tracks:
    """Return the tracks in the trial's results, if that method made them, else new ones."""
    file = results_folder(trial) / "tracks.nc"
    if file.is_file():
        tracks = read_result_tracks(file)
        made = [step["method"] for step in provenance_steps(tracks) if step["step"] == "track"]
        if is_pose(tracks) and made[-1:] == [method]:
            return tracks
    return track(trial, method=method, settings=settings, progress=progress)


def _whole_in_view(trial: Trial, animal: StickAnimal, poses: Poses) -> np.ndarray:
    """Return in which frames every tip lies in the picture.

    Where the animal comes in or goes out, legs that nobody sees would be compared.
    """
    with open_views(trial) as views:
        reader = views.readers[pose_view(trial)]
        size = np.array([reader.width, reader.height])
    tips = tip_positions(animal, poses)
    return np.asarray(((tips >= 0) & (tips <= size - 1)).all(axis=(1, 2)))  # NaN is outside


def _name(row: Any) -> str:
    """Return what a row of a table is about."""
    return f"{row.measure} {row.legs}".strip()


def _written(found: Evaluation, out: str | Path | None) -> Evaluation:
    """Write the tables where that was asked for."""
    if out is not None:
        folder = make_folder(out)
        for name, table in found.tables.items():
            write_table(pd.DataFrame(table), folder / f"evaluation_{name}.csv")
    return found
