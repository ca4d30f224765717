"""Figures into files that carry the recipe to make themselves again."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from pawnb import figures
from pawnb.gait import GaitTables
from pawnb.io.tables import write_table

FORMATS = ("png", "pdf", "svg")
DPI = 300


def save_gait_figures(
    tables: GaitTables, folder: str | Path, *, record: Mapping[str, Any]
) -> list[Path]:
    """Draw the gait diagram of each trial and the phase rose; save them with their tables.

    Parameters
    ----------
    tables : GaitTables
        What to draw.
    folder : str or Path
        Folder to write; made where it is absent.
    record : mapping
        Provenance that goes into the metadata of each file.

    Returns
    -------
    list of Path
        The files: png, pdf and svg of each figure, and the csv of what it draws.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    files = []
    drawings = []
    for (animal, trial), events in tables.events.groupby(["animal", "trial"], sort=False):
        own = tables.dropped
        own = own[(own["animal"] == animal) & (own["trial"] == trial)]
        table = figures.build_gait_diagram_table(events.reset_index(drop=True), dropped=own)
        drawings.append((f"gait_diagram_{_safe(f'{animal}_{trial}')}", table, "gait_diagram"))
    if len(tables.phases):
        table = figures.build_phase_rose_table(tables.phases)
        drawings.append(("phase_rose", table, "phase_rose"))
    for name, table, kind in drawings:
        with figures.style():
            ax = getattr(figures, f"plot_{kind}")(table)
            files += save_figure(ax, folder / name, record={**record, "figure": kind})
        write_table(table, folder / f"{name}.csv")
        files.append(folder / f"{name}.csv")
    return files


def save_figure(ax: Any, path: Path, *, record: Mapping[str, Any]) -> list[Path]:
    """Save a figure as png, pdf and svg with its recipe in the metadata, and close it.

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
    import matplotlib.pyplot as plt

    figure: Figure = ax.figure
    recipe = json.dumps(record, sort_keys=True)
    metadata: dict[str, dict[str, Any]] = {
        "png": {"Description": recipe, "Software": None},
        "pdf": {"Subject": recipe, "CreationDate": None, "ModDate": None, "Producer": None,
                "Creator": "pawnb"},
        "svg": {"Description": recipe, "Date": None, "Creator": "pawnb"},
    }  # fmt: skip
    files = []
    for ending in FORMATS:
        file = path.with_name(f"{path.name}.{ending}")
        figure.savefig(file, dpi=DPI, metadata=metadata[ending])
        files.append(file)
    plt.close(figure)
    return files


def _safe(name: str) -> str:
    """Return a name that every file system takes."""
    return "".join(c if c.isalnum() or c in "-_" else "-" for c in name)
