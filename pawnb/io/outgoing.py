"""What other programs' formats hold of Tracks: the points of one view, or points in space."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pawnb.arrays import FloatArray, IntArray
from pawnb.errors import InputError, did_you_mean
from pawnb.schema import ORIGIN_CODE, Tracks, absent_frames, check_tracks, rows_with_places


@dataclass(frozen=True)
class Outgoing:
    """Points as most programs keep them.

    Parameters
    ----------
    frames : ndarray, shape (n_frames,)
        Frames that the tracks have a row of.
    points, individuals : list of str
        Names.
    place : ndarray, shape (n_frames, n_points, n_individuals, 2 or 3)
        Positions, NaN where missing.
    confidence : ndarray, shape (n_frames, n_points, n_individuals)
        Confidence, NaN where missing or not known.
    fps : float
        Frames per second.
    attrs : dict
        Attributes of the tracks.
    tracks : xarray.Dataset
        The tracks, of these frames only.
    """

    frames: IntArray
    points: list[str]
    individuals: list[str]
    place: np.ndarray
    confidence: FloatArray
    fps: float
    attrs: dict
    tracks: Tracks

    def only_animal(self, program: str) -> None:
        """Refuse several animals where the format holds one."""
        if len(self.individuals) > 1:
            raise InputError(
                f"{program} holds one animal a file, and these tracks have "
                f"{', '.join(self.individuals)}; choose one with --animal."
            )

    def whole(self, values: FloatArray) -> FloatArray:
        """Return values (n_frames, ...) with a row for every frame from 0 on; NaN between."""
        if not len(self.frames):
            return values
        if self.frames[0] < 0:
            raise InputError("frames below 0 have no row in a file whose first row is frame 0.")
        filled = np.full((int(self.frames[-1]) + 1, *values.shape[1:]), np.nan)
        filled[self.frames] = values
        return filled


def views_of(tracks: Tracks) -> list[str]:
    """Return the views in which tracks have image positions; one of no name where in px only.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks.

    Returns
    -------
    list of str
        Names of views; ``[""]`` for positions in px that belong to no named view; empty where
        there are points in space only.
    """
    check_tracks(tracks)
    if "image_position" in tracks:
        return [str(view) for view in tracks["view"].to_numpy()]
    return [""] if tracks.sizes["space"] == 2 else []


def take_view(tracks: Tracks, view: str = "") -> Outgoing:
    """Return the points of one view.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks.
    view : str
        The view; may be left out where there is one.

    Returns
    -------
    Outgoing
        Points in px.

    Raises
    ------
    InputError
        If there is no such view, or no points in pictures at all.
    """
    views = views_of(tracks)
    if not views:
        raise InputError("these tracks hold no points in pictures, and this format no others.")
    if view not in views:
        if view or len(views) > 1:
            raise InputError(
                f"no view {view!r} in these tracks{did_you_mean(view, views)}; there are "
                f"{', '.join(views)}."
            )
        view = views[0]
    if "image_position" not in tracks:
        return _take(tracks, "position", "confidence", "origin")
    own = tracks.sel(view=view)
    return _take(own, "image_position", "image_confidence", "image_origin")


def take_space(tracks: Tracks) -> Outgoing:
    """Return the points in space.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks.

    Returns
    -------
    Outgoing
        Points with x, y, z.

    Raises
    ------
    InputError
        If there are none.
    """
    check_tracks(tracks)
    if not has_space(tracks):
        raise InputError(
            "these tracks hold no points in space; name a trial with a calibration, or a format "
            "of points in pictures."
        )
    return _take(tracks, "position", "confidence", "origin")


def has_space(tracks: Tracks) -> bool:
    """Say whether tracks hold points in space.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks.

    Returns
    -------
    bool
        True where a point has x, y and z.
    """
    return tracks.sizes["space"] == 3 and bool(np.isfinite(tracks["position"]).any())


def take_animal(tracks: Tracks, individual: str) -> Tracks:
    """Return the tracks of one animal.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks.
    individual : str
        Its name.

    Returns
    -------
    xarray.Dataset
        Its tracks.

    Raises
    ------
    InputError
        If there is none of that name.
    """
    names = [str(name) for name in tracks["individual"].to_numpy()]
    if individual not in names:
        raise InputError(
            f"no animal {individual!r} in these tracks{did_you_mean(individual, names)}; there "
            f"are {', '.join(names)}."
        )
    return tracks.isel(individual=[names.index(individual)])


def _take(tracks: Tracks, place: str, confidence: str, origin: str) -> Outgoing:
    """Return the named variables of the frames that have a row, or were given a place since."""
    frames = tracks["frame"].to_numpy()
    keep = np.ones(len(frames), dtype=bool)
    for first, last, _ in absent_frames(tracks):
        keep &= ~((frames >= first) & (frames <= last))
    keep |= rows_with_places(tracks)
    own = tracks.isel(time=keep)
    axis = "image_space" if place == "image_position" else "space"
    values = own[place].transpose("time", "keypoint", "individual", axis).to_numpy()
    order = ("time", "keypoint", "individual")
    missing = own[origin].transpose(*order).to_numpy() == ORIGIN_CODE["missing"]
    return Outgoing(
        frames=frames[keep],
        points=[str(point) for point in own["keypoint"].to_numpy()],
        individuals=[str(who) for who in own["individual"].to_numpy()],
        place=np.where(missing[..., None], np.nan, values),
        confidence=np.where(missing, np.nan, own[confidence].transpose(*order).to_numpy()),
        fps=float(tracks.attrs["fps"]),
        attrs=dict(tracks.attrs),
        tracks=own,
    )


def word(value: float) -> str:
    """Return a number with the fewest digits that give it back exactly; NaN is empty.

    Parameters
    ----------
    value : float
        The number.

    Returns
    -------
    str
        What is written into a cell.
    """
    return "" if np.isnan(value) else repr(float(value))
