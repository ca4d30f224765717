"""What a study tells beyond its trials: who was filmed, and gait against size."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import pandas as pd

from pawnb import figures
from pawnb.errors import InputError
from pawnb.figures.panels import speed_unit, with_unit
from pawnb.gait import GaitTables
from pawnb.gait.cycles import LegSignals
from pawnb.gait.legs import find_leg_place
from pawnb.gait.regression.reference_lines import least_stable_duty_factor, trot_gallop_transition
from pawnb.gait.regression.scaling import EXPECTED_EXPONENTS, expected_slopes_table, scaling_table
from pawnb.workflow.gait.drawing.drawings import Drawing, make_drawing
from pawnb.workflow.gait.drawing.overview_drawings import curve_clusters
from pawnb.workflow.gait.speed_residuals import speed_residuals
from pawnb.workflow.gait.statistics import Groups

Fields = Mapping[tuple[str, str], Mapping[str, Any]]
"""(animal, trial) to its covariates."""

MASS = ("mass_g", "mass_kg", "mass_mg", "mass")
LENGTH = ("body_length", "body_length_mm", "body_length_cm", "carapace_mm", "carapace_cm")
PARAMETERS = ("speed", "speed_bl", "frequency_hz", "stride_length")
PER_METRE = {"mm": 1000.0, "cm": 100.0, "m": 1.0}
_FEWEST_ANIMALS = 3
_STRIDE = "stride"
_FEWEST_LEGS = 4


def trials_table(tables: GaitTables, *, groups: Mapping[Any, str], fields: Fields) -> pd.DataFrame:
    """List who was analysed: a row a trial.

    Parameters
    ----------
    tables : GaitTables
        The analysis.
    groups : mapping
        (animal, trial) to its group.
    fields : mapping
        (animal, trial) to its covariates.

    Returns
    -------
    pandas.DataFrame
        ``animal, trial, group``, covariates, ``n_strides``, ``n_dropped`` strides, then a column
        for each other kind of drop in any of the trials (``n_dropped_phase``, ``n_dropped_pause``,
        ...): rows of ``dropped.csv``.
    """
    kinds = tables.dropped["what"].astype(str).map(_kind_of_drop)
    others = sorted(set(kinds) - {_STRIDE})
    columns = {"n_dropped": _STRIDE} | {f"n_dropped_{kind}": kind for kind in others}
    rows: list[dict[str, Any]] = []
    for basis in tables.bases:
        who = (str(basis.who["animal"]), str(basis.who["trial"]))
        own = kinds[_of(tables.dropped, who)].value_counts()
        plain = {
            name: value
            for name, value in fields.get(who, {}).items()
            if isinstance(value, str | int | float)
        }
        row = {"animal": who[0], "trial": who[1], "group": groups.get(who, "")}
        counts = {"n_strides": int(_of(tables.strides, who).sum())}
        counts |= {name: int(own.get(kind, 0)) for name, kind in columns.items()}
        rows.append({**row, **plain, **counts})
    table = pd.DataFrame(rows)
    last = ["n_strides", *columns]
    return table[[*(name for name in table if name not in last), *last]]


def _of(table: pd.DataFrame, who: tuple[str, str]) -> pd.Series:
    """Say which rows are of an animal and trial."""
    return (table["animal"].astype(str) == who[0]) & (table["trial"].astype(str) == who[1])


def _kind_of_drop(what: str) -> str:
    """Return what was dropped as the name of a column; all phases of a leg are one kind."""
    return re.sub(r"\W+", "_", what.split(" to ", 1)[0]).lower()


def tables_of_study(
    tables: GaitTables, *, groups: Groups, joints: Sequence[LegSignals], fields: Fields
) -> dict[str, pd.DataFrame]:
    """Return what compares animals: strides at equal speed, curves of groups, the trials.

    Parameters
    ----------
    tables : GaitTables
        Of all trials.
    groups : mapping
        (animal, trial) to its group.
    joints : sequence of LegSignals
        Joint angles of jointed animals.
    fields : mapping
        (animal, trial) to what else is known of it.

    Returns
    -------
    dict
        Name to table, without empty ones.
    """
    made = {
        "speed_residuals": speed_residuals(tables.strides),
        "curve_clusters": curve_clusters(tables, groups=groups, joints=joints),
    }
    found = {name: table for name, table in made.items() if len(table)}
    return found | {"trials": trials_table(tables, groups=groups, fields=fields)}


def size_tables(strides: pd.DataFrame, fields: Fields) -> dict[str, pd.DataFrame]:
    """Fit gait on size over animals (Pullar 2009, Tables 4.3 and 4.4).

    Parameters
    ----------
    strides : pandas.DataFrame
        Strides.
    fields : mapping
        (animal, trial) to its covariates.

    Returns
    -------
    dict
        ``scaling`` and ``expected_exponents``, where three animals or more have a size
        (:data:`MASS`, :data:`LENGTH`) and it is not the same in all.
    """
    sized, sizes = with_sizes(strides, fields)
    outcomes = _parameters_of(sized)
    if not sizes or not outcomes:
        return {}
    found = {"scaling": scaling_table(sized, outcomes, sizes)}
    mass = next((name for name in MASS if name in sizes), None)
    if mass is not None:
        named = sized.rename(columns={mass: "mass", "speed_bl": "relative_speed"})
        known = [
            row
            for row in EXPECTED_EXPONENTS
            if row.parameter in named and (named[row.parameter] > 0).all()
        ]
        if known:
            found["expected_exponents"] = expected_slopes_table(named, known)
    return found


def size_drawings(strides: pd.DataFrame, fields: Fields, *, unit: str | None) -> Iterator[Drawing]:
    """List the figures of gait against size (Pullar 2009, Figs. 4.1 and 4.2).

    Parameters
    ----------
    strides : pandas.DataFrame
        Strides.
    fields : mapping
        (animal, trial) to its covariates.
    unit : str or None
        Unit of lengths.

    Yields
    ------
    Drawing
        One for each measure of size.
    """
    sized, sizes = with_sizes(strides, fields)
    names = {
        "speed": with_unit("Speed", speed_unit(unit)),
        "speed_bl": "Speed (lengths/s)",
        "frequency_hz": "Stride frequency (Hz)",
        "stride_length": with_unit("Stride length", unit),
    }
    known = _parameters_of(sized)
    for size in sizes:
        if known:
            pairs = [(name, size) for name in known]
            build = partial(figures.build_regression_table, sized, pairs, kind="power")
            said = {**names, size: _said(size, unit)}
            yield make_drawing(f"against_{size}", "regression", build, names=said)


def _parameters_of(strides: pd.DataFrame) -> list[str]:
    """Return the measures that are compared with size: those known and above 0 in every stride."""
    return [name for name in PARAMETERS if name in strides and (strides[name] > 0).all()]


def with_sizes(strides: pd.DataFrame, fields: Fields) -> tuple[pd.DataFrame, list[str]]:
    """Return the strides of animals whose sizes are known, and the names of these.

    Parameters
    ----------
    strides : pandas.DataFrame
        Strides.
    fields : mapping
        (animal, trial) to its covariates.

    Returns
    -------
    strides : pandas.DataFrame
        With a column a size.
    sizes : list of str
        Those that every animal has, of three animals or more, not all of one size.

    Raises
    ------
    InputError
        If a size is no number above 0.
    """
    keys = list(zip(strides["animal"].astype(str), strides["trial"].astype(str), strict=True))
    sizes: list[str] = []
    for name in (*MASS, *LENGTH):
        values: list[Any] = [fields.get(key, {}).get(name) for key in keys]
        if not values or any(value is None for value in values):
            continue
        odd = [v for v in values if isinstance(v, bool | str) or not isinstance(v, int | float)]
        odd += [v for v in values if not odd and not v > 0]
        if odd:
            raise InputError(f"{name} is {odd[0]!r}; expected a number above 0.")
        strides = strides.assign(**{name: pd.Series(values, index=strides.index, dtype=float)})
        of_animals = strides.groupby("animal")[name].mean()
        if len(of_animals) >= _FEWEST_ANIMALS and of_animals.max() > of_animals.min():
            sizes.append(name)
    return strides, sizes


def reference_lines(
    strides: pd.DataFrame, fields: Fields, *, unit: str | None
) -> dict[str, tuple[float, str]]:
    """Return lines to draw beside measures against speed (Pullar 2009, Fig. 4.6).

    Parameters
    ----------
    strides : pandas.DataFrame
        Strides.
    fields : mapping
        (animal, trial) to its covariates.
    unit : str or None
        Unit of lengths.

    Returns
    -------
    dict
        Column to a value and its words: where every animal has a mass, the transition from trot
        to gallop at the mean mass; the least stable duty factor, where the legs are there in
        pairs, four or more.
    """
    lines: dict[str, tuple[float, str]] = {}
    masses = [mass_kg(fields.get(key, {})) for key in fields]
    known = [mass for mass in masses if mass is not None]
    if known and len(known) == len(masses):
        found = trot_gallop_transition(sum(known) / len(known))
        words = "trot-gallop\n(Heglund 1974)"
        lines["frequency_hz"] = (found.frequency_hz, words)
        if unit in PER_METRE:
            lines["speed"] = (found.speed_m_s * PER_METRE[unit], words)
            lines["stride_length"] = (found.stride_length_m * PER_METRE[unit], words)
    places = {find_leg_place(str(leg)) for leg in strides["leg"].unique()}
    sides = [{place.rank for place in places if place and place.side == side} for side in "LR"]
    if None not in places and sides[0] == sides[1] and len(places) >= _FEWEST_LEGS:
        duty = least_stable_duty_factor(len(places))
        source = {4: "McGhee 1968"}.get(len(places), "Ting 1994")
        lines["duty_factor"] = (duty, f"unstable below ({source})")
    return lines


def mass_kg(fields: Mapping[str, Any]) -> float | None:
    """Return the mass of an animal, kg; None where it is not known or has no unit.

    Parameters
    ----------
    fields : mapping
        Covariates of the animal.

    Returns
    -------
    float or None
        The mass.
    """
    for name, share in (("mass_kg", 1.0), ("mass_g", 1e-3), ("mass_mg", 1e-6)):
        value = fields.get(name)
        if isinstance(value, int | float) and not isinstance(value, bool) and value > 0:
            return float(value) * share
    return None


def covariates_of(parts: Sequence[GaitTables], fields: Sequence[Mapping[str, Any]]) -> Fields:
    """Return the covariates of each animal and trial.

    Parameters
    ----------
    parts : sequence of GaitTables
        An analysis of each input.
    fields : sequence of mapping
        What is known of each input's animal.

    Returns
    -------
    mapping
        (animal, trial) to its covariates.
    """
    return {
        (str(basis.who["animal"]), str(basis.who["trial"])): own
        for part, own in zip(parts, fields, strict=True)
        for basis in part.bases
    }


def _said(size: str, unit: str | None) -> str:
    """Return what a size is called on an axis."""
    words, _, last = size.rpartition("_")
    if last in ("g", "kg", "mg", "mm", "cm"):
        return with_unit(words.replace("_", " ").capitalize(), last)
    name = size.replace("_", " ").capitalize()
    return with_unit(name, unit) if "length" in size else name
