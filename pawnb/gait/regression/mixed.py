"""Mixed models: linear outcomes of strides in trials in animals.

For what means by animal cannot do: several terms at once, terms that vary within animals,
unequal numbers of strides. Variances are those of restricted maximum likelihood (REML); errors
and degrees of freedom are those of Kenward and Roger, or come from the animals' own scores: see
:mod:`pawnb.gait.inference.fixed_effects`.

The likelihood is maximised here and not by statsmodels' MixedLM, which agrees where animals
differ clearly, but may stop at quite wrong variances where one is near 0 (an intraclass
correlation of 0.94 in place of 0 in one of the tests), as it often is with 5 animals.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.stats import t as student

from pawnb.arrays import FloatArray, IntArray
from pawnb.errors import InputError
from pawnb.gait.inference.checks import as_numbers, check_level
from pawnb.gait.inference.circular_sample import animal_codes
from pawnb.gait.inference.fixed_effects import estimate_fixed_effects
from pawnb.gait.inference.mixed_likelihood import Blocks
from pawnb.gait.inference.variance_shares import icc_interval
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments

MIXED_COLUMNS = (
    "term", "estimate", "se", "ci_low", "ci_high", "t", "df", "p", "p_strides", "n", "n_animals",
    "method",
)  # fmt: skip

_NOT_IDENTIFIED = (
    "these strides do not tell the variances of animals, slopes and trials apart: other "
    "standard deviations fit as well, so there is no p; leave random parts out "
    "(slopes=False, trials=False), or animals with single strides"
)


@dataclass(frozen=True, kw_only=True, eq=False)
class MixedFit:
    """A fitted mixed model.

    Parameters
    ----------
    terms : pandas.DataFrame
        ``MIXED_COLUMNS``, one row for the intercept and each term; ``method`` is that of the
        error and the degrees of freedom; ``p_strides`` is that of least squares if strides were
        independent, for comparison only. No interval and no p where the strides do not tell
        the variances apart; the note says so.
    icc : float
        Intraclass correlation: share of the variance that the terms leave which lies
        between animals (at the mean of terms with random slopes).
    icc_low, icc_high : float
        Its interval (:func:`pawnb.gait.inference.variance_shares.icc_interval`). NaN where trials
        or slopes are random too, for which there is no exact one; fit without them for it.
    sd_animals, sd_trials, sd_residual : float
        Standard deviations between animals, between trials of an animal (NaN where
        trials are not told apart), and of strides within.
    sd_slopes : dict of str to float
        Standard deviation between animals of the slope of each term that varies within them.
    n, n_animals : int
        Strides and animals.
    note : str
        What the reader must know, else empty.
    """

    terms: pd.DataFrame
    icc: float
    icc_low: float
    icc_high: float
    sd_animals: float
    sd_trials: float
    sd_residual: float
    sd_slopes: dict[str, float]
    n: int
    n_animals: int
    note: str


@checked_arguments
def fit_mixed(
    table: pd.DataFrame,
    outcome: str,
    terms: Sequence[str] = (),
    *,
    level: float = 0.95,
    slopes: bool = True,
    trials: bool = True,
) -> MixedFit:
    """Fit an outcome of strides on terms, with animals, and trials in animals, as random.

    Every animal has its own intercept, and its own slope of each term that varies within
    animals: without these, 50 strides of 5 animals pretend to know the slope of the species
    (Barr et al. 2013). Random effects are independent of each other; terms are taken about
    their mean for the slopes.

    Errors and degrees of freedom are those of Kenward & Roger (1997), as R's pbkrtest prints
    them, but where the variance between animals that a term rests on is estimated as 0: there
    they come from how much the animals' own scores differ (CR2), as Kenward and Roger's p is far
    too large. The column ``method`` says which. ``benchmarks/few_animals.py`` measures false
    positives and power.

    Parameters
    ----------
    table : pandas.DataFrame
        One row a stride with ``animal``, the outcome and the terms; ``trial`` where there
        is one. Rows with a missing value are left out.
    outcome : str
        Column to explain, not a phase.
    terms : sequence of str
        Columns that explain it, numbers or words; words become one term for each level but
        the first in the alphabet. Without terms the intercept is the mean.
    level : float
        Level of the intervals.
    slopes : bool
        Whether animals have slopes of their own.
    trials : bool
        Whether trials of one animal may differ; used where an animal has several trials with
        several strides, and ``trial`` is no term.

    Returns
    -------
    MixedFit
        Terms, variances, and what to know.

    Raises
    ------
    InputError
        If a column is missing or infinite, there are fewer than 2 animals, as many terms
        between animals as animals, too few strides, or terms that repeat one another or the
        animals.
    """
    check_columns(table, ["animal", outcome, *terms], where="mixed model")
    check_level(level)
    if {"animal", outcome} & set(terms):
        raise InputError(f"mixed model: animal and {outcome} cannot be terms; leave them out.")
    known = table.dropna(subset=["animal", outcome, *terms])
    design, names = _design(known, terms)
    y = _finite_outcome(known, outcome, design)
    codes, k = animal_codes(known["animal"].tolist(), len(y)) if len(y) else (np.array([]), 0)
    within = [_varies_within(column, codes) for column in design.T]
    n_between = len(names) - sum(within)
    scale = np.maximum(np.abs(design).max(axis=0, initial=0.0), 1e-300)
    _check_fit(y, design / scale, k, n_between)
    parts = {"animal": np.ones(len(y))}
    random = {name for name, w in zip(names, within, strict=True) if w and slopes}
    parts |= {name: design[:, names.index(name)] for name in names if name in random}
    trial_codes = _trials(known, codes) if trials and "trial" not in terms else None
    centre, unit = float(y.mean()), float(y.std())  # the optimiser wants numbers near 1
    blocks = Blocks((y - centre) / unit, design / scale, codes, parts, trial_codes)
    variances, converged = blocks.fit()
    rests_on = [
        name if name in random else None if w else "animal"
        for name, w in zip(names, within, strict=True)
    ]
    found = estimate_fixed_effects(blocks, variances, rests_on=rests_on)
    estimates, errors = found.estimates * unit / scale, found.errors * unit / scale
    estimates[0] += centre
    residual = found.residual * unit**2
    spread = dict(zip(blocks.names, np.sqrt(variances * residual) / blocks.sizes, strict=True))
    frame = _term_table(names, estimates, errors, found.dfs, level)
    frame["p_strides"] = _naive_p(y, design)
    frame["n"], frame["n_animals"], frame["method"] = len(y), k, found.methods
    sd_trials = spread["trial"] if trial_codes is not None else math.nan
    whole = sum(spread[name] ** 2 for name in ("animal", "trial") if name in spread) + residual
    if not found.identified:
        frame[["ci_low", "ci_high", "p"]] = math.nan
    notes = [
        *_notes_on_fit(converged, none_between=spread["animal"] ** 2 <= 1e-6 * residual),
        *_blind_notes(design, names, codes, random),
        *([] if found.identified else [_NOT_IDENTIFIED]),
    ]
    icc_low = icc_high = math.nan
    if blocks.names == ["animal"]:
        icc_low, icc_high = icc_interval(y, known["animal"].tolist(), design=design, level=level)
    return MixedFit(
        terms=frame[list(MIXED_COLUMNS)], icc=spread["animal"] ** 2 / whole,
        icc_low=icc_low, icc_high=icc_high,
        sd_animals=spread["animal"], sd_trials=sd_trials, sd_residual=math.sqrt(residual),
        sd_slopes={name: spread[name] for name in parts if name != "animal"},
        n=len(y), n_animals=k, note="; ".join(notes),
    )  # fmt: skip


def _notes_on_fit(converged: bool, *, none_between: bool) -> list[str]:
    """Return what to know of how the fit went, and of the variance between animals."""
    notes = [] if converged else ["the fit did not converge: do not use it"]
    if none_between:
        notes.append("no variance between animals found; with few animals this is no proof")
    return notes


def _finite_outcome(known: pd.DataFrame, outcome: str, design: FloatArray) -> FloatArray:
    """Return the outcome as numbers; infinite ones, and infinite terms, are refused."""
    y = as_numbers(known[outcome].to_numpy(), outcome)
    if not (np.isfinite(y).all() and np.isfinite(design).all()):
        raise InputError("mixed model: some values are infinite; leave those strides out.")
    return y


def _blind_notes(
    design: FloatArray, names: list[str], codes: IntArray, random: set[str]
) -> list[str]:
    """Say which animals tell nothing of their own slope of a term."""
    k = int(codes.max()) + 1
    notes: dict[int, list[str]] = {}
    for name in (n for n in names if n in random):
        each = pd.Series(design[:, names.index(name)]).groupby(codes)
        blind = int((each.max() == each.min()).sum())
        if blind:
            notes.setdefault(blind, []).append(name)
    return [
        f"{blind} of {k} animals have one stride or one value of {', '.join(which)} and tell "
        "nothing of their own slope"
        for blind, which in notes.items()
    ]


def _check_fit(y: FloatArray, design: FloatArray, k: int, n_between: int) -> None:
    """Refuse data that do not determine the model."""
    n, n_terms = design.shape
    if k < 2 or k <= n_between or n < k + n_terms:
        raise InputError(
            f"mixed model: {n} strides of {k} animals for {n_terms} terms, {n_between} of "
            "them between animals; expected more animals than terms between them, and several "
            "strides an animal."
        )
    if np.linalg.matrix_rank(design) < n_terms:
        raise InputError("mixed model: the terms repeat one another; leave one out.")
    if np.ptp(y) <= 1e-12 * np.abs(y).max():
        raise InputError("mixed model: the outcome is the same in all strides; nothing to explain.")


def _design(known: pd.DataFrame, terms: Sequence[str]) -> tuple[FloatArray, list[str]]:
    """Return the fixed effects as columns, and their names."""
    parts: dict[str, np.ndarray] = {"intercept": np.ones(len(known))}
    for term in terms:
        if pd.api.types.is_numeric_dtype(known[term]):
            parts[term] = known[term].to_numpy(dtype=float)
            continue
        levels = sorted(known[term].astype(str).unique())
        for name in levels[1:]:
            chosen = (known[term].astype(str) == name).to_numpy()
            parts[f"{term}: {name} - {levels[0]}"] = chosen.astype(float)
    return np.column_stack(list(parts.values())), list(parts)


def _varies_within(column: FloatArray, codes: np.ndarray) -> bool:
    """Return whether a term takes several values in one animal."""
    return bool(pd.Series(column).groupby(codes).nunique().gt(1).any())


def _trials(known: pd.DataFrame, codes: IntArray) -> IntArray | None:
    """Give trials numbers; None where trials cannot be told from animals or from strides."""
    if "trial" not in known:
        return None
    names = known["trial"].astype(str).tolist()
    both = [f"{code}/{name}" for code, name in zip(codes, names, strict=True)]
    numbers = pd.factorize(np.array(both))[0]
    n_trials = int(numbers.max()) + 1
    several = n_trials > len(np.unique(codes)) and n_trials < len(codes)
    return np.asarray(numbers) if several else None


def _term_table(
    names: list[str], estimates: FloatArray, errors: FloatArray, dfs: FloatArray, level: float
) -> pd.DataFrame:
    """Return the table of terms without the counts."""
    t = estimates / errors
    half = student.ppf((1.0 + level) / 2.0, dfs) * errors
    return pd.DataFrame(
        {
            "term": names, "estimate": estimates, "se": errors,
            "ci_low": estimates - half, "ci_high": estimates + half,
            "t": t, "df": dfs, "p": 2.0 * student.sf(np.abs(t), dfs),
        }
    )  # fmt: skip


def _naive_p(y: FloatArray, design: FloatArray) -> FloatArray:
    """Return p of least squares, as if strides were independent."""
    from statsmodels.regression.linear_model import OLS  # slow to import

    return np.asarray(OLS(y, design).fit().pvalues, dtype=float)
