"""What every tracker offers, of paws and of jointed animals, and which trackers there are.

Comes in: opened views, a start that a person gave or accepted, and a request. Goes out: Tracks, or
the poses of a jointed animal. :class:`Tracker` is the protocol; :func:`trackers` lists those of a
kind of animal by the name of their method, the default first.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol, TypeVar

import pandas as pd

from pawnb.core.paws.layout import Views
from pawnb.core.paws.maghsoudi2019.settings import PUBLISHED_NAMES, Maghsoudi2019Settings
from pawnb.core.paws.maghsoudi2019.tracker import track_maghsoudi2019
from pawnb.core.paws.offline.detection.colour.cache import DetectionCache
from pawnb.core.paws.offline.reuse.kept_evidence import KeptStacks
from pawnb.core.paws.offline.reuse.retracking import Again
from pawnb.core.paws.offline.settings import FORMER_NAMES, OfflineSettings
from pawnb.core.paws.offline.tracker import track_offline
from pawnb.core.paws.request import TrackingRequest
from pawnb.core.paws.start_proposal import parameters as _proposal_stage  # noqa: F401  (is set)
from pawnb.core.pose.tracker import POSE_TRACKERS
from pawnb.errors import InputError, did_you_mean
from pawnb.schema import Tracks

ViewsT = TypeVar("ViewsT", contravariant=True)
StartT = TypeVar("StartT", contravariant=True)
RequestT = TypeVar("RequestT", contravariant=True)
KeptT = TypeVar("KeptT", contravariant=True)
CorrectedT = TypeVar("CorrectedT", contravariant=True)
FoundT = TypeVar("FoundT", covariant=True)


class Tracker(Protocol[ViewsT, StartT, RequestT, KeptT, CorrectedT, FoundT]):
    """A method that follows an animal through a recording.

    ``start`` are clicks of points, or poses; ``request`` a
    :class:`~pawnb.core.paws.request.TrackingRequest` or a
    :class:`~pawnb.core.pose.tracker.PoseRequest`; ``kept`` what earlier runs on the same recording
    have left; ``corrected`` what a person put right, and what follows from it.
    """

    @property
    def name(self) -> str:
        """The method."""

    @property
    def kind(self) -> str:
        """The kind of trial it is for: ``"paws"`` or ``"pose"``."""

    @property
    def settings(self) -> type[Any]:
        """The class of its settings."""

    @property
    def is_offline(self) -> bool:
        """Whether it decides over the whole recording, not frame by frame from the start on.

        Such a tracker takes a start in any number of frames, goes both ways from it, keeps what it
        finds by itself, and takes other programs' predictions as evidence.
        """

    @property
    def needs_calibration(self) -> bool:
        """Whether several views are tracked together only."""

    @property
    def is_of_first_view(self) -> bool:
        """Whether it tracks in the first view, and a second one gives places in space."""

    @property
    def stages(self) -> tuple[str, ...]:
        """The stages whose parameters can be set, see :mod:`pawnb.core.parameters`."""

    @property
    def packages(self) -> tuple[str, ...]:
        """The packages whose other named numbers a record of a run holds."""

    @property
    def more_files(self) -> tuple[str, ...]:
        """The files that a run writes beside those of every tracker."""

    @property
    def published_names(self) -> Mapping[str, str]:
        """A paper's names of settings, and their names here: who types those is told these."""

    @property
    def former_names(self) -> Mapping[str, str]:
        """What settings were called before, and what they are called now."""

    def track(
        self, views: ViewsT, start: StartT, request: RequestT, *, settings: Any, kept: KeptT
    ) -> FoundT:
        """Track from a start.

        Parameters
        ----------
        views : Views or ViewSet
            The opened views.
        start : DataFrame or Poses
            Clicks of points, or poses.
        request : TrackingRequest or PoseRequest
            What is to be tracked.
        settings : object
            An instance of :attr:`settings`.
        kept : KeptEvidence or KeptFrames
            What earlier runs on the same recording have left.

        Returns
        -------
        xarray.Dataset or PoseTrack
            Tracks of points, or poses.
        """

    def resume(
        self, views: ViewsT, start: StartT, request: RequestT, *, settings: Any, kept: KeptT
    ) -> FoundT:
        """Go on with a run that was interrupted, from what it kept.

        Parameters
        ----------
        views, start, request, settings, kept
            As for :meth:`track`.

        Returns
        -------
        xarray.Dataset or PoseTrack
            As :meth:`track`.
        """

    def retrack(
        self, views: ViewsT, start: StartT, request: RequestT, *, settings: Any,
        corrected: CorrectedT,
    ) -> FoundT:  # fmt: skip
        """Track again after a correction.

        Parameters
        ----------
        views, start, request, settings
            As for :meth:`track`.
        corrected : Correction or Poses
            What a person put right.

        Returns
        -------
        xarray.Dataset or PoseTrack
            As :meth:`track`.
        """


