"""Thickness, darkness and lengths once more, from sure frames of the whole recording."""

from __future__ import annotations

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.pose.fit.candidates.candidate_sets import LegCandidates
from pawnb.core.pose.fit.fitter import FrameFitter
from pawnb.core.pose.fit.learning.appearance import learn_appearance
from pawnb.core.pose.fit.learning.body_clutter import find_body_clutter
from pawnb.core.pose.fit.learning.leg_clutter import find_leg_clutter
from pawnb.core.pose.fit.learning.parameters import LEARNING
from pawnb.core.pose.fit.parallel import on_threads
from pawnb.core.pose.fit.rendering.excluded_parts import counted
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import ImageEvidence, Prior
from pawnb.core.pose.fit.sequence.first_frame import partners


def learn_again(fitter: FrameFitter, found: list[LegCandidates], poses: FloatArray) -> FloatArray:
    """Learn the animal's look from sure frames; return all poses, those of these frames refitted.

    Parameters
    ----------
    fitter : FrameFitter
        Its layout is replaced.
    found : list of LegCandidates
        Every frame.
    poses : ndarray, shape (n, n_parameters)
        Their poses.

    Returns
    -------
    ndarray, shape (n, n_parameters)
        Poses.
    """
    if not found:
        return poses
    poses = poses.copy()
    sure = [i for i, choices in enumerate(found) if not choices.is_open]
    if len(sure) < LEARNING.relearn_frames:
        sure = list(range(len(found)))
    chosen = sorted(
        {sure[k] for k in np.linspace(0, len(sure) - 1, LEARNING.relearn_frames).astype(int)}
    )
    for _ in range(LEARNING.relearn_rounds):
        known = usual_lengths(fitter, poses)

        def fitted(
            own: FrameFitter, i: int, known: Prior = known
        ) -> tuple[FloatArray, ImageEvidence]:
            image_evidence = own.image_evidence(
                found[i].image.astype(float), found[i].box, poses[i]
            )
            return own.fit(poses[i], counted(own, poses[i], image_evidence), known, rounds=6)[
                0
            ], image_evidence

        frames = on_threads(fitter, chosen, fitted)
        poses[chosen] = [pose for pose, _ in frames]
        fitter.body_clutter = find_body_clutter(fitter, frames)
        fitter.leg_clutter = find_leg_clutter(fitter, frames)
        frames = [(pose, counted(fitter, pose, image_evidence)) for pose, image_evidence in frames]
        fitter.layout = learn_appearance(
            fitter.layout, frames, first=fitter.first, partner=partners(fitter.animal),
            prior=known, blur=fitter.blur, soft=fitter.settings.soft_error,
        )  # fmt: skip
    return poses


def usual_lengths(fitter: FrameFitter, poses: FloatArray) -> Prior:
    """Return anatomy with each link's usual foreshortening in these poses."""
    middle = fitter.anatomy.middle.copy()
    middle[fitter.lengths] = np.median(poses[:, fitter.lengths], axis=0)
    return fitter.anatomy._replace(middle=middle)
