"""How far each trial lies from what its speed lets expect (Mendes et al. 2013, MouseWalker 2015).

Most measures change with speed. What is left of them once a line through all trials is taken away
can be compared between animals that ran at different speeds.
"""

from __future__ import annotations

import pandas as pd

from pawnb.gait.regression import fit_line
from pawnb.gait.regression.lines import differ
from pawnb.workflow.gait.statistics import known_measures

RESIDUAL_COLUMNS = (
    "animal", "trial", "measure", "speed", "value", "expected", "residual", "r2", "n_trials",
)  # fmt: skip
_FEWEST_FOR_LINE = 4


def speed_residuals(strides: pd.DataFrame) -> pd.DataFrame:
    """Take a line on speed away from each measure.

    Parameters
    ----------
    strides : pandas.DataFrame
        Strides: animal, trial, speed and measures.

    Returns
    -------
    pandas.DataFrame
        :data:`RESIDUAL_COLUMNS`, a row for each trial and measure: means over the trial's strides,
        ``expected`` by least squares through the means of all ``n_trials`` trials. Trials of one
        animal are not independent: compare animals, not trials. Empty where fewer than four
        trials ran at different speeds.
    """
    measures = [name for name in known_measures(strides) if name not in ("speed", "speed_bl")]
    means = strides.groupby(["animal", "trial"], sort=True)[["speed", *measures]].mean()
    parts = []
    for measure in measures:
        known = means[["speed", measure]].dropna()
        speed, value = known["speed"].to_numpy(float), known[measure].to_numpy(float)
        if known["speed"].nunique() < _FEWEST_FOR_LINE or not differ(speed):
            continue
        if known[measure].nunique() < 2:
            continue
        line = fit_line(speed, value)
        expected = line.a + line.b * speed
        own = pd.DataFrame(
            {
                "measure": measure, "speed": speed, "value": value, "expected": expected,
                "residual": value - expected, "r2": line.r2, "n_trials": line.n,
            },
            index=known.index,
        )  # fmt: skip
        parts.append(own.reset_index())
    if not parts:
        return pd.DataFrame(columns=list(RESIDUAL_COLUMNS))
    return pd.concat(parts, ignore_index=True)[list(RESIDUAL_COLUMNS)]
