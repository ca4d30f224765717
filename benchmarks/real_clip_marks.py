"""The real clips with marks: where they are, which marked frames serve as clicks, what is right.

``real-clips`` in the folder named by PAWNB_TEST_DATA (default: ../shared/data); its README has the
files of a clip.
"""

from __future__ import annotations

import itertools
import json
import math
import os
import tomllib
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

CLICK_COLUMNS = ["frame", "view", "point", "u", "v"]
NEVER_CLICKED_FRAMES = 200
"""What a mark of a point that no click names counts as, frames from the nearest click."""
DOUBTED_SHARE, DOUBTED_LEAST = 0.05, 3
"""Of the list of suspects so much is taken as looked at, and so many rows at least."""
NEAR_FRAMES = 3
DOUBTED_CONFIDENCE = 0.2


def clips_folder() -> Path:
    """Return where the clips are, or would be."""
    home = os.environ.get("PAWNB_TEST_DATA", Path(__file__).parents[2] / "shared" / "data")
    return Path(home) / "real-clips"


@dataclass(frozen=True)
class Clip:
    """A clip with marks."""

    folder: Path

    @property
    def name(self) -> str:
        """What its folder is called."""
        return self.folder.name

    @cached_property
    def threshold_px(self) -> float:
        """How far from a mark a track still is right."""
        return float(self._meta["threshold_px"])

    @property
    def recording(self) -> str:
        """The film that it is of; clips of one film are not independent of each other."""
        return str(self._meta.get("recording", self.name))

    @cached_property
    def _meta(self) -> dict[str, Any]:
        return tomllib.loads((self.folder / "meta.toml").read_text())

    @cached_property
    def start(self) -> pd.DataFrame:
        """The clicks that come with it."""
        return pd.read_csv(self.folder / "start.csv")[CLICK_COLUMNS]

    @cached_property
    def marks(self) -> pd.DataFrame:
        """The visible marks: frame, view, point, u, v."""
        marks = pd.read_csv(self.folder / "marks.csv")
        return marks.loc[marks["visible"] == 1, CLICK_COLUMNS].reset_index(drop=True)

    def clicks(self, n: int) -> pd.DataFrame | None:
        """Return clicks in ``n`` frames; None where there are not more marked frames than that.

        In one frame they are those that come with the clip.
        """
        if n >= self.marks["frame"].nunique():
            return None
        if n == 1:
            return self.start
        chosen = self.marks["frame"].isin(click_frames(self.marks, n))
        return self.marks[chosen].reset_index(drop=True)


def click_frames(marks: pd.DataFrame, n: int) -> tuple[int, ...]:
    """Return ``n`` marked frames that are spread evenly.

    Those with the least time, summed over marks, to the nearest click of the same point in the
    same view; of equal ones the first.
    """
    groups = [set(own["frame"]) for _, own in marks.groupby(["view", "point"])]

    def cost(frames: tuple[int, ...]) -> int:
        away = 0
        for own in groups:
            here = [frame for frame in frames if frame in own]
            if not here:
                away += NEVER_CLICKED_FRAMES * len(own)
            else:
                away += sum(min(abs(mark - click) for click in here) for mark in own)
        return away

    return min(itertools.combinations(sorted(set(marks["frame"])), n), key=lambda f: (cost(f), f))


def compare(
    marks: pd.DataFrame, clicks: pd.DataFrame, tracks: pd.DataFrame | None, px: float
) -> pd.DataFrame:
    """Return the marks that count with distance, confidence, ok, took and said.

    Marks count in frames that were not clicked, of points that were clicked in that view.
    ``took`` is the point whose own mark in that frame and view is nearer to a wrong track than
    the track's, or empty. ``said`` says whether the track itself is known to be doubtful, apart
    from suspects. Without tracks all marks are wrong.
    """
    marks = marks[~marks["frame"].isin(clicks["frame"])]
    clicked = pd.MultiIndex.from_frame(clicks[["view", "point"]])
    counted = marks[pd.MultiIndex.from_frame(marks[["view", "point"]]).isin(clicked)]
    keys = ["frame", "view", "point"]
    if tracks is None:
        tracks = pd.DataFrame(columns=CLICK_COLUMNS).astype({"frame": int, "u": float, "v": float})
    tracks = tracks.reindex(columns=[*CLICK_COLUMNS, "confidence", "origin"]).drop_duplicates(keys)
    found = counted.merge(tracks, on=keys, how="left", suffixes=("", "_track"))
    found["distance"] = np.hypot(found["u"] - found["u_track"], found["v"] - found["v_track"])
    found["ok"] = found["distance"] <= px
    found["took"] = [_taken_for(row, marks) for row in found.itertuples()]
    found["said"] = (
        found["distance"].isna()
        | (found["confidence"] < DOUBTED_CONFIDENCE)
        | found["origin"].isin(["predicted", "missing"])
    )
    return found


def _taken_for(row: tuple, marks: pd.DataFrame) -> str:
    """Return the point that a wrong track is nearer to than to its own, or nothing."""
    if row.ok or not math.isfinite(row.distance):
        return ""
    same = (marks["frame"] == row.frame) & (marks["view"] == row.view)
    others = marks[same & (marks["point"] != row.point)]
    away = np.hypot(others["u"] - row.u_track, others["v"] - row.v_track)
    if away.empty or away.min() >= row.distance:
        return ""
    return str(others["point"].loc[away.idxmin()])


def in_suspects(found: pd.DataFrame, suspects: pd.DataFrame) -> np.ndarray:
    """Tell which marks the first suspects point to: that point, within a few frames."""
    first = suspects.head(max(DOUBTED_LEAST, math.ceil(DOUBTED_SHARE * len(suspects))))
    first = first.fillna({"view": "", "point": ""})
    out = []
    for row in found.itertuples():
        near = (first["frame"] - row.frame).abs() <= NEAR_FRAMES
        there = first["view"].isin([row.view, ""]) & first["point"].isin([row.point, ""])
        out.append(bool((near & there).any()))
    return np.array(out, dtype=bool)


def share_inside(found: pd.DataFrame, path: Path) -> pd.Series:
    """Return of each mark how much of its two coordinates lies inside the stated 95 % intervals.

    Known where a recording of one view has standard deviations of its positions in px; NaN
    elsewhere.
    """
    out = pd.Series(np.nan, index=found.index)
    with xr.open_dataset(path, engine="h5netcdf") as tracks:
        one_view = tracks.sizes.get("view") == 1 and tracks.attrs.get("units") == "px"
        if "sd" not in tracks or not one_view:
            return out
        sd = tracks["sd"].isel(individual=0).swap_dims(time="frame").load()
    for row in found.itertuples():
        if row.frame in sd["frame"] and row.point in sd["keypoint"]:
            limit = 1.96 * sd.sel(frame=row.frame, keypoint=row.point).to_numpy()
            if np.isfinite(limit).all():
                away = np.abs([row.u - row.u_track, row.v - row.v_track])
                out[row.Index] = (away <= limit).mean()
    return out


def auroc(doubt: np.ndarray, wrong: np.ndarray) -> float:
    """Return how often a wrong mark is doubted more than a right one (ties count half)."""
    if wrong.all() or not wrong.any():
        return math.nan
    more = doubt[wrong][:, None] - doubt[~wrong][None]
    return float((more > 0).mean() + 0.5 * (more == 0).mean())


def verdict(results: Path) -> str:
    """Return the verdict of a folder of results on the recording, where it has one."""
    path = results / "quality.json"
    return str(json.loads(path.read_text()).get("verdict", "")) if path.exists() else ""
