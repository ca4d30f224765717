"""The calibrated views of a trial, by name.

A :class:`Rig` holds DLT coefficients in the pixels of the resulting views (after crop
and mirror; u right, v down, (0, 0) the centre of the top-left pixel) together with the
directions of the calibrated space. It is read with :func:`load_rig` or fitted with
:func:`pawnb.core.calibration.rig_from_points.fit_rig`, and never exists half made.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pawnb.arrays import FloatArray, Points2D, Points3D
from pawnb.core import dlt
from pawnb.core.lens import cameras_of_views
from pawnb.core.sightlines import (
    find_epipolar_line,
    find_look_point,
    find_nearest_on_sight_line,
)
from pawnb.errors import CalibrationError, InputWarning, did_you_mean
from pawnb.input_warnings import warn_of_input
from pawnb.io.cameras import coefs_of_cameras
from pawnb.io.coefs import read_coefs
from pawnb.trial import Calibration, Trial, View

_AMBIGUOUS = 0.05
"""Forward within about 3 degrees of where u does not change: neither right nor left."""


@dataclass(frozen=True)
class Rig:
    """Calibrated views.

    Parameters
    ----------
    names : tuple of str
        Names of the views, in the order of the columns of ``coefs``.
    coefs : ndarray, shape (11, n_views)
        DLT coefficients in the pixels of the resulting views.
    unit : str
        Unit of length of the calibrated space.
    forward, up : tuple of float
        Unit vectors of travel and of up in calibrated space.

    Raises
    ------
    CalibrationError
        If shape, names or numbers do not make a calibration, or two views have one name.
    """

    names: tuple[str, ...]
    coefs: FloatArray
    unit: str = "mm"
    forward: tuple[float, ...] = (1.0, 0.0, 0.0)
    up: tuple[float, ...] = (0.0, 0.0, 1.0)

    def __post_init__(self) -> None:
        coefs = np.array(self.coefs, dtype=float)
        if coefs.shape != (11, len(self.names)):
            raise CalibrationError(
                f"DLT coefficients have shape {coefs.shape}; expected 11 rows and one column for "
                f"each of the {len(self.names)} views ({', '.join(self.names)})."
            )
        if len(set(self.names)) < len(self.names):
            raise CalibrationError(
                f"two views have one name ({', '.join(self.names)}); give each its own."
            )
        for name, column in zip(self.names, coefs.T, strict=True):
            dlt.check_coefs(column, where=f"view {name!r}")
        coefs.flags.writeable = False
        object.__setattr__(self, "names", tuple(self.names))
        object.__setattr__(self, "coefs", coefs)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Rig):
            return NotImplemented
        return (
            (self.names, self.unit, self.forward, self.up)
            == (other.names, other.unit, other.forward, other.up)
        ) and np.array_equal(self.coefs, other.coefs)

    __hash__ = None  # type: ignore[assignment]

    def project(self, xyz: Points3D) -> FloatArray:
        """Return where points (..., 3) appear in every view: (..., n_views, 2) in px."""
        return dlt.project(self.coefs, xyz)

    def triangulate(
        self, uv: Points2D, *, refine: bool = False, even: bool = False
    ) -> dlt.Triangulation:
        """Find points in space from image positions.

        Parameters
        ----------
        uv : ndarray, shape (..., n_views, 2)
            Image positions in px in the order of ``names``, NaN where not seen.
        refine : bool
            Whether to minimise the reprojection error after the linear solution.
        even : bool
            Whether all views weigh alike, wherever the origin of the calibration lies.

        Returns
        -------
        pawnb.core.dlt.Triangulation
            ``xyz`` (..., 3) in ``unit``, ``residual_px``, ``dltres``, ``n_views``.
        """
        return dlt.triangulate(self.coefs, uv, refine=refine, even=even)

    def reprojection_error(self, xyz: Points3D, uv: Points2D) -> FloatArray:
        """Return the distance in px (..., n_views) of points (..., 3) from where seen."""
        return dlt.reprojection_error(self.coefs, xyz, uv)

    def index(self, name: str) -> int:
        """Return the place of a view; raises CalibrationError if it is not in the rig."""
        if name not in self.names:
            raise CalibrationError(
                f"view {name!r} is not calibrated{did_you_mean(name, self.names)}; calibrated "
                f"are {', '.join(self.names)}."
            )
        return self.names.index(name)

    def subset(self, names: Iterable[str]) -> Rig:
        """Return the rig of some of its views, in the order given."""
        names = tuple(names)
        places = [self.index(name) for name in names]
        return dataclasses.replace(self, names=names, coefs=self.coefs[:, places])

    def facing(self, name: str, *, at: Sequence[float] | FloatArray | None = None) -> int:
        """Say which way an animal that moves along ``forward`` faces in one view.

        The sign of the change of u for a small step along ``forward``. In a perspective
        view it depends on where the animal is; without ``at`` it is taken where the
        lines of sight of all views come closest (each line that of the view's optical
        axis), which is the place the cameras were pointed at.

        Parameters
        ----------
        name : str
            The view.
        at : array-like, shape (3,), optional
            A point near the animal, in the unit of the rig.

        Returns
        -------
        int
            +1 if the animal faces right in that picture, -1 if left.

        Raises
        ------
        CalibrationError
            If the view looks along ``forward``, or forward is upright in the picture,
            so that it is neither; give ``facing`` of that view in ``trial.toml`` then.
        """
        L = self.coefs[:, self.index(name)]
        point = find_look_point(self.coefs) if at is None else np.asarray(at, dtype=float)
        weight = L[8:11] @ point + 1.0
        u = (L[0:3] @ point + L[3]) / weight
        gradient = (L[0:3] - u * L[8:11]) / weight
        steepest = float(np.linalg.norm(gradient)) or np.nan
        cosine = gradient @ np.asarray(self.forward) / steepest
        if not abs(cosine) >= _AMBIGUOUS:
            raise CalibrationError(
                f"view {name!r}: a step along forward {list(self.forward)} goes neither right nor "
                "left in the picture; give facing = 1 (right) or -1 (left) for this view."
            )
        return 1 if cosine > 0 else -1

    def epipolar_line(
        self, view_from: str, uv: Sequence[float] | Points2D, view_to: str, *,
        size: tuple[int, int],
    ) -> FloatArray:  # fmt: skip
        """Return where a point seen in one view can be in another.

        Parameters
        ----------
        view_from : str
            The view in which the point was seen.
        uv : array-like, shape (2,)
            Its position there, px.
        view_to : str
            The view for which the line is wanted.
        size : tuple of int
            Width and height in px of the picture of ``view_to``.

        Returns
        -------
        ndarray, shape (2, 2)
            The two ends (u, v) of the straight line within the picture; NaN where it
            misses the picture or there is none (both views are the same).
        """
        L_from, L_to = self.coefs[:, self.index(view_from)], self.coefs[:, self.index(view_to)]
        return find_epipolar_line(L_from, np.asarray(uv, dtype=float), L_to, size=size)

    def nearest_in_sight(self, name: str, uv: Points2D, *, xyz: FloatArray) -> FloatArray:
        """Return the point that a view sees at some place and that is nearest to another point.

        Parameters
        ----------
        name : str
            The view.
        uv : ndarray, shape (2,)
            Where it sees the point, px.
        xyz : ndarray, shape (3,)
            The other point, in the unit of the calibration.

        Returns
        -------
        ndarray, shape (3,)
            The nearest point that is seen there.
        """
        return find_nearest_on_sight_line(self.coefs[:, self.index(name)], uv, xyz)


def load_rig(
    trial: Trial, *, sizes: Mapping[str, tuple[int, int]] | None = None, first_pixel: int = 0
) -> Rig | None:
    """Read the calibration of a trial.

    Parameters
    ----------
    trial : Trial
        Its ``[calibration] dlt`` names a csv of 11 rows, one column a view in the order of
        the views, without header; or ``anipose`` or ``opencv`` another program's cameras, called
        as the views are.
    sizes : mapping, optional
        Width and height in px of the file's whole picture of each view. Needed only where
        coefficients must be converted: for ``v = "up"``, and for ``pixels = "file"`` with a
        mirrored view that is not cropped.
    first_pixel : int
        Number of the first pixel in the pixels that the coefficients belong to: 1 where they
        come with points of DLTdv, which counts from 1 as MATLAB does. Those with ``v = "up"``
        are always counted from 1.

    Returns
    -------
    Rig or None
        The rig in the pixels of the resulting views; None where the trial has no DLT (no
        ``[calibration]``, or one view with ``px_per_unit``).

    Raises
    ------
    CalibrationError
        If the file is missing, is not 11 rows of numbers, has another number of columns
        than the trial has views, or a size is needed and not given.

    Notes
    -----
    ``pixels = "file"``: coefficients of the whole, unmirrored picture are moved by the
    crop offset and mirrored, exactly. ``v = "up"``: coefficients of DLTdv 7 and older,
    whose pictures have (1, 1) at the centre of the bottom-left pixel (pixels counted from
    1 as in MATLAB, v upwards): u = u_DLTdv - 1 and v = height - v_DLTdv.
    """
    calibration = trial.calibration
    if calibration is None or calibration.of_views is None:
        return None
    names = tuple(view.name for view in trial.views)
    if calibration.dlt is not None:
        coefs = read_coefs(trial.path(calibration.dlt), names)
    else:
        # cameras of other programs belong to the whole picture, straightened, pixels from 0
        coefs, first_pixel = _coefs_of_cameras(trial, names), 0
        calibration = dataclasses.replace(calibration, pixels="file", v="down")
    columns = [
        dlt.transform_image(
            coefs[:, i], _to_view(view, calibration, (sizes or {}).get(view.name), first_pixel)
        )
        for i, view in enumerate(trial.views)
    ]
    return Rig(
        names,
        np.stack(columns, axis=1),
        unit=calibration.unit,
        forward=calibration.forward,
        up=calibration.up,
    )


def _coefs_of_cameras(trial: Trial, names: Sequence[str]) -> np.ndarray:
    """Return coefficients of the views from another program's cameras of the same names."""
    cameras = cameras_of_views(trial, names)
    coefs, origin = coefs_of_cameras(list(cameras.values()))
    if origin.any():
        x, y, z = origin
        warn_of_input(
            f"trial {trial.name!r}: a camera stands at the origin of its calibration, which has no "
            f"DLT coefficients: positions are counted from ({x:g}, {y:g}, {z:g}) there.",
            InputWarning,
            stacklevel=4,
        )
    return coefs


