"""Where in the body's frame each point usually is."""

from __future__ import annotations

from collections.abc import Mapping

import cv2
import numpy as np

from pawnb.arrays import Float32Array
from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.association.parameters import LINKS
from pawnb.core.paws.offline.detection.evidence import bump_at
from pawnb.core.paws.offline.parameters import OfflineParameters
from pawnb.core.paws.offline.scene.stack import BodyStack


def prior_from_clicks(
    stack: BodyStack, annotations: Annotations, *, radius: float, parameters: OfflineParameters
) -> dict[int, Float32Array]:
    """Return the probability of every place for each point, wide about its clicks.

    Parameters
    ----------
    stack : BodyStack
        The view.
    annotations : Annotations
        Its clicks.
    radius : float
        About half a paw, in places.
    parameters : OfflineParameters
        Parameters of the scene and of the association.

    Returns
    -------
    dict
        Point to probabilities (h, w) that sum to 1.
    """
    _, h, w = stack.shape
    anywhere = parameters.association.anywhere
    priors = {}
    for point in annotations.points:
        rows = annotations.rows_of(point)
        narrower = LINKS.prior_narrower[0 if len(rows) == 1 else 1 if len(rows) < 4 else 2]
        sd = narrower * max(
            LINKS.prior_sd * parameters.scene.extent / stack.spacing,
            LINKS.prior_least_radii * radius,
        )
        places = [stack.grid_of(annotations.places[row][point], row) for row in rows]
        mass = np.sum([bump_at((h, w), place, sd) for place in places], axis=0)
        mass = (1 - anywhere) * mass / mass.sum() + anywhere / (h * w)
        priors[point] = (mass / mass.sum()).astype(np.float32)
    return priors


def prior_from_tracks(
    masses: Mapping[int, Float32Array], priors: Mapping[int, Float32Array], radius: float
) -> dict[int, Float32Array]:
    """Return priors that have learnt where points were found, half old and half new.

    Parameters
    ----------
    masses : mapping
        Point to where it was found, the mean over frames, shape (h, w).
    priors : mapping
        Point to its prior, shape (h, w).
    radius : float
        Half a paw, places of the grid.

    Returns
    -------
    dict
        Point to its new prior.
    """
    learnt = {}
    for point, found in masses.items():
        mass = cv2.GaussianBlur(found, (0, 0), LINKS.prior_blur_radii * radius)
        even = LINKS.prior_even
        mass = (1.0 - even) * mass / mass.sum() + even / mass.size
        learnt[point] = (0.5 * priors[point] + 0.5 * mass).astype(np.float32)
    return learnt
