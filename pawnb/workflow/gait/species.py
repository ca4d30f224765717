"""Own animals among other species: speed against size (Pullar 2009, Figs. 4.3 and 4.4)."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd

from pawnb import figures
from pawnb.errors import InputError
from pawnb.figures.panels import with_unit
from pawnb.files import safe_name
from pawnb.gait.regression.scaling import per_animal
from pawnb.io.tables import read_cells, read_column_names, read_numbers
from pawnb.schema import shown
from pawnb.workflow.gait.drawing.drawings import Drawing, make_drawing
from pawnb.workflow.gait.study_tables import Fields

_PER_UNIT = {
    "kg": 1e3, "g": 1.0, "mg": 1e-3, "m": 1e3, "cm": 10.0, "mm": 1.0,
}  # fmt: skip
"""Grams, and mm."""
_SIZE_COLUMN = re.compile(r"(?P<what>mass|body_length|carapace)_(?P<unit>kg|g|mg|cm|mm|m)")
_SPEED = re.compile(r"(?P<most>max_)?speed_(?P<unit>mm|cm|m)_s")
_SPECIES_NEEDS = (
    "name, group, a size (such as mass_kg or carapace_cm) and a speed (such as speed_cm_s, or "
    "max_speed_m_s)"
)
_KNOWN_COLUMNS = ("file", "name", "group", "without")


@dataclass(frozen=True, kw_only=True)
class Species:
    """A table of other species beside which a study's animals are drawn.

    Parameters
    ----------
    path : Path
        A csv with a row a species: name, group, a size, a speed.
    name : str
        What the study's own animals are called.
    group : str
        The group (such as a family) they belong to.
    without : tuple of str
        Groups that are left out once each, to see whether a law rests on them.
    """

    path: Path
    name: str
    group: str
    without: tuple[str, ...] = ()


def species_of(row: Mapping[str, Any], path: Path) -> Species:
    """Return what ``[[species]]`` of a study says.

    Parameters
    ----------
    row : mapping
        Its fields.
    path : Path
        The study.

    Returns
    -------
    Species
        What it says.

    Raises
    ------
    InputError
        If a field is unknown, one that is needed is missing, or the file is none of species.
    """
    odd = [name for name in row if name not in _KNOWN_COLUMNS]
    without = row.get("without", [])
    if odd or not all(isinstance(row.get(name), str) for name in _KNOWN_COLUMNS[:3]):
        raise InputError(
            f"{path}: [[species]] is {shown(dict(row))}; expected file, name and group of your own "
            "animals, and perhaps without = [groups]."
        )
    if not (isinstance(without, list) and all(isinstance(name, str) for name in without)):
        raise InputError(f"{path}: [[species]] without is {shown(without)}; expected groups.")
    _columns_of(path.parent / row["file"])  # what is wrong with it is said before anything is read
    return Species(
        path=path.parent / row["file"], name=row["name"], group=row["group"],
        without=tuple(without),
    )  # fmt: skip


def species_drawings(
    strides: pd.DataFrame, fields: Fields, species: Sequence[Species], *, unit: str | None
) -> Iterator[Drawing]:
    """List the figures of the study's animals among other species.

    Parameters
    ----------
    strides : pandas.DataFrame
        Strides.
    fields : mapping
        (animal, trial) to its covariates.
    species : sequence of Species
        Tables of other species.
    unit : str or None
        Unit of lengths of the strides.

    Yields
    ------
    Drawing
        One a table.
    """
    for one in species:
        size, speed = _columns_of(one.path)
        build = partial(_scaling, strides, fields, one, unit=unit)
        words = "Maximal speed" if speed["most"] else "Speed"
        said = size["what"].replace("_", " ").capitalize()
        yield make_drawing(
            f"species_{safe_name(one.path.stem)}", "scaling", build,
            size_name=with_unit(said, size["unit"]),
            value_name=with_unit(words, f"{speed['unit']}/s"),
        )  # fmt: skip


def _columns_of(path: Path) -> tuple[re.Match[str], re.Match[str]]:
    """Return the columns of size and speed of a table of species."""
    names = read_column_names(path, expected=f"a csv with {_SPECIES_NEEDS}")
    sizes, speeds = (
        [found for name in names if (found := form.fullmatch(name))]
        for form in (_SIZE_COLUMN, _SPEED)
    )
    if len(sizes) != 1 or len(speeds) != 1 or not {"name", "group"} <= set(names):
        raise InputError(f"{path}: columns are {', '.join(names)}; expected {_SPECIES_NEEDS}.")
    return sizes[0], speeds[0]


def _scaling(
    strides: pd.DataFrame, fields: Fields, species: Species, *, unit: str | None
) -> pd.DataFrame:
    """Fit the species without and with the study's animals, which are one point."""
    size, speed = _columns_of(species.path)
    cells = read_cells(species.path, ("name", "group", size[0], speed[0]))
    where = species.path.name
    reference = cells[["name", "group"]].assign(
        **{name: read_numbers(cells, name, where=where) for name in (size[0], speed[0])}
    )
    own = pd.DataFrame(
        {"name": [species.name], "group": species.group, size[0]: _own_size(fields, size),
         speed[0]: _own_speed(strides, speed, unit)}
    )  # fmt: skip
    return figures.build_scaling_table(
        reference, own, size=size[0], value=speed[0], without=species.without
    )


def _own_size(fields: Fields, column: re.Match[str]) -> float:
    """Return the mean size of the study's animals in the unit of a column."""
    sizes: dict[str, float] = {}
    for (animal, _), own in fields.items():
        for name, value in own.items():
            found = _SIZE_COLUMN.fullmatch(str(name))
            if found and found["what"] == column["what"] and isinstance(value, int | float):
                sizes[animal] = float(value) * _PER_UNIT[found["unit"]] / _PER_UNIT[column["unit"]]
    absent = sorted({animal for animal, _ in fields} - set(sizes))
    if absent or not sizes:
        raise InputError(
            f"species: no {column['what']} with a unit (such as {column[0]}) of "
            f"{', '.join(absent) or 'any animal'}; write it into the study."
        )
    return sum(sizes.values()) / len(sizes)


def _own_speed(strides: pd.DataFrame, column: re.Match[str], unit: str | None) -> float:
    """Return the speed of the study's animals in the unit of a column.

    The mean of the animals' means; or the fastest trial of any animal, as the paper takes the
    single fastest speed of each species.
    """
    known = strides[strides["speed"].notna()]
    if unit not in _PER_UNIT or known.empty:
        raise InputError(
            f"species: speeds are in {unit or 'an unknown unit'} a second, or not known; expected "
            "mm, cm or m: calibrate, or give the scale."
        )
    statistic = "max" if column["most"] else "mean"
    own = per_animal(known, ["speed"], statistics=[statistic])["speed"]
    value = float(own.max() if column["most"] else own.mean())
    return value * _PER_UNIT[unit] / _PER_UNIT[column["unit"]]
