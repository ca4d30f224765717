"""*StickPoser*: lay a stick animal on the animal in one frame, and tracking can begin."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.background import Background
from pawnb.core.pose.energy_view import EnergyView
from pawnb.core.pose.paper_settings import PaperPoseSettings
from pawnb.core.pose.poses import Poses
from pawnb.core.video import ViewSet, open_views
from pawnb.errors import InputError, PawnbError
from pawnb.trial import Trial, load_trial
from pawnb.widgets.click_initialiser import trial_span
from pawnb.widgets.frame_canvas import MOUSE_AND_KEYS, FrameCanvas, Overlay
from pawnb.widgets.stick_layers import LAYERS, SETTINGS, EnergyLayers, in_words
from pawnb.widgets.stick_pose import LEAST_FACTOR, MOST_FACTOR, StickPose
from pawnb.widgets.stick_session import StickSession, describe
from pawnb.workflow.propose_pose import (
    PoseStart,
    pose_view,
    propose_pose_in_views,
    trial_animal,
    trial_background,
)

HANDLES = (
    ("Drag the disc", "move the body"),
    (
        "Drag a square",
        "in front: turn the body; on the far side: make the animal larger or smaller",
    ),
    (
        "Drag a dot",
        "bend the leg there; what is further out follows, and the joint's range is shown",
    ),
    ("Drag a tip", "the whole leg follows; with Ctrl only its last joint turns"),
)
_KEYS = (
    *HANDLES,
    ("[, ]", "the chosen leg 2 % shorter, longer"),
    ("M, Delete", "the chosen leg is missing, or there after all"),
    ("N", "the chosen leg back to its natural orientation"),
    ("Shift+L, Shift+R", "copy the left legs to the right side, the right ones to the left"),
    ("P, Enter", "propose a pose, accept it as it is"),
    ("F", "the pose belongs to this frame"),
    ("Ctrl+Z, Ctrl+Y", "undo, redo"),
    ("Show", "segmentation, shape prior and costs of the published method, with its settings"),
)
_LENGTH_STEP = 1.02


class StickPoser(FrameCanvas):
    """Pose a stick animal over one frame of a trial.

    Body, heading, size, joints and tips are dragged; a joint beyond its range is red, and the
    range of a joint in the hand is shown as a wedge. Ranges are advice: nothing stops at them.
    Every change is written to ``start_pose.csv`` at once.

    Parameters
    ----------
    trial : Trial, str or Path
        A trial of kind ``pose``, its ``trial.toml``, or the folder that holds it. Its first
        view is posed.
    frame : int, optional
        Frame to begin with; default that of the pose there is, else the first.
    propose : bool or PoseStart
        Whether to begin with a proposal (drawn dashed, and not written before it is accepted
        or changed), or one that was made before with :func:`pawnb.propose_start`.
    **options
        ``path`` (file for the pose; default the trial's ``[start] pose``, else
        ``start_pose.csv`` beside the trial), ``views`` (when they are open already),
        ``session`` (one that was made before), and the options of :class:`FrameCanvas`.

    Attributes
    ----------
    session : StickSession
        The pose; works without a browser.
    layers : EnergyLayers
        What the published method makes of the picture, shown on demand, and the settings tried.

    Raises
    ------
    InputError
        If the trial names no species, or its video, species or pose cannot be used.
    """

    def __init__(
        self,
        trial: Trial | str | Path,
        *,
        frame: int | None = None,
        propose: bool | PoseStart = False,
        path: str | Path | None = None,
        views: ViewSet | None = None,
        session: StickSession | None = None,
        **options: Any,
    ) -> None:
        trial = trial if isinstance(trial, Trial) else load_trial(trial)
        self.trial = trial
        shown = open_views(trial) if views is None else views
        self._own_views = shown if views is None else None
        self._shown = shown
        self.view = pose_view(trial)
        self._background: Background | None = None
        self.layers = EnergyLayers()
        self.session = session or self._new_session(frame, path)
        if propose:
            self._propose(propose if isinstance(propose, PoseStart) else None)
        super().__init__(shown, frame=self.session.frame, span=self.session.span, **options)
        self.label = "Pose the stick animal"
        self.keys_help = [list(line) for line in (*_KEYS, *MOUSE_AND_KEYS)]
        self.tell_selected = True
        self._show_state()
        self.observe(self._look_at, names="frame")

    def _new_session(self, frame: int | None, path: str | Path | None) -> StickSession:
        """Return a session on the trial's start pose."""
        reader = self._shown.readers[self.view]
        return StickSession(
            self.trial,
            trial_animal(self.trial),
            size=(reader.width, reader.height),
            span=trial_span(self.trial, self._shown),
            frame=frame,
            path=path,
        )

    @property
    def start(self) -> Poses:
        """The pose so far, as a tracker takes it for ``start``."""
        return self.session.poses()

    @property
    def animal(self) -> StickAnimal:
        """The animal with its own legs and proportions."""
        return self.session.animal()

    def overlay(self, frame: int) -> Overlay:
        """Return what is drawn over a frame: the stick animal, and a button for each leg."""
        session = self.session
        pose, is_proposed = self._pose_shown(frame)
        stick = describe(session, pose) | {"dashed": is_proposed}
        chips = []
        for name, colour in session.colours.items():
            missing = session.pose.legs[name].missing
            words = "missing" if missing else f"length {session.pose.length_of(name):.2f}"
            state = "hidden" if missing else "open" if stick["dashed"] else "done"
            chips.append(
                {"id": name, "state": state, "title": f"{name}: {words}", "colour": colour}
            )
        here: dict[str, Any] = {"stick": stick, "chips": chips}
        told: Overlay = {"views": {self.view: here}, "current": [self.view, session.leg]}
        if frame == session.frame and (view := self._energy()) is not None:
            here["tint"] = self.layers.tint(view)
            told["caption"] = f"energy {view.energy:.0f}"
        return told

    def _pose_shown(self, frame: int) -> tuple[StickPose, bool]:
        """Return the pose drawn over a frame, and whether it is only proposed there."""
        session = self.session
        return session.pose, session.proposed or frame != session.pose_frame

    def edit(self, what: str, message: Mapping[str, Any]) -> int | None:
        """Do what a person did; see :meth:`FrameCanvas.edit`."""
        session, before = self.session, int(message["frame"])
        session.go(before)
        point = message.get("point")
        if what == "moved":
            whole = bool(message.get("whole", True))
            session.drag(str(point), float(message["u"]), float(message["v"]), whole=whole)
        elif what == "select":
            session.select(str(point))
        elif what == "hide" and str(point).split(".")[0] in session.colours:
            session.toggle_missing(str(point).split(".")[0])
        elif what == "action":
            self._act(str(message["action"]), message.get("value"))
        self._show_state()
        return session.frame if session.frame != before else None

    def close(self) -> None:
        """Take the widget away and close the videos it opened."""
        super().close()
        if (own := getattr(self, "_own_views", None)) is not None:
            own.close()

    def background(self) -> Background:
        """Return the empty scene, looked for once."""
        if self._background is None:
            self._background = trial_background(self.trial, self._shown)
        return self._background

    def _propose(self, proposal: PoseStart | None = None) -> None:
        """Offer a proposal, and say in words how sure it is."""
        if proposal is None:
            proposal = propose_pose_in_views(
                self.trial, self._shown, background=self.background(), progress=_silent
            )
        unsure = proposal.legs[proposal.legs["sure"] < 0.5]
        doubtful = [f"{row.leg} {row.words}" for row in unsure.itertuples()]
        notes = (f"{', '.join(doubtful)}." if doubtful else "All legs are sure.", *proposal.notes)
        self.session.propose(proposal.animal, proposal.pose, notes=notes)

    def _act(self, action: str, value: Any) -> None:
        """Do what a button, a key or a slider asks for."""
        session = self.session
        simple: dict[str, Callable[[], object]] = {
            "accept": session.accept,
            "undo": session.undo,
            "redo": session.redo,
            "missing": session.toggle_missing,
            "natural": session.reset_leg,
            "here": session.pose_here,
            "propose": self._propose,
            "from_left": lambda: session.mirror("left"),
            "from_right": lambda: session.mirror("right"),
            "longer": lambda: session.set_length(
                session.pose.length_of(session.leg) * _LENGTH_STEP
            ),
            "shorter": lambda: session.set_length(
                session.pose.length_of(session.leg) / _LENGTH_STEP
            ),
        }
        if action == "length":
            session.set_length(float(value))
        elif action == "layer":
            self.layers.show("" if value == "nothing" else str(value))
        elif action == "estimate":
            self.layers.reset()
        elif action in SETTINGS:
            self.layers.set(action, float(value))
        elif action in simple:
            simple[action]()
        else:
            raise InputError(f"{action} is no action of this widget.")

    def _energy(self) -> EnergyView | None:
        """Return the energy of the pose in the frame looked at, where a layer of it is shown."""
        if not self.layers.layer:
            return None
        picture = self._shown.frame(self.session.frame)[self.view].image()
        try:
            return self.layers.look(self.session, picture, self.background())
        except PawnbError as error:  # a frame without the animal: nothing to explain
            self.layers.show("")
            self.alarm = str(error)
            return None

    @property
    def settings(self) -> PaperPoseSettings:
        """The settings tried, as ``pawnb.track(..., method="paper")`` takes them."""
        return self.layers.settings

    def _look_at(self, change: Mapping[str, Any]) -> None:
        """Say whose frame this is once a person has gone to another."""
        with self._edit_lock:
            if change["new"] != self.session.frame:
                self.session.go(int(change["new"]))
                self._show_state()
                if self.layers.layer:
                    self.refresh()

    def _show_state(self, said: str = "", *, busy: bool = False) -> None:
        """Say what was done or is to be done, and which buttons can be pressed."""
        session = self.session
        told = f"{said or session.prompt()}\n{session.remarks()} {self._kept()}"
        view = self._energy()
        self.status = told if view is None else f"{told}\n{in_words(view)}"
        leg = session.leg
        length = round(session.pose.length_of(leg), 3)
        self.sliders = [
            {"id": "length", "text": f"Length of {leg}", "min": LEAST_FACTOR, "max": 2.0,
             "step": 0.01, "value": min(length, MOST_FACTOR),
             "title": "Times the length in the species file ([ and ])"},
            *self.layers.sliders(),
        ]  # fmt: skip
        shown = LAYERS.get(self.layers.layer, "nothing")
        layers = {"id": "layer", "text": f"Show: {shown}",
                  "title": "What the published method makes of the picture",
                  "options": [["nothing", "Nothing"], *map(list, LAYERS.items())]}  # fmt: skip
        actions = [*self._own_actions(busy=busy), layers]
        if self.layers.chosen:
            again = {"id": "estimate", "text": "Estimate settings",
                     "title": "Let every setting be estimated from the picture again"}  # fmt: skip
            actions.append(again)
        for action in actions:
            action["enabled"] = action.get("enabled", True) and (not busy or action["id"] == "stop")
        self.actions = actions

    def _kept(self) -> str:
        """Say where the pose is kept."""
        session = self.session
        return f"Saved in {session.path.name}." if session.saved else "Not saved yet."

    def _own_actions(self, *, busy: bool) -> list[dict[str, Any]]:  # noqa: ARG002 (for a review)
        """Return the buttons and menus, before those of the layers."""
        return stick_actions(self.session)


