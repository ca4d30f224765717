"""Paws found without clicks, and in words how sure of them one may be."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar

import pandas as pd

from pawnb.core.parameters import parameters_of, parameters_set
from pawnb.core.paws.start_proposal.proposal import find_paws
from pawnb.core.rig import load_rig
from pawnb.core.video import ViewSet, open_views
from pawnb.errors import InputError
from pawnb.trial import Trial, load_trial
from pawnb.workflow.progress import Progress, given_or_bar
from pawnb.workflow.start.proposed import Proposed, frames_to_look_through, sure_table
from pawnb.workflow.tracking.methods import stage_parameters

EVERY = 5
"""Frames are looked through in steps of so many."""

MOST_LOOKED_THROUGH = 60
"""More than this many frames are not looked through: longer recordings in larger steps."""

PAWS = ("FR", "HR", "FL", "HL")

SIDES_UNKNOWN = (
    "Check left and right: this calibration does not tell them (its views are parallel "
    "projections, mirrored, or its axes left-handed)."
)


@dataclass(frozen=True)
class StartProposal(Proposed):
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
    parameters : mapping
        The values of the stage ``paw_proposal`` that it was made with.
    """

    frame: int
    start: pd.DataFrame
    points: pd.DataFrame
    notes: tuple[str, ...] = ()
    parameters: Mapping[str, Any] = field(default_factory=dict)

    what: ClassVar[str] = "start"

    @property
    def parts(self) -> pd.DataFrame:
        """How sure each point is."""
        return self.points


def propose_paws(
    trial: Trial | str | Path,
    *,
    frames: Sequence[int] | None = None,
    settings: Mapping[str, Any] | None = None,
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
    settings : mapping, optional
        ``paw_proposal.NAME`` to values, which go before the trial's ``[tracking.paw_proposal]``.
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
        return propose_in_views(trial, views, frames=frames, settings=settings, progress=progress)


def propose_in_views(
    trial: Trial,
    views: ViewSet,
    *,
    frames: Sequence[int] | None = None,
    settings: Mapping[str, Any] | None = None,
    progress: Progress | None = None,
) -> StartProposal:
    """Find the paws in views that are open already; see :func:`propose_paws`.

    Parameters
    ----------
    trial : Trial
        The trial.
    views : ViewSet
        Its open views.
    frames, settings, progress
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
    frames = frames_to_look_through(trial, views, frames, every=EVERY, at_most=MOST_LOOKED_THROUGH)
    named = {view.name: view.points or PAWS for view in trial.views}
    wanted = {name: tuple(point for point in points if point in PAWS)
              for name, points in named.items()}  # fmt: skip
    # landmarks are left to be clicked; where there is nothing else the error names one
    wanted = {name: points for name, points in wanted.items() if points} or named
    asked = sorted({int(frame) for frame in frames})
    own = stage_parameters(trial, settings=settings)
    with given_or_bar(progress, "looking for paws") as report, parameters_set(own):
        found = find_paws(views, rig, points_by_view=wanted, frames=asked, progress=report)
        parameters = parameters_of(["paw_proposal"])["paw_proposal"]
    points = sure_table("point", {p: round(found.sure[p], 3) for p in PAWS if p in found.sure})
    views_in_order = list(wanted)
    start = found.start.sort_values(
        ["view", "point"],
        key=lambda column: column.map(
            views_in_order.index if column.name == "view" else PAWS.index
        ),
        ignore_index=True,
    )
    notes = () if found.sides_known else (SIDES_UNKNOWN,)
    return StartProposal(found.frame, start, points, notes, parameters)
