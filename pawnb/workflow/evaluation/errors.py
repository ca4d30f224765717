"""How good tracks are: errors against exact truth, or against tracks made by hand.

The rule for major and minor errors follows Haji Maghsoudi et al. 2019, section 4.2,
where a person judged; here it is written out so that a computer can count:

1. A label (one point in one view and frame) is *judged* where the truth says that the
   point is visible; hidden labels are never counted as errors. A judged label is
   *wrong* if it is missing or farther than ``threshold_px`` from the truth.
2. A point is wrong in a frame if any of its judged labels is wrong, right if none is, and
   not judged where it is hidden in every view. Errors are counted per point, not per
   view: a person corrects a paw, whatever the number of cameras it is seen in.
3. An *error* begins with a wrong frame and ends once the point has then been right in
   ``settled_frames`` judged frames in a row, so that a lost track that only crosses its paw
   has not recovered, and a track that flickers makes one error.
4. It is *minor* if it ended and its first and last wrong frame are fewer than
   ``recovery_frames`` apart: the tracker came back by itself. It is *major* if it lasted
   longer, or if the point was still wrong when it was last judged: a person had to step in.
5. Rates are per 1000 frames of all views together (the paper's 1000 four-camera
   frames; its 36,700 "frames" are single pictures). The limit given with a rate is the upper
   end of the exact 95 % interval of a Poisson count.

The tracked point of a paw is the one that was clicked: in the rendered truth the middle of
the digits, of the long hind foot too. A tracker that follows another place of the foot is
off by a constant, so distances are given twice, the second time with the constant offset of
each point in each view removed. What is wrong is always told from the plain distance.

Without corrections, a paw that is lost for good makes one major error however long the
recording is. The paper counts while a person corrects;
:func:`pawnb.workflow.evaluation.corrected_run.track_with_corrections` does the same.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.stats import chi2

from pawnb.core.paws.maghsoudi2019.settings import REFERENCE_WIDTH_PX
from pawnb.errors import InputError
from pawnb.schema import ORIGIN_CODE, Tracks, check_columns, check_tracks
from pawnb.schema.arguments import checked_arguments

TRUTH_COLUMNS = ("frame", "view", "point", "u", "v")
ERROR_COLUMNS = ("point", "first_frame", "last_frame", "kind")


THRESHOLD_PX = 20.0
"""About half the length of a hind paw in the paper's pictures."""

RECOVERY_FRAMES = 25
"""One stride of the fastest mouse of the paper: 10 Hz at 250 frames per second."""

SETTLED_FRAMES = 5
HIDDEN_PX = 10.0


def limits_for_width(width_px: float) -> tuple[float, float]:
    """Return the limits in px for pictures of a width, in proportion to the paper's.

    Parameters
    ----------
    width_px : float
        Width of the widest view, px.

    Returns
    -------
    tuple of float
        ``threshold_px`` and ``hidden_px`` for :func:`count_errors`.
    """
    share = width_px / REFERENCE_WIDTH_PX
    return THRESHOLD_PX * share, HIDDEN_PX * share


def poisson_limit(count: int) -> float:
    """Return the upper end of the exact 95 % interval of a Poisson mean (Garwood 1936).

    Parameters
    ----------
    count : int
        Number of errors that were found.

    Returns
    -------
    float
        Errors that are expected at most.
    """
    return float(chi2.ppf(0.975, 2 * count + 2)) / 2


