"""Views calibrated while points of known position are clicked, each as soon as it can be."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from pawnb.core.calibration.view_from_points import ViewFit, fit_view
from pawnb.errors import CalibrationError, InputError
from pawnb.io.cameras_out import write_lenses
from pawnb.io.coefs import write_coefs
from pawnb.io.tables import read_cells, read_numbers
from pawnb.workflow.calibration.calibrate import POINTS_COLUMNS
from pawnb.workflow.calibration.written import Written

Clicks = Mapping[tuple[str, str], tuple[float, float]]
"""View and point to u and v, px of the picture as filmed."""


@dataclass(frozen=True)
class KnownPointFit:
    """What the clicks so far determine.

    Parameters
    ----------
    views : dict of str to ViewFit
        The views that they determine.
    reasons : dict of str to str
        Why they do not determine the others.
    """

    views: dict[str, ViewFit]
    reasons: dict[str, str]


def read_known_points(points: pd.DataFrame | str | Path) -> dict[str, np.ndarray]:
    """Read points of known position.

    Parameters
    ----------
    points : DataFrame, str or Path
        ``point, x, y, z``, or a csv with these columns.

    Returns
    -------
    dict of str to ndarray, shape (3,)
        Their positions by name, in the order of the table.

    Raises
    ------
    InputError
        If a column is missing, a cell is no number, or a point is there twice.
    """
    where = "points" if isinstance(points, pd.DataFrame) else Path(points).name
    table = points if isinstance(points, pd.DataFrame) else read_cells(points, POINTS_COLUMNS)
    for name in POINTS_COLUMNS:
        if name not in table:
            raise InputError(f"{where}: no column {name!r}; expected point, x, y, z.")
    table = table.astype({"point": str})
    if not isinstance(points, pd.DataFrame):
        table = table.assign(**{a: read_numbers(table, a, where=where) for a in "xyz"})
    names = table["point"].tolist()
    xyz = table[list("xyz")].to_numpy(float)
    twice = next((name for i, name in enumerate(names) if name in names[:i]), None)
    if twice is not None:
        raise InputError(f"{where}: point {twice!r} is there twice; keep one of them.")
    bad = next((n for n, place in zip(names, xyz, strict=True) if not np.isfinite(place).all()), "")
    if bad or not names:
        said = f"point {bad!r} has no position" if bad else "no point"
        raise InputError(f"{where}: {said}; expected point, x, y, z, all of them numbers.")
    return dict(zip(names, xyz, strict=True))


def fit_known_points(
    known: Mapping[str, np.ndarray],
    clicks: Clicks,
    *,
    sizes: Mapping[str, tuple[int, int]],
    bends: bool = False,
) -> KnownPointFit:
    """Calibrate each view that the clicks determine.

    Parameters
    ----------
    known : mapping of str to ndarray, shape (3,)
        Positions of the points.
    clicks : mapping
        View and point to u, v in px, without those set aside.
    sizes : mapping of str to tuple of int
        Width and height of the picture of each view, px.
    bends : bool
        Whether lenses bend straight lines; see
        :func:`pawnb.core.calibration.view_from_points.fit_view`.

    Returns
    -------
    KnownPointFit
        The views, and why others are not determined yet.
    """
    views, reasons = {}, {}
    for view, size in sizes.items():
        seen = {point: uv for (name, point), uv in clicks.items() if name == view}
        try:
            views[view] = fit_view(
                np.array([known[point] for point in seen]).reshape(-1, 3),
                np.array(list(seen.values()), float).reshape(-1, 2),
                size=size,
                bends=bends,
            )
        except CalibrationError as error:
            reasons[view] = str(error)
    return KnownPointFit(views, reasons)


def write_known_points(fit: KnownPointFit, out: str | Path) -> Written:
    """Write ``DLTcoefs.csv`` and, where lenses bend, ``lenses.toml``.

    Parameters
    ----------
    fit : KnownPointFit
        A fit that determines every view.
    out : str or Path
        The file of coefficients.

    Returns
    -------
    Written
        What was written.

    Raises
    ------
    CalibrationError
        If a view is not determined.
    """
    for view, reason in fit.reasons.items():
        raise CalibrationError(f"view {view!r}: {reason}")
    out = Path(out)
    coefs = np.stack([view.coefs for view in fit.views.values()], axis=1)
    write_coefs(coefs, out)
    cameras = [
        dataclasses.replace(one.camera, name=name)
        for name, one in fit.views.items()
        if one.camera is not None
    ]
    lenses = write_lenses(cameras, out.with_name("lenses.toml")) if cameras else None
    return Written(tuple(fit.views), coefs, np.zeros(3), out, lenses)


def worst_click(
    fit: KnownPointFit, clicks: Clicks, *, limit_px: float, aside: Collection[tuple[str, str]] = ()
) -> tuple[str, str, float] | None:
    """Return view, point and px of the click that fits worst, where it is beyond a limit.

    Parameters
    ----------
    fit : KnownPointFit
        The views.
    clicks : mapping
        All clicks.
    limit_px : float
        What may be.
    aside : collection of (str, str)
        Clicks that are set aside.

    Returns
    -------
    (str, str, float) or None
        The worst, or None where all are within the limit.
    """
    worst: tuple[str, str, float] | None = None
    for view, one in fit.views.items():
        own = [point for name, point in clicks if name == view and (name, point) not in aside]
        for point, error in zip(own, one.residual_px, strict=True):
            if error > (limit_px if worst is None else worst[2]):
                worst = (view, point, float(error))
    return worst
