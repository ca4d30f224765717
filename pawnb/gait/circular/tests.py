"""Tests of one sample of phases: randomness, an expected phase, symmetry.

Every test takes ``animals=``, one name a phase. With it, each animal counts once, by its
mean phase, and p speaks of animals. Without it, p holds only if the phases were
independent, which the strides of one animal are not; the result says so.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.special import gammaln, ive
from scipy.stats import binomtest, chi2, chisquare, norm, wilcoxon
from scipy.stats import t as student

from pawnb.arrays import AnyArray, FloatArray
from pawnb.errors import InputError
from pawnb.gait.circular.describe import circular_median, difference
from pawnb.gait.circular.mean import mean_vector, wrap
from pawnb.gait.circular.rayleigh import rayleigh_p
from pawnb.gait.inference.checks import as_numbers
from pawnb.gait.inference.circular_sample import (
    NO_MEAN,
    ONE_ANIMAL,
    TINY,
    CircularTest,
    animal_sample,
    make_result,
    phase_standard_error,
)
from pawnb.schema.arguments import checked_arguments

_PHASE_STEPS = 10**12
"""Steps of a cycle in which phases are compared where rounding would matter."""
_MOST_EXACT = 50


@checked_arguments
def rayleigh_test(
    phases: FloatArray, *, animals: Sequence[object] | None = None, method: str = "exact"
) -> CircularTest:
    """Test whether phases are spread evenly round the cycle, against one preferred phase.

    Rayleigh's test with ``z = n r²`` (paper 2009, Eq. 3.24; Zar 2010, section 27.1). The
    default test at the level of animals: under random phases of animals its p is exact
    whatever the strides within animals do.

    Parameters
    ----------
    phases : ndarray, shape (n,)
        Phases in cycles.
    animals : sequence, shape (n,), optional
        Animal of each phase; each then counts once, by its mean phase.
    method : {"exact", "zar"}
        See :func:`pawnb.gait.circular.rayleigh_p`.

    Returns
    -------
    CircularTest
        ``statistic`` is z.

    Raises
    ------
    InputError
        If phases or animals cannot be used.
    """
    sample, n_animals = animal_sample(phases, animals)
    _, r, n = mean_vector(sample)
    p = rayleigh_p(n, r, method=method)
    how = "exact" if method == "exact" else "Zar's approximation"
    return make_result("Rayleigh z", n * r**2, p, counts=(len(phases), n_animals, how))


@checked_arguments
def v_test(
    phases: FloatArray,
    *,
    expected: float,
    animals: Sequence[object] | None = None,
    method: str = "exact",
) -> CircularTest:
    """Test for randomness against a preference for one expected phase (Zar 2010, 27.1c).

    ``V = n r cos(2 pi (mean - expected))``, one-sided. It asks whether phases are random,
    not whether their mean differs from the expected one: that is :func:`mean_test`.

    Parameters
    ----------
    phases : ndarray, shape (n,)
        Phases in cycles.
    expected : float
        Phase expected before the data were seen, cycles.
    animals : sequence, shape (n,), optional
        Animal of each phase; each then counts once, by its mean phase.
    method : {"exact", "normal"}
        How p is found. ``"normal"``: ``u = V sqrt(2 / n)`` against the normal distribution,
        as Zar, CircStat and pingouin do; far too large in the tail for few phases (1.1e-5
        instead of 3.0e-8 in Zar's own example of 10). ``"exact"``: the distribution of a
        sum of cosines of random angles, found by inverting its moment-generating function
        along a line through its saddle point.

    Returns
    -------
    CircularTest
        ``statistic`` is V.

    Raises
    ------
    InputError
        If phases, animals, the expected phase or the method cannot be used.
    """
    if method not in ("exact", "normal"):
        raise InputError(f"method is {method!r}; expected 'exact' or 'normal'.")
    expected = _checked_expected(expected)
    sample, n_animals = animal_sample(phases, animals)
    n = len(sample)
    v = float(np.cos(2.0 * np.pi * (sample - expected)).sum())
    p = float(norm.sf(v * math.sqrt(2.0 / n))) if method == "normal" else _exact_v_p(v, n)
    how = "exact, one-sided" if method == "exact" else "normal approximation, one-sided"
    return make_result("V", v, p, counts=(len(phases), n_animals, how))


@checked_arguments
def mean_test(
    phases: FloatArray, *, expected: float, animals: Sequence[object] | None = None
) -> CircularTest:
    """Test whether the mean phase differs from an expected one, for instance 0.5.

    Without animals: the confidence interval of the mean turned into a p (Upton; Zar 2010,
    section 27.1d asks whether the expected phase lies within the interval): ``statistic``
    is chi² with 1 degree of freedom. With animals: Student's t of the sines of the animals'
    mean phases about the common mean, with as many degrees of freedom as animals less
    one. Where the t of the sines about the expected phase has a larger p, that is taken: so it
    agrees with :func:`pawnb.gait.inference.animal_phases.interval_of_phases`.

    Parameters
    ----------
    phases : ndarray, shape (n,)
        Phases in cycles.
    expected : float
        The phase of the null hypothesis, cycles.
    animals : sequence, shape (n,), optional
        Animal of each phase; each then counts once, by its mean phase.

    Returns
    -------
    CircularTest
        ``statistic`` is chi² or t.

    Raises
    ------
    InputError
        If phases, animals or the expected phase cannot be used.
    """
    expected = _checked_expected(expected)
    sample, n_animals = animal_sample(phases, animals)
    mean, r, n = mean_vector(sample)
    counts = (len(phases), n_animals)
    if n < 2 or not math.isfinite(mean):
        note = NO_MEAN if n > 1 else ONE_ANIMAL if n_animals == 1 else "one phase: no test"
        return CircularTest("mean phase", math.nan, math.nan, *counts, "none", note)
    away = float(difference(np.array([mean]), expected)[0])
    if n_animals is not None:
        error = phase_standard_error(sample)
        t = away / error if error > 0.0 else math.copysign(math.inf, away) if away else 0.0
        if abs(away) < 0.25:
            across = np.sin(2.0 * np.pi * (sample - expected))
            spread = float(across.std(ddof=1)) / math.sqrt(n)
            least = abs(float(across.mean())) / spread if spread > 0.0 else abs(t)
            p = max(float(2.0 * student.sf(min(abs(t), least), n - 1)), TINY)
        else:
            p = max(float(2.0 * student.sf(abs(t), n - 1)), TINY)
        return make_result("t of mean phase", t, p, counts=(*counts, f"Student's t, {n - 1} df"))
    statistic = _upton_chi2(away, r, n)
    p = max(float(chi2.sf(statistic, 1)), TINY)
    return make_result("chi² of mean phase", statistic, p, counts=(*counts, "chi², 1 df"))


@checked_arguments
def hodges_ajne_test(
    phases: FloatArray, *, animals: Sequence[object] | None = None
) -> CircularTest:
    """Test for randomness against any concentration on one half of the circle.

    The omnibus test of Hodges and Ajne (Zar 2010, section 27.2): m is the fewest phases on
    one side of any diameter. It needs no shape of distribution and is weaker than
    Rayleigh's. p is exact for every m: the series of Bhattacharyya and Johnson (1969), whose
    first term alone is Zar's Eq. 27.7, right for m below n / 3 only.

    Parameters
    ----------
    phases : ndarray, shape (n,)
        Phases in cycles.
    animals : sequence, shape (n,), optional
        Animal of each phase; each then counts once, by its mean phase.

    Returns
    -------
    CircularTest
        ``statistic`` is m. ``smallest_p`` is that of m = 0: 0.75 for 3 phases, 0.063 for 8.

    Raises
    ------
    InputError
        If phases or animals cannot be used.
    """
    sample, n_animals = animal_sample(phases, animals)
    n = len(sample)
    # in whole steps of a small angle, so that opposite phases are exactly opposite
    steps = np.sort(
        np.mod(np.rint(np.mod(sample, 1.0) * _PHASE_STEPS).astype(np.int64), _PHASE_STEPS)
    )
    turns = np.concatenate((steps, steps + _PHASE_STEPS))
    # half circles that begin just at, and just after, each phase
    at = np.searchsorted(turns, steps + _PHASE_STEPS // 2) - np.searchsorted(turns, steps)
    after = np.searchsorted(turns, steps + _PHASE_STEPS // 2, side="right") - np.searchsorted(
        turns, steps, side="right"
    )
    m = int(min(at.min(), after.min(), n - at.max(), n - after.max()))
    return make_result(
        "Hodges-Ajne m", float(m), _hodges_ajne_p(m, n), counts=(len(phases), n_animals, "exact"),
        smallest_p=_hodges_ajne_p(0, n),
    )  # fmt: skip


def _hodges_ajne_p(m: int, n: int) -> float:
    """Return P(fewest phases on one side of a diameter <= m): Bhattacharyya & Johnson's series."""
    if 2 * m >= n:
        return 1.0
    k = n - m
    j = np.arange(k, n + 1, 2 * k - n)
    choose = gammaln(n + 1) - gammaln(j + 1) - gammaln(n - j + 1)
    terms = np.exp(choose + math.log(2 * k - n) - (n - 1) * math.log(2.0))
    return min(1.0, float(terms.sum()))


@checked_arguments
def batschelet_test(
    phases: FloatArray, *, expected: float, animals: Sequence[object] | None = None
) -> CircularTest:
    """Test for randomness against an expected phase by counting (Zar 2010, section 27.2b).

    Phases more than a quarter of a cycle away from the expected one are counted; two-sided
    binomial test against one half.

    Parameters
    ----------
    phases : ndarray, shape (n,)
        Phases in cycles.
    expected : float
        Phase expected before the data were seen, cycles.
    animals : sequence, shape (n,), optional
        Animal of each phase; each then counts once, by its mean phase.

    Returns
    -------
    CircularTest
        ``statistic`` is the count C. ``smallest_p`` is that of C = 0: 0.25 for 3 phases.

    Raises
    ------
    InputError
        If phases, animals or the expected phase cannot be used.
    """
    expected = _checked_expected(expected)
    sample, n_animals = animal_sample(phases, animals)
    count = int((np.abs(difference(sample, expected)) > 0.25).sum())
    n = len(sample)
    p, least = (float(binomtest(c, n, 0.5).pvalue) for c in (count, 0))
    counts = (len(phases), n_animals, "binomial")
    return make_result("Batschelet C", float(count), p, counts=counts, smallest_p=least)


@checked_arguments
def symmetry_test(phases: FloatArray, *, animals: Sequence[object] | None = None) -> CircularTest:
    """Test whether phases are spread symmetrically about their median (Zar 2010, section 27.3).

    Wilcoxon's signed ranks of the distances from the median.

    Parameters
    ----------
    phases : ndarray, shape (n,)
        Phases in cycles.
    animals : sequence, shape (n,), optional
        Animal of each phase; each then counts once, by its mean phase.

    Returns
    -------
    CircularTest
        ``statistic`` is the smaller sum of ranks. As half of the phases lie on each side of
        their own median, the test is a careful one: ``smallest_p`` is 0.31 for 9 phases and
        falls below 0.05 from 25 phases on, for even numbers from 30.

    Raises
    ------
    InputError
        If phases or animals cannot be used, or no median exists.
    """
    sample, n_animals = animal_sample(phases, animals)
    median = circular_median(sample)
    if not math.isfinite(median):
        raise InputError("the phases have no median: they are evenly spread round the cycle.")
    # equal distances must stay equal in spite of rounding, or their ranks differ
    away = np.round(difference(sample, median), 12)
    away = away[away != 0.0]
    if len(away) == 0:
        return make_result("Wilcoxon T", 0.0, 1.0, counts=(len(phases), n_animals, "no distances"))
    ties = len(np.unique(np.abs(away))) < len(away)
    how = "asymptotic" if ties or len(away) > _MOST_EXACT else "exact"
    found = wilcoxon(away, method="asymptotic" if how == "asymptotic" else "exact")
    p = float(found.pvalue)
    return make_result(
        "Wilcoxon T", float(found.statistic), p, counts=(len(phases), n_animals, how),
        smallest_p=min(p, _smallest_symmetry_p(len(sample))),
    )  # fmt: skip


def _smallest_symmetry_p(n: int) -> float:
    """Return p where all n phases on one side of the median are nearer than those beyond it.

    Of an even number the innermost two are equally far from their middle.
    """
    half = n // 2
    other = np.arange(half) + half + (n % 2)
    if n % 2 == 0:
        other[0] = 1
    away = np.concatenate((-1.0 - np.arange(half), other))
    exact = n % 2 == 1 and n <= _MOST_EXACT
    return float(wilcoxon(away, method="exact" if exact else "asymptotic").pvalue)


@checked_arguments
def chi2_uniform_test(counts: AnyArray) -> CircularTest:
    """Test whether phases counted in equal classes are spread evenly (Zar 2010, Example 27.23).

    Parameters
    ----------
    counts : ndarray, shape (k,)
        Number of phases in each of k equal classes that cover the whole cycle; empty ones too.

    Returns
    -------
    CircularTest
        ``statistic`` is chi² with k - 1 degrees of freedom.

    Raises
    ------
    InputError
        If there are fewer than two classes or no phases, or a count is negative.
    """
    counts = as_numbers(counts, "counts")
    if len(counts) < 2 or not (counts >= 0).all() or not 0 < counts.sum() < 1e15:
        raise InputError("counts: expected two classes or more, with numbers of 0 or more in them.")
    found = chisquare(counts)
    how = f"chi², {len(counts) - 1} df"
    return make_result(
        "chi²", float(found.statistic), float(found.pvalue), counts=(int(counts.sum()), None, how)
    )


def _checked_expected(expected: float) -> float:
    """Return an expected phase in [0, 1); refuse one that is no number."""
    if not math.isfinite(expected):
        raise InputError(f"expected is {expected}; expected a phase in cycles, for instance 0.5.")
    return wrap(float(expected))


def _upton_chi2(away: float, r: float, n: int) -> float:
    """Return the chi² at which the interval of the mean (Zar 26.24, 26.25) just reaches."""
    total2 = (n * r) ** 2
    along2 = total2 * max(0.0, math.cos(2.0 * math.pi * away)) ** 2
    if r <= 0.9:
        return 4.0 * n * (total2 - along2) / (2.0 * n**2 - along2)
    if total2 >= n**2:
        return math.inf if along2 < total2 else 0.0
    return n * math.log((n**2 - along2) / (n**2 - total2))


def _exact_v_p(v: float, n: int) -> float:
    """Return P(sum of n cosines of random angles > v).

    ``1 / (2 pi i) * integral of I0(s)^n exp(-s v) / s ds`` along a line Re s = k > 0.
    """
    if v <= -n or v >= n:
        return 1.0 if v <= -n else TINY
    if v < 0.0:
        return 1.0 - _exact_v_p(-v, n)
    if n == 1:
        return math.acos(v) / math.pi
    r = v / n
    height = max(r * (2.0 - r**2) / (1.0 - r**2), n**-0.5)
    step = min(height / 8.0, math.sqrt(2.0 / n) * max(1.0, 0.7 * height) / 2.0)
    reach = height * min(2000.0, 10.0 ** (60.0 / (n + 2))) + 24.0 * step
    s = height + 1j * step * np.arange(math.ceil(reach / step))
    # ive is scaled by exp(-Re s); put back here
    values = np.exp(n * (np.log(ive(0, s)) + height) - s * v - np.log(s)).real
    return float(np.clip(step * (values.sum() - values[0] / 2.0) / math.pi, TINY, 1.0))
