"""A rig fitted to known points and where they were clicked."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from pawnb.core import dlt
from pawnb.core.rig import Rig, unit_vector
from pawnb.errors import CalibrationError, InputError, did_you_mean
from pawnb.schema import check_columns


def fit_rig(
    points3d: pd.DataFrame,
    clicks: pd.DataFrame,
    *,
    unit: str = "mm",
    forward: Sequence[float] = (1.0, 0.0, 0.0),
    up: Sequence[float] = (0.0, 0.0, 1.0),
) -> tuple[Rig, pd.DataFrame]:
    """Calibrate views from points of known position that were clicked in them.

    Parameters
    ----------
    points3d : DataFrame
        Columns ``point, x, y, z``: the known positions.
    clicks : DataFrame
        Columns ``view, point, u, v``: where each view sees them, in px. A point that a view
        does not see is left out.
    unit : str
        Unit of x, y and z.
    forward, up : sequence of float
        Directions of travel and up; made unit vectors.

    Returns
    -------
    rig : Rig
        Views in the order in which they first appear in ``clicks``.
    residuals : DataFrame
        ``view, point, residual_px``: the reprojection error of each click.

    Raises
    ------
    InputError
        If a column is missing, or a point is given or clicked twice or is unknown.
    CalibrationError
        If the points seen by a view do not determine it; the view is named.
    """
    points3d = check_columns(points3d, ("point", "x", "y", "z"), where="points3d")
    clicks = check_columns(clicks, ("view", "point", "u", "v"), where="clicks")
    for table, keys, what in ((points3d, ["point"], "points3d"), (clicks, ["view", "point"], "clicks")):  # fmt: skip # noqa: E501
        twice = table[table.duplicated(keys)]
        if len(twice):
            name = ", ".join(str(twice.iloc[0][key]) for key in keys)
            raise InputError(f"{what}: {name} is there twice; keep one of them.")
    known = {str(p): xyz for p, xyz in zip(points3d["point"], _numbers(points3d, "xyz"), strict=True)}  # fmt: skip # noqa: E501
    for point in clicks["point"].astype(str):
        if point not in known:
            raise InputError(
                f"clicks: point {point!r} has no known position{did_you_mean(point, known)}; add "
                "it to points3d or remove the click."
            )
    columns, residuals, names = [], [], []
    for view, rows in clicks.groupby("view", sort=False):
        xyz = np.array([known[str(point)] for point in rows["point"]]).reshape(-1, 3)
        try:
            fit = dlt.fit_dlt(xyz, _numbers(rows, "uv"))
        except CalibrationError as error:
            raise CalibrationError(f"view {view!r}: {error}") from None
        names.append(str(view))
        columns.append(fit.coefs)
        residuals.append(rows[["view", "point"]].assign(residual_px=fit.residual_px))
    if not names:
        raise CalibrationError(
            "clicks: no click at all; click the calibration points in each view."
        )
    rig = Rig(tuple(names), np.stack(columns, axis=1), unit, unit_vector(forward), unit_vector(up))
    return rig, pd.concat(residuals, ignore_index=True)


def _numbers(table: pd.DataFrame, columns: str) -> np.ndarray:
    """Return columns as numbers; what is not one becomes NaN, which the fit refuses."""
    return np.stack([pd.to_numeric(table[c], errors="coerce").to_numpy(float) for c in columns], axis=1)  # fmt: skip # noqa: E501
