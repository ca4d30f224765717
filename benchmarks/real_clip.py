"""The real grey clip: where it is, its views, and its hand marks.

``mouse-side-bottom`` in the folder named by PAWNB_TEST_DATA (default: ../shared/data).
"""

from __future__ import annotations

import os
from pathlib import Path

import pandas as pd

from pawnb.trial import Animal, Calibration, Trial, View

LEGS = {"LH": "HL", "LF": "FL", "RF": "FR", "RH": "HR"}


def clip_folder() -> Path:
    """Return where the real clip is, or would be."""
    home = os.environ.get("PAWNB_TEST_DATA", Path(__file__).parents[2] / "shared" / "data")
    return Path(home) / "mouse-side-bottom"


def real_clip(folder: Path) -> Trial:
    """Describe the clip: two views cropped from one grey video."""
    return Trial(
        kind="paws",
        name=folder.name,
        fps=250.0,
        animal=Animal(id="mouse"),
        folder=folder,
        views=(
            View(name="cam1", video="test_vid.mp4", crop=(0, 0, 396, 168)),
            View(name="cam2", video="test_vid.mp4", crop=(0, 168, 396, 406)),
        ),
        calibration=Calibration(dlt="DLT_affine_fitted_from_labels.csv", unit="px"),
    )


def read_marks(path: Path) -> pd.DataFrame:
    """Read the hand marks as start clicks: frame, view, point, u, v."""
    table = pd.read_csv(path)
    parts = [
        table[["frame", "paw", f"{view}_x", f"{view}_y"]]
        .set_axis(["frame", "point", "u", "v"], axis=1)
        .assign(view=view)
        for view in ("cam1", "cam2")
    ]
    marks = pd.concat(parts).dropna().replace({"point": LEGS})
    return marks[["frame", "view", "point", "u", "v"]].reset_index(drop=True)
