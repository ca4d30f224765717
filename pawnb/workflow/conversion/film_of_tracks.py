"""Whether tracks made elsewhere belong to the film that their trial names."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.video import ViewReader, open_views
from pawnb.errors import PawnbError
from pawnb.schema import Tracks
from pawnb.trial import Trial, View

_TOO_SHORT = 0.9
"""Share of the film that tracks from its beginning cover; below it is said. Set by hand: programs
leave out a few frames at the end."""

_FRAMES_PROMISED = 5
"""Frames that tracks may have after the last of the film. Set by hand: DeepLabCut counts those that
the container promises, of which the last few of many films cannot be decoded."""

_OUTSIDE = 0.02
"""Share of places outside of the picture from which on it is said. Set by hand: feet at the border
are placed some px outside of it now and then."""

_SURE_IN_PICTURE = 0.6
"""Confidence of places that count here, as in the gait analysis."""


def doubt_film_of_tracks(trial: Trial, tracks: Tracks) -> list[str]:
    """Say where tracks made elsewhere do not fit the film of their trial.

    Parameters
    ----------
    trial : Trial
        A trial of kind ``tracks``; views without a film, or whose film is not there, are passed
        over.
    tracks : xarray.Dataset
        Its tracks, as the gait analysis takes them.

    Returns
    -------
    list of str
        What is odd in the film itself, its frame rate against ``fps``, and where the tracks have
        far fewer or more frames than it, or places outside of its pictures.
    """
    doubts: list[str] = []
    for view in trial.views:
        if not view.video:
            continue
        with (
            suppress(PawnbError),  # absent, or damaged: the gait does not need it
            open_views(replace(trial, views=(view,), calibration=None)) as views,
        ):
            reader = views.readers[view.name]
            of = f"{_file_of(trial, view)}: "
            doubts += views.notes
            doubts += [of + told for told in _on_frames(trial, view, tracks, reader)]
            doubts += [of + told for told in _on_places(trial, view, tracks, reader)]
    return list(dict.fromkeys(doubts))


def _file_of(trial: Trial, view: View) -> str:
    """Return the file that holds the tracks of a view."""
    return trial.tracks_of_views.get(view.name) or ", ".join(trial.track_files)


def _on_frames(trial: Trial, view: View, tracks: Tracks, reader: ViewReader) -> Iterator[str]:
    """Compare the frames of tracks with those of the film."""
    offset = view.offset if trial.tracks_of_views else 0
    frames = tracks["frame"].to_numpy() + offset
    first, last, n_film = int(frames[0]), int(frames[-1]), reader.n_frames
    film = f"the film of view {view.name!r} has {n_film}"
    if first == 1 and last == n_film:
        yield (
            f"frames 1 to {last}, and {film}, 0 to {n_film - 1}: the tracks seem to be counted "
            "from 1, and are seen one picture late on the film. The gait is the same."
        )
    elif last > n_film - 1 + _FRAMES_PROMISED:
        yield (
            f"frames up to {last}, and {film}: the tracks are of another film, or of this one "
            "before it was cut or brought to another rate. fps must be the rate of the film that "
            f"was tracked, and is {trial.fps:g} here."
        )
    elif trial.frames is None and first in (0, 1) and last + 1 < _TOO_SHORT * n_film:
        every = n_film / (last + 1 - first)
        yield (
            f"frames {first} to {last}, and {film}. Where only one picture in {every:.3g} was "
            f"tracked, and these were numbered anew, frequencies and speeds are {every:.3g} times "
            f"too high: then fps = {trial.fps / every:.4g} is right. Where only the beginning of "
            f"the film was tracked, a trial.toml says so: frames = [{first}, {last + 1}] below "
            "[trial]."
        )


def _on_places(trial: Trial, view: View, tracks: Tracks, reader: ViewReader) -> Iterator[str]:
    """Say where places lie outside of the pictures."""
    places = _sure_places(trial, view, tracks)
    size = np.array([reader.width, reader.height])
    outside = ((places < -0.5) | (places > size - 0.5)).any(axis=1)
    if len(places) and outside.mean() > _OUTSIDE:
        (u0, v0), (u1, v1) = np.quantile(places, [0.01, 0.99], axis=0)
        yield (
            f"{outside.mean():.0%} of the places lie outside of the pictures of view "
            f"{view.name!r}, which have {size[0]} x {size[1]} px (most places are from {u0:.0f} to "
            f"{u1:.0f} across and from {v0:.0f} to {v1:.0f} down): the tracks were made on "
            "pictures of another size, or cut out otherwise (crop). Lengths are in the pixels of "
            "those that were tracked, and so must a scale (px_per_unit) or a calibration be."
        )


def _sure_places(trial: Trial, view: View, tracks: Tracks) -> FloatArray:
    """Return places (n, 2) in px of a view that count; none where only space is known."""
    scale = 1.0
    if "image_position" in tracks and view.name in tracks["view"].to_numpy():
        place = tracks["image_position"].sel(view=view.name)
        sure = tracks["image_confidence"].sel(view=view.name)
        axis = "image_space"
    elif "image_position" in tracks or tracks.sizes["space"] != 2 or len(trial.views) != 1:
        return np.empty((0, 2))
    else:
        place, sure, axis = tracks["position"], tracks["confidence"], "space"
        if tracks.attrs["units"] != "px":
            known = trial.calibration.px_per_unit if trial.calibration is not None else None
            scale = np.nan if known is None else known
    order = ("time", "keypoint", "individual")
    uv = scale * place.transpose(*order, axis).to_numpy().reshape(-1, 2)
    unsure = sure.transpose(*order).to_numpy().ravel() < _SURE_IN_PICTURE
    return np.asarray(uv[np.isfinite(uv).all(axis=1) & ~unsure], dtype=float)
