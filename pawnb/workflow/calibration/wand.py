"""``pawnb calibrate --wand``: views calibrated by the two ends of a wand that were tracked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pawnb.core.calibration.rig_from_wand import WandFit, WandSightings, calibrate_by_wand
from pawnb.core.dlt import triangulate
from pawnb.core.lens import Lens, load_lenses
from pawnb.errors import InputError, did_you_mean
from pawnb.io.cameras import coefs_of_cameras
from pawnb.io.tables import read_cells, read_numbers
from pawnb.workflow.calibration.written import Written, write_calibration

WAND_COLUMNS = ("frame", "view", "point", "u", "v")


@dataclass(frozen=True, kw_only=True)
class WandCalibration:
    """Views calibrated by a wand.

    Parameters
    ----------
    fit : WandFit
        The cameras, and the error of each place of the wand; frames are those of the table.
    lengths : ndarray
        Lengths of the wand as triangulated, in its unit.
    length : float
        What they should be.
    written : Written or None
        The files.
    """

    fit: WandFit
    lengths: np.ndarray
    length: float
    written: Written | None

    @property
    def views(self) -> pd.DataFrame:
        """A row a view: ``view, n_frames, rms_px, worst_px, focal_px``."""
        rows = []
        for camera in self.fit.cameras:
            own = self.fit.errors[self.fit.errors["view"] == camera.name]
            error = own.loc[~own["set_aside"], "error_px"].to_numpy()
            rows.append(
                {"view": camera.name, "n_frames": len(error),
                 "rms_px": float(np.sqrt(np.mean(error**2))), "worst_px": float(error.max()),
                 "focal_px": float(camera.matrix[0, 0])}
            )  # fmt: skip
        return pd.DataFrame(rows)

    def remarks(self) -> list[str]:
        """Return sentences that name frames which were set aside."""
        said = []
        aside = self.fit.errors[self.fit.errors["set_aside"]]
        for view, rows in aside.groupby("view", sort=False):
            each = ", ".join(f"{r.frame} ({r.error_px:.1f} px)" for r in rows.itertuples())
            said.append(f"set aside in view {view!r}, as it does not agree with the others: {each}")
        return said

    def text(self) -> str:
        """Return the error of each view, remarks and the lines of ``trial.toml``."""
        lines = [
            f"{row.view}: {row.n_frames} frames of the wand, error of its ends {row.rms_px:.2f} px "
            f"RMS, at most {row.worst_px:.2f} px; focal length {row.focal_px:.0f} px"
            for row in self.views.itertuples()
        ]
        lines.append(
            f"in space: the wand of {self.length:g} is {np.median(self.lengths):.3f} long (median "
            f"of {len(self.lengths)}), SD {np.std(self.lengths):.3f}"
        )
        lines.append(
            "axes: z is up in the pictures, x to the right in the first view, zero amid the wands"
        )
        return "\n".join(lines + self.remarks() + (self.written.lines() if self.written else []))

    def table(self) -> dict[str, Any]:
        """Return what was found as plain values and tables."""
        return {
            "views": self.views,
            "frames": self.fit.errors,
            "length": self.length,
            "length_median": float(np.median(self.lengths)),
            "length_sd": float(np.std(self.lengths)),
            "remarks": self.remarks(),
            "files": self.written.files() if self.written else [],
        }


def calibrate_from_wand(
    ends: str | Path,
    length: float,
    *,
    sizes: Sequence[tuple[int, int]],
    out: str | Path | None = None,
    views: Sequence[str] | None = None,
    lenses: str | Path | None = None,
) -> WandCalibration:
    """Calibrate views by a wand of known length.

    Parameters
    ----------
    ends : str or Path
        A csv with ``frame, view, point, u, v``: where each view sees the two ends of the wand, px.
        ``tracks.csv`` of pawnb is one.
    length : float
        Distance of the two ends, in the unit that the calibration will have.
    sizes : sequence of (int, int)
        Width and height of the pictures, px: one for all views, or one a view.
    out : str or Path, optional
        The file to write, usually ``DLTcoefs.csv``.
    views : sequence of str, optional
        The order of the views; default that of the table.
    lenses : str or Path, optional
        ``lenses.toml`` of the views, for instance from a board. Without it focal lengths are found,
        and nothing is taken to bend.

    Returns
    -------
    WandCalibration
        The cameras, the error of each view, and the wand's length in space.

    Raises
    ------
    InputError
        If the table, the length, a size or a lens is wrong.
    CalibrationError
        If the wand does not determine the cameras, or was seen outside the pictures.
    """
    if not (np.isfinite(length) and length > 0):
        raise InputError(f"the wand is {length:g} long; expected a length above 0.")
    table = read_ends(ends)
    table = table[~table["set_aside"].to_numpy(bool)]
    names = _views(table, views, Path(ends).name)
    if len(sizes) not in (1, len(names)):
        raise InputError(
            f"{len(sizes)} sizes of pictures for {len(names)} views ({', '.join(names)}); give one "
            "for all, or one a view."
        )
    known = read_lenses(lenses, names)
    each = tuple(sizes) * (len(names) if len(sizes) == 1 else 1)
    fit = calibrate_ends(table, length, sizes=dict(zip(names, each, strict=True)), lenses=known)
    _, uv = _as_array(table, names)
    coefs, _ = coefs_of_cameras(fit.cameras)
    straight = [lens.straighten(uv[v]) for v, lens in enumerate(known)] if known else list(uv)
    xyz = triangulate(coefs, np.stack(straight, axis=-2), even=True).xyz
    lengths = np.linalg.norm(xyz[:, 0] - xyz[:, 1], axis=1)
    written = None if out is None else write_calibration(fit.cameras, out)
    return WandCalibration(
        fit=fit, lengths=lengths[np.isfinite(lengths)], length=length, written=written
    )


def read_ends(path: str | Path) -> pd.DataFrame:
    """Read a table of the two ends of a wand.

    Parameters
    ----------
    path : str or Path
        A csv with ``frame, view, point, u, v``; rows with 1 in a column ``set_aside`` are those
        that a person has set aside.

    Returns
    -------
    DataFrame
        ``frame, view, point, u, v, set_aside``, without places that are empty.

    Raises
    ------
    InputError
        If a column is missing, a cell is no number, there are not two points, or a row is there
        twice.
    """
    where = Path(path).name
    table = read_cells(path, WAND_COLUMNS)
    numbers = {name: read_numbers(table, name, where=where) for name in ("frame", "u", "v")}
    aside = table["set_aside"] == "1" if "set_aside" in table else False
    table = table.assign(**numbers, set_aside=aside).dropna(subset=["u", "v"])
    points = list(dict.fromkeys(table["point"]))
    if len(points) > 2:
        raise InputError(
            f"{where}: {len(points)} points ({', '.join(points[:5])}); expected two, the ends of "
            "the wand."
        )
    twice = table[table.duplicated(["frame", "view", "point"])]
    if len(twice):
        row = twice.iloc[0]
        raise InputError(
            f"{where}: frame {row['frame']:g}, view {row['view']}, point {row['point']} is there "
            "twice; keep one of them."
        )
    return table[[*WAND_COLUMNS, "set_aside"]]


def calibrate_ends(
    table: pd.DataFrame,
    length: float,
    *,
    sizes: Mapping[str, tuple[int, int]],
    lenses: tuple[Lens, ...] = (),
) -> WandFit:
    """Calibrate views by the ends of a wand.

    Parameters
    ----------
    table : DataFrame
        ``frame, view, point, u, v``.
    length : float
        Distance of the two ends.
    sizes : mapping of str to tuple of int
        Width and height of the picture of each view, px; their order is that of the cameras.
    lenses : tuple of Lens
        Lenses that are known, one a view.

    Returns
    -------
    WandFit
        The cameras, and the error of each place of the wand by frame.
    """
    _check_inside(table, sizes)
    frames, uv = _as_array(table, tuple(sizes))
    wand = WandSightings(
        names=tuple(sizes), sizes=tuple(sizes.values()), length=length, uv=uv, lenses=lenses
    )
    fit = calibrate_by_wand(wand)
    errors = fit.errors.assign(frame=frames[fit.errors["frame"].to_numpy(int)])
    return WandFit(cameras=fit.cameras, errors=errors)


def _check_inside(table: pd.DataFrame, sizes: Mapping[str, tuple[int, int]]) -> None:
    """Refuse ends of the wand that lie outside the pictures, whose size is then another."""
    for name, size in sizes.items():
        own = table[table["view"].astype(str) == name]
        for axis, most in zip("uv", size, strict=True):
            off = own[(own[axis] < -1.0) | (own[axis] > most + 1.0)]
            if len(off):
                row = off.iloc[0]
                raise InputError(
                    f"view {name!r}: {axis} is {row[axis]:g} in frame {row['frame']:g}, outside "
                    f"its picture of {size[0]} x {size[1]} px; give the width and height of the "
                    "pictures that were clicked, one a view where they differ."
                )


def _as_array(table: pd.DataFrame, names: tuple[str, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Return the frames, and both ends (n_views, n_frames, 2, 2)."""
    frames = np.unique(table["frame"].to_numpy(int))
    points = list(dict.fromkeys(table["point"]))
    uv = np.full((len(names), len(frames), 2, 2), np.nan)
    view = np.array([names.index(str(name)) for name in table["view"]], int)
    end = np.array([points.index(name) for name in table["point"]], int)
    at = np.searchsorted(frames, table["frame"].to_numpy(int))
    uv[view, at, end] = table[["u", "v"]].to_numpy(float)
    return frames, uv


def _views(table: pd.DataFrame, views: Sequence[str] | None, where: str) -> tuple[str, ...]:
    """Return the views in the order wanted."""
    found = tuple(dict.fromkeys(str(view) for view in table["view"]))
    if views is not None and sorted(views) != sorted(found):
        raise InputError(
            f"views {', '.join(views)} are named, but {where} has {', '.join(found)}; name each of "
            "these once."
        )
    return tuple(views or found)


def read_lenses(path: str | Path | None, names: Sequence[str]) -> tuple[Lens, ...]:
    """Read the lens of each view; none without a path."""
    if path is None:
        return ()
    found = load_lenses(path)
    for name in names:
        if name not in found:
            raise InputError(
                f"{Path(path).name}: no section [{name}]{did_you_mean(name, found)}; expected one "
                "for each view."
            )
    return tuple(found[name] for name in names)
