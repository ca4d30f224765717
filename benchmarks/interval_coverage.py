"""Coverage of intervals and false positives of tests that count animals.

    python benchmarks/interval_coverage.py [--quick] [--studies 2000] [--animals 5] [--part phase]

Studies are drawn from a known truth: animals differ, strides differ within animals. Printed for
every setting: how often the 95 % interval holds the truth, and how often each default test says
p <= 0.05 where nothing is there (to be at most 6 %), beside the naive way that takes strides to be
independent. With 2000 studies the standard error of a coverage of 95 % is 0.5 %.

``phase``: the mean phase of 3, 5 and 10 animals with 3 to 30 strides each, von Mises and a mixture
(30 % of the animals a quarter of a cycle later). Every study has an interval. Beside the coverage
of all stand the share of studies in which any phase is possible, so that the interval is its
longest, 95 % of the cycle; the coverage of the others; and the median length. ``kinds`` is the
coverage of the studies of a mixture that hold animals of both kinds: where all are of one kind,
nothing tells of the other.
``pattern``: how often phases of pairs of legs are given which name, and whether the interval of r
holds the truth. ``speed``: how often a shift of phase with speed within animals is found.

Found with 2000 studies. Mean phase: 94.5 to 96.9 % for 3, 5 and 10 von Mises animals with a
concentration of 1 and more, 91.6 to 92.2 % at 0.3 (strides as independent: 22 to 69 %). Any phase
is possible in 64 % of the studies of 3 animals at a concentration of 1, 17 % at 3, none at 10; of
5 animals in 44, 2 and 0 %; of 10 in 20, 0 and 0 %. The mixture: 93.9 to 96.5 % for 10 animals;
for 5, 93.5 to 96.2 % up to a concentration of 5, 89.8 at 10 and 84.0 at 50; for 3, 93.4 to 95.5 up
to 5, 89.4 at 10 and 77.2 at 50: there a third of the studies hold animals of one kind only, and
of the others 99 to 100 % hold. Called random though r is 0.5: 2 to 3 % of 400 studies of 2 to 30
animals; 0.7: at most 1.2 %. The interval of r holds it in 91 to 99 % of 200 von Mises studies.
A shift of 0.2 cycle within each of six animals is found in 99 to 100 %, none in 4.2 to 4.6 %.
Duty factor 93.5 to 95.0 % though skewed between animals (naive 42-93), slope of phase on speed
94.7 to 95.7 %. False positives of the default tests at most 6.0 % (naive 9-77). Hotelling's F as
in the books has 10-11 % where animals are regular and differ at random, and so is not the default.
Set OMP_NUM_THREADS=1: the matrices are small.
"""

from __future__ import annotations

import argparse
import cmath
import itertools
import math
import sys
import time
from collections.abc import Callable, Iterator

import numpy as np
import pandas as pd

from pawnb.gait.analysis.phase_patterns import ANTI_PHASE, NOT_DETERMINED, RANDOM, name_pattern
from pawnb.gait.circular import mean_interval, mean_vector
from pawnb.gait.circular.correlation import angular_linear
from pawnb.gait.circular.groups import watson_u2_test, watson_williams_test, wheeler_watson_test
from pawnb.gait.circular.second_order import animal_vectors, hotelling_test, moore_test
from pawnb.gait.circular.tests import hodges_ajne_test, mean_test, rayleigh_test, v_test
from pawnb.gait.groups import compare_groups
from pawnb.gait.groups.animals import mean_of_animals, slope_of_animals, slopes_by_animal
from pawnb.gait.groups.bootstrap import bootstrap_units
from pawnb.gait.inference.animal_phases import interval_of_phases
from pawnb.gait.inference.circular_length import kappa_of_length, length_interval
from pawnb.gait.regression.mixed import fit_mixed

CIRCLE = 2.0 * np.pi
# concentration between animals; of strides within an animal it is 10 (r 0.95)
BETWEEN = (0.3, 1.0, 2.0, 3.0, 5.0, 10.0, 50.0)
WITHIN = 10.0
LATER, SHARE_LATER = 0.25, 0.3  # the mixture: cycles, and share of the animals
# standard deviation between animals over that within
RATIOS = (0.0, 0.2, 0.5, 1.0, 3.0)


