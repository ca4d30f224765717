"""Which frames a person should look at, and why: doubts about tracks, most doubtful first.

Nothing is known here of what is true. A label (one point in one view and frame) is
doubted for several kinds of *evidence*, each measured in units of the trial's own
level, so that no limit in pixels has to be set: how far its views disagree, how it moves
compared with how it usually moves, where it is compared with where it usually is, how long
it was only predicted, whether another point is in the same place, and, where the recording
was tracked backwards too, how far both passes disagree.

Frames are then chosen one by one: the frame with the most doubt over all points comes
first, and calms the doubts about the frames around it, for whoever looks at one frame
of a stride sees what is wrong in the rest of it. What a person has placed is not doubted.

Trackers err in two ways. Those that go on from frame to frame lose points for long, and several
at once; they are judged by how their tracks move and how far their views disagree. Those that
decide over the whole recording err briefly, and smoothly; their tracks carry their
uncertainty (``sd``) and are judged by it (:mod:`pawnb.core.suspect_uncertainty`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from pawnb.core.rig import Rig
from pawnb.core.suspect_evidence import Evidence, collect_evidence
from pawnb.core.suspect_uncertainty import add_up, collect_uncertainty, states_uncertainty
from pawnb.errors import InputError
from pawnb.schema import ORIGIN_CODE, SUSPECTS_COLUMNS, Tracks, check_tracks

_TELLING = 0.5
"""A second point or reason is told where it weighs at least this much of the first."""

_APART_FRAMES = 25.0
"""One stride of a fast mouse at 250 frames per second: how long a lost paw is lost."""
_APART_FRAMES_CERTAIN = 12.0
"""Half of it: errors of a tracker that states its uncertainty are brief."""

_REACH = 8
"""Doubts further away than this many ``apart_frames`` are not calmed (by 0.03 %)."""


@dataclass(frozen=True, kw_only=True)
class SuspectSettings:
    """What counts as doubtful.

    Parameters
    ----------
    apart_frames : float, optional
        How far apart listed frames should be: doubts about frames nearer than a quarter of
        this are dropped, others are weakened by exp(-distance / apart_frames). Default: 25,
        one stride of a fast mouse at 250 frames per second, or 12 for tracks with ``sd``.
    paw_px : float, optional
        Size of a paw in px; two points of one view that are nearer than this cross. Default:
        a quarter of the usual distance between two points of that view.
    least_score : float
        Frames whose score is below this are left out.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    apart_frames: float | None = None
    paw_px: float | None = None
    least_score: float = 1.0

    def __post_init__(self) -> None:
        """Check the ranges."""
        for name in ("apart_frames", "paw_px", "least_score"):
            value = getattr(self, name)
            if value is not None and not 0 < value < float("inf"):
                raise InputError(f"setting {name!r} is {value}; expected a number above 0.")


def find_suspects(
    tracks: Tracks,
    *,
    rig: Rig | None = None,
    settings: SuspectSettings | None = None,
    other: Tracks | None = None,
) -> pd.DataFrame:
    """Rank the frames, views and points that a person should look at.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks with image positions.
    rig : Rig, optional
        The calibrated views; with it the error of reprojection is told view by view, else
        the residual of the tracks counts in each view.
    settings : SuspectSettings, optional
        What counts as doubtful.
    other : xarray.Dataset, optional
        Tracks of the same recording made another way, for instance from the last frame
        backwards: where both disagree, one of them is wrong.

    Returns
    -------
    DataFrame
        frame, view, point, reason (plain words), score; most doubtful first. A listed frame
        has one row for each point that is doubted there, the worst first, in the view
        where it is doubted most. The score is that of the frame: the doubts about all
        points added up, in robust standard deviations (for tracks with ``sd``: how much they
        are above those of four frames in five), less what frames listed before it have
        calmed.

    Raises
    ------
    InputError
        If the tracks have no image positions, or ``other`` shares no view and point with
        them.
    """
    check_tracks(tracks)
    if "image_position" not in tracks:
        raise InputError("these tracks have no image positions; suspects need them.")
    settings = settings or SuspectSettings()
    if states_uncertainty(tracks):
        evidence = collect_uncertainty(tracks, rig=rig, other=other, paw_px=settings.paw_px)
        total, apart = add_up(tracks, evidence), _APART_FRAMES_CERTAIN
    else:
        evidence = collect_evidence(tracks, rig=rig, other=other, paw_px=settings.paw_px)
        total = np.sqrt(np.sum([np.square(item.score) for item in evidence], axis=0))
        apart = _APART_FRAMES
    frames = tracks["frame"].to_numpy()
    views = tracks["view"].to_numpy().tolist()
    points = tracks["keypoint"].to_numpy().tolist()
    by_hand = tracks["image_origin"].isel(individual=0).to_numpy() == ORIGIN_CODE["edited"]
    total[by_hand] = 0.0
    rows = []
    for t, score, doubts in choose_frames(
        total.max(axis=1),
        frames,
        apart=settings.apart_frames or apart,
        least_score=settings.least_score,
    ):
        for p in np.argsort(-doubts, kind="stable").tolist():
            if doubts[p] >= _TELLING * doubts.max():
                v = int(total[t, :, p].argmax())
                said = _in_words(evidence, (t, v, p))
                rows.append((int(frames[t]), views[v], points[p], said, round(score, 3)))
    return pd.DataFrame(rows, columns=list(SUSPECTS_COLUMNS))


def choose_frames(
    doubts: np.ndarray, frames: np.ndarray, *, apart: float, least_score: float
) -> list[tuple[int, float, np.ndarray]]:
    """Take the frame with most doubt, calm the frames around it, and go on with the next.

    Parameters
    ----------
    doubts : ndarray, shape (n, P)
        Doubt about each point in each frame.
    frames : ndarray of int, shape (n,)
        Their numbers.
    apart, least_score : float
        As in :class:`SuspectSettings`.

    Returns
    -------
    list of (int, float, ndarray)
        Row, score and the doubts of its points (P,), highest score first.
    """
    left = doubts.copy()
    gain = left.sum(axis=1)
    reach = _REACH * apart
    chosen = []
    while len(gain) and gain.max() >= least_score:
        t = int(gain.argmax())
        chosen.append((t, float(gain[t]), left[t].copy()))
        near = slice(*np.searchsorted(frames, [frames[t] - reach, frames[t] + reach]).tolist())
        away = np.abs(frames[near] - frames[t]) / apart
        left[near] *= np.where(away < 0.25, 0.0, 1.0 - np.exp(-away))[:, None]
        gain[near] = left[near].sum(axis=1)
    return chosen


def _in_words(evidence: list[Evidence], key: tuple[int, int, int]) -> str:
    """Return the heaviest evidence of a label, and the next if it weighs enough."""
    ranked = sorted(evidence, key=lambda item: -item.score[key])
    said = [ranked[0].words(key)]
    if ranked[1].score[key] >= _TELLING * ranked[0].score[key]:
        said.append(ranked[1].words(key))
    return "; ".join(said)
