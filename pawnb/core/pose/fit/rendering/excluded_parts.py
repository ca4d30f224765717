"""What of a frame counts in the last fits: not what the animal is painted without."""

from __future__ import annotations

from pawnb.arrays import FloatArray
from pawnb.core.pose.fit.fitter import FrameFitter
from pawnb.core.pose.fit.learning.body_clutter import without_body_clutter
from pawnb.core.pose.fit.learning.leg_clutter import without_leg_clutter
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import ImageEvidence
from pawnb.core.pose.fit.rendering.leg_attachments import without_leg_attachments


def counted(fitter: FrameFitter, pose: FloatArray, image_evidence: ImageEvidence) -> ImageEvidence:
    """Return evidence without the weight of odd places, hairs and corners; see their modules.

    Parameters
    ----------
    fitter : FrameFitter
        A fitter.
    pose : ndarray, shape (n_parameters,)
        Where the animal is.
    image_evidence : ImageEvidence
        A frame.

    Returns
    -------
    ImageEvidence
        Its weight is a new array.
    """
    for without in (without_body_clutter, without_leg_clutter, without_leg_attachments):
        image_evidence = without(fitter, pose, image_evidence)
    return image_evidence
