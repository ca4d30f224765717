"""What starts of paws and of jointed animals share: how sure they are, and where one looks."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, ClassVar

import pandas as pd

from pawnb.core.video import ViewSet
from pawnb.errors import InputError
from pawnb.trial import Trial
from pawnb.workflow.start.sureness import sureness_in_words


class Proposed(ABC):
    """A start that a person accepts or corrects, and how sure each part of it is."""

    what: ClassVar[str]
    """What it is, in a word or two."""

    if TYPE_CHECKING:  # fields of one, a property of the other

        @property
        def frame(self) -> int:
            """In which frame it is."""

        @property
        def notes(self) -> tuple[str, ...]:
            """What a person should know, in sentences."""

    @property
    @abstractmethod
    def parts(self) -> pd.DataFrame:
        """The name of each part, sure (0 to 1), words."""

    @property
    def sure(self) -> float:
        """How sure all of it is, 0 to 1: as sure as its least sure part."""
        return float(self.parts["sure"].min())

    @property
    def words(self) -> str:
        """How sure all of it is, in words."""
        return sureness_in_words(self.sure)

    def text(self) -> str:
        """Return frame, parts and how sure they are, one a line, then the notes."""
        lines = [f"proposed {self.what} in frame {self.frame}: {self.words} ({self.sure:.2f})"]
        lines += [
            f"  {name}  {sure:.2f}  {words}"
            for name, sure, words in self.parts.itertuples(index=False)
        ]
        return "\n".join([*lines, *self.notes])


def sure_table(part: str, sure: Mapping[str, float]) -> pd.DataFrame:
    """Return how sure each part is, in numbers and in words.

    Parameters
    ----------
    part : str
        What a part is called: the first column.
    sure : mapping
        Part to how sure it is, 0 to 1.

    Returns
    -------
    pandas.DataFrame
        ``part``, sure, words.
    """
    rows = [(name, own, sureness_in_words(own)) for name, own in sure.items()]
    return pd.DataFrame(rows, columns=[part, "sure", "words"])


def frames_to_look_through(
    trial: Trial,
    views: ViewSet,
    frames: Sequence[int] | None,
    *,
    every: int = 1,
    at_most: int | None = None,
) -> Sequence[int]:
    """Return the frames in which a start is looked for.

    Parameters
    ----------
    trial : Trial
        The trial.
    views : ViewSet
        Its open views.
    frames : sequence of int or None
        Those asked for.
    every : int
        Else those of the trial, in steps of so many,
    at_most : int, optional
        or larger ones where that would be more than so many.

    Returns
    -------
    sequence of int
        The frames.

    Raises
    ------
    InputError
        If none is asked for, or one that is not in the recording.
    """
    first, stop = trial.frames or (views.first_frame, views.n_frames)
    if frames is None:
        step = every if at_most is None else max(every, -(-(stop - first) // at_most))
        frames = range(first, stop, step)
    wrong = [frame for frame in frames if not views.first_frame <= frame < views.n_frames]
    if wrong or not len(frames):
        raise InputError(
            f"frames to look through: found {wrong[0] if wrong else 'none'}; expected some of "
            f"{views.first_frame} to {views.n_frames - 1}."
        )
    return frames
