"""The methods paragraph of a gait analysis: what was done, with how many, and what was left out."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Collection, Mapping, Sequence
from typing import Any

import pandas as pd

from pawnb.core.paws.offline.quality.assessment import Quality
from pawnb.gait import EventSettings, GaitTables
from pawnb.schema import Tracks
from pawnb.workflow.gait.statistics import length_unit
from pawnb.workflow.provenance.report.tracking_text import tracking_sentences

_FILTER = (
    "a zero-phase Butterworth low-pass of fourth order (both passes together; half power at the "
    "cut-off)"
)
_TESTS = {
    "legs exchanged within trials": "permutation tests (legs exchanged within trials)",
    "Welch's t": "Welch's t test of the means of animals",
    "Welch's t of phases": "the same of phases",
    "paired t": "paired t tests of the means of animals",
    "paired t of phases": "the same of phases",
    "Greenhouse-Geisser": "analysis of variance of repeated measures (legs within animals) with "
    "the correction of Greenhouse and Geisser",
}
"""Tests under the names that tables give them, in a sentence."""
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
_LIGHTNING_POSE = (
    "Biderman D et al. (2024) Lightning Pose: improved animal pose estimation via semi-supervised "
    "learning, Bayesian ensembling and cloud-native open-source tools. Nat. Methods 21: 1316-1328."
)
PROGRAMS = {
    "DeepLabCut": "Mathis A, Mamidanna P, Cury KM, Abe T, Murthy VN, Mathis MW, Bethge M (2018) "
    "DeepLabCut: markerless pose estimation of user-defined body parts with deep learning. Nat. "
    "Neurosci. 21: 1281-1289.",
    "SLEAP": "Pereira TD et al. (2022) SLEAP: a deep learning system for multi-animal pose "
    "tracking. Nat. Methods 19: 486-495.",
    "Lightning Pose": _LIGHTNING_POSE,
    "Ensemble Kalman Smoother": _LIGHTNING_POSE,
    "Anipose": "Karashchuk P et al. (2021) Anipose: a toolkit for robust markerless 3D pose "
    "estimation. Cell Rep. 36: 109730.",
    "DLTdv": "Hedrick TL (2008) Software techniques for two- and three-dimensional kinematic "
    "measurements of biological and biomimetic systems. Bioinspir. Biomim. 3: 034001.",
    "Argus": "Jackson BE, Evangelista DJ, Ray DD, Hedrick TL (2016) 3D for the people: "
    "multi-camera motion capture in the field with consumer-grade cameras and open source "
    "software. Biol. Open 5: 1334-1342.",
    "LocoMouse": "Machado AS, Darmohray DM, Fayad J, Marques HG, Carey MR (2015) A quantitative "
    "framework for whole-body coordination reveals specific deficits in freely walking ataxic "
    "mice. eLife 4: e07892.",
}
"""What is to be cited for tracks of other programs, by the name that tracks give."""
_BY_HAND = re.compile(r"corrections by hand in force: \d+ \(([^)]+)\)")
_NUMBER_IN_TEXT = re.compile(r"(?<![\w.])\d+(?:\.\d+)?(?!\w)")
_PLURAL = re.compile(r"(?<=# )(\w{2,})s\b")
"""A noun after a number: one frame and two frames are the same reason."""


def methods_paragraphs(
    tables: GaitTables,
    further: Mapping[str, pd.DataFrame],
    *,
    step: Mapping[str, Any],
    tracked: Sequence[Tracks] = (),
    verdicts: Sequence[Quality | None] | None = None,
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
    verdicts : sequence of Quality or None, optional
        The verdict on each, where it is known already.

    Returns
    -------
    list of str
        Paragraphs: data, events and filter, statistics, what was dropped, programs and sources.
    """
    tracking = tracking_sentences(tracked, verdicts)
    said = [_subjects(tables, further), *([tracking] if tracking else []), _events(tables, step)]
    return [
        *said,
        _statistics(tables, further),
        _dropped(tables),
        _programs(step),
        _sources(tables, further, step, tracked),
    ]


