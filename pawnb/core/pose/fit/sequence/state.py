"""What following the animal knows after a frame, and after all frames of a direction."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.frame_checkpoint import Record
from pawnb.core.pose.fit.candidates.candidate_sets import LegCandidates
from pawnb.core.pose.fit.candidates.viterbi import ViterbiTrellis
from pawnb.core.pose.fit.fitter import FrameFitter

_RECORDED = ("pose", "velocity", "middle", "jump_px", "usual", "lost", "astray")
"""All that the next frame needs to know of those before, besides what each leaves open."""


@dataclass(frozen=True, eq=False, kw_only=True)
class FollowState:
    """What is known after a frame; each frame makes a new one.

    Parameters
    ----------
    pose, velocity : ndarray, shape (n_parameters,)
        The pose, and how it is expected to change until the next frame.
    middle : ndarray, shape (links of all legs,)
        The usual foreshortening of the links.
    jump_px : float
        Standard deviation of how far joints stray from their predicted places.
    usual : ndarray, shape (2,)
        Dark pixels that are usually left over on the animal's left and right; infinite before
        the first frame.
    lost : int
        Frames in a row, up to this one, without a body.
    astray : tuple of float
        How far the middle leg strayed in each of the last frames, px.
    trellises : tuple of (ViterbiTrellis or None)
        The paths of each side's legs; None before the first frame, or where none are kept.
    last : tuple of LegCandidates
        What the frame leaves open; none before the first.
    n_frames : int
        Frames followed.
    """

    pose: FloatArray
    velocity: FloatArray
    middle: FloatArray
    jump_px: float
    usual: FloatArray
    lost: int
    astray: tuple[float, ...]
    trellises: tuple[ViterbiTrellis | None, ...]
    last: tuple[LegCandidates, ...]
    n_frames: int

    @classmethod
    def begin(cls, fitter: FrameFitter, pose: FloatArray) -> FollowState:
        """Return what is known before the first frame: the pose before it.

        Parameters
        ----------
        fitter : FrameFitter
            What poses are fitted with.
        pose : ndarray, shape (n_parameters,)
            The pose.

        Returns
        -------
        FollowState
            An animal that stands still.
        """
        return cls(
            pose=pose,
            velocity=np.zeros_like(pose),
            middle=pose[fitter.index.lengths].copy(),
            jump_px=fitter.settings.jump_px,
            usual=np.full(2, np.inf),
            lost=0,
            astray=(),
            trellises=tuple(None for _ in fitter.index.sides),
            last=(),
            n_frames=0,
        )

    def record(self) -> dict[str, Any]:
        """Return all but paths and picture, as plain values and arrays."""
        state = {name: getattr(self, name) for name in _RECORDED} | {"astray": list(self.astray)}
        return {"candidates": self.last[-1].record(), "state": state}

    def recalled(
        self,
        record: Record,
        candidates: LegCandidates,
        trellises: tuple[ViterbiTrellis | None, ...],
    ) -> FollowState:
        """Return the state after the next frame, of which :meth:`record` made the record.

        Parameters
        ----------
        record : mapping
            What was kept.
        candidates : LegCandidates
            The frame.
        trellises : tuple of (ViterbiTrellis or None)
            The paths to it.

        Returns
        -------
        FollowState
            As if the frame had been fitted.
        """
        known: dict[str, Any] = {name: record["state"][name] for name in _RECORDED}
        known["astray"] = tuple(known["astray"])
        return replace(
            self, **known, last=(candidates,), trellises=trellises, n_frames=self.n_frames + 1
        )


@dataclass(frozen=True, eq=False)
class Followed:
    """What one direction through frames has found.

    Parameters
    ----------
    fitter : FrameFitter
        What poses were fitted with.
    frames : tuple of LegCandidates
        What every frame leaves open, in the order followed.
    middle, jump_px
        As :class:`FollowState` has them in the end.
    """

    fitter: FrameFitter
    frames: tuple[LegCandidates, ...]
    middle: FloatArray
    jump_px: float

    def with_frames(self, frames: Iterable[LegCandidates]) -> Followed:
        """Return the same with other frames."""
        return replace(self, frames=tuple(frames))
