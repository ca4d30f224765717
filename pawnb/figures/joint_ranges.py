"""How far the joints of each pair of legs move (paper 2009, Tables 4.6 and 5.1)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from pawnb.figures.panels import draw_points, make_panels
from pawnb.figures.style import OKABE_ITO, get_style, mark_animals, small_pt, style
from pawnb.gait.joints import RANGE_COLUMNS, joint_extremes, joint_range_table
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments

COLUMNS = ("row", "animal", "max_deg", "min_deg", *RANGE_COLUMNS)
JOINT_NAMES = {
    "BC": "Body-coxa", "CT": "Coxa-trochanter", "TF": "Trochanter-femur", "FP": "Femur-patella",
    "PT": "Patella-tibia", "TM": "Tibia-metatarsus", "MT": "Metatarsus-tarsus",
}  # fmt: skip


@checked_arguments
def build_joint_ranges_table(
    angles: pd.DataFrame, *, mechanical: pd.DataFrame | None = None, trim: float = 0.0
) -> pd.DataFrame:
    """Gather the joints' extremes, animal by animal and their means.

    Parameters
    ----------
    angles : pandas.DataFrame
        From :func:`pawnb.gait.joints.get_joint_angles`.
    mechanical : pandas.DataFrame, optional
        What each joint could move: see :func:`pawnb.gait.joints.joint_range_table`.
    trim : float
        Share of the frames left out at each end.

    Returns
    -------
    pandas.DataFrame
        ``row`` is ``mean`` (the columns of ``joint_range_table``) or ``animal`` (``animal,
        max_deg, min_deg``, with joint and pair). Joints that never move, as those held fixed
        in a model, are left out.

    Raises
    ------
    InputError
        If there is no angle or a column is missing.

    Examples
    --------
    >>> angles = pawnb.gait.joints.get_joint_angles(study.runs[0].tracks(), smooth=True)
    >>> table = figures.build_joint_ranges_table(angles)
    >>> "BC" in set(table["joint"])
    True
    """
    means = joint_range_table(angles, mechanical=mechanical, trim=trim).assign(row="mean")
    means = means[means.groupby("joint")["range_mean_deg"].transform("max") > 0.0]
    extremes = joint_extremes(angles, trim=trim)
    single = extremes.groupby(["joint", "pair", "animal"], sort=True)[["max_deg", "min_deg"]]
    own = single.mean().reset_index().assign(row="animal")
    own = own[own["joint"].isin(means["joint"])]
    return pd.concat([means, own], ignore_index=True).reindex(columns=list(COLUMNS))


@checked_arguments
def plot_joint_ranges(
    table: pd.DataFrame, *, ax: Axes | None = None, names: Mapping[str, str] | None = None
) -> Axes:
    """Draw the range of each joint by pair of legs, a panel for each joint.

    A bar reaches from the mean least to the mean greatest angle, whiskers are one standard
    deviation over animals, points are animals. Behind it, pale, is what the joint could move,
    where that is known; the number is the share of it that is used.

    Parameters
    ----------
    table : pandas.DataFrame
        From :func:`build_joint_ranges_table`.
    ax : matplotlib.axes.Axes, optional
        Where to draw a single joint; default a new figure.
    names : mapping, optional
        What joints are called; default the full names of a spider's.

    Returns
    -------
    matplotlib.axes.Axes
        The first panel; all are in ``ax.figure.axes``.

    Raises
    ------
    InputError
        If a column is missing, the table is empty, or ``ax`` is given for several joints.

    Examples
    --------
    >>> get = pawnb.gait.joints.get_joint_angles
    >>> angles = pd.concat([get(run.tracks(), smooth=True) for run in study.runs[:2]])
    >>> ax = figures.plot_joint_ranges(figures.build_joint_ranges_table(angles))
    """
    check_columns(table, COLUMNS, where="joint ranges")
    joints = [own for _, own in table.groupby("joint", sort=False)]
    called = {**JOINT_NAMES, **(names or {})}
    with style():
        panels = make_panels(len(joints), where="joint ranges", ax=ax, height_mm=48.0, columns=2)
        font_pt = get_style().font_size_pt
        marks = mark_animals(table.loc[table["row"] == "animal", "animal"])
        for panel, own in zip(panels, joints, strict=True):
            _draw(panel, own, marks)
            joint = str(own["joint"].iloc[0])
            # in the middle and larger, long names would run into the letter of the panel
            panel.set_title(called.get(joint, joint), loc="right", fontsize=font_pt)
            panel.set_ylabel("Angle (°)")
            panel.set_xlabel("Pair of legs")
    return panels[0]


def _draw(ax: Any, own: pd.DataFrame, marks: Mapping[str, Any]) -> None:
    """Draw one joint."""
    means = own[own["row"] == "mean"].reset_index(drop=True)
    place = {pair: k for k, pair in enumerate(means["pair"])}
    at = np.arange(len(means))
    low, high = means["mechanical_low_deg"], means["mechanical_high_deg"]
    if low.notna().any():
        ax.bar(at, high - low, bottom=low, width=0.8, color="0.9", linewidth=0.0, zorder=0)
    ax.bar(at, means["range_mean_deg"], bottom=means["min_mean_deg"], width=0.5,
           color=OKABE_ITO["sky blue"], linewidth=0.0, zorder=1)  # fmt: skip
    for end in ("max", "min"):
        ax.errorbar(at - 0.12, means[f"{end}_mean_deg"], yerr=means[f"{end}_sd_deg"],
                    linestyle="none", color="black", linewidth=0.7, capsize=1.5)  # fmt: skip
    for animal, points in own[own["row"] == "animal"].groupby("animal", sort=True):
        x = points["pair"].map(place).to_numpy(dtype=float) + 0.12
        for end in ("max_deg", "min_deg"):
            draw_points(ax, x, points[end], mark=marks[str(animal)], markersize=2.2, zorder=3)
    ax.axhline(0.0, color="0.5", linewidth=0.5)
    ax.set_xticks(at, means["pair"])
    ax.tick_params(axis="x", length=0)
    ends = own[["max_deg", "min_deg", "mechanical_low_deg", "mechanical_high_deg"]]
    values = ends.to_numpy(dtype=float)
    bottom, top = float(np.nanmin(values)), float(np.nanmax(values))
    room = 0.14 * (top - bottom)
    bottom, top = min(bottom, 0.0) - 0.4 * room, max(top, 0.0) + room
    ax.set_ylim(bottom, top)
    for k, share in enumerate(means["share_percent"]):
        if math.isfinite(share):
            ax.text(k, top, f"{share:.0f} %", ha="center", va="top", fontsize=small_pt())
