"""Frames with the animal: sum of differences to an empty frame (paper 2009, Fig. 3.1)."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from pawnb.arrays import BoolArray, FloatArray, IntArray
from pawnb.errors import InputError
from pawnb.figures.panels import new_axes
from pawnb.figures.style import OKABE_ITO, figure_size, style
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments

COLUMNS = ("frame", "difference", "threshold", "has_animal")


@checked_arguments
def build_animal_presence_table(
    frames: IntArray, difference: FloatArray, *, threshold: float, has_animal: BoolArray
) -> pd.DataFrame:
    """Put the differences of all frames and the threshold in a table.

    Parameters
    ----------
    frames : array_like of int, shape (n,)
        Frame numbers.
    difference : array_like, shape (n,)
        Sum over the picture of the absolute differences to an empty frame, grey values.
    threshold : float
        Difference above which a frame shows the animal.
    has_animal : array_like of bool, shape (n,)
        What was decided for each frame.

    Returns
    -------
    pandas.DataFrame
        ``frame, difference, threshold, has_animal``, one row a frame.

    Raises
    ------
    InputError
        If the lengths differ, there is no frame, or the threshold is not a number.

    Examples
    --------
    >>> frames = np.arange(60)
    >>> difference = 3.0 + 80.0 * np.exp(-(((frames - 25.0) / 10.0) ** 4))
    >>> table = figures.build_animal_presence_table(
    ...     frames, difference, threshold=10.0, has_animal=difference > 10.0
    ... )
    >>> table.loc[table["has_animal"], "frame"].agg(["min", "max"]).tolist()
    [13, 37]
    """
    lengths = [len(frames), len(difference), len(has_animal)]
    if len(set(lengths)) > 1 or not lengths[0]:
        raise InputError(
            f"animal presence: {lengths[0]} frames, {lengths[1]} differences and {lengths[2]} "
            "decisions; expected one of each for every frame."
        )
    if not math.isfinite(threshold):
        raise InputError(f"animal presence: the threshold is {threshold}; expected a number.")
    return pd.DataFrame(
        {
            "frame": np.asarray(frames, dtype=int),
            "difference": np.asarray(difference, dtype=float),
            "threshold": float(threshold),
            "has_animal": np.asarray(has_animal, dtype=bool),
        }
    )


@checked_arguments
def plot_animal_presence(table: pd.DataFrame, *, ax: Axes | None = None) -> Axes:
    """Draw the differences over the recording, the threshold, and the frames with the animal.

    Parameters
    ----------
    table : pandas.DataFrame
        From :func:`build_animal_presence_table`.
    ax : matplotlib axes, optional
        Where to draw. Default: a new figure one column wide.

    Returns
    -------
    matplotlib axes
        The axes.

    Raises
    ------
    InputError
        If a column is missing or the table is empty.

    Examples
    --------
    >>> frames = np.arange(60)
    >>> difference = 3.0 + 80.0 * np.exp(-(((frames - 25.0) / 10.0) ** 4))
    >>> table = figures.build_animal_presence_table(
    ...     frames, difference, threshold=10.0, has_animal=difference > 10.0
    ... )
    >>> ax = figures.plot_animal_presence(table)
    """
    check_columns(table, COLUMNS, where="animal presence")
    if len(table) == 0:
        raise InputError("animal presence: the table is empty.")
    with style():
        if ax is None:
            _, ax = new_axes(figsize=figure_size(1, 55.0))
        frames, there = table["frame"].to_numpy(), table["has_animal"].to_numpy(dtype=bool)
        starts = np.flatnonzero(there & ~np.r_[False, there[:-1]])
        ends = np.flatnonzero(there & ~np.r_[there[1:], False])
        for i, (start, end) in enumerate(zip(frames[starts], frames[ends], strict=True)):
            ax.axvspan(
                start - 0.5, end + 0.5, color=OKABE_ITO["sky blue"], alpha=0.3, linewidth=0,
                label="_" * (i > 0) + "with the animal",
            )  # fmt: skip
        ax.plot(frames, table["difference"], color="black", label="sum of differences")
        ax.axhline(
            table["threshold"].iloc[0], color=OKABE_ITO["vermillion"], linestyle="--",
            label="prediction limit",
        )  # fmt: skip
        ax.set_xlabel("Frame")
        ax.set_ylabel("Sum of differences (grey values)")
        ax.set_xlim(frames[0] - 0.5, frames[-1] + 0.5)
        ax.set_ylim(bottom=0)
        ax.legend(frameon=False)
    return ax
