"""Whether curves over the stride differ between groups: cluster permutation tests over animals.

A curve has a hundred points, and a hundred tests find something by chance. Maris & Oostenveld
(2007, J. Neurosci. Methods 164: 177) ask instead how large a stretch of neighbouring differences
becomes if the names of the groups mean nothing.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pandas as pd

from pawnb.arrays import FloatArray, IntArray
from pawnb.errors import InputError
from pawnb.gait.inference.leg_permutation import PERMUTATION_ROUNDING
from pawnb.gait.inference.linear_fit import t_quantile
from pawnb.gait.inference.permutations import bound_note
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments

CLUSTER_COLUMNS = (
    "leg", "group_a", "group_b", "cluster", "start_percent", "stop_percent", "mean_difference",
    "mass", "p", "p_adjusted", "n_animals_a", "n_animals_b", "method", "signal", "unit", "note",
)  # fmt: skip
_WHOLE_CYCLE = 100.0
_MOST_FLIPS = 10_000
_CURVES_AT_ONCE = 500
_TWO_OR_MORE = "expected two or more in each: there is no test of one animal"


class _Curves(NamedTuple):
    """Mean curves of the animals of two groups; rows are animals, then legs and points."""

    a: np.ndarray
    b: np.ndarray
    note: str
    counted: str

    @property
    def is_enough(self) -> bool:
        """Whether there are two animals or more in each group: there is no test of one."""
        return min(len(self.a), len(self.b)) >= 2


@checked_arguments
def compare_cycles(
    cycles: pd.DataFrame,
    *,
    group: str = "group",
    value: str = "value",
    paired: bool = False,
    threshold_p: float = 0.05,
    n_permutations: int = 9_999,
    seed: int = 0,
) -> pd.DataFrame:
    """Find the stretches of the stride in which curves of two groups differ.

    Each animal is one curve a leg: the mean of its strides. At every point a t is computed (of two
    samples with one variance, or of the differences of pairs); neighbouring points whose t is
    beyond ``threshold_p`` on one side are a cluster, and its mass is the sum of their t. The names
    of the groups are then exchanged between whole animals (of pairs: the sign of an animal's
    difference), and p of a cluster is the share of arrangements, that of the data among them, whose
    heaviest cluster in any leg and anywhere in the stride is as heavy. It so counts the points and
    the legs. The stride is a ring: a cluster may go on from 100 to 0 percent.

    What is claimed is that the curves differ; where a cluster begins and ends is not tested
    (Sassenhagen & Draschkow 2019, Psychophysiology 56: e13335).

    Parameters
    ----------
    cycles : pandas.DataFrame
        From :func:`pawnb.gait.cycles.cut_cycles`, with a column of groups.
    group : str
        Column of groups, or of conditions.
    value : str
        Column of the curve: ``value``, ``velocity`` or ``acceleration``.
    paired : bool
        Whether the groups are conditions of the same animals.
    threshold_p : float
        p (two-sided) beyond which a point belongs to a cluster. It decides what is found, short and
        high or long and low differences, but not how often something is found by chance.
    n_permutations, seed : int
        Number and seed of random arrangements, used where there are more than 10,000.

    Returns
    -------
    pandas.DataFrame
        ``CLUSTER_COLUMNS``, a row a cluster, the heaviest first, and a row with ``cluster`` 0 for
        two groups that have none. ``mean_difference`` is b less a over the cluster, in ``unit``;
        ``stop_percent`` is below ``start_percent`` where a cluster goes on beyond 100. Of three
        groups and more each two are compared, and ``p_adjusted`` counts the comparisons; two of
        which one has fewer than two animals have no p, and the note says so.

    Raises
    ------
    InputError
        If a column is missing, there are fewer than two groups, an animal is in both groups of an
        unpaired comparison, no two groups have two animals each, or an option makes no sense.

    Examples
    --------
    >>> angles = [one for one in gait.signals if one.signal == "leg angle"]
    >>> cycles = pawnb.gait.cycles.cut_cycles(angles, gait.strides)
    >>> cycles["group"] = np.where(cycles["animal"] < "spider-03", "young", "old")
    >>> table = pawnb.gait.cycles.tests.compare_cycles(cycles)
    """
    needed = ("animal", "trial", "leg", "stride", "percent", value, group, "signal", "unit")
    check_columns(cycles, needed, where="cycles")
    if not 0.0 < threshold_p < 1.0 or n_permutations < 1:
        raise InputError(
            f"threshold_p is {threshold_p}, n_permutations {n_permutations}; expected a share "
            "between 0 and 1, and at least one permutation."
        )
    means = _mean_curves(cycles, group=group, value=value)
    names = list(dict.fromkeys(cycles[group].dropna().astype(str)))
    if len(names) < 2:
        raise InputError(f"column {group!r} holds {names}; expected two groups or more.")
    about = {name: cycles[name].iloc[0] for name in ("signal", "unit")}
    curves = {
        (a, b): _two_groups(means, a, b, paired=paired) for a, b in itertools.combinations(names, 2)
    }
    n_tests = sum(own.is_enough for own in curves.values())
    if not n_tests:
        raise InputError(f"{next(iter(curves.values())).counted}; {_TWO_OR_MORE}.")
    parts = []
    for (a, b), own in curves.items():
        found = _not_tested(own)
        if own.is_enough:
            found = _test(
                own, means, paired=paired, threshold_p=threshold_p,
                n_permutations=n_permutations, seed=seed,
            )  # fmt: skip
        found["p_adjusted"] = np.minimum(found["p"] * n_tests, 1.0)
        parts.append(found.assign(group_a=a, group_b=b, **about))
    return pd.concat(parts, ignore_index=True)[list(CLUSTER_COLUMNS)]


def _mean_curves(cycles: pd.DataFrame, *, group: str, value: str) -> pd.DataFrame:
    """Return the mean curve of each animal in each group: columns are legs and percents."""
    own = cycles[(cycles["percent"] < _WHOLE_CYCLE) & cycles[group].notna()]
    keys = ["animal", "trial", "leg", "stride"]
    broken = own[value].isna().groupby([own[key] for key in keys]).transform("any")
    known = own.assign(**{group: own[group].astype(str)})[~broken]
    if known.empty:
        raise InputError("cycles: no stride has a whole curve; expected at least one.")
    table: pd.DataFrame = known.pivot_table(
        index=[group, "animal"], columns=["leg", "percent"], values=value, aggfunc="mean"
    )
    return table


def _two_groups(means: pd.DataFrame, a: str, b: str, *, paired: bool) -> _Curves:
    """Return the curves of two groups, of the animals that have every leg."""
    whole = means.dropna()
    left = len(means.loc[means.index.isin([a, b], level=0)]) - len(
        whole.loc[whole.index.isin([a, b], level=0)]
    )
    said = f"{left} animal{'s' * (left != 1)} without whole curves of every leg left out"
    notes = [said] if left else []
    one, two = (whole[whole.index.get_level_values(0) == g].droplevel(0) for g in (a, b))
    shared = one.index.intersection(two.index)
    if paired:
        alone = len(one.index.union(two.index)) - len(shared)
        said = f"{alone} animal{'s' * (alone != 1)} in one condition only left out"
        notes += [said] if alone else []
        one, two = one.loc[shared], two.loc[shared]
    elif len(shared):
        raise InputError(
            f"animal {shared[0]} is in more than one group; say paired=True where the groups are "
            "conditions of the same animals."
        )
    legs = means.columns.get_level_values(0).unique()
    shape = (-1, len(legs), means.shape[1] // len(legs))
    counted = f"animals with curves: {len(one)} of {a}, {len(two)} of {b}"
    first, second = (own.to_numpy().reshape(shape) for own in (one, two))
    return _Curves(first, second, "; ".join(notes), counted)


def _not_tested(curves: _Curves) -> pd.DataFrame:
    """Return the row of two groups that cannot be tested: it has no p."""
    notes = "; ".join(filter(None, (f"{curves.counted}: not compared", curves.note)))
    counts = {"n_animals_a": len(curves.a), "n_animals_b": len(curves.b)}
    row = {"leg": "", "cluster": 0, "p": math.nan, **counts, "method": "none", "note": notes}
    return pd.DataFrame([row]).reindex(columns=list(CLUSTER_COLUMNS))


def _test(
    curves: _Curves, means: pd.DataFrame, *, paired: bool, threshold_p: float,
    n_permutations: int, seed: int,
) -> pd.DataFrame:  # fmt: skip
    """Find the clusters of two groups and their p."""
    n_a, n_b = len(curves.a), len(curves.b)
    limit = t_quantile(1.0 - threshold_p, (n_a - 1 if paired else n_a + n_b - 2))
    joined = curves.b - curves.a if paired else np.concatenate((curves.a, curves.b))
    statistic = _paired_t if paired else _two_sample_t
    given = np.ones(n_a) if paired else np.arange(n_a + n_b) >= n_a
    t = statistic(joined, given[None].astype(float))[0]
    rows_of, method = _arrangements(n_a, n_b, paired=paired, count=n_permutations, seed=seed)
    blocks = (
        rows_of[done : done + _CURVES_AT_ONCE] for done in range(0, len(rows_of), _CURVES_AT_ONCE)
    )
    masses = np.concatenate([_heaviest(statistic(joined, block), limit) for block in blocks])
    smallest = _smallest_p(n_a, n_b, paired=paired, n=len(masses))
    note = "; ".join(filter(None, (curves.note, bound_note(smallest, _counted(n_a, n_b, paired)))))
    legs = means.columns.get_level_values(0).unique()
    percents = means.columns.get_level_values(1).to_numpy(dtype=float)[: t.shape[1]]
    difference = curves.b.mean(axis=0) - curves.a.mean(axis=0)
    rows = []
    for k, leg in enumerate(legs):
        for inside in _clusters(t[k], limit):
            mass = float(t[k][inside].sum())
            p = float((masses >= abs(mass) * (1.0 - PERMUTATION_ROUNDING)).mean())
            rows.append({"leg": leg, "start_percent": percents[inside[0]],
                         "stop_percent": percents[inside[-1]], "mass": mass, "p": p,
                         "mean_difference": float(difference[k][inside].mean())})  # fmt: skip
    rows.sort(key=lambda row: -abs(row["mass"]))
    rows = [{**row, "cluster": i + 1} for i, row in enumerate(rows)]
    table = pd.DataFrame(rows or [{"leg": "", "cluster": 0}])
    table = table.reindex(columns=list(CLUSTER_COLUMNS))
    if not rows:
        table["p"] = 1.0
    return table.assign(n_animals_a=n_a, n_animals_b=n_b, method=method, note=note)


def _counted(n_a: int, n_b: int, paired: bool) -> str:
    """Say what was counted."""
    return f"{n_a} animals" if paired else f"{n_a} and {n_b} animals"


def _smallest_p(n_a: int, n_b: int, *, paired: bool, n: int) -> float:
    """Return the least p: the data and their mirror image are as heavy, where that is a choice."""
    mirrored = paired or n_a == n_b
    return (1.0 + mirrored) / n


def _paired_t(differences: FloatArray, signs: FloatArray) -> FloatArray:
    """Return t of the mean difference for rows of signs, shape (rows, legs, points)."""
    n = len(differences)
    mean = np.tensordot(signs, differences, axes=1) / n
    squares = (differences**2).sum(axis=0)
    variance = np.maximum(squares - n * mean**2, PERMUTATION_ROUNDING * squares) / (n - 1)
    return _ratio(mean, variance / n)


def _two_sample_t(values: FloatArray, second: FloatArray) -> FloatArray:
    """Return t of two samples with one variance for rows that say who is in the second."""
    values = values - values.mean(axis=0)  # no digits are lost in the squares
    n_b = second.sum(axis=1)[:, None, None]
    n_a = len(values) - n_b
    sum_b = np.tensordot(second, values, axes=1)
    mean_a, mean_b = -sum_b / n_a, sum_b / n_b
    squares = (values**2).sum(axis=0)
    within = np.maximum(squares - n_a * mean_a**2 - n_b * mean_b**2, PERMUTATION_ROUNDING * squares)
    return _ratio(mean_b - mean_a, within / (len(values) - 2) * (1.0 / n_a + 1.0 / n_b))


def _ratio(difference: FloatArray, variance: FloatArray) -> FloatArray:
    """Return a difference over its standard error; 0 where all curves are the same."""
    error = np.sqrt(variance)
    return np.divide(difference, error, out=np.zeros_like(difference), where=error > 0.0)


def _heaviest(t: FloatArray, limit: float) -> FloatArray:
    """Return the mass of the heaviest cluster of each row, shape (rows, legs, points) to (rows,).

    One goes twice around the ring, so that a cluster that begins near 100 percent is whole.
    """
    most = np.zeros(t.shape[:2])
    for side in (t, -t):
        inside = side > limit
        weight = np.where(inside, side, 0.0)
        run = np.zeros(t.shape[:2])
        for k in (*range(t.shape[2]), *range(t.shape[2])):
            run = np.where(inside[..., k], run + weight[..., k], 0.0)
            most = np.maximum(most, run)
        everywhere = inside.all(axis=2)
        most = np.where(everywhere, weight.sum(axis=2), most)
    heaviest: np.ndarray = most.max(axis=1)
    return heaviest


def _clusters(t: FloatArray, limit: float) -> Iterator[IntArray]:
    """Yield the points of each cluster on the ring, in the order in which they are passed."""
    for side in (t, -t):
        inside = side > limit
        if inside.all():
            yield np.arange(len(t))
            continue
        first = int(np.flatnonzero(~inside)[0])
        order = (first + np.arange(len(t))) % len(t)
        ends = np.flatnonzero(np.diff(np.r_[0, inside[order].astype(int), 0]))
        for start, stop in ends.reshape(-1, 2):
            yield order[start:stop]


def _arrangements(
    n_a: int, n_b: int, *, paired: bool, count: int, seed: int
) -> tuple[FloatArray, str]:
    """Return the arrangements, a row each and that of the data among them; and their number.

    Signs of the animals' differences where they are paired, else 1 for who is in the second group.
    """
    number = 2**n_a if paired else math.comb(n_a + n_b, n_b)
    if number <= _MOST_FLIPS:
        said = f"all {number} arrangements"
        if paired:
            return np.array(list(itertools.product((1.0, -1.0), repeat=n_a))), said
        chosen = np.array(list(itertools.combinations(range(n_a + n_b), n_b)))
        rows = np.zeros((number, n_a + n_b))
        np.put_along_axis(rows, chosen, 1.0, axis=1)
        return rows, said
    rng = np.random.default_rng(seed)
    if paired:
        data, drawn = np.ones(n_a), rng.choice((1.0, -1.0), (count, n_a))
    else:
        data = (np.arange(n_a + n_b) >= n_a).astype(float)
        drawn = rng.permuted(np.tile(data, (count, 1)), axis=1)
    return np.concatenate((data[None], drawn)), f"{count} random arrangements"
