"""How this animal holds its legs, learnt from frames in which they are well seen.

Of a leg that is mostly hidden, all that is seen may be the end that sticks out: the rest is where
the legs of this animal usually are.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.pose.fit.candidates.candidate_sets import LegCandidates
from pawnb.core.pose.fit.fitter import FrameFitter
from pawnb.core.pose.fit.learning.attached_clutter import find_attached_clutter
from pawnb.core.pose.fit.learning.parameters import LEARNING
from pawnb.core.pose.fit.parallel import on_threads
from pawnb.core.pose.fit.sequence.first_frame import partners
from pawnb.core.pose.fit.support import leg_supports
from pawnb.signals.robust import MAD_TO_SD


def learn_from_all(fitter: FrameFitter, found: Sequence[LegCandidates], poses: FloatArray) -> bool:
    """Learn what hides legs, and how they are held; return whether it is worth a second look.

    Parameters
    ----------
    fitter : FrameFitter
        Learns, where something that is no leg is fixed to the body.
    found : sequence of LegCandidates
        All frames.
    poses : ndarray, shape (n, n_parameters)
        Their poses.

    Returns
    -------
    bool
        True where something fixed to the body was found.
    """
    fitter.attached_clutter = find_attached_clutter(fitter, found, poses)
    if fitter.attached_clutter is None:
        return False
    learn_pose_prior(fitter, found, poses)
    return True


def learn_pose_prior(
    fitter: FrameFitter, found: Sequence[LegCandidates], poses: FloatArray
) -> None:
    """Make anatomy that of this animal's own legs, and keep poses that they usually have.

    Parameters
    ----------
    fitter : FrameFitter
        Its ``anatomy`` and ``usual_poses`` are replaced, those of legs that are seldom well seen
        left as they are.
    found : sequence of LegCandidates
        The frames.
    poses : ndarray, shape (n, n_parameters)
        Their poses.
    """

    def support(own: FrameFitter, t: int) -> FloatArray:
        image_evidence = own.image_evidence(found[t].image.astype(float), found[t].box, poses[t])
        return leg_supports(own, poses[t], image_evidence)

    supports = np.array(on_threads(fitter, range(len(found)), support))
    seen: np.ndarray = np.all(supports >= LEARNING.pose_prior_seen, axis=2)
    partner = partners(fitter.animal)
    middle, precision = fitter.anatomy.middle.copy(), fitter.anatomy.precision.copy()
    for leg, numbers in enumerate(fitter.numbers):
        alike = {leg, int(partner[leg])}
        own = np.concatenate([poses[np.ix_(seen[:, i], fitter.numbers[i])] for i in alike])
        if len(own) < LEARNING.pose_prior_few:
            continue
        centre, sd = _spread(own)
        middle[numbers], precision[numbers] = centre, 1.0 / sd**2
        fitter.usual_poses[leg] = _far_apart((own - centre) / sd) * sd + centre
    fitter.anatomy = fitter.anatomy._replace(middle=middle, precision=precision)


def _spread(own: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return middles and standard deviations of a leg's numbers, robustly."""
    centre = np.median(own, axis=0)
    sd = LEARNING.pose_prior_wider * MAD_TO_SD * np.median(np.abs(own - centre), axis=0)
    least = np.repeat([np.radians(LEARNING.least_sd_deg), LEARNING.least_sd], own.shape[1] // 2)
    return centre, np.maximum(sd, least)


def _far_apart(away: FloatArray) -> FloatArray:
    """Return the most usual of standardised poses, and others as far from those before as may be.

    Poses with an odd number are left out.
    """
    away = away[np.abs(away).max(axis=1) < LEARNING.pose_prior_odd]
    if not len(away):
        return away
    chosen = [int(np.argmin((away**2).sum(axis=1)))]
    nearest = np.full(len(away), np.inf)
    while len(chosen) < min(LEARNING.pose_prior_poses, len(away)):
        nearest = np.minimum(nearest, ((away - away[chosen[-1]]) ** 2).sum(axis=1))
        chosen.append(int(np.argmax(nearest)))
    return away[chosen]
