"""The films in which a start was made, kept beside its csv: one film may be put for another."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from pathlib import Path

import pandas as pd

from pawnb.errors import InputError
from pawnb.files import read_bytes
from pawnb.io.tables import write_text

_FILMS_SUFFIX = ".films.json"
"""``start.films.json`` beside ``start.csv`` has the code of each of its lines."""


def lines_of(cells: pd.DataFrame) -> list[str]:
    """Return the lines of a table of cells, as their films are kept under them.

    Parameters
    ----------
    cells : pandas.DataFrame
        Cells as they are in the file.

    Returns
    -------
    list of str
        A line a row.
    """
    return [",".join(map(str, row)) for row in cells.itertuples(index=False, name=None)]


def read_films(path: str | Path) -> dict[str, str]:
    """Return the film of each line of a start, as far as it is known.

    Parameters
    ----------
    path : str or Path
        The csv of the start. Lines that others made or changed have no film.

    Returns
    -------
    dict of str to str
        Line to the film's code (:func:`pawnb.core.video.doubts.exchanged_films.film_code`).
    """
    file = Path(path).with_suffix(_FILMS_SUFFIX)
    if not file.exists():
        return {}
    try:
        known = json.loads(read_bytes(file))
    except (InputError, ValueError):  # a start without films is as good
        return {}
    if not isinstance(known, Mapping):
        return {}
    return {str(line): str(code) for line, code in known.items()}


def write_films(path: str | Path, lines: Iterable[tuple[str, str]]) -> None:
    """Keep in which films the lines of a start were made; where none is known nothing is written.

    Parameters
    ----------
    path : str or Path
        The csv of the start.
    lines : iterable of (str, str)
        Each line and the code of its film; empty where that is not known.
    """
    films = {line: film for line, film in lines if film}
    if films:
        write_text(json.dumps(films, indent=1), Path(path).with_suffix(_FILMS_SUFFIX))