def require_rig(
    trial: Trial, *, sizes: Mapping[str, tuple[int, int]] | None = None, first_pixel: int = 0
) -> Rig:
    """Read the calibration of a trial for a step that cannot do without.

    Parameters
    ----------
    trial : Trial
        The trial.
    sizes, first_pixel : optional
        As for :func:`load_rig`.

    Returns
    -------
    Rig
        The calibrated views.

    Raises
    ------
    CalibrationError
        If the trial has no DLT calibration, or it cannot be read.
    """
    rig = load_rig(trial, sizes=sizes, first_pixel=first_pixel)
    if rig is None:
        raise CalibrationError(
            f"trial {trial.name!r} has no DLT calibration; add [calibration] dlt = "
            '"DLTcoefs.csv" to trial.toml; pawnb calibrate makes it from a board, a wand or points.'
        )
    return rig


def _to_view(
    view: View, calibration: Calibration, size: tuple[int, int] | None, first_pixel: int
) -> FloatArray:
    """Return the homography from the pixels of the coefficients to those of the view."""
    if calibration.pixels == "view" and view.crop is not None:
        size = (view.crop[2] - view.crop[0], view.crop[3] - view.crop[1])
    H = np.array([[1.0, 0.0, -first_pixel], [0.0, 1.0, -first_pixel], [0.0, 0.0, 1.0]])
    if calibration.v == "up":
        if size is None:
            raise _size_needed(view, 'v = "up"')
        H = np.array([[1.0, 0.0, -1.0], [0.0, -1.0, size[1]], [0.0, 0.0, 1.0]])
    if calibration.pixels == "view":
        return H
    if view.crop is not None:
        u0, v0, u1, _ = view.crop
        H = np.array([[1.0, 0.0, -u0], [0.0, 1.0, -v0], [0.0, 0.0, 1.0]]) @ H
        width = u1 - u0
    elif size is not None:
        width = size[0]
    elif view.mirror:
        raise _size_needed(view, 'pixels = "file" and mirror = true')
    if view.mirror:
        H = np.array([[-1.0, 0.0, width - 1.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]) @ H
    return H


def _size_needed(view: View, why: str) -> CalibrationError:
    """Make the error for a picture size that is needed and unknown."""
    return CalibrationError(
        f"view {view.name!r}: the size of its picture is needed to convert DLT coefficients with "
        f"{why}; name its video under [[views]], or give crop = [0, 0, width, height] there."
    )


def unit_vector(vector: Sequence[float]) -> tuple[float, ...]:
    """Return a direction at length one."""
    direction = np.asarray(vector, dtype=float)
    length = np.linalg.norm(direction)
    if direction.shape != (3,) or not np.isfinite(length) or length == 0:
        raise CalibrationError(
            f"direction {list(vector)}; expected three numbers, not all of them 0."
        )
    return tuple(float(x) for x in direction / length)
