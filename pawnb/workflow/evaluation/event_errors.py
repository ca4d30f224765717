"""Times of events against the true ones: AEP and PEP, or touch-down and lift-off."""

from __future__ import annotations

import numpy as np
import pandas as pd

from pawnb.errors import InputError
from pawnb.schema import check_columns

EVENT_COLUMNS = ("leg", "event", "frame_true", "frame_found", "difference")


def measure_event_errors(
    found: pd.DataFrame, truth: pd.DataFrame, *, window_frames: float | None = None
) -> pd.DataFrame:
    """Compare the times of events with the true ones.

    Parameters
    ----------
    found, truth : DataFrame
        Columns leg, event, frame (fractional), as in ``events.csv``.
    window_frames : float, optional
        Farthest apart that two events can be the same. Default: a quarter of the median time
        between true events of one kind and leg; where there is none, 5 frames.

    Returns
    -------
    DataFrame
        ``EVENT_COLUMNS``, one row an event: NaN in ``frame_found`` where a true event was
        missed, NaN in ``frame_true`` where there is none. ``difference`` is found less true,
        frames. Nearest pairs are matched first, each event once; true events outside the time
        from the leg's first to its last found event, and a window around it, are left out.

    Raises
    ------
    InputError
        If a column is missing or nothing was found.
    """
    for table, where in ((found, "events found"), (truth, "true events")):
        check_columns(table, ("leg", "event", "frame"), where=where, cells=False)
    if found.empty:
        raise InputError("no events were found; there is nothing to compare.")
    window = _event_window(truth) if window_frames is None else window_frames
    rows: list[tuple[str, str, float, float, float]] = []
    for (leg, event), own in found.groupby(["leg", "event"], sort=True):
        at = np.sort(own["frame"].to_numpy(dtype=float))
        true = truth.loc[(truth["leg"] == leg) & (truth["event"] == event), "frame"]
        there = np.sort(true.to_numpy(dtype=float))
        there = there[(there >= at[0] - window) & (there <= at[-1] + window)]
        rows += [(str(leg), str(event), t, f, f - t) for t, f in _match(there, at, window)]
    return pd.DataFrame(rows, columns=list(EVENT_COLUMNS))


def _match(true: np.ndarray, found: np.ndarray, window: float) -> list[tuple[float, float]]:
    """Pair events, nearest first; NaN for those left over."""
    apart = np.abs(true[:, None] - found[None, :])
    pairs, used_true, used_found = [], set(), set()
    for k in np.argsort(apart, axis=None, kind="stable"):
        i, j = divmod(int(k), len(found))
        if apart[i, j] <= window and i not in used_true and j not in used_found:
            pairs.append((float(true[i]), float(found[j])))
            used_true.add(i)
            used_found.add(j)
    pairs += [(float(t), np.nan) for i, t in enumerate(true) if i not in used_true]
    pairs += [(np.nan, float(f)) for j, f in enumerate(found) if j not in used_found]
    return sorted(pairs, key=lambda pair: np.nanmin(pair))


def _event_window(truth: pd.DataFrame) -> float:
    """Return a quarter of the median period of true events."""
    periods = truth.sort_values("frame").groupby(["leg", "event"])["frame"].diff().dropna()
    return 0.25 * float(periods.median()) if len(periods) else 5.0
