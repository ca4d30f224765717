"""Posing a stick animal: everything the widget does, without the widget.

Each change is written to ``start_pose.csv`` at once, so nothing is lost when the browser or
the kernel ends. A proposal is written only when it is accepted or changed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

from pawnb.core.pose.animal import LEFT, RIGHT, StickAnimal
from pawnb.core.pose.pose_table import read_start_pose, write_start
from pawnb.core.pose.poses import Poses, join_poses, natural_pose
from pawnb.errors import InputError
from pawnb.io.pose import films_of_poses
from pawnb.trial import Trial
from pawnb.widgets.draft import Draft
from pawnb.widgets.stick_pose import StickPose, stick_pose
from pawnb.workflow.export.colours import point_colours

_SIDE_SIGNS = {"left": LEFT, "right": RIGHT}
_USUAL_SHARE = 0.5
"""Leg span of a first pose as a share of the picture's shorter side, where no scale is known."""


@dataclass(frozen=True)
class StickState:
    """A pose, the frame it belongs to, and who made it: what undo goes back to.

    ``others`` are the poses that start the tracking in further frames.
    """

    pose: StickPose
    frame: int
    origin: Literal["first", "proposed", "person"] = "person"
    others: Mapping[int, StickPose] = field(default_factory=dict)


class StickSession(Draft[StickState]):
    """The pose of one animal in one frame of a trial, or in several.

    One pose at a time is changed: that of the frame looked at where it has one. The animal's
    proportions and missing legs are the same in all.

    Parameters
    ----------
    trial : Trial
        A trial of kind ``pose``.
    species : StickAnimal
        The animal as its species file describes it.
    size : tuple of int
        Width and height of the view, px.
    span : tuple of int
        First and last frame that can be posed.
    frame : int, optional
        Frame to begin with; default that of the file, else the first.
    path : str or Path, optional
        Where the pose goes; default the trial's ``[start] pose``, else ``start_pose.csv``
        beside the trial.
    film : str, optional
        Code of the view's film, kept beside its poses: another film may be put there later.

    Attributes
    ----------
    film : str
        Code of the view's film.
    frame : int
        The frame looked at.
    leg : str
        The leg that buttons and keys are about.
    notes : tuple of str
        What came with a proposal, in sentences.

    Raises
    ------
    InputError
        If the pose in the file does not fit the animal, or the frame is not in the trial.
    """

    def __init__(
        self,
        trial: Trial,
        species: StickAnimal,
        *,
        size: tuple[int, int],
        span: tuple[int, int],
        frame: int | None = None,
        path: str | Path | None = None,
        film: str = "",
    ) -> None:
        super().__init__(
            Path(path) if path else trial.path(trial.start_pose or "start_pose.csv"), span
        )
        self.film, self._earlier_films = film, films_of_poses(self.path)
        self.trial, self.species, self.size = trial, species, size
        self.colours = point_colours(species.leg_names)
        self.leg = species.leg_names[0]
        self.notes: tuple[str, ...] = ()
        self._state = self._begin(frame)
        self.saved = self._state.origin == "person"  # as its file has it
        self.frame = self._state.frame
        if frame is not None:
            StickSession.go(self, frame)

    # --- what there is --------------------------------------------------------------------

    @property
    def pose(self) -> StickPose:
        """The pose."""
        return self._state.pose

    @property
    def pose_frame(self) -> int:
        """The frame that the pose belongs to."""
        return self._state.frame

    @property
    def proposed(self) -> bool:
        """Whether the pose is a proposal that nobody has accepted or changed."""
        return self._state.origin == "proposed"

    @property
    def posed_frames(self) -> list[int]:
        """The frames that have a pose, ascending."""
        return sorted({self.pose_frame, *self._state.others})

    def poses(self) -> Poses:
        """Return all poses as :func:`.tracker.track_pose` takes them to start."""
        every = {**self._state.others, self.pose_frame: self.pose}
        return join_poses(
            [pose.built_like(self.pose).poses(frame) for frame, pose in sorted(every.items())]
        )

    def animal(self) -> StickAnimal:
        """Return the animal with its own legs and proportions."""
        return self.pose.animal()

    # --- what a person does ---------------------------------------------------------------

    def go(self, frame: int) -> None:
        """Look at another frame: its pose is the one to change, where it has one.

        Elsewhere the pose looked at before stays where it belongs until it is changed.
        """
        self.frame = self._checked_frame(frame)
        if self.frame in self._state.others:
            self._state = self._moved_on(self.frame)

    def select(self, leg: str) -> None:
        """Choose the leg that buttons and keys are about; a joint chooses its leg."""
        self.leg = self.species.leg(leg.split(".")[0]).name

    def drag(self, handle: str, u: float, v: float, *, whole: bool = True) -> None:
        """Drag a handle of the stick animal; see :meth:`StickPose.drag`.

        Parameters
        ----------
        handle : str
            The handle.
        u, v : float
            Where it is dragged to, px of the view.
        whole : bool
            Whether the whole leg follows its tip, or only the last joint turns.
        """
        if handle == "body":
            width, height = self.size
            if not (-0.5 <= u < width - 0.5 and -0.5 <= v < height - 0.5):
                raise InputError(
                    f"the body at ({u:.1f}, {v:.1f}) is outside the picture "
                    f"({width} x {height} px); drag it inside."
                )
        elif handle not in ("heading", "span"):
            self.select(handle)
        self._change(self.pose.drag(handle, u, v, whole=whole))

    def set_length(self, factor: float, leg: str | None = None) -> None:
        """Set the factor of a leg's length; see :meth:`StickPose.lengthened`."""
        self._change(self.pose.lengthened(self._named(leg), factor))

    def toggle_missing(self, leg: str | None = None) -> None:
        """Say that a leg is missing, or there after all."""
        name = self._named(leg)
        self._change(self.pose.with_missing(name, missing=not self.pose.legs[name].missing))

    def reset_leg(self, leg: str | None = None) -> None:
        """Put a leg at its natural orientation."""
        self._change(self.pose.straightened(self._named(leg)))

    def mirror(self, source: str) -> None:
        """Copy the legs of the ``left`` or the ``right`` side to the other."""
        if source not in _SIDE_SIGNS:
            raise InputError(f"mirror from {source!r}: expected left or right.")
        self._change(self.pose.mirrored(_SIDE_SIGNS[source]))

    def pose_here(self) -> None:
        """Say that the pose belongs to the frame looked at."""
        self._change(self.pose)

    def pose_here_too(self) -> None:
        """Say that the frame looked at has a pose as well: the same, until it is changed."""
        if self.frame != self.pose_frame:
            others = {**self._state.others, self.pose_frame: self.pose}
            self._make(StickState(self.pose, self.frame, others=others))

    def drop(self) -> None:
        """Take the pose of the frame looked at out of the start; raises for the only one."""
        others = self._state.others
        if self.frame != self.pose_frame or not others:
            raise InputError("a start needs at least one pose.")
        nearest = min(others, key=lambda frame: (abs(frame - self.frame), frame))
        self._make(replace(self._moved_on(nearest), others=_without(others, nearest)))

    def propose(self, animal: StickAnimal, pose: Poses, *, notes: tuple[str, ...] = ()) -> None:
        """Offer a pose of one frame to accept or change, and look at it.

        Parameters
        ----------
        animal : StickAnimal
            The animal, with its own proportions.
        pose : Poses
            Its pose in one frame.
        notes : tuple of str
            What a person should know of the proposal.
        """
        frame = self._checked_frame(int(pose.frames[0]))
        others = _without(self._state.others, frame)
        self._make(StickState(stick_pose(self.species, animal, pose), frame, "proposed", others))
        self.frame, self.notes = frame, notes

    def take(self, animal: StickAnimal, pose: Poses) -> None:
        """Take over a pose of the frame that the pose belongs to, such as a fitted one."""
        self._change(stick_pose(self.species, animal, pose), frame=self.pose_frame)

    def calibrated(self, trial: Trial) -> None:
        """Take over a trial whose scale was measured; a pose that nobody made yet follows."""
        self.trial = trial
        if self._state.origin == "first":
            self._state = self._first(self.pose_frame)

    def accept(self) -> None:
        """Take a proposal as it is."""
        self._change(self.pose, frame=self.pose_frame)

    # --- in words -------------------------------------------------------------------------

    def prompt(self) -> str:
        """Say what to do next."""
        if self.frame != self.pose_frame:
            return (
                f"{self._where()} Drag anything, or press F, to pose this frame instead; press "
                "Shift+F to start from this frame, too."
            )
        if self.proposed:
            return "This pose is proposed: drag what is wrong, or press Enter to accept it."
        if self._state.origin == "first":
            return "Press P for a proposal, or drag the stick animal onto the animal."
        drag = "Drag the joints until the stick animal lies on the animal."
        return f"{drag} {self._where()}" if self._state.others else drag

    def remarks(self) -> str:
        """Say what looks wrong, or that nothing does."""
        over = sorted(self.pose.beyond().items(), key=lambda item: -item[1])
        parts = []
        if over:
            named = ", ".join(f"{name} by {by:.0f}°" for name, by in over[:4])
            more = f" and {len(over) - 4} more" if len(over) > 4 else ""
            parts.append(f"Beyond their range: {named}{more}.")
        lost = [name for name, pose in self.pose.legs.items() if pose.missing]
        if lost:
            parts.append(f"Missing: {', '.join(lost)}.")
        outside = [name for name in self.colours if name not in lost and self._outside(name)]
        if outside:
            parts.append(f"Reaching out of the picture: {', '.join(outside)}.")
        if self.proposed:
            parts += self.notes
        return " ".join(parts) or "All joints are within their range."

    def _where(self) -> str:
        """Say which frames have poses."""
        if not self._state.others:
            return f"The pose belongs to frame {self.pose_frame}."
        *most, last = self.posed_frames
        return f"Frames {', '.join(map(str, most))} and {last} have poses to start from."

    # --- inside ---------------------------------------------------------------------------

    def _outside(self, leg: str) -> bool:
        """Say whether a leg's tip is outside the picture."""
        u, v = self.pose.places(leg)[-1]
        width, height = self.size
        return not (-0.5 <= u < width - 0.5 and -0.5 <= v < height - 0.5)

    def _begin(self, frame: int | None) -> StickState:
        """Return the pose to begin with."""
        return self._read() if self.path.exists() else self._first(frame)

    def _first(self, frame: int | None) -> StickState:
        """Return a natural pose in the middle of the picture."""
        width, height = self.size
        known = self.trial.calibration
        scale = _USUAL_SHARE * min(width, height) / self.species.span
        if known is not None and known.px_per_unit is not None and known.unit == self.species.unit:
            scale = known.px_per_unit
        pose = natural_pose(self.species, xy=((width - 1) / 2, (height - 1) / 2), scale=scale)
        first = self.span[0] if frame is None else frame
        return StickState(
            stick_pose(self.species, self.species, pose), self._checked_frame(first), "first"
        )

    def _read(self) -> StickState:
        """Return the poses in the file; that of its first frame is the one to change."""
        animal, poses = read_start_pose(self.path, self.species)
        every = {
            self._checked_frame(int(poses.frames[k])): stick_pose(
                self.species, animal, poses.take([k])
            )
            for k in range(len(poses))
        }
        first = min(every)
        return StickState(every[first], first, others=_without(every, first))

    def _moved_on(self, frame: int) -> StickState:
        """Return the state in which the pose of another frame that has one is changed."""
        state = self._state
        others = dict(state.others)
        if state.origin == "person":  # a proposal that nobody took is let go
            others[state.frame] = state.pose
        pose = others.pop(frame).built_like(state.pose)
        return StickState(pose, frame, others=others)

    def _change(self, pose: StickPose, *, frame: int | None = None) -> None:
        """Take over a new pose and save it; it belongs to the frame looked at."""
        where = self.frame if frame is None else frame
        self._make(StickState(pose, where, others=_without(self._state.others, where)))

    def _write(self) -> None:
        write_start(
            self.path, self.animal(), self.poses(), species=self.species, film=self.film,
            earlier_films=self._earlier_films,
        )  # fmt: skip

    def _keep(self, state: StickState) -> bool:
        """Say yes to poses that a person made: the file keeps these."""
        return state.origin == "person"

    def _look_at_change(self, before: StickState) -> None:  # noqa: ARG002 (the frame tells)
        self.frame = self.pose_frame

    def _named(self, leg: str | None) -> str:
        return self.leg if leg is None else self.species.leg(leg).name


def _without(poses: Mapping[int, StickPose], frame: int) -> dict[int, StickPose]:
    """Return poses of other frames than one."""
    return {other: pose for other, pose in poses.items() if other != frame}