@dataclass(frozen=True)
class KeptEvidence:
    """What earlier runs on the same recording have left, for trackers that read it again.

    Parameters
    ----------
    detections : DetectionCache, optional
        What was found by colour in each frame; what is found now goes there, too.
    stacks : KeptStacks, optional
        Pictures and optical flow.
    """

    detections: DetectionCache | None = None
    stacks: KeptStacks | None = None


@dataclass(frozen=True)
class Correction:
    """What a person put right, and what tracking again has to know of the runs before.

    Parameters
    ----------
    learn_at : mapping
        Point to the frame whose colour is its initial colour from now on.
    annotations : DataFrame, optional
        Earlier clicks by which the recording was searched, columns as those of a start.
    again : Again, optional
        The frames that are to be made anew; default all.
    kept : KeptEvidence
        What earlier runs have left.
    """

    learn_at: Mapping[str, int] = field(default_factory=dict)
    annotations: pd.DataFrame | None = None
    again: Again | None = None
    kept: KeptEvidence = KeptEvidence()


@dataclass(frozen=True)
class OfflineTracker:
    """The default tracker of points: :func:`pawnb.core.paws.offline.tracker.track_offline`."""

    name: str = "pawnb"
    kind: str = "paws"
    settings: type[OfflineSettings] = OfflineSettings
    is_offline: bool = True
    needs_calibration: bool = False
    is_of_first_view: bool = False
    stages: tuple[str, ...] = (
        "colour", "movement", "network_flow", "stride", "gap_closing", "smoothing", "landmarks",
        "treadmill", "scene", "motion", "correlation", "appearance", "association", "identity",
        "registration", "data_association", "learnt_detection", "predictions", "point_tracker",
        "quality", "quality_limits", "run", "paw_proposal",
    )  # fmt: skip
    packages: tuple[str, ...] = ("pawnb.core.paws.offline", "pawnb.core.paws.start_proposal")
    more_files: tuple[str, ...] = ()
    published_names: Mapping[str, str] = field(default_factory=dict, hash=False)
    former_names: Mapping[str, str] = field(default_factory=lambda: FORMER_NAMES, hash=False)

    def track(
        self, views: Views, start: pd.DataFrame, request: TrackingRequest, *, settings: Any,
        kept: KeptEvidence = KeptEvidence(),
    ) -> Tracks:  # fmt: skip
        """Track from clicks in any number of frames."""
        return track_offline(
            views, start, request, settings=settings, store=kept.detections, stacks=kept.stacks
        )

    def resume(
        self, views: Views, start: pd.DataFrame, request: TrackingRequest, *, settings: Any,
        kept: KeptEvidence,
    ) -> Tracks:  # fmt: skip
        """Decide anew; frames whose detections were kept are not decoded again."""
        return self.track(views, start, request, settings=settings, kept=kept)

    def retrack(
        self, views: Views, start: pd.DataFrame, request: TrackingRequest, *, settings: Any,
        corrected: Correction,
    ) -> Tracks:  # fmt: skip
        """Decide anew, with everything in ``start`` as certain."""
        return track_offline(
            views, start, request, settings=settings, looked=corrected.annotations,
            store=corrected.kept.detections, stacks=corrected.kept.stacks, again=corrected.again,
        )  # fmt: skip


