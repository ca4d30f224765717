"""Start clicks (``start.csv``): where points are in one frame or more, any points in each."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

import pandas as pd

from pawnb.errors import InputError, did_you_mean
from pawnb.files import as_word
from pawnb.io.recognise import find_format
from pawnb.io.start_films import lines_of, read_films, write_films
from pawnb.io.tables import read_cells, read_numbers, write_table
from pawnb.schema import START_COLUMNS, check_columns
from pawnb.schema.arguments import checked_arguments
from pawnb.trial import Trial

FILM_COLUMN = "film"
"""Code of the film in which a point was clicked."""
_OWN_FORMATS = ("csv", "csv-3d", "pawnb")


@checked_arguments
def read_start(path: str | Path, trial: Trial) -> pd.DataFrame:
    """Read and check ``start.csv``.

    Parameters
    ----------
    path : str or Path
        A csv with the columns ``frame, view, point, u, v``, in px of the views. A point that
        a view does not see is left out.
    trial : Trial
        The trial whose views and points these are.

    Returns
    -------
    pandas.DataFrame
        Exactly those columns, in the order of the file.

    Raises
    ------
    InputError
        For a missing file or column, a cell that is not a number, an unknown view or point, the
        same click twice, a frame outside the trial, or a point of the trial that is clicked in
        no view of any frame.

    Examples
    --------
    >>> clicks = pd.DataFrame({"frame": 0, "view": "cam1", "point": ["FR", "HR"],
    ...                        "u": [120.0, 80.0], "v": [60.0, 61.0]})
    >>> path = pawnb.io.write_start(clicks, "start.csv")
    >>> trial = pawnb.Trial(kind="paws", name="m07", fps=250.0, animal=pawnb.Animal(id="m07"),
    ...                     views=(pawnb.View(name="cam1", video="cam1.avi"),))
    >>> len(pawnb.io.read_start(path, trial))
    2
    """
    where = Path(path).name
    if not Path(path).exists():
        raise InputError(
            f"{path}: no such file; click the points with pawnb open or "
            "pawnb.widgets.ClickInitialiser, or write a csv table with the columns "
            f"{', '.join(START_COLUMNS)}."
        )
    _refuse_other_programs(Path(path), trial)
    cells = read_cells(path, START_COLUMNS)
    table = pd.DataFrame(
        {
            "frame": read_numbers(cells, "frame", where=where, whole=True),
            "view": cells["view"],
            "point": cells["point"],
            "u": read_numbers(cells, "u", where=where),
            "v": read_numbers(cells, "v", where=where),
        }
    )
    _check_clicks(table, trial, where)
    return table


def films_of_clicks(path: str | Path) -> dict[tuple[int, str, str, float, float], str]:
    """Return in which film each click was made, as far as that is known.

    Parameters
    ----------
    path : str or Path
        ``start.csv``. The films are in ``start.films.json`` beside it, which the widget writes; of
        clicks that others made or changed since it says nothing.

    Returns
    -------
    dict of tuple to str
        Frame, view, point, u and v of a click to the film's code
        (:func:`pawnb.core.video.doubts.exchanged_films.film_code`).
    """
    if not (known := read_films(path)):
        return {}
    try:
        return {
            (int(frame), view, point, float(u), float(v)): known[line]
            for line, (frame, view, point, u, v) in _lines(path)
            if line in known
        }
    except (InputError, ValueError):  # the clicks are read, and faults told, elsewhere
        return {}


def _lines(path: str | Path) -> list[tuple[str, tuple[str, ...]]]:
    """Return each line of a file of clicks, and its cells."""
    cells = read_cells(path, START_COLUMNS)[list(START_COLUMNS)]
    rows = cells.itertuples(index=False, name=None)
    return list(zip(lines_of(cells), rows, strict=True))


def clicked_films(path: str | Path) -> dict[str, set[str]]:
    """Return the codes of the films in which points were clicked, by view, as far as known.

    Parameters
    ----------
    path : str or Path
        As for :func:`films_of_clicks`.

    Returns
    -------
    dict of str to set of str
        Codes by view.
    """
    films: dict[str, set[str]] = {}
    for (_, view, *_), code in films_of_clicks(path).items():
        films.setdefault(view, set()).add(code)
    return films


def check_start(
    start: pd.DataFrame, trial: Trial, sizes: Mapping[str, tuple[int, int]]
) -> pd.DataFrame:
    """Check start clicks against the trial and the pictures.

    Parameters
    ----------
    start : DataFrame
        Columns ``frame, view, point, u, v``, from a file or from a widget.
    trial : Trial
        The trial.
    sizes : mapping
        Width and height in px of the resulting picture of each view.

    Returns
    -------
    pandas.DataFrame
        The same table.

    Raises
    ------
    InputError
        As :func:`read_start`, and for a click outside its picture.
    """
    check_columns(start, START_COLUMNS, where="start clicks")
    _check_clicks(start, trial, "start clicks")
    for row in start.to_dict("records"):
        width, height = sizes[row["view"]]
        if not (-0.5 <= row["u"] < width - 0.5 and -0.5 <= row["v"] < height - 0.5):
            raise InputError(
                f"start clicks: view {row['view']}, point {row['point']} is at u = {row['u']:g}, "
                f"v = {row['v']:g}, outside the picture of {width} × {height} px; click it again, "
                "or remove it where it is hidden."
            )
    return start


@checked_arguments
def write_start(start: pd.DataFrame, path: str | Path) -> Path:
    """Write start clicks as ``start.csv`` (u, v to 4 decimals), whole or not at all.

    Parameters
    ----------
    start : DataFrame
        Columns ``frame, view, point, u, v``, and ``film`` where it is known in which film each
        was clicked: that goes into ``start.films.json`` beside the file.
    path : str or Path
        The file.

    Returns
    -------
    Path
        The file.

    Examples
    --------
    >>> clicks = pd.DataFrame({"frame": 0, "view": "cam1", "point": ["FR", "HR"],
    ...                        "u": [120.0, 80.0], "v": [60.0, 61.0]})
    >>> pawnb.io.write_start(clicks, "start.csv").name
    'start.csv'
    """
    check_columns(start, START_COLUMNS, where="start clicks")
    path = write_table(start[list(START_COLUMNS)].reset_index(drop=True), path)
    if FILM_COLUMN in start:
        lines = [line for line, _ in _lines(path)]
        write_films(path, zip(lines, start[FILM_COLUMN], strict=True))
    return path


def _refuse_other_programs(path: Path, trial: Trial) -> None:
    """Refuse points that another program wrote, and say how they become start clicks."""
    views = ", ".join(view.name for view in trial.views)
    expected = f"expected a csv table with the columns {', '.join(START_COLUMNS)}"
    if path.suffix.lower() == ".json" and path.is_file():
        raise InputError(
            f"{path.name}: a JSON file, as COCO and Label Studio write it, which is not read; "
            f"{expected}, in px of the views ({views}). Label Studio counts in percent of the "
            "picture."
        )
    try:
        found = find_format(path)
    except InputError:
        return  # said where the table itself is read
    if found not in (None, *_OWN_FORMATS):
        raise InputError(
            f"{path.name}: points of another program ({found}); {expected}. Turn it into one with: "
            f"pawnb convert {as_word(path.name)} start.csv --to csv --fps {trial.fps:g}; write the "
            f"trial's views ({views}) into its column view, and leave out rows without a place."
        )


def _check_clicks(table: pd.DataFrame, trial: Trial, where: str) -> None:
    """Check everything about clicks that needs no picture."""
    if table.empty:
        raise InputError(f"{where}: no clicks; click every point in at least one view.")
    lost = table[~table[["u", "v"]].apply(lambda c: c.between(-1e9, 1e9)).all(axis=1)]
    if len(lost):
        row = lost.iloc[0]
        raise InputError(
            f"{where}: view {row['view']}, point {row['point']} has u = {row['u']}, "
            f"v = {row['v']}; expected numbers (leave out a point that the view does not see)."
        )
    for view, point in table[["view", "point"]].drop_duplicates().itertuples(index=False):
        _check_names(str(view), str(point), trial, where)
    twice = table.duplicated(["frame", "view", "point"])
    if twice.any():
        row = table[twice].iloc[0]
        raise InputError(
            f"{where}: point {row['point']} is clicked twice in view {row['view']}, frame "
            f"{row['frame']}; keep one of them."
        )
    _check_frames(table, trial, where)
    clicked = set(table["point"])
    for point in _points(trial):
        if point not in clicked:
            raise InputError(
                f"{where}: point {point!r} is clicked in no view; click it in at least one, or "
                "take it out of the views' points in trial.toml."
            )


def _check_frames(table: pd.DataFrame, trial: Trial, where: str) -> None:
    """Refuse frames that the trial does not have."""
    frames = sorted({int(frame) for frame in table["frame"]})
    first, stop = trial.frames or (0, None)
    for frame in frames:
        if frame < first or (stop is not None and frame >= stop):
            span = f"[{first}, {stop})" if stop is not None else f"{first} and later"
            raise InputError(f"{where}: frame {frame} is not in the trial's frames, {span}.")


def _check_names(view: str, point: str, trial: Trial, where: str) -> None:
    """Refuse a view that the trial does not have, and a point that the view does not track."""
    names = [v.name for v in trial.views]
    if view not in names:
        raise InputError(
            f"{where}: unknown view {view!r}{did_you_mean(view, names)}; the trial's views are "
            f"{', '.join(names)}."
        )
    points = trial.view(view).points
    if points and point not in points:
        everywhere = _points(trial)
        if point not in everywhere:
            raise InputError(
                f"{where}: unknown point {point!r}{did_you_mean(point, everywhere)}; view {view!r} "
                f"tracks {', '.join(points)}; to track it, add it to that view's points in "
                "trial.toml."
            )
        raise InputError(
            f"{where}: point {point!r} is clicked in view {view!r}, which tracks "
            f"{', '.join(points)}; remove the click, or add the point to that view in trial.toml."
        )
    if not point:
        raise InputError(f"{where}: a click in view {view!r} has no point name; name it.")


def _points(trial: Trial) -> Iterable[str]:
    """Return every point that the trial's views name, in order."""
    return dict.fromkeys(point for view in trial.views for point in view.points)
