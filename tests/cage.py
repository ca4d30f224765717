"""The real points of mouse-4cam-cage: a mouse in a home cage, seen by four cameras."""

from __future__ import annotations

import tomllib

import numpy as np
import pandas as pd


def read_cage(folder):
    """Coefficients, undistorted uv (120, 15, 4, 2), authors' xyz (120, 15, 3), point names."""
    coefs = np.loadtxt(folder / "DLT_for_undistorted_images.csv", delimiter=",")
    table = pd.read_csv(folder / "points2d.csv")
    names = list(table["point"].unique())
    uv = np.full((120, len(names), 4, 2), np.nan)
    index = table["point"].map(names.index)
    uv[table["frame"], index, table["cam"] - 1] = table[["x", "y"]]
    lens = tomllib.loads((folder / "calibration_side_refitted.toml").read_text())
    for i in range(4):
        matrix = np.array(lens[f"cam_{i}"]["matrix"])
        k1 = lens[f"cam_{i}"]["distortions"][0]
        bent = (uv[..., i, :] - matrix[:2, 2]) / matrix[0, 0]
        straight = bent.copy()
        for _ in range(50):  # fixed point of the radial model
            straight = bent / (1 + k1 * (straight**2).sum(axis=-1, keepdims=True))
        uv[..., i, :] = straight * matrix[0, 0] + matrix[:2, 2]
    truth = pd.read_csv(folder / "points3d_refitted.csv").set_index("frame")
    xyz = np.stack([truth[[f"{n}_{a}" for a in "xyz"]].to_numpy() for n in names], axis=1)
    return coefs, uv, xyz, names
