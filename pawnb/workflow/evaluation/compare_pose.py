"""The comparison of methods on jointed animals with truth: errors of each, over trials."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pawnb.io.tables import write_table
from pawnb.trial import Trial
from pawnb.workflow.evaluation.against_truth import PoseTruth
from pawnb.workflow.evaluation.compared import open_compared
from pawnb.workflow.provenance.results import make_folder
from pawnb.workflow.tracking.methods import POSE_METHODS
from pawnb.workflow.tracking.track import track

POSE_TRUTH = Path("truth") / PoseTruth.file
POSE_COMPARISON_COLUMNS = ("trial", "method", "measure", "value", "unit")
POSE_SUMMARY_COLUMNS = ("method", "measure", "unit", "n_trials", "mean", "sd")
_TIME = "time"


@dataclass(frozen=True)
class PoseComparison:
    """What a comparison of methods on jointed animals yields.

    Parameters
    ----------
    trials : DataFrame
        One row a trial, method and measure: those of
        :func:`pawnb.workflow.evaluation.pose_errors.measure_pose_errors`, and the time of tracking,
        s a frame, decoding included.
    summary : DataFrame
        Mean and SD over trials of each; SD blank with one trial.
    """

    trials: pd.DataFrame
    summary: pd.DataFrame

    def text(self) -> str:
        """Return the summary in plain text."""
        lines = []
        for method, own in self.summary.groupby("method", sort=False):
            lines.append(f"{method}: {own['n_trials'].max()} trials")
            for row in own.to_dict("records"):
                spread = f" (SD {row['sd']:.4g})" if np.isfinite(row["sd"]) else ""
                lines.append(
                    f"  {row['measure']}: {row['mean']:.4g} {row['unit']}".rstrip() + spread
                )
        return "\n".join(lines)


def compare_pose_methods(
    trials: Sequence[Trial | str | Path],
    *,
    methods: Sequence[str] = POSE_METHODS,
    settings: Mapping[str, Any] | None = None,
    frames: tuple[int, int] | None = None,
    out: str | Path | None = None,
    progress: Callable[[int, int], None] | None = None,
    report: Callable[[str], None] | None = None,
) -> PoseComparison:
    """Track jointed animals with truth by several methods, and compare their errors.

    Parameters
    ----------
    trials : sequence of Trial, str or Path
        Trials of kind ``pose`` with the truth in ``truth/pose.csv``.
    methods : sequence of str
        Methods of :func:`pawnb.track`; default both.
    settings : mapping, optional
        As for :func:`pawnb.workflow.evaluation.compare.compare_methods`.
    frames : tuple of int, optional
        Half-open range of frames; default all.
    out : str or Path, optional
        Folder for ``comparison.csv`` and ``comparison_summary.csv``.
    progress, report
        As for :func:`pawnb.workflow.evaluation.compare.compare_methods`.

    Returns
    -------
    PoseComparison
        The tables.

    Raises
    ------
    InputError
        If a trial has no truth, is of another kind, or two have the same name, or a method is
        unknown.
    """
    opened, own_settings = open_compared(
        trials, "pose", methods=methods, settings=settings, truth=POSE_TRUTH,
        or_else=", others are of kind 'pose'; compare trials of one kind.",
    )  # fmt: skip
    truth = PoseTruth()
    rows: list[tuple[str, str, str, float, str]] = []
    for trial in opened:
        for method in methods:
            begun = time.perf_counter()
            tracks = track(
                trial, method=method, settings=own_settings[method], frames=frames,
                progress=progress,
            )  # fmt: skip
            took = (time.perf_counter() - begun) / tracks.sizes["time"]
            found = truth.measure(tracks, trial.folder / POSE_TRUTH).tables["summary"]
            own = [tuple(row) for row in found[["measure", "value", "unit"]].to_numpy().tolist()]
            own.append((_TIME, took, "s a frame"))
            rows += [(trial.name, method, *row) for row in own]
            if report is not None:
                said = [f"{name} {value:.4g} {unit}" for name, value, unit in own if "RMS" in name]
                report(f"{trial.name}, {method}: {'; '.join(said)}; {took:.3f} s a frame")
    table = pd.DataFrame(rows, columns=list(POSE_COMPARISON_COLUMNS))
    groups = table.groupby(["method", "measure", "unit"], sort=False)["value"]
    summary = groups.agg(n_trials="count", mean="mean", sd="std").reset_index()
    comparison = PoseComparison(table, summary[list(POSE_SUMMARY_COLUMNS)])
    if out is not None:
        folder = make_folder(out)
        write_table(comparison.trials, folder / "comparison.csv")
        write_table(comparison.summary, folder / "comparison_summary.csv")
    return comparison
