"""Size, shape and darkness of the body's parts, learnt from frames whose pose is nearly known."""

from __future__ import annotations

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.pose.fit.layout import N_BODY, meeting
from pawnb.core.pose.fit.learning.parameters import LEARNING


class BodyEquations:
    """The equations of one step of learning the body, summed over frames.

    The shape of the body and where it lies are seen in the same outline: a part that gets longer
    in front looks as one that moves forwards. Each frame's pose is therefore free to follow: the
    equations are those of shape and poses together, the poses eliminated.

    Parameters
    ----------
    ellipse : ndarray, shape (parts, 7)
        The body as known so far, see :class:`.layout.Layout`.
    known : ndarray, shape (parts, 7)
        The body as the species file has it.
    n_frames : int
        How many frames will be added.
    """

    def __init__(self, ellipse: FloatArray, known: FloatArray, n_frames: int) -> None:
        self.known, self.ellipse = known, ellipse
        self.meets = meeting(known)
        parts = len(ellipse)
        sds = np.tile(LEARNING.body_sd, (parts, 1))
        overlap_sd = 1.0
        if self.meets.any():
            sds[-1] = LEARNING.waist_sd
            overlap_sd = LEARNING.overlap_sd * float(known[self.meets != 0.0, 2].min())
        self.now = self._numbers(ellipse)
        stiff = n_frames / np.append(sds.ravel(), overlap_sd) ** 2
        self.stiff = stiff
        self.matrix, self.vector = np.diag(stiff), stiff * self.now
        self.follow: list[tuple[np.ndarray, np.ndarray]] = []

    def _numbers(self, ellipse: FloatArray) -> FloatArray:
        """Return what is learnt of every part, see ``LEARNING.body_sd``, then the overlap."""
        longer, wider = np.log(ellipse[:, 2:4] / self.known[:, 2:4]).T
        darker = ellipse[:, 4] - self.known[:, 4]
        inwards = self.meets * (self.known[:, 0] * np.exp(longer) - ellipse[:, 0])
        overlap = inwards[self.meets != 0.0].mean() if self.meets.any() else 0.0
        middle = ellipse[:, 6] - ellipse[:, 4]
        shape = np.column_stack([longer, wider, darker, ellipse[:, 5], middle])
        return np.append(shape.ravel(), overlap)

    def prior_cost(self, ellipse: FloatArray) -> float:
        """Return what a shape (like ``ellipse``) costs by itself."""
        return 0.5 * float(self.stiff @ self._numbers(ellipse) ** 2)

    def add(
        self, matrix: FloatArray, vector: FloatArray, *, of_pose: FloatArray, slope: FloatArray
    ) -> None:
        """Add a frame.

        Parameters
        ----------
        matrix, vector : ndarray, shape (parts, 9, 9) and (parts, 9)
            See :func:`.appearance_kernels.body_equations`.
        of_pose : ndarray, shape (n_parameters, n_parameters)
            The Gauss-Newton matrix of the pose, by picture and prior.
        slope : ndarray, shape (n_parameters,)
            The gradient of the cost of both.
        """
        n = len(self.now)
        across = np.zeros((n, len(of_pose)))
        for part in range(len(matrix)):
            at = [*range(5 * part, 5 * part + 5), n - 1]  # the overlap is common to all
            self.matrix[np.ix_(at, at)] += matrix[part, :6, :6]
            self.vector[at] += vector[part, :6]
            across[at, :N_BODY] += matrix[part, :6, 6:]
        both = np.column_stack([across.T, slope])
        solved = np.linalg.solve(of_pose + LEARNING.least_precision * np.eye(len(of_pose)), both)
        follow, own = solved[:, :-1], solved[:, -1]
        self.matrix -= across @ follow
        self.vector -= across @ own
        self.follow.append((follow, own))

    def solve(self) -> tuple[FloatArray, list[FloatArray]]:
        """Return the body after the step, and how each frame's pose moves with it."""
        step = -np.linalg.solve(self.matrix, self.vector)
        step = np.clip(step, -LEARNING.most_step, LEARNING.most_step)
        longer, wider, darker, egg, middle = (self.now + step)[:-1].reshape(-1, 5).T
        overlap = self.now[-1] + step[-1]
        known, ellipse = self.known, self.ellipse.copy()
        ellipse[:, 0] = known[:, 0] * np.exp(longer) - self.meets * overlap
        ellipse[:, 2] = known[:, 2] * np.exp(longer)
        ellipse[:, 3] = known[:, 3] * np.exp(wider)
        ellipse[:, 4] = np.clip(known[:, 4] + darker, LEARNING.least_dark, LEARNING.most_dark)
        ellipse[:, 5] = np.clip(egg, -LEARNING.most_egg, LEARNING.most_egg)
        ellipse[:, 6] = np.clip(ellipse[:, 4] + middle, LEARNING.least_dark, LEARNING.most_dark)
        if self.meets.any():  # what joins two parts is no wider than either
            ellipse[-1, 3] = min(ellipse[-1, 3], ellipse[self.meets != 0.0, 3].min())
        return ellipse, [-own - follow @ step for follow, own in self.follow]
