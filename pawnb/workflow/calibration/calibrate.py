"""``pawnb calibrate``: DLT coefficients from points of known position that were clicked."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from pawnb.core.calibration.doubts import doubt_points, tell_mirrored
from pawnb.core.calibration.rig_from_points import fit_rig
from pawnb.core.dlt import handedness
from pawnb.core.rig import Rig
from pawnb.errors import InputError
from pawnb.io.coefs import write_coefs
from pawnb.io.tables import read_cells, read_column_names, read_numbers

POINTS_COLUMNS = ("point", "x", "y", "z")
_NUMBER_IN_FILE = re.compile(r"[-+.\deE]+|nan", re.IGNORECASE)
CLICKS_COLUMNS = ("view", "point", "u", "v")


@dataclass(frozen=True)
class CalibrationFit:
    """A calibration, and how well it fits.

    Parameters
    ----------
    rig : Rig
        The calibrated views.
    residuals : DataFrame
        ``view, point, residual_px``: how far each click is from where its point appears.
    remarks : tuple of str
        What looks wrong: views that show space mirrored, clicks that are not on their point.
    """

    rig: Rig
    residuals: pd.DataFrame
    remarks: tuple[str, ...] = ()

    def text(self) -> str:
        """Return the reprojection error of each view and of each of its points, and remarks."""
        lines = []
        for view in self.rig.names:
            own = self.residuals[self.residuals["view"] == view]
            error = own["residual_px"].to_numpy()
            rms = np.sqrt(np.mean(error**2))
            lines.append(
                f"{view}: {len(own)} points, reprojection error {rms:.3f} px RMS, at most "
                f"{error.max():.3f} px"
            )
            each = zip(own["point"], error, strict=True)
            lines.append("  " + ", ".join(f"{point} {value:.3f}" for point, value in each))
        lines += [f"look: {remark}" for remark in self.remarks]
        return "\n".join(lines)


def calibrate(
    points3d: str | Path,
    clicks: str | Path,
    *,
    out: str | Path | None = None,
    views: Sequence[str] | None = None,
    unit: str = "mm",
) -> CalibrationFit:
    """Calibrate views from points of known position (2019 paper, Eq. 1 and section 4.4).

    Parameters
    ----------
    points3d : str or Path
        A csv with ``point, x, y, z``: the known positions. Six points or more must be seen in
        each view, not all in one plane.
    clicks : str or Path
        A csv with ``view, point, u, v``, px: where each view sees them. Points that a view
        does not see are left out, and so are rows with 1 in a column ``set_aside``.
    out : str or Path, optional
        The file to write, usually ``DLTcoefs.csv``: 11 rows, one column a view.
    views : sequence of str, optional
        The order of the views, which is that of the trial; default that of the clicks.
    unit : str
        Unit of x, y and z.

    Returns
    -------
    CalibrationFit
        The calibrated views, and the reprojection error of each click.

    Raises
    ------
    InputError
        If a file cannot be read, a cell is no number, or the views named are not those clicked.
    CalibrationError
        If the points seen by a view do not determine it; the view is named.
    """
    known = _read(points3d, POINTS_COLUMNS, ("x", "y", "z"))
    clicked = _read(clicks, CLICKS_COLUMNS, ("u", "v"))
    if "set_aside" in clicked:  # by the CalibrationDigitiser
        clicked = clicked[clicked["set_aside"] != "1"]
    rig, residuals = fit_rig(known, clicked, unit=unit)
    if views is not None:
        if sorted(views) != sorted(rig.names):
            raise InputError(
                f"views {', '.join(views)} are named, but {Path(clicks).name} has clicks in "
                f"{', '.join(rig.names)}; name each of these once."
            )
        rig = rig.subset(views)
    if out is not None:
        write_coefs(rig.coefs, out)
    return CalibrationFit(rig, residuals, _doubts(rig, known, clicked))


def _doubts(rig: Rig, known: pd.DataFrame, clicked: pd.DataFrame) -> tuple[str, ...]:
    """Return what looks wrong in views that were calibrated."""
    places = known.set_index(known["point"].astype(str))[list("xyz")]
    said = tell_mirrored(rig.names, handedness(rig.coefs, places.to_numpy(float)))
    for view in rig.names:
        own = clicked[clicked["view"].astype(str) == view]
        points = own["point"].astype(str).tolist()
        xyz, uv = places.loc[points].to_numpy(float), own[["u", "v"]].to_numpy(float)
        said += doubt_points(points, xyz, uv, view=view)
    return tuple(said)


def is_points(path: str | Path) -> bool:
    """Say whether a file is, or was meant to be, the table of known points.

    Parameters
    ----------
    path : str or Path
        The file.

    Returns
    -------
    bool
        True for a csv whose first line names a column.
    """
    if Path(path).suffix.lower() != ".csv":
        return False
    names = read_column_names(path, expected="a csv of known points, or a calibration")
    return any(name and not _NUMBER_IN_FILE.fullmatch(name) for name in names)


def _read(path: str | Path, columns: Sequence[str], numbers: Sequence[str]) -> pd.DataFrame:
    """Read a table whose named columns are numbers."""
    table = read_cells(path, columns)
    return table.assign(
        **{name: read_numbers(table, name, where=Path(path).name) for name in numbers}
    )
