"""Where a further click helps most: the frames about which tracks expect most wrong labels."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.ndimage import binary_closing
from scipy.signal import lfilter

from pawnb.core.paws.offline.quality.assessment import label_chances
from pawnb.errors import InputError
from pawnb.io.start import read_start
from pawnb.schema import ORIGIN_CODE, Tracks
from pawnb.schema.arguments import checked_arguments
from pawnb.trial import Trial, load_trial
from pawnb.workflow.reviewing.quality import clicks_of_tracks

SUGGESTION_COLUMNS = ("frame", "points", "gain")

SURE = 0.9
"""A point is sure where its labels are right with this probability, as in tracks that are good."""

AGAIN_FRAMES = 3
"""A point is sure again when it is for so many frames in a row."""

HOLDS_S = 1.0
HOLDS_FRAMES = 10
"""Time, and least number of frames, over which what a click mends beside it falls to 1/e. With 1 s
gains are of the size that is measured in real clips with marks (camel, horse, fly); in a mouse
from below, where the looks of paws were learnt for the whole clip from one click, three times as
many labels became right."""

APART_FRAMES = 5
"""No frame is suggested nearer than this to a clicked one, or to another."""

_LEAST_LABELS = 0.5
_LEAST_COUNT_SHARE = 0.2
"""A point is named where a click mends half a label, and a fifth of what it does of the point that
needs it most."""


@checked_arguments
def suggest_frames(trial: Trial | str | Path, tracks: Tracks, *, n: int = 3) -> pd.DataFrame:
    """Name the frames in which further clicks are expected to mend most.

    A click of a point in frame t mends its labels about t, until the track is sure again. With
    ``c`` the probability that a label is right (that of :func:`pawnb.assess_quality`), the gain is

        gain(t) = sum over points, and over frames s of the point's unsure stretch that holds t,
        of (1 - c) exp(-abs(s - t) / h) times the product, over frames k in which the point was
        clicked since it was tracked, of 1 - exp(-abs(s - k) / h)

    summed over views. A stretch is unsure where the mean of c over views is below 0.9, and ends
    where it is not for three frames in a row. ``h`` is 1 s, at least 10 frames. What was mended by
    clicks that tracks were made from, c says; clicks that are new in the trial's start file, and
    corrections, are reckoned with in the product. The frame with the largest gain is taken and
    counts as clicked in its stretch, then the next is chosen. No frame is within 5 frames of a
    clicked one. Where a point cannot be seen in its frame, click it in the nearest one in which it
    can.

    Parameters
    ----------
    trial : Trial, str or Path
        The trial, its ``trial.toml``, or the folder that holds it.
    tracks : xarray.Dataset
        Its tracks, of any method.
    n : int
        How many frames at most.

    Returns
    -------
    pandas.DataFrame
        frame; points, the names of those that need a click there, with commas between, that
        which needs it most first; gain, the expected number of labels that become right. The
        best frame first; fewer rows where further clicks would mend less than half a label.

    Raises
    ------
    InputError
        If ``n`` is below 1, the trial is not of kind ``paws``, the tracks have no image
        positions, or the start clicks cannot be read.

    Examples
    --------
    >>> list(pawnb.suggest_frames(trial, tracks, n=2))
    ['frame', 'points', 'gain']
    """
    if n < 1:
        raise InputError(f"n is {n}; expected at least one frame to suggest.")
    trial = trial if isinstance(trial, Trial) else load_trial(trial)
    trial.must_be("paws", or_else="; frames to click are suggested for kind 'paws'.")
    state = _state(trial, tracks)
    names = [str(name) for name in tracks["keypoint"].to_numpy()]
    rows = [
        (int(tracks["frame"][t]), ", ".join(names[p] for p in points), round(gain, 1))
        for t, points, gain in _choose(state, n)
    ]
    return pd.DataFrame(rows, columns=list(SUGGESTION_COLUMNS))


def gain_by_frame(trial: Trial, tracks: Tracks) -> pd.Series:
    """Return the gain of a click in each frame, by frame: the first suggestion has the largest."""
    state = _state(trial, tracks)
    _, gain = state.gains()
    return pd.Series(gain, index=tracks["frame"].to_numpy())


@dataclass
class _State:
    """What is known of labels before the next frame is chosen.

    Parameters
    ----------
    wrong : ndarray, shape (n, P)
        Expected number of wrong labels that a click could mend.
    stretch : ndarray of int, shape (n, P)
        Number of the stretch in which a point is unsure; -1 where it is not.
    free : ndarray of bool, shape (n,)
        Which frames may be taken.
    holds : float
        Frames over which a click holds.
    """

    wrong: np.ndarray
    stretch: np.ndarray
    free: np.ndarray
    holds: float

    def gains(self) -> tuple[np.ndarray, np.ndarray]:
        """Return what a click of each point mends (n, P), 0 if too little, and the sum by frame."""
        mended = _mended(self.wrong, self.stretch, self.holds)
        least = np.maximum(_LEAST_COUNT_SHARE * mended.max(axis=1, keepdims=True), _LEAST_LABELS)
        named = np.where(mended >= least, mended, 0.0)
        return named, named.sum(axis=1)


def _state(trial: Trial, tracks: Tracks) -> _State:
    """Return what tracks say of themselves, clicks since then included."""
    clicks = clicks_of_tracks(tracks)
    chance = label_chances(tracks, clicks=clicks)
    known, since = _clicked_frames(trial, tracks, clicks)
    frames = tracks["frame"].to_numpy()
    holds = max(HOLDS_S * float(tracks.attrs["fps"]), HOLDS_FRAMES)
    wrong = np.nansum(1.0 - chance, axis=1)
    for p, own in enumerate(since):
        for frame in own:
            wrong[:, p] *= -np.expm1(-np.abs(frames - frame) / holds)
    free = np.ones(len(frames), dtype=bool)
    for frame in sorted(set().union(*known, *since)):
        free &= np.abs(frames - frame) > APART_FRAMES
    unsure = _unsure(chance)
    stretch = np.where(unsure, np.cumsum(np.diff(unsure, axis=0, prepend=False), axis=0), -1)
    return _State(wrong, stretch, free, holds)


def _clicked_frames(
    trial: Trial, tracks: Tracks, clicks: pd.DataFrame | None
) -> tuple[list[set[int]], list[set[int]]]:
    """Return the frames in which tracks had clicks of each point, and those clicked since."""
    names = tracks["keypoint"].to_numpy()
    known = _by_point(clicks, names)
    file = trial.start_file()
    since = _by_point(None if file is None else read_start(trial.path(file), trial), names)
    origin = tracks["image_origin"].isel(individual=0).transpose("time", "view", "keypoint")
    placed = (origin.to_numpy() == ORIGIN_CODE["edited"]).any(axis=1)
    frames = tracks["frame"].to_numpy()
    for p, own in enumerate(since):
        own.update(int(frame) for frame in frames[placed[:, p]])
        own -= known[p]
    return known, since


def _by_point(clicks: pd.DataFrame | None, names: np.ndarray) -> list[set[int]]:
    """Return the frames in which each point is clicked."""
    if clicks is None:
        return [set() for _ in names]
    return [{int(frame) for frame in clicks["frame"][clicks["point"] == name]} for name in names]


def _unsure(chance: np.ndarray) -> np.ndarray:
    """Return in which frames (n, P) each point is unsure, short sure times in between included."""
    unsure = np.nanmean(chance, axis=1) < SURE
    return np.asarray(binary_closing(
        np.pad(unsure, ((AGAIN_FRAMES, AGAIN_FRAMES), (0, 0))), np.ones((AGAIN_FRAMES, 1))
    )[AGAIN_FRAMES:-AGAIN_FRAMES])  # fmt: skip


def _choose(state: _State, n: int) -> Iterator[tuple[int, list[int], float]]:
    """Yield row, points and gain of each of ``n`` frames to click, the best first.

    The state is changed.
    """
    rows = np.arange(len(state.wrong))
    for _ in range(n):
        mended, gain = state.gains()
        gain = np.where(state.free, gain, 0.0)
        if not len(gain) or gain.max() == 0.0:
            return
        t = int(gain.argmax())
        points = [int(p) for p in np.argsort(-mended[t], kind="stable") if mended[t, p] > 0.0]
        yield t, points, float(gain[t])
        for p in points:
            own = state.stretch[:, p] == state.stretch[t, p]
            state.wrong[own, p] *= -np.expm1(-np.abs(rows[own] - t) / state.holds)
        state.free &= np.abs(rows - t) > APART_FRAMES


def _mended(wrong: np.ndarray, stretch: np.ndarray, holds: float) -> np.ndarray:
    """Return how many labels of each point a click in each frame mends (n, P)."""
    mended = np.zeros(wrong.shape)
    decay = ([1.0], [1.0, -np.exp(-1.0 / holds)])
    for p in range(wrong.shape[1]):
        for number in np.unique(stretch[stretch[:, p] >= 0, p]):
            own = stretch[:, p] == number
            here = wrong[own, p]
            # the sum of what is before, weighted by nearness, and of what is after
            mended[own, p] = lfilter(*decay, here) + lfilter(*decay, here[::-1])[::-1] - here
    return mended
