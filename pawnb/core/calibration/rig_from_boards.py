"""Views calibrated together from one board in several poses, and cameras judged by such a board."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from pawnb.arrays import BoolArray, FloatArray
from pawnb.core.calibration.arrangement import Arrangement, arrange, as_vectors, place_boards
from pawnb.core.calibration.bundle import Adjusted, Boards, ViewObservations, adjust
from pawnb.core.calibration.corners import FEWEST_CORNERS
from pawnb.core.calibration.intrinsics import LensFit, fit_lens
from pawnb.core.calibration.optics import OPTICS_COLUMNS, POSE, camera_of_row, moved, row_of_camera
from pawnb.core.dlt import triangulate
from pawnb.core.lens import Lens
from pawnb.errors import CalibrationError
from pawnb.io.cameras import Camera, coefs_of_cameras

OUTLYING = 3.0
"""A shot of a view is outlying where its error is that many times the median of all (by hand)."""
LEAST_OUTLYING_PX = 1.0
"""And above this: corners are found to 0.1 to 0.5 px (measured on mouse-4cam-cage)."""


LEAST_SHARED = 3
"""Shots by which a view stands to the others; one fits whatever it says, two hardly tell."""


@dataclass(frozen=True, kw_only=True)
class Sightings:
    """A board as seen by several views at the same instants.

    Parameters
    ----------
    names : tuple of str
        The views.
    sizes : tuple of (int, int)
        Width and height of the picture of each, px.
    corners : ndarray, shape (n_corners, 3)
        Corners on the board.
    uv : ndarray, shape (n_views, n_shots, n_corners, 2)
        Where they are seen, px of the picture as filmed; NaN where they are not.
    may_be_turned : bool
        Whether corners may be counted from another one, as on a checkerboard.
    """

    names: tuple[str, ...]
    sizes: tuple[tuple[int, int], ...]
    corners: FloatArray
    uv: FloatArray
    may_be_turned: bool = False


@dataclass(frozen=True, kw_only=True)
class BoardFit:
    """Cameras, and how well they show the board.

    Parameters
    ----------
    cameras : tuple of Camera
        The cameras, in the axes of the board of one shot.
    shots : DataFrame
        ``view, shot, n_corners, rms_px, worst_px, set_aside``: a row for each shot that a view saw.
    uv : ndarray, shape (n_views, n_shots, n_corners, 2)
        Where corners were seen, px: counted from the same one in every view, NaN where a shot is
        set aside.
    lenses : tuple of LensFit
        How each lens was found; empty for cameras that were only judged.
    floor : int or None
        The shot whose board gives the axes.
    """

    cameras: tuple[Camera, ...]
    shots: pd.DataFrame
    uv: FloatArray
    lenses: tuple[LensFit, ...] = ()
    floor: int | None = None

    def of_view(self, view: str) -> dict[str, float]:
        """Return n_shots, n_corners, rms_px and worst_px of a view, without what is set aside."""
        rows = self.shots[(self.shots["view"] == view) & ~self.shots["set_aside"]]
        n = rows["n_corners"].to_numpy()
        square = float((n * rows["rms_px"].to_numpy() ** 2).sum())
        return {
            "n_shots": len(rows),
            "n_corners": int(n.sum()),
            "rms_px": float(np.sqrt(square / n.sum())) if len(rows) else np.nan,
            "worst_px": float(rows["worst_px"].max()) if len(rows) else np.nan,
        }


def calibrate_by_boards(
    sightings: Sightings,
    *,
    floor: int | None = None,
    aside: Collection[tuple[str, int]] = (),
) -> BoardFit:
    """Calibrate views by a board that was shown to them in several poses.

    Lens by lens first (Zhang 2000, as in OpenCV), then the cameras to each other by shots that two
    of them share, then all of it by bundle adjustment. Shots that do not agree are set aside and
    the others adjusted again.

    Parameters
    ----------
    sightings : Sightings
        What was seen.
    floor : int, optional
        The shot whose board gives the axes: x and y along it, z towards who looks at it. Default
        the first that most views see.
    aside : collection of (str, int)
        Views and shots that are set aside from the first.

    Returns
    -------
    BoardFit
        The cameras and the error of each shot.

    Raises
    ------
    CalibrationError
        If there is one view only, a view sees the board too rarely, shares no shot with the
        others, or does not agree with them.
    """
    names, uv = sightings.names, sightings.uv
    if len(names) < 2:
        raise CalibrationError(
            f"one view only ({', '.join(names)}): where a point is in space is told by two or "
            "more; for a single view, measure px_per_unit."
        )
    lenses = tuple(
        fit_lens(sightings.corners, uv[v], size=sightings.sizes[v], view=name)
        for v, name in enumerate(names)
    )
    start = arrange(
        sightings.corners,
        uv,
        np.stack([one.lens for one in lenses]),
        names=names,
        may_be_turned=sightings.may_be_turned,
    )
    rows = np.hstack([np.stack([one.lens for one in lenses]), as_vectors(start.cameras)])
    is_free = np.zeros(rows.shape, bool)
    for v, one in enumerate(lenses):
        is_free[v, [OPTICS_COLUMNS.index(name) for name in one.free]] = True
        is_free[v, POSE] = v != start.first
    found, shots = _without_outliers(sightings, start, rows, is_free, aside)
    at = _floor(shots, floor, n_shots=uv.shape[1])
    place = np.unique(shots["shot"]).tolist().index(at)
    pose = found.free.reshape(-1, 6)[place]
    R = Rotation.from_rotvec(pose[:3]).as_matrix()
    cameras = tuple(
        camera_of_row(moved(row, R, pose[3:]), name=name, size=size)
        for row, name, size in zip(found.cameras, names, sightings.sizes, strict=True)
    )
    return BoardFit(
        cameras=cameras, shots=shots, uv=_agreed(start.uv, names, shots), lenses=lenses, floor=at
    )


def judge_by_boards(cameras: Sequence[Camera], sightings: Sightings) -> BoardFit:
    """Tell how well cameras that are given show a board: only the boards are moved.

    Parameters
    ----------
    cameras : sequence of Camera
        The cameras, in the order of the views.
    sightings : Sightings
        What was seen.

    Returns
    -------
    BoardFit
        The same cameras, with the error of each shot. A camera that is wrong among several that
        are right has nearly all of the error (soft L1).
    """
    rows = np.stack([row_of_camera(camera) for camera in cameras])
    start = place_boards(
        sightings.corners, sightings.uv, rows, may_be_turned=sightings.may_be_turned
    )
    _, shots = _adjusted(sightings, start, rows, np.zeros(rows.shape, bool), set())
    return BoardFit(
        cameras=tuple(cameras), shots=shots, uv=_agreed(start.uv, sightings.names, shots)
    )


def find_outlying_views(shots: pd.DataFrame) -> list[str]:
    """Name views that most of their shots do not agree with.

    Parameters
    ----------
    shots : DataFrame
        As in :class:`BoardFit`.

    Returns
    -------
    list of str
        Views whose median shot is three times worse than that of the others.
    """
    rms = shots.groupby("view", sort=False)["rms_px"].median()
    usual = {view: rms.drop(view).median() for view in rms.index} if len(rms) > 1 else {}
    return [v for v in usual if rms[v] > max(OUTLYING * usual[v], LEAST_OUTLYING_PX)]


def tell_disagreement(fit: BoardFit) -> str | None:
    """Say which views show boards well alone, and badly or too rarely together with the others.

    Parameters
    ----------
    fit : BoardFit
        Cameras of :func:`calibrate_by_boards`. Films that are out of step by a frame or two bend
        all cameras a little, so that no single one stands out.

    Returns
    -------
    str or None
        A sentence with the error of each such view; None where the views agree, or cameras were
        judged only.
    """
    if not fit.lenses:
        return None
    names = [camera.name for camera in fit.cameras]
    alone = {name: lens.rms_px for name, lens in zip(names, fit.lenses, strict=True)}
    # with those set aside: what is left of films out of step are shots in which nothing moved
    both = fit.shots.groupby("view")["rms_px"].median()
    off = [v for v in names if both[v] > max(OUTLYING * alone[v], LEAST_OUTLYING_PX)]
    if not off:
        return _tell_weak_link(fit.shots)
    each = ", ".join(f"{v} {both[v]:.1f} px together, {alone[v]:.1f} alone" for v in off)
    return (
        f"the views do not agree, though each alone shows the board well ({each}): pictures "
        "of one number are not of one instant (a film was started some frames later, frames were "
        "dropped, the board was moved between pictures), or a camera was moved; positions in space "
        "will be wrong: bring frames of one instant to one number, and calibrate again"
    )


def _tell_weak_link(shots: pd.DataFrame) -> str | None:
    """Say which view stands where it stands by the word of too few shots; None without such."""
    used = shots[~shots["set_aside"]]
    seen = {str(view): set(own["shot"]) for view, own in used.groupby("view", sort=False)}
    placed = [max(seen, key=lambda view: len(seen[view]))]
    while len(placed) < len(seen):
        known = set().union(*(seen[view] for view in placed))
        shared = {view: len(own & known) for view, own in seen.items() if view not in placed}
        best = max(shared, key=lambda view: shared[view])
        if shared[best] < LEAST_SHARED:
            n = shared[best]
            return (
                f"view {best!r} shares only {n} picture{'' if n == 1 else 's'} of the board with "
                f"the other views ({', '.join(placed)}), so that small errors in px do not tell "
                "whether it stands where it is put; positions in space may be far off: show the "
                f"board to them at one instant in {LEAST_SHARED} pictures or more, tilted "
                "differently (markers of a ChArUco board hide it where it is described as a "
                "checkerboard)"
            )
        placed.append(best)
    return None


def _without_outliers(
    sightings: Sightings,
    start: Arrangement,
    rows: FloatArray,
    is_free: BoolArray,
    given: Collection[tuple[str, int]],
) -> tuple[Adjusted, pd.DataFrame]:
    """Adjust, set aside what does not agree, and adjust the others again.

    Of one instant the worst view is set aside at a time: it draws the board away from the others.
    """
    aside = set(given)
    while True:
        found, shots = _adjusted(sightings, start, rows, is_free, aside)
        limit = max(OUTLYING * float(shots["rms_px"].median()), LEAST_OUTLYING_PX)
        outlying = shots[(shots["rms_px"] > limit) & ~shots["set_aside"]]
        if outlying.empty:
            return found, shots
        worst = outlying.loc[outlying.groupby("shot")["rms_px"].idxmax()]
        aside |= set(zip(worst["view"], worst["shot"], strict=True))
        _refuse_views(shots, aside - set(given))


def _refuse_views(shots: pd.DataFrame, outlying: set[tuple[str, int]]) -> None:
    """Refuse views of which most shots do not agree with the others."""
    for view, own in shots.groupby("view", sort=False):
        bad = [shot for name, shot in outlying if name == view]
        if 2 * len(bad) > len(own):
            rms = float(own["rms_px"].median())
            raise CalibrationError(
                f"view {view!r} does not agree with the others in {len(bad)} of {len(own)} "
                f"pictures (corner error {rms:.1f} px): its pictures are of other instants or of "
                "another board, or it was moved in between; give its pictures in the order of "
                "the others', or leave it out."
            )


def _adjusted(
    sightings: Sightings,
    start: Arrangement,
    rows: FloatArray,
    is_free: BoolArray,
    aside: set[tuple[str, int]],
) -> tuple[Adjusted, pd.DataFrame]:
    """Adjust to all shots that are not set aside; return the error of each."""
    names, n_corners = sightings.names, len(sightings.corners)
    seen = np.isfinite(start.uv[..., 0])
    seen[seen.sum(axis=-1) < FEWEST_CORNERS] = False
    seen &= np.isfinite(start.boards[:, 0, 0])[None, :, None]
    used = seen.copy()
    for view, shot in aside:
        used[names.index(view), shot] = False
    kept = np.flatnonzero(seen.any(axis=(0, 2)))
    number = np.full(seen.shape[1], -1)
    number[kept] = np.arange(len(kept))
    boards = Boards(as_vectors(start.boards[kept]), sightings.corners)

    def observations(which: BoolArray) -> ViewObservations:
        v, s, c = np.nonzero(which)
        return ViewObservations(v, number[s] * n_corners + c, start.uv[which])

    found = adjust(observations(used), rows, boards, is_free=is_free)
    off = observations(seen)
    errors = found.errors(off)
    table = pd.DataFrame(
        {
            "view": np.array(names, dtype=object)[off.view],
            "shot": kept[off.place // n_corners],
            "square": errors**2,
            "error": errors,
        }
    )
    shots = table.groupby(["view", "shot"], sort=False).agg(
        n_corners=("error", "size"), square=("square", "mean"), worst_px=("error", "max")
    )
    shots = shots.reset_index().assign(rms_px=lambda t: np.sqrt(t["square"]))
    is_aside = [pair in aside for pair in zip(shots["view"], shots["shot"], strict=True)]
    shots = shots.assign(set_aside=np.array(is_aside, bool))
    return found, shots[["view", "shot", "n_corners", "rms_px", "worst_px", "set_aside"]]


def _agreed(uv: FloatArray, names: Sequence[str], shots: pd.DataFrame) -> FloatArray:
    """Return corners without those of shots that are set aside."""
    uv = uv.copy()
    for row in shots[shots["set_aside"]].itertuples():
        uv[names.index(str(row.view)), int(str(row.shot))] = np.nan
    return uv


def _floor(shots: pd.DataFrame, floor: int | None, *, n_shots: int) -> int:
    """Return the shot whose board gives the axes."""
    agreed = shots[~shots["set_aside"]]
    count = agreed.groupby("shot")["view"].size()
    if floor is None:
        return int(count.index[int(count.to_numpy().argmax())])
    if floor not in count.index:
        raise CalibrationError(
            f"the board of picture {floor} gives no axes: it is not among the {n_shots} pictures "
            "(counted from 0), no view found it, or it does not agree with the others."
        )
    return floor


def sides_in_space(fit: BoardFit, corners: FloatArray) -> FloatArray:
    """Return distances of neighbouring corners that were triangulated, without rigid boards.

    Parameters
    ----------
    fit : BoardFit
        The cameras and what they saw.
    corners : ndarray, shape (n_corners, 3)
        Corners on the board.

    Returns
    -------
    ndarray, shape (n,)
        Lengths in the unit of the board, of corners that two views or more saw.
    """
    straight = np.stack(
        [
            Lens(matrix=tuple(map(tuple, c.matrix)), distortion=c.distortion or (0.0,) * 5)
            .straighten(fit.uv[v])
            for v, c in enumerate(fit.cameras)
        ],
        axis=-2,
    )  # fmt: skip
    coefs, _ = coefs_of_cameras(fit.cameras)
    xyz = triangulate(coefs, straight, even=True).xyz
    step = np.linalg.norm(np.diff(corners, axis=0), axis=1)
    beside = np.isclose(step, step.min())
    sides = np.linalg.norm(np.diff(xyz, axis=1), axis=-1)[:, beside]
    return sides[np.isfinite(sides)]
