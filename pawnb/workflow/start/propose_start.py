"""A start without clicks, whatever the kind of trial."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pawnb.schema.arguments import checked_arguments
from pawnb.trial import Trial, load_trial
from pawnb.workflow.kinds import kind_of
from pawnb.workflow.progress import Progress
from pawnb.workflow.start.propose import StartProposal
from pawnb.workflow.start.propose_pose import PoseStart


@checked_arguments
def propose_start(
    trial: Trial | str | Path,
    *,
    frames: Sequence[int] | None = None,
    settings: Mapping[str, Any] | None = None,
    progress: Progress | None = None,
) -> StartProposal | PoseStart:
    """Find where tracking may start without clicks: paws, or the pose of a jointed animal.

    Parameters
    ----------
    trial : Trial, str or Path
        The trial, its ``trial.toml``, or the folder that holds it.
    frames : sequence of int, optional
        Frames to look through; default some spread over the trial.
    settings : mapping, optional
        Parameters of the stage ``paw_proposal`` or ``pose_proposal`` that go before the trial's
        ``[tracking]``: ``paw_proposal.NAME`` to values.
    progress : callable, optional
        ``progress(done, total)``; default a bar on a terminal or in a notebook.

    Returns
    -------
    StartProposal or PoseStart
        As :func:`~pawnb.workflow.start.propose.propose_paws` or, for a trial of kind ``pose``,
        :func:`~pawnb.workflow.start.propose_pose.propose_pose_start`.

    Raises
    ------
    InputError
        As these.

    Examples
    --------
    >>> proposal = pawnb.propose_start(trial)
    >>> {"frame", "view", "point", "u", "v"} <= set(proposal.start)
    True
    """
    if not isinstance(trial, Trial):
        trial = load_trial(trial)
    return kind_of(trial).propose(trial, frames=frames, settings=settings, progress=progress)
