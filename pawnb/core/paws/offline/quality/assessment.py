"""How good tracks are, by limits that do not depend on the recording: good, look or failed.

Every label (one point in one view and frame) gets the probability of being right, within about
half a paw, from what the tracks say of themselves; the mean over labels is the share that is
expected to be right, and the verdict follows from that. A method whose ``image_confidence`` is
such a probability says so (:data:`CALIBRATED`), and it is taken as it is. Of other methods it
is the product of what each measure leaves of it (:mod:`.measures`): how far a candidate
is ahead of others, the standard deviation, how long nothing was found, agreement of passes and
of views. Places that no animal can have lower it for all: off the picture, far beyond the
body, two names on one place.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
import pandas as pd

from pawnb.arrays import AnyArray, FloatArray, IntArray
from pawnb.core.parameters import values_in_force
from pawnb.core.paws.offline.quality.labels import OF, Labels, Measure, QualityLimits
from pawnb.core.paws.offline.quality.measures import (
    CALIBRATED,
    heaviest,
    measure_evidence,
    measure_places,
    read_labels,
)
from pawnb.core.paws.offline.quality.one_place import on_one_place_in_space
from pawnb.core.paws.offline.quality.parameters import LIMITS, QUALITY
from pawnb.core.paws.offline.quality.time_gaps import TimeGap, find_time_gaps
from pawnb.core.paws.offline.quality.usable_frames import UsableFrames, find_usable_frames
from pawnb.errors import InputError
from pawnb.schema import ORIGIN_CODE, Tracks, check_tracks

Verdict = Literal["good", "look", "failed"]


@dataclass(frozen=True)
class PointQuality:
    """How good the track of one point is.

    Parameters
    ----------
    name : str
        The point.
    verdict : {"good", "look", "failed"}
        At least 90 %, at least 50 %, or less of its labels are expected to be right.
    expected_right : float
        That share, 0 to 1, over frames in which it was not clicked and the views in which it was
        ever found.
    measured, bridged, missing : float
        Shares of labels that were found in the picture or placed by hand, that were bridged,
        predicted or re-projected, and that are not there.
    reasons : tuple of str
        What speaks against it, the heaviest first.
    """

    name: str
    verdict: Verdict
    expected_right: float
    measured: float
    bridged: float
    missing: float
    reasons: tuple[str, ...]


@dataclass(frozen=True)
class Quality:
    """How good the tracks of a recording are.

    Parameters
    ----------
    verdict : {"good", "look", "failed"}
        As of a point, by the mean over points: a recording of which 90 % is right is good though
        one point of it is less; not where any point failed.
    expected_right, measured, bridged, missing : float
        Means over the points.
    reasons : tuple of str
        Where a film stands still, and those of the points that are not good, the worst first.
    points : tuple of PointQuality
        In the order of the tracks.
    gaps : tuple of TimeGap
        Frames that were dropped when the recording was made.
    usable : UsableFrames, optional
        The part of the recording that would have a better verdict than the whole, where its ends
        have hardly a right label.
    """

    verdict: Verdict
    expected_right: float
    measured: float
    bridged: float
    missing: float
    reasons: tuple[str, ...]
    points: tuple[PointQuality, ...]
    gaps: tuple[TimeGap, ...] = field(default=())
    usable: UsableFrames | None = None

    @property
    def has_failed_point(self) -> bool:
        """Whether any point failed, however the others are."""
        return any(point.verdict == "failed" for point in self.points)

    @property
    def poor_points(self) -> tuple[str, ...]:
        """Names of the points that are not good, the worst first."""
        return tuple(point.name for point in _worst_first(self.points))

    def document(self) -> dict[str, Any]:
        """Return what ``quality.json`` holds: shares rounded to 0.1 %."""
        shares = ("expected_right", "measured", "bridged", "missing")

        def shown(of: Quality | PointQuality) -> dict[str, Any]:
            values = {name: round(getattr(of, name), 3) for name in shares}
            return {"verdict": of.verdict, **values, "reasons": list(of.reasons)}

        return {
            **shown(self),
            "points": {point.name: shown(point) for point in self.points},
            "dropped_frames": [{"after": g.after, "frames": g.frames} for g in self.gaps],
            **({} if self.usable is None else {
                "usable_frames": [self.usable.first, self.usable.stop]
            }),
        }  # fmt: skip

    def line(self) -> str:
        """Return the verdict, and what a person should know, in one line.

        A recording may be good as a whole though a point of it is not; then so much is said.
        """
        said: str = self.verdict
        if self.reasons:
            said += " but for " if self.verdict == "good" else ": "
            said += "; ".join(self.reasons)
        more = [self.dropped()] if self.gaps else []
        more += [self.usable.words()] if self.usable is not None else []
        return "; ".join([said, *more])

    def dropped(self) -> str:
        """Return in words which frames the camera dropped."""
        n = sum(gap.frames for gap in self.gaps)
        places = ", ".join(str(gap.after) for gap in self.gaps[: QUALITY.most_reasons])
        more = len(self.gaps) - QUALITY.most_reasons
        return (
            f"{n} frame{'s were' if n > 1 else ' was'} dropped by the camera, after frame {places}"
            + (f" and {more} more" if more > 0 else "")
        )


def assess(
    tracks: Tracks, *, clicks: pd.DataFrame | None = None, limits: QualityLimits | None = None
) -> Quality:
    """Say how good tracks are, point by point.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks of any method, with image positions, in one view or more.
    clicks : DataFrame, optional
        frame, view, point, u, v: what a person placed at the start. It tells how large the
        animal is (without it the usual size of the tracks does), and which labels say nothing
        of the tracking.
    limits : QualityLimits, optional
        The limits.

    Returns
    -------
    Quality
        The verdict.

    Raises
    ------
    InputError
        If the tracks have no image positions.
    """
    limits = limits or values_in_force(LIMITS)
    labels = _labels(tracks, clicks)
    chance, measures = _chances(tracks, labels, limits)
    names = [str(name) for name in tracks["keypoint"].to_numpy()]
    points = tuple(
        _point_quality(p, names, labels, chance, measures, limits) for p in range(len(names))
    )
    means = {
        name: _mean([getattr(point, name) for point in points])
        for name in ("expected_right", "measured", "bridged", "missing")
    }
    verdict = _verdict(means["expected_right"], limits)
    quality = Quality(
        verdict,
        reasons=_told(points),
        points=points,
        gaps=find_time_gaps(tracks),
        usable=None,
        **means,
    )
    if verdict == "good" and quality.has_failed_point:
        quality = replace(quality, verdict="look")
    return replace(quality, usable=_better_part(tracks, labels, chance, quality, limits))


def _better_part(
    tracks: Tracks, labels: Labels, chance: FloatArray, quality: Quality, limits: QualityLimits
) -> UsableFrames | None:
    """Return the part of a recording whose verdict would be better than that of the whole."""
    of_frames = np.mean(
        [chance[:, _views_of(labels, p), p].mean(axis=1) for p in range(chance.shape[2])], axis=0
    )
    part = find_usable_frames(
        of_frames, tracks["frame"].to_numpy(), clicked=np.asarray(labels.clicked.any(axis=1)),
        limit=limits.failed,
    )  # fmt: skip
    if part is None or part.stop - part.first < QUALITY.fewest_frames:
        return None
    if max(right for *_, right in part.left_out) > QUALITY.hardly_any:
        return None
    better = _rank(_verdict(part.right, limits)) > _rank(quality.verdict)
    return part if better else None


def _rank(verdict: Verdict) -> int:
    """Return 0 of a verdict that failed, 2 of a good one."""
    return ("failed", "look", "good").index(verdict)


def label_chances(
    tracks: Tracks, *, clicks: pd.DataFrame | None = None, limits: QualityLimits | None = None
) -> AnyArray:
    """Return the probability that each label is right: what the verdict is the mean of.

    Parameters
    ----------
    tracks, clicks, limits
        As for :func:`assess`.

    Returns
    -------
    ndarray, shape (n, V, P)
        0 to 1, and 0 where there is no label; NaN in views in which a point was never found,
        if it was found in others.

    Raises
    ------
    InputError
        If the tracks have no image positions.
    """
    labels = _labels(tracks, clicks)
    chance, _ = _chances(tracks, labels, limits or values_in_force(LIMITS))
    for p in range(chance.shape[2]):
        chance[:, ~np.isin(np.arange(chance.shape[1]), _views_of(labels, p)), p] = np.nan
    return chance


def share_on_one_place(tracks: Tracks, clicks: pd.DataFrame | None) -> float:
    """Return the largest share of a point's labels that lie on another one's place in space.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks with image positions; without a calibration the share is 0.
    clicks : DataFrame, optional
        frame, view, point, u, v: what a person has placed.

    Returns
    -------
    float
        0 to 1.
    """
    left = on_one_place_in_space(_labels(tracks, clicks), values_in_force(LIMITS)).left
    return float((left < 1.0).mean(axis=(0, 1)).max(initial=0.0))


def _labels(tracks: Tracks, clicks: pd.DataFrame | None) -> Labels:
    """Return what is measured, of tracks that have image positions."""
    check_tracks(tracks)
    if "image_position" not in tracks:
        raise InputError("these tracks have no image positions; their quality cannot be told.")
    return read_labels(tracks, clicks)


def _views_of(labels: Labels, p: int) -> IntArray:
    """Return the views in which a point was ever found; all where it was in none."""
    views = np.flatnonzero(labels.found[:, :, p].any(axis=0))
    return views if len(views) else np.arange(labels.found.shape[1])


def _chances(
    tracks: Tracks, labels: Labels, limits: QualityLimits
) -> tuple[np.ndarray, list[Measure]]:
    """Return the probability (n, V, P) that each label is right, and what lowers it."""
    confidence = tracks["image_confidence"]
    if confidence.attrs.get(CALIBRATED):
        own = np.clip(np.nan_to_num(confidence.isel(individual=0).to_numpy()), 0.0, 1.0)
        evidence = [Measure("the tracker is not sure of {point}", own)]
    else:
        evidence = measure_evidence(tracks, labels, limits)
    trust = np.prod([heaviest(evidence, of, labels) for of in OF], axis=0)
    places = measure_places(labels, limits, trust)
    measures = [*evidence, *places]
    chance = trust * np.prod([measure.left for measure in places], axis=0)
    # who has placed a point has seen to it
    chance = np.where(labels.origin == ORIGIN_CODE["edited"], 1.0, chance)
    return np.where(labels.known, chance, 0.0), measures


def _point_quality(
    p: int,
    names: Sequence[str],
    labels: Labels,
    chance: FloatArray,
    measures: Sequence[Measure],
    limits: QualityLimits,
) -> PointQuality:
    """Return the quality of one point: over the views in which it was ever found, else all."""
    views = _views_of(labels, p)
    known, found = labels.known[:, views, p], labels.found[:, views, p]
    # a frame that was clicked tells nothing of the others; of those that all were, all count
    own = ~labels.clicked[:, p] if not labels.clicked[:, p].all() else slice(None)
    right = _mean(chance[own][:, views, p])
    reasons = []
    if (missing := _mean(~known)) >= QUALITY.telling:
        reasons.append((missing, f"{names[p]} is missing in {100 * missing:.0f} % of frames"))
    for measure in measures:
        left = np.where(known, measure.left[:, views, p], 1.0)
        taken = _mean(1.0 - left)
        if taken >= QUALITY.telling:
            reasons.append((taken, _words(measure, p, names, views, left)))
    ranked = sorted(reasons, key=lambda reason: -reason[0])[: QUALITY.most_reasons]
    return PointQuality(
        names[p], _verdict(right, limits), right,
        measured=_mean(known & found), bridged=_mean(known & ~found), missing=missing,
        reasons=tuple(words for _, words in ranked),
    )  # fmt: skip


def _words(
    measure: Measure, p: int, names: Sequence[str], views: IntArray, left: FloatArray
) -> str:
    """Say what a measure has against a point, and in how many frames."""
    hit = left < QUALITY.telling_left
    other = ""
    if measure.other is not None and hit.any():
        other = names[int(np.bincount(measure.other[:, views, p][hit]).argmax())]
    share = _mean(np.any(hit, axis=1)) or _mean(np.any(left < 1.0, axis=1))
    return f"{measure.words.format(point=names[p], other=other)} in {100 * share:.0f} % of frames"


def _told(points: Sequence[PointQuality]) -> tuple[str, ...]:
    """Return what is said of a recording: its worst points, each with its heaviest reason."""
    poor = _worst_first(points)
    said = [
        f"{p.name} ({100 * p.expected_right:.0f} % of labels expected right)"
        + "".join(f" - {reason}" for reason in p.reasons[:1])
        for p in poor[: QUALITY.most_reasons]
    ]
    if len(poor) > QUALITY.most_reasons:
        more = len(poor) - QUALITY.most_reasons
        said.append(f"and {more} more point{'s' * (more != 1)}")
    return tuple(said)


def _worst_first(points: Sequence[PointQuality]) -> list[PointQuality]:
    """Return the points that are not good, the worst first."""
    return sorted((p for p in points if p.verdict != "good"), key=lambda p: p.expected_right)


def _verdict(right: float, limits: QualityLimits) -> Verdict:
    if right >= limits.good:
        return "good"
    return "look" if right >= limits.failed else "failed"


def _mean(values: Sequence[float] | np.ndarray) -> float:
    """Return the mean; 0 of nothing: where nothing was tracked, nothing is right."""
    return float(np.mean(values)) if np.size(values) else 0.0
