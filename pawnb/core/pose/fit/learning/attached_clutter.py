"""What is fixed to the body and no leg (wings, a marker, hairs), learnt from the recording.

A leg moves relative to the body; what lies in the same place of the body's frame in most frames
is no leg, and hides what is under it.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from pawnb.arrays import BoolArray, ByteArray, Float32Array, FloatArray
from pawnb.core.parallel import on_threads
from pawnb.core.pose.fit.candidates.candidate_sets import LegCandidates
from pawnb.core.pose.fit.fitter import FrameFitter
from pawnb.core.pose.fit.learning.attached_clutter_kernels import in_body_frame
from pawnb.core.pose.fit.learning.parameters import LEARNING
from pawnb.core.pose.fit.observation import disc_px, evidence_of, near_body
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import ImageEvidence


def find_attached_clutter(
    fitter: FrameFitter, found: Sequence[LegCandidates], poses: FloatArray
) -> BoolArray | None:
    """Return where something that is no leg is fixed to the body.

    Parameters
    ----------
    fitter : FrameFitter
        A fitter.
    found : sequence of LegCandidates
        The frames.
    poses : ndarray, shape (n, n_parameters)
        Their poses; only the body's place and heading matter.

    Returns
    -------
    ndarray of bool, shape (side, side), or None
        In the body's frame, working pixels: the body looks along the rows, its origin is the
        middle. None where it is no more than the body, or frames are too few to tell.

    Notes
    -----
    The median of the pictures in the body's frame shows what is there in most of them. Of that
    counts what is wider than legs, which may hold still as well, and hangs together with the body.
    """
    if len(found) < LEARNING.attached_clutter_few:
        return None
    chosen = np.unique(np.linspace(0, len(found) - 1, LEARNING.attached_clutter_frames).astype(int))
    side = 2 * int(np.ceil(fitter.reach)) + 1

    def turned(t: int) -> Float32Array:
        image = found[t].grey
        image_evidence = evidence_of(fitter, poses[t], image=image, box=found[t].box, margin=np.inf)
        out = np.empty((side, side), np.float32)
        in_body_frame(image_evidence.seen, image_evidence.box, poses[t], out)
        return out

    usual = np.median(on_threads(turned, chosen), axis=0)
    body = _body(fitter, side)
    size = disc_px(fitter)
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
    wide = (cv2.morphologyEx(usual, cv2.MORPH_OPEN, disc) > LEARNING.attached_clutter_dark).astype(
        np.uint8
    )
    edge = cv2.getStructuringElement(
        cv2.MORPH_ELLIPSE, (2 * LEARNING.edge_px + 1, 2 * LEARNING.edge_px + 1)
    )
    fixed = (usual > LEARNING.attached_clutter_dark) & (
        cv2.dilate(_hanging_on(wide, body), edge) > 0
    )
    is_more = np.count_nonzero(fixed & ~body) > LEARNING.least_legs * fitter.leg_area
    return fixed if is_more else None


def _body(fitter: FrameFitter, side: int) -> BoolArray:
    """Return where the body itself may be, in its own frame."""
    pose, empty = np.zeros(fitter.index.n), np.zeros((side, side))
    image_evidence = ImageEvidence(
        empty, empty, np.array([-(side // 2), -(side // 2)], dtype=float)
    )
    return near_body(fitter, pose, image_evidence)


def _hanging_on(wide: ByteArray, body: BoolArray) -> ByteArray:
    """Return the parts of a mask (uint8) that touch the body."""
    _, names = cv2.connectedComponents(wide)
    kept = np.unique(names[body])
    return (np.isin(names, kept[kept > 0])).astype(np.uint8)
