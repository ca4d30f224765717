"""What is asked of a tracker of paws, whichever it is: which points, frames and views."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from pawnb.core.rig import Rig
from pawnb.errors import InputError
from pawnb.schema import Tracks

if TYPE_CHECKING:
    from pawnb.core.paws.offline.detection.evidence import EvidenceKind
    from pawnb.core.paws.offline.detection.predictions import Predictions


@dataclass(frozen=True, kw_only=True)
class TrackingRequest:
    """What is to be tracked, and who is informed.

    Parameters
    ----------
    frames : tuple of int
        First frame and one past the last. The published methods begin with the first start
        frame: frames before it stay missing.
    fps : float
        Frames per second.
    rig : Rig, optional
        The calibrated views.
    points_by_view : mapping
        Points that each view tracks; none listed means every point.
    facing : mapping, optional
        +1 or -1 where the animal faces right or left in a view; default by the rig's
        forward direction, else by the clicks of front and hind points.
    individual : str
        The animal's id.
    unit : str
        Unit of the rig's space; without a rig positions are in px.
    tracks : Tracks, optional
        Tracks to go on from: rows before ``frames[0]`` are kept; what the tracker takes
        from the others it says itself.
    predictions : mapping, optional
        View to what another program predicts there, counted from ``frames[0]``; the default
        method takes it as evidence beside its own.
    evidence : sequence of EvidenceKind
        Further kinds of evidence, beside those that packages offer; the default method takes them
        where points are found by what is learnt in the recording.
    progress : callable, optional
        ``progress(done, total)`` after each frame.
    stop : callable, optional
        Asked before each frame; when it answers True, what is done is returned.
    """

    frames: tuple[int, int]
    fps: float
    rig: Rig | None = None
    points_by_view: Mapping[str, Sequence[str]] = field(default_factory=dict)
    facing: Mapping[str, int] | None = None
    individual: str = "animal"
    unit: str = "px"
    tracks: Tracks | None = None
    predictions: Mapping[str, Predictions] = field(default_factory=dict)
    evidence: Sequence[EvidenceKind] = ()
    progress: Callable[[int, int], None] | None = None
    stop: Callable[[], bool] | None = None

    def check_frames(self, n_frames: int) -> None:
        """Raise InputError unless a recording of ``n_frames`` has the frames asked for."""
        first, end = self.frames
        if not 0 <= first < end <= n_frames:
            raise InputError(
                f"frames {first} to {end - 1} are to be tracked, but the views have "
                f"frames 0 to {n_frames - 1}; choose a range within."
            )
