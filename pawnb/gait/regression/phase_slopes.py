"""How phases change with speed within animals.

Animals that walk at other speeds also differ in other things, so the mean phases of animals
against their mean speeds say nothing of what speed does: a shift that every animal shows
cannot be found in them, and a few animals line up by chance. Each animal's own slope can.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from pawnb.errors import InputError
from pawnb.gait.circular.mean import mean_vector
from pawnb.gait.groups.animals import slope_of_animals
from pawnb.schema import PHASES_COLUMNS, check_columns
from pawnb.schema.arguments import checked_arguments

PHASE_SPEED_COLUMNS = (
    "leg", "reference", "slope", "ci_low", "ci_high", "n_animals", "p", "n", "sd_animals", "unit",
    "note",
)  # fmt: skip
_SPREAD = 0.5


@checked_arguments
def phases_at_speeds(
    phases: pd.DataFrame, strides: pd.DataFrame, *, speed: str = "speed"
) -> pd.DataFrame:
    """Put each phase beside the speed of the stride in which it was measured.

    Parameters
    ----------
    phases : pandas.DataFrame
        ``PHASES_COLUMNS``.
    strides : pandas.DataFrame
        ``STRIDES_COLUMNS``: the stride of the reference leg gives the speed.
    speed : str
        Column of the strides.

    Returns
    -------
    pandas.DataFrame
        ``PHASES_COLUMNS`` and ``speed``; phases without a speed are left out.

    Raises
    ------
    InputError
        If a column is missing or no stride has a speed.
    """
    check_columns(phases, PHASES_COLUMNS, where="phases", numbers=("phase",))
    check_columns(strides, ("animal", "trial", "leg", "stride", speed), where="strides")
    keys = ["animal", "trial", "reference", "stride"]
    base = strides.rename(columns={"leg": "reference", speed: "speed"})[[*keys, "speed"]]
    # names that are numbers come back from a csv as such
    words = {"animal": str, "trial": str}
    found = phases[list(PHASES_COLUMNS)].astype(words).merge(base.astype(words), on=keys)
    found = found[np.isfinite(found["speed"].to_numpy(dtype=float))].reset_index(drop=True)
    if found.empty:
        raise InputError(
            f"phase against speed: no stride has a {speed}; speeds need tracks, or a belt speed."
        )
    return found


@checked_arguments
def phase_speed_table(
    phases: pd.DataFrame,
    strides: pd.DataFrame,
    *,
    speed: str = "speed",
    unit: str | None = None,
    level: float = 0.95,
) -> pd.DataFrame:
    """Compute the slope of phase on speed within animals, pair of legs by pair.

    A line is fitted to the strides of each animal, with differences of phases taken the short way
    round from the animal's mean phase; the slopes of the animals are the units of Student's t
    (:func:`pawnb.gait.groups.animals.slope_of_animals`). Phases and speeds of one animal may differ
    from another's at will.

    Parameters
    ----------
    phases : pandas.DataFrame
        ``PHASES_COLUMNS``.
    strides : pandas.DataFrame
        ``STRIDES_COLUMNS``: the stride of the reference leg gives the speed.
    speed : str
        Column of the strides.
    unit : str, optional
        Unit of that column, such as ``mm/s``.
    level : float
        Level of the interval.

    Returns
    -------
    pandas.DataFrame
        :data:`PHASE_SPEED_COLUMNS`, one row a pair. ``slope``: mean over animals, cycles for
        each unit of speed, with its interval and p of no slope (NaN for one animal);
        ``n_animals`` that have a slope; ``n`` phases; ``sd_animals`` between their slopes;
        ``note``: what was left out, and where a slope says little.

    Raises
    ------
    InputError
        If a column is missing, no stride has a speed, or level cannot be used.
    """
    known = phases_at_speeds(phases, strides, speed=speed)
    rows: list[dict[str, Any]] = []
    for (leg, reference), own in known.groupby(["leg", "reference"], sort=False):
        row = {"leg": leg, "reference": reference, "unit": f"cycle/({unit or 'unit of speed'})"}
        rows.append(row | slope_of_pair(own, level=level))
    return pd.DataFrame(rows, columns=list(PHASE_SPEED_COLUMNS))


@checked_arguments
def slope_of_pair(own: pd.DataFrame, *, level: float = 0.95) -> dict[str, Any]:
    """Compute the slope of phase on speed within the animals of one pair of legs.

    Parameters
    ----------
    own : pandas.DataFrame
        Rows of one pair from :func:`phases_at_speeds`.
    level : float
        Level of the interval.

    Returns
    -------
    dict
        ``slope, ci_low, ci_high, n_animals, p, n, sd_animals, note`` as in
        :func:`phase_speed_table`; NaN and 0 animals where none has a slope.
    """
    animals = own["animal"].astype(str).to_numpy()
    values = own["phase"].to_numpy(dtype=float)
    try:
        found = slope_of_animals(
            own["speed"].to_numpy(dtype=float), values, animals.tolist(), circular=True, level=level
        )
    except InputError:
        blank = dict.fromkeys(("slope", "ci_low", "ci_high", "p", "sd_animals"), np.nan)
        note = "no animal has three phases at different speeds"
        return {**blank, "n_animals": 0, "n": len(own), "note": note}
    names = np.unique(animals)
    spread = sum(mean_vector(values[animals == name]).r < _SPREAD for name in names)
    notes = [found.note]
    if spread:
        notes.append(
            f"phases of {spread} of {len(names)} animals are spread over much of the cycle "
            f"(r below {_SPREAD}), where a line says little"
        )
    return {
        "slope": found.estimate, "ci_low": found.low, "ci_high": found.high,
        "n_animals": found.n_animals, "p": found.p, "n": len(own), "sd_animals": found.sd,
        "note": "; ".join(note for note in notes if note),
    }  # fmt: skip
