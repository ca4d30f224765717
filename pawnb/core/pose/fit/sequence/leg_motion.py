"""How the legs of this animal move from frame to frame, and what that says about each frame."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pawnb.core.pose.fit.sequence.messages import from_neighbours

_ANGLE_SD_DEG, _LENGTH_SD = 8.0, 0.12
"""Standard deviation of second differences before anything is known of this animal: wide."""
_LEAST_DEG, _LEAST_LENGTH = 0.5, 0.005
"""What is added to the spread of second differences: no joint of a living leg moves more evenly."""
_COUNTS = 20.0
"""So many frames is that least spread worth."""
_TAIL = 4.0
"""Degrees of freedom of Student's t: a leg that leaps in a few frames, because it is wrong there,
does not say how legs move."""
_ROUNDS = 3


def first_motion(n_links: int) -> np.ndarray:
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
    return np.diag(np.repeat([np.radians(_ANGLE_SD_DEG), _LENGTH_SD], n_links) ** 2)


def learn_motion(legs: Sequence[np.ndarray], known: np.ndarray) -> np.ndarray:
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
    least = np.diag(np.repeat([np.radians(_LEAST_DEG), _LEAST_LENGTH], d // 2) ** 2)
    for _ in range(_ROUNDS):
        far = np.einsum("ti,ij,tj->t", change, np.linalg.inv(known), change)
        weight = (_TAIL + d) / (_TAIL + far)
        moments = (change * weight[:, None]).T @ change + _COUNTS * least
        known = moments / (len(change) + _COUNTS) + least
    return known


def motion_messages(
    precision: np.ndarray, vector: np.ndarray, motion: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
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
