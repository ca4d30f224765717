"""Animals that a new trial can be of: which points they have, and how they are tracked."""

from __future__ import annotations

from dataclasses import dataclass

from pawnb.errors import InputError, did_you_mean
from pawnb.trial import Kind
from pawnb.trial.kinds import TRAITS


@dataclass(frozen=True)
class AnimalChoice:
    """One animal to choose.

    Parameters
    ----------
    name : str
        What it is called in a list.
    words : str
        What is tracked of it, in words.
    kind : {"paws", "pose"}
        Points, or a jointed animal.
    points : tuple of str
        Points to track; empty where they are typed, or given by the species.
    species : str, optional
        What ``[animal] species`` says.
    """

    name: str
    words: str
    kind: Kind
    points: tuple[str, ...] = ()
    species: str | None = None

    @property
    def has_points(self) -> bool:
        """Whether points are tracked, which a person may name."""
        return not TRAITS[self.kind].is_jointed


def _sides(n: int) -> tuple[str, ...]:
    """Return the names of the feet of n pairs, front to hind."""
    return tuple(f"{side}{place}" for side in "LR" for place in range(1, n + 1))


OTHER_ANIMAL = "other"
ANIMALS: tuple[AnimalChoice, ...] = (
    AnimalChoice("mouse", "four paws", "paws", ("FR", "HR", "FL", "HL"), "mouse"),
    AnimalChoice("four legs", "four feet of another animal", "paws", ("FR", "HR", "FL", "HL")),
    AnimalChoice("insect", "six feet", "paws", _sides(3)),
    AnimalChoice("spider", "eight feet", "paws", _sides(4)),
    AnimalChoice(
        "insect with joints", "whole legs, from above", "pose", species="insect"
    ),
    AnimalChoice("spider with joints", "whole legs, from above", "pose", species="spider"),
    AnimalChoice(
        "Dolomedes with joints", "a fishing spider, from above", "pose", species="dolomedes"
    ),
    AnimalChoice(OTHER_ANIMAL, "points that you name", "paws"),
)  # fmt: skip


def choose_animal(answer: str) -> AnimalChoice:
    """Return the animal of a name, or of its place in the list counted from 1.

    Parameters
    ----------
    answer : str
        What a person typed.

    Returns
    -------
    AnimalChoice
        The animal.

    Raises
    ------
    InputError
        If there is none.
    """
    names = [animal.name for animal in ANIMALS]
    word = answer.strip().lower()
    if word.isdigit() and 1 <= int(word) <= len(ANIMALS):
        return ANIMALS[int(word) - 1]
    for animal in ANIMALS:
        if animal.name.lower() == word:
            return animal
    raise InputError(
        f"{answer!r} is no animal of the list{did_you_mean(word, names)}; "
        f"expected {', '.join(names)}, or a number from 1 to {len(ANIMALS)}."
    )
