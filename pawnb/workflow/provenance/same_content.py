"""In what two files of the same kind differ, in words."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pawnb.errors import InputError

_SHOWN = 3


def tell_difference(before: Path, now: Path) -> str | None:
    """Say in what a file that was made again differs from what it was.

    Parameters
    ----------
    before, now : Path
        The two files, of one kind.

    Returns
    -------
    str or None
        None where they are the same, byte for byte; else what differs, in words.
    """
    if before.read_bytes() == now.read_bytes():
        return None
    teller = _TELLERS.get(now.suffix.lower())
    try:
        found = None if teller is None else teller(before, now)
    except (OSError, ValueError, InputError, KeyError):
        found = "the file from before cannot be read any more"
    sizes = f"{before.stat().st_size} bytes before, {now.stat().st_size} now"
    return found or f"the content looks the same, but not every byte is ({sizes})"


def tell_versions(before: Mapping[str, str], now: Mapping[str, str]) -> str | None:
    """Say which packages have other versions than on record; None where all are the same."""
    other = [
        f"{name} {was} before, {now.get(name, 'not installed')} here"
        for name, was in before.items()
        if now.get(name) != was
    ]
    return "; ".join(other) if other else None


def _tables(before: Path, now: Path) -> str | None:
    """Compare two csv."""
    old, new = (
        pd.read_csv(path, dtype=str, keep_default_na=False, na_filter=False)
        for path in (before, now)
    )
    if list(old.columns) != list(new.columns):
        return f"columns {', '.join(old.columns)} before, {', '.join(new.columns)} now"
    if len(old) != len(new):
        return f"{len(old)} rows before, {len(new)} now"
    said = []
    for name in old.columns:
        other = (old[name] != new[name]).to_numpy()
        if other.any():
            a, b = (pd.to_numeric(t[name][other], errors="coerce") for t in (old, new))
            apart = np.abs(a - b).max()
            by = "" if np.isnan(apart) else f", by {apart:.3g} at most"
            said.append(f"{name} in {other.sum()} of {len(old)} rows{by}")
    return None if not said else _listed(said)


def _pictures(before: Path, now: Path) -> str | None:
    """Compare two png, pixels first."""
    from PIL import Image

    with Image.open(before) as one, Image.open(now) as two:
        if one.size != two.size:
            return f"{one.size[0]} x {one.size[1]} px before, {two.size[0]} x {two.size[1]} now"
        pixels = [np.asarray(p.convert("RGBA"), dtype=int) for p in (one, two)]
        recipes = [json.loads(p.info.get("Description", "{}")) for p in (one, two)]
    apart = np.abs(pixels[0] - pixels[1]).max(axis=2)
    if apart.any():
        return f"{(apart > 0).mean():.2%} of the pixels, by {apart.max()} of 255 at most"
    said = _keys(recipes[0], recipes[1])
    return f"the picture is the same, pixel for pixel; its recipe differs in {_listed(said)}"


def _documents(before: Path, now: Path) -> str | None:
    """Compare two json."""
    old, new = (json.loads(path.read_text(encoding="utf-8")) for path in (before, now))
    return _listed(_keys(old, new))


def _netcdf(before: Path, now: Path) -> str | None:
    """Compare two files of tracks, variable by variable."""
    from pawnb.io.native import read_tracks

    old, new = read_tracks(before), read_tracks(now)
    if dict(old.sizes) != dict(new.sizes):
        return f"sizes {dict(old.sizes)} before, {dict(new.sizes)} now"
    said = [
        str(name)
        for name in sorted(set(old.variables) | set(new.variables), key=str)
        if name not in old or name not in new or not old[name].equals(new[name])
    ]
    said += [f"attribute {name}" for name in _keys(old.attrs, new.attrs)]
    return _listed(said) if said else None


def _keys(old: Any, new: Any, at: str = "") -> list[str]:
    """Return the places at which two nested records differ."""
    if isinstance(old, Mapping) and isinstance(new, Mapping):
        names = dict.fromkeys([*old, *new])
        return [k for n in names for k in _keys(old.get(n), new.get(n), f"{at}.{n}".strip("."))]
    return [] if old == new else [at]


def _listed(said: list[str]) -> str:
    """Return some of many."""
    more = len(said) - _SHOWN
    return ", ".join(said[:_SHOWN]) + (f" and {more} more" if more > 0 else "")


_TELLERS: dict[str, Callable[[Path, Path], str | None]] = {
    ".csv": _tables, ".png": _pictures, ".json": _documents, ".nc": _netcdf,
}  # fmt: skip
