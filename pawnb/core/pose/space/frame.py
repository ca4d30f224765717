"""One frame of two views: what is known of it, and how legs may stand before it is fitted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.pose.space.arch import arch, slide
from pawnb.core.pose.space.model import SpaceModel
from pawnb.core.pose.space.parameters import IN_SPACE
from pawnb.core.pose.space.picture_kernels import Known


@dataclass(frozen=True, eq=False)
class SpaceFrame:
    """What both views show of one frame.

    Parameters
    ----------
    xy, heading_deg : ndarray, float
        The body in the first view, px and degrees.
    places, precision : ndarray
        Joints in the first view and how sure they are; see ``first_view_places``.
    image : ndarray, shape (H, W)
        The second view's crop, grey working pixels.
    box : tuple of int
        Where it lies.
    """

    xy: FloatArray
    heading_deg: float
    places: FloatArray
    precision: FloatArray
    image: FloatArray
    box: tuple[int, int, int, int]


def known_without_picture(
    model: SpaceModel, one: SpaceFrame, *, expected: FloatArray | None, expected_sd: float
) -> Known:
    """Return what is known of a frame without its second picture.

    Parameters
    ----------
    model : SpaceModel
        The animal, and the lines of sight of the first view.
    one : SpaceFrame
        The frame.
    expected : ndarray or None
        Unknowns that are expected.
    expected_sd : float
        Their standard deviation.

    Returns
    -------
    Known
        What is known.
    """
    settings = model.settings
    legs, joints = one.places.shape[:2]
    nothing = np.full(1 + legs * joints, np.nan)
    return Known(
        axis=model.lines.axis,
        about=model.lines.about,
        top=model.lines.coefs,
        seen=np.nan_to_num(one.places),
        weight=np.nan_to_num(one.precision),
        length=model.lengths,
        length_sd=settings.length_sd * model.lengths + IN_SPACE.length_least * model.span,
        bend_sd=settings.bend_sd,
        root_sd=settings.root_share * model.span,
        expected=nothing if expected is None else expected,
        expected_sd=expected_sd,
        ground=model.ground,
        ground_sd=settings.ground_share * model.span,
        lifted=IN_SPACE.lifted,
    )


def even_arches(model: SpaceModel, one: SpaceFrame, body: float) -> tuple[FloatArray, FloatArray]:
    """Return the joints of legs in even arches from body to ground.

    Parameters
    ----------
    model : SpaceModel
        The animal, and the lines of sight of the first view.
    one : SpaceFrame
        The frame.
    body : float
        The body's height.

    Returns
    -------
    places : ndarray, shape (legs, joints, 2)
        Where the first view would see them, on the legs' lines there.
    heights : ndarray, shape (legs, joints)
        Their heights.
    """
    places, heights = one.places.copy(), np.full(one.places.shape[:2], np.nan)
    ground = model.ground if np.isfinite(model.ground) else body
    for i in range(len(places)):
        n = int(model.layout.n_segments[i])
        at = model.lines.at(one.places[i, : n + 1], body)
        reach = float(np.linalg.norm(np.diff(at, axis=0), axis=1).sum())
        out, up = arch(model.lengths[i, :n], reach, ground - body)
        places[i, : n + 1] = slide(one.places[i, : n + 1], out)
        heights[i, : n + 1] = body + up
    return places, heights
