"""Pages that stand by themselves: text, tables and pictures as HTML, every sign escaped."""

from __future__ import annotations

import base64
import html
import math
from collections.abc import Iterable
from pathlib import Path
from urllib.parse import quote

import pandas as pd
from PIL import Image

_PX_PER_INCH = 140.0
MOST_ROWS = 60
"""Rows that a table of a page has at most; the csv beside it has all."""
_REPORT_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; color: #222; background: #fff; margin: 2em auto;
  max-width: 66em; padding: 0 1em; }
h1 { font-size: 1.6em; } h2 { font-size: 1.25em; margin-top: 2em; border-bottom: 1px solid #ccc; }
h3 { font-size: 1.05em; margin-bottom: .3em; }
table { border-collapse: collapse; font-size: .85em; margin: .6em 0; }
th, td { padding: .2em .5em; text-align: left; vertical-align: top; }
td { border-bottom: 1px solid #e4e4e4; } th { border-bottom: 2px solid #999; }
td.n { text-align: right; font-variant-numeric: tabular-nums; } .wide { overflow-x: auto; }
figure { margin: 1.2em 0; } figure img { max-width: 100%; height: auto; }
figcaption, .small { font-size: .85em; color: #555; } ul.notes li { margin-bottom: .3em; }
@media print { body { font-size: 10pt; max-width: none; margin: 0; } table { font-size: 7pt; }
  th, td { padding: .2em .4em; overflow-wrap: break-word; } .wide { overflow: visible; }
  tr, figure { break-inside: avoid; } h2, h3 { break-after: avoid; } }
"""


def page(title: str, body: Iterable[str]) -> str:
    """Return a whole page.

    Parameters
    ----------
    title : str
        Its title, as plain text.
    body : iterable of str
        Parts of the page, as HTML.

    Returns
    -------
    str
        HTML that needs no other file but the pictures it names.
    """
    said = text(title)
    head = f'<meta charset="utf-8"><title>{said}</title><style>{_REPORT_STYLE}</style>'
    inside = "\n".join(body)
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head>{head}</head>\n'
        f"<body>\n<h1>{said}</h1>\n{inside}\n</body></html>\n"
    )


def text(value: object) -> str:
    """Return a value as text in which no sign is one of HTML's."""
    return html.escape(str(value))


def link(path: str, words: str) -> str:
    """Return a link to a file beside the page, whatever signs its name has."""
    return f'<a href="./{quote(path)}">{text(words)}</a>'


def listed(items: Iterable[str], *, kind: str = "") -> str:
    """Return plain texts as a list."""
    of = f' class="{kind}"' if kind else ""
    return f"<ul{of}>" + "".join(f"<li>{text(item)}</li>" for item in items) + "</ul>"


def table(values: pd.DataFrame, *, most: int | None = None) -> str:
    """Return a table; numbers with four digits, missing values blank.

    Parameters
    ----------
    values : pandas.DataFrame
        The table.
    most : int, optional
        Rows at most; that there are more is said.

    Returns
    -------
    str
        HTML.
    """
    shown = values if most is None else values.head(most)
    # long names of columns may break where their words end, else a page is not wide enough
    head = "".join(f"<th>{text(name).replace('_', '_<wbr>')}</th>" for name in shown)
    rows = []
    for row in shown.itertuples(index=False, name=None):
        rows.append("<tr>" + "".join(_cell(value) for value in row) + "</tr>")
    more = len(values) - len(shown)
    said = f'<p class="small">and {more} more rows</p>' if more else ""
    return (
        f'<div class="wide"><table><thead><tr>{head}</tr></thead><tbody>{"".join(rows)}</tbody>'
        f"</table></div>{said}"
    )


def picture(source: str, caption: str, *, file: Path) -> str:
    """Return a picture with its caption.

    Parameters
    ----------
    source : str
        Of :func:`embedded` or :func:`beside`.
    caption : str
        What it shows, as plain text.
    file : Path
        The png, for its size in print: all are shown enlarged alike.

    Returns
    -------
    str
        HTML.
    """
    said = text(caption)
    with Image.open(file) as png:
        width = round(png.width / png.info.get("dpi", (96.0, 96.0))[0] * _PX_PER_INCH)
    shown = f'<img src="{source}" alt="{said}" width="{width}">'
    return f"<figure>{shown}<figcaption>{said}</figcaption></figure>"


def embedded(path: Path) -> str:
    """Return a png as a source that needs no file."""
    return "data:image/png;base64," + base64.b64encode(path.read_bytes()).decode("ascii")


def beside(path: str) -> str:
    """Return a picture beside the page as a source."""
    return f"./{quote(path)}"


def _cell(value: object) -> str:
    """Return one cell."""
    if value is None or value is pd.NA or (isinstance(value, float) and math.isnan(value)):
        return "<td></td>"
    if isinstance(value, bool):
        return f"<td>{'yes' if value else 'no'}</td>"
    if isinstance(value, float):
        return f'<td class="n">{value:.4g}</td>'
    return f'<td class="n">{value}</td>' if isinstance(value, int) else f"<td>{text(value)}</td>"
