"""What a reader must know of the groups of a gait analysis: who is in them, what mixes them."""

from __future__ import annotations

import re
import unicodedata
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence

from pawnb.gait.analysis.notes import trial_of
from pawnb.workflow.gait.study_tables import LENGTH, MASS, Fields


def notes_on_groups(
    trials: Sequence[tuple[str, str]],
    groups: Mapping[tuple[str, str], str],
    *,
    aside: Mapping[tuple[str, str], str],
    compared: str,
) -> list[str]:
    """Say what may be wrong with animals and groups, and which tables do not tell groups apart.

    Parameters
    ----------
    trials : sequence of (animal, trial)
        All trials.
    groups : mapping
        Group of each animal and trial, where there are any.
    aside : mapping
        Condition of each animal and trial where a study compares groups, group where it compares
        conditions.
    compared : {"group", "condition"}
        What the groups are.

    Returns
    -------
    list of str
        The notes.
    """
    return [
        *_spelt_alike("animals", (animal for animal, _ in trials)),
        *_spelt_alike("groups", groups.values()),
        *_without_group(trials, groups),
        *_in_several_groups(groups, compared=compared),
        *_not_told_apart(groups, aside, compared=compared),
        *_all_together(groups, compared=compared),
    ]


def notes_on_fields(fields: Fields) -> list[str]:
    """Say where what is known of animals is not known of all, or contradicts itself.

    Parameters
    ----------
    fields : mapping
        (animal, trial) to its covariates.

    Returns
    -------
    list of str
        The notes.
    """
    names = list(dict.fromkeys(name for own in fields.values() for name in own))
    notes = []
    for name in names:
        lacking = [who for who, own in fields.items() if name not in own]
        if lacking and name in (*MASS, *LENGTH):
            notes.append(
                f"gait is not compared with {name}: it is not given for "
                f"{', '.join(name_trials(lacking, fields))}; every trial of every animal needs it."
            )
        notes += _contradictions(name, fields)
    return notes


def _contradictions(name: str, fields: Fields) -> list[str]:
    """Say which animals have several values of a field that is one value in most others."""
    values: dict[str, list[str]] = {}
    for (animal, _), own in fields.items():
        values.setdefault(animal, []).append(str(own.get(name, "")))
    several = {animal: own for animal, own in values.items() if len(own) > 1}
    differ = {a: dict.fromkeys(own) for a, own in several.items() if len(set(own)) > 1}
    if not differ or 2 * len(differ) >= len(several):
        return []
    told = "; ".join(
        f"{animal}: {', '.join(value or 'empty' for value in own)}"
        for animal, own in differ.items()
    )
    return [
        f"{name} is one value in the trials of most animals, and several in those of {told}. Look "
        "whether that is a slip, or two animals under one name."
    ]


def name_trials(some: Iterable[tuple[str, str]], trials: Iterable[tuple[str, str]]) -> list[str]:
    """Return the names of some trials, with the animal's where another one has such a trial.

    Parameters
    ----------
    some : iterable of (animal, trial)
        Those to name.
    trials : iterable of (animal, trial)
        All that there are.

    Returns
    -------
    list of str
        A name for each.
    """
    names = Counter(trial for _, trial in trials)
    return [trial if names[trial] == 1 else trial_of(animal, trial) for animal, trial in some]


def _spelt_alike(what: str, names: Iterable[str]) -> list[str]:
    """Say which names differ in capitals, spaces, hyphens, underscores and leading zeros only."""
    alike: dict[str, list[str]] = {}
    for name in dict.fromkeys(names):
        plain = re.sub(r"[\s_-]+", "", unicodedata.normalize("NFKC", name)).casefold()
        # spreadsheets make 7 of 007; 0.05 and 0.5 are no such names
        plain = re.sub(r"(?<![\d.,])0+(?=\d)", "", plain)
        alike.setdefault(plain, []).append(name)
    return [
        f"{' and '.join(same)} count as {len(same)} {what}: where they are one, write the name "
        "alike everywhere and run this again."
        for same in alike.values()
        if len(same) > 1
    ]


def _without_group(
    trials: Sequence[tuple[str, str]], groups: Mapping[tuple[str, str], str]
) -> list[str]:
    """Say which trials have no group, where others have one."""
    if not groups:
        return []
    lost = name_trials([one for one in trials if one not in groups], trials)
    if not lost:
        return []
    return [
        f"no group is given for {', '.join(lost)}: left out where groups are compared, and "
        "counted in all other tables."
    ]


def _in_several_groups(groups: Mapping[tuple[str, str], str], *, compared: str) -> list[str]:
    """Say which animals are in several groups: they are compared with themselves, others not."""
    own: dict[str, dict[str, None]] = {}
    for (animal, _), group in groups.items():
        own.setdefault(animal, {})[group] = None
    several = [animal for animal, names in own.items() if len(names) > 1]
    if not several:
        return []
    names = " and ".join(dict.fromkeys(name for animal in several for name in own[animal]))
    alone = ", ".join(animal for animal in own if animal not in several)
    if compared == "condition":  # so it is meant
        left = f"no other condition is given for {alone}: left out where conditions are compared."
        return [left] * bool(alone)
    left = f", and {alone}, of one group only, left out" if alone else ""
    return [
        f"{', '.join(several)} count as the same animals in {names}: groups are compared within "
        f"animals (paired){left}. Where these are different animals, or a trial is in a wrong "
        "group, give every animal an id and a group of its own and run this again."
    ]


def _not_told_apart(
    groups: Mapping[tuple[str, str], str], aside: Mapping[tuple[str, str], str], *, compared: str
) -> list[str]:
    """Say where groups are compared although each has trials of several conditions, or so."""
    own: dict[str, dict[str, None]] = {}
    for key, name in aside.items():
        own.setdefault(groups.get(key, ""), {})[name] = None
    mixed = dict.fromkeys(name for names in own.values() if len(names) > 1 for name in names)
    if not groups or not mixed:
        return []
    other = "condition" if compared == "group" else "group"
    has: dict[str, set[str]] = {}
    for (animal, _), name in aside.items():
        has.setdefault(animal, set()).add(name)
    less = [animal for animal, names in has.items() if not names >= set(mixed)]
    uneven = f"; {', '.join(less)} lack some of them, so that their means are of another mix"
    return [
        f"{compared}s are compared over several {other}s ({', '.join(mixed)}), which are not told "
        f"apart: the mean of a {compared} is over all of them"
        f"{uneven if less and compared == 'group' else ''}. To compare within one {other}, "
        "leave the trials of the others out of the study; to compare these, write [study] "
        f'compare = "{other}".'
    ]


def _all_together(groups: Mapping[tuple[str, str], str], *, compared: str) -> list[str]:
    """Say that means outside the comparison of groups are over all of them."""
    names = list(dict.fromkeys(groups.values()))
    if len(names) < 2:
        return []
    own = {(animal, group) for (animal, _), group in groups.items()}
    several = len(own) > len({animal for animal, _ in own})
    mixed = (
        f", and rows of single animals in symmetry, alternation, coupling, patterns, support_rule "
        f"and support_shares over all {compared}s of the animal"
    )
    return [
        f"means, intervals and patterns of phase_summary, animals and legs, and figures that name "
        f"no {compared}, are over all {compared}s together ({', '.join(names)})"
        f"{mixed if several else ''}. groups.csv has "
        f"the means of each {compared}; for the whole tables and figures of one, analyse its "
        "trials alone."
    ]
