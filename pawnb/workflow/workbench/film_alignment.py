"""Films that were not started together, aligned by an event that all of them show."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from pawnb.errors import InputError


def offsets_by_event(
    films: Sequence[str], events: Sequence[int | None], *, from_first: bool = False
) -> list[int]:
    """Return the offset of each film from the frame in which it shows one event.

    Parameters
    ----------
    films : sequence of str
        What each film is called.
    events : sequence of int or None
        Frame of each film that first shows the event, such as a flash; None where that is not
        known.
    from_first : bool
        Whether frames of the trial are those of the first film, as of a jointed animal.

    Returns
    -------
    list of int
        Frame of each film that belongs to frame 0 of the trial, the first that all films have; 0
        where no event is known.

    Raises
    ------
    InputError
        If the event is known in some films only.
    """
    known = [event for event in events if event is not None]
    if not known:
        return [0] * len(films)
    missing = [film for film, event in zip(films, events, strict=True) if event is None]
    if missing:
        raise InputError(
            f"the flash is not marked in {', '.join(missing)} yet: go to the frame in which "
            f"{missing[0]} first shows it, and press Flash is here; or empty the other fields, "
            "where all films were started together."
        )
    first = known[0] if from_first else min(known)
    return [event - first for event in known]


def tell_alignment(offsets: Mapping[str, int], lengths: Mapping[str, int]) -> str:
    """Say how films are aligned, or that they may have to be.

    Parameters
    ----------
    offsets : mapping of str to int
        Film to its offset.
    lengths : mapping of str to int
        Film to its number of frames.

    Returns
    -------
    str
        A sentence or two; empty where films of one length begin together.
    """
    if any(offsets.values()):
        begins = ", ".join(f"frame {offset} of {film}" for film, offset in offsets.items())
        return (
            f"The films are aligned: frame 0 is {begins}. Go through the pictures: what moves "
            "must do so in all of them at once."
        )
    if len(set(lengths.values())) > 1:
        each = ", ".join(f"{film} {n}" for film, n in lengths.items())
        return (
            f"The films differ in length (frames: {each}). Were the cameras not started together, "
            "go to the frame in which a picture first shows a flash or another sudden event, press "
            "Flash is here beside that view, and do so for each."
        )
    return ""
