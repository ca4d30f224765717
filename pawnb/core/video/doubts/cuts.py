"""Whether a film leaps from one picture to the next, as where it is cut or two are joined.

Nothing can be followed across a cut, and time stamps say nothing of it. A picture there differs
more from that before it than any picture about it does, however fast the animal moves. A flash
leaps twice, so that neither leap is larger than the other.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence

import cv2
import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.video.views import Frame
from pawnb.core.video.viewset import ViewSet
from pawnb.schema import Tracks
from pawnb.trial import Trial

_REDUCED_WIDTH_PX = 160
"""Resource: pictures are reduced to about this width."""
_BLUR_PX = 1.0
_NEAR = 12
"""Changes before and after it that one is compared with."""
_LEAP_TIMES, _LEAP_GREY = 2.0, 1.0
"""A leap is so many times the largest change about it, RMS, and so many grey values. Chosen on
eight real films (mice, horse, camel, dog): as they are the most is 1.5, written again in H.264
of crf 30 and 38 with a key picture every 40 it is 1.7 where something moves, and 15 times 0.06
grey values where next to nothing does. Of cuts of 10 to 60 frames 90 to 100 % are found in horse,
camel and a mouse from above, 82 % in a mouse from below, 47 % in a dog that hardly moves, and next
to none in a wheel, whose mouse runs on in the same place. None is found in 18 other real films (a
mouse from the side, flies, mice in an arena, a spider that a shadow sweeps over, boards)."""
_MOST_CUTS_TOLD = 3
_CUTS = "cuts"
"""Attribute of tracks: the first frame after each cut, by view, as JSON."""

Cuts = Mapping[str, Sequence[int]]
"""View to the first frames after a cut."""


def cuts_of_views(trial: Trial, views: ViewSet, *, start: int, stop: int) -> dict[str, list[int]]:
    """Find where the films of views leap.

    Parameters
    ----------
    trial : Trial
        The trial; the end of frames that it says are without the animal is no leap.
    views : ViewSet
        The open views.
    start, stop : int
        Frames of the trial, half open.

    Returns
    -------
    dict
        View to the first frames after a leap; views without any are left out.
    """
    before: dict[str, FloatArray] = {}
    changes: dict[str, list[float]] = {name: [] for name in views.names}
    for _, frames in views.frames(start, stop):
        for name, frame in frames.items():
            now = _small_grey(frame)
            if name in before:
                changes[name].append(float(np.sqrt(np.mean((now - before[name]) ** 2))))
            before[name] = now
    found = {}
    for name, own in changes.items():
        first, end = trial.view(name).background_frames or (stop, stop)
        leaps = [start + 1 + i for i in find_leaps(np.array(own))]
        if leaps := [frame for frame in leaps if not first <= frame <= end]:
            found[name] = leaps
    return found


def find_leaps(changes: FloatArray) -> list[int]:
    """Find changes that are larger than any about them.

    Parameters
    ----------
    changes : ndarray, shape (n,)
        RMS change from each picture to the next, grey values.

    Returns
    -------
    list of int
        Their numbers; none at the ends, where too little is before or after.
    """
    found = []
    for i in np.flatnonzero(changes >= _LEAP_GREY).tolist():
        before, after = changes[max(i - _NEAR, 0) : i], changes[i + 1 : i + 1 + _NEAR]
        if min(len(before), len(after)) < _NEAR // 2:
            continue
        if changes[i] >= _LEAP_TIMES * max(before.max(), after.max()):
            found.append(i)
    return found


def tell_cuts(views: ViewSet, cuts: Cuts) -> list[str]:
    """Say where films leap, once a film.

    Parameters
    ----------
    views : ViewSet
        The open views.
    cuts : mapping
        As from :func:`cuts_of_views`.

    Returns
    -------
    list of str
        A sentence a film.
    """
    of_files = {views.readers[name].source.name: own for name, own in cuts.items()}
    return [
        f"{file} leaps {_places(own)}: the film is cut there, or joined from two, or the light was "
        "switched; nothing is followed across it, so make a trial of each part "
        f"([trial] frames, one of which ends with {own[0]} and the next begins there)"
        for file, own in of_files.items()
    ]


def with_cuts(tracks: Tracks, cuts: Cuts) -> Tracks:
    """Return tracks that say where their films leap.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks.
    cuts : mapping
        As from :func:`cuts_of_views`.
    """
    return tracks.assign_attrs({_CUTS: json.dumps(dict(cuts))}) if cuts else tracks


def cuts_in_words(tracks: Tracks) -> list[str]:
    """Say where the films leap that tracks were made from.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks.

    Returns
    -------
    list of str
        A sentence, without a full stop, for each view of which there are tracks on both sides.
    """
    frames = tracks["frame"].to_numpy()
    said = []
    for view, own in json.loads(tracks.attrs.get(_CUTS, "{}")).items():
        inside = [frame for frame in own if frame in frames and frame - 1 in frames]
        if view in tracks["view"].to_numpy() and inside:
            said.append(f"the film of view {view} is cut, or leaps, {_places(inside)}")
    return said


def _places(cuts: Sequence[int]) -> str:
    """Name the frames between which a film leaps."""
    told = ", ".join(f"from frame {frame - 1} to {frame}" for frame in cuts[:_MOST_CUTS_TOLD])
    more = len(cuts) - _MOST_CUTS_TOLD
    return told + (f" and {more} more times" if more > 0 else "")


def _small_grey(frame: Frame) -> FloatArray:
    """Return a picture in grey, small and without its finest detail."""
    by = max(1, frame.width // _REDUCED_WIDTH_PX)
    small = frame.reduced(0, 0, frame.width // by * by, frame.height // by * by, factor=by)
    grey = cv2.cvtColor(small, cv2.COLOR_RGB2GRAY) if small.ndim == 3 else small
    return np.asarray(cv2.GaussianBlur(grey.astype(np.float32), (0, 0), _BLUR_PX), float)
