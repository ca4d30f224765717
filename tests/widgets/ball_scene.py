"""Twelve balls at known places before two cameras, painted with a known centre each.

The cameras are pinholes 600 mm away; u and v are written out below, not taken from pawnb.
"""

import functools

import cv2
import numpy as np
import pandas as pd

SIZE = (640, 400)
FOCAL = 2200.0
VIEWS = {"left": -0.5, "right": 0.5}  # radians about z
DOWN = 0.3  # radians that both look down
PLACES = {
    f"b{i}{j}{k}": (40.0 * i - 20.0, 50.0 * j - 50.0, 45.0 * k)
    for k in range(2) for j in range(3) for i in range(2)
}  # fmt: skip
RADIUS_PX = 9.0


def seen(view, xyz):
    """Where a view sees points (n, 3), px."""
    c, s = np.cos(VIEWS[view]), np.sin(VIEWS[view])
    x, y, z = np.asarray(xyz, float).T
    across, away = c * x + s * y, -s * x + c * y
    depth = 600.0 + np.cos(DOWN) * away - np.sin(DOWN) * (z - 20.0)
    up = np.sin(DOWN) * away + np.cos(DOWN) * (z - 20.0)
    return np.stack([319.5 + FOCAL * across / depth, 199.5 - FOCAL * up / depth], axis=1)


@functools.cache
def picture(view):
    """Paint the balls, each pixel the mean of 16 places in it."""
    v, u = (np.indices((SIZE[1] * 4, SIZE[0] * 4)) + 0.5) / 4 - 0.5
    fine = np.zeros(u.shape, np.float32)
    for cu, cv in seen(view, list(PLACES.values())):
        fine[(u - cu) ** 2 + (v - cv) ** 2 < RADIUS_PX**2] = 1.0
    grey = cv2.resize(fine, SIZE, interpolation=cv2.INTER_AREA)
    return (50 + 170 * grey).astype(np.uint8)


def write(folder):
    """Write two folders of one picture each, and the known places; return the pictures."""
    for view in VIEWS:
        (folder / view).mkdir(parents=True)
        cv2.imwrite(str(folder / view / "0.png"), picture(view))
    table = pd.DataFrame(list(PLACES.values()), columns=list("xyz"))
    table.insert(0, "point", list(PLACES))
    table.to_csv(folder / "points.csv", index=False)
    return {view: folder / view for view in VIEWS}
