"""Reviewing and correcting tracks: everything the widget does, without the widget."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pawnb.core.edits.effects import Retracker
from pawnb.core.edits.log import Accept, Move
from pawnb.core.edits.solving import triangulate_views, usable_views
from pawnb.core.pose.as_tracks import is_pose
from pawnb.core.rig import Rig
from pawnb.errors import InputError
from pawnb.gait.analysis.leg_names import guess_legs
from pawnb.gait.legs import find_leg_place
from pawnb.schema import ORIGIN_CODE, ORIGINS, Tracks
from pawnb.trial import Trial
from pawnb.widgets.start_marks import FAR_PX
from pawnb.widgets.stretch_edits import StretchEdits, order_partners
from pawnb.workflow.export.colours import point_colours
from pawnb.workflow.export.marks import TRAIL


class ReviewSession(StretchEdits):
    """Points under review: what :class:`StretchEdits` can, and what is drawn of them.

    Parameters
    ----------
    trial : Trial
        The trial of the tracks.
    tracks : xarray.Dataset
        Its tracks; not modified.
    rig : Rig, optional
        The calibrated views.
    edits, retrack, save, before
        As for :class:`~pawnb.widgets.corrected_tracks.CorrectedTracks`.

    Raises
    ------
    InputError
        As there, and for tracks of a jointed animal, whose points are not moved
        one by one.
    """

    def __init__(
        self,
        trial: Trial,
        tracks: Tracks,
        *,
        rig: Rig | None = None,
        edits: str | Path | None = None,
        retrack: Retracker | None = None,
        save: Callable[[Tracks], object] | None = None,
        before: Callable[[], Tracks] | None = None,
    ) -> None:
        if is_pose(tracks):
            raise InputError(
                "these are tracks of a jointed animal, which is corrected as a whole; open them "
                "with pawnb.widgets.PoseReviewer(trial, tracks)."
            )
        super().__init__(trial, tracks, rig=rig, edits=edits, retrack=retrack, save=save,
                         before=before)  # fmt: skip
        self.trial, self.rig = trial, rig
        self.views = [str(name) for name in tracks["view"].to_numpy()]
        self.points = [str(name) for name in tracks["keypoint"].to_numpy()]
        self.colours = point_colours(self.points)
        self.points_by_view = self._points_by_view()

    def pairs(self) -> list[tuple[str, str]]:
        """Return the pairs of points that can be mistaken for one another.

        First the left and the right one of each kind, also where no view tracks both: a camera
        beside the animal sees the far leg between the near ones. Then those that some view
        tracks both of.
        """
        every = list(combinations(self.points, 2))
        sided = {p: found for p in self.points if (found := _side_and_kind(p)) is not None}
        across = [
            (a, b)
            for a, b in every
            if {a, b} <= sided.keys() and sided[a][1] == sided[b][1] and sided[a][0] != sided[b][0]
        ]
        tracked = [set(points) for points in self.points_by_view.values()]
        seen = [pair for pair in every if any(set(pair) <= points for points in tracked)]
        return list(dict.fromkeys([*across, *seen]))

    def partners(self, point: str) -> list[str]:
        """Return the other points, those that are likely to be mistaken for it first."""
        return order_partners(point, self.points, self.pairs())

    # --- what a person does -------------------------------------------------------------

    def move(self, frame: int, view: str, point: str, *, u: float, v: float) -> str:
        """Put a point at (u, v) px of a view; returns what was done, in words.

        Parameters
        ----------
        frame : int
            The frame.
        view : str
            The view.
        point : str
            The point.
        u, v : float
            Place in the view, px.

        Returns
        -------
        str
            What was done.
        """
        return self.apply(Move(frame=frame, view=view, point=point, u=round(u, 3), v=round(v, 3)))

    def accept(self, frame: int, view: str, point: str) -> str:
        """Say that a point is right as it is; returns what was done, in words.

        Raises
        ------
        InputError
            If there is no position to accept.

        Parameters
        ----------
        frame : int
            The frame.
        view : str
            The view.
        point : str
            The point.

        Returns
        -------
        str
            What was done.
        """
        uv = self.position(frame, view, point)
        if uv is None:
            raise InputError(f"{point} has no position in {view}, frame {frame}; click it first.")
        return self.apply(Accept(frame=frame, view=view, point=point, u=uv[0], v=uv[1]))

    def position(self, frame: int, view: str, point: str) -> tuple[float, float] | None:
        """Return where a point is in px of a view, or None where it is missing.

        Parameters
        ----------
        frame : int
            The frame.
        view : str
            The view.
        point : str
            The point.

        Returns
        -------
        tuple of float or None
            (u, v), px.
        """
        with self.lock:
            tracks = self.present
            uv = tracks["image_position"].to_numpy()[
                self._row(frame), self.views.index(view), :, self.points.index(point), 0
            ]
        return (float(uv[0]), float(uv[1])) if np.isfinite(uv).all() else None

    def say_seen_once(self, frame: int, point: str) -> str:
        """Say in words what it means that one view only sees a point; empty where it is not so.

        Parameters
        ----------
        frame : int
            The frame.
        point : str
            The point.

        Returns
        -------
        str
            The end of a sentence.
        """
        with self.lock:
            tracks, row, p = self.present, self._row(frame), self.points.index(point)
            uv = tracks["image_position"].to_numpy()[row, :, :, p, 0]
            used = usable_views(uv, tracks["image_origin"].to_numpy()[row, :, p, 0])
            xyz = tracks["position"].to_numpy()[row, :, p, 0]
        if self.rig is None or len(xyz) != 3 or used.sum() != 1:
            return ""
        view, again = self.views[int(used.argmax())], "place it in a second view as well"
        if np.isfinite(xyz).all():
            return f"; only {view} sees it, so its distance from there is a guess: {again}"
        return f"; only {view} sees it, so it has no place in space here: {again}"

    def say_lost(self, first: int, stop: int, point: str) -> str:
        """Say in words in how many frames one view only is left of a point over a stretch.

        Parameters
        ----------
        first, stop : int
            First frame, and one past the last.
        point : str
            The point.

        Returns
        -------
        str
            The end of a sentence; empty where it is so in none.
        """
        if self.rig is None or self.present.sizes["space"] != 3:
            return ""
        with self.lock:
            tracks, p = self.present, self.points.index(point)
            frames = tracks["frame"].to_numpy()
            rows = np.flatnonzero((frames >= first) & (frames < stop))
            uv = tracks["image_position"].to_numpy()[rows, :, :, p, 0]
            used = usable_views(uv, tracks["image_origin"].to_numpy()[rows, :, p, 0])
            lost = np.isnan(tracks["position"].to_numpy()[rows, :, p, 0]).any(axis=1)
        n = int((lost & (used.sum(axis=1) == 1)).sum())
        if not n:
            return ""
        return f"; in {n} of these frames only one view has {point}, so it has no place in space"

    def is_seen(self, frame: int, view: str, point: str) -> bool:
        """Whether a view has a point of its own: not missing, nor shown from its place in space.

        Parameters
        ----------
        frame : int
            The frame.
        view : str
            The view.
        point : str
            The point.

        Returns
        -------
        bool
            Whether there is a ring to drag.
        """
        tracks, place = self.present, (self.views.index(view), self.points.index(point))
        origin = int(tracks["image_origin"].to_numpy()[self._row(frame), *place, 0])
        return (
            origin != ORIGIN_CODE["reprojected"] and self.position(frame, view, point) is not None
        )

    # --- what is drawn ------------------------------------------------------------------

    def overlay(self, frame: int) -> dict[str, Any]:
        """Return what is drawn over a frame; see ``frame_canvas.Overlay``."""
        with self.lock:
            tracks = self.present
            row = self._row(frame)
            past = slice(max(0, row - TRAIL), row + 1)
            trail = tracks["image_position"].to_numpy()[past, ..., 0]  # (n, V, 2, P)
            origin = tracks["image_origin"].to_numpy()[row, ..., 0]  # (V, P)
            confidence = tracks["image_confidence"].to_numpy()[row, ..., 0]
            residual = tracks["residual"].to_numpy()[row, :, 0]
            xyz = tracks["position"].to_numpy()[row, ..., 0].T  # (P, 2 or 3)
            expected, alone = self._reproject(tracks, trail[-1], origin, xyz)
        views = {}
        for k, view in enumerate(self.views):
            marks: dict[str, Any] = {"points": [], "hollow": [], "lines": [], "chips": []}
            marks |= {"guides": {}, "limit_px": FAR_PX}
            for p, point in enumerate(self.points):
                own = {"id": point, "colour": self.colours[point]}
                uv, from_others = trail[-1, k, :, p], expected[k, p]
                word = ORIGINS[origin[k, p]]
                shown = np.isfinite(uv).all()
                if shown and word != "reprojected":
                    marks["points"].append(own | _uv(uv) | {"origin": word})
                if np.isfinite(from_others).all():
                    marks["hollow"].append(own | _uv(from_others))
                if alone[k, p]:
                    marks["guides"][point] = [_pair(from_others)]
                if np.isfinite(trail[:, k, :, p]).all(axis=1).sum() > 1:
                    at = [_pair(q) for q in trail[:, k, :, p]]
                    marks["lines"].append({"at": at, "colour": own["colour"], "fade": True})
                if point in self.points_by_view[view] or shown:
                    words = _describe_point(
                        word, confidence[k, p], residual[p],
                        float(np.hypot(*(uv - from_others))) if alone[k, p] and shown else np.nan,
                    )  # fmt: skip
                    state = {"measured": "ok", "resolved": "ok"}.get(word, word)
                    marks["chips"].append(own | {"state": state, "title": f"{point}: {words}"})
            views[view] = marks
        return {"views": views}

    def _reproject(
        self, tracks: Tracks, uv: np.ndarray, origin: np.ndarray, xyz: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return where the other views see each point (V, P, 2), and where its own was left out.

        Each view is left out in turn, so that a point that is wrong in one view shows up
        there. Where fewer than two others see the point, its 3D position is shown.
        """
        n_views, n_points = origin.shape
        expected = np.full((n_views, n_points, 2), np.nan)
        alone = np.zeros((n_views, n_points), dtype=bool)
        if self.rig is None or xyz.shape[-1] != 3:
            return expected, alone
        uv_points = np.moveaxis(uv, 2, 0)  # (P, V, 2)
        used = usable_views(uv_points, origin.T)  # (P, V)
        others = used[None] & ~np.eye(n_views, dtype=bool)[:, None]  # (left out, P, V)
        stack = np.broadcast_to(uv_points, (n_views, *uv_points.shape))
        apart, _, _ = triangulate_views(tracks, self.rig, stack, used=others)  # (left out, P, 3)
        alone = np.asarray(np.isfinite(apart).all(axis=-1))
        projected = self.rig.project(np.where(alone[..., None], apart, xyz[None]))
        for place, name in enumerate(self.rig.names):
            if name in self.views:
                k = self.views.index(name)
                expected[k] = projected[k, :, place]
        return expected, alone

    # --- inside -------------------------------------------------------------------------

    def _row(self, frame: int) -> int:
        frames = self.present["frame"].to_numpy()
        rows = np.flatnonzero(frames == frame)
        if not len(rows):
            raise InputError(f"frame {frame} is not in the tracks ({frames[0]} to {frames[-1]}).")
        return int(rows[0])

    def _points_by_view(self) -> dict[str, tuple[str, ...]]:
        """Return what each view tracks: what the trial says, else what was found in it."""
        listed: Mapping[str, Sequence[str]] = {v.name: v.points for v in self.trial.views}
        origin = self.present["image_origin"].to_numpy()[..., 0]
        own = (origin != ORIGIN_CODE["missing"]) & (origin != ORIGIN_CODE["reprojected"])
        found = own.any(axis=0)  # (V, P)
        return {
            view: tuple(listed.get(view, ()))
            or tuple(p for p, there in zip(self.points, found[k], strict=True) if there)
            for k, view in enumerate(self.views)
        }


