"""Reprojection errors by camera and paw (Haji Maghsoudi et al. 2019, Table 1 and Fig. 7b)."""

from __future__ import annotations

import itertools
from collections.abc import Mapping

import numpy as np
import pandas as pd
from scipy import stats

from pawnb.core.paws.maghsoudi2019.settings import Maghsoudi2019Settings
from pawnb.core.rig import load_rig
from pawnb.core.video import open_views
from pawnb.schema import ORIGIN_CODE, Tracks
from pawnb.trial import Trial

TESTS_COLUMNS = (
    "method", "kind", "view_a", "view_b", "n_frames_a", "n_frames_b", "t", "p",
    "n_trials_a", "n_trials_b", "t_trials", "p_trials",
)  # fmt: skip

Samples = Mapping[tuple[str, str, str, str, str], np.ndarray]
"""Trial, method, view, point and kind of paw to the errors, px, one a frame."""


def measure_reprojection(trial: Trial, tracks: Tracks) -> dict[tuple[str, str, str], np.ndarray]:
    """Measure the reprojection errors of one trial (section 4.4).

    Parameters
    ----------
    trial : Trial
        The trial, with the calibration of its views.
    tracks : xarray.Dataset
        Its tracks.

    Returns
    -------
    dict
        View, point and kind (front, hind, other) to the errors, px, one a frame, of the points
        that each view tracks: method ``pawnb`` finds paws in the other views, too. Of method
        ``pawnb`` (``image_residual`` of the tracks): the distance of what was found in the
        picture from the projection of the smoothed position. Of the others, where a point
        was found by two views or more: the distance of each from the projection of the
        triangulated position. Empty without a calibration of two views.
    """
    if "image_residual" in tracks:
        names = ("time", "keypoint", "view")
        error = tracks["image_residual"].isel(individual=0).transpose(*names).to_numpy()
    else:
        triangulated = _triangulation_error(trial, tracks)
        if triangulated is None:
            return {}
        error = triangulated
    settings = Maghsoudi2019Settings()
    found: dict[tuple[str, str, str], np.ndarray] = {}
    tracked = {view.name: view.points for view in trial.views}
    for p, point in enumerate(tracks["keypoint"].to_numpy().tolist()):
        for v, view in enumerate(tracks["view"].to_numpy().tolist()):
            if tracked[view] and point not in tracked[view]:
                continue
            values = error[:, p, v]
            values = values[np.isfinite(values)]
            if len(values):
                found[view, point, settings.kind(point)] = values
    return found


def _triangulation_error(trial: Trial, tracks: Tracks) -> np.ndarray | None:
    """Return the errors (n, P, V), px, about the triangulated positions; None without a rig."""
    with open_views(trial) as views:
        sizes = {name: (r.source.width, r.source.height) for name, r in views.readers.items()}
    rig = load_rig(trial, sizes=sizes)
    if rig is None:
        return None
    rig = rig.subset(tracks["view"].to_numpy().tolist())
    labels = tracks.isel(individual=0).transpose("time", "keypoint", "view", "image_space", ...)
    origin = labels["image_origin"].to_numpy()
    seen = np.isin(origin, [ORIGIN_CODE[name] for name in ("measured", "resolved", "edited")])
    uv = np.where(seen[..., None], labels["image_position"].to_numpy(), np.nan)
    error: np.ndarray = rig.reprojection_error(rig.triangulate(uv).xyz, uv)
    return error


def compare_cameras(samples: Samples) -> pd.DataFrame:
    """Compare the reprojection error between every two cameras, front and hind (Table 1).

    Parameters
    ----------
    samples : mapping
        Trial, method, view, point and kind to the errors, px, one a frame.

    Returns
    -------
    pandas.DataFrame
        ``TESTS_COLUMNS``: Welch's t-test, over frames as if they were independent, and over
        the trials' means; NaN where a side has fewer than two.
    """
    rows = []
    methods = dict.fromkeys(key[1] for key in samples)
    kinds = sorted({key[4] for key in samples})
    for method, kind in itertools.product(methods, kinds):
        own = {key: x for key, x in samples.items() if key[1] == method and key[4] == kind}
        for pair in itertools.combinations(sorted({key[2] for key in own}), 2):
            of_frames, of_trials = [], []
            for view in pair:
                here = {key: x for key, x in own.items() if key[2] == view}
                of_frames.append(np.concatenate(list(here.values())))
                trials = dict.fromkeys(key[0] for key in here)
                of_trials.append(
                    np.array([np.concatenate([x for key, x in here.items() if key[0] == t]).mean()
                              for t in trials])
                )  # fmt: skip
            rows.append((method, kind, *pair, *_welch(*of_frames), *_welch(*of_trials)))
    return pd.DataFrame(rows, columns=list(TESTS_COLUMNS))


def _welch(a: np.ndarray, b: np.ndarray) -> tuple[int, int, float, float]:
    """Return the sizes of two samples, and t and p of Welch's test; NaN where it has none."""
    if min(len(a), len(b)) < 2 or np.ptp(a) + np.ptp(b) == 0:
        return len(a), len(b), float("nan"), float("nan")
    t, p = stats.ttest_ind(a, b, equal_var=False)
    return len(a), len(b), float(t), float(p)


def describe_reprojection(reprojection: pd.DataFrame) -> str:
    """Put the reprojection errors of each camera and paw into words, a method and view a line.

    Parameters
    ----------
    reprojection : pandas.DataFrame
        ``reprojection.csv``: columns method, view, point, n, mean_px.

    Returns
    -------
    str
        Means over all trials in px, each frame counted once.
    """
    if len(reprojection) == 0:
        return "reprojection error: none, for it needs two calibrated views that share a paw"
    lines = ["reprojection error, px, mean by camera and paw"]
    for (method, view), own in reprojection.groupby(["method", "view"], sort=False):
        means = [
            f"{point} {np.average(here['mean_px'], weights=here['n']):.2f}"
            for point, here in own.groupby("point", sort=False)
        ]
        lines.append(f"  {method}, {view}: {', '.join(means)}")
    return "\n".join(lines)


def describe_tests(tests: pd.DataFrame) -> str:
    """Put the t-tests between cameras into words, one a line.

    Parameters
    ----------
    tests : pandas.DataFrame
        From :func:`compare_cameras`.

    Returns
    -------
    str
        t and p over frames and over trials; empty where there is no test.
    """
    if len(tests) == 0:
        return ""
    lines = ["t-tests of the reprojection error between cameras"]
    for row in tests.to_dict("records"):
        by = [
            f"{name} t {row[t]:.2f}, p {row[p]:.2g}"
            for name, t, p in (("frames", "t", "p"), ("trials", "t_trials", "p_trials"))
            if np.isfinite(row[t])
        ]
        which = f"{row['method']}, {row['kind']} paws, {row['view_a']} and {row['view_b']}"
        lines.append(f"  {which}: {'; '.join(by) or 'too few to test'}")
    return "\n".join(lines)