@dataclass(frozen=True)
class Maghsoudi2019Tracker:
    """The published method, or one of the variants it is compared with.

    See :func:`pawnb.core.paws.maghsoudi2019.tracker.track_maghsoudi2019`. It keeps no evidence: the
    frames that are done are in ``request.tracks``.
    """

    name: str
    needs_calibration: bool = True
    kind: str = "paws"
    settings: type[Maghsoudi2019Settings] = Maghsoudi2019Settings
    is_offline: bool = False
    is_of_first_view: bool = False
    stages: tuple[str, ...] = ("maghsoudi2019", "paw_proposal")
    packages: tuple[str, ...] = (
        "pawnb.core.paws.maghsoudi2019",
        "pawnb.core.paws.start_proposal",
    )
    more_files: tuple[str, ...] = ()
    published_names: Mapping[str, str] = field(default_factory=lambda: PUBLISHED_NAMES, hash=False)
    former_names: Mapping[str, str] = field(default_factory=dict, hash=False)

    def track(
        self, views: Views, start: pd.DataFrame, request: TrackingRequest, *, settings: Any,
        kept: KeptEvidence = KeptEvidence(),  # noqa: ARG002  (there is none)
    ) -> Tracks:  # fmt: skip
        """Track frame by frame from the first clicked one."""
        return track_maghsoudi2019(views, start, request, settings=settings, method=self.name)

    def resume(
        self, views: Views, start: pd.DataFrame, request: TrackingRequest, *, settings: Any,
        kept: KeptEvidence,
    ) -> Tracks:  # fmt: skip
        """Go on from the last frame of ``request.tracks``."""
        return self.track(views, start, request, settings=settings, kept=kept)

    def retrack(
        self, views: Views, start: pd.DataFrame, request: TrackingRequest, *, settings: Any,
        corrected: Correction,
    ) -> Tracks:  # fmt: skip
        """Go on from the first frame of the request, with every state made anew."""
        return track_maghsoudi2019(
            views, start, request, settings=settings, method=self.name,
            learn_at=corrected.learn_at,
        )  # fmt: skip


AnyTracker = Tracker[Any, Any, Any, Any, Any, Any]

DEFAULT = "pawnb"
"""The name of the default tracker of every kind of animal."""

_TRACKERS: tuple[AnyTracker, ...] = (
    OfflineTracker(),
    Maghsoudi2019Tracker("paper"),
    Maghsoudi2019Tracker("slic-3d"),
    Maghsoudi2019Tracker("slic-2d", needs_calibration=False),
    *POSE_TRACKERS,
)


def trackers(kind: str) -> dict[str, AnyTracker]:
    """Return the trackers for a kind of trial, by the names of their methods, the default first.

    Parameters
    ----------
    kind : str
        ``"paws"`` or ``"pose"``; for others there are none.

    Returns
    -------
    dict
        Name to tracker.
    """
    return {tracker.name: tracker for tracker in _TRACKERS if tracker.kind == kind}


def tracked_kinds() -> tuple[str, ...]:
    """Return the kinds of trials that are tracked here."""
    return tuple(dict.fromkeys(tracker.kind for tracker in _TRACKERS))


def find_tracker(kind: str, name: str) -> AnyTracker:
    """Return a tracker.

    Parameters
    ----------
    kind : str
        The kind of trial.
    name : str
        The method.

    Returns
    -------
    Tracker
        The tracker.

    Raises
    ------
    InputError
        If there is none of that name for that kind.
    """
    known = trackers(kind)
    if name not in known:
        raise InputError(
            f"unknown method {name!r}{did_you_mean(name, known)}; expected {', '.join(known)}."
        )
    return known[name]
