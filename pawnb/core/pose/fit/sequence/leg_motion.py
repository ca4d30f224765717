"""How the legs of this animal move from frame to frame, and what that says about each frame."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pawnb.arrays import AnyArray, FloatArray
from pawnb.core.pose.fit.sequence.messages import from_neighbours
from pawnb.core.pose.fit.sequence.parameters import SEQUENCE


def first_motion(n_links: int) -> FloatArray:
    """Return the covariance of second differences of a leg of which nothing is known.

    Parameters
    ----------
    n_links : int
        Links of the leg; its numbers are their angles in radians, then the logarithms of their
        foreshortening.

    Returns
    -------
    ndarray, shape (2 n_links, 2 n_links)
        Covariance.
    """
    return np.diag(np.repeat([np.radians(SEQUENCE.angle_sd_deg), SEQUENCE.length_sd], n_links) ** 2)


def learn_motion(legs: Sequence[FloatArray], known: FloatArray) -> FloatArray:
    """Return the covariance of second differences of legs that move alike.

    Parameters
    ----------
    legs : sequence of ndarray, shape (n, d)
        Of each leg, or each stretch of frames, its numbers in consecutive frames.
    known : ndarray, shape (d, d)
        The covariance so far.

    Returns
    -------
    ndarray, shape (d, d)
        Covariance, by iterated weights of Student's t.

    Notes
    -----
    That the numbers of a leg change together (it shortens as it swings forward, and all its
    links do) is in the covariance: what is seen of a leg says where its hidden end is.
    """
    d = len(known)
    legs = [leg for leg in legs if len(leg) > 2]
    if not legs:
        return known
    change = np.concatenate([np.diff(leg, 2, axis=0) for leg in legs])
    least = np.diag(np.repeat([np.radians(SEQUENCE.least_deg), SEQUENCE.least_length], d // 2) ** 2)
    for _ in range(SEQUENCE.leg_motion_rounds):
        far = np.einsum("ti,ij,tj->t", change, np.linalg.inv(known), change)
        weight = (SEQUENCE.leg_motion_tail + d) / (SEQUENCE.leg_motion_tail + far)
        moments = (change * weight[:, None]).T @ change + SEQUENCE.leg_motion_counts * least
        known = moments / (len(change) + SEQUENCE.leg_motion_counts) + least
    return known


def motion_messages(
    precision: AnyArray, vector: AnyArray, motion: AnyArray
) -> tuple[AnyArray, AnyArray]:
    """Return where all other frames have a leg in each frame, and how surely.

    Parameters
    ----------
    precision, vector : ndarray, shape (n, d, d) and (n, d)
        What each frame's picture says, see :func:`.messages.from_neighbours`.
    motion : ndarray, shape (d, d)
        Covariance of second differences.

    Returns
    -------
    around : ndarray, shape (n, d)
        The leg's numbers.
    pull : ndarray, shape (n, d, d)
        Their precision.
    """
    pull, row = from_neighbours(
        np.ascontiguousarray(precision), np.ascontiguousarray(vector), np.linalg.inv(motion)
    )
    least = 1e-9 * np.eye(vector.shape[1])
    return np.linalg.solve(pull + least, row[..., None])[..., 0], pull
