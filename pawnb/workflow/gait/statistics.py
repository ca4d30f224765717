"""The statistics that ``pawnb gait`` writes beside its tables: each where the input allows it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from pawnb.errors import InputError
from pawnb.figures.panels import speed_unit
from pawnb.gait import GaitTables, body_angles
from pawnb.gait.analysis.stride_measures import MEASURE_COLUMNS
from pawnb.gait.analysis.stride_support import SUPPORT_MEASURES
from pawnb.gait.cycles import POSITION, LegSignals
from pawnb.gait.cycles.joint_signals import joint_signals
from pawnb.gait.groups import adjust_p, compare_groups
from pawnb.gait.groups.animal_summary import summarise_animals
from pawnb.gait.joints import get_joint_angles, joint_range_table
from pawnb.gait.regression.lines import differ
from pawnb.gait.regression.phase_slopes import phase_speed_table
from pawnb.gait.regression.scaling import speed_table
from pawnb.gait.selection import steadiness
from pawnb.gait.strides.durations import compare_legs, stride_duration_by_leg
from pawnb.schema import Tracks
from pawnb.trial import Trial

COMPARED_MEASURES = (
    "period_s", "frequency_hz", "stance_s", "swing_s", "duty_factor", "contact_duty_factor",
    "stride_length", "speed", "step_displacement",
    *(name for name in MEASURE_COLUMNS if name not in ("heading_deg", "heading_change_deg")),
    *SUPPORT_MEASURES,
)  # fmt: skip
"""Measures of strides that are summarised and compared."""

BY_LEG = ("period_s", "stance_s", "swing_s", "duty_factor", "stride_length")
AGAINST_SPEED = (
    "frequency_hz", "stride_length", "swing_s", "stance_s", "duty_factor", "wave_gait_margin",
)  # fmt: skip
AGAINST_FREQUENCY = ("swing_s", "stance_s")
"""Measures that Pullar's (2009) Table 4.5 and Fig. 4.7 set against stride frequency, too."""
_FEWEST_FOR_SLOPE = 3
ALL_LEGS = "all"
"""In place of a leg's name where legs were averaged."""

Groups = Mapping[tuple[str, str], str]
"""(animal, trial) to its group."""


def statistics_tables(
    tables: GaitTables, *, groups: Groups | None = None, angles: pd.DataFrame | None = None
) -> tuple[dict[str, pd.DataFrame], list[str]]:
    """Build the tables of statistics that an analysis allows.

    Parameters
    ----------
    tables : GaitTables
        The result of an analysis.
    groups : mapping, optional
        (animal, trial) to group; trials without one are left out of the comparison.
    angles : pandas.DataFrame, optional
        Joint angles (:data:`pawnb.gait.joints.ANGLE_COLUMNS`) of jointed animals.

    Returns
    -------
    found : dict
        Name to table, those left out that cannot be made: ``animals`` (every measure of the
        strides, leg by leg, counting animals), ``steadiness`` (trial by trial),
        ``stride_durations`` (whether legs keep one rhythm, trial by trial), ``legs`` (whether
        measures differ between legs, over two animals or more),
        ``against_speed`` (Pullar 2009, Table 4.5, of all legs together, where the thesis has L2;
        three trials or more of known speed),
        ``phase_speed`` (slopes of phase on speed within animals, where speeds are known),
        ``joint_ranges`` (Table 4.6) and ``groups`` (two groups or more; column ``role``:
        ``measure``, legs averaged first; ``phase`` of a pair of legs; ``follow-up``, a measure
        of one leg). Each measure is a family: ``p_adjusted`` is Holm's over its pairs of groups,
        that of phases over pairs of legs too, that of follow-ups over the legs of their measure.
        ``p_all_measures`` is Holm's over all rows that are no follow-ups.
    notes : list of str
        Why a table that was asked for is not there.
    """
    strides = tables.strides
    found: dict[str, pd.DataFrame] = {}
    notes: list[str] = []
    if len(strides):
        found["animals"] = summarise_animals(strides, known_measures(strides))
        found["steadiness"] = steadiness(strides)
        found["stride_durations"] = stride_duration_by_leg(strides)
        found["legs"] = _compare_legs(strides)
        found["against_speed"] = _against_speed(strides)
        found["phase_speed"] = _phase_speed(tables)
    if angles is not None and len(angles):
        found["joint_ranges"] = joint_range_table(angles)
    if groups:
        try:
            found["groups"] = _compare(tables, groups)
        except InputError as error:
            notes.append(f"groups are not compared: {error}")
    return {name: table for name, table in found.items() if len(table)}, notes


