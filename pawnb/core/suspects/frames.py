"""Which frames a person should look at, and why: doubts about tracks, most doubtful first.

Nothing is known here of what is true, and what a person has placed is not doubted. Trackers err
in two ways. Those that decide over the whole recording err briefly, and smoothly; their tracks
carry their uncertainty (``sd``). What they say of themselves
(:mod:`pawnb.core.suspects.uncertainty`), how far candidates are ahead of others and passes
forwards and backwards are apart among it, is turned into the number of errors to be expected
(:mod:`pawnb.core.suspects.rates`), together with what no sound track shows: errors of reprojection
and speeds that no paw has (:mod:`pawnb.core.suspects.limits`). Frames are chosen one by one: that
where a look is expected to find most of what earlier looks have not shown.

Trackers that go on from frame to frame lose points for long, and several at once. A label (one
point in one view and frame) is doubted for several kinds of *evidence*, each measured in units
of the trial's own level, so that no limit in pixels has to be set: how far its views disagree,
how it moves compared with how it usually moves, where it is compared with where it usually
is, how long it was only predicted, whether another point is in the same place, and, where the
recording was tracked backwards too, how far both passes disagree. The frame with the most doubt
over all points comes first, and calms the doubts about the frames around it, for whoever
looks at one frame of a stride sees what is wrong in the rest of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from pawnb.arrays import BoolArray, FloatArray, IntArray
from pawnb.core.paws.offline.quality.measures import CALIBRATED
from pawnb.core.paws.offline.self_training.doubted_clicks import doubted_clicks_of
from pawnb.core.rig import Rig
from pawnb.core.suspects.chances import SEEN_AROUND_FRAMES, doubted_labels
from pawnb.core.suspects.evidence import LabelEvidence, collect_evidence, image_positions
from pawnb.core.suspects.limits import collect_limits
from pawnb.core.suspects.rates import WRONG_AROUND_FRAMES, choose_looks, error_rates, weigh
from pawnb.core.suspects.uncertainty import Doubt, collect_doubts, recognised, states_uncertainty
from pawnb.errors import InputError
from pawnb.schema import ORIGIN_CODE, SUSPECTS_COLUMNS, Tracks, check_tracks

SECOND_SHARE = 0.5
"""A second point or reason is named where it weighs at least this much of the first."""

_POINTS_APART_FRAMES = 25.0
"""One stride of a fast mouse at 250 frames per second: how long a lost paw is lost."""
_LEAST_DEVIATIONS = 1.0
"""Frames with less doubt than this are not listed, of tracks without uncertainty."""
_LEAST_ERRORS = 0.02
"""Who looks at fifty frames for one error has found nearly all of them."""
_LEAST_WRONG = 0.1
"""Of labels that state their chance of being right, those are listed that are wrong with this one
or a larger: a recording whose labels all are surer is good."""
_LEAST_CHANCE_SHARE = 0.02
"""This share of frames is listed in any case: a recording may err where no other did."""

_FRAMES_REACHED = 8
"""Doubts further away than this many ``apart_frames`` are not calmed (by 0.03 %)."""


Row = tuple[int, str, str, str, float]
"""One row of the list: frame, view, point, reason, score."""


@dataclass(frozen=True, kw_only=True)
class SuspectSettings:
    """What counts as doubtful.

    Parameters
    ----------
    apart_frames : float, optional
        How far apart listed frames should be. For tracks with ``sd``: what is wrong within half
        of this is seen from a frame (default 10). For others: doubts about frames nearer
        than a quarter of this are dropped, others are weakened by exp(-distance /
        apart_frames) (default 25, one stride of a fast mouse at 250 frames per second).
    paw_px : float, optional
        Size of a paw in px; two points of one view that are nearer than this cross. Default:
        a quarter of the usual distance between two points of that view.
    least_score : float, optional
        Frames whose score is below this are left out. Default: 1, or for tracks with
        ``sd`` 0.02, but then one frame in fifty is listed in any case.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    apart_frames: float | None = None
    paw_px: float | None = None
    least_score: float | None = None

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
        The calibrated views; with it the error of reprojection is given view by view, else
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
        where it is doubted most. The score is that of the frame. For tracks with ``sd`` it is
        the number of errors that a look at it, and at the five frames before and after, is
        expected to find besides those that frames listed before it show; scores of
        several recordings can be compared. For others it is the doubts about all points added
        up, in robust standard deviations, less what frames listed before have calmed. Where
        ``image_confidence`` is the chance of being right, every label that is wrong with a chance
        of 0.1 and more has a row of its own; the score is the number of labels that a look at it
        is expected to show as wrong besides those that rows before it show
        (:mod:`pawnb.core.suspects.chances`). So has a click that those of other frames
        contradict, for the labels that are nearer to it than to another click.

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
    if tracks["image_confidence"].attrs.get(CALIBRATED):
        rows = _by_chance(tracks, settings)
    elif states_uncertainty(tracks):
        rows = _by_expected_errors(tracks, rig, settings, other)
    else:
        rows = _by_evidence(tracks, rig, settings, other)
    return pd.DataFrame(rows, columns=list(SUSPECTS_COLUMNS))


