"""The jointed animal in space, and what the second view will see of it."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core import dlt
from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.fit.layout import PoseLayout, make_layout
from pawnb.core.pose.poses import joint_positions
from pawnb.core.pose.space.geometry import SightLines, check_second_view, px_per_unit, view_slope
from pawnb.core.pose.space.parameters import IN_SPACE
from pawnb.core.pose.space.settings import SpaceSettings
from pawnb.core.pose.track_result import PoseTrack
from pawnb.core.rig import Rig
from pawnb.core.sightlines import find_look_point
from pawnb.errors import InputError

_HEIGHTS_TRIED, _LOOKED_UP = 4001, 25
"""Numerics: heights that are tried, in so many frames, evenly spread."""


@dataclass(frozen=True, kw_only=True)
class SpaceModel:
    """One animal and two views of it.

    Parameters
    ----------
    animal : StickAnimal
        The animal.
    lines : SightLines
        The first view.
    coefs : ndarray, shape (11,)
        DLT coefficients of the second view, working pixels.
    factor : int
        View pixels of the second view along each side of a working pixel.
    layout : PoseLayout
        Thickness and darkness in the second view, working pixels.
    size : float
        Units of the calibration in one unit of the species file.
    lengths : ndarray, shape (legs, segments)
        Lengths of the segments, unit of the calibration.
    heights : tuple of float
        Range of heights at which the second view shows the body.
    thickness, lift : ndarray, shape (parts,)
        Of the body's parts: height as a share of width, and how far the middle lies above the
        body's height, as the body is pitched.
    ground : float
        Height of the ground; NaN where it is not known.
    settings : SpaceSettings
        Settings.
    """

    animal: StickAnimal
    lines: SightLines
    coefs: FloatArray
    factor: int
    layout: PoseLayout
    size: float
    lengths: FloatArray
    heights: tuple[float, float]
    thickness: FloatArray
    lift: FloatArray
    ground: float
    settings: SpaceSettings

    @property
    def span(self) -> float:
        """Leg span, unit of the calibration."""
        return self.size * self.animal.span

    def changed(self, **values: FloatArray | PoseLayout | float) -> SpaceModel:
        """Return the model with some of its values replaced."""
        return dataclasses.replace(self, **values)  # type: ignore[arg-type]

    def body_parts(self, xy: FloatArray, heading_deg: float, height: float) -> FloatArray:
        """Return the body in the second picture, for :func:`picture_loops.paint_parts`.

        Parameters
        ----------
        xy : ndarray, shape (2,)
            The body's place in the first view, px.
        heading_deg : float
            Its heading there.
        height : float
            Roughly its height.

        Returns
        -------
        ndarray, shape (parts, 10)
            One ellipse a part: the outline of an ellipsoid seen without perspective.
        """
        turn = np.radians(heading_deg)
        ahead = np.array([np.cos(turn), np.sin(turn)])
        start, direction = self.lines.lines(np.stack([xy, xy + ahead, xy + ahead[::-1] * [-1, 1]]))
        at = start + height * direction
        forward, right = (at[k] - at[0] for k in (1, 2))
        forward, right = (a / np.linalg.norm(a) for a in (forward, right))
        parts = np.zeros((len(self.animal.body), 10))
        for e, part in enumerate(self.animal.body):
            offset = self.size * (part.centre[0] * forward + part.centre[1] * right)
            offset = offset + self.lift[e] * self.lines.axis
            middle = at[0] + offset
            slope = view_slope(self.coefs, middle)
            half = 0.5 * self.size * np.array(
                [part.length, part.width, self.thickness[e] * part.width]
            )  # fmt: skip
            axes = slope @ (np.stack([forward, right, self.lines.axis]).T * half)
            outline = axes @ axes.T
            change = slope @ direction[0]
            inverse = np.linalg.inv(outline + 1e-6 * np.eye(2))
            parts[e, 0:2] = dlt.project(self.coefs, middle)[0] - height * change
            parts[e, 2:4] = change
            parts[e, 4:7] = inverse[0, 0], inverse[0, 1], inverse[1, 1]
            parts[e, 7:9] = np.sqrt(np.diag(outline))
            parts[e, 9] = self.layout.ellipse[e, 4]
        return parts


def make_model(
    animal: StickAnimal,
    track: PoseTrack,
    rig: Rig,
    *,
    views: tuple[str, str],
    sizes: tuple[tuple[int, int], tuple[int, int]],
    settings: SpaceSettings,
) -> SpaceModel:
    """Return what is known of an animal before its second view is looked at.

    Parameters
    ----------
    animal : StickAnimal
        The animal.
    track : PoseTrack
        Its poses in the first view.
    rig : Rig
        The calibrated views.
    views : tuple of str
        The view that was tracked, and the second.
    sizes : tuple
        Width and height of both, px.
    settings : SpaceSettings
        Settings.

    Returns
    -------
    SpaceModel
        The model; lengths are those of the species file in the scale of the track.

    Raises
    ------
    CalibrationError
        If a view is not calibrated, or both look in the same direction.
    InputError
        If the animal's sight lines miss the second view.
    """
    coefs = rig.subset(views).coefs
    about = find_look_point(coefs)
    up = np.array(rig.up)
    known = np.flatnonzero(np.isfinite(track.poses.xy).all(axis=1))
    xy = track.poses.xy[known]
    for _ in range(2):
        lines = SightLines(coefs[:, 0], about, up)
        heights = _heights_in_view(lines, coefs[:, 1], xy, views, sizes)
        middle = lines.at(np.median(xy, axis=0), 0.5 * (heights[0] + heights[1]))
        about = middle
    lines = SightLines(coefs[:, 0], about, up)
    heights = _heights_in_view(lines, coefs[:, 1], xy, views, sizes)
    check_second_view(lines, coefs[:, 1], views)
    scale = float(np.median(track.poses.scale[known]))
    size = scale / px_per_unit(coefs[:, 0], about)
    across = px_per_unit(coefs[:, 1], about)
    factor = max(1, int(size * animal.span * across / settings.working_span_px))
    shrink = np.array(
        [[1 / factor, 0, (1 / factor - 1) / 2], [0, 1 / factor, (1 / factor - 1) / 2], [0, 0, 1]]
    )
    layout = make_layout(animal, px_per_unit=size * across / factor)
    most = layout.length.shape[1]
    lengths = np.ones((len(animal.legs), most))
    for i, leg in enumerate(animal.legs):
        lengths[i, : len(leg.lengths)] = size * np.array(leg.lengths)
    return SpaceModel(
        animal=animal,
        lines=lines,
        coefs=dlt.transform_image(coefs[:, 1], shrink),
        factor=factor,
        layout=layout,
        size=size,
        lengths=lengths,
        heights=heights,
        thickness=np.full(len(animal.body), IN_SPACE.first_thickness),
        lift=np.zeros(len(animal.body)),
        ground=np.nan,
        settings=settings,
    )


def _heights_in_view(
    lines: SightLines,
    coefs: FloatArray,
    xy: FloatArray,
    views: tuple[str, str],
    sizes: tuple[tuple[int, int], tuple[int, int]],
) -> tuple[float, float]:
    """Return the range of heights at which the body is in the second picture in most frames."""
    far = IN_SPACE.far_pictures * max(sizes[0]) / px_per_unit(lines.coefs, lines.about)
    heights = np.linspace(-far, far, _HEIGHTS_TRIED)
    some = xy[:: max(1, len(xy) // _LOOKED_UP)]
    start, direction = lines.lines(some)
    uv = dlt.project(coefs, start[:, None] + heights[:, None] * direction[:, None])[..., 0, :]
    inside = ((uv > -0.5) & (uv < np.array(sizes[1]) - 0.5)).all(axis=-1)
    shown = np.flatnonzero(inside.mean(axis=0) > 0.5)
    if not len(shown):
        raise InputError(
            f"view {views[1]!r} does not show the places that view {views[0]!r} says the animal "
            "may be at; look at the calibration and its order of views."
        )
    return float(heights[shown[0]]), float(heights[shown[-1]])


def first_view_places(model: SpaceModel, track: PoseTrack) -> tuple[FloatArray, FloatArray]:
    """Return places of the joints in the first view and how sure they are.

    Parameters
    ----------
    model : SpaceModel
        The model.
    track : PoseTrack
        Poses in the first view.

    Returns
    -------
    places : ndarray, shape (n, legs, joints, 2)
        px of the first view.
    precision : ndarray, shape (n, legs, joints, 3)
        uu, uv and vv of the inverse of their covariance.
    """
    animal, settings = model.animal, model.settings
    places = joint_positions(animal, track.poses)
    span_px = model.span * px_per_unit(model.lines.coefs, model.lines.about)
    steps = np.diff(places, axis=2)
    steps = steps / np.maximum(np.linalg.norm(steps, axis=-1, keepdims=True), 1e-9)
    along = np.concatenate([steps[:, :, :1], steps[:, :, 1:] + steps[:, :, :-1], steps[:, :, -1:]], axis=2)  # fmt: skip # noqa: E501
    joint_sd = np.full(places.shape[1:3], settings.joint_along_share)
    for i, leg in enumerate(animal.legs):
        n = len(leg.segments)
        along[:, i, n] = steps[:, i, n - 1]
        joint_sd[i, 0], joint_sd[i, n] = settings.across_share, settings.tip_along_share
    along = along / np.maximum(np.linalg.norm(along, axis=-1, keepdims=True), 1e-9)
    # a leg that the first view hardly shows is less sure in every direction
    doubt = 1.0 / np.clip(track.confidence, 1 / 3, 1.0)[:, :, None]
    p = 1.0 / (doubt * joint_sd * span_px) ** 2
    q = 1.0 / (doubt * settings.across_share * span_px) ** 2
    u, v = along[..., 0], along[..., 1]
    precision = np.stack([p * u * u + q * v * v, (p - q) * u * v, p * v * v + q * u * u], axis=-1)
    return places, precision
