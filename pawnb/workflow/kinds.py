"""The kinds of trials, and what is done to each in a way of its own.

``paws`` are points, ``pose`` a jointed animal, ``tracks`` what another program has tracked.
:func:`kind_of` finds the object of a trial's kind once; what is asked of it does not ask for the
kind again. What tracks points, or poses, is a :class:`~pawnb.core.paws.tracker.Tracker`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from pawnb.core.video import ViewSet
from pawnb.errors import InputError, PawnbError
from pawnb.io.start import read_start
from pawnb.schema import Tracks, shown
from pawnb.trial import Trial
from pawnb.workflow.checking.check_points import check_points_trial
from pawnb.workflow.checking.check_pose import check_pose_trial
from pawnb.workflow.checking.check_report import CheckReport
from pawnb.workflow.progress import Progress
from pawnb.workflow.start.propose import propose_paws
from pawnb.workflow.start.propose_pose import propose_pose_start
from pawnb.workflow.tracking.methods import NO_RECORDING
from pawnb.workflow.tracking.options import RetrackOptions, TrackOptions
from pawnb.workflow.tracking.pose.retrack_pose import retrack_pose
from pawnb.workflow.tracking.pose.track_pose import track_pose_trial
from pawnb.workflow.tracking.retrack_points import retrack_points
from pawnb.workflow.tracking.track_points import track_points


class TrialKind(Protocol):
    """What is done to a trial in a way of its own, by its kind."""

    def track(self, trial: Trial, asked: TrackOptions, /) -> Tracks:
        """Track it, see :func:`pawnb.track`."""

    def retrack(self, trial: Trial, tracks: Tracks, frame: int, *, asked: RetrackOptions) -> Tracks:
        """Track it again about a corrected frame, see :func:`pawnb.retrack`.

        Parameters
        ----------
        trial : Trial
            The trial.
        tracks : xarray.Dataset
            Tracks with the corrections already applied.
        frame : int
            The corrected frame.
        asked : RetrackOptions
            What is asked for.

        Returns
        -------
        xarray.Dataset
            Tracks of the same frames.
        """

    def propose(
        self,
        trial: Trial,
        *,
        frames: Sequence[int] | None,
        settings: Mapping[str, Any] | None,
        progress: Progress | None,
    ) -> Any:
        """Find a start without a click, see :func:`pawnb.propose_start`.

        Parameters
        ----------
        trial : Trial
            The trial.
        frames : sequence of int or None
            Frames to look through.
        settings : mapping or None
            Parameters of the stage that looks.
        progress : callable or None
            ``progress(done, total)``.

        Returns
        -------
        StartProposal or PoseStart
            The start, and how sure it is.
        """

    def check_start(self, trial: Trial, views: ViewSet, report: CheckReport, /) -> None:
        """Add to a report what is seen of its start, and of what it needs.

        Parameters
        ----------
        trial : Trial
            The trial.
        views : ViewSet
            Its open views.
        report : CheckReport
            The report.
        """

    def start_file(self, trial: Trial, /) -> str | None:
        """Return the csv of its start, where it has one."""

    def is_started(self, trial: Trial, /) -> bool:
        """Tell whether its start is complete, as far as that needs no picture."""

    def compare(self, trials: Sequence[Trial], *, corrections: bool, **asked: Any) -> Any:
        """Compare methods on trials with truth.

        Parameters
        ----------
        trials : sequence of Trial
            The trials.
        corrections : bool
            Whether to count with corrections as well, where the kind knows that.
        **asked
            As for :func:`pawnb.workflow.evaluation.compare.compare_methods`.

        Returns
        -------
        Comparison or PoseComparison
            The tables.
        """


class PointTrials:
    """Trials of kind ``paws``: points clicked in calibrated views."""

    track = staticmethod(track_points)
    retrack = staticmethod(retrack_points)
    propose = staticmethod(propose_paws)
    check_start = staticmethod(check_points_trial)
    start_file = staticmethod(Trial.start_file)

    def is_started(self, trial: Trial, /) -> bool:
        """Tell whether every point is clicked in a view."""
        file = trial.start_file()
        if file is None:
            return False
        try:
            read_start(trial.path(file), trial)
        except (PawnbError, OSError):  # clicking goes on in it, or says what is wrong with it
            return False
        return True

    def compare(self, trials: Sequence[Trial], *, corrections: bool, **asked: Any) -> Any:
        """Compare methods as the 2019 paper does."""
        # draws figures: tracking does not wait for them to be loaded
        from pawnb.workflow.evaluation.compare import compare_methods

        return compare_methods(trials, corrections=corrections, **asked)


class PoseTrials:
    """Trials of kind ``pose``: a jointed animal in one view, or in two."""

    track = staticmethod(track_pose_trial)
    retrack = staticmethod(retrack_pose)
    propose = staticmethod(propose_pose_start)
    check_start = staticmethod(check_pose_trial)
    start_file = staticmethod(Trial.start_pose_file)

    def is_started(self, trial: Trial, /) -> bool:
        """Tell whether there is a start pose: it is saved as a whole."""
        file = trial.start_pose_file()
        return file is not None and trial.path(file).exists()

    def compare(self, trials: Sequence[Trial], *, corrections: bool, **asked: Any) -> Any:  # noqa: ARG002  (poses are not corrected one by one)
        """Compare the errors of methods."""
        from pawnb.workflow.evaluation.compare_pose import compare_pose_methods

        return compare_pose_methods(trials, **asked)


_KINDS: dict[str, TrialKind] = {"paws": PointTrials(), "pose": PoseTrials()}


def kind_of(trial: Trial) -> TrialKind:
    """Return what is done to a trial in the way of its kind.

    Parameters
    ----------
    trial : Trial
        The trial.

    Returns
    -------
    TrialKind
        The object of its kind.

    Raises
    ------
    InputError
        If it is no trial, or has no recording: another program has tracked it.
    """
    if not isinstance(trial, Trial):
        raise InputError(f"trial is {shown(trial)}; expected what pawnb.load_trial returns.")
    trial.must_be(*_KINDS, or_else=NO_RECORDING)
    return _KINDS[trial.kind]
