"""Paths of the feet and other points in calibrated space (paper 2019, Fig. 9)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

from pawnb.errors import InputError
from pawnb.figures.panels import open_grid, with_unit
from pawnb.figures.style import colour_legs, figure_size, small_pt, style
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments

COLUMNS = ("point", "frame", "x", "y", "z")


@checked_arguments
def build_paths_3d_table(
    points3d: pd.DataFrame,
    *,
    points: Sequence[str] | None = None,
    frames: tuple[int, int] | None = None,
) -> pd.DataFrame:
    """Choose the paths to show.

    Parameters
    ----------
    points3d : pandas.DataFrame
        ``POINTS3D_COLUMNS``, or frame, point, x, y, z.
    points : sequence of str, optional
        Points, in this order; default all that are ever seen.
    frames : tuple of int, optional
        First frame and one past the last; default all.

    Returns
    -------
    pandas.DataFrame
        ``point, frame, x, y, z``, point by point in the order of frames; a row for every
        frame from the first to the last of a point, NaN where it was not seen.

    Raises
    ------
    InputError
        If a column is missing, a point is not there, or nothing is left to show.

    Examples
    --------
    >>> points = pd.DataFrame({"frame": range(40), "point": "FR"})
    >>> points["x"] = 20.0 * np.cos(points["frame"] / 5.0)
    >>> points["y"] = 10.0
    >>> points["z"] = 4.0 * np.sin(points["frame"] / 5.0).clip(lower=0.0)
    >>> len(figures.build_paths_3d_table(points, frames=(0, 20)))
    20
    """
    check_columns(points3d, COLUMNS, where="points in space")
    table = points3d
    if frames is not None:
        table = table[(table["frame"] >= frames[0]) & (table["frame"] < frames[1])]
    seen = table[table[["x", "y", "z"]].notna().all(axis=1)]
    names = list(dict.fromkeys(seen["point"])) if points is None else list(points)
    parts = []
    for name in names:
        own = seen[seen["point"] == name]
        if len(own) == 0:
            raise InputError(
                f"paths: point {name!r} is never seen in these frames; there are "
                f"{', '.join(map(str, dict.fromkeys(seen['point']))) or 'none'}."
            )
        whole = np.arange(int(own["frame"].min()), int(own["frame"].max()) + 1)
        own = own.drop_duplicates("frame").set_index("frame")[["x", "y", "z"]].reindex(whole)
        parts.append(own.rename_axis("frame").reset_index().assign(point=name))
    if not parts:
        raise InputError("paths: no point is seen in space; they need a calibrated rig.")
    return pd.concat(parts, ignore_index=True)[list(COLUMNS)]


@checked_arguments
def plot_paths_3d(
    table: pd.DataFrame,
    *,
    ax: Any = None,
    unit: str | None = None,
    view_deg: tuple[float, float] = (22.0, -60.0),
) -> Any:
    """Draw the paths in perspective, from the side and from above, all axes to one scale.

    Parameters
    ----------
    table : pandas.DataFrame
        From :func:`build_paths_3d_table`.
    ax : matplotlib axes, optional
        The panels divide its place in its figure; default a new figure.
    unit : str, optional
        Unit of the positions.
    view_deg : tuple of float
        Elevation and azimuth of the eye, degrees.

    Returns
    -------
    matplotlib axes
        The first of three panels: in perspective; x and z; x and y.

    Raises
    ------
    InputError
        If a column is missing or the table is empty.

    Examples
    --------
    >>> points = pd.DataFrame({"frame": range(40), "point": "FR"})
    >>> points["x"] = 20.0 * np.cos(points["frame"] / 5.0)
    >>> points["y"] = 10.0
    >>> points["z"] = 4.0 * np.sin(points["frame"] / 5.0).clip(lower=0.0)
    >>> ax = figures.plot_paths_3d(figures.build_paths_3d_table(points), unit="mm")
    """
    check_columns(table, COLUMNS, where="paths")
    if len(table) == 0:
        raise InputError("paths: the table is empty.")
    names = [str(name) for name in dict.fromkeys(table["point"])]
    colours = colour_legs(names)
    with style():
        figure, grid = open_grid(
            2, 2, where="paths", size=figure_size(2, 70.0), ax=ax, width_ratios=[1.15, 1.0]
        )
        space: Any = figure.add_subplot(grid[:, 0], projection="3d")
        side = figure.add_subplot(grid[0, 1])
        above = figure.add_subplot(grid[1, 1])
        for name in names:
            own = table[table["point"] == name]
            x, y, z = (own[axis].to_numpy(dtype=float) for axis in "xyz")
            line: dict[str, Any] = {"color": colours[name], "linewidth": 0.8, "label": name}
            space.plot(x, y, z, **line)
            side.plot(x, z, **line)
            above.plot(x, y, **line)
        _finish_space(space, table, unit)
        space.view_init(elev=view_deg[0], azim=view_deg[1])
        for panel, up in ((side, "z"), (above, "y")):
            panel.set_aspect("equal", adjustable="datalim")
            panel.set_ylabel(with_unit(up, unit))
        above.set_xlabel(with_unit("x", unit))
        for letter, panel in zip("abc", (space, side, above), strict=True):
            panel.set_title(letter, loc="left", fontweight="bold")
        handles, words = side.get_legend_handles_labels()
        figure.legend(handles, words, loc="outside lower center", ncols=min(len(names), 8))
    return space


def _finish_space(ax: Any, table: pd.DataFrame, unit: str | None) -> None:
    """Give the three axes one scale, and show it by three short lines instead of numbers."""
    low, high = (getattr(table[["x", "y", "z"]], k)().to_numpy(dtype=float) for k in ("min", "max"))
    # a path in a plane has no height: the box keeps a twentieth of its length
    widest = float((high - low).max())
    box = np.maximum(high - low, 0.05 * widest if widest > 0 else 1.0)
    middle = (high + low) / 2.0
    ax.set_box_aspect(box.copy(), zoom=0.95)  # it scales the array it is given
    for k, axis in enumerate("xyz"):
        getattr(ax, f"set_{axis}lim")(middle[k] - 0.52 * box[k], middle[k] + 0.52 * box[k])
    ax.set_axis_off()
    power = 10.0 ** np.floor(np.log10(box.max() / 8.0))
    length = max(step * power for step in (1.0, 2.0, 5.0) if step * power <= box.max() / 8.0)
    corner = middle + [-0.5, -0.5, -0.5] * box - [0.0, 0.0, 1.6 * length]
    for k, axis in enumerate("xyz"):
        end = corner + length * np.eye(3)[k]
        ax.plot(*np.stack([corner, end], axis=-1), color="black", linewidth=0.8)
        ax.text(*(corner + 1.35 * length * np.eye(3)[k]), axis, ha="center", va="center")
    ax.text2D(0.5, 0.0, f"each line: {length:g} {unit or 'units'}", transform=ax.transAxes,
              ha="center", va="bottom", fontsize=small_pt())  # fmt: skip
