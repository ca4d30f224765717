"""``pawnb evaluate``: results against truth or tracks made by hand, whatever their kind."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from pawnb.io.tables import read_cells, read_numbers, write_table
from pawnb.schema.arguments import checked_arguments
from pawnb.workflow.evaluation.against_truth import Evaluation, truth_of
from pawnb.workflow.gait.inputs import analyse_source
from pawnb.workflow.gait.sources import read_source
from pawnb.workflow.provenance.results import make_folder, read_result_tracks

EVENT_ERROR_COLUMNS = (
    "leg", "event", "n_true", "n_found", "missed", "extra", "median_frames", "p95_frames",
    "bias_frames",
)  # fmt: skip
_SHARE_OF_STRIDE = 0.25
"""A true event is found where one of its kind is nearer than this share of the leg's stride."""


@checked_arguments
def evaluate(
    results: str | Path,
    truth: str | Path,
    *,
    threshold_px: float | None = None,
    out: str | Path | None = None,
) -> Evaluation:
    """Measure errors against truth or against tracks made by hand.

    Parameters
    ----------
    results : str or Path
        Folder of results, or a ``tracks.nc``.
    truth : str or Path
        Folder with ``pose.csv`` (jointed animals) or ``tracks.csv`` (points), and where the
        truth is known ``events.csv``; or one of the first two files.
    threshold_px : float, optional
        Points further from the truth than this are wrong, and hidden ones within half of it
        are bridged. Default: 20 px in pictures 2048 px wide, in others in proportion.
    out : str or Path, optional
        Folder to write the tables to, as ``evaluation_<name>.csv``.

    Returns
    -------
    Evaluation
        Of jointed animals :func:`pawnb.workflow.evaluation.pose_errors.measure_pose_errors`, over
        the frames in which ``tracks.csv`` says that every tip is visible, where it does (where no
        frame shows every tip, of each leg over those that show its own); of points
        :func:`pawnb.workflow.evaluation.errors.count_errors`. Events: :func:`compare_events`.

    Raises
    ------
    InputError
        If a file is missing or does not fit the results.

    Examples
    --------
    >>> evaluation = pawnb.evaluate("sample/results", "sample/truth")
    >>> evaluation.text != ""
    True
    """
    results, truth = Path(results), Path(truth)
    folder = results if results.is_dir() else results.parent
    tracks = read_result_tracks(results)
    truth_folder = truth if truth.is_dir() else truth.parent
    kind = truth_of(tracks, truth)
    path = truth / kind.file if truth.is_dir() else truth
    found = kind.measure(tracks, path, threshold_px=threshold_px)
    events = truth_folder / "events.csv"
    if truth.is_dir() and events.exists():
        own = analyse_source(read_source(folder)).events
        table = compare_events(own, _true_events(events), fps=float(tracks.attrs["fps"]))
        if len(table):
            found = Evaluation(
                f"{found.text}\n{_say_events(table)}", {**found.tables, "events": table}
            )
    if out is not None:
        out = make_folder(out)
        for name, table in found.tables.items():
            write_table(table, out / f"evaluation_{name}.csv")
    return found


def compare_events(events: pd.DataFrame, truth: pd.DataFrame, *, fps: float) -> pd.DataFrame:
    """Compare the times of events with true ones.

    Parameters
    ----------
    events, truth : pandas.DataFrame
        Columns leg, event, time_s.
    fps : float
        Frames per second.

    Returns
    -------
    pandas.DataFrame
        ``EVENT_ERROR_COLUMNS``, a row for each leg and kind of event that the truth has.
        ``n_found`` of the true events have one of their kind nearer than a quarter of the
        leg's median stride, no two the same; ``missed`` lie within the time of the events that
        were found but have none, ``extra`` are events within the time of the true ones that
        belong to none. Errors are in frames, found less true.
    """
    rows = []
    for (leg, event), true in truth.groupby(["leg", "event"], sort=True):
        at = np.sort(true["time_s"].to_numpy(dtype=float)) * fps
        own = events[(events["leg"] == leg) & (events["event"] == event)]
        found = np.sort(own["time_s"].to_numpy(dtype=float)) * fps
        reach = _SHARE_OF_STRIDE * float(np.median(np.diff(at))) if len(at) > 1 else np.inf
        pairs = _nearest_pairs(found, at, reach)
        errors = np.array([found[i] - at[j] for i, j in pairs])
        matched, used = {j for _, j in pairs}, {i for i, _ in pairs}
        span = events["time_s"].min() * fps, events["time_s"].max() * fps
        missed = sum(span[0] <= t <= span[1] for j, t in enumerate(at) if j not in matched)
        extra = sum(at[0] <= t <= at[-1] for i, t in enumerate(found) if i not in used)
        middle = (
            (np.median(np.abs(errors)), np.percentile(np.abs(errors), 95), errors.mean())
            if len(errors)
            else (np.nan, np.nan, np.nan)
        )
        rows.append((leg, event, len(at), len(pairs), missed, extra, *middle))
    return pd.DataFrame(rows, columns=list(EVENT_ERROR_COLUMNS))


def _nearest_pairs(found: np.ndarray, true: np.ndarray, reach: float) -> list[tuple[int, int]]:
    """Pair found and true times within reach, the nearest first, each once."""
    away = np.abs(found[:, None] - true)
    pairs: list[tuple[int, int]] = []
    for i, j in sorted(np.argwhere(away <= reach).tolist(), key=lambda ij: away[ij[0], ij[1]]):
        if all(i != a and j != b for a, b in pairs):
            pairs.append((i, j))
    return pairs


def _true_events(path: Path) -> pd.DataFrame:
    """Read true events."""
    cells = read_cells(path, ("leg", "event", "time_s"))
    return cells.assign(time_s=read_numbers(cells, "time_s", where=path.name))


def _say_events(table: pd.DataFrame) -> str:
    """Put the errors of events in a few lines."""
    lines = []
    for event, own in table.groupby("event", sort=True):
        lines.append(
            f"{event}: {own['n_found'].sum()} of {own['n_true'].sum()} found, "
            f"{own['missed'].sum()} missed, {own['extra'].sum()} extra; median error "
            f"{own['median_frames'].median():.2f} frames (the median leg)"
        )
    return "\n".join(lines)
