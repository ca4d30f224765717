"""Tables whose cells are separated by semicolons or tabs, their decimal mark perhaps a comma."""

from __future__ import annotations

import csv
import io
import re

from pawnb.errors import InputError

_DECIMAL_COMMA = re.compile(r"\s*[+-]?\d*,\d+(?:[eE][+-]?\d+)?\s*")
_DECIMAL_POINT = re.compile(r"\s*[+-]?(?:\d+\.\d*|\.\d+)(?:[eE][+-]?\d+)?\s*")
_THOUSANDS = re.compile(r"\s*[+-]?[1-9]\d{0,2}(?:,\d{3})+\s*")
_TOLD = re.compile(r"sep=.\r?(\n|$)")
"""A first line that tells Excel what separates the cells; it is no row."""
_WORDS = {";": "semicolons", "\t": "tabs"}
_MENDED = "save it as csv with commas between the cells and points in the numbers"


def header_lines(text: str) -> list[str]:
    """Return the lines of the beginning of a table, without one that tells its separator only.

    Parameters
    ----------
    text : str
        Its beginning.

    Returns
    -------
    list of str
        The lines.
    """
    return _TOLD.sub("", text, count=1).splitlines() if _TOLD.match(text) else text.splitlines()


def separator_of(line: str) -> str:
    """Return what separates the cells of a table, told by a line of it.

    Parameters
    ----------
    line : str
        The names of its columns, or its first row.

    Returns
    -------
    str
        ``","``, ``";"`` or a tab: what is there more often than commas are, those of decimals
        not counted.
    """
    for mark in _WORDS:
        cells = line.split(mark)
        commas = sum(cell.count(",") for cell in cells if not _DECIMAL_COMMA.fullmatch(cell))
        if len(cells) - 1 > commas:
            return mark
    return ","


def with_commas(
    text: str, *, where: str, first: int = 0, error: type[InputError] = InputError
) -> str:
    """Return a table with commas between its cells and points in its numbers.

    Parameters
    ----------
    text : str
        The whole table.
    where : str
        How messages name the file.
    first : int
        Line that tells what separates cells; those before it stay as they are.
    error : type
        Kind of InputError to raise.

    Returns
    -------
    str
        The same text where commas separate its cells.

    Raises
    ------
    InputError
        If it is not to be told which sign is the decimal mark.
    """
    above = "".join(f"{line}\n" for line in text.split("\n", first)[:first])
    body = text[len(above) :]
    told = _TOLD.match(body)
    body = body[told.end() :] if told else body
    mark = separator_of(body[: body.find("\n") + 1 or None])
    if mark == ",":
        return above + body
    try:
        rows = list(csv.reader(io.StringIO(body), delimiter=mark))
    except csv.Error:
        raise error(f"{where}: not a table; {_MENDED}.") from None
    cells = {cell for row in rows for cell in row if "," in cell}
    commas = {cell for cell in cells if _DECIMAL_COMMA.fullmatch(cell)}
    if commas:
        _check_decimals(rows, commas, mark, where=where, error=error)
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerows(
        [cell.replace(",", ".") if cell in commas else cell for cell in row] for row in rows
    )
    return above + out.getvalue()


def _check_decimals(
    rows: list[list[str]], commas: set[str], mark: str, *, where: str, error: type[InputError]
) -> None:
    """Refuse numbers of which it is not to be told whether a comma begins their decimals.

    No program that separates cells by semicolons writes commas between thousands.
    """
    line, point = next(
        ((i, cell) for i, row in enumerate(rows, start=1) for cell in row
         if _DECIMAL_POINT.fullmatch(cell)),
        (0, ""),
    )  # fmt: skip
    if point:
        raise error(
            f"{where}: numbers with points and with commas, such as {point.strip()} in line {line} "
            f"and {min(commas).strip()}; cells are separated by {_WORDS[mark]}, and which of the "
            f"two is the decimal mark is not told: {_MENDED}."
        )
    if mark == "\t" and all(_THOUSANDS.fullmatch(cell) for cell in commas):
        raise error(
            f"{where}: numbers with commas, such as {min(commas).strip()}, which may be thousands "
            f"or decimals; cells are separated by tabs: {_MENDED}."
        )