def _side_and_kind(point: str) -> tuple[str, str] | None:
    """Return the side of a point, and what it is called without it; None where it has no side."""
    leg = next(iter(guess_legs([point])), None)
    place = None if leg is None else find_leg_place(leg)
    if place is not None:
        return place.side, f"leg {place.rank}"
    words = [word for word in re.split(r"[^0-9a-z]+", point.lower()) if word]
    side = [word[0] for word in words if word in ("l", "r", "left", "right")]
    rest = [word for word in words if word not in ("l", "r", "left", "right")]
    return (side[0].upper(), " ".join(rest)) if len(side) == 1 and rest else None


def suspect_options(suspects: pd.DataFrame | None, *, most: int = 200) -> list[list[str]]:
    """Return the frames to look at as choices of a menu, most doubtful first.

    Parameters
    ----------
    suspects : pandas.DataFrame or None
        Columns frame, view, point, reason, score.
    most : int
        How many are listed.

    Returns
    -------
    list of [value, text]
        The value is the place in the list, from 0.
    """
    if suspects is None:
        return []
    return [
        [str(place), f"frame {row['frame']}: {row['point']} in {row['view']}, {row['reason']}"]
        for place, row in enumerate(suspects.head(most).to_dict("records"))
    ]


def _uv(uv: np.ndarray) -> dict[str, float]:
    return {"u": round(float(uv[0]), 2), "v": round(float(uv[1]), 2)}


def _pair(uv: np.ndarray) -> list[float] | None:
    return [round(float(x), 1) for x in uv] if np.isfinite(uv).all() else None


_FROM_SPACE = "shown from the 3D position; click in this view to place it"


def _describe_point(origin: str, confidence: float, residual: float, off: float) -> str:
    """Say in words how sure a point is; distances in px, NaN where not known."""
    if origin == "missing":
        return "not visible here; click in this view to place it"
    words = {"edited": "placed by hand", "reprojected": _FROM_SPACE}
    parts = [words.get(origin, f"{origin}, confidence {confidence:.2f}")]
    if np.isfinite(residual):
        parts.append(f"residual {residual:.1f} px")
    if np.isfinite(off):
        parts.append(f"{off:.1f} px from where the other views put it")
    return ", ".join(parts)
