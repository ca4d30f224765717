"""Whether a film leaps from one picture to the next, as where it is cut or two are joined.

Nothing can be followed across a cut, and time stamps say nothing of it. A picture there differs
more from that before it than any picture about it does, however fast the animal moves. A flash
leaps twice, so that neither leap is larger than the other.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence

import cv2
import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.video.views import Frame, ViewReader
from pawnb.core.video.viewset import ViewSet
from pawnb.schema import Tracks
from pawnb.trial import Trial

_REDUCED_WIDTH_PX = 160
"""Resource: pictures are reduced to about this width."""
_BLUR_PX = 1.0
_NEAR = 12
"""Changes before and after it that one is compared with."""
_LEAP_TIMES, _LEAP_GREY = 2.0, 2.0
"""A leap is so many times the largest change about it, RMS, and so many grey values. Chosen on
eight real films (mice, horse, camel, dog): as they are the most is 1.5, written again in H.264
of crf 30 and 38 with a key picture every 40 it is 1.7 where something moves, and 15 times 0.06
grey values where next to nothing does; on rendered mice, whose knees may turn over from one frame
to the next, it is 2.2 times 1.2 grey values. Of cuts of 10 to 60 frames 94 to 100 % are found in
horse, camel and a mouse from above, 76 % in a mouse from below, 53 % in a dog that hardly moves,
and next to none in a wheel, whose mouse runs on in the same place. None is found in 18 other real
films (a mouse from the side, flies, mice in an arena, a spider that a shadow sweeps over, boards).
"""
_MOST_CUTS_TOLD = 3
_CUTS = "cuts"
"""Attribute of tracks: the first frame after each cut, by view, as JSON."""

Cuts = Mapping[str, Sequence[int]]
"""View to the first frames after a cut."""


class WatchedViews:
    """Opened views that note how much each picture differs from the one before it.

    They are handed on as they are, to whoever reads all of them one after the other; pictures of
    which only small parts are decoded are not looked at.

    Parameters
    ----------
    views : ViewSet
        The open views.
    """

    def __init__(self, views: ViewSet) -> None:
        self._views = views
        self._last: dict[str, tuple[int, FloatArray]] = {}
        self._changes: dict[str, dict[int, float]] = {name: {} for name in views.names}

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the views."""
        return self._views.names

    @property
    def n_frames(self) -> int:
        """Frames that every view has."""
        return self._views.n_frames

    @property
    def readers(self) -> dict[str, ViewReader]:
        """Reader of each view."""
        return self._views.readers

    def frame(self, i: int) -> dict[str, Frame]:
        """Return frame i of every view."""
        return self._views.frame(i)

    def frames(
        self, start: int, stop: int, *, step: int = 1, partly: bool = False
    ) -> Iterator[tuple[int, dict[str, Frame]]]:
        """Go through frames of every view: see :meth:`pawnb.core.video.ViewSet.frames`."""
        for index, frames in self._views.frames(start, stop, step=step, partly=partly):
            for name, frame in {} if partly or step != 1 else frames.items():
                self._note(name, index, frame)
            yield index, frames

    def _note(self, name: str, index: int, frame: Frame) -> None:
        """Compare a picture with the one before it, unless an earlier reading has."""
        changes, last = self._changes[name], self._last.get(name)
        if index in changes and index + 1 in changes:
            return
        now = _small_grey(frame)
        if last is not None and last[0] == index - 1:
            changes[index] = float(np.sqrt(np.mean((now - last[1]) ** 2)))
        self._last[name] = index, now

    def find_cuts(self, trial: Trial) -> dict[str, list[int]]:
        """Find where the films leap, in all that was read.

        Parameters
        ----------
        trial : Trial
            The trial; the end of frames that it says are without the animal is no leap.

        Returns
        -------
        dict
            View to the first frames after a leap; views without any are left out.
        """
        found = {}
        for name, noted in self._changes.items():
            if not noted:
                continue
            first, end = trial.view(name).background_frames or (self.n_frames, self.n_frames)
            begin = min(noted)
            own = np.array([noted.get(i, 0.0) for i in range(begin, max(noted) + 1)])
            leaps = [frame for i in find_leaps(own) if not first <= (frame := begin + i) <= end]
            if leaps:
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


def tell_cuts(views: ViewSet | WatchedViews, cuts: Cuts) -> list[str]:
    """Say where films leap, once a film.

    Parameters
    ----------
    views : ViewSet
        The open views.
    cuts : mapping
        As from :meth:`WatchedViews.find_cuts`.

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
        As from :meth:`WatchedViews.find_cuts`.
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
        if "view" in tracks.coords and view in tracks["view"].to_numpy() and inside:
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
