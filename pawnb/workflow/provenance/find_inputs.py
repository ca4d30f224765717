"""The inputs of a run, found again by their names and told by their checksums."""

from __future__ import annotations

import glob
from collections.abc import Iterable, Mapping
from pathlib import Path

from pawnb.errors import InputError
from pawnb.workflow.provenance.record import file_checksum

_NEAREST_PLACES = 3
"""In so many of the places, the nearest, folders within are looked into, too."""


def places_of(path: Path, inputs: str | Path | None) -> list[Path]:
    """Return the folders in which inputs of a run are looked for.

    Parameters
    ----------
    path : Path
        What the run made.
    inputs : str, Path or None
        A folder that was named for it.

    Returns
    -------
    list of Path
        That folder and those in which it lies, or else the folder of the file and those in which
        it lies; the nearest first.

    Raises
    ------
    InputError
        If ``inputs`` is no folder.
    """
    if inputs is None:
        return list(path.absolute().parents)
    folder = Path(inputs)
    if not folder.is_dir():
        raise InputError(f"{folder}: no such folder; name the one that holds the inputs.")
    return [folder.absolute(), *folder.absolute().parents]


def find_inputs(
    checksums: Mapping[str, str], places: Iterable[Path], *, of: str | Path
) -> dict[str, Path]:
    """Find every input of a run as it was then.

    Parameters
    ----------
    checksums : mapping
        What the record calls each input (``m1/results/tracks.nc``), to its checksum.
    places : iterable of Path
        Folders to look in, the nearest first. In each the whole name is tried first, then without
        its first folders, for a folder may have been renamed; where that is nowhere, the whole name
        within folders of the nearest places, for results often lie beside a folder of data.
    of : str or Path
        What was made from them, for messages.

    Returns
    -------
    dict
        Each name to its file.

    Raises
    ------
    InputError
        If any are nowhere, or only with another content; all of them are named.
    """
    places = list(places)
    found: dict[str, Path] = {}
    changed: list[str] = []
    absent: list[str] = []
    others: list[Path] = []
    for label, checksum in checksums.items():
        parts = Path(label).parts
        tails = [Path(*parts[k:]) for k in range(len(parts))]
        there = [f for place in places for tail in tails if _is_input(f := place / tail)]
        # what lies farther off may be another trial's: only the very file is taken for it
        near = (
            []
            if there
            else [f for place in places[:_NEAREST_PLACES] for f in _within(place, label)]
        )
        same = next((file for file in (*there, *near) if file_checksum(file) == checksum), None)
        if same is not None:
            found[label] = same
        elif there:
            changed.append(str(there[0]))
        else:
            absent.append(label)
            others += near[:1]
    if changed or absent:
        raise InputError(_say_missing(changed, absent, others, of=Path(of).name))
    return found


def _say_missing(changed: list[str], absent: list[str], others: list[Path], *, of: str) -> str:
    """Name the inputs that have changed, and those that are not there."""
    said = []
    if changed:
        one = len(changed) == 1
        said.append(
            f"{' and '.join(changed)} {'has' if one else 'have'} changed since {of} was made of "
            f"{'it' if one else 'them'}, so that cannot be made again; put the "
            f"file{'' if one else 's'} from then back, or make it anew"
        )
    if absent:
        one = len(absent) == 1
        other = f" ({' and '.join(map(str, others))} has another content)" if others else ""
        said.append(
            f"{' and '.join(absent)}, of which {of} was made, {'is' if one else 'are'} not there"
            f"{other}; name the folder that holds {'it' if one else 'them'} with --inputs"
        )
    return f"{'; and '.join(said)}."


def _is_input(path: Path) -> bool:
    """Say whether something is a file, or a folder that has files, as tables of one foot each."""
    return path.is_file() or (path.is_dir() and any(item.is_file() for item in path.iterdir()))


def _within(place: Path, label: str) -> list[Path]:
    """Return the files of that name one or two folders down."""
    if place == place.parent:  # the root of all holds more than anybody's inputs
        return []
    name = glob.escape(label)
    return [f for up in ("*", "*/*") for f in sorted(place.glob(f"{up}/{name}")) if _is_input(f)]
