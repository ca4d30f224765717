"""``index.html`` of a folder of gait results: notes first, then what each file is, then figures."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from pawnb.workflow.provenance.report.html import beside, link, listed, page, picture, text
from pawnb.workflow.provenance.report.words import FILES, figure_order, figure_words

INDEX_FILE = "index.html"
_HOW_TO_CHECK = (
    "To check them: pawnb reproduce . in this folder makes each file again from the inputs that "
    "provenance.json names, and says whether it is the same. Where the inputs lie elsewhere: "
    "pawnb reproduce . --inputs FOLDER."
)


def index_page(
    files: Sequence[Path], folder: Path, *, notes: pd.DataFrame, paragraphs: Sequence[str]
) -> str:
    """Write the page that says what a run has left in its folder.

    Parameters
    ----------
    files : sequence of Path
        Every file of the run.
    folder : Path
        The folder.
    notes : pandas.DataFrame
        ``where, what, rows``: what a reader must know.
    paragraphs : sequence of str
        The methods, in prose.

    Returns
    -------
    str
        HTML with links relative to the folder.
    """
    names = [file.relative_to(folder).as_posix() for file in files] + ["provenance.json"]
    tables = [name for name in names if "/" not in name]
    figures = sorted(
        (n.removesuffix(".png") for n in names if n.endswith(".png")), key=figure_order
    )
    rows = "".join(
        f"<tr><td>{link(name, name)}</td><td>{text(FILES.get(name, ''))}</td></tr>"
        for name in sorted(tables)
    )
    said = note_lines(notes)
    body = [
        "<h2>Notes</h2>",
        listed(said, kind="notes") if said else "<p>None.</p>",
        "<h2>What was done</h2>",
        *(f"<p>{text(paragraph)}</p>" for paragraph in paragraphs),
        "<h2>Files</h2>",
        f"<table><tbody>{rows}</tbody></table>",
        f"<p>{text(_HOW_TO_CHECK)}</p>",
    ]
    if figures:
        body.append("<h2>Figures</h2>")
    for name in figures:
        endings = [end for end in ("pdf", "svg", "png", "csv") if f"{name}.{end}" in names]
        words = figure_words(Path(name).name)
        body.append(picture(beside(f"{name}.png"), words, file=folder / f"{name}.png"))
        links = " ".join(link(f"{name}.{end}", end) for end in endings)
        body.append(f'<p class="small">{links}</p>')
    return page("Gait", body)


def note_lines(notes: pd.DataFrame) -> list[str]:
    """Return notes as lines: where, what.

    Parameters
    ----------
    notes : pandas.DataFrame
        ``where, what, rows``.

    Returns
    -------
    list of str
        A line a note.
    """
    lines = []
    for where, what, rows in notes.fillna("").astype(str).itertuples(index=False, name=None):
        place = f"{where}{f', rows {rows}' if rows else ''}"
        lines.append(f"{place}: {what}" if place else what)
    return lines
