"""A start without clicks, and in words how sure of it one may be."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from pawnb.core.paws.start_proposal.proposal import find_paws
from pawnb.core.rig import load_rig
from pawnb.core.video import ViewSet, open_views
from pawnb.errors import InputError
from pawnb.trial import Trial, load_trial
from pawnb.workflow.progress import Progress, progress_bar
from pawnb.workflow.start.propose_pose import PoseStart, propose_pose_start
from pawnb.workflow.start.sureness import sureness_in_words

EVERY = 5
"""Frames are looked through in steps of so many."""

MOST_FRAMES = 60
"""More than this many frames are not looked through: longer recordings in larger steps."""

PAWS = ("FR", "HR", "FL", "HL")

SIDES_UNKNOWN = (
    "Check left and right: this calibration does not tell them (its views are parallel "
    "projections, mirrored, or its axes left-handed)."
)


@dataclass(frozen=True)
class StartProposal:
    """A start for the tracker that a person accepts or corrects.

    Parameters
    ----------
    frame : int
        The frame in which the paws are best told.
    start : DataFrame
        frame, view, point, u, v (px), as :func:`pawnb.track` takes them for ``start``.
    points : DataFrame
        point, sure (0 to 1), words: how sure each point is.
    notes : tuple of str
        What a person should know besides.
    """

    frame: int
    start: pd.DataFrame
    points: pd.DataFrame
    notes: tuple[str, ...] = ()

    @property
    def sure(self) -> float:
        """How sure all of it is, 0 to 1: as sure as its least sure point."""
        return float(self.points["sure"].min())

    @property
    def words(self) -> str:
        """How sure all of it is, in words."""
        return sureness_in_words(self.sure)

    def text(self) -> str:
        """Return frame, points and how sure they are, one a line."""
        lines = [f"proposed start in frame {self.frame}: {self.words} ({self.sure:.2f})"]
        lines += [f"  {row.point}  {row.sure:.2f}  {row.words}" for row in self.points.itertuples()]
        return "\n".join([*lines, *self.notes])


def propose_start(
    trial: Trial | str | Path,
    *,
    frames: Sequence[int] | None = None,
    progress: Progress | None = None,
) -> StartProposal | PoseStart:
    """Find where tracking may start without clicks: paws, or the pose of a jointed animal.

    Parameters
    ----------
    trial : Trial, str or Path
        The trial, its ``trial.toml``, or the folder that holds it.
    frames : sequence of int, optional
        Frames to look through; default some spread over the trial.
    progress : callable, optional
        ``progress(done, total)``; default a bar on a terminal or in a notebook.

    Returns
    -------
    StartProposal or PoseStart
        As :func:`propose_paws` or, for a trial of kind ``pose``, :func:`propose_pose_start`.

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
    propose = _PROPOSE.get(trial.kind, propose_paws)
    return propose(trial, frames=frames, progress=progress)


def propose_paws(
    trial: Trial | str | Path,
    *,
    frames: Sequence[int] | None = None,
    progress: Progress | None = None,
) -> StartProposal:
    """Find the paws of a running mouse without clicks, in a frame where they are well seen.

    Parameters
    ----------
    trial : Trial, str or Path
        The trial, its ``trial.toml``, or the folder that holds it. Its views are calibrated,
        and two or more see the same side of the animal, or all of it.
    frames : sequence of int, optional
        Frames to look through; default every fifth of the trial, at most 60 spread over it.
    progress : callable, optional
        ``progress(done, total)``; default a bar on a terminal or in a notebook.

    Returns
    -------
    StartProposal
        The frame, the points, and how sure they are. The point of a paw is the middle of
        its digits. Landmarks (nose, ears, tail) are left to be clicked.

    Raises
    ------
    InputError
        If the trial tracks none of the paws FR, HR, FL and HL, if it is not calibrated, or if
        no paws are found.
    """
    if not isinstance(trial, Trial):
        trial = load_trial(trial)
    with open_views(trial) as views:
        return propose_in_views(trial, views, frames=frames, progress=progress)


def propose_in_views(
    trial: Trial,
    views: ViewSet,
    *,
    frames: Sequence[int] | None = None,
    progress: Progress | None = None,
) -> StartProposal:
    """Find the paws in views that are open already; see :func:`propose_paws`.

    Parameters
    ----------
    trial : Trial
        The trial.
    views : ViewSet
        Its open views.
    frames, progress
        As for :func:`propose_paws`.

    Returns
    -------
    StartProposal
        The frame, the points, and how sure they are.

    Raises
    ------
    InputError
        As for :func:`propose_paws`.
    """
    rig = load_rig(
        trial,
        sizes={name: (r.source.width, r.source.height) for name, r in views.readers.items()},
    )
    if rig is None:
        raise InputError(
            f"trial {trial.name!r} is not calibrated; paws can be proposed only where two "
            "calibrated views see the same side: click the points instead."
        )
    first, last = trial.frames or (views.first_frame, views.n_frames)
    if frames is None:
        step = max(EVERY, -(-(last - first) // MOST_FRAMES))
        frames = range(first, last, step)
    wrong = [frame for frame in frames if not views.first_frame <= frame < views.n_frames]
    if wrong or not len(frames):
        raise InputError(
            f"frames to look through: found {wrong[0] if wrong else 'none'}; expected some of "
            f"{views.first_frame} to {views.n_frames - 1}."
        )
    named = {view.name: view.points or PAWS for view in trial.views}
    wanted = {name: tuple(point for point in points if point in PAWS)
              for name, points in named.items()}  # fmt: skip
    # landmarks are left to be clicked; where there is nothing else the error names one
    wanted = {name: points for name, points in wanted.items() if points} or named
    asked = sorted({int(frame) for frame in frames})
    if progress is not None:
        found = find_paws(views, rig, points_by_view=wanted, frames=asked, progress=progress)
    else:
        with progress_bar("looking for paws") as bar:
            found = find_paws(views, rig, points_by_view=wanted, frames=asked, progress=bar)
    order = [point for point in PAWS if point in found.sure]
    points = pd.DataFrame(
        [(p, round(found.sure[p], 3), sureness_in_words(found.sure[p])) for p in order],
        columns=["point", "sure", "words"],
    )
    views_in_order = list(wanted)
    start = found.start.sort_values(
        ["view", "point"],
        key=lambda column: column.map(
            views_in_order.index if column.name == "view" else PAWS.index
        ),
        ignore_index=True,
    )
    notes = () if found.sides_known else (SIDES_UNKNOWN,)
    return StartProposal(found.frame, start, points, notes)


_PROPOSE: dict[str, Callable[..., StartProposal | PoseStart]] = {
    "paws": propose_paws,
    "pose": propose_pose_start,
}
