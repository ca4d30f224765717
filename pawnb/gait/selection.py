"""Which trials run steadily and straight.

Pullar 2009, sections 3.6 and 3.7: only trials of reasonably constant speed and little deviation
in heading were used.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pandas as pd

from pawnb.errors import InputError
from pawnb.gait.analysis.tables import GaitTables
from pawnb.gait.phases.phase_table import summarise_phases
from pawnb.gait.strides.stride_table import TRIAL_KEYS
from pawnb.schema import DROPPED_COLUMNS, check_columns
from pawnb.schema.arguments import checked_arguments

STEADINESS_COLUMNS = (
    "animal", "trial", "n_strides", "speed", "speed_cv", "heading_deg", "heading_sd_deg", "steady",
    "why",
)  # fmt: skip


@checked_arguments
def steadiness(
    strides: pd.DataFrame,
    *,
    max_speed_cv: float = 0.2,
    max_heading_sd_deg: float = 10.0,
    min_strides: int = 2,
) -> pd.DataFrame:
    """Say of each trial whether the animal ran steadily and straight.

    Parameters
    ----------
    strides : pandas.DataFrame
        Strides, with ``speed`` and, where the heading is known, ``heading_deg``.
    max_speed_cv : float
        Greatest coefficient of variation of the speed over strides.
    max_heading_sd_deg : float
        Greatest circular standard deviation of the heading over strides, degrees.
    min_strides : int
        Fewest strides of the leg with the fewest.

    Returns
    -------
    pandas.DataFrame
        ``STEADINESS_COLUMNS``, one row a trial; ``why`` says what speaks against it, with the
        threshold. What is not known (no speed, no heading) speaks against nothing.

    Raises
    ------
    InputError
        If a threshold is not positive.
    """
    check_columns(strides, ("animal", "trial", "leg", "speed"), where="strides")
    limits = {"max_speed_cv": max_speed_cv, "max_heading_sd_deg": max_heading_sd_deg}
    for name, limit in limits.items():
        if not limit > 0:
            raise InputError(f"{name} is {limit}; expected a number above 0.")
    rows: list[dict[str, Any]] = []
    for (animal, trial), own in strides.groupby(TRIAL_KEYS, sort=False):
        speed = own["speed"].dropna().to_numpy(dtype=float)
        cv = float(speed.std(ddof=1) / abs(speed.mean())) if len(speed) > 1 else np.nan
        heading, spread = _heading(own)
        fewest = int(own.groupby("leg").size().min())
        why = []
        if fewest < min_strides:
            why.append(f"{fewest} stride(s) of a leg; at least {min_strides} wanted")
        if cv > max_speed_cv:
            why.append(f"speed varies by {cv:.0%}; at most {max_speed_cv:.0%} wanted")
        if spread > max_heading_sd_deg:
            why.append(
                f"heading varies by {spread:.0f} degrees; at most {max_heading_sd_deg:g} wanted"
            )
        rows.append(
            {
                "animal": animal,
                "trial": trial,
                "n_strides": len(own),
                "speed": speed.mean() if len(speed) else np.nan,
                "speed_cv": cv,
                "heading_deg": heading,
                "heading_sd_deg": spread,
                "steady": not why,
                "why": "; ".join(why),
            }
        )
    return pd.DataFrame(rows, columns=list(STEADINESS_COLUMNS))


def _heading(strides: pd.DataFrame) -> tuple[float, float]:
    """Return mean and circular standard deviation of the heading, degrees."""
    known = strides["heading_deg"].dropna() if "heading_deg" in strides else pd.Series(dtype=float)
    if known.empty:
        return np.nan, np.nan
    vector = np.exp(1j * np.radians(known.to_numpy(dtype=float))).mean()
    spread = np.degrees(np.sqrt(max(0.0, -2.0 * np.log(min(abs(vector), 1.0)))))
    return float(np.degrees(np.angle(vector))), float(spread)


@checked_arguments
def select_steady(tables: GaitTables, **thresholds: float) -> GaitTables:
    """Keep the trials that run steadily and straight; the others are listed as dropped.

    Parameters
    ----------
    tables : GaitTables
        The result of an analysis, of one or more trials.
    **thresholds
        As for :func:`steadiness`.

    Returns
    -------
    GaitTables
        Strides, phases and their summary of the steady trials; ``dropped`` says of each other
        trial why, ``notes`` how many were kept. Events and signals stay as they are.

    Raises
    ------
    InputError
        If no trial is steady.
    """
    table = steadiness(tables.strides, **thresholds)  # type: ignore[arg-type]
    kept = table[table["steady"]]
    if kept.empty:
        first = table["why"].iloc[0] if len(table) else "there is no stride"
        raise InputError(
            f"none of {len(table)} trials is steady ({first}); raise max_speed_cv or "
            "max_heading_sd_deg."
        )
    wanted = pd.MultiIndex.from_frame(kept[TRIAL_KEYS])

    def steady_rows(one: pd.DataFrame) -> pd.DataFrame:
        return one[pd.MultiIndex.from_frame(one[TRIAL_KEYS]).isin(wanted)].reset_index(drop=True)

    out = table[~table["steady"]]
    spans = tables.strides.groupby(TRIAL_KEYS, sort=False)["start_s"].agg(["min", "max"])
    lost = [
        {
            **{key: row[key] for key in TRIAL_KEYS},
            "leg": "",
            "start_s": spans.loc[(row["animal"], row["trial"]), "min"],
            "end_s": spans.loc[(row["animal"], row["trial"]), "max"],
            "what": "trial",
            "why": row["why"],
        }
        for row in out.to_dict("records")
    ]
    phases = steady_rows(tables.phases)
    dropped = pd.concat(
        [tables.dropped, pd.DataFrame(lost, columns=list(DROPPED_COLUMNS))], ignore_index=True
    ) if lost else tables.dropped  # fmt: skip
    return dataclasses.replace(
        tables,
        strides=steady_rows(tables.strides),
        phases=phases,
        phase_summary=summarise_phases(phases),
        dropped=dropped,
        notes=(*tables.notes, f"{len(kept)} of {len(table)} trials are steady and were kept."),
    )
