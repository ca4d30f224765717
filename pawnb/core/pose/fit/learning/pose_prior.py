"""How this animal holds its legs, learnt from frames in which they are well seen.

Of a leg that is mostly hidden, all that is seen may be the end that sticks out: the rest is where
the legs of this animal usually are.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.parallel import on_threads
from pawnb.core.pose.fit.candidates.candidate_sets import LegCandidates
from pawnb.core.pose.fit.fitter import FrameFitter
from pawnb.core.pose.fit.learning.parameters import LEARNING
from pawnb.core.pose.fit.observation import evidence_of
from pawnb.core.pose.fit.support import leg_supports
from pawnb.signals.robust import MAD_TO_SD


def learn_pose_prior(
    fitter: FrameFitter, found: Sequence[LegCandidates], poses: FloatArray
) -> FrameFitter:
    """Return a fitter whose anatomy is that of this animal's own legs, with usual poses of them.

    Parameters
    ----------
    fitter : FrameFitter
        What poses are fitted with so far.
    found : sequence of LegCandidates
        The frames.
    poses : ndarray, shape (n, n_parameters)
        Their poses.

    Returns
    -------
    FrameFitter
        What it knows of legs that are seldom well seen is what was known before.
    """

    def support(t: int) -> FloatArray:
        image_evidence = evidence_of(fitter, poses[t], image=found[t].grey, box=found[t].box)
        return leg_supports(fitter, poses[t], image_evidence)

    supports = np.array(on_threads(support, range(len(found))))
    seen: np.ndarray = np.all(supports >= LEARNING.pose_prior_seen, axis=2)
    partner, usual = fitter.index.partner, list(fitter.usual_poses)
    middle, precision = fitter.anatomy.middle.copy(), fitter.anatomy.precision.copy()
    for leg, numbers in enumerate(fitter.index.numbers):
        alike = {leg, int(partner[leg])}
        own = np.concatenate([poses[np.ix_(seen[:, i], fitter.index.numbers[i])] for i in alike])
        if len(own) < LEARNING.pose_prior_few:
            continue
        centre, sd = _spread(own)
        middle[numbers], precision[numbers] = centre, 1.0 / sd**2
        usual[leg] = _far_apart((own - centre) / sd) * sd + centre
    anatomy = fitter.anatomy._replace(middle=middle, precision=precision)
    return fitter.with_prior(anatomy, usual_poses=tuple(usual))


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
