"""What the pose tracker is given, and what it knows between two steps of its pipeline."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from pawnb.arrays import FloatArray
from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.fit.candidates.candidate_sets import LegCandidates
from pawnb.core.pose.fit.fitter import FrameFitter
from pawnb.core.pose.fit.rendering.evidence import BackgroundPicture
from pawnb.core.pose.fit.sequence.between_annotations import Ways
from pawnb.core.pose.fit.sequence.final_fit import FinalFit
from pawnb.core.pose.fit.settings import PoseSettings
from pawnb.core.pose.poses import Poses
from pawnb.core.video.views import Frame


@dataclass(frozen=True, eq=False, kw_only=True)
class PoseRecording:
    """What is given.

    Parameters
    ----------
    frame : callable
        Returns a frame by its number.
    ways : Ways
        How frames are read, counted and kept while the animal is followed.
    frames : tuple of int
        First frame and one past the last.
    start : Poses
        Poses to start from, within ``frames``.
    reference : Poses
        One frame, from which the animal's appearance is learnt.
    animal : StickAnimal
        The animal.
    background : BackgroundPicture
        The empty scene.
    settings : PoseSettings
        Settings.
    """

    frame: Callable[[int], Frame]
    ways: Ways
    frames: tuple[int, int]
    start: Poses
    reference: Poses
    animal: StickAnimal
    background: BackgroundPicture
    settings: PoseSettings


@dataclass(frozen=True, eq=False, kw_only=True)
class PoseFitState:
    """What is known; each step returns a new one.

    Parameters
    ----------
    recording : PoseRecording
        What is given.
    fitter : FrameFitter
        The animal as far as it was learnt.
    known : mapping of int to ndarray, shape (n_parameters,)
        Start frame to its fitted pose.
    frames : tuple of LegCandidates
        What every frame leaves open, ascending; those without the animal are left out.
    poses : ndarray, shape (n, n_parameters)
        Their poses.
    final_fits : tuple of FinalFit
        Their last fits.
    passes : int
        How often the animal was followed.
    """

    recording: PoseRecording
    fitter: FrameFitter
    known: Mapping[int, FloatArray]
    frames: tuple[LegCandidates, ...]
    poses: FloatArray
    final_fits: tuple[FinalFit, ...] = ()
    passes: int = 0
