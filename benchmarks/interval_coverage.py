"""Coverage of intervals and false positives of tests that count animals.

    python benchmarks/interval_coverage.py [--studies 2000] [--animals 5] [--strides 10]

Studies are drawn from a known truth: animals differ, strides differ within animals. Printed
for every setting: how often the 95 % interval holds the truth (to be 93-97 %), and how often
each default test says p <= 0.05 where nothing is there (to be at most 6 %), beside the
naive way that takes strides to be independent. With 2000 studies the standard error of a
coverage of 95 % is 0.5 %. An interval that is left blank because any mean phase is possible
is counted as holding the truth; how many there were is printed.

Found with 2000 studies of 5 animals of 10 strides: mean phase 94.5-97.2 % in 28 settings, blank
in none where animals are alike to 86 % where they hardly share a direction (bootstrap 87.8-95.5,
plain percentiles 73.2-85.3, strides as independent 40-97); duty factor
93.5-95.0 % though skewed between animals (naive 42-93), slope of phase on speed 94.7-95.7 %.
False positives of the default tests at most 6.0 % (naive 5-77). Hotelling's F as in the books
has 10-11 % where animals are regular and differ at random, and so is not the default.
Set OMP_NUM_THREADS=1: the matrices are small.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections.abc import Callable, Iterator

import numpy as np
import pandas as pd

from pawnb.gait.animal_phases import interval_of_phases
from pawnb.gait.animals import mean_of_animals, slope_of_animals, slopes_by_animal
from pawnb.gait.bootstrap import bootstrap_units
from pawnb.gait.circular import mean_interval, mean_vector
from pawnb.gait.circular_correlation import angular_linear
from pawnb.gait.circular_groups import watson_u2_test, watson_williams_test, wheeler_watson_test
from pawnb.gait.circular_tests import hodges_ajne_test, mean_test, rayleigh_test, v_test
from pawnb.gait.groups import compare_groups
from pawnb.gait.mixed import fit_mixed
from pawnb.gait.second_order import animal_vectors, hotelling_test, moore_test

CIRCLE = 2.0 * np.pi
# concentration between animals, and of strides within: r is 1.00 to 0.24
PHASES = [
    (b, w) for b in (math.inf, 200.0, 20.0, 4.0, 2.0, 1.0, 0.5) for w in (50.0, 10.0, 3.0, 1.0)
]
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


def covers(low: float, high: float, truth: float) -> tuple[bool, bool]:
    """Return whether an interval of phases holds the truth, and whether it is blank."""
    blank = math.isnan(low)
    return blank or (truth - low) % 1.0 <= (high - low) % 1.0, blank


def phase_coverage(size: Size, studies: int, rng: np.random.Generator) -> None:
    print("mean phase: t of sines | bootstrap | plain percentiles | strides as independent")
    print("between within     t  blank   boot  plain  naive")
    for between, within in PHASES:
        hits, blank = np.zeros(4), 0
        for _ in range(studies):
            phases = size.phases(rng, between, within)
            means = animal_vectors(phases, size.who.tolist()).means
            ends = [interval_of_phases(means)]
            for corrected in (True, False):
                found = bootstrap_units(means, circular=True, corrected=corrected)
                ends.append((found.low, found.high))
            ends.append(mean_interval(*mean_vector(phases)))
            held = [covers(low, high, 0.5) for low, high in ends]
            hits += [h for h, _ in held]
            blank += held[0][1]
        t, boot, plain, naive = 100.0 * hits / studies
        print(
            f"{between:7g} {within:6g} {t:5.1f} {100 * blank / studies:6.1f} {boot:6.1f} "
            f"{plain:6.1f} {naive:6.1f}",
            flush=True,
        )


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
    parser.add_argument("--studies", type=int, default=2000)
    parser.add_argument("--animals", type=int, default=5)
    parser.add_argument("--strides", type=int, default=10)
    parser.add_argument("--part", choices=["phase", "linear", "random", "effects", "mixed"])
    asked = parser.parse_args()
    size, rng = Size(asked.animals, asked.strides), np.random.default_rng(20)
    began = time.perf_counter()
    print(f"{asked.studies} studies of {size.k} animals of {size.n} strides (a group)")
    if asked.part in (None, "phase"):
        phase_coverage(size, asked.studies, rng)
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
