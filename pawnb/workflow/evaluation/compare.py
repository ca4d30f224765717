"""The comparison of methods on trials with truth (Haji Maghsoudi et al. 2019, section 4).

Errors as in :mod:`pawnb.workflow.evaluation.errors`, with corrections (as the paper counts) and
without; the time of tracking; reprojection errors by camera and paw, and the t-tests
between cameras (Table 1, Table 2, Fig. 7). Trials are the unit: means and SDs are
those of the trials' values.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pawnb import figures
from pawnb.core.compiled import time_compiling
from pawnb.core.video import open_views
from pawnb.figures.panels import apart_from_pyplot
from pawnb.io.tables import write_table
from pawnb.schema import Tracks
from pawnb.trial import Trial
from pawnb.workflow.evaluation.against_truth import PointTruth
from pawnb.workflow.evaluation.compare_cameras import (
    compare_cameras,
    describe_reprojection,
    describe_tests,
    measure_reprojection,
)
from pawnb.workflow.evaluation.compared import open_compared
from pawnb.workflow.evaluation.corrected_run import track_with_corrections
from pawnb.workflow.evaluation.errors import count_errors, limits_for_width, poisson_limit
from pawnb.workflow.gait.drawing.save_figures import save_figure
from pawnb.workflow.provenance.labels import label_inputs
from pawnb.workflow.provenance.record import build_step, file_checksum
from pawnb.workflow.provenance.results import make_folder
from pawnb.workflow.tracking.methods import PAW_METHODS
from pawnb.workflow.tracking.track import retrack, track

POINT_TRUTH = Path("truth") / PointTruth.file

COMPARISON_COLUMNS = (
    "trial", "method", "n_frames", "time_s_per_1000", "major_per_1000", "minor_per_1000",
    "major_alone_per_1000", "minor_alone_per_1000", "share_wrong_alone", "median_px", "p95_px",
    "major", "minor", "major_alone", "minor_alone", "median_px_centred", "p95_px_centred",
)  # fmt: skip
SUMMARY_COLUMNS = ("method", "n_trials", "n_frames", "measure", "mean", "sd", "count", "limit")
REPROJECTION_COLUMNS = ("trial", "method", "view", "point", "kind", "n", "mean_px", "sd_px")
_COLUMN_TYPES = {"trial": str, "method": str, "view": str, "point": str, "kind": str}
_MEASURES = ("time_s_per_1000", "major_per_1000", "minor_per_1000",
             "major_alone_per_1000", "minor_alone_per_1000")  # fmt: skip


@dataclass(frozen=True)
class MethodComparison:
    """What a comparison yields.

    Parameters
    ----------
    trials : DataFrame
        One row a trial and method. ``major_per_1000`` counts corrections and
        ``minor_per_1000`` what is left after them, both per 1000 frames of all views
        together; ``..._alone`` is without corrections. ``time_s_per_1000``: seconds of
        tracking for 1000 frames, decoding included; corrections, and compiling in the first
        run, are left out. The paper's time includes corrections by its user. ``median_px`` and
        ``p95_px`` are the distances of visible labels from the truth, without corrections;
        ``..._centred`` with the constant offset of each track removed. ``major``, ``minor``,
        ``..._alone``: the counts.
    summary : DataFrame
        Table 2: mean and SD over trials of each measure; SD blank with one trial. Of errors
        ``count``, over all trials, and ``limit``, the upper end of the exact 95 % interval of
        the rate per 1000 frames.
    reprojection : DataFrame
        Reprojection error, px, of each trial, method, view and point, as
        :func:`pawnb.workflow.evaluation.compare_cameras.measure_reprojection` has it.
    tests : DataFrame
        Table 1: Welch's t-test of the reprojection error between every two cameras, for
        front and hind paws. ``t`` and ``p`` count frames as if they were independent,
        as the paper seems to; ``t_trials`` and ``p_trials`` count trials (their means) and
        are blank with fewer than two.
    """

    trials: pd.DataFrame
    summary: pd.DataFrame
    reprojection: pd.DataFrame
    tests: pd.DataFrame

    def text(self) -> str:
        """Return Table 2, the reprojection errors and Table 1 in plain text."""
        lines = []
        if self.trials["major_per_1000"].isna().all():
            lines.append("No corrections were made: errors are those of the trackers alone.")
        for method, own in self.summary.groupby("method", sort=False):
            first = own.iloc[0]
            lines.append(f"{method}: {first['n_trials']} trials, {first['n_frames']} frames")
            for row in own.to_dict("records"):
                spread = f" (SD {row['sd']:.2f})" if np.isfinite(row["sd"]) else ""
                if np.isfinite(row["count"]):
                    spread += f"; {row['count']:.0f} in all, 95 % limit {row['limit']:.2f}"
                lines.append(f"  {row['measure']:<22} {row['mean']:8.2f}{spread}")
        lines += [describe_reprojection(self.reprojection), describe_tests(self.tests)]
        return "\n".join(part for part in lines if part)


def compare_methods(
    trials: Sequence[Trial | str | Path],
    *,
    methods: Sequence[str] = PAW_METHODS,
    settings: Mapping[str, Any] | None = None,
    frames: tuple[int, int] | None = None,
    corrections: bool = True,
    out: str | Path | None = None,
    progress: Callable[[int, int], None] | None = None,
    report: Callable[[str], None] | None = None,
) -> MethodComparison:
    """Track trials with truth by several methods, and compare them as the 2019 paper does.

    Parameters
    ----------
    trials : sequence of Trial, str or Path
        Trials with the truth in ``truth/tracks.csv``.
    methods : sequence of str
        Methods of :func:`pawnb.track`; default all.
    settings : mapping, optional
        Settings of the tracker, given to every method that has one of that name. A name
        with a method before it, as in ``"paper.n_superpixels"``, is for that method only.
    frames : tuple of int, optional
        Half-open range of frames; default all. Where paws were clicked in a later one, the
        published methods have only the frames from there on, and their rates are of those.
    corrections : bool
        Whether to count with corrections as well, which tracks again after each; without,
        ``major_per_1000`` and ``minor_per_1000`` are blank.
    out : str or Path, optional
        Folder for ``comparison.csv``, ``comparison_summary.csv``, ``reprojection.csv``,
        ``reprojection_tests.csv`` and the figure ``compare_methods``.
    progress : callable, optional
        ``progress(done, total)`` while a trial is tracked; default a bar on a terminal.
    report : callable, optional
        Told in one line what was done, after each trial and method.

    Returns
    -------
    MethodComparison
        The tables.

    Raises
    ------
    InputError
        If a trial has no truth or two have the same name, or a method is unknown.
    """
    opened, own_settings = open_compared(
        trials, "paws", methods=methods, settings=settings, truth=POINT_TRUTH,
        or_else="; expected kind 'paws', or every trial of kind 'pose'.",
    )  # fmt: skip
    rows, errors = [], []
    samples: dict[tuple[str, str, str, str, str], np.ndarray] = {}
    for trial in opened:
        truth = pd.read_csv(trial.folder / POINT_TRUTH)
        limits = _limits(trial)
        for method in methods:
            row, tracks = _run(
                trial, truth, limits, method=method, settings=own_settings[method], frames=frames,
                corrections=corrections, progress=progress,
            )  # fmt: skip
            rows.append(row)
            if report is not None:
                report(_line(row))
            for (view, point, kind), values in measure_reprojection(trial, tracks).items():
                errors.append((trial.name, method, view, point, kind, len(values),
                               float(values.mean()), _sd(values)))  # fmt: skip
                samples[trial.name, method, view, point, kind] = values
    table = pd.DataFrame(rows, columns=list(COMPARISON_COLUMNS))
    comparison = MethodComparison(
        trials=table,
        summary=_summarise(table),
        reprojection=pd.DataFrame(errors, columns=list(REPROJECTION_COLUMNS)),
        tests=compare_cameras(samples),
    )
    if out is not None:
        _write(comparison, make_folder(out), settings or {})
    return comparison


def _limits(trial: Trial) -> dict[str, Any]:
    """Return the limits of an error in the pixels of a trial."""
    with open_views(trial) as views:
        width = max(reader.width for reader in views.readers.values())
    points = {view.name: view.points for view in trial.views if view.points}
    threshold = limits_for_width(width)[0]
    return {"points_by_view": points or None, "threshold_px": threshold}


def _run(
    trial: Trial,
    truth: pd.DataFrame,
    limits: Mapping[str, Any],
    *,
    method: str,
    settings: Mapping[str, Any] | None,
    frames: tuple[int, int] | None,
    corrections: bool,
    progress: Callable[[int, int], None] | None,
) -> tuple[dict[str, Any], Tracks]:
    """Track one trial by one method; return its row, and the tracks after corrections."""
    begun = time.perf_counter()
    with time_compiling() as compiling:
        tracks = track(trial, method=method, settings=settings, frames=frames, progress=progress)
        # once on a machine, however many trials there are
        took = time.perf_counter() - begun - compiling()
    alone = count_errors(tracks, truth, **limits)
    row = {
        "trial": trial.name,
        "method": method,
        "n_frames": alone.n_frames,
        "time_s_per_1000": 1000.0 * took / tracks.sizes["time"],
        "major_per_1000": np.nan,
        "minor_per_1000": np.nan,
        "major_alone_per_1000": alone.major_per_1000,
        "minor_alone_per_1000": alone.minor_per_1000,
        "share_wrong_alone": alone.share_wrong,
        "median_px": alone.median_px,
        "p95_px": alone.p95_px,
        "major": np.nan,
        "minor": np.nan,
        "major_alone": alone.major,
        "minor_alone": alone.minor,
        "median_px_centred": alone.median_px_centred,
        "p95_px_centred": alone.p95_px_centred,
    }
    if corrections:
        run = track_with_corrections(
            tracks,
            truth,
            lambda tracks, frame: retrack(trial, tracks, frame, progress=lambda _done, _of: None),
            **limits,
        )
        tracks = run.tracks
        row["major_per_1000"] = run.interventions_per_1000
        row["minor_per_1000"] = run.report.minor_per_1000
        row["major"], row["minor"] = len(run.interventions), run.report.minor
    return row, tracks


def _line(row: Mapping[str, Any]) -> str:
    """Return one line about one trial and method."""
    counted = "" if np.isnan(row["major_per_1000"]) else (
        f"{row['major_per_1000']:.1f} corrections and {row['minor_per_1000']:.1f} minor errors "
        "per 1000 frames; "
    )  # fmt: skip
    return (
        f"{row['trial']}, {row['method']}: {counted}without corrections "
        f"{row['major_alone_per_1000']:.1f} major, {row['minor_alone_per_1000']:.1f} minor, "
        f"{row['share_wrong_alone']:.1%} of labels wrong; "
        f"{row['time_s_per_1000'] / 1000.0:.3f} s a frame"
    )


def _summarise(table: pd.DataFrame) -> pd.DataFrame:
    """Mean and SD over trials of each method and measure (Table 2)."""
    rows = []
    for method, own in table.groupby("method", sort=False):
        for measure in _MEASURES:
            values = own[measure].dropna().to_numpy()
            if len(values):
                frames = int(own["n_frames"].sum())
                found = limit = float("nan")
                if measure.removesuffix("_per_1000") in own:
                    found = float(own[measure.removesuffix("_per_1000")].sum())
                    limit = 1000.0 * poisson_limit(int(found)) / frames
                rows.append((method, len(own), frames, measure, float(values.mean()),
                             _sd(values), found, limit))  # fmt: skip
    return pd.DataFrame(rows, columns=list(SUMMARY_COLUMNS))


def _sd(values: np.ndarray) -> float:
    """Return the sample's standard deviation; NaN of one value."""
    return float(np.std(values, ddof=1)) if len(values) > 1 else float("nan")


