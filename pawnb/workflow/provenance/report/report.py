"""One page on an animal or a study that needs no other file: methods, tables, figures, notes."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from pawnb.figures.measure_heat_map import say_measure
from pawnb.figures.panels import speed_unit, with_unit
from pawnb.files import write_whole
from pawnb.workflow.gait.request import GaitRequest, Legs
from pawnb.workflow.gait.run import GaitRun, carry_out
from pawnb.workflow.gait.statistics import length_unit
from pawnb.workflow.provenance.manifest import read_manifest
from pawnb.workflow.provenance.report.html import (
    MOST_ROWS,
    embedded,
    listed,
    page,
    picture,
    table,
    text,
)
from pawnb.workflow.provenance.report.index_page import note_lines
from pawnb.workflow.provenance.report.methods_text import count_dropped
from pawnb.workflow.provenance.report.phase_words import phase_tables
from pawnb.workflow.provenance.report.words import FILES, figure_order, figure_words

REPORT_FILE = "report.html"

_REPORT_TABLES = (
    "trials", "groups", "phase_summary", "animals", "legs", "against_speed", "phase_speed",
    "scaling", "expected_exponents", "joint_ranges", "steadiness", "stride_durations",
)  # fmt: skip
_NAMED = (
    "animal", "trial", "group", "condition", "group_a", "group_b", "leg", "reference", "where",
    "what", "rows",
)  # fmt: skip
"""Columns of words, however much like numbers or like nothing these look."""
_P_OF_GROUPS = {
    "p": "p", "p_adjusted": "p, Holm within the measure", "p_all_measures": "p over all measures",
}  # fmt: skip
_LEG_COLUMNS = ("leg", "measure", "mean", "ci_low", "ci_high")
_BY_LEG = "Means over animals, each counted once, with 95 % intervals where there are several."
_BLANK_OF_ONE = (
    "One animal only: numbers of strides are no numbers of animals, and no interval or test over "
    "animals is given."
)


def write_report(
    inputs: str | Path | Sequence[str | Path],
    *,
    out: str | Path | None = None,
    fps: float | None = None,
    legs: Legs | None = None,
    settings: Mapping[str, Any] | None = None,
    command: Sequence[str] | None = None,
) -> Path:
    """Analyse the gait of an animal or a study and write one self-contained page on it.

    Corrections of events count as in :func:`pawnb.run_gait`: those in the results of the inputs,
    in the folder where ``pawnb gait`` writes what it finds of them by default, and beside the page.

    Parameters
    ----------
    inputs : str, Path, or sequence of them
        As for :func:`pawnb.run_gait`: a study, a trial, results, tracks, events.
    out : str or Path, optional
        The file; default ``report.html`` beside a study, else in the current folder.
    fps, legs, settings
        As for :func:`pawnb.run_gait`.
    command : sequence of str, optional
        The command line, for the provenance.

    Returns
    -------
    Path
        The page. It holds its figures, and links to nothing.

    Raises
    ------
    InputError
        As :func:`pawnb.run_gait`, and for a folder that holds nothing but results of an analysis.
    """
    request = GaitRequest(inputs=inputs, fps=fps, legs=legs, settings=settings)
    alone = isinstance(inputs, str | Path) and Path(inputs).is_file()
    beside = Path(inputs).parent if alone and isinstance(inputs, str | Path) else Path()
    target = Path(out) if out is not None else beside / REPORT_FILE
    with tempfile.TemporaryDirectory(prefix="pawnb-") as folder:
        run = carry_out(request, out=folder, command=command, corrected=[target.parent])
        write_whole(target, report_page(run).encode())
    return target


def report_page(run: GaitRun) -> str:
    """Lay out the page on an analysis that lies in a folder.

    Parameters
    ----------
    run : GaitRun
        The analysis.

    Returns
    -------
    str
        HTML.
    """
    animals = sorted(run.tables.events["animal"].astype(str).unique())
    title = f"Gait of {animals[0]}" if len(animals) == 1 else f"Gait of {len(animals)} animals"
    notes = note_lines(_read(run.out / "notes.csv"))
    methods = (run.out / "methods.txt").read_text(encoding="utf-8").strip().split("\n\n")
    body = [*(f"<p>{text(_BLANK_OF_ONE)}</p>" for _ in range(len(animals) == 1))]
    body += ["<h2>Animals and strides</h2>", table(_counts(run))]
    body += ["<h2>Methods</h2>", *(f"<p>{text(paragraph)}</p>" for paragraph in methods)]
    body += ["<h2>What was left out</h2>", _left_out(run.tables.dropped)]
    body.append("<h2>Notes</h2>")
    body.append(listed(notes, kind="notes") if notes else "<p>None.</p>")
    body += ["<h2>Tables</h2>", *_tables(run), "<h2>Figures</h2>", *_figures(run.out)]
    body += ["<h2>Provenance</h2>", _provenance(run.out)]
    return page(title, body)


def _read(path: Path) -> pd.DataFrame:
    """Read a table of the run: an animal may be called 01, and a group NA."""
    names = dict.fromkeys(_NAMED, str)
    return pd.read_csv(path, keep_default_na=False, na_values=[""], dtype=names)


def _counts(run: GaitRun) -> pd.DataFrame:
    """Count trials and strides of each animal, and give its usual measures with their units."""
    strides, unit = run.tables.strides, length_unit(run.tables)
    names = {
        "frequency_hz": "stride frequency (Hz)",
        "duty_factor": "duty factor",
        "stride_length": with_unit("stride length", unit),
        "speed": with_unit("speed", speed_unit(unit)),
    }
    known = [name for name in names if name in strides and strides[name].notna().any()]
    by_animal = strides.groupby("animal", sort=True)
    counts = by_animal.agg(trials=("trial", "nunique"), strides=("trial", "size"))
    medians = by_animal[known].median().rename(columns=names)
    trials = _read(run.out / "trials.csv")
    groups = trials.dropna(subset=["group"]).groupby("animal")["group"]
    if len(groups):
        counts.insert(0, "group", groups.agg(lambda own: ", ".join(dict.fromkeys(own))))
    return counts.join(medians.add_prefix("median ")).reset_index()


def _left_out(dropped: pd.DataFrame) -> str:
    """Count what was dropped, by animal and reason."""
    if dropped.empty:
        return "<p>Nothing.</p>"
    return table(count_dropped(dropped, ["animal", "what", "why"]), most=MOST_ROWS)


def _tables(run: GaitRun) -> list[str]:
    """Lay out the tables that there are, measures with their units."""
    parts, unit = [], length_unit(run.tables)
    for name in _REPORT_TABLES:
        path = run.out / f"{name}.csv"
        if not path.exists():
            continue
        values = _read(path)
        if name == "groups":  # those of single legs are follow-ups
            values = values.loc[values["role"] != "follow-up"]
        values = values.drop(columns="note", errors="ignore").dropna(axis=1, how="all")
        if "measure" in values:
            values["measure"] = [say_measure(str(own), unit=unit) for own in values["measure"]]
        parts.append(f"<h3>{text(FILES[path.name])} ({path.name})</h3>")
        if name == "phase_summary":
            parts += phase_tables(values)
            continue
        if name == "groups":
            values = _by_group(values)
        if name == "animals":
            values = _by_leg(values)
            parts.append(f'<p class="small">{_BY_LEG}</p>')
        parts.append(table(values, most=MOST_ROWS))
    return parts


def _by_group(values: pd.DataFrame) -> pd.DataFrame:
    """Lay out the differences so that intervals and p stand on the page, whatever the groups."""

    def cell(row: Any, name: str) -> str:
        return f"{row[name]:.4g}" if pd.notna(row.get(name)) else ""

    rows = []
    for row in values.to_dict(orient="records"):
        of = [str(row[name]) for name in ("leg", "reference") if pd.notna(row.get(name))]
        leg = "" if of in ([], ["all"]) else f" {' to '.join(of)}"
        means = [f"{row[f'group_{k}']} {cell(row, f'mean_{k}')} ({row[f'n_animals_{k}']})"
                 for k in "ab"]  # fmt: skip
        low, high = cell(row, "ci_low"), cell(row, "ci_high")
        interval = f" ({low} to {high})" if low and high else ""
        p = {name: cell(row, own) for own, name in _P_OF_GROUPS.items()}
        differs = cell(row, "difference") + interval
        own = {"measure": f"{row['measure']}{leg}", "means (animals)": "; ".join(means)}
        rows.append({**own, "second less first (95 % interval)": differs, **p})
    return pd.DataFrame(rows)


def _by_leg(values: pd.DataFrame) -> pd.DataFrame:
    """Put the means of measures side by side, a column a leg, with their intervals."""
    values = values.dropna(subset=["mean"]).reindex(columns=[*_LEG_COLUMNS])
    cells = [
        f"{mean:.4g}" + (f" ({low:.4g} to {high:.4g})" if pd.notna(low) and pd.notna(high) else "")
        for mean, low, high in values[["mean", "ci_low", "ci_high"]].itertuples(index=False)
    ]
    by_leg = values.assign(cell=cells).pivot_table(
        index="measure", columns="leg", values="cell", aggfunc="first", sort=False
    )
    return by_leg.fillna("").reset_index()


def _figures(folder: Path) -> list[str]:
    """Embed the figures."""
    found = sorted((folder / "figures").glob("*.png"), key=lambda path: figure_order(path.stem))
    return [picture(embedded(path), figure_words(path.stem), file=path) for path in found]


def _provenance(folder: Path) -> str:
    """Name command, versions and inputs with their checksums."""
    manifest = read_manifest(folder)
    steps = [] if manifest is None else manifest.steps_of("gait")
    parts = []
    for step in steps:
        if step["command"]:
            parts.append(f"<p><code>{text(step['command'])}</code></p>")
        inputs = pd.DataFrame(list(step["inputs"].items()), columns=["input", "checksum"])
        parts.append(table(inputs))
        versions = ", ".join(f"{name} {number}" for name, number in step["versions"].items())
        parts.append(f'<p class="small">{text(versions)}</p>')
    return "\n".join(parts)
