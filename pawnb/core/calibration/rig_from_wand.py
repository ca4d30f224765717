"""Views calibrated together from a wand of known length that was moved through the filmed space.

As Theriault et al. (2014, J. Exp. Biol. 217:1843) do: the relation of the two views that share most
from their essential matrix, the others from the points so found, then bundle adjustment in which
the two ends are the wand's length apart.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from pawnb.core.calibration.bundle import Adjusted, ViewObservations, adjust
from pawnb.core.calibration.optics import (
    OPTICS_COLUMNS,
    POSE,
    camera_of_row,
    moved,
    row_of_camera,
)
from pawnb.core.calibration.rig_from_boards import LEAST_OUTLYING_PX, OUTLYING
from pawnb.core.dlt import reprojection_error, triangulate
from pawnb.core.lens import Lens
from pawnb.errors import CalibrationError
from pawnb.io.cameras import Camera, coefs_of_cameras

FEWEST_FRAMES = 10
"""Fewer positions of the wand leave focal lengths and the arrangement undetermined."""

_FOCAL_GUESSES = (0.7, 1.0, 1.5, 2.5, 4.0)
"""Focal lengths to begin with, in lengths of the longer side: 71 to 14 degrees of view."""
_GUESS_FRAMES = 30
"""Frames with which the guesses are tried."""
_MOST_WAND_FRAMES = 300
"""Frames that are adjusted: more add time and nothing else."""
_MOST_OFF = 0.01
"""An error above this part of the picture's longer side is that of another place."""
_RANSAC_PX = 3.0
_STIFF_END = 10.0
"""The length of the wand is known that many times better than a pixel."""


@dataclass(frozen=True, kw_only=True)
class WandSightings:
    """The two ends of a wand as seen by several views at the same instants.

    Parameters
    ----------
    names : tuple of str
        The views.
    sizes : tuple of (int, int)
        Width and height of the picture of each, px.
    length : float
        Distance of the two ends, in the unit that the calibration will have.
    uv : ndarray, shape (n_views, n_frames, 2, 2)
        Where both ends are seen, px of the picture as filmed; NaN where they are not.
    lenses : tuple of Lens, optional
        Lenses that are known, one a view, for instance from a board. Without them focal lengths are
        found, and nothing is taken to bend.
    """

    names: tuple[str, ...]
    sizes: tuple[tuple[int, int], ...]
    length: float
    uv: np.ndarray
    lenses: tuple[Lens, ...] = ()


@dataclass(frozen=True, kw_only=True)
class WandFit:
    """Cameras, and how well they show the wand.

    Parameters
    ----------
    cameras : tuple of Camera
        The cameras: z is up in their pictures, x to the right in the first, zero amid the wands.
    errors : DataFrame
        ``view, frame, error_px, set_aside``: a row for each place of the wand that a view saw; the
        error is that of the worse end, the frame the place in ``uv``.
    """

    cameras: tuple[Camera, ...]
    errors: pd.DataFrame


