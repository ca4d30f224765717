"""*StickPoser*: lay a stick animal on the animal in one frame, and tracking can begin."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.background import Background
from pawnb.core.pose.fit.explanation import fit_to_picture
from pawnb.core.pose.fit.settings import PoseSettings
from pawnb.core.pose.poses import Poses
from pawnb.core.pose.pullar2009.settings import Pullar2009Settings
from pawnb.core.video import ViewSet, open_views
from pawnb.core.video.doubts.exchanged_films import film_code
from pawnb.errors import InputError, PawnbError
from pawnb.trial import Trial
from pawnb.widgets.background_work import said_in_status
from pawnb.widgets.click_initialiser import trial_span
from pawnb.widgets.fit_layers import FitLayers
from pawnb.widgets.frame_canvas import NO_PLACING, FrameCanvas, Overlay
from pawnb.widgets.opened_trial import open_trial
from pawnb.widgets.picture_layers import PictureLayers
from pawnb.widgets.scale_clicks import ScaleClicks
from pawnb.widgets.stick_actions import KEYS, stick_actions
from pawnb.widgets.stick_drawing import describe
from pawnb.widgets.stick_layers import EnergyLayers
from pawnb.widgets.stick_pose import LEAST_FACTOR, MOST_FACTOR, StickPose
from pawnb.widgets.stick_session import StickSession
from pawnb.workflow.calibration.scale import write_scale
from pawnb.workflow.start.propose_pose import (
    ANIMAL_WORDS,
    SCENE_WORDS,
    PoseStart,
    pose_view,
    propose_pose_in_views,
    trial_animal,
    trial_background,
)
from pawnb.workflow.start.start_doubts import tell_other_film
from pawnb.workflow.start.sureness import SURE_FROM

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
    fits : FitLayers
        What the default method sees and would paint, shown on demand, and the settings tried.
    layers : EnergyLayers
        The same of the published method.
    measuring : ScaleClicks or None
        The two clicks of a scale, while they are made.

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
        trial = open_trial(trial)
        self.trial = trial
        shown = open_views(trial, share_memory=True) if views is None else views
        self._own_views = shown if views is None else None
        self._shown = shown
        self.view = pose_view(trial)
        self._background: Background | None = None
        self.fits, self.layers = FitLayers(), EnergyLayers()
        self.measuring: ScaleClicks | None = None
        self.session = session or self._new_session(frame, path)
        self._other_film = "".join(
            f"⚠ {text}.\n"
            for text in tell_other_film(self.session.path, view=self.view, film=self.session.film)
        )
        if propose:
            self._propose(propose if isinstance(propose, PoseStart) else None)
        super().__init__(shown, frame=self.session.frame, span=self.session.span, **options)
        self.label = "Pose the stick animal"
        self.keys_help = [list(line) for line in (*KEYS, *NO_PLACING)]
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
            film=film_code(reader.source),
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
        if self.measuring is not None:
            told["views"] = {self.view: self.measuring.marks()}
        elif frame == session.frame and (seen := self._look()) is not None:
            shown, view = seen
            here["tint"], told["caption"] = shown.tint(view), shown.caption(view)
        return told

    def plain_legs(self, frame: int) -> dict[str, list[tuple[np.ndarray, str]]]:
        """Return the legs of the stick animal for the plain picture."""
        pose, _ = self._pose_shown(frame)
        colours = self.session.colours
        there = [name for name in colours if not pose.legs[name].missing]
        return {self.view: [(pose.places(name), colours[name]) for name in there]}

    def _pose_shown(self, frame: int) -> tuple[StickPose, bool]:
        """Return the pose drawn over a frame, and whether it is only proposed there."""
        session = self.session
        return session.pose, session.proposed or frame != session.pose_frame

    def edit(self, what: str, message: Mapping[str, Any]) -> int | None:
        """Do what a person did; see :meth:`FrameCanvas.edit`."""
        session, before = self.session, int(message["frame"])
        session.go(before)
        point = message.get("point")
        if self.measuring is not None and what in ("click", "moved"):
            self._measure(what, message)
        elif what == "moved":
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
            with said_in_status(self, SCENE_WORDS) as progress:
                self._background = trial_background(self.trial, self._shown, progress=progress)
        return self._background

    def _propose(self, proposal: PoseStart | None = None) -> None:
        """Offer a proposal, and say in words how sure it is."""
        if proposal is None:
            background = self.background()
            with said_in_status(self, ANIMAL_WORDS) as progress:
                proposal = propose_pose_in_views(
                    self.trial, self._shown, background=background, progress=progress
                )
        unsure = proposal.legs[proposal.legs["sure"] < SURE_FROM]
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
            "here_too": session.pose_here_too,
            "drop": session.drop,
            "propose": self._propose,
            "fit": self._fit,
            "scale": self._toggle_measuring,
            "use_scale": self._use_scale,
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
            for layers in (self.fits, self.layers):
                layers.show(str(value) if value in layers.names else "")
        elif action == "estimate":
            self._shown_layers().reset()
        elif action == "known_length" and self.measuring is not None:
            self.measuring.set_length(float(value))
        elif action in (shown := self._shown_layers()).sliders_of:
            shown.set(action, float(value))
        elif action in simple:
            simple[action]()
        else:
            raise InputError(f"{action} is no action of this widget.")

    def _fit(self) -> None:
        """Fit the pose to the frame that it belongs to."""
        session = self.session
        frame = self._shown.frame(session.pose_frame)[self.view]
        animal = session.animal()
        pose, _ = fit_to_picture(
            frame,
            session.pose.poses(session.pose_frame),
            animal=animal,
            background=self.background(),
            settings=self.fit_settings,
        )
        session.take(animal, pose)

    def _toggle_measuring(self) -> None:
        """Begin to measure the scale, or leave it."""
        self.measuring = ScaleClicks() if self.measuring is None else None

    def _measure(self, what: str, message: Mapping[str, Any]) -> None:
        """Place an end of the known length."""
        if self.measuring is None:
            return
        u, v = float(message["u"]), float(message["v"])
        if what == "click":
            self.measuring.click(u, v)
        else:
            self.measuring.move(str(message["point"]), u, v)

    def _use_scale(self) -> None:
        """Write the measured scale into the trial; a pose that nobody made yet takes it."""
        found = None if self.measuring is None else self.measuring.result()
        if found is None:
            raise InputError("click both ends of a known length first.")
        self.trial = write_scale(self.trial, found.px_per_unit)
        self.session.calibrated(self.trial)
        self.measuring = None

    def _shown_layers(self) -> PictureLayers[Any, Any]:
        """Return the layers of the method that is shown; those of the default where none is."""
        return self.layers if self.layers.layer else self.fits

    def _look(self) -> tuple[PictureLayers[Any, Any], Any] | None:
        """Return what a method makes of the pose in the frame looked at, where it is shown."""
        shown = self._shown_layers()
        if not shown.layer or self.measuring is not None:
            return None
        frame = self._shown.frame(self.session.frame)[self.view]
        picture = frame.image() if shown is self.layers else frame
        try:
            return shown, shown.look(self.session, picture, self.background())
        except PawnbError as error:  # a frame without the animal: nothing to explain
            shown.show("")
            self.alarm = str(error)
            return None

    @property
    def settings(self) -> Pullar2009Settings:
        """The settings tried, as ``pawnb.track(..., method="paper")`` takes them."""
        return self.layers.settings

    @property
    def fit_settings(self) -> PoseSettings:
        """The settings tried, as ``pawnb.track(..., method="pawnb")`` takes them."""
        return self.fits.settings

    def _look_at(self, change: Mapping[str, Any]) -> None:
        """Say whose frame this is once a person has gone to another."""
        with self._edit_lock:
            if change["new"] != self.session.frame:
                self.session.go(int(change["new"]))
                self._show_state()
                if self._shown_layers().layer:
                    self.refresh()

    def _show_state(self, said: str = "", *, busy: bool = False) -> None:
        """Say what was done or is to be done, and which buttons can be pressed."""
        session = self.session
        if self.measuring is not None:
            self._show_measuring(self.measuring)
            return
        told = f"{said or session.prompt()}\n{self._other_film}{session.remarks()} {self._kept()}"
        seen = self._look()
        leg, layers = session.leg, self._shown_layers()
        length = round(session.pose.length_of(leg), 3)
        self.sliders = [
            {"id": "length", "text": f"Length of {leg}", "min": LEAST_FACTOR, "max": 2.0,
             "step": 0.01, "value": min(length, MOST_FACTOR),
             "title": "Times the length in the species file ([ and ])"},
            *layers.sliders(),
        ]  # fmt: skip
        choices = self.fits.names | self.layers.names
        menu = {"id": "layer", "text": f"Show: {choices.get(layers.layer, 'nothing')}",
                "title": "What the default and the published method (2009) make of the picture",
                "options": [["nothing", "Nothing"], *map(list, choices.items())]}  # fmt: skip
        actions = [*self._own_actions(busy=busy), menu]
        if layers.chosen:
            again = {"id": "estimate", "text": "Usual settings",
                     "title": "Every setting as it was, or as the picture says"}  # fmt: skip
            actions.append(again)
        for action in actions:
            action["enabled"] = action.get("enabled", True) and (not busy or action["id"] == "stop")
        self._tell(told if seen is None else f"{told}\n{seen[0].in_words(seen[1])}", actions)

    def _show_measuring(self, measuring: ScaleClicks) -> None:
        """Say what to click for the scale."""
        calibration = self.trial.calibration
        unit = "mm" if calibration is None else calibration.unit
        found = measuring.result()
        words = "" if found is None else f"\n{found.text(unit)}."
        self.sliders = [
            {"id": "known_length", "text": f"Known length, {unit}", "number": True, "min": 0,
             "max": None, "step": "any", "value": measuring.length,
             "title": "How far apart the two ends are"},
        ]  # fmt: skip
        actions: list[dict[str, Any]] = [
            {"id": "use_scale", "text": "Use this scale", "keys": ["Enter"],
             "enabled": found is not None, "title": "Write px_per_unit into trial.toml (Enter)"},
            {"id": "scale", "text": "Leave", "keys": ["c"], "title": "Keep the scale as it is (C)"},
        ]  # fmt: skip
        self._tell(f"{measuring.prompt(unit)}{words}", actions)

    def _kept(self) -> str:
        """Say where the pose is kept."""
        session = self.session
        return f"Saved in {session.path.name}." if session.saved else "Not saved yet."

    def _own_actions(self, *, busy: bool) -> list[dict[str, Any]]:  # noqa: ARG002 (for a review)
        """Return the buttons and menus, before those of the layers."""
        return stick_actions(self.session)
