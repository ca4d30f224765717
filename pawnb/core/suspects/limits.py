"""What no sound track shows: pictures far from where a point is said to be, and leaps.

The tracker that decides over the whole recording shows neither where it errs, so that nothing
is learnt of them (:mod:`pawnb.core.suspects.rates`): in 37 rendered scenes its pictures are at
most 0.73 sizes of a paw away, and its steps at most 1.6 times the fast tenth. What comes after
it may show them: points exchanged in the wrong place, or corrected in one view only.
"""

from __future__ import annotations

import numpy as np

from pawnb.core.suspects.evidence import find_nearest, image_positions
from pawnb.core.suspects.uncertainty import Doubt, paw_size, positions
from pawnb.schema import Tracks

_SLOW = 75.0
"""Sizes of a paw in a second. Where even the fast tenth is slower the animal hardly walks, and
its steps are compared with this."""


def collect_limits(tracks: Tracks, *, paw_px: float | None) -> list[Doubt]:
    """Measure what no sound track shows.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks with image positions.
    paw_px : float, optional
        Size of a paw in px.

    Returns
    -------
    list of Doubt
        In a fixed order.
    """
    return [_pictures_disagree(tracks, paw_px), _leaps(tracks)]


def _pictures_disagree(tracks: Tracks, paw_px: float | None) -> Doubt:
    """Doubt points that the pictures show elsewhere: the error of reprojection."""
    size = find_nearest(image_positions(tracks), paw_px)[2]
    names = ("time", "view", "keypoint")
    each = np.full(tuple(tracks.sizes[name] for name in names), np.nan)
    if "image_residual" in tracks:
        each = tracks["image_residual"].isel(individual=0).transpose(*names).to_numpy()
    # root mean square over the views, which what was corrected has as well
    px = tracks["residual"].isel(individual=0).to_numpy()
    worst = np.nan_to_num(each / size[:, None], nan=-1.0).argmax(axis=1)
    most = np.take_along_axis(each, worst[:, None], axis=1)[:, 0]
    views = tracks["view"].to_numpy().tolist()

    def words(t: int, p: int) -> str:
        if most[t, p] / size[worst[t, p]] >= np.nan_to_num(px[t, p]) / size.mean():
            return f"{views[worst[t, p]]} shows it {most[t, p]:.0f} px from its place"
        return f"the views disagree about it by {px[t, p]:.0f} px"

    return Doubt({"reprojection": np.fmax(most / size[worst], px / size.mean())}, words)


def _leaps(tracks: Tracks) -> Doubt:
    """Doubt points that move faster than any paw of the animal."""
    x = positions(tracks)
    frames = tracks["frame"].to_numpy().astype(float)
    leap = np.full(x.shape[:2], np.nan)
    pace = leap.copy()
    if len(frames) > 1:
        step = np.diff(x, axis=0) / np.diff(frames)[:, None, None]
        known = np.isfinite(step).all(axis=-1)
        if known.any():
            # standing paws go with the ground, and most paws stand
            step = np.linalg.norm(step - np.median(step[known], axis=0), axis=-1)
            slow = _SLOW * paw_size(tracks) / float(tracks.attrs["fps"])
            fast = np.fmax(np.percentile(step[known], 90.0), slow)
            leap[1:] = step
            leap[:-1] = np.fmax(leap[:-1], step)
            pace = leap / fast if fast > 0 else pace
    unit = tracks.attrs["units"]

    def words(t: int, p: int) -> str:
        return f"it leaps by {leap[t, p]:.1f} {unit} in one frame"

    return Doubt({"leap": pace}, words)