class Size:
    """Number of animals and of strides of each."""

    def __init__(self, animals: int, strides: int) -> None:
        self.k, self.n = animals, strides
        self.who = np.repeat(np.arange(animals), strides)

    def phases(self, rng: np.random.Generator, between: float, within: float) -> np.ndarray:
        """Draw phases about half a cycle; a concentration of 0 between animals is random."""
        own = rng.vonmises(0.0, between, self.k) if math.isfinite(between) else np.zeros(self.k)
        turns = own[self.who] + rng.vonmises(0.0, within, self.k * self.n)
        return np.mod(0.5 + turns / CIRCLE, 1.0)


def uneven_study(
    rng: np.random.Generator, k: int, between: float, *, mixed: bool
) -> tuple[np.ndarray, np.ndarray, int]:
    """Draw phases of k animals of 3 to 30 strides about half a cycle; and how many are later."""
    who = np.repeat(np.arange(k), rng.integers(3, 31, k))
    later = (rng.random(k) < SHARE_LATER) & mixed
    own = 0.5 + LATER * later + rng.vonmises(0.0, between, k) / CIRCLE
    return np.mod(own[who] + rng.vonmises(0.0, WITHIN, len(who)) / CIRCLE, 1.0), who, later.sum()


def phase_coverage(studies: int, rng: np.random.Generator) -> None:
    """Print how often intervals of a mean phase hold it."""
    print("mean phase: 3 to 30 strides an animal, concentration within 10")
    print("                    all   any phase   others   median  both    strides as")
    print("animals  between  holds    possible    hold    length  kinds  independent")
    for mixed in (False, True):
        print("mixture of two kinds" if mixed else "von Mises")
        part = SHARE_LATER if mixed else 0.0
        truth = 0.5 + cmath.phase(1.0 - part + part * cmath.exp(1j * CIRCLE * LATER)) / CIRCLE
        for k, between in itertools.product((3, 5, 10), BETWEEN):
            rows = np.array(
                [_one_interval(rng, k, between, truth, mixed=mixed) for _ in range(studies)]
            )
            held, longest, length, both, naive = rows.T
            others = held[longest == 0]
            kinds = f"{100 * held[both == 1].mean():6.1f}" if mixed else "      "
            print(
                f"{k:7d} {between:8g} {100 * held.mean():6.1f} {100 * longest.mean():11.1f} "
                f"{100 * others.mean() if len(others) else math.nan:7.1f} "
                f"{np.median(length):9.3f} {kinds} {100 * naive.mean():12.1f}",
                flush=True,
            )


def _one_interval(
    rng: np.random.Generator, k: int, between: float, truth: float, *, mixed: bool
) -> tuple[bool, bool, float, bool, bool]:
    """Return of one study: held, longest possible, length, both kinds, held by the naive one."""
    phases, who, later = uneven_study(rng, k, between, mixed=mixed)
    ends = interval_of_phases(animal_vectors(phases, who.tolist()).means)
    naive = mean_interval(*mean_vector(phases))
    (held, length), (naively, _) = (_covers(low, high, truth) for low, high in (ends, naive))
    return held, length >= 0.95 - 1e-9, length, 0 < later < k, naively


def _covers(low: float, high: float, truth: float) -> tuple[bool, float]:
    """Return whether an interval of phases holds the truth, and its length."""
    length = 1.0 if high - low == 1.0 else (high - low) % 1.0
    return (truth - low) % 1.0 <= length, length


def patterns(studies: int, rng: np.random.Generator) -> None:
    """Print the names that pairs of legs are given, and coverage of the interval of r."""
    print(f"patterns of {studies} studies, true mean 0.5; and the interval of r")
    print("animals  true r                  random  not det.  anti-phase  other   holds")
    kappas = {0.0: 1e-9} | {r: kappa_of_length(r) for r in (0.3, 0.5, 0.7, 0.9, 0.99)}
    for k, (r, kappa) in itertools.product((2, 3, 5, 10, 30), kappas.items()):
        _print_names(k, f"{r:g}", r, 0.5 + rng.vonmises(0.0, kappa, (studies, k)) / CIRCLE)
    for k in (3, 5, 10, 30):  # a third each of a cycle apart; r 0.5 as of von Mises above
        kinds = (rng.random((studies, k)) < 0.5) / 3.0 + 1.0 / 3.0
        _print_names(k, "0.5, of two kinds", 0.5, kinds + rng.normal(0.0, 1e-6, kinds.shape))


