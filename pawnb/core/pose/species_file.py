"""Species files: a jointed animal described in TOML, built in or one's own.

One ``[[body]]`` an ellipse (name, centre, length, width) and one ``[[legs]]`` a pair of legs:
``left`` and ``right`` name them (one alone for a leg without a partner), ``attach`` is the
body-coxa joint of the right one (forward, right), ``segments`` and ``joints`` name them from
the body outwards, and ``lengths``, ``natural_deg`` and ``range_deg`` give one number each. A joint
whose range is 0 is fixed; ``free`` may name the joints that a tracker turns. ``widths`` (one
more than segments) may be left out. The files beside this module are examples.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from importlib import resources
from pathlib import Path
from typing import Any

from pawnb.core.pose.animal import LEFT, RIGHT, Ellipse, Leg, StickAnimal
from pawnb.errors import InputError, did_you_mean
from pawnb.files import MOST_TEXT_BYTES, parse_toml, read_text

_ANIMAL_KEYS = ("name", "title", "unit", "source", "body", "legs")
_BODY_KEYS = ("name", "centre", "length", "width")
_LEG_KEYS = (
    "left", "right", "attach", "segments", "joints", "lengths", "natural_deg", "range_deg",
    "free", "widths",
)  # fmt: skip
_NO_LEG_NAMES = ("body", "heading", "span")
"""What is tracked or dragged beside the legs has these names."""
_WIDTH_OF_LENGTH = (0.055, 0.02)
"""Thickness of a leg at the body and at the tip, as shares of its length, where none is given."""


def built_in_species() -> tuple[str, ...]:
    """Return the names of the species files that come with pawnb."""
    folder = resources.files("pawnb.core.pose.species")
    return tuple(
        sorted(p.name.removesuffix(".toml") for p in folder.iterdir() if p.name.endswith(".toml"))
    )


def load_species(species: str | Path, *, folder: Path | None = None) -> StickAnimal:
    """Read a species file.

    Parameters
    ----------
    species : str or Path
        A built-in species (:func:`built_in_species`), or the path of a species file.
    folder : Path, optional
        Folder that a relative path is relative to.

    Returns
    -------
    StickAnimal
        The animal.

    Raises
    ------
    InputError
        For an unknown species, a file that cannot be read, or an animal that cannot be: a
        missing or unknown name, lists of unequal length, a length that is not positive, a
        range below 0 or above 360 degrees, two legs of one name, a leg without a free joint.
    """
    names = built_in_species()
    if str(species) in names:
        text = (resources.files("pawnb.core.pose.species") / f"{species}.toml").read_text("utf-8")
        return parse_species(text, where=f"{species}.toml")
    path = Path(species) if folder is None else folder / species
    if not path.exists():
        raise InputError(
            f"species {str(species)!r}{did_you_mean(str(species), names)}: neither a built-in "
            f"species ({', '.join(names)}) nor a file."
        )
    text = read_text(path, expected="a species file", most_bytes=MOST_TEXT_BYTES)
    return parse_species(text, where=path.name)


def parse_species(text: str, *, where: str = "species file") -> StickAnimal:
    """Make a stick animal from the text of a species file.

    Parameters
    ----------
    text : str
        TOML.
    where : str
        Name of the file for messages.

    Returns
    -------
    StickAnimal
        The animal.

    Raises
    ------
    InputError
        As :func:`load_species`.
    """
    raw = parse_toml(text, where=where)
    _check_keys(raw, _ANIMAL_KEYS, ("body", "legs"), where)
    body, pairs = raw["body"], raw["legs"]
    for name, tables in (("body", body), ("legs", pairs)):
        if not (isinstance(tables, list) and tables and all(isinstance(t, dict) for t in tables)):
            raise InputError(f"{where}: {name} is not a list of tables; write [[{name}]].")
    legs = [leg for pair in pairs for leg in _read_pair(pair, where)]
    names = [leg.name for leg in legs]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"{where}: two legs are called {name!r}; give each its own name.")
    # the usual order of tables: the left legs from front to rear, then the right ones
    legs.sort(key=lambda leg: leg.side)
    return StickAnimal(
        name=str(raw.get("name", where.removesuffix(".toml"))),
        title=str(raw.get("title", "")),
        unit=str(raw.get("unit", "mm")),
        source=str(raw.get("source", "")),
        body=tuple(_read_ellipse(part, where) for part in body),
        legs=tuple(legs),
    )


def _read_ellipse(part: Mapping[str, Any], where: str) -> Ellipse:
    """Return one part of the body."""
    what = f"{where}: body {part.get('name', '?')!r}"
    _check_keys(part, _BODY_KEYS, _BODY_KEYS, what)
    centre = _numbers(part, "centre", 2, what)
    sizes = [_number(part[name], f"{what}: {name}") for name in ("length", "width")]
    for name, size in zip(("length", "width"), sizes, strict=True):
        if size <= 0:
            raise InputError(f"{what}: {name} is {size:g}; expected a number above 0.")
    return Ellipse(
        name=str(part["name"]), centre=(centre[0], centre[1]), length=sizes[0], width=sizes[1]
    )


def _read_pair(pair: Mapping[str, Any], where: str) -> list[Leg]:
    """Return the one or two legs of a table."""
    named = [(side, pair[key]) for key, side in (("left", LEFT), ("right", RIGHT)) if key in pair]
    if not named:
        raise InputError(f"{where}: a [[legs]] table names no leg; give it left, right or both.")
    what = f"{where}: leg {named[0][1]}"
    needed = ("attach", "segments", "joints", "lengths", "natural_deg", "range_deg")
    _check_keys(pair, _LEG_KEYS, needed, what)
    joints = tuple(str(name) for name in _list(pair, "joints", what))
    n = len(joints)
    segments = tuple(str(name) for name in _list(pair, "segments", what))
    if len(segments) != n:
        raise InputError(
            f"{what}: {len(segments)} segments but {n} joints; each segment turns about one joint."
        )
    for kind, names in (("segment", segments), ("joint", joints)):
        if len(set(names)) < n:
            raise InputError(f"{what}: two {kind}s have one name ({', '.join(names)}).")
    _check_names([str(name) for _, name in named], joints, what)
    attach, lengths = _read_attach(pair, what), _numbers(pair, "lengths", n, what)
    for segment, length in zip(segments, lengths, strict=True):
        if length <= 0:
            raise InputError(
                f"{what}: segment {segment} is {length:g} long; expected a number above 0."
            )
    natural, ranges = (_numbers(pair, key, n, what) for key in ("natural_deg", "range_deg"))
    _check_joints(joints, natural, ranges, what)
    total = sum(lengths)
    ends = [share * total for share in _WIDTH_OF_LENGTH]
    taper = [ends[0] + (ends[1] - ends[0]) * i / n for i in range(n + 1)]
    widths = _numbers(pair, "widths", n + 1, what) if "widths" in pair else taper
    if min(widths) <= 0:
        raise InputError(f"{what}: a width is {min(widths):g}; expected numbers above 0.")
    free = _free_joints(pair, joints, ranges, what)
    return [
        Leg(
            name=str(name),
            side=side,
            attach=(attach[0], side * attach[1]),
            segments=segments,
            joints=joints,
            lengths=tuple(lengths),
            natural_deg=tuple(natural),
            range_deg=tuple(ranges),
            free=free,
            widths=tuple(widths),
        )
        for side, name in named
    ]


def _read_attach(pair: Mapping[str, Any], what: str) -> list[float]:
    """Return where the right leg of a pair meets the body."""
    attach = _numbers(pair, "attach", 2, what)
    if attach[1] < 0:
        raise InputError(
            f"{what}: attach is {attach}, which puts the right leg on the left side; its second "
            "number counts to the animal's right, so expected 0 or more. The left leg mirrors it."
        )
    return attach


def _check_names(legs: Sequence[str], joints: Sequence[str], what: str) -> None:
    """Refuse names by which points (``L1.BC``) and columns (``L1_BC``) cannot be told."""
    for name in (*legs, *joints):
        if not name.strip() or "." in name:
            raise InputError(
                f"{what}: {name!r} cannot name a leg or a joint; expected a name without a dot."
            )
    for name in joints:
        if "_" in name:
            raise InputError(
                f"{what}: {name!r} cannot name a joint; expected a name without _: its column is "
                f"{legs[0]}_joint."
            )
    for name in legs:
        if name in _NO_LEG_NAMES:
            raise InputError(
                f"{what}: {name!r} is the name of something else ({', '.join(_NO_LEG_NAMES)}); "
                "give the leg another name."
            )


def _check_joints(
    joints: Sequence[str], natural: Sequence[float], ranges: Sequence[float], what: str
) -> None:
    """Refuse a joint that no animal can have."""
    for joint, middle, whole in zip(joints, natural, ranges, strict=True):
        if not 0 <= whole <= 360:
            raise InputError(
                f"{what}: joint {joint} has a range of {whole:g} degrees; expected the whole "
                "mechanical range, from 0 (fixed) to 360."
            )
        if not -180 <= middle <= 180:
            raise InputError(
                f"{what}: joint {joint} has a natural orientation of {middle:g} degrees; expected "
                "-180 to 180."
            )


def _free_joints(
    pair: Mapping[str, Any], joints: tuple[str, ...], ranges: Sequence[float], what: str
) -> tuple[bool, ...]:
    """Return which joints a tracker may turn."""
    if "free" in pair:
        wanted = [str(name) for name in _list(pair, "free", what)]
        for name in wanted:
            if name not in joints:
                raise InputError(
                    f"{what}: free names the joint {name!r}{did_you_mean(name, joints)}; "
                    f"its joints are {', '.join(joints)}."
                )
            if ranges[joints.index(name)] == 0:
                raise InputError(f"{what}: joint {name} is free but its range is 0 degrees.")
    else:
        wanted = [joint for joint, whole in zip(joints, ranges, strict=True) if whole > 0]
    if not wanted:
        raise InputError(f"{what}: no joint is free; a leg needs at least one.")
    return tuple(joint in wanted for joint in joints)


def _check_keys(
    table: Mapping[str, Any], known: Sequence[str], needed: Sequence[str], where: str
) -> None:
    """Refuse unknown names and say which are missing."""
    for name in table:
        if name not in known:
            raise InputError(
                f"{where}: unknown name {name!r}{did_you_mean(name, known)}; "
                f"known are {', '.join(known)}."
            )
    missing = [name for name in needed if name not in table]
    if missing:
        raise InputError(f"{where}: {', '.join(missing)} missing.")


def _list(table: Mapping[str, Any], name: str, what: str) -> list[Any]:
    """Return a list that is not empty."""
    value = table[name]
    if not isinstance(value, list) or not value:
        raise InputError(f"{what}: {name} is {value!r}; expected a list of one or more.")
    return value


def _numbers(table: Mapping[str, Any], name: str, n: int, what: str) -> list[float]:
    """Return a list of n numbers."""
    values = _list(table, name, what)
    if len(values) != n:
        raise InputError(f"{what}: {name} has {len(values)} numbers; expected {n}.")
    return [_number(value, f"{what}: {name}") for value in values]


def _number(value: Any, what: str) -> float:
    """Return a finite number."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise InputError(f"{what} holds {value!r}; expected a number.")
    return float(value)