def _by_expected_errors(
    tracks: Tracks, rig: Rig | None, settings: SuspectSettings, other: Tracks | None
) -> list[Row]:
    """List the frames of tracks that state their uncertainty."""
    frames = tracks["frame"].to_numpy()
    views, points = (tracks[name].to_numpy().tolist() for name in ("view", "keypoint"))
    doubts = collect_doubts(tracks, rig=rig, other=other, paw_px=settings.paw_px)
    doubts += collect_limits(tracks, paw_px=settings.paw_px)
    # who has placed a point in one view has seen to all of it
    by_hand = _placed_by_hand(tracks).any(axis=1)
    known = np.isfinite(image_positions(tracks)[..., 0]).any(axis=1)
    looks = choose_looks(
        np.where(known & ~by_hand, error_rates(doubts), 0.0),
        frames,
        around=WRONG_AROUND_FRAMES if settings.apart_frames is None else settings.apart_frames / 2,
        least=settings.least_score or _LEAST_ERRORS,
        at_least=0 if settings.least_score else round(_LEAST_CHANCE_SHARE * len(frames)),
    )
    weights = np.stack([weigh(doubt) for doubt in doubts])
    # it shows best where it is seen, and least like itself
    sure = tracks["image_confidence"].isel(individual=0).to_numpy()
    seen = recognised(tracks)
    showing = np.where(seen, 1.0 - np.nan_to_num(sure), -1.0)
    rows = []
    for t, score, expected, worst in looks:
        for p in np.argsort(-expected, kind="stable").tolist():
            if expected[p] >= SECOND_SHARE * expected.max():
                at = int(worst[p])
                # the frame that is listed is the one looked at: its views come first
                view = views[int((showing[at, :, p] + 2.0 * seen[t, :, p]).argmax())]
                when = _elsewhere_in_words(int(frames[at]), int(frames[t]))
                said = when + _heaviest(doubts, weights[:, at, p], at, p)
                rows.append((int(frames[t]), view, points[p], said, round(score, 4)))
    return rows


def _by_chance(tracks: Tracks, settings: SuspectSettings) -> list[Row]:
    """List the labels of tracks that state their own chance of being right."""
    frames = tracks["frame"].to_numpy()
    views, points = (tracks[name].to_numpy().tolist() for name in ("view", "keypoint"))
    chance = np.nan_to_num(tracks["image_confidence"].isel(individual=0).to_numpy())
    known = np.isfinite(image_positions(tracks)[..., 0])
    followed = known.any(axis=0)
    wrong = np.where(followed & ~_placed_by_hand(tracks), 1.0 - chance, 0.0)  # (n, V, P)
    listed = doubted_labels(
        wrong,
        frames,
        around=SEEN_AROUND_FRAMES if settings.apart_frames is None else settings.apart_frames / 2,
        least=settings.least_score or _LEAST_WRONG,
    )
    rows = []
    for label in listed:
        t, v, p = label.row, label.view, label.point
        sure = f"the tracker is {100 * (1 - wrong[t, v, p]):.0f} % sure of it"
        said = sure if known[t, v, p] else "it was not found here"
        rows.append((int(frames[t]), views[v], points[p], said, round(label.score, 4)))
    return sorted([*_by_clicks(tracks), *rows], key=lambda row: -row[-1])