@dataclass(frozen=True)
class _Wands:
    """Free points, two for each frame, that are a length apart (a structure of the adjustment)."""

    xyz: np.ndarray  # (2 * n_frames, 3)
    length: float
    px_per_unit: float

    def start(self) -> np.ndarray:
        return self.xyz.ravel()

    def points(self, free: np.ndarray) -> np.ndarray:
        return free.reshape(-1, 3)

    def columns(self, place: np.ndarray) -> np.ndarray:
        return 3 * place[:, None] + np.arange(3)

    def beside(self, xyz: np.ndarray) -> np.ndarray:
        length = np.linalg.norm(xyz[0::2] - xyz[1::2], axis=1)
        return _STIFF_END * self.px_per_unit * (length - self.length)

    def beside_columns(self) -> np.ndarray:
        return 6 * np.arange(len(self.xyz) // 2)[:, None] + np.arange(6)


def calibrate_by_wand(wand: WandSightings) -> WandFit:
    """Calibrate views by a wand of known length.

    Parameters
    ----------
    wand : WandSightings
        What was seen.

    Returns
    -------
    WandFit
        The cameras and the error of each place of the wand.

    Raises
    ------
    CalibrationError
        If there is one view only, views share too few frames, they do not determine cameras, or
        a view does not agree with the others in most frames.
    """
    names = wand.names
    if len(names) < 2:
        raise CalibrationError(
            f"one view only ({', '.join(names)}): a wand calibrates two or more views that see it "
            "at the same instants."
        )
    is_whole = np.isfinite(wand.uv).all(axis=(2, 3))
    frames = np.flatnonzero(is_whole.sum(axis=0) >= 2)
    if len(frames) < FEWEST_FRAMES:
        raise CalibrationError(
            f"both ends of the wand are seen by two views in {len(frames)} frames; at least "
            f"{FEWEST_FRAMES} are needed, with the wand all over the filmed space and turned in "
            "all directions."
        )
    frames = _some(frames, _MOST_WAND_FRAMES)
    rows = _begin(wand, _some(frames, _GUESS_FRAMES))
    aside: dict[tuple[str, int], float] = {}  # view and frame to their error, px
    for _ in range(len(names) + 1):
        found, errors = _adjusted(wand, rows, frames, set(aside))
        limit = max(OUTLYING * float(errors["error_px"].median()), LEAST_OUTLYING_PX)
        outlying = errors[(errors["error_px"] > limit) & ~errors["set_aside"]]
        if outlying.empty:
            break
        worst = outlying.loc[outlying.groupby("frame")["error_px"].idxmax()]
        aside |= dict(
            zip(zip(worst["view"], worst["frame"], strict=True), worst["error_px"], strict=True)
        )
    errors = _with_dropped(errors, aside)
    _check_agreement(wand, errors)
    return WandFit(cameras=_upright(wand, found), errors=errors)


def _check_agreement(wand: WandSightings, errors: pd.DataFrame) -> None:
    """Refuse cameras of which one does not show the wand where the others do, in most frames."""
    for name, size in zip(wand.names, wand.sizes, strict=True):
        own = errors[errors["view"] == name]
        limit = _MOST_OFF * max(size)
        kept = int((~own["set_aside"].to_numpy(bool) & (own["error_px"] < limit)).sum())
        if kept < max(FEWEST_FRAMES, len(own) / 2):
            raise CalibrationError(
                f"view {name!r} agrees with the others in {kept} of {len(own)} frames of the wand "
                f"(median error {own['error_px'].median():.1f} px): it, or one of them, has frames "
                "of other instants, a mirrored or turned picture, a size that is not that of its "
                "picture, or a camera that was moved; mend that view, or leave it out."
            )


def _with_dropped(errors: pd.DataFrame, aside: Mapping[tuple[str, int], float]) -> pd.DataFrame:
    """Add what was set aside in frames that no two views are left of, as it was found."""
    there = set(zip(errors["view"], errors["frame"], strict=True))
    dropped = [(*pair, error, True) for pair, error in aside.items() if pair not in there]
    if not dropped:
        return errors
    return pd.concat([errors, pd.DataFrame(dropped, columns=errors.columns)], ignore_index=True)


def _begin(wand: WandSightings, frames: np.ndarray) -> np.ndarray:
    """Return cameras to begin with: of all guesses of the focal length the one that ends best."""
    best, best_error = None, np.inf
    for guess in _FOCAL_GUESSES if not wand.lenses else (1.0,):
        rows = np.stack([_lens_row(wand, v, guess) for v in range(len(wand.names))])
        try:
            rows = _arranged(wand, rows, frames)
            found, errors = _adjusted(wand, rows, frames, set())
        except (CalibrationError, cv2.error, np.linalg.LinAlgError):
            continue
        error = float(errors["error_px"].median())
        if error < best_error and (found.cameras[:, 1] > 0).all():
            best, best_error = found.cameras, error
    if best is None:
        raise CalibrationError(
            "no arrangement of the views fits the wand; check that both ends have the same names "
            "in every view, that frames are of the same instants, and that the wand was turned in "
            "all directions."
        )
    return best


def _lens_row(wand: WandSightings, view: int, guess: float) -> np.ndarray:
    """Return a camera without a place: its lens as known, or a guess of its focal length."""
    if wand.lenses:
        lens = wand.lenses[view]
        return row_of_camera(
            Camera(
                name=wand.names[view], matrix=np.array(lens.matrix), distortion=lens.distortion,
                rotation=np.eye(3), translation=np.zeros(3),
            )
        )  # fmt: skip
    width, height = wand.sizes[view]
    row = np.zeros(len(OPTICS_COLUMNS))
    row[:4] = 1.0, guess * max(width, height), (width - 1) / 2, (height - 1) / 2
    return row


def _arranged(wand: WandSightings, rows: np.ndarray, frames: np.ndarray) -> np.ndarray:
    """Place the cameras: two by their essential matrix, the others by points that those see."""
    n = len(rows)
    straight = _straight(wand, rows)[:, frames].reshape(n, -1, 2)
    rays = (straight - rows[:, None, 2:4]) / (rows[:, None, [1, 1]] * [1.0, 1.0])
    rays[..., 1] /= rows[:, None, 0]
    seen = np.isfinite(rays[..., 0])
    pairs = {(a, b): int((seen[a] & seen[b]).sum()) for a in range(n) for b in range(a + 1, n)}
    a, b = max(pairs, key=lambda pair: pairs[pair])
    rows = rows.copy()
    both = seen[a] & seen[b]
    limit = _RANSAC_PX / rows[[a, b], 1].mean()
    E, _ = cv2.findEssentialMat(rays[a, both], rays[b, both], np.eye(3), cv2.RANSAC, 0.999, limit)
    if E is None or E.shape != (3, 3):
        raise CalibrationError("the two views with most in common have no essential matrix.")
    _, R, t, _ = cv2.recoverPose(E, rays[a, both], rays[b, both], np.eye(3))
    rows[b, POSE] = np.r_[Rotation.from_matrix(R).as_rotvec(), t.ravel()]
    placed = [a, b]
    size = _wand_lengths(_in_space(wand, rows, placed)[frames])
    rows[b, 12:15] *= wand.length / np.nanmedian(size)
    while len(placed) < n:
        xyz = _in_space(wand, rows, placed)[frames].reshape(-1, 3)
        known = np.isfinite(xyz).all(axis=1)
        v = max((v for v in range(n) if v not in placed), key=lambda v: (known & seen[v]).sum())
        use = known & seen[v]
        if use.sum() < FEWEST_FRAMES:
            raise CalibrationError(f"view {wand.names[v]!r} shares too few frames with the others.")
        found, rvec, tvec, _ = cv2.solvePnPRansac(
            xyz[use], rays[v, use], np.eye(3), None,
            reprojectionError=4 * _RANSAC_PX / rows[v, 1], flags=cv2.SOLVEPNP_EPNP,
        )  # fmt: skip
        if not found:
            raise CalibrationError(f"view {wand.names[v]!r} cannot be placed.")
        rows[v, POSE] = np.r_[rvec.ravel(), tvec.ravel()]
        placed.append(v)
    return rows


def _adjusted(
    wand: WandSightings, rows: np.ndarray, frames: np.ndarray, aside: set[tuple[str, int]]
) -> tuple[Adjusted, pd.DataFrame]:
    """Adjust to what is not set aside; return the error of each place of the wand."""
    names = wand.names
    seen = np.isfinite(wand.uv).all(axis=(2, 3))[:, frames]
    used = seen.copy()
    number = {int(frame): i for i, frame in enumerate(frames)}
    for view, frame in aside:
        used[names.index(view), number[frame]] = False
    xyz = _in_space(wand, rows, list(range(len(rows))))[frames]
    known = np.isfinite(xyz).all(axis=(1, 2)) & (used.sum(axis=0) >= 2)
    seen, used, xyz, kept = seen[:, known], used[:, known], xyz[known], frames[known]
    if len(kept) < FEWEST_FRAMES:
        raise CalibrationError(
            f"only {len(kept)} frames of the wand agree between views; at least {FEWEST_FRAMES} "
            "are needed."
        )
    uv = wand.uv[:, kept]
    is_free = np.zeros(rows.shape, bool)
    is_free[1:, POSE] = True
    if not wand.lenses:
        is_free[:, OPTICS_COLUMNS.index("f")] = True
    first = _to_first(rows)
    xyz = xyz @ first[0].T + first[1]
    depth = np.linalg.norm(xyz.reshape(-1, 3), axis=1).mean()
    structure = _Wands(xyz.reshape(-1, 3), wand.length, float(rows[:, 1].mean() / depth))

    def observations(which: np.ndarray) -> ViewObservations:
        v, f = np.nonzero(which)
        place = (2 * f[:, None] + np.arange(2)).ravel()
        return ViewObservations(np.repeat(v, 2), place, uv[v, f].reshape(-1, 2))

    found = adjust(observations(used), first[2], structure, is_free=is_free)
    v, f = np.nonzero(seen)
    error = found.errors(observations(seen)).reshape(-1, 2).max(axis=1)
    pairs = list(zip((names[i] for i in v), kept[f].tolist(), strict=True))
    return found, pd.DataFrame(
        {
            "view": np.array([view for view, _ in pairs], dtype=object),
            "frame": kept[f],
            "error_px": error,
            "set_aside": np.array([pair in aside for pair in pairs], bool),
        }
    )


def _to_first(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return rotation and translation to the axes of the first camera, and all cameras there."""
    R, t = Rotation.from_rotvec(rows[0, 9:12]).as_matrix(), rows[0, 12:15]
    cameras = np.stack([moved(row, R.T, -R.T @ t) for row in rows])
    cameras[0, POSE] = 0.0
    return R, t, cameras


def _straight(wand: WandSightings, rows: np.ndarray) -> np.ndarray:
    """Return what was seen, in pixels of straightened pictures."""
    cameras = _as_cameras(wand, rows)
    return np.stack(
        [
            wand.uv[v]
            if camera.is_straight
            else Lens(
                matrix=tuple(map(tuple, camera.matrix)), distortion=camera.distortion
            ).straighten(wand.uv[v])
            for v, camera in enumerate(cameras)
        ]
    )


def _in_space(wand: WandSightings, rows: np.ndarray, views: Sequence[int]) -> np.ndarray:
    """Return both ends of the wand in space (n_frames, 2, 3), from some of the views.

    Of all pairs of views, that which the median view agrees with best: one view that is wrong, its
    ends swapped for instance, does not draw the place away from the others.
    """
    chosen = list(views)
    coefs, origin = coefs_of_cameras([_as_cameras(wand, rows)[v] for v in chosen])
    straight = np.moveaxis(_straight(wand, rows)[chosen], 0, -2)
    best = np.full((*straight.shape[:2], 3), np.nan)
    least = np.full(straight.shape[:2], np.inf)
    for pair in itertools.combinations(range(len(chosen)), 2):
        xyz = triangulate(coefs[:, pair], straight[:, :, pair], even=True).xyz
        off = np.where(np.isfinite(straight[..., 0]), reprojection_error(coefs, xyz, straight), -1)
        # the median of the views that see it; those of the pair itself are among the least
        off = np.sort(np.where(off < 0, np.inf, off), axis=-1)
        n_seen = np.isfinite(off).sum(axis=-1)
        middle = np.take_along_axis(off, np.maximum(n_seen // 2, 1)[..., None], axis=-1)[..., 0]
        better = np.isfinite(xyz[..., 0]) & (middle < least)
        best[better], least[better] = xyz[better], middle[better]
    return best + origin


def _wand_lengths(xyz: np.ndarray) -> np.ndarray:
    """Return the distance of the two ends."""
    return np.linalg.norm(xyz[:, 0] - xyz[:, 1], axis=1)


def _as_cameras(wand: WandSightings, rows: np.ndarray) -> list[Camera]:
    """Return rows of numbers as cameras."""
    return [
        camera_of_row(row, name=name, size=size)
        for row, name, size in zip(rows, wand.names, wand.sizes, strict=True)
    ]


def _upright(wand: WandSightings, found: Adjusted) -> tuple[Camera, ...]:
    """Return the cameras in axes with z up in the pictures, x to the right in the first."""
    turns = Rotation.from_rotvec(found.cameras[:, 9:12]).as_matrix()
    up = -turns[:, 1].mean(axis=0)
    up /= np.linalg.norm(up)
    right = turns[0, 0] - (turns[0, 0] @ up) * up
    right /= np.linalg.norm(right)
    axes = np.column_stack([right, np.cross(up, right), up])
    middle = found.xyz.mean(axis=0)
    return tuple(_as_cameras(wand, np.stack([moved(row, axes, middle) for row in found.cameras])))


def _some(frames: np.ndarray, most: int) -> np.ndarray:
    """Return at most so many frames, evenly."""
    if len(frames) <= most:
        return frames
    return frames[np.linspace(0, len(frames) - 1, most).astype(int)]