def _print_names(k: int, label: str, r: float, draws: np.ndarray) -> None:
    """Print one line of :func:`patterns`."""
    vectors = [mean_vector(np.mod(one, 1.0)) for one in draws]
    names = [name_pattern(one.mean, one.r, k) for one in vectors]
    counts = [names.count(name) for name in (RANDOM, NOT_DETERMINED, ANTI_PHASE)]
    ends = [length_interval(one.r, k) for one in vectors[:200]]  # slow
    held = np.mean([low <= r <= high for low, high in ends])
    shares = [100.0 * n / len(names) for n in (*counts, len(names) - sum(counts))]
    print(f"{k:7d}  {label:20s}" + " ".join(f"{one:9.1f}" for one in (*shares, 100.0 * held)),
          flush=True)  # fmt: skip


def speed_studies(studies: int, rng: np.random.Generator) -> None:
    """Print how often phase_speed_table and means of animals find a shift of phase with speed."""
    print("phase against speed, six animals at three speeds of 8 strides: p <= 0.05")
    print("speeds         shift within   within animals   means of animals")
    for own, shift in itertools.product((False, True), (0.2, 0.1, 0.0)):
        low = np.zeros(2)
        for _ in range(studies):
            x, y, who = _belt_study(rng, own=own, shift=shift)
            low[0] += slope_of_animals(x, y, who, circular=True).p <= 0.05
            low[1] += angular_linear(y, x, animals=who, n_permutations=199).p_permutation <= 0.05
        within, means = 100.0 * low / studies
        print(f"{'of their own' if own else 'equal':14s} {shift:12g} {within:16.1f} {means:18.1f}",
              flush=True)  # fmt: skip


def _belt_study(
    rng: np.random.Generator, *, own: bool, shift: float
) -> tuple[np.ndarray, np.ndarray, list[int]]:
    """Draw speeds and phases; ``own``: each animal has a range of speeds of its own."""
    start = rng.uniform(50.0, 250.0, (6, 1)) if own else np.full((6, 1), 100.0)
    span = rng.uniform(40.0, 250.0, (6, 1)) if own else np.full((6, 1), 200.0)
    place = np.repeat(np.tile([0.0, 0.5, 1.0], (6, 1)), 8, axis=1)
    trial = np.repeat(rng.normal(0.0, 0.02, (6, 3)), 8, axis=1)  # trials of one animal differ
    y = rng.random((6, 1)) + shift * place + trial + rng.normal(0.0, 0.05, place.shape)
    x = start + span * place + rng.normal(0.0, 2.0, place.shape)
    return x.ravel(), np.mod(y, 1.0).ravel(), np.repeat(np.arange(6), 24).tolist()


def duty(size: Size, rng: np.random.Generator, ratio: float) -> np.ndarray:
    """Draw duty factors about 0.6; skewed between animals, normal within."""
    own = rng.gamma(4.0, 1.0, size.k) / 2.0 - 2.0
    return 0.6 + 0.02 * (ratio * own[size.who] + rng.normal(0.0, 1.0, size.k * size.n))


def linear_coverage(size: Size, studies: int, rng: np.random.Generator) -> None:
    print("duty factor (skewed between animals) and slope of phase on speed")
    print("ratio   duty  boot  naive  slope  boot")
    for ratio in RATIOS:
        hits = np.zeros(5)
        for _ in range(studies):
            values = duty(size, rng, ratio)
            found = mean_of_animals(values, size.who.tolist())
            units = values.reshape(size.k, size.n).mean(axis=1)
            boot = bootstrap_units(units)
            half = 1.96 * values.std(ddof=1) / math.sqrt(len(values))
            speed, phases = steered(size, rng, ratio, slope=0.004)
            slope = slope_of_animals(speed, phases, size.who.tolist(), circular=True)
            slopes, _ = slopes_by_animal(speed, phases, size.who.tolist(), circular=True)
            drawn = bootstrap_units(slopes)
            hits += [
                found.low <= 0.6 <= found.high,
                boot.low <= 0.6 <= boot.high,
                abs(values.mean() - 0.6) <= half,
                slope.low <= 0.004 <= slope.high,
                drawn.low <= 0.004 <= drawn.high,
            ]
        print(f"{ratio:5g} " + " ".join(f"{v:6.1f}" for v in 100.0 * hits / studies), flush=True)


