"""The second view of a trial of a jointed animal: its joints in space."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pawnb.core.frame_checkpoint import KeptFrames
from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.background import find_background
from pawnb.core.pose.space.first_view import corrected_first_view
from pawnb.core.pose.space.geometry import SightLines, check_second_view
from pawnb.core.pose.space.settings import SpaceSettings
from pawnb.core.pose.space.track import SpaceTrack
from pawnb.core.pose.space.tracker import place_in_space
from pawnb.core.pose.track_result import PoseTrack
from pawnb.core.rig import Rig, load_rig
from pawnb.core.sightlines import find_look_point
from pawnb.core.video import ViewReader, ViewSet
from pawnb.core.video.views import Frame
from pawnb.trial import Trial
from pawnb.workflow.progress import Progress, tracking_progress


class ShiftedReader:
    """The frames of a view by their numbers in the trial.

    Parameters
    ----------
    reader : ViewReader
        The view.
    offset : int
        Its file's frame that belongs to frame 0 of the trial.
    """

    def __init__(self, reader: ViewReader, offset: int) -> None:
        self._reader, self._offset = reader, offset
        self.width, self.height = reader.width, reader.height

    def frame(self, index: int) -> Frame:
        """Return a frame of the trial."""
        return self._reader.frame(index + self._offset)


def load_second(trial: Trial, views: ViewSet) -> Rig | None:
    """Return the rig of a trial with a second view, in the pixels of its views.

    Parameters
    ----------
    trial : Trial
        A trial of kind ``pose``.
    views : ViewSet
        Its open views.

    Returns
    -------
    Rig or None
        None where there is one view only.

    Raises
    ------
    CalibrationError
        If the calibration cannot be read, or both views look in nearly the same direction.
    """
    if len(trial.views) < 2:
        return None
    sizes = {name: (r.source.width, r.source.height) for name, r in views.readers.items()}
    rig = load_rig(trial, sizes=sizes)
    if rig is not None:
        lines = SightLines(rig.coefs[:, 0], find_look_point(rig.coefs), np.array(rig.up))
        check_second_view(lines, rig.coefs[:, 1], (rig.names[0], rig.names[1]))
    return rig


def find_in_space(
    trial: Trial,
    views: ViewSet,
    track: PoseTrack,
    *,
    animal: StickAnimal,
    rig: Rig,
    settings: SpaceSettings,
    rows: range | None = None,
    progress: Progress | None = None,
    stop: Callable[[], bool] | None = None,
    kept: KeptFrames | None = None,
) -> tuple[SpaceTrack, PoseTrack]:
    """Find joints in space from poses in the first view and the pictures of the second.

    Parameters
    ----------
    trial : Trial
        A trial with two views.
    views : ViewSet
        Its open views.
    track : PoseTrack
        Poses in the first.
    animal : StickAnimal
        The animal.
    rig : Rig
        The calibrated views.
    settings : SpaceSettings
        Settings; see there.
    rows : range, optional
        Rows of the track in which joints are wanted; default all.
    progress, stop
        As for :func:`pawnb.track`.
    kept : KeptFrames, optional
        What an interrupted run has found, and what this one finds.

    Returns
    -------
    space : SpaceTrack
        One row for every frame of the track; NaN in those that are not wanted.
    track : PoseTrack
        The poses in the first view, corrected by them unless ``settings`` say otherwise.

    Raises
    ------
    CalibrationError, InputError
        If the second view does not serve: see :func:`place_in_space`.
    """
    first, second = trial.views
    reader = views.readers[second.name]
    background = find_background(reader, second, folder=trial.folder)
    with tracking_progress(progress, "joints in space", kind="space") as report:
        space = place_in_space(
            ShiftedReader(reader, second.offset),
            track,
            animal=animal,
            rig=rig,
            views=(first.name, second.name),
            first_size=(views.readers[first.name].width, views.readers[first.name].height),
            background=background,
            settings=settings,
            rows=rows,
            progress=report,
            stop=stop,
            kept=kept,
        )
    if not settings.correct_first:
        return space, track
    coefs = rig.coefs[:, rig.names.index(first.name)]
    return space, corrected_first_view(animal, track, space, coefs=coefs, settings=settings)
