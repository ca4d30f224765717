"""Tests of two or more samples of phases against each other.

Every test takes a tidy pair of arrays, phases and the group of each, and ``animals=``, one
name a phase. With it, each animal counts once, by its mean phase, and p speaks of animals.
Without it, p holds only if the phases were independent, and the result says so.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence

import numpy as np
from scipy.stats import chi2, rankdata
from scipy.stats import f as fisher

from pawnb.arrays import BoolArray, FloatArray, IntArray
from pawnb.errors import InputError
from pawnb.gait.circular.describe import concentration
from pawnb.gait.circular.mean import check_phases, mean_vector
from pawnb.gait.inference.circular_sample import (
    TINY,
    CircularTest,
    animal_codes,
    animal_sample,
    make_result,
)
from pawnb.gait.inference.permutations import shuffle_in_blocks
from pawnb.schema.arguments import checked_arguments

_MOST_GROUPINGS = 20_000
_LEAST_R = ((11.0, 0.45), (7.0, 0.5), (0.0, 0.55))
"""Phases a group, and from which mean r on Watson and Williams' F may be used (CircStat's
circ_wwtest; its further rule of 5 phases a group is not needed: 3 and 3 hold their level)."""


@checked_arguments
def watson_williams_test(
    phases: FloatArray, groups: Sequence[object], *, animals: Sequence[object] | None = None
) -> CircularTest:
    """Test whether two or more groups have the same mean phase (Zar 2010, section 27.4).

    ``F = K (N - k) (sum of R_i - R) / ((k - 1) (N - sum of R_i))`` with
    ``K = 1 + 3 / (8 kappa)``. It takes the groups to be von Mises with one concentration, and
    r to be large. Libraries differ in kappa: here, as in CircStat and pycircstat2, it is that
    of the mean of the groups' r weighted by n, which is what Zar's table of K is entered
    with; R takes that of all phases together, which is smaller where the means differ (F is
    0.3 % larger in Zar's example of two groups, 1 % in that of three). Both use Fisher's
    approximation of kappa.

    Parameters
    ----------
    phases : ndarray, shape (n,)
        Phases in cycles.
    groups : sequence, shape (n,)
        Group of each phase.
    animals : sequence, shape (n,), optional
        Animal of each phase; each then counts once, by its mean phase.

    Returns
    -------
    CircularTest
        ``statistic`` is F with k - 1 and N - k degrees of freedom. Where r is too small for the
        test by CircStat's rule (below 0.45; 0.5 of fewer than 11 phases a group; 0.55 of fewer
        than 7) there is no p, and the note says so: of phases at random 20 to 49 % would have
        one below 0.05.

    Raises
    ------
    InputError
        If phases, groups or animals cannot be used, or all phases of each group are equal.
    """
    samples, n_animals = group_samples(phases, groups, animals=animals)
    k, n = len(samples), sum(len(s) for s in samples)
    lengths = sum(len(s) * mean_vector(s).r for s in samples)
    _, r, _ = mean_vector(np.concatenate(samples))
    if n - lengths < 1e-12 * n or n == k:
        raise InputError(
            "groups: the phases do not vary within groups; expected two or more that differ."
        )
    correction = 1.0 + 3.0 / (8.0 * concentration(lengths / n, method="fisher"))
    f = correction * (n - k) * (lengths - n * r) / ((k - 1) * (n - lengths))
    p = max(float(fisher.sf(f, k - 1, n - k)), TINY)
    counts = (len(phases), n_animals, f"F, {k - 1} and {n - k} df")
    found = make_result("Watson-Williams F", f, p, counts=counts)
    limit = next(least for size, least in _LEAST_R if n / k >= size)
    if lengths / n >= limit:
        return found
    note = (
        f"r within groups is below {limit}: too scattered for this test, so no p "
        "(wheeler_watson_test needs no such r)"
    )
    return found._replace(p=math.nan, note=f"{found.note}; {note}" if found.note else note)


@checked_arguments
def watson_u2_test(
    phases: FloatArray,
    groups: Sequence[object],
    *,
    animals: Sequence[object] | None = None,
    n_permutations: int = 9_999,
    seed: int = 0,
) -> CircularTest:
    """Test whether two groups have the same distribution of phases (Zar 2010, section 27.5).

    Watson's U² with ties as in Zar's Eq. 27.17. p by permutation of phases (of animals, with
    ``animals``) between the groups: all arrangements where there are at most 20,000.

    Parameters
    ----------
    phases : ndarray, shape (n,)
        Phases in cycles.
    groups : sequence, shape (n,)
        Group of each phase; two groups.
    animals : sequence, shape (n,), optional
        Animal of each phase; each then counts once, by its mean phase.
    n_permutations, seed : int
        Number and seed of random permutations.

    Returns
    -------
    CircularTest
        ``statistic`` is U². ``smallest_p`` is that of the most separate of all arrangements: two
        groups of 3 cannot have a p below 0.3, of 4 below 0.11.

    Raises
    ------
    InputError
        If phases, groups or animals cannot be used, or there are not two groups.
    """
    samples, n_animals = group_samples(phases, groups, animals=animals)
    if len(samples) != 2:
        raise InputError(f"groups: found {len(samples)}; Watson's U² compares two.")
    values = np.round(np.mod(np.concatenate(samples), 1.0), 12)
    _, place, ties = np.unique(values, return_inverse=True, return_counts=True)
    n1, n = len(samples[0]), len(values)

    def statistic(members: BoolArray) -> FloatArray:
        """Compute U² for rows of truth values: which phases are in the first group."""
        each = np.zeros((len(members), len(ties)))
        rows, columns = np.nonzero(members)
        np.add.at(each, (rows, place[columns]), 1.0)
        first = np.cumsum(each, axis=1) / n1
        d = first - (np.cumsum(ties) - np.cumsum(each, axis=1)) / (n - n1)
        return n1 * (n - n1) / n**2 * ((d**2) @ ties - (d @ ties) ** 2 / n)

    sizes = [n1, n - n1]
    observed, p, least, how = _permute(statistic, sizes, n_permutations, seed)
    counts = (len(phases), n_animals, how)
    return make_result("Watson U²", observed, p, counts=counts, smallest_p=least, sizes=sizes)


@checked_arguments
def wheeler_watson_test(
    phases: FloatArray,
    groups: Sequence[object],
    *,
    animals: Sequence[object] | None = None,
    method: str = "permutation",
    n_permutations: int = 9_999,
    seed: int = 0,
) -> CircularTest:
    """Test whether two or more groups have the same distribution of phases, by ranks.

    The test of Wheeler and Watson, or Mardia-Watson-Wheeler (Zar 2010, section 27.5): phases
    are replaced by evenly spaced ranks; ``W = 2 (N - 1) / N sum of (C_i² + S_i²) / n_i``. The
    factor (N - 1) / N is in Zar's equation for two groups and in R; with it the mean of W
    over all permutations is exactly its degrees of freedom, for any number of groups.

    Parameters
    ----------
    phases : ndarray, shape (n,)
        Phases in cycles.
    groups : sequence, shape (n,)
        Group of each phase.
    animals : sequence, shape (n,), optional
        Animal of each phase; each then counts once, by its mean phase.
    method : {"permutation", "chi2"}
        How p is found: by permutation between groups, or by chi² with 2 (k - 1) degrees of
        freedom, as Zar and R do, which needs 10 phases a group.
    n_permutations, seed : int
        Number and seed of random permutations.

    Returns
    -------
    CircularTest
        ``statistic`` is W. ``smallest_p`` is that of the most separate of all arrangements: two
        groups of 3 cannot have a p below 0.3, of 4 below 0.11.

    Raises
    ------
    InputError
        If phases, groups or animals cannot be used, or the method is unknown.
    """
    if method not in ("permutation", "chi2"):
        raise InputError(f"method is {method!r}; expected 'permutation' or 'chi2'.")
    samples, n_animals = group_samples(phases, groups, animals=animals)
    sizes = [len(s) for s in samples]
    ranks = rankdata(np.round(np.mod(np.concatenate(samples), 1.0), 12))
    vectors = np.exp(2j * np.pi * ranks / len(ranks))
    scale = 2.0 * (len(ranks) - 1) / len(ranks)

    if method == "chi2":
        which = np.repeat(np.arange(len(sizes)), sizes)
        w = scale * sum(abs(vectors[which == i].sum()) ** 2 / m for i, m in enumerate(sizes))
        p = max(float(chi2.sf(w, 2 * (len(sizes) - 1))), TINY)
        counts = (len(phases), n_animals, f"chi², {2 * (len(sizes) - 1)} df")
        return make_result("Wheeler-Watson W", float(w), p, counts=counts)

    def two(members: BoolArray) -> FloatArray:
        first = members @ vectors
        rest = vectors.sum() - first
        return scale * (np.abs(first) ** 2 / sizes[0] + np.abs(rest) ** 2 / sizes[1])

    def many(codes: IntArray) -> FloatArray:
        parts = [np.abs((codes == i) @ vectors) ** 2 / m for i, m in enumerate(sizes)]
        return scale * np.sum(parts, axis=0)

    statistic = two if len(sizes) == 2 else many
    observed, p, least, how = _permute(statistic, sizes, n_permutations, seed)
    counts = (len(phases), n_animals, how)
    return make_result(
        "Wheeler-Watson W", observed, p, counts=counts, smallest_p=least, sizes=sizes
    )


@checked_arguments
def group_samples(
    phases: FloatArray, groups: Sequence[object], *, animals: Sequence[object] | None = None
) -> tuple[list[FloatArray], int | None]:
    """Divide phases into the samples of their groups, one phase an animal where asked.

    Parameters
    ----------
    phases : ndarray, shape (n,)
        Phases in cycles.
    groups : sequence, shape (n,)
        Group of each phase.
    animals : sequence, shape (n,), optional
        Animal of each phase; each then counts once, by its mean phase.

    Returns
    -------
    samples : list of ndarray
        Groups in the order of their names.
    n_animals : int or None
        Number of animals; None without animals.

    Raises
    ------
    InputError
        If there is not one group a phase, only one group, or an animal in two groups.
    """
    phases = check_phases(phases)
    names = [str(g) for g in groups]
    if len(names) != len(phases):
        raise InputError(
            f"groups: found {len(names)} for {len(phases)} phases; expected one a phase."
        )
    which = np.array(names)
    known = sorted(set(names))
    if len(known) < 2:
        raise InputError(f"groups: found only {known}; expected two or more.")
    if animals is None:
        return [phases[which == name] for name in known], None
    owners = np.array([str(a) for a in animals])
    animal_codes(list(owners), len(phases))
    shared = [a for a in np.unique(owners) if len(set(which[owners == a])) > 1]
    if shared:
        raise InputError(
            f"animal {shared[0]} is in more than one group; compare conditions within animals "
            "with pawnb.gait.groups.compare_groups(..., paired=True)."
        )
    samples = []
    for name in known:
        sample, _ = animal_sample(phases[which == name], list(owners[which == name]))
        samples.append(sample)
    return samples, sum(len(s) for s in samples)


def _permute(
    statistic: Callable[[np.ndarray], np.ndarray], sizes: list[int], n_permutations: int, seed: int
) -> tuple[float, float, float, str]:
    """Return the statistic of the groups as given, its p by permutation, the least p, and how.

    For two groups ``statistic`` is given rows of truth values (in the first group), for more
    rows of group numbers.
    """
    n = sum(sizes)
    given = np.repeat(np.arange(len(sizes)), sizes)
    two = len(sizes) == 2
    observed = float(statistic((given == 0 if two else given)[None, :])[0])
    if two and math.comb(n, sizes[0]) <= _MOST_GROUPINGS:
        rows = list(itertools.combinations(range(n), sizes[0]))
        members = np.zeros((len(rows), n), dtype=bool)
        np.put_along_axis(members, np.array(rows), True, axis=1)
        found = statistic(members)
        p, least = (float((found >= high - 1e-9).mean()) for high in (observed, found.max()))
        return observed, p, least, "all permutations"
    high = sum(
        int((statistic(orders == 0 if two else orders) >= observed - 1e-9).sum())
        for orders in shuffle_in_blocks(given, n_permutations, seed=seed)
    )
    least = max(1.0 / (1.0 + n_permutations), _share_of_most_separate(sizes))
    return observed, (1.0 + high) / (1.0 + n_permutations), least, f"{n_permutations} permutations"


def _share_of_most_separate(sizes: list[int]) -> float:
    """Return about how many of all arrangements keep every group together, in any order.

    On a circle: N rotations of each of (groups - 1)! orders.
    """
    log_all = math.lgamma(sum(sizes) + 1) - sum(math.lgamma(size + 1) for size in sizes)
    return math.exp(math.log(sum(sizes)) + math.lgamma(len(sizes)) - log_all)
