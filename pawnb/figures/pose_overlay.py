"""A tracked pose over its picture: body, legs and joints of a jointed animal in one frame."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from pawnb.arrays import ByteArray
from pawnb.errors import InputError
from pawnb.figures.panels import new_axes
from pawnb.figures.style import colour_legs, figure_size, style
from pawnb.gait.legs import sort_legs
from pawnb.schema import Tracks, check_columns, check_tracks
from pawnb.schema.arguments import checked_arguments

COLUMNS = ("frame", "leg", "joint", "u", "v")

TIP = "tip"
"""What the outer end of a leg is called in the table."""
_NAME_PT = 8.0
"""Distance of a leg's name from its tip."""
_MARGIN = 0.15


@checked_arguments
def build_pose_overlay_table(tracks: Tracks, *, frame: int) -> pd.DataFrame:
    """Take the joints of every leg in one frame out of Tracks.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks of a jointed animal: points ``L1`` (a tip) and ``L1.BC`` (a joint), from the body
        outwards.
    frame : int
        The frame.

    Returns
    -------
    pandas.DataFrame
        ``frame, leg, joint, u, v``, px: leg by leg from the body outwards; the last of a leg is
        its ``tip``.

    Raises
    ------
    InputError
        If the frame is not among those tracked, or no point is a joint of a leg.

    Examples
    --------
    >>> tracks = study.runs[0].tracks()
    >>> frame = int(tracks["frame"][len(tracks["frame"]) // 2])
    >>> table = figures.build_pose_overlay_table(tracks, frame=frame)
    >>> sorted(table["leg"].unique())[:2]
    ['L1', 'L2']
    """
    check_tracks(tracks)
    frames = tracks["frame"].to_numpy()
    if frame not in frames:
        raise InputError(
            f"frame {frame} is not tracked; choose one of {frames[0]} to {frames[-1]}."
        )
    points = [str(point) for point in tracks["keypoint"].to_numpy()]
    legs = sort_legs(point.partition(".")[0] for point in points if "." in point)
    if not legs or "image_position" not in tracks:
        raise InputError("pose overlay: no joints such as L1.BC; expected tracks of a pose.")
    here = tracks["image_position"].isel(
        time=int(np.flatnonzero(frames == frame)[0]), view=0, individual=0
    )
    uv = here.transpose("keypoint", "image_space").to_numpy()
    rows: list[tuple[Any, ...]] = []
    for leg in legs:
        chain = [point for point in points if point.startswith(f"{leg}.")]
        for point in (*chain, leg):
            joint = point.partition(".")[2] or TIP
            rows.append((frame, leg, joint, *uv[points.index(point)]))
    return pd.DataFrame(rows, columns=list(COLUMNS))


@checked_arguments
def plot_pose_overlay(
    table: pd.DataFrame, *, picture: ByteArray | None = None, ax: Axes | None = None
) -> Axes:
    """Draw a pose over its picture.

    Parameters
    ----------
    table : pandas.DataFrame
        From :func:`build_pose_overlay_table`.
    picture : ndarray, shape (H, W) or (H, W, 3), uint8, optional
        The frame.
    ax : matplotlib.axes.Axes, optional
        Where to draw; default a new figure, one column wide.

    Returns
    -------
    matplotlib.axes.Axes
        The axes, in px of the view, cut to the animal.

    Raises
    ------
    InputError
        If a column is missing, or no joint has a place.

    Examples
    --------
    >>> tracks = study.runs[0].tracks()
    >>> frame = int(tracks["frame"][len(tracks["frame"]) // 2])
    >>> ax = figures.plot_pose_overlay(figures.build_pose_overlay_table(tracks, frame=frame))
    """
    check_columns(table, COLUMNS, where="pose overlay")
    known = table.dropna(subset=["u", "v"])
    if known.empty:
        raise InputError("pose overlay: no joint has a place in this frame; choose another.")
    legs = list(dict.fromkeys(table["leg"]))
    with style():
        if ax is None:
            _, ax = new_axes(figsize=figure_size(1, 85.0))
        if picture is not None:
            ax.imshow(picture, cmap="gray", vmin=0, vmax=255)
        colours = colour_legs(legs)
        for leg, chain in known.groupby("leg", sort=False):
            ax.plot(
                chain["u"], chain["v"], "-o", color=colours[str(leg)], markersize=2.0, linewidth=1.2
            )
            places = chain[["u", "v"]].to_numpy(dtype=float)
            away = places[-1] - places[0]  # beyond the tip the name lies on no part of its leg
            right, down = away / (float(np.hypot(*away)) or 1.0) * _NAME_PT
            ax.annotate(
                str(leg), tuple(places[-1]), xytext=(right, -down), textcoords="offset points",
                color=colours[str(leg)], ha="center", va="center",
            )  # fmt: skip
        low, high = known[["u", "v"]].min(), known[["u", "v"]].max()
        room = _MARGIN * float((high - low).max())
        ax.set_xlim(low["u"] - room, high["u"] + room)
        ax.set_ylim(high["v"] + room, low["v"] - room)
        ax.set_aspect("equal")
        ax.set_xlabel("u (px)")
        ax.set_ylabel("v (px)")
    return ax