def length_unit(tables: GaitTables) -> str | None:
    """Return the unit of lengths, where all trials have the same; None where not known."""
    units = {one.unit for one in tables.signals if one.signal == POSITION}
    return units.pop() if len(units) == 1 else None


def known_measures(strides: pd.DataFrame) -> list[str]:
    """Return the measures that any stride has, in the order of :data:`COMPARED_MEASURES`."""
    return [name for name in COMPARED_MEASURES if name in strides and strides[name].notna().any()]


def joint_angles_of(
    sources: Sequence[tuple[Tracks, str | None, str]],
) -> pd.DataFrame | None:
    """Collect the joint angles of jointed animals.

    Parameters
    ----------
    sources : sequence of (tracks, animal, trial)
        Tracks, those of points too; ``animal`` None takes the names that the Tracks give.

    Returns
    -------
    pandas.DataFrame or None
        :data:`pawnb.gait.joints.ANGLE_COLUMNS`; None where no Tracks hold any angle. Angles of
        a method that does not smooth (``paper``) are smoothed first, as in the thesis.
    """
    parts = []
    for tracks, animal, trial in sources:
        if "joint_angle" not in tracks or np.isnan(tracks["joint_angle"]).all():
            continue
        # tracks that tell no uncertainty are not smoothed yet, and the worst frame is the extreme
        own = get_joint_angles(tracks, trial=trial, smooth="sd" not in tracks)
        parts.append(own if animal is None else own.assign(animal=animal))
    return pd.concat(parts, ignore_index=True) if parts else None


def joint_signals_of(sources: Sequence[tuple[Tracks, str | None, str]]) -> list[LegSignals]:
    """Collect the joint angles of jointed animals as signals over time.

    Parameters
    ----------
    sources : sequence of (tracks, animal, trial)
        As for :func:`joint_angles_of`.

    Returns
    -------
    list of LegSignals
        Empty where no Tracks hold any angle.
    """
    found: list[LegSignals] = []
    for tracks, animal, trial in sources:
        if "joint_angle" in tracks:
            found += joint_signals(tracks, animal=animal, trial=trial)
    return found


def body_angles_of(sources: Sequence[tuple[Tracks, Trial | None]]) -> pd.DataFrame:
    """Collect roll, pitch and yaw of the bodies, of the trials that name points of it.

    Parameters
    ----------
    sources : sequence of (tracks, trial)
        Tracks, and what is known of their recording.

    Returns
    -------
    pandas.DataFrame
        animal, trial, and the columns of :func:`pawnb.gait.body_angles`; empty where no
        trial has ``[animal] body`` and positions in space of one animal.

    Raises
    ------
    InputError
        If a trial names a point that its tracks lack.
    """
    parts = []
    for tracks, trial in sources:
        if trial is None or len(trial.animal.body) < 2:
            continue
        if tracks.sizes["space"] == 3 and tracks.sizes["individual"] == 1:
            own = body_angles(tracks, trial=trial)
            own.insert(0, "trial", trial.name)
            own.insert(0, "animal", trial.animal.id)
            parts.append(own)
    return pd.concat(parts, ignore_index=True) if parts else pd.DataFrame()


def _compare_legs(strides: pd.DataFrame) -> pd.DataFrame:
    """Compare measures between legs over animals; empty with one animal or one leg."""
    if strides["animal"].nunique() < 2 or strides["leg"].nunique() < 2:
        return pd.DataFrame()
    rows = []
    for measure in BY_LEG:
        known = strides.dropna(subset=[measure])
        counted = known.groupby("animal")["leg"].nunique()
        if len(known) and (counted == known["leg"].nunique()).any():
            row = compare_legs(known, measure=measure)._asdict()
            row["means"] = " ".join(f"{mean:.6g}" for mean in row["means"])
            rows.append({"measure": measure, **row, "legs": " ".join(row["legs"])})
    return pd.DataFrame(rows)


