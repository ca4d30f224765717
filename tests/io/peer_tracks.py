"""The recording that the folder peer-files holds in eleven formats, from its formulas."""

import numpy as np

POINTS = ("FR", "HR", "FL", "HL")
FPS = 100.0
N = 60
LOST = slice(10, 13)
"""Frames in which HR is missing."""

_T = np.arange(N) / FPS


def true_uv(animal=0):
    """Where each point is in each frame, px: (60, 4, 2) (README.md of peer-files)."""
    k = np.arange(4)
    u = 200 + 60 * np.sin(2 * np.pi * 3 * _T[:, None] + 1.5 * k) + 40 * k
    v = 300 + 5 * np.cos(2 * np.pi * 3 * _T[:, None] + k)
    return np.stack([u, v], axis=-1) + 50.0 * animal


def places(tracks, points=POINTS):
    """Positions (frame, point, animal, axis) of Tracks, in the order of the points."""
    own = tracks["position"].sel(keypoint=list(points))
    return own.transpose("time", "keypoint", "individual", "space").to_numpy()


def largest_error(found, true):
    """Largest difference where the recording has a point; NaN at any other place is wrong."""
    lost = np.zeros(true.shape[:2], dtype=bool)
    lost[LOST, POINTS.index("HR")] = True
    assert np.isnan(found[lost]).all()
    return np.abs(found - true)[~lost].max()
