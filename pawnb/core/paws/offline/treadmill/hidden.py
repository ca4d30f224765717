"""What no picture shows is known the less the longer it is hidden: its standard deviation grows.

Where a point is bridged, the smoothest path between what was seen knows nothing of when a paw that
stands hidden lifts off, or of whether what it was seen as before was the paw.
"""

from __future__ import annotations

import numpy as np

from pawnb.arrays import BoolArray, FloatArray, IntArray
from pawnb.core.paws.offline.treadmill.parameters import TREADMILL
from pawnb.schema import ORIGIN_CODE, Tracks


def with_hidden_sd(tracks: Tracks, frames: tuple[int, int]) -> Tracks:
    """Return tracks in space whose standard deviations grow where no view has the point.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks; those of a picture are returned as they are.
    frames : tuple of int
        First frame and one past the last of those that were tracked now: others have grown.

    Returns
    -------
    xarray.Dataset
        The same positions.
    """
    if tracks.sizes["space"] < 3 or not tracks.sizes["time"]:
        return tracks
    frame = tracks["frame"].to_numpy()
    origin = tracks["image_origin"].isel(individual=0).transpose("time", "keypoint", "view")
    has_it = np.isin(origin.to_numpy(), [ORIGIN_CODE["measured"], ORIGIN_CODE["edited"]])
    seen = np.asarray(has_it.any(axis=-1))
    x = tracks["position"].isel(individual=0).transpose("time", "keypoint", "space").to_numpy()
    hidden_s = frames_hidden(seen, frame) / float(tracks.attrs["fps"])
    more = body_size(x) * np.minimum(TREADMILL.hidden_speed * hidden_s, TREADMILL.hidden_most)
    more[(frame < frames[0]) | (frame >= frames[1])] = 0.0
    along = tracks["sd"].isel(individual=0).transpose("time", "keypoint", "space").dims
    sd = tracks["sd"].transpose(*along, "individual")
    grown = sd.copy(data=np.hypot(sd.to_numpy(), more[..., None, None]))
    return tracks.assign(sd=grown.transpose(*tracks["sd"].dims))


def frames_hidden(seen: BoolArray, frame: IntArray) -> IntArray:
    """Return how far each frame (n, P) is from the nearest one in which the point was seen.

    Parameters
    ----------
    seen : ndarray of bool, shape (n, P)
        Where any view has the point.
    frame : ndarray of int, shape (n,)
        Frame numbers.

    Returns
    -------
    ndarray of int, shape (n, P)
        0 where it was seen; as many frames as there are where it never was.
    """
    far = np.full(seen.shape, int(frame[-1] - frame[0]) + 1)
    for p, here in enumerate(seen.T):
        if here.any():
            at = frame[here]
            after = np.searchsorted(at, frame)
            nearest = np.stack([at[np.clip(after - 1, 0, None)], at[after.clip(max=len(at) - 1)]])
            far[:, p] = np.abs(nearest - frame).min(axis=0)
    return far


def body_size(x: FloatArray) -> float:
    """Return how far apart two points (n, P, d) usually are at most."""
    apart = np.linalg.norm(x[:, :, None] - x[:, None], axis=-1)
    return float(np.median(np.nan_to_num(apart).max(axis=(1, 2))))