def _against_speed(strides: pd.DataFrame) -> pd.DataFrame:
    """Fit measures on speed over trials; empty where there are too few of different speed."""
    speeds, frequency = ["speed", "speed_bl"], "frequency_hz"
    names = list(dict.fromkeys([*AGAINST_SPEED, *speeds]))
    means = strides.groupby(["animal", "trial"])[names].mean()
    if not any(_is_axis(means[x].dropna()) for x in speeds):
        return pd.DataFrame()
    parts = [
        speed_table(strides, [outcome], [x])
        for outcome in AGAINST_SPEED
        for x in (*speeds, *([frequency] if outcome in AGAINST_FREQUENCY else []))
        if _is_axis(means[[outcome, x]].dropna()[x])
    ]
    return pd.concat(parts, ignore_index=True) if parts else pd.DataFrame()


def _is_axis(known: pd.Series) -> bool:
    """Say whether a line can be fitted: three points or more that are not at one place."""
    return known.nunique() >= _FEWEST_FOR_SLOPE and differ(known.to_numpy(float))


def _phase_speed(tables: GaitTables) -> pd.DataFrame:
    """Fit phases on speed within animals; empty where there are no phases or no speeds."""
    if tables.phases.empty or not tables.strides["speed"].notna().any():
        return pd.DataFrame()
    unit = speed_unit(length_unit(tables))
    try:
        return phase_speed_table(tables.phases, tables.strides, unit=unit)
    except InputError:  # strides of reference legs have no speed
        return pd.DataFrame()


def _compare(tables: GaitTables, groups: Groups) -> pd.DataFrame:
    """Compare measures and phases between groups, or between conditions of the same animals."""
    strides, phases = (with_group(table, groups) for table in (tables.strides, tables.phases))
    if len(strides["group"].unique()) < 2:
        return pd.DataFrame()
    paired = is_paired(strides)
    measures = known_measures(strides)
    parts = [compare_groups(strides, measures, average_over="leg", paired=paired)]
    parts[0] = parts[0].assign(role="measure", leg=ALL_LEGS)
    if len(phases["group"].unique()) > 1:
        pairs = ["leg", "reference"]
        found = compare_groups(phases, ["phase"], by=pairs, circular=True, paired=paired)
        parts.append(found.assign(role="phase"))
    first = pd.concat(parts, ignore_index=True)
    first["p_all_measures"] = adjust_p(first["p"].to_numpy(dtype=float))
    legs = compare_groups(strides, measures, by=["leg"], paired=paired)
    legs = legs.assign(role="follow-up", p_all_measures=np.nan)
    found = pd.concat([first, legs], ignore_index=True)
    columns = ["measure", "leg", "reference", "role"]
    found = found.reindex(columns=[*columns, *(c for c in first.columns if c not in columns)])
    return found.assign(design="paired" if paired else "unpaired")


def is_paired(strides: pd.DataFrame) -> bool:
    """Say whether groups are conditions of the same animals.

    Parameters
    ----------
    strides : pandas.DataFrame
        Columns animal and group.

    Returns
    -------
    bool
        True where an animal is in two groups: it was filmed in two conditions.
    """
    both = strides[["animal", "group"]].drop_duplicates()
    return bool(both["animal"].duplicated().any())


def with_group(table: pd.DataFrame, groups: Groups) -> pd.DataFrame:
    """Return the rows of trials that have a group, with it.

    Parameters
    ----------
    table : pandas.DataFrame
        Columns animal and trial.
    groups : mapping
        (animal, trial) to its group.

    Returns
    -------
    pandas.DataFrame
        Those rows, with a column ``group``.
    """
    keys = zip(table["animal"].astype(str), table["trial"].astype(str), strict=True)
    names = [groups.get(key) for key in keys]
    named = table.assign(group=pd.Series(names, index=table.index, dtype=object))
    return named[named["group"].notna()].reset_index(drop=True)
