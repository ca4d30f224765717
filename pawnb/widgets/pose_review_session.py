"""Reviewing and correcting poses: everything the widget does, without the widget."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from pawnb.core.edits.log import Pose
from pawnb.core.pose.animal import Leg
from pawnb.core.pose.as_tracks import animal_of, poses_of
from pawnb.core.pose.corrected import pose_values
from pawnb.core.pose.pose_suspects import find_pose_suspects
from pawnb.errors import InputError
from pawnb.schema import ORIGIN_CODE, Tracks
from pawnb.trial import Trial
from pawnb.widgets.corrected_tracks import CorrectedTracks
from pawnb.widgets.stick_pose import StickPose, stick_pose
from pawnb.widgets.stick_session import StickSession, StickState
from pawnb.widgets.stretch_edits import order_partners

_LEAST_DRAG_PX, _ROUNDING_PX = 0.3, 1e-6
"""A drag that moves no joint that far is no correction: a leg at full reach that is dragged further
out settles by less and less. Keys may move them by less, on small animals."""


class PoseReviewSession(StickSession):
    """The tracked poses of one animal, each of which can be corrected.

    What a person does with the stick animal is a correction of the frame looked at, and is in
    ``edits.jsonl`` at once.

    Parameters
    ----------
    trial : Trial
        A trial of kind ``pose``.
    corrected : CorrectedTracks
        Its tracks.
    size : tuple of int
        Width and height of the view, px.
    frame : int, optional
        Frame to begin with; default the first of the tracks.

    Attributes
    ----------
    moved : bool
        Whether the last change moved anything; one that did not is no correction.

    Raises
    ------
    InputError
        If the tracks are not those of a jointed animal, or do not hold the frame.
    """

    def __init__(
        self,
        trial: Trial,
        corrected: CorrectedTracks,
        *,
        size: tuple[int, int],
        frame: int | None = None,
    ) -> None:
        self.corrected, self.moved = corrected, True
        self._least_px = _ROUNDING_PX
        super().__init__(
            trial,
            animal_of(corrected.present),
            size=size,
            span=corrected.span,
            frame=corrected.span[0] if frame is None else frame,
            path=corrected.edits,
        )
        self.saved = True
        self.go(self.frame)

    @property
    def can_undo(self) -> bool:
        """Whether there is a correction to undo."""
        return self.corrected.can_undo

    @property
    def can_redo(self) -> bool:
        """Whether an undone correction can be made again."""
        return self.corrected.can_redo

    def pose_at(self, frame: int) -> StickPose | None:
        """Return the pose of a frame; None where the animal was not found."""
        with self.corrected.lock:
            tracks = self.corrected.present
        row = int(np.flatnonzero(tracks["frame"].to_numpy() == self._checked_frame(frame))[0])
        track = poses_of(tracks.isel(time=slice(row, row + 1)))
        if not np.isfinite(track.poses.xy).all():
            return None
        pose = stick_pose(self.species, self.species, track.poses)
        for name, is_there in zip(
            self.species.leg_names, self._legs_seen(tracks, row), strict=True
        ):
            if not is_there:
                pose = pose.with_missing(name, missing=True)
        return pose

    def _legs_seen(self, tracks: Tracks, row: int) -> np.ndarray:
        """Tell which legs were not hidden or deleted in a row."""
        origin = tracks["image_origin"].isel(time=row, view=0, individual=0)
        codes = origin.sel(keypoint=list(self.species.leg_names)).to_numpy()
        return np.asarray(codes != ORIGIN_CODE["missing"])

    def partners(self) -> dict[str, list[str]]:
        """Return the legs that each leg may be mistaken for, the likeliest first.

        Those beside it on its own side, then that across; then the rest.
        """
        legs = list(self.species.legs)
        pairs = [
            (a.name, b.name)
            for i, a in enumerate(legs)
            for b in legs[i + 1 :]
            if (a.side == b.side and abs(_rank(legs, a) - _rank(legs, b)) == 1)
        ]
        pairs += [
            (a.name, b.name)
            for i, a in enumerate(legs)
            for b in legs[i + 1 :]
            if a.side != b.side and _rank(legs, a) == _rank(legs, b)
        ]
        names = [leg.name for leg in legs]
        return {name: order_partners(name, names, pairs) for name in names}

    def go(self, frame: int) -> None:
        """Look at another frame: its pose is the one that is corrected.

        Where the animal was not found, the pose looked at before is proposed.
        """
        super().go(frame)
        pose = self.pose_at(self.frame)
        self._state = (
            StickState(pose, self.frame)
            if pose is not None
            else StickState(self.pose, self.frame, "proposed")
        )

    def toggle_missing(self, leg: str | None = None) -> None:
        """Refuse: tracks have the legs they were made with."""
        raise InputError(
            f"{self._named(leg)}: the tracks were made with these legs; say in the start pose "
            "which are missing (pawnb.widgets.StickPoser), and track again."
        )

    def drag(self, handle: str, u: float, v: float, *, whole: bool = True) -> None:
        """Drag a handle; what moves nothing that can be seen is no correction.

        Parameters
        ----------
        handle : str
            The handle.
        u, v : float
            Where it is dragged to, px of the view.
        whole : bool
            Whether the whole leg follows its tip, or only the last joint turns.
        """
        self._least_px = _LEAST_DRAG_PX
        try:
            super().drag(handle, u, v, whole=whole)
        finally:
            self._least_px = _ROUNDING_PX

    def accept(self) -> None:
        """Keep the pose as it is: a correction, though it moves nothing."""
        self._record(self.pose, self.pose_frame)

    def retrack(self, frame: int) -> str:
        """Track again about a frame; returns what was done, in words."""
        said = self.corrected.retrack(frame)
        self.go(self.frame)
        return said

    def undo(self) -> bool:
        """Take back the last correction, and look at its frame; say whether there was one."""
        return self._stepped(self.corrected.undo())

    def redo(self) -> bool:
        """Make the correction that was undone last again; say whether there was one."""
        return self._stepped(self.corrected.redo())

    def save(self) -> Path:
        """Return the file of the corrections, which each of them reached as it was made."""
        return self.path

    def suspects(self) -> pd.DataFrame:
        """Return the frames that a person should look at, the most doubtful first."""
        return find_pose_suspects(self.corrected.present)

    def prompt(self) -> str:
        """Say what to do next."""
        if self.proposed:
            return "The animal was not found in this frame: drag the stick animal onto it."
        return "Step through the frames, drag what is wrong, then track again from there (R)."

    def _begin(self, frame: int | None) -> StickState:
        """Return the first pose there is."""
        poses = poses_of(self.corrected.present).poses
        known = np.flatnonzero(np.isfinite(poses.xy).all(axis=1))
        if not len(known):
            raise InputError("the animal was found in no frame of these tracks; track it first.")
        first = poses.take(known[:1])
        begin = int(first.frames[0]) if frame is None else self._checked_frame(frame)
        return StickState(stick_pose(self.species, self.species, first), begin, "proposed")

    def _change(self, pose: StickPose, *, frame: int | None = None) -> None:
        """Make the pose the correction of the frame looked at, where it moves anything."""
        where = self.frame if frame is None else frame
        self.moved = _moves(self.pose_at(where), pose, least_px=self._least_px)
        if self.moved:
            self._record(pose, where)

    def _record(self, pose: StickPose, where: int) -> None:
        """Make the pose the correction of a frame."""
        for name in self.species.leg_names:  # who poses the animal has posed every leg
            pose = pose.with_missing(name, missing=False)
        values = pose_values(self.species, pose.poses(where))
        self.corrected.apply(Pose(frame=where, pose=values))
        self.go(where)

    def _stepped(self, edit: object) -> bool:
        """Look at the frame that was corrected."""
        if edit is None:
            return False
        self.go(int(getattr(edit, "frame", self.frame)))
        return True


def _moves(before: StickPose | None, after: StickPose, *, least_px: float) -> bool:
    """Say whether a pose is another one; a leg that was hidden is there again once it is posed."""
    if before is None or any(leg.missing for leg in before.legs.values()):
        return True
    steps = [after.places(name) - before.places(name) for name in before.legs]
    steps.append(np.subtract([after.xy], [before.xy]))
    return bool(np.abs(np.concatenate(steps)).max() > least_px)


def _rank(legs: list[Leg], leg: Leg) -> int:
    """Return the place of a leg among those of its side, from the front."""
    return [one.name for one in legs if one.side == leg.side].index(leg.name)