def _by_clicks(tracks: Tracks) -> list[Row]:
    """List clicks that others contradict: labels are as wrong up to half way to the next click."""
    frames, rows = tracks["frame"].to_numpy(), []
    by_hand = _placed_by_hand(tracks)
    for one in doubted_clicks_of(tracks):
        v, p = (
            tracks[name].to_numpy().tolist().index(own)
            for name, own in (("view", one.view), ("keypoint", one.point))
        )
        others = frames[by_hand[:, v, p] & (frames != one.frame)]
        away = np.abs(frames[:, None] - others[None].astype(float)).min(axis=1, initial=np.inf)
        wrong = one.sure * float((np.abs(frames - one.frame) < away).sum())
        where = f"to the click of {one.other}" if one.other else "far from this click"
        said = f"clicks in other frames lead {where}"
        rows.append((one.frame, one.view, one.point, said, round(wrong, 4)))
    return rows


def _heaviest(doubts: list[Doubt], weights: FloatArray, row: int, point: int) -> str:
    """Return the heaviest reason to doubt a point, and the next if it weighs enough."""
    # circumstances come first only where nothing else speaks against the point
    reasons = np.where([doubt.is_circumstance for doubt in doubts], 0.0, weights)
    first = int(np.argmax(reasons))
    rest = np.where(np.arange(len(doubts)) == first, -np.inf, weights)
    second = int(np.argmax(rest))
    said = [doubts[first].words(row, point)]
    if weights[second] >= SECOND_SHARE * weights[first] > 0:
        said.append(doubts[second].words(row, point))
    return "; ".join(said)


def _elsewhere_in_words(doubted: int, listed: int) -> str:
    """Say in which frame a doubt lies that is not in the listed frame itself."""
    step = doubted - listed
    if step == 0:
        return ""
    return f"in frame {doubted}, {abs(step)} {'later' if step > 0 else 'before'}: "


def _by_evidence(
    tracks: Tracks, rig: Rig | None, settings: SuspectSettings, other: Tracks | None
) -> list[Row]:
    """List the frames of tracks that were made from frame to frame."""
    evidence = collect_evidence(tracks, rig=rig, other=other, paw_px=settings.paw_px)
    # one after the other: all squares of a long recording at once are hundreds of megabytes
    total = np.square(evidence[0].score)
    for item in evidence[1:]:
        total += np.square(item.score)
    np.sqrt(total, out=total)
    frames = tracks["frame"].to_numpy()
    views, points = (tracks[name].to_numpy().tolist() for name in ("view", "keypoint"))
    total[_placed_by_hand(tracks)] = 0.0
    rows = []
    for t, score, doubts in choose_frames(
        total.max(axis=1),
        frames,
        apart=settings.apart_frames or _POINTS_APART_FRAMES,
        least_score=settings.least_score or _LEAST_DEVIATIONS,
    ):
        for p in np.argsort(-doubts, kind="stable").tolist():
            if doubts[p] >= SECOND_SHARE * doubts.max():
                v = int(total[t, :, p].argmax())
                said = _in_words(evidence, (t, v, p))
                rows.append((int(frames[t]), views[v], points[p], said, round(score, 3)))
    return rows


def _placed_by_hand(tracks: Tracks) -> BoolArray:
    """Return which labels (n, V, P) a person has placed."""
    origin = tracks["image_origin"].isel(individual=0).to_numpy()
    return np.asarray(origin == ORIGIN_CODE["edited"])


def choose_frames(
    doubts: FloatArray, frames: IntArray, *, apart: float, least_score: float
) -> list[tuple[int, float, FloatArray]]:
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
    reach = _FRAMES_REACHED * apart
    chosen = []
    while len(gain) and gain.max() >= least_score:
        t = int(gain.argmax())
        chosen.append((t, float(gain[t]), left[t].copy()))
        near = slice(*np.searchsorted(frames, [frames[t] - reach, frames[t] + reach]).tolist())
        away = np.abs(frames[near] - frames[t]) / apart
        left[near] *= np.where(away < 0.25, 0.0, 1.0 - np.exp(-away))[:, None]
        gain[near] = left[near].sum(axis=1)
    return chosen


def _in_words(evidence: list[LabelEvidence], key: tuple[int, int, int]) -> str:
    """Return the heaviest evidence of a label, and the next if it weighs enough."""
    ranked = sorted(evidence, key=lambda item: -item.score[key])
    said = [ranked[0].words(key)]
    if ranked[1].score[key] >= SECOND_SHARE * ranked[0].score[key]:
        said.append(ranked[1].words(key))
    return "; ".join(said)
