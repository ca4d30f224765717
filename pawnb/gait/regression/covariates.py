"""Several terms at once: groups compared at equal speed, and the like."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from pawnb.errors import InputError
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments


@checked_arguments
def fit_covariates(
    table: pd.DataFrame,
    outcome: str,
    terms: Sequence[str],
    *,
    level: float = 0.95,
    animal: str = "animal",
) -> pd.DataFrame:
    """Fit an outcome on several terms at once, for instance group with speed as covariate.

    Parameters
    ----------
    table : pandas.DataFrame
        One row a point: one an animal, unless points of an animal are independent. Rows with
        a missing value are left out.
    outcome : str
        Column to explain.
    terms : sequence of str
        Columns that explain it. Those that hold words become one term for each level but the
        first in the alphabet, with which the others are compared.
    level : float
        Level of the intervals.
    animal : str
        Column that counts animals; ``n_animals`` is missing where there is none.

    Returns
    -------
    pandas.DataFrame
        term, estimate, se, ci_low, ci_high, t, df, p, n and n_animals: one row for the intercept
        and each term, from ordinary least squares.

    Raises
    ------
    InputError
        If a column is missing, points are too few, or terms repeat one another.
    """
    check_columns(table, [outcome, *terms], where="regression")
    known = table.dropna(subset=[outcome, *terms])
    parts: dict[str, np.ndarray] = {"intercept": np.ones(len(known))}
    for term in terms:
        if pd.api.types.is_numeric_dtype(known[term]):
            parts[term] = known[term].to_numpy(dtype=float)
            continue
        levels = sorted(known[term].astype(str).unique())
        for name in levels[1:]:
            parts[f"{term}: {name} - {levels[0]}"] = (known[term].astype(str) == name).to_numpy()
    design = np.column_stack(list(parts.values())).astype(float)
    df = len(known) - design.shape[1]
    if df < 1:
        raise InputError(
            f"regression: {len(known)} points for {design.shape[1]} coefficients; expected more "
            "points."
        )
    scaled = design / np.maximum(np.abs(design).max(axis=0), 1e-300)
    if np.linalg.matrix_rank(scaled) < design.shape[1]:
        raise InputError("regression: the terms repeat one another or do not vary; leave one out.")
    from statsmodels.regression.linear_model import OLS  # slow to import

    fitted = OLS(known[outcome].to_numpy(dtype=float), design).fit()
    ends = fitted.conf_int(alpha=1.0 - level)
    count = known[animal].nunique() if animal in known else pd.NA
    return pd.DataFrame(
        {
            "term": list(parts), "estimate": fitted.params, "se": fitted.bse,
            "ci_low": ends[:, 0], "ci_high": ends[:, 1], "t": fitted.tvalues, "df": df,
            "p": fitted.pvalues, "n": len(known), "n_animals": count,
        }
    )  # fmt: skip
