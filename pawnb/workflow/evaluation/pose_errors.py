"""How good poses are: jitter, forward against reverse, and errors against exact truth.

The first two are the evaluations of Pullar 2009, §4.1 (Tables 4.1 and 4.2); with truth there is
more to say. Frames that one side lacks are left out, and counted.

A *swap* of legs is counted by this rule:

1. A leg is *taken for another* in a frame if its tip is farther than ``far_share`` of the leg span
   from its own true tip, and nearer to the true tip of another leg than to its own.
2. Frames in which a leg is taken for another make one swap if no more than ``gap_frames``
   tracked frames lie between one and the next, whichever leg it is taken for.
3. Two legs that change places make two swaps. Rates are per 1000 tracked frames.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.poses import Poses, leg_angles, tip_positions
from pawnb.core.pose.track_result import PoseTrack
from pawnb.errors import InputError

FAR_SHARE = 0.05
"""Tips nearer to their true place than this share of the leg span are never swapped."""

JITTER_COLUMNS = ("measure", "legs", "range", "sd", "unit")
DIRECTION_COLUMNS = ("measure", "legs", "rms_difference", "unit")
LEG_COLUMNS = (
    "leg", "n_frames", "tip_px_median", "tip_share_median", "tip_share_p95", "joint_rmse_deg",
    "leg_angle_rmse_deg", "leg_angle_bias_deg",
)  # fmt: skip
SWAP_COLUMNS = ("leg", "taken_for", "first_frame", "last_frame", "n_frames")

TOTAL = "total leg"


@dataclass(frozen=True, kw_only=True)
class PoseErrors:
    """Errors of poses against truth.

    Parameters
    ----------
    summary : DataFrame
        Columns measure, value, unit: one row a measure.
    legs : DataFrame
        One row a leg, ``LEG_COLUMNS``: shares are of the leg span; the root mean square error of
        joints is over the leg's free joints; the bias is the mean error of the leg angle.
    swaps : DataFrame
        One row a swap, ``SWAP_COLUMNS``; the rule is that of
        :mod:`pawnb.workflow.evaluation.pose_errors`.
    """

    summary: pd.DataFrame
    legs: pd.DataFrame
    swaps: pd.DataFrame

    def value(self, measure: str) -> float:
        """Return one number of the summary."""
        rows = self.summary.loc[self.summary["measure"] == measure, "value"]
        if rows.empty:
            known = ", ".join(self.summary["measure"])
            raise InputError(f"no measure {measure!r}; there are {known}.")
        return float(rows.iloc[0])


def build_jitter_table(animal: StickAnimal, poses: Poses) -> pd.DataFrame:
    """Tell how much the pose of an animal that keeps still varies (Table 4.1).

    Parameters
    ----------
    animal : StickAnimal
        The animal.
    poses : Poses
        Its poses in frames in which it does not move; frames without a pose are left out.

    Returns
    -------
    DataFrame
        ``JITTER_COLUMNS``: x, y and heading; then for each pair of legs every joint and the
        total leg angle: maximum less minimum, and standard deviation (n - 1), each the
        mean of the pair's two legs.

    Raises
    ------
    InputError
        If there are fewer than two poses.
    """
    poses = _there(poses)
    if len(poses) < 2:
        raise InputError(f"jitter needs two poses or more; found {len(poses)}.")
    return _by_pair(
        animal,
        {"x": poses.xy[:, 0], "y": poses.xy[:, 1]},
        {"heading": _unwrapped(poses.heading_deg)},
        _unwrapped(poses.angles_deg),
        _unwrapped(leg_angles(animal, poses)),
        {"range": np.ptp, "sd": lambda v: float(np.std(v, ddof=1))},
    )


def build_direction_table(animal: StickAnimal, forward: Poses, reverse: Poses) -> pd.DataFrame:
    """Compare tracking in one direction with tracking in the other (Table 4.2).

    Parameters
    ----------
    animal : StickAnimal
        The animal.
    forward, reverse : Poses
        The poses found either way, of which the frames they share are compared.

    Returns
    -------
    DataFrame
        ``DIRECTION_COLUMNS``: root mean square of the differences in x, y and heading; then,
        for each pair of legs, in every joint and in the total leg angle, the mean of the two
        legs' root mean squares.

    Raises
    ------
    InputError
        If they share no frame.
    """
    one, other = _shared(forward, reverse)
    xy = one.xy - other.xy
    return _by_pair(
        animal,
        {"x": xy[:, 0], "y": xy[:, 1]},
        {"heading": _wrapped(one.heading_deg - other.heading_deg)},
        _wrapped(one.angles_deg - other.angles_deg),
        _wrapped(leg_angles(animal, one) - leg_angles(animal, other)),
        {"rms_difference": _rms},
    )


def compare_directions(
    track: Callable[[Poses], PoseTrack],
    starts: tuple[Poses, Poses],
    *,
    animal: StickAnimal,
    disturb_px: float = 0.0,
    disturb_deg: float = 0.0,
    seed: int = 0,
) -> pd.DataFrame:
    """Track from the first frame forwards and from the last backwards, and compare (Table 4.2).

    Parameters
    ----------
    track : callable
        Tracks the whole recording from one start pose.
    starts : tuple of Poses
        The pose in the first frame and that in the last.
    animal : StickAnimal
        The animal.
    disturb_px, disturb_deg : float
        Standard deviation of what is added at random to each start pose: to x and y, and to
        the heading and every joint.
    seed : int
        Seed of that.

    Returns
    -------
    DataFrame
        As :func:`build_direction_table`.
    """
    rng = np.random.default_rng(seed)
    both = [
        track(disturbed(start, px=disturb_px, deg=disturb_deg, rng=rng)).poses for start in starts
    ]
    return build_direction_table(animal, *both)


def disturbed(poses: Poses, *, px: float, deg: float, rng: np.random.Generator) -> Poses:
    """Return poses with Gaussian errors: ``px`` in x and y, ``deg`` in heading and joints.

    Parameters
    ----------
    poses : Poses
        The poses.
    px : float
        Standard deviation in x and y, px.
    deg : float
        Standard deviation in heading and joints, degrees.
    rng : numpy.random.Generator
        Source of chance.

    Returns
    -------
    Poses
        The disturbed poses.
    """
    return Poses(
        frames=poses.frames,
        xy=poses.xy + rng.normal(0, px, poses.xy.shape),
        heading_deg=poses.heading_deg + rng.normal(0, deg, poses.heading_deg.shape),
        scale=poses.scale,
        angles_deg=poses.angles_deg + rng.normal(0, deg, poses.angles_deg.shape),
        lengths_px=poses.lengths_px,
    )


def measure_pose_errors(
    animal: StickAnimal,
    poses: Poses,
    truth: Poses,
    *,
    seen: np.ndarray | None = None,
    far_share: float = FAR_SHARE,
    gap_frames: int = 2,
) -> PoseErrors:
    """Measure the errors of poses against exact truth.

    Parameters
    ----------
    animal : StickAnimal
        The animal.
    poses : Poses
        Tracked poses; NaN where there is none.
    truth : Poses
        True poses.
    seen : ndarray of bool, shape (frames of the truth, legs), optional
        Where each leg is judged; default everywhere.
    far_share : float
        Share of the leg span: see the rule for swaps.
    gap_frames : int
        Frames between two parts of one swap.

    Returns
    -------
    PoseErrors
        The errors over the frames that both have. A leg that is judged nowhere has NaN.

    Raises
    ------
    InputError
        If they share no frame, or no leg is judged in any.
    """
    found, true = _shared(poses, truth)
    if seen is None:
        seen = np.ones((len(truth), len(animal.leg_names)), dtype=bool)
    seen = seen[np.isin(truth.frames, found.frames)]
    if not seen.any():
        raise InputError("no leg can be judged in any frame that has a pose.")
    span = animal.span * true.scale
    away = _tip_distances(animal, found, true)
    own = np.diagonal(away, axis1=1, axis2=2)
    share = own / span[:, None]
    owner = [animal.leg_names.index(name.rsplit("_", 1)[0]) for name in animal.joints]
    joints = np.where(seen[:, owner], _wrapped(found.angles_deg - true.angles_deg), np.nan)
    total = _wrapped(leg_angles(animal, found) - leg_angles(animal, true))
    heading = _wrapped(found.heading_deg - true.heading_deg)
    body = np.hypot(*(found.xy - true.xy).T)
    swaps = _swaps(animal, found.frames, away, far_share * span, gap_frames, seen=seen)
    rows = []
    for i, leg in enumerate(animal.leg_names):
        here = seen[:, i]
        if not here.any():
            rows.append((leg, 0, *[np.nan] * 6))
            continue
        cols = _joint_columns(animal, leg)
        rows.append(
            (leg, int(here.sum()), np.median(own[here, i]), np.median(share[here, i]),
             np.percentile(share[here, i], 95), _rms(joints[here][:, cols]), _rms(total[here, i]),
             total[here, i].mean())
        )  # fmt: skip
    n, share, total = len(found), share[seen], total[seen]
    summary: list[tuple[str, float, str]] = [
        ("frames", n, ""),
        ("true frames without a pose", len(np.setdiff1d(truth.frames, found.frames)), ""),
        ("body error, median", float(np.median(body)), "px"),
        ("body error, RMS", _rms(body), "px"),
        ("heading error, RMS", _rms(heading), "deg"),
        ("tip error, median", float(np.median(share)), "of leg span"),
        ("tip error, 95th percentile", float(np.percentile(share, 95)), "of leg span"),
        ("joint angle error, RMS", _rms(joints[np.isfinite(joints)]), "deg"),
        ("total leg angle error, RMS", _rms(total), "deg"),
        ("leg swaps", len(swaps), ""),
        ("leg swaps per 1000 frames", 1000 * len(swaps) / n, ""),
        ("frames with a swapped leg", _frames_swapped(swaps, found.frames), ""),
    ]
    return PoseErrors(
        summary=pd.DataFrame(summary, columns=["measure", "value", "unit"]),
        legs=pd.DataFrame(rows, columns=list(LEG_COLUMNS)),
        swaps=swaps,
    )


def _tip_distances(animal: StickAnimal, found: Poses, true: Poses) -> np.ndarray:
    """Return the distance of every found tip from every true tip, (n, legs, legs), px."""
    step = tip_positions(animal, found)[:, :, None] - tip_positions(animal, true)[:, None]
    return np.hypot(step[..., 0], step[..., 1])


def _swaps(
    animal: StickAnimal,
    frames: np.ndarray,
    away: np.ndarray,
    far_px: np.ndarray,
    gap: int,
    *,
    seen: np.ndarray,
) -> pd.DataFrame:
    """Return the swaps by the rule at the top of this module, of legs where they are judged."""
    rows: list[tuple[Any, ...]] = []
    names = np.array(animal.leg_names)
    for i, leg in enumerate(names):
        nearest = away[:, i].argmin(axis=1)
        at = np.flatnonzero(seen[:, i] & (nearest != i) & (away[:, i, i] > far_px))
        for run in np.split(at, np.flatnonzero(np.diff(at) > gap + 1) + 1):
            if len(run):
                others, counts = np.unique(nearest[run], return_counts=True)
                most = names[others[counts.argmax()]]
                rows.append((leg, most, frames[run[0]], frames[run[-1]], len(run)))
    return pd.DataFrame(rows, columns=list(SWAP_COLUMNS))


def _frames_swapped(swaps: pd.DataFrame, frames: np.ndarray) -> int:
    """Return in how many frames at least one leg is within a swap."""
    inside = np.zeros(len(frames), bool)
    for first, last in zip(swaps["first_frame"], swaps["last_frame"], strict=True):
        inside |= (frames >= first) & (frames <= last)
    return int(inside.sum())


def _by_pair(
    animal: StickAnimal,
    place: dict[str, np.ndarray],
    heading: dict[str, np.ndarray],
    joints: np.ndarray,
    total: np.ndarray,
    measures: dict[str, Callable[[np.ndarray], float]],
) -> pd.DataFrame:
    """Return measures of place, heading, and of joints and legs averaged over pairs of legs."""
    rows: list[dict[str, Any]] = []

    def add(name: str, legs: str, unit: str, series: list[np.ndarray]) -> None:
        values = {k: float(np.mean([f(s) for s in series])) for k, f in measures.items()}
        rows.append({"measure": name, "legs": legs, **values, "unit": unit})

    for name, series in place.items():
        add(name, "", "px", [series])
    for name, series in heading.items():
        add(name, "", "deg", [series])
    for pair in _pairs(animal):
        legs = ", ".join(pair)
        leg = animal.leg(pair[0])
        for joint, free in zip(leg.joints, leg.free, strict=True):
            if free:
                cols = [animal.joints.index(f"{name}_{joint}") for name in pair]
                add(joint, legs, "deg", [joints[:, c] for c in cols])
        add(TOTAL, legs, "deg", [total[:, animal.leg_names.index(name)] for name in pair])
    return pd.DataFrame(rows, columns=["measure", "legs", *measures, "unit"])


def _pairs(animal: StickAnimal) -> list[tuple[str, ...]]:
    """Return the legs in pairs, front to rear; a leg without a partner alone."""
    partner = animal.mirrored_names()
    pairs: list[tuple[str, ...]] = []
    done: set[str] = set()
    for name in animal.leg_names:
        if name not in done:
            pair = (name, partner[name]) if name in partner else (name,)
            pairs.append(pair)
            done.update(pair)
    return pairs


def _joint_columns(animal: StickAnimal, leg: str) -> list[int]:
    """Return the columns of a leg's free joints."""
    own = animal.leg(leg)
    names = [f"{leg}_{j}" for j, free in zip(own.joints, own.free, strict=True) if free]
    return [animal.joints.index(name) for name in names]


def _there(poses: Poses) -> Poses:
    """Return the frames that have a pose."""
    return poses.take(np.isfinite(poses.xy[:, 0]))


def _shared(one: Poses, other: Poses) -> tuple[Poses, Poses]:
    """Return both poses of the frames in which both are there."""
    one, other = _there(one), _there(other)
    frames, i, j = np.intersect1d(one.frames, other.frames, return_indices=True)
    if not len(frames):
        raise InputError("the two have no frame with a pose in common; nothing to compare.")
    return one.take(i), other.take(j)


def _wrapped(angle_deg: np.ndarray) -> np.ndarray:
    """Return angles in [-180, 180)."""
    return (angle_deg + 180.0) % 360.0 - 180.0


def _unwrapped(angle_deg: np.ndarray) -> np.ndarray:
    """Return angles without jumps of a whole turn from frame to frame."""
    return np.unwrap(angle_deg, axis=0, period=360.0)


def _rms(values: np.ndarray) -> float:
    """Return the root of the mean square."""
    return float(np.sqrt(np.mean(np.square(values))))