def stick_actions(session: StickSession) -> list[dict[str, Any]]:
    """Return the buttons that change a pose, and their keys.

    Parameters
    ----------
    session : StickSession
        The pose.

    Returns
    -------
    list of dict
        id, text, keys, title, enabled; see ``static/frame_canvas.js``.
    """
    leg = session.leg
    lost = session.pose.legs[leg].missing
    actions: list[dict[str, Any]] = [
        {"id": "propose", "text": "Propose", "keys": ["p"],
         "title": "Find the animal by its outline and lay the stick animal on it (P)"},
        {"id": "from_left", "text": "Mirror left → right", "keys": ["Shift+L"],
         "title": "Bend the right legs like the left ones (Shift+L)"},
        {"id": "from_right", "text": "Mirror right → left", "keys": ["Shift+R"],
         "title": "Bend the left legs like the right ones (Shift+R)"},
        {"id": "missing", "text": f"{leg} is there" if lost else f"{leg} is missing",
         "keys": ["m"], "title": "The animal has lost the chosen leg, or has it after all (M)"},
        {"id": "natural", "text": f"Straighten {leg}", "keys": ["n"],
         "title": "Put the chosen leg at its natural orientation (N)"},
        {"id": "undo", "text": "Undo", "keys": ["Ctrl+z"], "enabled": session.can_undo,
         "title": "Take back the last change (Ctrl+Z)"},
        {"id": "redo", "text": "Redo", "keys": ["Ctrl+y", "Ctrl+Shift+Z"],
         "enabled": session.can_redo, "title": "Make it again (Ctrl+Y)"},
        {"id": "shorter", "text": "Shorter", "keys": ["["], "title": f"{leg} 2 % shorter ([)"},
        {"id": "longer", "text": "Longer", "keys": ["]"], "title": f"{leg} 2 % longer (])"},
    ]  # fmt: skip
    if session.frame != session.pose_frame:
        here = {"id": "here", "text": "Pose this frame", "keys": ["f"],
                "title": "The pose belongs to the frame looked at (F)"}  # fmt: skip
        actions.insert(0, here)
    elif session.proposed:
        accept = {"id": "accept", "text": "Accept", "keys": ["Enter"],
                  "title": "Take the proposed pose as it is (Enter)"}  # fmt: skip
        actions.insert(0, accept)
    return actions


def _silent(_done: int, _total: int) -> None:
    """Show no progress: the widget says when the proposal is there."""
