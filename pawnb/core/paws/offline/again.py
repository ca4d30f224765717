"""Tracking again after a correction: only between the clicks on either side of it.

Clicks close the model: what lies beyond the neighbouring clicks of a point bears on nothing
between them. What appearance is learnt from includes the correction, and how far it is trusted
stays as it was in the run that is corrected.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.parameters import APPEARANCE
from pawnb.core.paws.offline.weighing import Weighing
from pawnb.schema import ORIGIN_CODE, Tracks

TRUST, LEFT_OUT = "appearance_trust", "left_out_found"
"""Attributes of tracks: how far appearance was trusted beside the other kinds of evidence, and how
likely each click was found when its frame was left out (:class:`.weighing.Weighing`)."""
_SURE = 0.9
"""Other points are certain at both ends of what is tracked again from this confidence on."""


@dataclass(frozen=True)
class Again:
    """What is tracked again.

    Parameters
    ----------
    tracks : Tracks
        The corrected tracks.
    frames : tuple of int
        First frame and one past the last.
    weighing : Weighing
        How far appearance is trusted.
    """

    tracks: Tracks
    frames: tuple[int, int]
    weighing: Weighing

    def rows_in(self, first: int, span: tuple[int, int]) -> tuple[int, int] | None:
        """Return the rows of a window, counted from its first; None where there is none.

        Parameters
        ----------
        first : int
            The frame that is row 0.
        span : tuple of int
            First row of the window and one past the last.
        """
        begin = max(self.frames[0] - first, span[0]) - span[0]
        end = min(self.frames[1] - first, span[1]) - span[0]
        return (begin, end) if begin < end else None

    def known(self, view: str, points: Sequence[str], first: int) -> Annotations:
        """Return where sure points of a view are at both ends, by row and number of the point.

        Parameters
        ----------
        view : str
            The view.
        points : sequence of str
            Points, in the order of their numbers.
        first : int
            Frame of the first row.

        Returns
        -------
        Annotations
            Positions by row and number of the point.
        """
        places: dict[int, dict[int, np.ndarray]] = {}
        flat = self.tracks.isel(individual=0)
        at = np.isin(flat["frame"].to_numpy(), (self.frames[0], self.frames[1] - 1))
        for t in np.flatnonzero(at):
            for number, point in enumerate(points):
                label = {"time": int(t)}, {"view": view, "keypoint": point}
                here = flat.isel(label[0]).sel(label[1])
                uv = here["image_position"].to_numpy()
                seen = here["image_origin"] != ORIGIN_CODE["reprojected"]
                if seen and here["image_confidence"] >= _SURE and np.isfinite(uv).all():
                    places.setdefault(int(here["frame"]) - first, {})[number] = uv
        return Annotations(places)


def weighing_as_attributes(weighing: Weighing) -> dict[str, float | str]:
    """Return what is to be known of a weighing when tracks are corrected, as their attributes.

    Attributes of files of tracks are numbers and text: lists are written as JSON.
    """
    found = [round(float(value), 4) for value in weighing.found]
    return {TRUST: float(weighing.trust), **({LEFT_OUT: json.dumps(found)} if found else {})}


def weighing_of(tracks: Tracks) -> Weighing:
    """Return how far appearance was trusted in the run that made these tracks."""
    usual = APPEARANCE.trust
    found = np.array(json.loads(tracks.attrs.get(LEFT_OUT, "[]")), float)
    return Weighing(float(tracks.attrs.get(TRUST, usual)), found)


def frames_again(tracks: Tracks, frame: int, points: Sequence[str]) -> tuple[int, int]:
    """Return the frames that a correction is tracked again in: up to the next click.

    Parameters
    ----------
    tracks : Tracks
        Tracks with the correction.
    frame : int
        The corrected frame.
    points : sequence of str
        The points that were put in place there.

    Returns
    -------
    tuple of int
        The frame and one past the next one in which each of the points is placed by hand in
        some view, or past the last of the tracks.
    """
    frames = tracks["frame"].to_numpy()
    by_hand = (tracks["image_origin"] == ORIGIN_CODE["edited"]).isel(individual=0).any("view")
    last = frame
    for point in points:
        later = frames[by_hand.sel(keypoint=point).to_numpy() & (frames > frame)]
        last = max(last, int(later[0]) if len(later) else int(frames[-1]))
    return frame, last + 1
