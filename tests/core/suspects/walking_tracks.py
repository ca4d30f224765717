"""Tracks of two trotting paws, made from exact places."""

import numpy as np

from pawnb.core.rig import Rig
from pawnb.schema import ORIGIN_CODE, make_tracks

N = 300
# two cameras infinitely far away, 30 degrees to each side: u = x +- y / 2, v = 300 - z
COEFS = np.array(
    [[1, 0.5, 0, 0, 0, 0, -1, 300, 0, 0, 0], [1, -0.5, 0, 0, 0, 0, -1, 300, 0, 0, 0]], float
).T
RIG = Rig(("cam1", "cam2"), COEFS)


def walk(first=0, noise_px=0.3):
    """Two paws trot: forward 30 mm about their middles, 25 frames a stride, seen with noise."""
    rng = np.random.default_rng(0)
    phase = 2 * np.pi * (np.arange(N)[:, None] / 25 + [0.0, 0.5])
    xyz = np.stack(
        [[150, 90] + 15 * np.sin(phase), np.full((N, 2), 20.0), np.fmax(6 * np.cos(phase), 0)], 2
    )
    uv = np.moveaxis(RIG.project(xyz), 1, 2) + rng.normal(0, noise_px, (N, 2, 2, 2))
    tracks = make_tracks(range(first, first + N), ["FR", "HR"], fps=250.0, views=RIG.names)
    put(tracks, uv)
    tracks["image_origin"].values[:] = ORIGIN_CODE["measured"]
    tracks["image_confidence"].values[..., 0] = 0.9 + rng.normal(0, 0.01, (N, 2, 2))
    return tracks, uv


def put(tracks, uv):
    """Set image positions (n, V, P, 2), and with them the places in space."""
    tracks["image_position"].values[..., 0] = np.moveaxis(uv, 3, 2)
    solved = RIG.triangulate(np.swapaxes(uv, 1, 2))
    tracks["position"].values[..., 0] = np.moveaxis(solved.xyz, 2, 1)
    tracks["residual"].values[..., 0] = solved.residual_px
