"""A tracker that is corrected with the truth wherever it is lost, as a person would."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from pawnb.schema import ORIGIN_CODE, Tracks
from pawnb.workflow.evaluation.errors import (
    RECOVERY_FRAMES,
    SETTLED_FRAMES,
    THRESHOLD_PX,
    ErrorReport,
    count_errors,
)


@dataclass(frozen=True)
class CorrectedRun:
    """Tracks that were corrected with the truth wherever the tracker was lost.

    Parameters
    ----------
    tracks : xarray.Dataset
        The corrected tracks.
    interventions : DataFrame
        frame, point: one row for each correction of one point.
    report : ErrorReport
        What is left; its major errors are those that corrections did not reach.
    """

    tracks: Tracks
    interventions: pd.DataFrame
    report: ErrorReport

    @property
    def interventions_per_1000(self) -> float:
        """Corrections per 1000 frames of all views: the paper's major errors."""
        return 1000.0 * len(self.interventions) / self.report.n_frames


def track_with_corrections(
    tracks: Tracks,
    truth: pd.DataFrame,
    retrack: Callable[[Tracks, int], Tracks],
    *,
    points_by_view: Mapping[str, Sequence[str]] | None = None,
    threshold_px: float = THRESHOLD_PX,
    recovery_frames: int = RECOVERY_FRAMES,
    settled_frames: int = SETTLED_FRAMES,
    max_interventions: int = 200,
) -> CorrectedRun:
    """Correct every major error as a person would, track on from there, and count.

    Where a major error begins, the truth is put in place in that frame, for that point, in
    the views where it is visible, and tracking goes on from there; that is one
    intervention. Minor errors are left alone.

    Parameters
    ----------
    tracks : xarray.Dataset
        What the tracker made by itself.
    truth : DataFrame
        As for :func:`pawnb.workflow.evaluation.errors.count_errors`.
    retrack : callable
        ``retrack(tracks, frame)`` tracks on from a corrected frame and returns all
        tracks, such as :func:`pawnb.workflow.tracking.track.retrack` for one trial.
    points_by_view, threshold_px, recovery_frames, settled_frames
        As for :func:`pawnb.workflow.evaluation.errors.count_errors`.
    max_interventions : int
        Stop after so many.

    Returns
    -------
    CorrectedRun
        Corrected tracks, interventions, and the errors that are left.
    """
    limits: dict[str, Any] = {
        "points_by_view": points_by_view,
        "threshold_px": threshold_px,
        "recovery_frames": recovery_frames,
        "settled_frames": settled_frames,
    }
    done: list[tuple[int, str]] = []
    while True:
        report = count_errors(tracks, truth, **limits)
        major = report.errors[report.errors["kind"] == "major"]
        todo = [
            (frame, point)
            for frame, point in zip(major["first_frame"], major["point"], strict=True)
            if (frame, point) not in done
        ]
        if not todo or len(done) >= max_interventions:
            break
        frame = todo[0][0]
        points = [point for f, point in todo if f == frame]
        tracks = retrack(_place_truth(tracks, truth, frame, points), frame)
        done += [(frame, point) for point in points]
    table = pd.DataFrame(done, columns=["frame", "point"])
    return CorrectedRun(tracks, table, report)


def _place_truth(tracks: Tracks, truth: pd.DataFrame, frame: int, points: Sequence[str]) -> Tracks:
    """Put the visible truth of some points in place in one frame, as if by hand."""
    tracks = tracks.copy(deep=True)
    row = int(np.flatnonzero(tracks["frame"].to_numpy() == frame)[0])
    views = tracks["view"].to_numpy().tolist()
    names = tracks["keypoint"].to_numpy().tolist()
    here = truth[(truth["frame"] == frame) & truth["point"].isin(points)]
    if "visible" in here:
        here = here[here["visible"] > 0]
    for point in points:
        p = names.index(point)
        shown = tracks["image_origin"][:, :, p, 0].to_numpy() == ORIGIN_CODE["reprojected"]
        ever = (np.isfinite(tracks["image_position"][:, :, 0, p, 0].to_numpy()) & ~shown).any(
            axis=0
        )
        # where the truth is hidden, what was tracked is not known to be right
        tracks["image_position"][row, :, :, p, 0] = np.nan
        tracks["image_origin"][row, :, p, 0] = ORIGIN_CODE["missing"]
        tracks["image_confidence"][row, :, p, 0] = 0.0
        for label in here[here["point"] == point].itertuples(index=False):
            if label.view not in views or not ever[views.index(label.view)]:
                continue
            v = views.index(label.view)
            tracks["image_position"][row, v, :, p, 0] = [label.u, label.v]
            tracks["image_origin"][row, v, p, 0] = ORIGIN_CODE["edited"]
            tracks["image_confidence"][row, v, p, 0] = 1.0
    return tracks