@dataclass(frozen=True)
class ErrorReport:
    """Errors of tracks against truth.

    Parameters
    ----------
    n_frames : int
        Frames (of all views together) that tracks and truth share: the denominator.
    n_labels : int
        Judged labels: point, view and frame where the truth is visible.
    n_hidden : int
        Labels where the truth is hidden.
    major, minor : int
        Number of errors; the rule is that of :mod:`pawnb.workflow.evaluation.errors`.
    share_wrong : float
        Share of judged labels that are wrong.
    share_missing : float
        Share of judged labels without any position.
    median_px, p95_px : float
        Median and 95th percentile of the distance of judged labels from the truth.
    median_px_centred, p95_px_centred : float
        The same after the constant offset of each point in each view was taken away (the
        median of its labels that are not wrong): a tracker may well follow the middle of a
        paw where the truth is its tip.
    share_hidden_bridged : float
        Share of hidden labels with a position within ``hidden_px`` of the truth.
    threshold_px, hidden_px : float
        Limits that were used, px.
    recovery_frames, settled_frames : int
        Limits that were used.
    errors : DataFrame
        point, first_frame, last_frame, kind (``major`` or ``minor``).
    distances_px : ndarray
        Distances of judged labels from the truth, for pooling over recordings.
    """

    n_frames: int
    n_labels: int
    n_hidden: int
    major: int
    minor: int
    share_wrong: float
    share_missing: float
    median_px: float
    p95_px: float
    median_px_centred: float
    p95_px_centred: float
    share_hidden_bridged: float
    threshold_px: float
    hidden_px: float
    recovery_frames: int
    settled_frames: int
    errors: pd.DataFrame
    distances_px: np.ndarray

    @property
    def major_per_1000(self) -> float:
        """Major errors per 1000 frames of all views together."""
        return 1000.0 * self.major / self.n_frames

    @property
    def minor_per_1000(self) -> float:
        """Minor errors per 1000 frames of all views together."""
        return 1000.0 * self.minor / self.n_frames

    def summary(self) -> pd.DataFrame:
        """Return the numbers of the report: columns measure, value, unit, as of poses."""
        per = 1000.0 / self.n_frames
        rows = [
            ("frames", self.n_frames, ""),
            ("visible labels", self.n_labels, ""),
            ("hidden labels", self.n_hidden, ""),
            ("major errors", self.major, ""),
            ("minor errors", self.minor, ""),
            ("major errors per 1000 frames", self.major_per_1000, ""),
            ("minor errors per 1000 frames", self.minor_per_1000, ""),
            ("major errors per 1000 frames, 95 % limit", poisson_limit(self.major) * per, ""),
            ("minor errors per 1000 frames, 95 % limit", poisson_limit(self.minor) * per, ""),
            ("labels wrong", self.share_wrong, "share"),
            ("labels missing", self.share_missing, "share"),
            ("distance, median", self.median_px, "px"),
            ("distance, 95th percentile", self.p95_px, "px"),
            ("distance without constant offset, median", self.median_px_centred, "px"),
            ("distance without constant offset, 95th percentile", self.p95_px_centred, "px"),
            ("hidden labels bridged", self.share_hidden_bridged, "share"),
            ("wrong from", self.threshold_px, "px"),
            ("bridged within", self.hidden_px, "px"),
        ]
        return pd.DataFrame(rows, columns=["measure", "value", "unit"])

    def text(self) -> str:
        """Return the report in a few lines."""
        return "\n".join(
            (
                f"{self.n_frames} frames of all views together, {self.n_labels} visible labels",
                f"major errors {self._count(self.major)}, minor {self._count(self.minor)}",
                f"labels wrong: {self.share_wrong:.1%}; wrong means missing or more than "
                f"{self.threshold_px:g} px off, major for {self.recovery_frames} frames or to the "
                "end",
                f"median distance {self.median_px:.2f} px, 95th percentile {self.p95_px:.2f} px; "
                "with the constant offset of each track removed "
                f"{self.median_px_centred:.2f} px and {self.p95_px_centred:.2f} px",
                f"hidden labels within {self.hidden_px:g} px: {self.share_hidden_bridged:.0%}"
                if self.n_hidden
                else "no hidden labels",
            )
        )

    def _count(self, count: int) -> str:
        """Return a number of errors with its rate and the limit of that."""
        per = 1000.0 / self.n_frames
        limit = poisson_limit(count) * per
        return f"{count} ({count * per:.1f} per 1000 frames, 95 % limit {limit:.1f})"


@dataclass(frozen=True)
class _Judged:
    """Tracks and truth side by side: n frames, V views, P points."""

    frames: np.ndarray
    points: tuple[str, ...]
    step: np.ndarray  # (n, V, P, 2): tracked minus true, NaN where either is missing
    visible: np.ndarray  # (n, V, P)
    hidden: np.ndarray

    @property
    def distance(self) -> np.ndarray:
        """Distance from the truth, px; infinite where nothing was tracked."""
        away = np.hypot(self.step[..., 0], self.step[..., 1])
        return np.where(np.isnan(away), np.inf, away)