def _subjects(tables: GaitTables, further: Mapping[str, pd.DataFrame]) -> str:
    """Say of whom, how many strides of each, in which groups and in which unit."""
    strides = tables.strides
    own_names = strides[["animal", "trial"]].drop_duplicates().astype(str)
    with_strides = set(own_names.itertuples(index=False, name=None))
    who = tables.trials
    by_leg = ", ".join(f"{leg} {n}" for leg, n in strides.groupby("leg", sort=False).size().items())
    counted = _number(len({animal for animal, _ in who}), "animal")
    each = strides.groupby("animal", sort=False).size().tolist()
    spread = f", {_range(each)} of each animal" if len(each) > 1 else ""
    said = [
        f"Gait was analysed in {_number(len(who), 'trial')} of {counted}: "
        f"{_number(len(strides), 'stride')}{f' ({by_leg})' if by_leg else ''}{spread}."
    ]
    said += _without_strides([one for one in who if one not in with_strides], with_strides)
    grouped = further.get("strides", strides)
    if "group" in grouped and grouped["group"].notna().any():
        own = [
            f"{group} {_number(one['animal'].nunique(), 'animal')}, {_number(len(one), 'stride')}"
            for group, one in grouped.groupby("group", sort=True)
        ]
        said.append(f"Groups: {'; '.join(own)}.")
    unit = length_unit(tables)
    if unit is not None:
        said.append(f"Lengths are in {unit}{', not calibrated' if unit == 'px' else ''}.")
    return " ".join(said)


def _without_strides(
    lacking: Sequence[tuple[str, str]], with_strides: Collection[tuple[str, str]]
) -> list[str]:
    """Say in which trials no stride was found, and which animals so have none."""
    if not lacking or not with_strides:
        return []
    known = {animal for animal, _ in with_strides}
    gone = list(dict.fromkeys(animal for animal, _ in lacking if animal not in known))
    trials = ", ".join(dict.fromkeys(trial for _, trial in lacking))
    left = f"; {', '.join(gone)} {'is' if len(gone) == 1 else 'are'} in no mean and no test"
    return [
        f"No stride was found in {len(lacking)} of these trials ({trials}){left if gone else ''}."
    ]


def _events(tables: GaitTables, step: Mapping[str, Any]) -> str:
    """Say how events were found and strides made of them."""
    counts = tables.events.groupby(["event", "method"], sort=False).size().reset_index(name="n")
    found = ", ".join(f"{row.event} ({row.method}, {row.n})" for row in counts.itertuples())
    said = [f"Events: {found or 'none'}."]
    by_hand = [kinds for note in tables.notes for kinds in _BY_HAND.findall(str(note))]
    said += [f"Corrected by hand: {'; '.join(by_hand)}."] * bool(by_hand)
    said += [f"Positions were smoothed by {_filtered(tables, step)}."] * bool(tables.signals)
    said += [
        f"{words} {_range(values)}{unit}."
        for words, pattern, unit in (
            ("Positions counted as missing where their confidence was below",
             r"confidence below ([\d.]+)", ""),
            ("Gaps were bridged up to", r"gaps bridged up to ([\d.]+) s", " s"),
        )
        if (values := _noted(tables, pattern))
    ]  # fmt: skip
    said.append(
        "A stride runs from AEP (or touch-down, where only contact is known) to the next of the "
        "same leg."
    )
    usual = {field.name: field.default for field in dataclasses.fields(EventSettings)}
    changed = {
        name: value
        for name, value in step["settings"].items()
        if name != "cutoff_hz" and name in usual and value != usual[name]
    }
    said += [f"Settings by hand: {_settings(changed)}."] * bool(changed)
    own = step.get("settings_of_trials") or {}
    told = "; ".join(f"{who}: {_settings(values)}" for who, values in own.items())
    said += [f"Settings of single trials: {told}."] * bool(told)
    return " ".join(said)


def _filtered(tables: GaitTables, step: Mapping[str, Any]) -> str:
    """Name the filter and its cut-off, which is that of each trial where none was given."""
    cutoff = step["settings"].get("cutoff_hz")
    if cutoff is not None:
        return f"{_FILTER} at {cutoff:g} Hz"
    found = _noted(tables, r"low-pass ([\d.]+) Hz")
    values = f" ({_range(found)} Hz)" if found else ""
    return (
        f"{_FILTER} at ten times the stride frequency of each trial{values}, and not at all where "
        "that is too near the frame rate (the notes say it trial by trial)"
    )


def _noted(tables: GaitTables, pattern: str) -> list[float]:
    """Return the numbers that the notes on the trials give."""
    found = [re.findall(pattern, str(note)) for note in tables.notes]
    return [float(number) for numbers in found for number in numbers]


def _range(values: Sequence[float]) -> str:
    """Return a number, or the least and the largest of several."""
    low, high = min(values), max(values)
    return f"{low:g}" if low == high else f"{low:g} to {high:g}"


def _settings(values: Mapping[str, Any]) -> str:
    """Return settings with their values."""
    return ", ".join(f"{name} {value}" for name, value in values.items())


