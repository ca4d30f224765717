"""A start pose without a click, and in words how sure of it one may be."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar

import pandas as pd

from pawnb.core.parameters import parameters_of, parameters_set
from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.background import Background, find_background
from pawnb.core.pose.fit.explanation import explain_fit, fit_to_picture
from pawnb.core.pose.pose_table import write_start
from pawnb.core.pose.poses import Poses
from pawnb.core.pose.species_file import built_in_species, load_species
from pawnb.core.pose.start_proposal.proposal import PoseProposal, propose_pose
from pawnb.core.video import ViewSet, open_views
from pawnb.errors import InputError
from pawnb.trial import Trial, load_trial
from pawnb.workflow.progress import Progress, given_or_bar
from pawnb.workflow.start.proposed import Proposed, frames_to_look_through, sure_table
from pawnb.workflow.start.sureness import SURE_FROM
from pawnb.workflow.tracking.methods import stage_parameters

SCENE_WORDS, ANIMAL_WORDS = "looking for the empty scene", "looking for the animal"
"""What is done while a pose is proposed, in words."""


@dataclass(frozen=True)
class PoseStart(Proposed):
    """A start pose that a person accepts or corrects.

    Parameters
    ----------
    animal : StickAnimal
        The animal of the trial.
    pose : Poses
        Its pose in one frame; projected lengths are those in the picture.
    legs : DataFrame
        leg, sure (0 to 1), words: how sure each leg is.
    notes : tuple of str
        What a person should know, in sentences.
    parameters : mapping
        The values of the stage ``pose_proposal`` that it was made with.
    """

    animal: StickAnimal
    pose: Poses
    legs: pd.DataFrame
    notes: tuple[str, ...]
    parameters: Mapping[str, Any] = field(default_factory=dict)

    what: ClassVar[str] = "start pose"

    @property
    def frame(self) -> int:
        """The frame in which the animal is best seen."""
        return int(self.pose.frames[0])

    @property
    def parts(self) -> pd.DataFrame:
        """How sure each leg is."""
        return self.legs

    def save(self, path: str | Path) -> Path:
        """Write it as ``start_pose.csv``; returns the path."""
        return write_start(path, self.animal, self.pose)


class OneView:
    """One view of several, its frames by their numbers in the trial.

    Parameters
    ----------
    views : ViewSet
        The open views of a trial.
    name : str
        Which of them.
    """

    def __init__(self, views: ViewSet, name: str) -> None:
        self._views, self._name = views, name
        self.n_frames = views.n_frames

    def frame(self, index: int, /) -> Any:
        """Return a frame of this view."""
        return self._views.frame(index)[self._name]


def pose_view(trial: Trial) -> str:
    """Return the view whose pixels poses are in: the first."""
    return trial.views[0].name


def trial_animal(trial: Trial) -> StickAnimal:
    """Return the animal of a trial of kind ``pose``; raises InputError if no species is named."""
    if trial.animal.species is None:
        raise InputError(
            f"trial {trial.name!r} names no species; add species to [animal]: "
            f"{', '.join(built_in_species())}, or the path of a species file."
        )
    return load_species(trial.animal.species, folder=trial.folder)


def trial_background(
    trial: Trial, views: ViewSet, *, progress: Progress | None = None
) -> Background:
    """Return the empty scene of the view that poses are in.

    Parameters
    ----------
    trial : Trial
        The trial.
    views : ViewSet
        Its open views.
    progress : callable, optional
        ``progress(done, total)`` in frames; in a long film every frame is read.

    Returns
    -------
    Background
        The empty scene.
    """
    view = trial.views[0]
    reader = views.readers[view.name]
    return find_background(reader, view, folder=trial.folder, progress=progress)


def propose_pose_start(
    trial: Trial | str | Path,
    *,
    frames: Sequence[int] | None = None,
    settings: Mapping[str, Any] | None = None,
    progress: Progress | None = None,
) -> PoseStart:
    """Find the pose of a jointed animal without clicks, in a frame where it is well seen.

    Parameters
    ----------
    trial : Trial, str or Path
        A trial of kind ``pose``, its ``trial.toml``, or the folder that holds it.
    frames : sequence of int, optional
        Frames that may be looked through; default all: 40 spread over them are, and 40 more
        where a leg is in doubt.
    settings : mapping, optional
        ``pose_proposal.NAME`` to values, which go before the trial's ``[tracking.pose_proposal]``.
    progress : callable, optional
        ``progress(done, total)``, first of the frames in which the empty scene is looked for, then
        of those in which the animal is; default a bar on a terminal or in a notebook.

    Returns
    -------
    PoseStart
        The pose, and how sure each leg is.

    Raises
    ------
    InputError
        If no frame shows the whole animal, or a frame is not in the recording.
    """
    if not isinstance(trial, Trial):
        trial = load_trial(trial)
    with open_views(trial) as views:
        with given_or_bar(progress, SCENE_WORDS) as report:
            background = trial_background(trial, views, progress=report)
        return propose_pose_in_views(
            trial, views, background=background, frames=frames, settings=settings, progress=progress
        )


def propose_pose_in_views(
    trial: Trial,
    views: ViewSet,
    *,
    background: Background,
    frames: Sequence[int] | None = None,
    settings: Mapping[str, Any] | None = None,
    progress: Progress | None = None,
) -> PoseStart:
    """Find the pose in views that are open already; see :func:`propose_pose_start`.

    Parameters
    ----------
    trial : Trial
        The trial.
    views : ViewSet
        Its open views.
    background : Background
        Their empty scene.
    frames, settings, progress
        As for :func:`propose_pose_start`.

    Returns
    -------
    PoseStart
        The pose, and how sure each leg is.

    Raises
    ------
    InputError
        As for :func:`propose_pose_start`.
    """
    animal = trial_animal(trial)
    frames = frames_to_look_through(trial, views, frames)
    known = trial.calibration
    about: dict[str, Any] = {
        "frames": frames,
        "px_per_unit": known.px_per_unit if known and known.unit == animal.unit else None,
    }
    one = OneView(views, pose_view(trial))
    own = stage_parameters(trial, settings=settings)
    with given_or_bar(progress, ANIMAL_WORDS) as report, parameters_set(own):
        found = propose_pose(one, animal, background, progress=report, **about)
        parameters = parameters_of(["pose_proposal"])["pose_proposal"]
    legs = sure_table("leg", _as_tracking_sees(found, one, animal, background))
    # limbs that are in the background as well are not seen against it
    why = (background.doubt,) if background.doubt and not (legs["sure"] >= SURE_FROM).all() else ()
    return PoseStart(animal, found.pose, legs, (*found.notes, *why), parameters)


def _as_tracking_sees(
    found: PoseProposal, view: OneView, animal: StickAnimal, background: Background
) -> dict[str, float]:
    """Return how sure each leg is, and no surer than tracking from there would be of it.

    The proposal asks whether a leg lies on a limb of the outline; tracking, once it has fitted the
    pose, whether the picture is as dark along it as a leg should be. The edge of a wing is an
    outline, and no leg.
    """
    frame = view.frame(int(found.pose.frames[0]))
    try:
        pose, _ = fit_to_picture(frame, found.pose, animal=animal, background=background)
        seen = explain_fit(frame, pose, animal=animal, background=background).support
    except InputError:  # it is told when tracking starts from it
        return found.sure
    return {leg: round(min(sure, max(seen[leg], 0.0)), 3) for leg, sure in found.sure.items()}