def _write(comparison: MethodComparison, out: Path, settings: Mapping[str, Any]) -> None:
    """Write the tables and the figure."""
    for name, table in (
        ("comparison", comparison.trials),
        ("comparison_summary", comparison.summary),
        ("reprojection", comparison.reprojection),
        ("reprojection_tests", comparison.tests),
    ):
        write_table(table, out / f"{name}.csv")
    drawn_from = [out / f"{name}.csv" for name in ("comparison", "reprojection")]
    draw_comparison(drawn_from, out, settings=settings)


def draw_comparison(
    tables: Sequence[Path],
    out: Path,
    *,
    settings: Mapping[str, Any],
    labels: Mapping[str, Path] | None = None,
) -> None:
    """Draw the comparison from its tables on disk, so that the figure can be drawn again of them.

    Times differ from run to run: the tables, not the trials, are what the figure is made from.

    Parameters
    ----------
    tables : sequence of Path
        ``comparison.csv`` and ``reprojection.csv``.
    out : Path
        Folder for ``compare_methods`` as csv, png, pdf and svg.
    settings : mapping
        Settings of the methods, for the recipe.
    labels : mapping, optional
        What the recipe calls each table, to the table; default folder and name.
    """
    named = labels or {label: path for path, label in label_inputs(tables).items()}
    trials, errors = (pd.read_csv(path, dtype=_COLUMN_TYPES) for path in tables)
    drawn = figures.build_compare_methods_table(trials, errors)
    step = build_step(
        "compare",
        command=None,
        inputs={label: file_checksum(path) for label, path in named.items()},
        settings=json.loads(json.dumps(dict(settings))),
    )
    out.mkdir(parents=True, exist_ok=True)
    with figures.style(), apart_from_pyplot():
        axes = figures.plot_compare_methods(drawn)
        record = {**step, "figure": "compare_methods", "name": "compare_methods"}
        save_figure(axes, out / "compare_methods", record=record)
    write_table(drawn, out / "compare_methods.csv")
