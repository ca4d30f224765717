"""Left against right: symmetry indices of stride measures."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from pawnb.gait.legs import find_leg_place
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments

SYMMETRY_COLUMNS = (
    "animal", "pair", "left", "right", "measure", "n_left", "n_right", "left_mean", "right_mean",
    "symmetry_index", "ratio",
)  # fmt: skip
SYMMETRIC = ("stance_s", "swing_s", "duty_factor", "stride_length", "step_displacement")


@checked_arguments
def symmetry_table(strides: pd.DataFrame, *, measures: Sequence[str] = SYMMETRIC) -> pd.DataFrame:
    """Compare the left with the right leg of each pair, animal by animal.

    Parameters
    ----------
    strides : pandas.DataFrame
        Strides of one or more animals.
    measures : sequence of str
        Columns to compare.

    Returns
    -------
    pandas.DataFrame
        One row for animal, pair of legs and measure: means of both legs, the symmetry index
        ``200 (L - R) / (L + R)`` in percent (Robinson, Herzog & Nigg 1987: 0 is symmetrical,
        positive where the left is greater) and the ratio L / R. NaN where a mean is missing or
        both are 0. Legs without a partner are left out.

    Raises
    ------
    InputError
        If a measure is no column of the strides, or holds no numbers.
    """
    check_columns(strides, ("animal", "leg", *measures), where="strides", numbers=measures)
    rows = []
    for animal, own in strides.groupby("animal", sort=True):
        legs = {str(leg): part for leg, part in own.groupby("leg")}
        for left, right in _pairs(list(legs)):
            for measure in measures:
                values = [legs[leg][measure].dropna() for leg in (left, right)]
                a, b = (float(v.mean()) for v in values)
                total = a + b
                rows.append(
                    {
                        "animal": animal,
                        "pair": f"{left}:{right}",
                        "left": left,
                        "right": right,
                        "measure": measure,
                        "n_left": len(values[0]),
                        "n_right": len(values[1]),
                        "left_mean": a,
                        "right_mean": b,
                        "symmetry_index": 200.0 * (a - b) / total if total else np.nan,
                        "ratio": a / b if b else np.nan,
                    }
                )
    return pd.DataFrame(rows, columns=list(SYMMETRY_COLUMNS))


def _pairs(legs: Sequence[str]) -> list[tuple[str, str]]:
    """Return left and right leg of each pair, from the front."""
    places = {place: leg for leg in legs if (place := find_leg_place(leg)) is not None}
    ranks = sorted({place.rank for place in places})
    by = {(place.side, place.rank): leg for place, leg in places.items()}
    return [(by["L", k], by["R", k]) for k in ranks if ("L", k) in by and ("R", k) in by]
