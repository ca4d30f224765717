"""Truth of a rendered spider: poses, points, events and phases as tables."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
import pandas as pd
from scipy.optimize import minimize_scalar

from pawnb.arrays import BoolArray, FloatArray, IntArray
from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.poses import Poses
from pawnb.schema import EVENTS_COLUMNS, PHASES_COLUMNS, TRACKS_COLUMNS
from pawnb.synthetic.spider_motion import FootMotion, SpiderMotion

PAIRS = tuple(
    (f"{a}{i}", f"{b}{j}")
    for a, i, b, j in (
        *(("L", n, "R", n) for n in range(1, 5)),
        *((s, n, s, n + k) for k in range(1, 4) for n in range(1, 5 - k) for s in "LR"),
    )
)
"""Pairs of legs of Pullar 2009, §4.2.4: (leg, reference)."""

_SCAN = 400
_TIME_CLOSE_S = 1e-8


def pose_truth(animal: StickAnimal, poses: Poses) -> pd.DataFrame:
    """Return the columns of pose.csv.

    Parameters
    ----------
    animal : StickAnimal
        Names of joints and segments.
    poses : Poses
        Its poses.

    Returns
    -------
    pandas.DataFrame
        frame, x, y, heading, joints, scale, ``<leg>_<segment>_px``.
    """
    columns: dict[str, np.ndarray] = {
        "frame": poses.frames,
        "x": poses.xy[:, 0],
        "y": poses.xy[:, 1],
        "heading": poses.heading_deg,
    }
    columns.update(zip(animal.joints, poses.angles_deg.T, strict=True))
    columns["scale"] = poses.scale
    lengths = [f"{segment}_px" for segment in animal.segments]
    columns.update(zip(lengths, poses.lengths_px.T, strict=True))
    return pd.DataFrame(columns)


def start_truth(animal: StickAnimal, poses: Poses) -> pd.DataFrame:
    """Return the columns of start_pose.csv for the first of the poses."""
    columns = ["frame", "x", "y", "heading", "scale", *animal.joints]
    return pose_truth(animal, poses)[columns].iloc[:1].round(3)


def point_names(animal: StickAnimal) -> tuple[str, ...]:
    """Return ``body``, the tips (``L1``) and the joints (``L1.BC``) in the order of the tables."""
    joints = (f"{leg.name}.{joint}" for leg in animal.legs for joint in leg.joints)
    return ("body", *animal.leg_names, *joints)


def points_px(body: FloatArray, joints: FloatArray) -> FloatArray:
    """Return the points of :func:`point_names`, shape (n, points, k).

    Parameters
    ----------
    body : ndarray (n, k)
        The cephalothorax-abdomen joint.
    joints : ndarray (n, legs, segments + 1, k)
        Joints and tips.
    """
    n, k = body.shape
    inner = joints[:, :, :-1].reshape(n, -1, k)
    return np.concatenate([body[:, None], joints[:, :, -1], inner], axis=1)


def tracks_truth(
    names: Sequence[str], frames: IntArray, points: FloatArray, *, view: str, visible: BoolArray
) -> pd.DataFrame:
    """Return the columns of tracks.csv, then ``visible``.

    Parameters
    ----------
    names : sequence of str
        Points.
    frames : ndarray (n,)
        Frame numbers.
    points : ndarray (n, points, 2)
        u, v in px.
    view : str
        Name of the view.
    visible : ndarray (n, points) of bool
        Whether a point is in the picture and not under the body.

    Returns
    -------
    pandas.DataFrame
        One row a frame and point.
    """
    n, m = points.shape[:2]
    table = pd.DataFrame(
        {
            "frame": np.repeat(frames, m),
            "view": view,
            "point": np.tile(np.array(names, dtype=object), n),
            "u": points[..., 0].ravel(),
            "v": points[..., 1].ravel(),
            "confidence": 1.0,
            "origin": "measured",
        }
    )
    return table[list(TRACKS_COLUMNS)].assign(visible=visible.ravel().astype(int))


def under_body(animal: StickAnimal, poses: Poses, points: FloatArray) -> BoolArray:
    """Return which points (n, points, 2) lie within one of the body's ellipses.

    Parameters
    ----------
    animal : StickAnimal
        The animal.
    poses : Poses
        Its poses, n of them.
    points : ndarray, shape (n, points, 2)
        Places in the picture, px.

    Returns
    -------
    ndarray of bool, shape (n, points)
        True within the body.
    """
    turn = np.radians(poses.heading_deg)[:, None]
    away = (points - poses.xy[:, None]) / poses.scale[:, None, None]
    x = away[..., 0] * np.cos(turn) + away[..., 1] * np.sin(turn)
    y = away[..., 1] * np.cos(turn) - away[..., 0] * np.sin(turn)
    inside = np.zeros(points.shape[:2], dtype=bool)
    for part in animal.body:
        across = 2 * (y - part.centre[1]) / part.width
        inside |= (2 * (x - part.centre[0]) / part.length) ** 2 + across**2 < 1
    return inside


def leg_extremes(motion: SpiderMotion, leg: str) -> tuple[FloatArray, FloatArray]:
    """Return the times, s, of the AEPs and PEPs of a leg.

    The extremes of its total angle (Pullar 2009, §3.6): the maximum between the middle of a
    swing and the middle of the stance after it, the minimum from there to the middle of the
    next swing.
    """
    foot: FootMotion = motion.feet[leg]
    down, off = foot.touch_down_s, foot.lift_off_s
    swing = (off[:-1] + down[1:]) / 2.0
    stance = (down + off)[1:] / 2.0
    aep = [_peak(motion, leg, (a, b), 1.0) for a, b in zip(swing, stance, strict=True)]
    pep = [_peak(motion, leg, (a, b), -1.0) for a, b in zip(stance[:-1], swing[1:], strict=True)]
    return np.array(aep), np.array(pep)


def _peak(motion: SpiderMotion, leg: str, span: tuple[float, float], sign: float) -> float:
    """Return when the leg's angle times ``sign`` is greatest within a span, s."""
    t = np.linspace(*span, _SCAN)
    best = int(np.argmax(sign * motion.leg_angle(leg, t)))
    around = (t[max(best - 1, 0)], t[min(best + 1, _SCAN - 1)])
    found = minimize_scalar(
        lambda x: -sign * float(motion.leg_angle(leg, np.array([x]))[0]),
        bounds=around,
        method="bounded",
        options={"xatol": _TIME_CLOSE_S},
    )
    return float(found.x)


