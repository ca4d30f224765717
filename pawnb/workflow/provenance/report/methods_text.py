"""The methods paragraph of a gait analysis: what was done, with how many, and what was left out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from pawnb.gait import GaitTables
from pawnb.schema import Tracks
from pawnb.workflow.provenance.report.tracking_text import tracking_sentences

_FILTER = (
    "a zero-phase Butterworth low-pass of fourth order (both passes together; half power at the "
    "cut-off)"
)
_PROGRAMS = ("numpy", "scipy", "pandas", "xarray", "matplotlib")
SOURCES = {
    "pullar": "Pullar K (2009) Markerless motion capture applied to the analysis of locomotor "
    "kinematics in the semi-aquatic hunting spider. Thesis.",
    "paper": "Haji Maghsoudi O, Vahedipour A, Spence A (2019) A novel method for robust markerless "
    "tracking of rodent paws in 3D. EURASIP Journal on Image and Video Processing.",
    "holm": "Holm S (1979) A simple sequentially rejective multiple test procedure. Scand. J. "
    "Statist. 6: 65-70.",
    "maris": "Maris E, Oostenveld R (2007) Nonparametric statistical testing of EEG- and MEG-data. "
    "J. Neurosci. Methods 164: 177-190.",
    "zar": "Zar JH (2010) Biostatistical Analysis. 5th ed. Pearson. (Rayleigh's test)",
}


def methods_paragraphs(
    tables: GaitTables,
    further: Mapping[str, pd.DataFrame],
    *,
    step: Mapping[str, Any],
    tracked: Sequence[Tracks] = (),
) -> list[str]:
    """Say in prose what an analysis did.

    Parameters
    ----------
    tables : GaitTables
        The analysis.
    further : mapping
        Its tables of statistics by name.
    step : mapping
        The record of the run.
    tracked : sequence of xarray.Dataset, optional
        The tracks that events were found in.

    Returns
    -------
    list of str
        Paragraphs: data, events and filter, statistics, what was dropped, programs and sources.
    """
    tracking = tracking_sentences(tracked)
    said = [_data(tables), *([tracking] if tracking else []), _events(tables, step)]
    return [
        *said,
        _statistics(tables, further),
        _dropped(tables),
        _programs(step),
        _sources(tables, further, step),
    ]


def _data(tables: GaitTables) -> str:
    """Say of whom, and how many strides."""
    who = tables.events[["animal", "trial"]].drop_duplicates()
    strides = tables.strides
    by_leg = ", ".join(f"{leg} {n}" for leg, n in strides.groupby("leg", sort=False).size().items())
    counted = _number(who["animal"].nunique(), "animal")
    return (
        f"Gait was analysed in {_number(len(who), 'trial')} of {counted}: "
        f"{_number(len(strides), 'stride')}{f' ({by_leg})' if by_leg else ''}."
    )


def _events(tables: GaitTables, step: Mapping[str, Any]) -> str:
    """Say how events were found and strides made of them."""
    counts = tables.events.groupby(["event", "method"], sort=False).size().reset_index(name="n")
    found = ", ".join(f"{row.event} ({row.method}, {row.n})" for row in counts.itertuples())
    settings = step["settings"]
    cutoff = settings.get("cutoff_hz")
    filtered = (
        f" at {cutoff:g} Hz"
        if cutoff is not None
        else " at ten times the stride frequency of the trial, and not at all where that is too "
        "near the frame rate (the notes say it trial by trial)"
    )
    own = step.get("settings_of_trials") or {}
    told = "; ".join(
        f"{who}: " + ", ".join(f"{name} {value}" for name, value in changed.items())
        for who, changed in own.items()
    )
    smoothed = f" Positions were smoothed by {_FILTER}{filtered}." if tables.signals else ""
    return (
        f"Events: {found or 'none'}.{smoothed} A stride runs from AEP (or touch-down, where only "
        "contact is known) to the next of the same leg."
        + (f" Settings of single trials: {told}." if told else "")
    )


def _statistics(tables: GaitTables, further: Mapping[str, pd.DataFrame]) -> str:
    """Name the tests that were made, as the tables name them."""
    said = []
    animals = tables.events["animal"].nunique()
    if len(tables.phase_summary) and animals > 1:
        said.append(
            "Mean phases are circular means over animals, each counted once, with 95 % intervals "
            "and Rayleigh's test"
        )
    for name, words in (("groups", "Groups were compared by"), ("legs", "Legs were compared by")):
        table = further.get(name)
        if table is not None and "method" in table:
            methods = dict.fromkeys(str(m).split(",")[0] for m in table["method"].dropna())
            said.append(f"{words} {' and '.join(methods)}")
    if "groups" in further:
        design = str(further["groups"]["design"].iloc[0])
        said.append(
            f"The design is {design}; within a measure p was adjusted by Holm's method, and p over "
            "all measures is given beside it"
        )
    if "curve_clusters" in further:
        counted = " or ".join(dict.fromkeys(further["curve_clusters"]["method"].astype(str)))
        said.append(
            "Curves over the stride were compared by cluster permutation tests over animals "
            f"({counted}; clusters of points whose t has p below 0.05)"
        )
    if "scaling" in further:
        said.append(
            "Exponents of size are least squares on logarithms, one point an animal, with 95 % "
            "intervals"
        )
    if said:
        return ". ".join(said) + "."
    alone = ", as there is one animal only: strides are described, and nothing is tested"
    return f"No statistics over animals were made{alone if animals == 1 else ''}."


def _dropped(tables: GaitTables) -> str:
    """Count what was left out, by reason."""
    dropped = tables.dropped
    if dropped.empty:
        return "Nothing was left out."
    counts = count_dropped(dropped, ["what", "why"])
    told = "; ".join(f"{row.n} x {row.what}: {row.why}" for row in counts.head(12).itertuples())
    more = f"; and {len(counts) - 12} further reasons (dropped.csv)" if len(counts) > 12 else ""
    return f"Left out: {told}{more}."


def count_dropped(dropped: pd.DataFrame, by: Sequence[str]) -> pd.DataFrame:
    """Count what was left out by reason, whichever stride of a trial it was.

    Parameters
    ----------
    dropped : pandas.DataFrame
        ``dropped.csv``.
    by : sequence of str
        Columns to count by.

    Returns
    -------
    pandas.DataFrame
        These columns and ``n``, the most frequent first.
    """
    any_stride = dropped["why"].astype(str).str.replace(r"\bstride \d+\b", "a stride", regex=True)
    counts = dropped.assign(why=any_stride).groupby(list(by), sort=True).size()
    return counts.reset_index(name="n").sort_values("n", ascending=False, kind="stable")


def _programs(step: Mapping[str, Any]) -> str:
    """Name the programs and their versions."""
    versions = step["versions"]
    others = ", ".join(f"{name} {versions[name]}" for name in _PROGRAMS if name in versions)
    return f"pawnb {versions['pawnb']} on Python {versions['python']} ({others})."


def _sources(
    tables: GaitTables, further: Mapping[str, pd.DataFrame], step: Mapping[str, Any]
) -> str:
    """Name what is to be cited."""
    n_animals = tables.events["animal"].nunique()
    tested = "phase_summary" in further and n_animals > 1
    wanted = ["zar"] if tested else []
    wanted += ["maris"] if "curve_clusters" in further else []
    wanted += ["holm"] if "groups" in further else []
    wanted += ["pullar"] if {"scaling", "against_speed", "joint_ranges"} & set(further) else []
    used = [made.get("method") for steps in step.get("sources", {}).values() for made in steps]
    wanted += ["paper"] if {"paper", "slic-2d", "slic-3d"} & set(used) else []
    return "To cite: pawnb (CITATION.cff). " + " ".join(SOURCES[name] for name in wanted)


def _number(n: int, what: str) -> str:
    """Return a number of things."""
    return f"{n} {what}{'s' * (n != 1)}"