def steered(
    size: Size, rng: np.random.Generator, ratio: float, *, slope: float
) -> tuple[np.ndarray, np.ndarray]:
    """Draw speeds and phases that depend on them; animals differ in level, range and slope."""
    spread = np.exp(rng.normal(0.0, 0.3, size.k))
    inside = spread[size.who] * rng.normal(0.0, 4.0, size.k * size.n)
    own = slope + 0.004 * ratio * rng.normal(0.0, 1.0, size.k)
    phases = rng.random(size.k)[size.who] + own[size.who] * inside
    phases = phases + rng.normal(0.0, 0.03, size.k * size.n)
    return rng.normal(25.0, 5.0, size.k)[size.who] + inside, np.mod(phases, 1.0)


def random_phase_tests(size: Size, rng: np.random.Generator, within: float) -> dict[str, float]:
    """Return p of each test of randomness where animals' phases are random."""
    phases = size.phases(rng, 0.0, within)
    who = size.who.tolist()
    vectors = animal_vectors(phases, who)
    return {
        "Rayleigh": rayleigh_test(phases, animals=who).p,
        "Moore": moore_test(vectors.means, vectors.lengths).p,
        "Hotelling": hotelling_test(vectors.means, vectors.lengths, n_rotations=999).p,
        "Hotelling F": hotelling_test(vectors.means, vectors.lengths, method="f").p,
        "V": v_test(phases, expected=0.5, animals=who).p,
        "Hodges-Ajne": hodges_ajne_test(phases, animals=who).p,
        "naive Rayleigh": rayleigh_test(phases, method="zar").p,
    }


