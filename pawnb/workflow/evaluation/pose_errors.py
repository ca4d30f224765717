"""How good poses are: errors against exact truth.

Frames that one side lacks are left out, and counted.

A *swap* of legs is counted by this rule:

1. A leg is *taken for another* in a frame if its tip is farther than ``far_share`` of the leg span
   from its own true tip, and nearer to the true tip of another leg than to its own.
2. Frames in which a leg is taken for another make one swap if no more than ``gap_frames``
   tracked frames lie between one and the next, whichever leg it is taken for.
3. Two legs that change places make two swaps. Rates are per 1000 tracked frames.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.poses import Poses, leg_angles, tip_positions
from pawnb.errors import InputError
from pawnb.workflow.evaluation.pose_spread import rms, shared_frames, wrapped_deg

FAR_SHARE = 0.05
"""Tips nearer to their true place than this share of the leg span are never swapped."""

LEG_COLUMNS = (
    "leg", "n_frames", "tip_px_median", "tip_share_median", "tip_share_p95", "joint_rmse_deg",
    "leg_angle_rmse_deg", "leg_angle_bias_deg",
)  # fmt: skip
SWAP_COLUMNS = ("leg", "taken_for", "first_frame", "last_frame", "n_frames")


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
    found, true = shared_frames(poses, truth)
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
    joints = np.where(seen[:, owner], wrapped_deg(found.angles_deg - true.angles_deg), np.nan)
    total = wrapped_deg(leg_angles(animal, found) - leg_angles(animal, true))
    heading = wrapped_deg(found.heading_deg - true.heading_deg)
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
             np.percentile(share[here, i], 95), rms(joints[here][:, cols]), rms(total[here, i]),
             total[here, i].mean())
        )  # fmt: skip
    n, share, total = len(found), share[seen], total[seen]
    summary: list[tuple[str, float, str]] = [
        ("frames", n, ""),
        ("true frames without a pose", len(np.setdiff1d(truth.frames, found.frames)), ""),
        ("body error, median", float(np.median(body)), "px"),
        ("body error, RMS", rms(body), "px"),
        ("heading error, RMS", rms(heading), "deg"),
        ("tip error, median", float(np.median(share)), "of leg span"),
        ("tip error, 95th percentile", float(np.percentile(share, 95)), "of leg span"),
        ("joint angle error, RMS", rms(joints[np.isfinite(joints)]), "deg"),
        ("total leg angle error, RMS", rms(total), "deg"),
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


def _joint_columns(animal: StickAnimal, leg: str) -> list[int]:
    """Return the columns of a leg's free joints."""
    own = animal.leg(leg)
    names = [f"{leg}_{j}" for j, free in zip(own.joints, own.free, strict=True) if free]
    return [animal.joints.index(name) for name in names]