@checked_arguments
def count_errors(
    tracks: Tracks,
    truth: pd.DataFrame,
    *,
    points_by_view: Mapping[str, Sequence[str]] | None = None,
    threshold_px: float = THRESHOLD_PX,
    recovery_frames: int = RECOVERY_FRAMES,
    settled_frames: int = SETTLED_FRAMES,
    hidden_px: float = HIDDEN_PX,
) -> ErrorReport:
    """Count major and minor errors and measure distances from the truth.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks with image positions.
    truth : DataFrame
        frame, view, point, u, v (px) and, optionally, ``visible`` (1 or 0); without it
        every row with a position is visible.
    points_by_view : mapping, optional
        Points that each view should have tracked; by default those of which it has a
        position of its own, not a reprojected one, in any frame.
    threshold_px : float
        A judged label farther than this from the truth is wrong. The default suits
        pictures 2048 px wide; :func:`limits_for_width` has those of others.
    recovery_frames : int
        An error whose first and last wrong frame are at least this far apart is major.
    settled_frames : int
        Judged frames in a row that a point must be right in to have recovered.
    hidden_px : float
        A hidden label is bridged if it is no farther than this from the truth.

    Returns
    -------
    ErrorReport
        Counts, rates, distances, and the list of errors.

    Raises
    ------
    InputError
        If the truth lacks a column, or shares no frame, view and point with the tracks.

    Examples
    --------
    >>> truth = pd.read_csv("sample/truth/tracks.csv")
    >>> errors = pawnb.count_errors(tracks, truth, threshold_px=4.0)
    >>> errors.text().splitlines()[0] != ""
    True
    """
    for name, value in (
        ("threshold_px", threshold_px),
        ("recovery_frames", recovery_frames),
        ("settled_frames", settled_frames),
        ("hidden_px", hidden_px),
    ):
        if not value > 0:
            raise InputError(f"{name} is {value}; expected a number above 0.")
    judged = _side_by_side(tracks, truth, points_by_view)
    away, visible = judged.distance, judged.visible
    wrong = visible & (away > threshold_px)
    errors = _list_errors(judged, wrong, recovery_frames, settled_frames)
    found = visible & np.isfinite(away)
    centred = _centred_distance(judged, found, found & ~wrong)
    n_labels, n_hidden = int(visible.sum()), int(judged.hidden.sum())
    bridged = judged.hidden & (away <= hidden_px)
    return ErrorReport(
        n_frames=len(judged.frames),
        n_labels=n_labels,
        n_hidden=n_hidden,
        major=int((errors["kind"] == "major").sum()),
        minor=int((errors["kind"] == "minor").sum()),
        share_wrong=float(wrong.sum() / n_labels),
        share_missing=float((visible & ~np.isfinite(away)).sum() / n_labels),
        median_px=_percentile(away[found], 50),
        p95_px=_percentile(away[found], 95),
        median_px_centred=_percentile(centred, 50),
        p95_px_centred=_percentile(centred, 95),
        share_hidden_bridged=float(bridged.sum() / n_hidden) if n_hidden else float("nan"),
        threshold_px=float(threshold_px),
        hidden_px=float(hidden_px),
        recovery_frames=int(recovery_frames),
        settled_frames=int(settled_frames),
        errors=errors,
        distances_px=away[found],
    )


