"""Figures into files that carry the recipe to make themselves again."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pandas as pd
from fontTools.subset import Options
from matplotlib.figure import Figure, SubFigure

from pawnb import figures
from pawnb.errors import InputError
from pawnb.figures.other_scripts import (
    set_fonts_of_names,
    signs_as_boxes,
    warn_of_boxes,
)
from pawnb.figures.panels import apart_from_pyplot
from pawnb.files import distinct_name, whole_file
from pawnb.input_warnings import hide_warnings_of
from pawnb.io.tables import write_table
from pawnb.workflow.gait.drawing.drawings import Drawing

Which = Literal["all", "main", "none"]
MAIN = ("gait_diagram", "phase_rose")
FORMATS = ("png", "pdf", "svg")
_PLACES = 8
_OF_LAYOUT = ("GSUB", "GPOS", "GDEF")
"""Tables of a font for who sets words with it. In a PDF each sign has its place; to cut these
tables down to its signs was three quarters of the time to embed DejaVu Sans (0.10 of 0.13 s)."""

# of all figures of a run that is said once, in a sentence; not within a block, as figures are drawn
# on threads, and filters are those of all of them
hide_warnings_of(__name__, saying="Glyph .* missing from")


def save_gait_figures(
    drawings: Iterable[Drawing],
    folder: str | Path,
    *,
    record: Mapping[str, Any],
    which: Which = "all",
    only: Collection[str] | None = None,
) -> list[Path]:
    """Draw figures; save each with the table it draws.

    Figures of trials and of animals carry their names. What cannot be drawn (no speed, one leg,
    no signals) is left out, and ``not_drawn.csv`` says which and why.

    Parameters
    ----------
    drawings : iterable of Drawing
        What to draw: of :func:`~pawnb.workflow.gait.drawing.drawings.gait_drawings`, of
        :func:`~pawnb.workflow.gait.drawing.source_drawings.source_drawings`.
    folder : str or Path
        Folder to write; made where it is absent.
    record : mapping
        Provenance that goes into the metadata of each file.
    which : {"all", "main", "none"}
        All of them, gait diagrams and phase roses only, or none.
    only : collection of str, optional
        Names of the figures to draw, of those.

    Returns
    -------
    list of Path
        The files: png, pdf and svg of each figure, and the csv of what it draws.

    Raises
    ------
    InputError
        If ``which`` is none of these.
    """
    if which not in ("all", "main", "none"):
        raise InputError(f"figures is {which!r}; expected 'all', 'main' or 'none'.")
    if which == "none":
        return []
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    files: list[Path] = []
    absent: list[tuple[str, str]] = []
    taken: set[str] = set()
    boxes = ""
    for drawing in drawings:
        if which == "main" and drawing.kind not in MAIN:
            continue
        # two trials may differ in signs only that no file name has
        name = distinct_name(drawing.name, taken)
        taken.add(name.casefold())
        if only is not None and name not in only:
            continue
        with figures.style(), apart_from_pyplot():
            try:
                table, ax = drawing.draw()
            except InputError as error:
                absent.append((name, str(error)))
                continue
            own = {**record, "figure": drawing.kind, "name": name}
            files += save_figure(ax, folder / name, record=own)
            boxes += signs_as_boxes(ax.get_figure(root=True))
        files.append(write_table(table, folder / f"{name}.csv"))
    if absent:
        table = pd.DataFrame(absent, columns=["figure", "why"])
        files.append(write_table(table, folder / "not_drawn.csv"))
    warn_of_boxes("".join(dict.fromkeys(boxes)))
    return files


def save_figure(ax: Any, path: Path, *, record: Mapping[str, Any]) -> list[Path]:
    """Save a figure as png, pdf and svg with its recipe in the metadata.

    Parameters
    ----------
    ax : matplotlib.axes.Axes or sequence of Axes
        What was drawn.
    path : Path
        Name without ending.
    record : mapping
        The recipe; written as JSON. No time is written, so that equal inputs give
        equal bytes.

    Returns
    -------
    list of Path
        The files.
    """
    figure: Figure = ax.get_figure(root=True)
    chosen = figures.get_style()
    if chosen != figures.StyleOptions():  # then the recipe needs it
        record = {**record, "style": dataclasses.asdict(chosen)}
    recipe = json.dumps(record, sort_keys=True)
    metadata: dict[str, dict[str, Any]] = {
        "png": {"Description": recipe, "Software": None},
        "pdf": {"Subject": recipe, "CreationDate": None, "ModDate": None, "Producer": None,
                "Creator": "pawnb"},
        "svg": {"Description": recipe, "Date": None, "Creator": "pawnb"},
    }  # fmt: skip
    # panels are laid out once, not anew for each format
    figure.draw_without_rendering()
    if set_fonts_of_names(figure):
        figure.draw_without_rendering()
    figure.set_layout_engine("none")
    _round_layout(figure)
    files = []
    with _laid_out(figure), _fonts_without_layout():
        for ending in FORMATS:
            file = path.with_name(f"{path.name}.{ending}")
            with whole_file(file) as part:
                figure.savefig(part, dpi=chosen.dpi, metadata=metadata[ending])
            files.append(file)
    return files


@contextmanager
def _laid_out(figure: Figure) -> Iterator[None]:
    """Save a figure without laying it out: matplotlib draws it twice for that in each format.

    It does so wherever there is an engine, also one that does nothing, as ``"none"`` leaves it.
    """
    figure.get_layout_engine = lambda: None  # type: ignore[method-assign]
    try:
        yield
    finally:
        del figure.get_layout_engine


@contextmanager
def _fonts_without_layout() -> Iterator[None]:
    """Embed fonts without their tables of layout; other threads may do so meanwhile."""
    # no public name; where it is another one day, saving takes longer
    dropped: list[str] = getattr(Options, "_drop_tables_default", [])
    dropped.extend(_OF_LAYOUT)
    try:
        yield
    finally:
        for name in _OF_LAYOUT:
            dropped.remove(name)


def _round_layout(figure: Figure | SubFigure) -> None:
    """Round where panels lie: the solver of the layout varies in the last bits from run to run.

    A hundred-millionth of the page moves nothing that is seen, but a line that lies on the edge
    of a pixel would else be drawn in one or the other.
    """
    for ax in figure.get_axes():
        ax.set_position(np.round(ax.get_position(original=True).bounds, _PLACES).tolist())
    for part in figure.subfigs:
        box = part.bbox_relative
        box.p0, box.p1 = np.round(box.p0, _PLACES), np.round(box.p1, _PLACES)
        _round_layout(part)
