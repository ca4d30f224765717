"""A second track of the same trial beside the one under review: by hand, or before corrections."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from pawnb.core.rig import Rig
from pawnb.errors import InputError
from pawnb.schema import SUSPECTS_COLUMNS, Tracks, check_tracks

APART = 10
"""Differences of one point are listed so many frames apart: the largest of those between."""
LEAST_DIFFERENCE_PX = 1.0
"""Smaller differences are not listed."""
_MOST_LISTED = 200


class Comparison:
    """How far the points of two tracks of one trial are from one another in the pictures.

    Parameters
    ----------
    tracks : xarray.Dataset
        The tracks under review.
    other : xarray.Dataset
        The others. What they share is compared: frames by their number, views and points by name.
        Where they have no place in a picture but one in space, that is shown there.
    name : str
        What the others are called.
    rig : Rig, optional
        The calibrated views.
    listed : sequence of str, optional
        Points that :meth:`largest` lists and :meth:`marks` shows; default all.

    Attributes
    ----------
    uv : ndarray, shape (n, V, 2, P)
        Places of the others in the order of the tracks under review, px; NaN where they have none.

    Raises
    ------
    InputError
        If they share nothing that can be compared.
    """

    def __init__(
        self,
        tracks: Tracks,
        other: Tracks,
        *,
        name: str,
        rig: Rig | None = None,
        listed: Sequence[str] | None = None,
    ) -> None:
        check_tracks(other)
        if other.sizes["individual"] != 1:
            raise InputError(
                f"the tracks to compare with hold {other.sizes['individual']} individuals; choose "
                "one with tracks.isel(individual=[0])."
            )
        self.name = name
        self.frames = tracks["frame"].to_numpy()
        self.views = [str(view) for view in tracks["view"].to_numpy()]
        self.points = [str(point) for point in tracks["keypoint"].to_numpy()]
        self.listed = frozenset(self.points if listed is None else listed)
        self.uv = self._aligned(other, rig)
        if not np.isfinite(self.uv).any():
            raise InputError(
                "the tracks to compare with share no point of a view in any frame with those under "
                "review; their points and views must have the same names."
            )

    def distances(self, tracks: Tracks) -> np.ndarray:
        """Return how far each point is from the other's, px, shape (n, V, P); NaN without both."""
        own = tracks["image_position"].to_numpy()[..., 0]
        return np.asarray(np.hypot(*np.moveaxis(own - self.uv, 2, 0)))

    def farthest(self, tracks: Tracks) -> np.ndarray:
        """Return the largest distance over the views, px, shape (n, P); NaN without any."""
        return np.asarray(np.fmax.reduce(self.distances(tracks), axis=1))

    def largest(self, tracks: Tracks) -> pd.DataFrame:
        """Return where the tracks differ most, the largest difference first.

        Parameters
        ----------
        tracks : xarray.Dataset
            The tracks under review, as they are now.

        Returns
        -------
        pandas.DataFrame
            frame, view, point, reason and score (px), as of doubtful labels; of differences of one
            point less than :data:`APART` frames apart only the largest.
        """
        every = self.distances(tracks)
        rows: list[tuple[Any, ...]] = []
        for p, point in enumerate(self.points):
            if point not in self.listed:
                continue
            far = np.nan_to_num(self.farthest(tracks)[:, p], nan=0.0)
            for _ in range(_MOST_LISTED):
                if far.max(initial=0.0) < LEAST_DIFFERENCE_PX:
                    break
                row = int(far.argmax())
                view = self.views[int(np.nanargmax(every[row, :, p]))]
                words = f"{far[row]:.1f} px from {self.name}"
                rows.append((int(self.frames[row]), view, point, words, float(far[row])))
                far[np.abs(self.frames - self.frames[row]) < APART] = 0.0
        table = pd.DataFrame(rows, columns=list(SUSPECTS_COLUMNS))
        return table.sort_values("score", ascending=False, kind="stable").head(_MOST_LISTED)

    def marks(self, frame: int, view: str, colours: Mapping[str, str]) -> list[dict[str, Any]]:
        """Return where the other tracks have the points of a view.

        Parameters
        ----------
        frame : int
            The frame.
        view : str
            The view.
        colours : mapping of str to str
            Colour of each point.

        Returns
        -------
        list of dict
            id, colour, u and v (px) of each point, as the browser draws them.
        """
        rows = np.flatnonzero(self.frames == frame)
        if not len(rows):
            return []
        places = self.uv[int(rows[0]), self.views.index(view)]
        return [
            {
                "id": point,
                "colour": colours[point],
                "u": round(float(u), 2),
                "v": round(float(v), 2),
            }
            for point, (u, v) in zip(self.points, places.T, strict=True)
            if point in self.listed and np.isfinite([u, v]).all()
        ]

    def _aligned(self, other: Tracks, rig: Rig | None) -> np.ndarray:
        """Return the others' places in the order of the tracks under review."""
        out = np.full((len(self.frames), len(self.views), 2, len(self.points)), np.nan)
        rows = _places(self.frames, other["frame"].to_numpy())
        points = _places(self.points, [str(point) for point in other["keypoint"].to_numpy()])
        if "image_position" in other:
            views = _places(self.views, [str(view) for view in other["view"].to_numpy()])
            theirs = other["image_position"].to_numpy()[..., 0]
            out[np.ix_(rows[0], views[0], [0, 1], points[0])] = theirs[
                np.ix_(rows[1], views[1], [0, 1], points[1])
            ]
        if rig is not None and other.sizes["space"] == 3:
            xyz = other["position"].to_numpy()[..., 0][np.ix_(rows[1], [0, 1, 2], points[1])]
            shown = np.moveaxis(rig.project(np.moveaxis(xyz, 1, 2)), 1, 3)  # (n, V, 2, P)
            views = _places(self.views, list(rig.names))
            at = np.ix_(rows[0], views[0], [0, 1], points[0])
            out[at] = np.where(np.isfinite(out[at]), out[at], shown[:, views[1]])
        return out


def _places(own: Iterable[Any], other: Iterable[Any]) -> tuple[list[int], list[int]]:
    """Return where what both have stands in the one and in the other."""
    where = {name: k for k, name in enumerate(other)}
    shared = [(k, where[name]) for k, name in enumerate(own) if name in where]
    return [k for k, _ in shared], [k for _, k in shared]