def _side_by_side(
    tracks: Tracks, truth: pd.DataFrame, points_by_view: Mapping[str, Sequence[str]] | None
) -> _Judged:
    """Line up tracks and truth on the frames, views and points they share."""
    check_tracks(tracks)
    check_columns(truth, TRUTH_COLUMNS, where="the truth")
    if "image_position" not in tracks:
        raise InputError("these tracks have no image positions to compare with the truth.")
    frames = np.intersect1d(tracks["frame"].to_numpy(), truth["frame"].to_numpy())
    views = [v for v in tracks["view"].to_numpy().tolist() if v in set(truth["view"])]
    points = [p for p in tracks["keypoint"].to_numpy().tolist() if p in set(truth["point"])]
    tracked = (
        tracks["image_position"]
        .isel(individual=0)
        .swap_dims(time="frame")
        .sel(frame=frames, view=views, keypoint=points)
        .transpose("frame", "view", "keypoint", "image_space")
        .to_numpy()
    )
    rows = truth[
        truth["frame"].isin(frames) & truth["view"].isin(views) & truth["point"].isin(points)
    ]
    key = (
        np.searchsorted(frames, rows["frame"]),
        rows["view"].map(views.index).to_numpy(dtype=int),
        rows["point"].map(points.index).to_numpy(dtype=int),
    )
    true = np.full(tracked.shape, np.nan)
    true[key] = rows[["u", "v"]].to_numpy(dtype=float)
    seen = np.zeros(tracked.shape[:-1], dtype=bool)
    seen[key] = rows["visible"].to_numpy(dtype=float) > 0 if "visible" in rows else True
    if points_by_view is None:
        origin = _origins(tracks, frames, views, points)
        found = np.isfinite(tracked[..., 0]) & (origin != ORIGIN_CODE["reprojected"])
        expected = found.any(axis=0)
    else:
        expected = np.array([[p in points_by_view.get(v, ()) for p in points] for v in views])
    known = np.isfinite(true[..., 0]) & expected
    if not (known & seen).any():
        raise InputError(
            "tracks and truth share no visible point; compare the names of views and points "
            "and the frames of both."
        )
    return _Judged(frames, tuple(points), tracked - true, known & seen, known & ~seen)


def _origins(
    tracks: Tracks, frames: np.ndarray, views: Sequence[str], points: Sequence[str]
) -> np.ndarray:
    """Return the origins of image positions, shape (n, V, P)."""
    return (
        tracks["image_origin"]
        .isel(individual=0)
        .swap_dims(time="frame")
        .sel(frame=frames, view=views, keypoint=points)
        .transpose("frame", "view", "keypoint")
        .to_numpy()
    )


def _percentile(values: np.ndarray, percent: float) -> float:
    """Return a percentile, or NaN of nothing."""
    return float(np.percentile(values, percent)) if len(values) else float("nan")


def _centred_distance(judged: _Judged, found: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Return distances after the median offset of each track's right labels is removed."""
    distances = []
    for view, point in np.argwhere(right.any(axis=0)).tolist():
        offset = np.median(judged.step[right[:, view, point], view, point], axis=0)
        step = judged.step[found[:, view, point], view, point]
        distances.append(np.linalg.norm(step - offset, axis=-1))
    return np.concatenate(distances) if distances else np.empty(0)


def _list_errors(
    judged: _Judged, wrong: np.ndarray, recovery_frames: int, settled_frames: int
) -> pd.DataFrame:
    """Find the errors of every point, in the order of their first frames."""
    rows = []
    for p, point in enumerate(judged.points):
        known = judged.visible[:, :, p].any(axis=1)
        frames = judged.frames[known]
        bad = np.asarray(wrong[known][:, :, p].any(axis=1))
        for first, last, ended in _runs(bad, settled_frames):
            lasted = frames[last] - frames[first]
            kind = "minor" if ended and lasted < recovery_frames else "major"
            rows.append((point, int(frames[first]), int(frames[last]), kind))
    rows.sort(key=lambda row: row[1])
    return pd.DataFrame(rows, columns=list(ERROR_COLUMNS))


def _runs(bad: np.ndarray, settled: int) -> list[tuple[int, int, bool]]:
    """Join wrong frames, fewer than ``settled`` right ones apart, into runs.

    Returns first and last index of each, and whether a right frame came after it.
    """
    where = np.flatnonzero(bad)
    if len(where) == 0:
        return []
    cuts = np.flatnonzero(np.diff(where) > settled)
    firsts = where[np.concatenate([[0], cuts + 1])]
    lasts = where[np.concatenate([cuts, [len(where) - 1]])]
    n = len(bad)
    return [
        (int(first), int(last), bool(last < n - 1))
        for first, last in zip(firsts, lasts, strict=True)
    ]
