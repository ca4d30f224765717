"""The trackers of jointed animals, each as a :class:`pawnb.core.paws.tracker.Tracker`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import pawnb.core.pose.space.parameters  # noqa: F401  (its stage is known from here on)
from pawnb.core.frame_checkpoint import KeptFrames
from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.background import Background
from pawnb.core.pose.fit.settings import PoseSettings
from pawnb.core.pose.fit.tracker import track_pose
from pawnb.core.pose.poses import Poses
from pawnb.core.pose.pullar2009.settings import PUBLISHED_NAMES, Pullar2009Settings
from pawnb.core.pose.pullar2009.tracker import track_pullar2009
from pawnb.core.pose.start_proposal import parameters as _proposal_stage  # noqa: F401  (is set)
from pawnb.core.pose.track_result import PoseTrack
from pawnb.core.video import ViewSet


@dataclass(frozen=True)
class PoseRequest:
    """What a tracker of a jointed animal is to do.

    Parameters
    ----------
    view : str
        The view in which it is tracked.
    frames : tuple of int
        Half-open range of frames.
    animal : StickAnimal
        The animal, with its own proportions.
    background : Background
        The empty scene.
    progress : callable, optional
        ``progress(done, total)``.
    stop : callable, optional
        Asked before each frame; when it answers True, what is done is returned.
    """

    view: str
    frames: tuple[int, int]
    animal: StickAnimal
    background: Background
    progress: Callable[[int, int], None] | None = None
    stop: Callable[[], bool] | None = None


@dataclass(frozen=True)
class PoseTracker:
    """A tracker of a jointed animal in one view, see :class:`pawnb.core.paws.tracker.Tracker`.

    Parameters
    ----------
    name : str
        Its method.
    settings : type
        The class of its settings.
    run : callable
        What tracks: see :func:`pawnb.core.pose.fit.tracker.track_pose`.
    is_offline : bool
        Whether it decides over the whole recording, and knows when the animal is gone.
    stages, packages : tuple of str
        Stages whose parameters can be set, and packages whose other named numbers are recorded.
    kind, needs_calibration, is_of_first_view, more_files, published_names, former_names
        See :class:`pawnb.core.paws.tracker.Tracker`.
    """

    name: str
    settings: type[PoseSettings] | type[Pullar2009Settings]
    run: Callable[..., PoseTrack]
    is_offline: bool
    stages: tuple[str, ...]
    packages: tuple[str, ...]
    kind: str = "pose"
    needs_calibration: bool = False
    is_of_first_view: bool = True
    more_files: tuple[str, ...] = ("pose.csv",)
    published_names: Mapping[str, str] = field(default_factory=dict, hash=False)
    former_names: Mapping[str, str] = field(default_factory=dict, hash=False)

    def track(
        self,
        views: ViewSet,
        start: Poses,
        request: PoseRequest,
        *,
        settings: Any,
        kept: KeptFrames | None = None,
    ) -> PoseTrack:
        """Track from one pose or more, both ways."""
        return self._run(views, start, request, settings=settings, kept=kept)

    def resume(
        self,
        views: ViewSet,
        start: Poses,
        request: PoseRequest,
        *,
        settings: Any,
        kept: KeptFrames,
    ) -> PoseTrack:
        """Go on with a run that was interrupted: frames that it kept are not tracked again."""
        return self._run(views, start, request, settings=settings, kept=kept)

    def retrack(
        self,
        views: ViewSet,
        start: Poses,
        request: PoseRequest,
        *,
        settings: Any,
        corrected: Poses,
    ) -> PoseTrack:
        """Track a part again."""
        return self._run(views, start, request, settings=settings, reference=corrected)

    def _run(self, views: ViewSet, start: Poses, request: PoseRequest, **given: Any) -> PoseTrack:
        return self.run(
            views.readers[request.view], start, animal=request.animal,
            background=request.background, frames=request.frames, progress=request.progress,
            stop=request.stop, **given,
        )  # fmt: skip


POSE_TRACKERS = (
    PoseTracker(
        "pawnb", PoseSettings, track_pose, is_offline=True,
        stages=(
            "fitting", "rendering", "candidates", "learning", "sequence", "space_fit",
            "pose_proposal",
        ),
        packages=("pawnb.core.pose.fit", "pawnb.core.pose.space", "pawnb.core.pose.start_proposal"),
    ),
    PoseTracker(
        "paper", Pullar2009Settings, track_pullar2009, is_offline=False,
        stages=("pullar2009", "space_fit", "pose_proposal"),
        packages=(
            "pawnb.core.pose.pullar2009", "pawnb.core.pose.space", "pawnb.core.pose.start_proposal",
        ),
        published_names=PUBLISHED_NAMES,
    ),
)  # fmt: skip
"""The trackers of jointed animals; the first is the default."""
