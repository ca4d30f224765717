"""Thickness, darkness and lengths once more, from sure frames of the whole recording."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.parallel import on_threads
from pawnb.core.pose.fit.candidates.candidate_sets import LegCandidates
from pawnb.core.pose.fit.fitter import FrameFitter
from pawnb.core.pose.fit.learning.appearance import fit_appearance
from pawnb.core.pose.fit.learning.body_clutter import find_body_clutter
from pawnb.core.pose.fit.learning.leg_clutter import find_leg_clutter
from pawnb.core.pose.fit.learning.parameters import LEARNING
from pawnb.core.pose.fit.observation import evidence_of
from pawnb.core.pose.fit.rendering.excluded_parts import counted
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import ImageEvidence, Prior


def learn_again(
    fitter: FrameFitter, found: Sequence[LegCandidates], poses: FloatArray
) -> tuple[FrameFitter, FloatArray]:
    """Learn the animal's appearance from sure frames, and refit these.

    Parameters
    ----------
    fitter : FrameFitter
        What poses are fitted with so far.
    found : sequence of LegCandidates
        Every frame.
    poses : ndarray, shape (n, n_parameters)
        Their poses.

    Returns
    -------
    fitter : FrameFitter
        With the appearance, and with clutter that does not count in the last fits.
    poses : ndarray, shape (n, n_parameters)
        All poses, those of the frames learnt from refitted.
    """
    if not found:
        return fitter, poses
    chosen = frames_to_learn_from(found)
    for _ in range(LEARNING.relearn_rounds):
        known = usual_lengths(fitter, poses)
        fitted = partial(_fitted, fitter, found=found, poses=poses, known=known)
        frames = on_threads(fitted, chosen)
        poses = poses.copy()
        poses[chosen] = [pose for pose, _ in frames]
        clutter = replace(
            fitter.clutter,
            body=find_body_clutter(fitter, frames),
            legs=find_leg_clutter(fitter, frames),
        )
        fitter = fitter.with_clutter(clutter)
        frames = [(pose, counted(fitter, pose, image_evidence)) for pose, image_evidence in frames]
        fitter = fit_appearance(fitter, frames, prior=known)
    return fitter, poses


def frames_to_learn_from(found: Sequence[LegCandidates]) -> list[int]:
    """Return frames spread evenly over the sure ones, or over all where too few are sure."""
    sure = [i for i, one in enumerate(found) if not one.is_open]
    if len(sure) < LEARNING.relearn_frames:
        sure = list(range(len(found)))
    spread = np.linspace(0, len(sure) - 1, LEARNING.relearn_frames).astype(int)
    return sorted({sure[k] for k in spread})


def _fitted(
    fitter: FrameFitter,
    i: int,
    *,
    found: Sequence[LegCandidates],
    poses: FloatArray,
    known: Prior,
) -> tuple[FloatArray, ImageEvidence]:
    """Return a frame's pose, fitted again, and what the frame shows."""
    image_evidence = evidence_of(fitter, poses[i], image=found[i].grey, box=found[i].box)
    without = counted(fitter, poses[i], image_evidence)
    return fitter.fit(poses[i], without, known)[0], image_evidence


def usual_lengths(fitter: FrameFitter, poses: FloatArray) -> Prior:
    """Return anatomy with each link's usual foreshortening in these poses."""
    middle = fitter.anatomy.middle.copy()
    middle[fitter.index.lengths] = np.median(poses[:, fitter.index.lengths], axis=0)
    return fitter.anatomy._replace(middle=middle)
