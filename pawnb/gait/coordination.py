"""Every table of coordination that events, strides and phases allow, in one call."""

from __future__ import annotations

import pandas as pd

from pawnb.errors import InputError
from pawnb.gait.analysis.tables import GaitTables
from pawnb.gait.legs import find_leg_place
from pawnb.gait.phases.coupling import alternation_rule, coupling_strength, support_rule
from pawnb.gait.phases.patterns import pattern_distances
from pawnb.gait.strides.symmetry import SYMMETRIC, symmetry_table
from pawnb.gait.support import (
    regularity_index,
    support_shares,
    support_table,
    whole_stretches,
)
from pawnb.schema.arguments import checked_arguments

REGULARITY_COLUMNS = ("animal", "trial", "regularity_percent", "n_footfalls", "n_sequences")


@checked_arguments
def coordination_tables(tables: GaitTables) -> dict[str, pd.DataFrame]:
    """Build the tables of support, symmetry, coupling, and distance to ideal gaits.

    Parameters
    ----------
    tables : GaitTables
        The result of an analysis.

    Returns
    -------
    dict
        Name to table, those that would be empty left out: ``support`` (feet on the ground,
        stretch by stretch, where every leg is within a stride that counts) and
        ``support_shares``, ``symmetry`` (left against right), ``patterns`` (distances to ideal
        gaits), ``coupling`` (tightness along, across and diagonally), ``alternation`` and
        ``support_rule`` (Hughes' rules), ``regularity`` (four legs, trial by trial).
    """
    events, strides, phases = tables.events, tables.strides, tables.phases
    found: dict[str, pd.DataFrame] = {}
    if len(events):
        found["support"] = support_table(events, strides=strides)
        found["support_rule"] = support_rule(events, strides=strides)
        found["regularity"] = _regularity(events, strides)
    if len(found.get("support", ())):
        found["support_shares"] = support_shares(found["support"])
    if len(strides):
        measures = [name for name in SYMMETRIC if strides[name].notna().any()]
        found["symmetry"] = symmetry_table(strides, measures=measures)
    if len(phases):
        found["coupling"] = coupling_strength(phases)
        found["alternation"] = alternation_rule(phases)
        named = phases["leg"].map(find_leg_place).notna()
        named &= phases["reference"].map(find_leg_place).notna()
        if named.any():
            found["patterns"] = pattern_distances(phases[named])
    return {name: table for name, table in found.items() if len(table)}


def _regularity(events: pd.DataFrame, strides: pd.DataFrame) -> pd.DataFrame:
    """Return the regularity index of every trial of a four-legged animal."""
    rows = []
    stretches = whole_stretches(events, strides)
    for (animal, trial), own in events.groupby(["animal", "trial"], sort=False):
        here = (stretches["animal"] == animal) & (stretches["trial"] == trial)
        try:
            found = regularity_index(own, stretches=stretches[here])
        except InputError:
            continue  # not four legs, or too few footfalls: there is no such index
        rows.append([animal, trial, found.percent, found.n_footfalls, found.n_sequences])
    return pd.DataFrame(rows, columns=list(REGULARITY_COLUMNS))
