"""What is kept of the candidates of the legs of one side in a frame."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from pawnb.arrays import AnyArray, ByteArray, FloatArray
from pawnb.core.pose.fit.fitter import FrameFitter


@dataclass(frozen=True, eq=False)
class LegCandidates:
    """What a frame leaves open.

    Attributes
    ----------
    frame : int
        Frame number.
    pose : ndarray, shape (n_parameters,)
        The pose followed so far.
    image, box
        Grey working pixels of the crop (uint8) and where they lie, to be observed again.
    legs : tuple of ndarray, shape (candidates, 2 links)
        Of each leg, its possible parts of the pose vector; the first is that of ``pose``.
    joints : tuple of ndarray, shape (candidates, segments + 1, 2)
        Where they put its joints.
    worth : tuple of ndarray, shape (candidates,)
        Cost of the picture with that leg alone added to the body, less that of the body.
    unlikely : tuple of ndarray, shape (candidates,)
        What anatomy makes each candidate cost.
    shared : dict
        Of pairs of legs, the cost of both together less that of each, (candidates, candidates).
    crossed : dict
        Of neighbouring legs, whether they cross, (candidates, candidates).
    alternatives : tuple of ndarray
        Of each leg, the candidates that may still be right by what was known when the frame was
        first seen, other than the one chosen then.
    """

    frame: int
    pose: FloatArray
    image: ByteArray
    box: tuple[int, int, int, int]
    legs: tuple[FloatArray, ...]
    joints: tuple[FloatArray, ...]
    worth: tuple[FloatArray, ...]
    unlikely: tuple[FloatArray, ...]
    shared: dict[tuple[int, int], np.ndarray] = field(default_factory=dict)
    crossed: dict[tuple[int, int], np.ndarray] = field(default_factory=dict)
    alternatives: tuple[FloatArray, ...] = ()

    @property
    def grey(self) -> FloatArray:
        """Grey working pixels of the crop, as numbers to calculate with."""
        return self.image.astype(float)

    @property
    def is_open(self) -> bool:
        """Whether any leg has more than one candidate."""
        return any(len(c) > 1 for c in self.legs)

    @property
    def is_doubtful(self) -> bool:
        """Whether any leg had a rival."""
        return any(len(c) for c in self.alternatives)

    def with_pose(self, pose: FloatArray) -> LegCandidates:
        """Return the frame with another pose that is followed."""
        return replace(self, pose=pose)

    def with_alternatives(self, alternatives: Mapping[int, FloatArray]) -> LegCandidates:
        """Return the frame with alternatives of some legs, and none of the others."""
        none = [candidates[:0] for candidates in self.legs]
        return replace(
            self, alternatives=tuple(alternatives.get(i, empty) for i, empty in enumerate(none))
        )

    def record(self) -> dict[str, Any]:
        """Return all but the picture, as plain values and arrays."""
        out = {"pose": self.pose, "box": self.box}
        out |= {name: list(getattr(self, name)) for name in _LEG_FIELDS}
        return out | {name: [[*k, v] for k, v in getattr(self, name).items()] for name in _OF_PAIRS}


_LEG_FIELDS = ("legs", "joints", "worth", "unlikely", "alternatives")
_OF_PAIRS = ("shared", "crossed")


def recalled(
    fitter: FrameFitter, frame: int, record: Mapping[str, Any], *, image: AnyArray
) -> LegCandidates:
    """Return what :meth:`LegCandidates.record` was made of, given the grey pixels of its box.

    Parameters
    ----------
    fitter : FrameFitter
        What poses are fitted with.
    frame : int
        The frame.
    record : mapping
        What was kept of it.
    image : ndarray, shape (H, W)
        Grey pixels of its box.

    Returns
    -------
    LegCandidates
        The frame as it was.
    """
    box = tuple(record["box"])
    candidates = only_candidate(fitter, frame, record["pose"], image=image, box=box)
    found: dict[str, Any] = {name: tuple(record[name]) for name in _LEG_FIELDS}
    found |= {name: {(a, b): costs for a, b, costs in record[name]} for name in _OF_PAIRS}
    return replace(candidates, **found)


def only_candidate(
    fitter: FrameFitter, frame: int, pose: FloatArray, *, image: FloatArray, box: tuple
) -> LegCandidates:
    """Return the frame with one pose of each leg.

    Parameters
    ----------
    fitter : FrameFitter
        What poses are fitted with.
    frame : int
        The frame.
    pose : ndarray
        The pose vector.
    image : ndarray, shape (H, W)
        Grey pixels of the box.
    box : tuple of int
        Region of the picture, px.

    Returns
    -------
    LegCandidates
        The frame.
    """
    joints = fitter.joints(pose)
    return LegCandidates(
        frame=frame,
        pose=pose,
        image=np.clip(np.round(image), 0, 255).astype(np.uint8),
        box=box,
        legs=tuple(pose[numbers][None] for numbers in fitter.index.numbers),
        joints=tuple(j[None] for j in joints),
        worth=tuple(np.zeros(1) for _ in fitter.index.numbers),
        unlikely=tuple(np.zeros(1) for _ in fitter.index.numbers),
    )
