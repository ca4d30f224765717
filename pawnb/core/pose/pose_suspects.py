"""Which frames of a tracked jointed animal a person should look at, and why.

Nothing is known here of what is true. A leg in a frame is doubted for six kinds of evidence.
Each is 0 up to where it is ordinary, grows by 1 for each further step of the same size, and
counts 3 at most:

- the picture explains it badly: confidence below half the usual;
- a joint turns faster than it usually does: further than four robust standard deviations of
  its own turns from frame to frame, and at least 10 degrees;
- a joint is beyond its range by more than 10 degrees (ranges are soft at their ends);
- it crosses another leg;
- its tip is three times as uncertain as usual, where the method tells that;
- the film stood still before it: legs that swung meanwhile may have been exchanged.

In a film that stands still nothing is seen of any leg: its first such frame is listed, and says so.
Frames are chosen as for points (:mod:`pawnb.core.suspects.frames`): the most doubtful first, and it
calms the doubts about the frames around it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from pawnb.arrays import BoolArray, FloatArray, IntArray
from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.as_tracks import animal_of, poses_of
from pawnb.core.pose.poses import joint_positions
from pawnb.core.pose.track_result import PoseTrack
from pawnb.core.suspects.frames import SECOND_SHARE, choose_frames
from pawnb.core.video.doubts.frozen_labels import freezes_in_words, freezes_of_tracks
from pawnb.schema import ORIGIN_CODE, SUSPECTS_COLUMNS, Tracks
from pawnb.signals.robust import MAD_TO_SD

_USUAL_CONFIDENCE = 0.5
"""A leg is doubted below this share of its usual confidence."""
_TURN_SD, _LEAST_TURN_DEG = 4.0, 10.0
_BEYOND_DEG = 10.0
"""A joint so far beyond its range is doubted: ranges are soft at their ends."""
_VAGUE_TIP = 3.0
"""A tip is doubted where its SD is so many times the usual one."""
_POSES_APART_FRAMES = 12.0
"""About half a stride of a running spider at 125 frames per second."""
_LEAST_SCORE = 0.5
"""Frames with less doubt than this are not listed."""
_MOST_DOUBT = 3.0
"""What one reason adds at most, so that none drowns the others."""
_AT_CONFIDENCE = (0.0, 0.02, 0.2, 0.6, 1.0)
_TIPS_RIGHT = (0.57, 0.85, 0.92, 0.96, 0.995)
"""How often a tip is right, by the confidence of its leg: within 12 px of SLEAP's surer than 0.7 on
a real fly (flies-topview, 2016 tips from four starts); of three rendered spiders, of which only 24
of 1896 tips are below 0.8, all are right, as are the legs of spider-nephila (0.92 and more)."""

_RIGHT_APART, _RIGHT_CROSSED = (0.7, 0.1)
"""How often a tip of ``method="paper"`` is right, by whether its leg crosses another: within 5 % of
the leg span in two rendered spiders (``pawnb demo spider``, seed 0 at scale 0.3, 400 frames, seed 2
at 0.5, 260 frames: 0.73 and 0.69 of 1253 tips, 0.07 and 0.09 of 1683; the body is right in all
frames). In a third, seed 5 at 0.3, 200 frames, not looked at for it: 0.67 of 756 and 0.13 of 500.
Legs of the true poses cross in 0.01 to 0.05."""


@dataclass(frozen=True)
class _Doubt:
    """One kind of evidence: its weight (n, legs), and words with ``{}`` for a number."""

    words: str
    score: FloatArray
    value: FloatArray


def find_pose_suspects(tracks: Tracks) -> pd.DataFrame:
    """Rank the frames and legs that a person should look at.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks of a jointed animal.

    Returns
    -------
    DataFrame
        frame, view, point (the leg), reason (plain words), score; most doubtful first.

    Raises
    ------
    InputError
        If the tracks are not those of a jointed animal.
    """
    animal, track = animal_of(tracks), poses_of(tracks)
    doubts = [
        _badly_explained(track),
        _turns_fast(animal, track),
        _beyond_range(animal, track),
        _crosses(animal, track),
        _vague(animal, track),
    ]
    freezes = [freeze for own in freezes_of_tracks(tracks).values() for freeze in own]
    doubts.append(_after_freeze(track, freezes))
    total = np.sum([np.minimum(doubt.score, _MOST_DOUBT) for doubt in doubts], axis=0)
    settled = np.isin(track.origin, (ORIGIN_CODE["edited"], ORIGIN_CODE["missing"]))
    frames, view = track.poses.frames, str(tracks["view"].to_numpy()[0])
    frozen = np.zeros(len(frames), bool)
    for begin, stop in freezes:
        frozen |= (frames >= begin) & (frames < stop)
    total[settled] = 0.0
    total[frozen] = 0.0
    rows = _freeze_rows(animal, frames, settled, freezes, view=view)
    for t, score, left in choose_frames(
        total, frames, apart=_POSES_APART_FRAMES, least_score=_LEAST_SCORE
    ):
        for leg in np.argsort(-left, kind="stable").tolist():
            if left[leg] > 0 and left[leg] >= SECOND_SHARE * left.max():
                reason = _in_words(doubts, t, leg)
                rows.append((int(frames[t]), view, animal.leg_names[leg], reason, round(score, 3)))
    rows.sort(key=lambda row: -row[-1])
    return pd.DataFrame(rows, columns=list(SUSPECTS_COLUMNS))


def _freeze_rows(
    animal: StickAnimal,
    frames: IntArray,
    settled: BoolArray,
    freezes: Sequence[tuple[int, int]],
    *,
    view: str,
) -> list[tuple[int, str, str, str, float]]:
    """List the first frame of each freeze, with each leg that nobody has placed there."""
    rows = []
    for freeze in freezes:
        t = int(np.searchsorted(frames, freeze[0]))
        reason = f"the film stands still in {freezes_in_words([freeze])}: nothing is seen of it"
        legs = [name for leg, name in enumerate(animal.leg_names) if not settled[t, leg]]
        rows += [(int(frames[t]), view, name, reason, float(len(legs))) for name in legs]
    return rows


def chances_of_tips(confidence: FloatArray) -> FloatArray:
    """Return how likely the tip of a leg is right, by how much of the leg the picture shows.

    Parameters
    ----------
    confidence : ndarray
        Of the default tracker in one view, 0 to 1.

    Returns
    -------
    ndarray
        0 to 1, of the same shape. A leg that the picture does not show is right now and then only:
        it follows its body and its own usual motion.
    """
    return np.interp(np.nan_to_num(confidence), _AT_CONFIDENCE, _TIPS_RIGHT)


def chances_of_crossing(tracks: Tracks) -> FloatArray:
    """Return how likely body and tips are right, by whether legs cross.

    A leg that is on another's place crosses the legs between the two, which animals seldom do.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks of a jointed animal, of method ``paper``: its confidence is no evidence, as the shape
        prior makes pixels along a leg subject.

    Returns
    -------
    ndarray, shape (n, 1 + legs)
        0 to 1, of the body and the tips of the legs.
    """
    animal, track = animal_of(tracks), poses_of(tracks)
    crossed = _crosses(animal, track).score > 0
    tips = np.where(crossed, _RIGHT_CROSSED, _RIGHT_APART)
    return np.column_stack([np.ones(len(track)), tips])


def _in_words(doubts: list[_Doubt], t: int, leg: int) -> str:
    """Return the heaviest evidence, and the next where it weighs enough."""
    ranked = sorted(doubts, key=lambda doubt: -doubt.score[t, leg])
    heaviest = ranked[0].score[t, leg]
    return "; ".join(
        doubt.words.format(float(doubt.value[t, leg]))
        for doubt in ranked[:2]
        if doubt.score[t, leg] >= SECOND_SHARE * heaviest
    )


def _badly_explained(track: PoseTrack) -> _Doubt:
    """Doubt legs whose confidence is below half the usual."""
    usual = max(float(np.median(track.confidence)) if len(track) else 0.0, 1e-6)
    share = track.confidence / usual
    score = np.maximum(1.0 - share / _USUAL_CONFIDENCE, 0.0)
    return _Doubt("the picture hardly shows it (confidence {:.2f})", score, track.confidence)


def _turns_fast(animal: StickAnimal, track: PoseTrack) -> _Doubt:
    """Doubt legs of which a joint turns implausibly fast, in both frames of the turn."""
    steps = np.diff(track.poses.frames)[:, None]
    turns = (np.diff(track.poses.angles_deg, axis=0) + 180.0) % 360.0 - 180.0
    turns = np.abs(np.where(steps == 1, turns, np.nan))
    known = turns[np.isfinite(turns).all(axis=1)]
    spread = MAD_TO_SD * np.median(known, axis=0) if len(known) else np.zeros(turns.shape[1])
    limit = np.maximum(_TURN_SD * spread, _LEAST_TURN_DEG)
    fast = np.nan_to_num(np.maximum(turns / limit - 1.0, 0.0))
    turned = np.nan_to_num(turns)
    pad = np.zeros((1, turns.shape[1]))
    both = np.maximum(np.concatenate([fast, pad]), np.concatenate([pad, fast]))[: len(track)]
    value = np.maximum(np.concatenate([turned, pad]), np.concatenate([pad, turned]))[: len(track)]
    return _Doubt(
        "a joint turns by {:.0f} degrees from one frame to the next",
        _worst_of_leg(animal, both),
        _worst_of_leg(animal, np.where(both > 0, value, 0.0)),
    )


def _beyond_range(animal: StickAnimal, track: PoseTrack) -> _Doubt:
    """Doubt legs of which a joint is beyond its mechanical range."""
    beyond = _degrees_beyond(animal, track.poses.angles_deg)
    score = np.maximum(beyond / _BEYOND_DEG - 1.0, 0.0)
    return _Doubt(
        "a joint is {:.0f} degrees beyond its range",
        _worst_of_leg(animal, score),
        _worst_of_leg(animal, beyond),
    )


def _degrees_beyond(animal: StickAnimal, angles_deg: FloatArray) -> FloatArray:
    """Return how far each free joint is beyond its range, degrees; shape (n, n_joints)."""
    off = np.abs((angles_deg - animal.natural_deg + 180.0) % 360.0 - 180.0)
    return np.nan_to_num(np.maximum(off - animal.range_deg / 2.0, 0.0))


def joints_beyond_range(animal: StickAnimal, angles_deg: FloatArray) -> dict[str, float]:
    """Return the joints of one pose that are beyond their range.

    Parameters
    ----------
    animal : StickAnimal
        The animal.
    angles_deg : ndarray, shape (n_joints,)
        Free joints, degrees.

    Returns
    -------
    dict
        ``<leg>_<joint>`` to how far beyond it is, degrees.
    """
    beyond = _degrees_beyond(animal, angles_deg[None])[0]
    return {name: float(far) for name, far in zip(animal.joints, beyond, strict=True) if far > 1e-9}


def _crosses(animal: StickAnimal, track: PoseTrack) -> _Doubt:
    """Doubt legs that cross another leg."""
    places = joint_positions(animal, track.poses)
    crossed = np.zeros(track.confidence.shape)
    for a in range(len(animal.legs)):
        for b in range(a):
            cross = _chains_cross(places[:, a], places[:, b])
            crossed[:, a] += cross
            crossed[:, b] += cross
    return _Doubt("it crosses another leg", crossed, crossed)


def _chains_cross(a: FloatArray, b: FloatArray) -> BoolArray:
    """Say in which frames two chains of segments (n, most + 1, 2) cross; NaN never does."""
    p, q = a[:, :-1, None], a[:, 1:, None]
    r, s = b[:, None, :-1], b[:, None, 1:]

    def side(o: FloatArray, d: FloatArray, x: FloatArray) -> FloatArray:
        u, v = d - o, x - o
        return np.asarray(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0])

    cross = (side(p, q, r) * side(p, q, s) < 0) & (side(r, s, p) * side(r, s, q) < 0)
    return np.asarray(cross.any(axis=(1, 2)))


def _vague(animal: StickAnimal, track: PoseTrack) -> _Doubt:
    """Doubt legs whose tips are far more uncertain than usual."""
    last = [len(leg.segments) for leg in animal.legs]
    sd = np.hypot(*np.moveaxis(track.places_sd_px[:, np.arange(len(last)), last], -1, 0))
    known = sd[np.isfinite(sd)]
    usual = max(float(np.median(known)) if len(known) else 1.0, 1e-6)
    score = np.nan_to_num(np.maximum(sd / (_VAGUE_TIP * usual) - 1.0, 0.0))
    return _Doubt("its tip is only known to {:.1f} px", score, np.nan_to_num(sd))


def _after_freeze(track: PoseTrack, freezes: Sequence[tuple[int, int]]) -> _Doubt:
    """Doubt every leg in the first frame after a film stood still."""
    first = np.isin(track.poses.frames, [stop for _, stop in freezes])
    score = np.where(first[:, None], 1.0, np.zeros(track.confidence.shape))
    return _Doubt("the film stood still before, and legs may be exchanged", score, score)


def _worst_of_leg(animal: StickAnimal, of_joints: FloatArray) -> FloatArray:
    """Return the greatest value over the free joints of each leg, shape (n, n_legs)."""
    ends = np.cumsum([sum(leg.free) for leg in animal.legs])[:-1]
    return np.stack([part.max(axis=1) for part in np.split(of_joints, ends, axis=1)], axis=1)
