"""The recipe that a figure or a table carries: in its own metadata, or in the list beside it."""

from __future__ import annotations

import html
import json
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pawnb.errors import InputError
from pawnb.files import check_file, read_bytes
from pawnb.workflow.provenance.manifest import MANIFEST, Manifest, read_manifest

_PDF_ESCAPES = {b"n": b"\n", b"r": b"\r", b"t": b"\t", b"b": b"\b", b"f": b"\f"}
_MOST_RECIPE_BYTES = 64 << 20


@dataclass(frozen=True, kw_only=True)
class Recipe:
    """What a file says of how it was made.

    Parameters
    ----------
    step : dict
        The record of the run; see :func:`pawnb.workflow.provenance.record.build_step`.
    name : str
        The file's name in the folder of results, such as ``figures/phase_rose.png``.
    style : dict
        Options of the style that a figure was drawn in, where they are not the usual ones.
    """

    step: dict[str, Any]
    name: str
    style: dict[str, Any]

    @property
    def kind(self) -> str:
        """The kind of run: gait, track or compare."""
        return str(self.step.get("step"))


def read_recipe(path: str | Path) -> Recipe:
    """Read how a file was made.

    Parameters
    ----------
    path : str or Path
        A figure (png, svg, pdf), which carries its recipe wherever it lies, or any other file of
        a folder of results, whose ``provenance.json`` has it.

    Returns
    -------
    Recipe
        The recipe.

    Raises
    ------
    InputError
        If there is no such file, or it carries none.
    """
    if not Path(path).exists() and next(_listings(Path(path)), None) is not None:
        raise InputError(
            f"{path}: no such file, though {MANIFEST} lists it; put it back, or run anew what made "
            "it."
        )
    path = check_file(path, expected="a figure or a table that pawnb made")
    reader = _FIGURES.get(path.suffix.lower())
    text = None if reader is None else reader(path)
    if text is None:
        return _of_manifest(path)
    try:
        record = json.loads(text)
        kind, name = str(record.pop("figure")), record.pop("name", None)
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        raise InputError(
            f"{path}: its description is no recipe of pawnb's, so it cannot be made again."
        ) from None
    style = record.pop("style", {})
    if not isinstance(record.get("inputs"), dict) or "step" not in record:
        raise InputError(
            f"{path}: this figure ({kind}) does not say what it was drawn from; draw it anew with "
            "pawnb gait."
        )
    return Recipe(step=record, name=f"figures/{name or kind}{path.suffix.lower()}", style=style)


def _of_manifest(path: Path) -> Recipe:
    """Return the recipe of a file of a folder of results."""
    for manifest, name in _listings(path):
        run = manifest.files[name]["run"]
        steps = manifest.steps_of("gait" if run == "gait" else "track")
        if steps:
            first, *later = steps
            return Recipe(step=first | ({"later": later} if later else {}), name=name, style={})
    own = " Figures of a notebook carry theirs where pawnb.draw_figure saves them."
    raise InputError(
        f"{path}: nothing says how this file was made; expected a figure with its recipe, or a "
        f"file that a {MANIFEST} beside it lists.{own if path.suffix.lower() in _FIGURES else ''}"
    )


def _listings(path: Path) -> Iterator[tuple[Manifest, str]]:
    """Give the lists that name a file, beside it or above, with its name there."""
    for folder in path.absolute().parents[:2]:
        manifest = read_manifest(folder)
        name = path.absolute().relative_to(folder).as_posix()
        if manifest is not None and name in manifest.files:
            yield manifest, name


def _png_text(path: Path) -> str | None:
    """Return the description in a png."""
    from PIL import Image

    try:
        with Image.open(path) as picture:
            return picture.info.get("Description")
    except (OSError, ValueError, SyntaxError):
        raise InputError(f"{path}: cannot be read as a png; draw it anew.") from None


def _svg_text(path: Path) -> str | None:
    """Return the description in an svg."""
    data = read_bytes(path, most_bytes=_MOST_RECIPE_BYTES)
    found = re.search(rb"<dc:description>(.*?)</dc:description>", data, re.DOTALL)
    return None if found is None else html.unescape(found.group(1).decode(errors="replace"))


def _pdf_text(path: Path) -> str | None:
    """Return the subject in a pdf: a text in brackets, in which some signs are escaped."""
    data = read_bytes(path, most_bytes=_MOST_RECIPE_BYTES)
    if not data.startswith(b"%PDF"):
        raise InputError(f"{path}: cannot be read as a pdf; draw it anew.")
    found = re.search(rb"/Subject\s*\(((?:[^\\()]|\\.)*)\)", data, re.DOTALL)
    if found is None:
        return None

    def plain(escaped: re.Match[bytes]) -> bytes:
        sign = escaped.group(1)
        return bytes([int(sign, 8)]) if sign.isdigit() else _PDF_ESCAPES.get(sign, sign)

    raw = re.sub(rb"\\([0-7]{1,3}|.)", plain, found.group(1), flags=re.DOTALL)
    utf16 = raw.startswith(b"\xfe\xff")
    return raw.decode("utf-16" if utf16 else "latin-1", errors="replace")


_FIGURES: dict[str, Callable[[Path], str | None]] = {
    ".png": _png_text, ".svg": _svg_text, ".pdf": _pdf_text,
}  # fmt: skip
FIGURE_ENDINGS = tuple(_FIGURES)
"""Endings of the files that carry their recipe."""