def _statistics(tables: GaitTables, further: Mapping[str, pd.DataFrame]) -> str:
    """Name the tests that were made, as the tables name them."""
    said = []
    animals = tables.events["animal"].nunique()
    if len(tables.phase_summary) and animals > 1:
        whose = "the animals of all groups together" if "groups" in further else "animals"
        said.append(
            f"Mean phases are circular means over {whose}, each counted once, with 95 % intervals "
            "and Rayleigh's test"
        )
    for name, words in (("groups", "Groups were compared by"), ("legs", "Legs were compared by")):
        table = further.get(name)
        if table is not None and "method" in table:
            named = [_TESTS.get(method, method) for method in _tests_made(table)]
            said += [f"{words} {' and '.join(named)}"] if named else []
    if "groups" in further and not _tests_made(further["groups"]):
        said.append("Differences between groups are described and not tested (groups.csv says why)")
    elif "groups" in further:
        said.append(
            "An animal's value is the mean of the means of its legs, over all its strides in a "
            f"group. The design is {_design(further['groups'])}; within a measure p was adjusted "
            "by Holm's method, and p over all measures is given beside it"
        )
    if "curve_clusters" in further:
        methods = dict.fromkeys(further["curve_clusters"]["method"].astype(str))
        counted = " or ".join(method for method in methods if method != "none")
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


def _design(groups: pd.DataFrame) -> str:
    """Name the design; of a paired one with how many animals are in both groups."""
    design = str(groups["design"].iloc[0])
    if design != "paired":
        return design
    measures = groups[(groups["role"] == "measure") & groups["n_animals_a"].notna()]
    told = [
        f"{_number(int(own['n_animals_a'].max()), 'animal')} in both {pair[0]} and {pair[1]}"
        for pair, own in measures.groupby(["group_a", "group_b"], sort=False)
    ]
    return f"{design} ({'; '.join(told)})"


def _tests_made(table: pd.DataFrame) -> list[str]:
    """Return the tests in a table, each once; of what could not be tested the method is none."""
    methods = dict.fromkeys(str(method).split(",")[0] for method in table["method"].dropna())
    return [method for method in methods if method != "none"]


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
    """Count what was left out by reason, whichever stride of a trial it was and however long.

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
    own = dropped.assign(
        why=dropped["why"].astype(str).str.replace(r"\bstride \d+\b", "a stride", regex=True)
    )
    numberless = own["why"].str.replace(_NUMBER_IN_TEXT, "#", regex=True)
    own["alike"] = numberless.str.replace(_PLURAL, r"\1", regex=True)
    groups = own.groupby([*(name for name in by if name != "why"), "alike"], sort=True)
    counts = groups.agg(why=("why", _together), n=("why", "size")).reset_index()
    return counts[[*by, "n"]].sort_values("n", ascending=False, kind="stable")


def _together(reasons: pd.Series) -> str:
    """Return reasons that differ in their numbers only as one, with the range of each number.

    The words are those of the longest, which has its nouns in the plural where any has.
    """
    words = max(reasons, key=lambda reason: len(_NUMBER_IN_TEXT.sub("#", reason)))
    numbers = [_NUMBER_IN_TEXT.findall(reason) for reason in reasons]
    ranges = iter([_range([float(one) for one in same]) for same in zip(*numbers, strict=True)])
    return _NUMBER_IN_TEXT.sub(lambda _: next(ranges), words)


def _programs(step: Mapping[str, Any]) -> str:
    """Name the programs and their versions."""
    versions = step["versions"]
    others = ", ".join(f"{name} {versions[name]}" for name in _PROGRAMS if name in versions)
    return f"pawnb {versions['pawnb']} on Python {versions['python']} ({others})."


def _sources(
    tables: GaitTables,
    further: Mapping[str, pd.DataFrame],
    step: Mapping[str, Any],
    tracked: Sequence[Tracks],
) -> str:
    """Name what is to be cited."""
    n_animals = tables.events["animal"].nunique()
    tested = "phase_summary" in further and n_animals > 1
    wanted = ["zar"] if tested else []
    wanted += ["maris"] if "curve_clusters" in further else []
    wanted += ["holm"] if "groups" in further and _tests_made(further["groups"]) else []
    wanted += ["pullar"] if {"scaling", "against_speed", "joint_ranges"} & set(further) else []
    used = [made.get("method") for steps in step.get("sources", {}).values() for made in steps]
    wanted += ["paper"] if {"paper", "slic-2d", "slic-3d"} & set(used) else []
    told = dict.fromkeys(str(tracks.attrs.get("source_software", "")) for tracks in tracked)
    others = dict.fromkeys(source for name, source in PROGRAMS.items() if name in told)
    return " ".join(
        ["To cite: pawnb (CITATION.cff).", *(SOURCES[name] for name in wanted), *others]
    )


def _number(n: int, what: str) -> str:
    """Return a number of things."""
    return f"{n} {what}{'s' * (n != 1)}"
