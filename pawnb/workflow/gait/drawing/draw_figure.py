"""One figure of one's own from a table, into files that can be made again."""

from __future__ import annotations

import inspect
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from pawnb import figures
from pawnb.errors import InputError, did_you_mean
from pawnb.figures.other_scripts import signs_as_boxes, warn_of_boxes
from pawnb.figures.panels import apart_from_pyplot
from pawnb.io.tables import write_table
from pawnb.schema.arguments import checked_arguments
from pawnb.workflow.gait.drawing.save_figures import save_figure
from pawnb.workflow.provenance.labels import label_inputs
from pawnb.workflow.provenance.record import build_step, file_checksum
from pawnb.workflow.provenance.results import make_folder

STEP = "draw"
"""What the recipe of such a figure calls its step."""
_TABLE = ""


@checked_arguments
def draw_figure(kind: str, table: pd.DataFrame, path: str | Path, **options: Any) -> list[Path]:
    """Draw a figure of a table, and save both so that :func:`pawnb.reproduce` draws it again.

    ``pawnb gait`` saves its figures so by itself; this is for those that a notebook draws.

    Parameters
    ----------
    kind : str
        Name of the figure: ``"bland_altman"`` is drawn by
        :func:`pawnb.figures.plot_bland_altman`.
    table : pandas.DataFrame
        What it draws: of its ``build_..._table``, perhaps changed.
    path : str or Path
        Where to, without ending; the folder is made where it is absent.
    **options
        Of ``plot_<kind>``. Tables among them are saved, too.

    Returns
    -------
    list of Path
        The png, pdf and svg, and the csv of each table.

    Raises
    ------
    InputError
        If there is no such figure or option, an option cannot be written down (an array, axes), or
        the table cannot be drawn.

    Examples
    --------
    >>> trace = pawnb.tracks_table(tracks).groupby("frame")["u"].mean().to_numpy()
    >>> table = pawnb.figures.build_filter_effect_table(trace, fs_hz=250.0, cutoff_hz=20.0)
    >>> files = pawnb.draw_figure("filter_effect", table, "own/filter", unit="px")
    >>> [file.name for file in files]
    ['filter.png', 'filter.pdf', 'filter.svg', 'filter.csv']
    >>> pawnb.reproduce("own/filter.svg").identical
    True
    """
    options = _checked(kind, options)
    path = Path(path)
    make_folder(path.parent)
    tables = {_TABLE: table} | {k: v for k, v in options.items() if isinstance(v, pd.DataFrame)}
    plain = {name: value for name, value in options.items() if name not in tables}
    files = {
        name: write_table(own, path.with_name(f"{path.name}{name and '_'}{name}.csv"))
        for name, own in tables.items()
    }
    labels = label_inputs(list(files.values()))
    step = build_step(
        STEP,
        command=None,
        inputs={labels[file]: file_checksum(file) for file in files.values()},
        settings=plain,
        kind=kind,
        tables={name: labels[file] for name, file in files.items()},
        words={name: _words(own) for name, own in tables.items()},
    )
    made = redraw({**step, "name": path.name}, files, path.parent)
    return [*made, *files.values()]


def redraw(record: Mapping[str, Any], files: Mapping[str, Path], folder: Path) -> list[Path]:
    """Draw a figure of its tables on disk, as they were written.

    Parameters
    ----------
    record : mapping
        The recipe, with the names of the figure and of its files.
    files : mapping of str to Path
        The table under ``""``, and tables among the options under their names.
    folder : Path
        Where to.

    Returns
    -------
    list of Path
        The png, pdf and svg.
    """
    words = record["words"]
    # an empty cell is missing, and nothing else is: an animal may be called NA
    tables = {
        name: pd.read_csv(
            file, dtype=dict.fromkeys(words[name], str), keep_default_na=False, na_values=[""],
        )
        for name, file in files.items()
    }  # fmt: skip
    table = tables.pop(_TABLE)
    with figures.style(), apart_from_pyplot():
        ax = getattr(figures, f"plot_{record['kind']}")(table, **record["settings"], **tables)
        record = {**record, "figure": record["kind"]}
        made = save_figure(ax, folder / str(record["name"]), record=record)
        warn_of_boxes(signs_as_boxes(ax.get_figure(root=True)))
    return made


def _checked(kind: str, options: Mapping[str, Any]) -> dict[str, Any]:
    """Return the options as JSON gives them back, after naming what is none."""
    known = [n.removeprefix("plot_") for n in figures.__all__ if n.startswith("plot_")]
    if kind not in known:
        raise InputError(
            f"there is no figure {kind!r}{did_you_mean(kind, known)}; figures are "
            f"{', '.join(sorted(known))}."
        )
    takes = list(inspect.signature(getattr(figures, f"plot_{kind}")).parameters)[1:]
    takes = [name for name in takes if name != "ax"]
    checked = {}
    for name, value in options.items():
        if name not in takes:
            listed = f"it takes {', '.join(takes)}" if takes else "it takes none"
            raise InputError(f"{kind} has no option {name!r}{did_you_mean(name, takes)}; {listed}.")
        try:
            plain = isinstance(value, pd.DataFrame) or value is None
            checked[name] = value if plain else json.loads(json.dumps(value))
        except TypeError:
            raise InputError(
                f"{kind}: {name} is a {type(value).__name__}, which no recipe can hold; expected "
                "text, numbers, lists, or a table."
            ) from None
    return checked


def _words(table: pd.DataFrame) -> list[str]:
    """Return the columns that hold words, which numbers in a csv may look like."""
    return [
        str(name)
        for name in table
        if not pd.api.types.is_numeric_dtype(table[name])
        and not pd.api.types.is_bool_dtype(table[name])
    ]
