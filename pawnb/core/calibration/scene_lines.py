"""Axes and a floor grid over a view: whether a calibration's geometry is right is seen at once."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pawnb.arrays import Points2D, Points3D

AXES = {"x": "#d55e00", "y": "#009e73", "z": "#56b4e9"}
"""Colours that most people can tell apart (Okabe & Ito 2008)."""
GRID_COLOUR = "#f0e442"
_CELLS = 6
_LINE_SAMPLES = 13
"""Places along each line: lenses bend them."""


def scene_lines(
    show: Callable[[Points3D], Points2D], *, around: Points3D
) -> tuple[list[dict[str, object]], list[dict[str, object]]]:
    """Return a grid on the plane z = 0, and the three axes from zero.

    Parameters
    ----------
    show : callable
        Points (n, 3) to where the picture shows them (n, 2); NaN where it does not.
    around : ndarray, shape (n, 3)
        Points of the filmed space: the grid lies below them.

    Returns
    -------
    lines : list of dict
        ``at`` (a list of [u, v], None where not seen) and ``colour`` of each line.
    ends : list of dict
        ``id`` (x, y or z), ``u``, ``v`` and ``colour`` of the end of each axis that is seen.
    """
    low, high = around.min(axis=0), around.max(axis=0)
    step = grid_step(float(max(high - low)))
    first = np.floor(low[:2] / step) * step
    last = first + step * np.minimum(np.ceil((high[:2] - first) / step).clip(1), 4 * _CELLS)
    along = np.linspace(0.0, 1.0, _LINE_SAMPLES)
    lines: list[dict[str, object]] = []
    for axis in (0, 1):
        for value in np.arange(first[axis], last[axis] + step / 2, step):
            xyz = np.zeros((_LINE_SAMPLES, 3))
            xyz[:, axis] = value
            xyz[:, 1 - axis] = first[1 - axis] + along * (last - first)[1 - axis]
            lines.append({"at": _plain(show(xyz)), "colour": GRID_COLOUR})
    ends: list[dict[str, object]] = []
    for k, (name, colour) in enumerate(AXES.items()):
        xyz = np.zeros((_LINE_SAMPLES, 3))
        xyz[:, k] = 2.0 * step * along
        at = _plain(show(xyz))
        lines.append({"at": at, "colour": colour})
        if at[-1] is not None:
            ends.append({"id": name, "u": at[-1][0], "v": at[-1][1], "colour": colour})
    return lines, ends


def grid_step(extent: float) -> float:
    """Return a round side of the grid's squares, about a sixth of an extent."""
    rough = max(extent, 1e-9) / _CELLS
    power = 10.0 ** np.floor(np.log10(rough))
    return float(power * min((1.0, 2.0, 5.0, 10.0), key=lambda k: abs(np.log(k * power / rough))))


def _plain(uv: np.ndarray) -> list[list[float] | None]:
    """Return places as JSON has them."""
    return [[round(float(u), 2), round(float(v), 2)] if np.isfinite(u + v) else None for u, v in uv]
