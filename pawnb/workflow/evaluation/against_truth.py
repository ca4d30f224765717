"""Tracks of points and poses against their truth, each in a way of its own."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

import numpy as np
import pandas as pd

from pawnb.core.paws.maghsoudi2019.settings import REFERENCE_WIDTH_PX
from pawnb.core.pose.as_tracks import animal_of, is_pose, poses_of
from pawnb.core.pose.pose_table import pose_names, poses_from_table
from pawnb.errors import InputError
from pawnb.io.native import read_tracks, tracks_table
from pawnb.io.pose import read_pose
from pawnb.io.tables import read_cells, read_numbers
from pawnb.schema import TRACKS_COLUMNS, Tracks
from pawnb.workflow.evaluation.errors import count_errors, limits_for_width
from pawnb.workflow.evaluation.pose_errors import measure_pose_errors


@dataclass(frozen=True)
class Evaluation:
    """Errors of results.

    Parameters
    ----------
    text : str
        What was found, in a few lines.
    tables : dict
        Name to DataFrame: ``summary`` (measure, value, unit), ``legs`` and ``swaps`` of poses,
        ``errors`` of points, ``events`` where the truth has them.
    """

    text: str
    tables: dict[str, pd.DataFrame] = field(default_factory=dict)


class Truth(Protocol):
    """What is known of the truth of tracks of one kind."""

    @property
    def file(self) -> str:
        """The name of its file."""

    def measure(
        self, tracks: Tracks, path: Path, *, threshold_px: float | None = None
    ) -> Evaluation:
        """Measure the errors of tracks.

        Parameters
        ----------
        tracks : xarray.Dataset
            Tracks.
        path : Path
            The truth.
        threshold_px : float, optional
            Points further from the truth than this are wrong, see
            :func:`pawnb.workflow.evaluation.evaluate.evaluate`.

        Returns
        -------
        Evaluation
            The errors in words, and their tables.

        Raises
        ------
        InputError
            If the truth cannot be read, or does not fit the tracks.
        """


class PointTruth:
    """Where points are; of jointed animals also where their tips are."""

    file = "tracks.csv"

    def measure(
        self, tracks: Tracks, path: Path, *, threshold_px: float | None = None
    ) -> Evaluation:
        """Count errors, see :func:`pawnb.workflow.evaluation.errors.count_errors`."""
        table = _true_points(path)
        limit, hidden = _limits(tracks, threshold_px)
        report = count_errors(tracks, table, threshold_px=limit, hidden_px=hidden)
        text = "\n".join([report.text(), *_not_compared(tracks, table)])
        return Evaluation(text, {"summary": report.summary(), "errors": report.errors})


def _not_compared(tracks: Tracks, truth: pd.DataFrame) -> list[str]:
    """Say what of the truth the tracks lack: that of another trial, or of a film cut short."""
    lost = []
    frames = np.unique(truth["frame"].to_numpy())
    beyond = np.setdiff1d(frames, tracks["frame"].to_numpy())
    if len(beyond):
        lost.append(f"{len(beyond)} of {len(frames)} frames ({beyond[0]:g} to {beyond[-1]:g})")
    for column, dim in (("view", "view"), ("point", "keypoint")):
        names = pd.unique(truth[column].astype(str))
        without = [n for n in names if n not in set(map(str, tracks[dim].to_numpy()))]
        if without:
            lost.append(f"the {column}{'s' * (len(without) > 1)} {', '.join(without)}")
    if not lost:
        return []
    return [
        f"the tracks lack {' and '.join(lost)} of the truth, which count neither as right nor as "
        "wrong: look whether the truth is of this trial, and the trial was tracked to its end"
    ]


class PoseTruth:
    """How a jointed animal is posed; ``tracks.csv`` beside it says which tips are visible."""

    file = "pose.csv"

    def measure(
        self,
        tracks: Tracks,
        path: Path,
        *,
        threshold_px: float | None = None,
    ) -> Evaluation:
        """Measure the errors of poses where the whole animal is in view, else leg by leg.

        See :func:`pawnb.workflow.evaluation.pose_errors.measure_pose_errors`.
        """
        if threshold_px is not None:
            raise InputError(
                f"a threshold of {threshold_px:g} px is for points; errors of poses are measured, "
                "not counted, and it would not be heeded: leave it out."
            )
        animal = animal_of(tracks)
        table = read_pose(path, names=pose_names(animal), other_legs=True)
        visible = _tips_in_view(path.with_name("tracks.csv"), animal.leg_names)
        seen: np.ndarray | None = None
        note: list[str] = []
        if visible is not None and visible.all(axis=1).any():
            table = table[table["frame"].isin(visible.index[visible.all(axis=1)])]
        elif visible is not None:
            seen = visible.reindex(table["frame"], fill_value=False).to_numpy()
            if not seen.any():
                raise InputError(f"{path.parent}: the truth never shows a tip of the animal.")
            never = ", ".join(
                str(visible.columns[k]) for k in np.flatnonzero(~seen.any(axis=0)).tolist()
            )
            note = [
                "no frame shows every tip: each leg is judged where its own is visible; never "
                f"visible: {never or 'none'}"
            ]
        _, truth = poses_from_table(table, animal)
        found = measure_pose_errors(animal, poses_of(tracks).poses, truth, seen=seen)
        lines = [
            f"{row.measure}: {row.value:.4g} {row.unit}".rstrip()
            for row in found.summary.itertuples()
        ]
        tables = {"summary": found.summary, "legs": found.legs, "swaps": found.swaps}
        return Evaluation("\n".join([*note, *lines]), tables)


def truth_of(tracks: Tracks, path: Path) -> Truth:
    """Return how tracks are measured.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks.
    path : Path
        The truth: a file, or the folder that holds it. ``tracks.csv`` has points of whatever
        animal.

    Returns
    -------
    Truth
        What measures them.
    """
    return PoseTruth() if is_pose(tracks) and path.name != PointTruth.file else PointTruth()


def _limits(tracks: Tracks, threshold_px: float | None) -> tuple[float, float]:
    """Return the limits of an error and of what is bridged, px; those asked for, or by width."""
    if threshold_px is not None:
        return threshold_px, threshold_px / 2.0
    sizes = json.loads(tracks.attrs.get("pictures_px", "{}"))
    # tracks made elsewhere do not say how wide their pictures are
    return limits_for_width(max((width for width, _ in sizes.values()), default=REFERENCE_WIDTH_PX))


def _tips_in_view(path: Path, tips: tuple[str, ...]) -> pd.DataFrame | None:
    """Return whether each tip (columns) is visible in each frame, or None if nobody knows."""
    if not path.exists():
        return None
    cells = read_cells(path, ("frame", "point"))
    if "visible" not in cells:
        return None
    cells = cells[cells["point"].isin(tips)]
    visible = pd.DataFrame(
        {
            "frame": read_numbers(cells, "frame", where=path.name, whole=True),
            "point": cells["point"],
            "visible": read_numbers(cells, "visible", where=path.name) > 0,
        }
    )
    table = visible.pivot_table(
        index="frame", columns="point", values="visible", aggfunc="min", fill_value=True
    )
    return table.reindex(columns=list(tips), fill_value=True).astype(bool)


def _true_points(path: Path) -> pd.DataFrame:
    """Read true points, or those of another program's tracks.nc."""
    if path.suffix == ".nc":
        return tracks_table(read_tracks(path))
    cells = read_cells(path, TRACKS_COLUMNS[:5])
    table = cells.copy()
    table["frame"] = read_numbers(cells, "frame", where=path.name, whole=True)
    for name in ("u", "v", "visible", "visible_fraction"):
        if name in cells:
            table[name] = read_numbers(cells, name, where=path.name, empty=True)
    return table
