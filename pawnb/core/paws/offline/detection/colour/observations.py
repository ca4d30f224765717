"""What every view shows in every frame: detections as positions of each point."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.paws.offline.detection.colour.detections import InFrames, pad_and_stack
from pawnb.core.paws.offline.detection.colour.label_offsets import Offsets
from pawnb.core.paws.offline.detection.colour.likelihood import AppearanceLikelihood
from pawnb.core.paws.offline.detection.colour_parameters import COLOUR
from pawnb.core.paws.offline.projection import Projection


@dataclass(frozen=True)
class Observations:
    """Detections of n frames, V views and P points, at most C in a picture.

    Parameters
    ----------
    raw : ndarray, shape (n, V, C, 2)
        The detections, px.
    at : ndarray, shape (n, P, V, C, 2)
        Where each says that each point is, px.
    detection_probability : ndarray, shape (n, V, C)
        How much each looks like the end of a paw, 0 to 1.
    is_there : ndarray of bool, shape (n, V, C)
        False where a picture has fewer detections.
    """

    raw: FloatArray
    at: FloatArray
    detection_probability: FloatArray
    is_there: np.ndarray

    def only(self, frame: int) -> Observations:
        """Return one frame of them, n = 1."""
        one = slice(frame, frame + 1)
        return Observations(
            self.raw[one], self.at[one], self.detection_probability[one], self.is_there[one]
        )


def read_observations(
    found: InFrames,
    offsets: Offsets | Sequence[Offsets],
    *,
    facing: Sequence[int],
    likelihood: AppearanceLikelihood,
) -> Observations:
    """Return what detections say.

    Parameters
    ----------
    found : sequence
        Detections of every frame and view.
    offsets : Offsets or sequence of Offsets
        Where the tracked points lie relative to them, in all views or in each.
    facing : sequence of int
        +1 or -1 for each view.
    likelihood : AppearanceLikelihood
        Tells how much detections look like paws.

    Returns
    -------
    Observations
        Positions and qualities.
    """
    every, is_there = pad_and_stack(found)
    n, n_views, most = is_there.shape
    by_view = [offsets] * n_views if isinstance(offsets, Offsets) else offsets
    n_points = len(by_view[0].along)
    detection_probability = np.empty((n, n_views, most))
    at = np.empty((n, n_points, n_views, most, 2))
    for v in range(n_views):
        here = every.of_view(v)
        detection_probability[:, v] = likelihood.likeness(here, v).reshape(n, -1)
        for p in range(n_points):
            moved = by_view[v].apply(
                here, p, paw_width_px=likelihood.paw_width_px[v], facing=facing[v] or 1
            )
            at[:, p, v] = moved.reshape(n, -1, 2)
    return Observations(every.uv.astype(float), at, detection_probability, is_there)


def tracked_points(
    places: FloatArray,
    observations: Observations,
    *,
    geometry: Projection,
    paw_width_px: FloatArray,
    view: int | None = None,
) -> FloatArray:
    """Return where the tracked points are of places made of detections.

    Parameters
    ----------
    places : ndarray, shape (n, P, d)
        Places where detections meet, NaN where there is none.
    observations : Observations
        What the detections say.
    geometry : Projection
        The views.
    paw_width_px : ndarray, shape (V,)
        Width of a paw in each view; detections within it of a place belong to it.
    view : int, optional
        The only view whose detections the places are made of; default all.

    Returns
    -------
    ndarray, shape (n, P, d)
        The places, each moved by what its detections say on average.
    """
    which = np.ones(len(paw_width_px), bool)
    if view is not None:
        which = np.arange(len(paw_width_px)) == view
    known = np.isfinite(places[..., 0])
    x = np.nan_to_num(places)
    away = np.linalg.norm(observations.raw[:, None] - geometry.project(x)[..., None, :], axis=-1)
    away = np.where(observations.is_there[:, None], away / paw_width_px[:, None], np.inf)
    nearest = away.argmin(axis=-1)[..., None]
    near = (np.take_along_axis(away, nearest, axis=-1)[..., 0] < 1.0) & which
    step = observations.at - observations.raw[:, None]
    step = np.take_along_axis(step, nearest[..., None], axis=3)[:, :, :, 0]
    J = geometry.jacobian(x) * np.where(near, 1.0, 0.0)[..., None, None]
    normal = np.einsum("npvik,npvil->npkl", J, J, optimize=True)
    # what one view alone does not tell stays as it is
    size = np.trace(normal, axis1=-2, axis2=-1)[..., None, None]
    normal = normal + (COLOUR.stays * size + 1e-9) * np.eye(x.shape[-1])
    target = np.einsum("npvik,npvi->npk", J, step, optimize=True)
    moved = x + np.linalg.solve(normal, target[..., None])[..., 0]
    return np.where(known[..., None], moved, np.nan)