def no_effect_tests(
    size: Size, rng: np.random.Generator, setting: tuple[float, float]
) -> dict[str, float]:
    """Return p of each test of a mean, of two groups and of a slope where there is no effect."""
    between, within = setting
    both = Size(2 * size.k, size.n)
    phases = both.phases(rng, between, within)
    who = both.who.tolist()
    groups = np.where(both.who < size.k, "a", "b").tolist()
    ratio = 1.0 / math.sqrt(max(between, 1e-9) / within) if math.isfinite(between) else 0.0
    values = duty(both, rng, ratio)
    table = pd.DataFrame({"animal": who, "group": groups, "phase": phases, "duty": values})
    table["speed"] = rng.normal(25.0, 5.0, both.k)[both.who] + rng.normal(0.0, 3.0, len(who))
    mirrored = np.where(np.arange(len(who)) % size.n < size.n // 2, "x", "y")
    one = table[table["group"] == "a"]
    circular = compare_groups(table, ["phase"], circular=True).iloc[0]
    linear = compare_groups(table, ["duty"]).iloc[0]
    conditions = one.assign(group=mirrored[: len(one)])
    paired = compare_groups(conditions, ["phase"], circular=True, paired=True).iloc[0]
    slope = slope_of_animals(
        one["speed"].to_numpy(), one["phase"].to_numpy(), one["animal"].tolist(), circular=True
    )
    by_animal = table.groupby("animal")["speed"].mean()[both.who].to_numpy()
    options = {"animals": who, "n_permutations": 999}
    return {
        "mean phase = expected": mean_test(
            one["phase"].to_numpy(), expected=0.5, animals=one["animal"].tolist()
        ).p,
        "  naive": mean_test(one["phase"].to_numpy(), expected=0.5).p,
        "phase of 2 groups": circular["p"],
        "  naive t": circular["p_strides"],
        "phase of 2 conditions": paired["p"],
        "Watson-Williams": watson_williams_test(phases, groups, animals=who).p,
        "Watson U2": watson_u2_test(phases, groups, **options).p,
        "Wheeler-Watson": wheeler_watson_test(phases, groups, **options).p,
        "duty of 2 groups": linear["p"],
        "  naive t ": linear["p_strides"],
        "slope of phase": slope.p,
        "angular-linear": angular_linear(phases, by_animal, **options).p_permutation,
        "  naive chi2": angular_linear(phases, by_animal, n_permutations=99).p,
    }


def mixed_tests(size: Size, rng: np.random.Generator, ratio: float) -> dict[str, float]:
    """Return p of a mixed model's terms where neither group nor speed has an effect."""
    both = Size(2 * size.k, size.n)
    trial = np.arange(both.k * both.n) % both.n // max(1, both.n // 2)
    table = pd.DataFrame({"animal": both.who, "trial": trial})
    table["group"] = np.where(both.who < size.k, "a", "b")
    table["speed"] = rng.normal(0.0, 1.0, both.k)[both.who] + rng.normal(0.0, 1.0, len(table))
    own = ratio * rng.normal(0.0, 1.0, both.k)
    slopes = ratio / 2.0 * rng.normal(0.0, 1.0, both.k)
    trials = ratio / 4.0 * rng.normal(0.0, 1.0, (both.k, int(trial.max()) + 1))
    table["y"] = own[both.who] + slopes[both.who] * table["speed"] + trials[both.who, trial]
    table["y"] += rng.normal(0.0, 1.0, len(table))
    full = fit_mixed(table, "y", ["group", "speed"]).terms.set_index("term")
    few = table[table["group"] == "a"]
    one = fit_mixed(few, "y", ["speed"]).terms.set_index("term")
    mean = fit_mixed(few, "y").terms.set_index("term")
    return {
        "mixed: group": full.loc["group: b - a", "p"],
        "  naive": full.loc["group: b - a", "p_strides"],
        "mixed: slope, all animals": full.loc["speed", "p"],
        "mixed: slope, half the animals": one.loc["speed", "p"],
        "  naive ": one.loc["speed", "p_strides"],
        "mixed: mean, half the animals": mean.loc["intercept", "p"],
        "  naive  ": mean.loc["intercept", "p_strides"],
    }


def false_positives(
    draw: Callable[[], dict[str, float]], studies: int, title: str
) -> Iterator[tuple[str, float]]:
    """Count how often each test says p <= 0.05, and print it."""
    low: dict[str, int] = {}
    for _ in range(studies):
        for name, p in draw().items():
            low[name] = low.get(name, 0) + bool(p <= 0.05)
    print(title)
    for name, count in low.items():
        print(f"  {name:32s} {100.0 * count / studies:5.1f} %", flush=True)
        yield name, count / studies


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--studies", type=int)
    parser.add_argument("--quick", action="store_true", help="200 studies instead of 2000")
    parser.add_argument("--animals", type=int, default=5)
    parser.add_argument("--strides", type=int, default=10)
    parts = ["phase", "pattern", "speed", "linear", "random", "effects", "mixed"]
    parser.add_argument("--part", choices=parts)
    asked = parser.parse_args()
    if asked.studies is None:
        asked.studies = 200 if asked.quick else 2000
    size, rng = Size(asked.animals, asked.strides), np.random.default_rng(20)
    began = time.perf_counter()
    print(f"{asked.studies} studies of {size.k} animals of {size.n} strides (a group)")
    if asked.part in (None, "phase"):
        phase_coverage(asked.studies, rng)
    if asked.part in (None, "pattern"):
        patterns(max(asked.studies // 5, 100), rng)  # slow
    if asked.part in (None, "speed"):
        speed_studies(asked.studies, rng)
    if asked.part in (None, "linear"):
        linear_coverage(size, asked.studies, rng)
    if asked.part in (None, "random"):
        for within in (50.0, 3.0, 0.5):
            title = f"false positives, animals' phases random, concentration within {within:g}"
            list(
                false_positives(
                    lambda w=within: random_phase_tests(size, rng, w), asked.studies, title
                )
            )
    if asked.part in (None, "effects"):
        for setting in ((200.0, 10.0), (20.0, 50.0), (4.0, 3.0)):
            title = f"false positives, no effect, concentration between and within {setting}"
            list(
                false_positives(
                    lambda s=setting: no_effect_tests(size, rng, s), asked.studies, title
                )
            )
    if asked.part in (None, "mixed"):
        for ratio in (0.0, 0.5, 2.0):
            title = f"false positives, mixed models, animals differ by {ratio:g} SD of strides"
            list(false_positives(lambda r=ratio: mixed_tests(size, rng, r), asked.studies, title))
    print(f"{time.perf_counter() - began:.0f} s", file=sys.stderr)


if __name__ == "__main__":
    main()