def events_truth(
    motion: SpiderMotion, *, fps: float, frames: tuple[int, int], animal: str, trial: str
) -> pd.DataFrame:
    """Return the columns of events.csv: AEP and PEP in fractional frames.

    Parameters
    ----------
    motion : SpiderMotion
        The run.
    fps : float
        Frames per second.
    frames : tuple of int
        First and last frame in which the whole animal is in view; others hold no events.
    animal, trial : str
        Names.

    Returns
    -------
    pandas.DataFrame
        One row an event.
    """
    rows = []
    for leg in sorted(motion.feet):
        aep, pep = leg_extremes(motion, leg)
        both = [("AEP", t) for t in aep] + [("PEP", t) for t in pep]
        for event, t in sorted(both, key=lambda row: row[1]):
            if frames[0] <= t * fps <= frames[1]:
                rows.append((animal, trial, leg, event, t * fps, t, "truth"))
    return pd.DataFrame(rows, columns=list(EVENTS_COLUMNS))


def phases_truth(events: pd.DataFrame) -> pd.DataFrame:
    """Return the columns of phases.csv: Eq. 3.21 for the pairs of §4.2.4.

    A phase is the time of the leg's AEP within the reference's stride, from AEP to AEP, as a
    share of that stride.
    """
    rows = []
    aep = events[events["event"] == "AEP"]
    for leg, reference in PAIRS:
        own = aep.loc[aep["leg"] == leg, "time_s"].to_numpy()
        base = aep.loc[aep["leg"] == reference, "time_s"].to_numpy()
        for stride, (start, end) in enumerate(itertools.pairwise(base)):
            for t in own[(own >= start) & (own < end)]:
                who = aep.iloc[0]
                phase = (t - start) / (end - start)
                rows.append((who["animal"], who["trial"], leg, reference, stride, phase))
    return pd.DataFrame(rows, columns=list(PHASES_COLUMNS))
