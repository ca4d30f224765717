"""Correlation of phases with speed or another number, and with other phases."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from scipy.stats import chi2, norm
from scipy.stats import f as fisher

from pawnb.arrays import AnyArray, FloatArray, IntArray
from pawnb.errors import InputError
from pawnb.gait.circular.mean import check_phases
from pawnb.gait.inference.checks import as_numbers
from pawnb.gait.inference.circular_sample import AS_INDEPENDENT, TINY, animal_codes
from pawnb.gait.inference.permutations import shuffle_in_blocks
from pawnb.schema.arguments import checked_arguments

_MOST_ORDERS = 5_040


class CircularCorrelation(NamedTuple):
    """Correlation that involves phases.

    Attributes
    ----------
    r : float
        Coefficient: 0 to 1 for a phase with a number, -1 to 1 for two phases.
    statistic : float
        What ``p`` rests on.
    p : float
        By the formula named in ``method``.
    p_permutation : float
        By permutation: of all orders for up to 7 pairs, else of random ones.
    n : int
        Number of pairs given.
    n_animals : int or None
        Number of animals that p counts; None where pairs were taken as independent.
    method : str
        How p was found.
    note : str
        What the reader must know, else empty.
    """

    r: float
    statistic: float
    p: float
    p_permutation: float
    n: int
    n_animals: int | None
    method: str
    note: str = ""


@checked_arguments
def angular_linear(
    phases: FloatArray,
    values: AnyArray,
    *,
    animals: Sequence[object] | None = None,
    method: str = "chi2",
    n_permutations: int = 9_999,
    seed: int = 0,
) -> CircularCorrelation:
    """Correlate phases with a number such as speed (paper 2009, Eq. 3.26; Zar 2010, 27.15a).

    ``r² = (r_xc² + r_xs² - 2 r_xc r_xs r_cs) / (1 - r_cs²)``: the multiple correlation of the
    number with cosine and sine of the phase. r has no sign, is above 0 by chance (about
    sqrt(2 / n)), and is not 1 where a phase that turns steadily goes round the whole cycle
    (0.78). ``"chi2"`` holds n r² against chi² with 2 degrees of freedom, as the paper,
    CircStat and pingouin do; with few pairs it is far too large where r is high (0.033 for
    Zar's 7 pairs; permutation says 0.0024). ``"f"`` is Mardia's F, (n - 3) r² / (2 (1 - r²)),
    for normal numbers.

    Parameters
    ----------
    phases : ndarray, shape (n,)
        Phases in cycles.
    values : ndarray, shape (n,)
        The number that goes with each.
    animals : sequence, shape (n,), optional
        Animal of each pair; each then counts once, by its mean phase and mean number. To ask
        whether phase changes with speed *within* animals see
        :func:`pawnb.gait.groups.animals.slope_of_animals`.
    method : {"chi2", "f"}
        How ``p`` is found.
    n_permutations, seed : int
        Number and seed of random permutations.

    Returns
    -------
    CircularCorrelation
        ``statistic`` is n r², or F.

    Raises
    ------
    InputError
        If there are fewer than 4 pairs (of animals, with ``animals``), if numbers are missing
        or all the same, or if phases lie on one line through the circle.
    """
    if method not in ("chi2", "f"):
        raise InputError(f"method is {method!r}; expected 'chi2' or 'f'.")
    phases, values = check_phases(phases), _checked_values(values, len(phases))
    vectors, x, n_animals = _pairs(phases, values, animals)
    n = len(x)
    basis = np.column_stack((np.cos(vectors), np.sin(vectors)))
    basis = basis - basis.mean(axis=0)
    x = x - x.mean()
    if n < 4 or not x.any():
        raise InputError(
            f"angular-linear correlation: found {n} pairs, or numbers that are all the same; "
            "expected 4 or more, with different numbers."
        )
    q, triangle = np.linalg.qr(basis)
    if np.abs(np.diag(triangle)).min() < 1e-9:
        raise InputError("the phases take only one or two values; expected three or more.")
    x = x / np.linalg.norm(x)

    def squared(order: IntArray) -> FloatArray:
        return ((x[order] @ q) ** 2).sum(axis=-1)

    r2 = min(1.0, float(squared(np.arange(n))))
    if method == "chi2":
        statistic, p, how = n * r2, float(chi2.sf(n * r2, 2)), "chi², 2 df"
    else:
        statistic = (n - 3) * r2 / (2.0 * (1.0 - r2)) if r2 < 1.0 else math.inf
        p, how = float(fisher.sf(statistic, 2, n - 3)), f"F, 2 and {n - 3} df"
    by_permutation = _permuted_p(squared, n, n_permutations, seed)
    note = AS_INDEPENDENT if n_animals is None else ""
    counts = (len(phases), n_animals, how, note)
    return CircularCorrelation(math.sqrt(r2), statistic, max(p, TINY), by_permutation, *counts)


@checked_arguments
def angular_angular(
    phases: FloatArray,
    others: FloatArray,
    *,
    animals: Sequence[object] | None = None,
    method: str = "jammalamadaka",
    n_permutations: int = 9_999,
    seed: int = 0,
) -> CircularCorrelation:
    """Correlate two phases, for instance those of two pairs of legs in the same strides.

    ``"jammalamadaka"``: Jammalamadaka and SenGupta (2001), as in CircStat, R and astropy, whose
    function is used; p by the normal distribution. ``"fisher-lee"``: Fisher and Lee (1983), Zar
    (2010) Eq. 27.43, from sines of the differences of all pairs of pairs; p by permutation only.
    The two answer differently (0.82 and 0.89 in Zar's example): the first is about the means, which
    must exist; the second needs none.

    Parameters
    ----------
    phases, others : ndarray, shape (n,)
        Phases in cycles.
    animals : sequence, shape (n,), optional
        Animal of each pair; each then counts once, by its two mean phases.
    method : {"jammalamadaka", "fisher-lee"}
        Which coefficient.
    n_permutations, seed : int
        Number and seed of random permutations.

    Returns
    -------
    CircularCorrelation
        ``p_permutation`` is two-sided.

    Raises
    ------
    InputError
        If there are fewer than 4 pairs (of animals, with ``animals``), or phases do not vary.
    """
    if method not in ("jammalamadaka", "fisher-lee"):
        raise InputError(f"method is {method!r}; expected 'jammalamadaka' or 'fisher-lee'.")
    phases, others = check_phases(phases), check_phases(others)
    if len(phases) != len(others):
        raise InputError(f"found {len(phases)} phases and {len(others)} others; expected pairs.")
    a, _, n_animals = _pairs(phases, None, animals)
    b, _, _ = _pairs(others, None, animals)
    n = len(a)
    if n < 4 or len(a) != len(b) or np.ptp(np.exp(1j * a)) == 0 or np.ptp(np.exp(1j * b)) == 0:
        raise InputError(
            f"angular-angular correlation: found {n} pairs, or phases that are all the same; "
            "expected 4 or more that differ, with a mean phase in every animal."
        )
    coefficient = _jammalamadaka(a, b) if method == "jammalamadaka" else _fisher_lee(a, b)
    r = float(coefficient(np.arange(n)))
    by_permutation = _permuted_p(lambda order: np.abs(coefficient(order)), n, n_permutations, seed)
    note = AS_INDEPENDENT if n_animals is None else ""
    if method == "fisher-lee":
        counts = (len(phases), n_animals, "permutation", note)
        return CircularCorrelation(r, r, by_permutation, by_permutation, *counts)
    u, v = _about_mean(a) ** 2, _about_mean(b) ** 2
    statistic = r * math.sqrt(n * u.mean() * v.mean() / (u * v).mean())
    p = max(2.0 * float(norm.sf(abs(statistic))), TINY)
    counts = (len(phases), n_animals, "normal approximation", note)
    return CircularCorrelation(r, statistic, p, by_permutation, *counts)


def _jammalamadaka(a: FloatArray, b: FloatArray) -> Callable[[np.ndarray], np.ndarray]:
    """Return the coefficient for orders of the second phases; the first one is astropy's."""
    from astropy.stats import circcorrcoef  # slow to import, needed here only

    u, v = _about_mean(a), _about_mean(b)
    scale = float(circcorrcoef(a, b)) / float(u @ v) if u @ v else 1.0 / math.sqrt(u @ u * (v @ v))
    return lambda order: (v[order] @ u) * scale


def _fisher_lee(a: FloatArray, b: FloatArray) -> Callable[[np.ndarray], np.ndarray]:
    """Return the coefficient for orders of the second phases, without the n² differences."""

    def product(x: FloatArray, y: FloatArray) -> FloatArray:
        """Sum sin(x_i - x_j) sin(y_i - y_j) over all i < j."""
        n = x.shape[-1]
        minus, plus = np.exp(1j * (x - y)).sum(-1), np.exp(1j * (x + y)).sum(-1)
        return (np.abs(minus) ** 2 - n - np.abs(plus) ** 2 + n) / 4.0

    scale = math.sqrt(float(product(a, a)) * float(product(b, b)))
    return lambda order: product(a, b[order]) / scale


def _about_mean(angles: FloatArray) -> FloatArray:
    """Return the sines of angles about their mean."""
    return np.sin(angles - np.angle(np.exp(1j * angles).sum()))


def _pairs(
    phases: FloatArray, values: FloatArray | None, animals: Sequence[object] | None
) -> tuple[FloatArray, FloatArray, int | None]:
    """Return angles in radians and values, one of each an animal where animals are given."""
    if values is None:
        values = np.zeros(len(phases))
    angles = 2.0 * np.pi * phases
    if animals is None:
        return angles, values, None
    codes, k = animal_codes(animals, len(phases))
    each = np.bincount(codes, minlength=k)
    c, s = (np.bincount(codes, f(angles), k) / each for f in (np.cos, np.sin))
    known = np.hypot(c, s) > 1e-12
    means = np.bincount(codes, values, k) / each
    return np.arctan2(s, c)[known], means[known], int(known.sum())


def _permuted_p(
    statistic: Callable[[np.ndarray], np.ndarray], n: int, n_permutations: int, seed: int
) -> float:
    """Return the share of orders whose statistic is at least that of the order given."""
    observed = float(statistic(np.arange(n))) - 1e-9
    if math.factorial(n) <= _MOST_ORDERS:
        orders = np.array(list(itertools.permutations(range(n))))
        return float((statistic(orders) >= observed).mean())
    high = sum(
        int((statistic(orders) >= observed).sum())
        for orders in shuffle_in_blocks(np.arange(n), n_permutations, seed=seed)
    )
    return (1.0 + high) / (1.0 + n_permutations)


def _checked_values(values: np.ndarray, n: int) -> FloatArray:
    """Return the numbers as floats; refuse missing ones."""
    values = as_numbers(values, "values")
    # squares must be finite too
    if len(values) != n or not (np.abs(values) < 1e150).all():
        raise InputError(
            f"values: found {len(values)} for {n} phases, or some that are not finite; expected "
            "one finite number a phase."
        )
    return values
