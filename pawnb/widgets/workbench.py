"""*Workbench*: the trials of a folder on one page, the next step of each one click away."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import ipywidgets as widgets

from pawnb.errors import InputError, PawnbError
from pawnb.widgets.alignment_form import AlignmentForm
from pawnb.widgets.background_work import BackgroundWork
from pawnb.widgets.calibration_form import CalibrationForm
from pawnb.widgets.click_initialiser import ClickInitialiser
from pawnb.widgets.gait_explorer import GaitExplorer
from pawnb.widgets.plain import Plain, picture_of_table
from pawnb.widgets.pose_reviewer import PoseReviewer
from pawnb.widgets.stick_poser import StickPoser
from pawnb.widgets.surroundings import Surroundings
from pawnb.widgets.track_reviewer import TrackReviewer
from pawnb.widgets.tracks_form import TracksForm, review_of_trial
from pawnb.widgets.trial_form import TrialForm
from pawnb.widgets.workbench_offers import Offers
from pawnb.widgets.workbench_parts import (
    ROW,
    Tool,
    cell,
    list_trials,
    show_findings,
    show_results,
    step_menu,
    video_choice,
)
from pawnb.widgets.workbench_session import WorkbenchSession, described, text_of
from pawnb.workflow.provenance.results import results_folder
from pawnb.workflow.workbench.states import DONE, WORK_STEPS, Step, TrialState

_PAGE = 20
"""Trials that are listed at once."""
_LEAST_BENCH_PX, _AROUND_PX = 300, 380
"""Least height of the pictures, and what the timeline and buttons around them take, CSS px."""
_WRONG_IN_BENCH = {False: "#B3261E", True: "#FFB4AB"}


class Workbench(Plain, widgets.VBox):  # type: ignore[misc]
    """All trials of a folder: how far each is, what is wrong, and the next step.

    The steps are those of the work: calibrate, click the start, track, review, analyse the gait,
    look at the results. Videos that are no trial yet become one by a form on the same page.

    Parameters
    ----------
    folder : str or Path
        The folder; trials lie in it, in its folders, or in theirs.
    videos : sequence of str or Path, optional
        Videos to make a trial of at once, where there is none yet.

    Attributes
    ----------
    session : WorkbenchSession
        The trials; works without a browser.
    tool : widget or None
        What is open below the list.
    work : BackgroundWork
        What is being done without a person.

    Raises
    ------
    InputError
        If there is no such folder, or a video cannot be opened.

    Examples
    --------
    >>> bench = pawnb.Workbench("sample")
    >>> [state.folder.name for state in bench.session.states]
    ['sample']
    """

    def __init__(self, folder: str | Path = ".", videos: Sequence[str | Path] = ()) -> None:
        super().__init__()
        self.session = WorkbenchSession(folder)
        self.tool: Any = None
        self._first = 0  # of the list, where there are more trials than it shows
        self._around = Surroundings()
        self._told = widgets.Label()
        self._told.add_class("pawnb-wrap").add_class("pawnb-next")
        self._list, self._desk = widgets.VBox(), widgets.VBox()
        self._list.add_class("pawnb-trials")
        stop = self._button("Stop", lambda: self.session.stop.set(), icon="stop")
        self.work = BackgroundWork(
            stop, around=self.look_again, failed=partial(self._tell, wrong=True)
        )
        self.work.add_class("pawnb-next")
        self._head = widgets.HBox(layout=ROW)
        self.children = (
            self._around, self._head, self._list, self.work, self._told, self._desk
        )  # fmt: skip
        # words on what is wrong have another colour on a dark page
        self._around.observe(lambda _: self._show_list(), names="dark")
        self.look_again()
        if videos:
            self._begin_with([self.session.folder / video for video in videos])

    # --- what a person does ---------------------------------------------------------------

    def look_again(self) -> None:
        """Look anew what lies in the folder, and list it."""
        self.session.refresh()
        self._show_list()

    def make_trial(self, videos: Sequence[str | Path]) -> None:
        """Open the form that makes a trial of some videos."""
        self._open(lambda: TrialForm(videos, done=self._made))

    def do(self, step: Step, folder: str | Path) -> None:
        """Do a step of the work for the trial of a folder.

        Parameters
        ----------
        step : str
            mend, calibrate, align, start, track, review, gait or look.
        folder : str or Path
            The folder of the trial.
        """
        state = self.session.state(Path(folder))
        if step in ("track", "gait"):
            self._put_away()
            work = self._track if step == "track" else self._gait
            self._begin(WORK_STEPS[step], lambda: work(state))
            return
        make: dict[str, Callable[[], Any]] = {
            "mend": lambda: show_findings(self.session.wrong(state)),
            "calibrate": lambda: self._describe(CalibrationForm, state),
            "align": lambda: self._describe(AlignmentForm, state),
            "start": lambda: self._start(state),
            "review": lambda: self._review(state),
            "look": lambda: self._results(state),
        }
        if step not in make:
            raise InputError(f"step is {step!r}; expected one of {', '.join(WORK_STEPS)}.")
        self._open(make[step])

    def plain_picture(self) -> bytes:
        """Return the list of trials as PNG."""
        rows = [
            [state.name, *("x" if word in state.done else "-" for word in DONE),
             WORK_STEPS[self.session.next_step(state)]]
            for state in self.session.states[self._first : self._first + _PAGE]
        ]  # fmt: skip
        title = self.session.folder.resolve().name
        return picture_of_table(["trial", *DONE, "next"], rows, title)

    def close(self) -> None:
        """Take the workbench away, and end what is being done."""
        self.session.stop.set()
        self.work.wait()
        self._put_away()
        super().close()

    # --- the list ---------------------------------------------------------------------------

    def _begin_with(self, videos: Sequence[Path]) -> None:
        """Open the form of some videos; where the trial was made since, its line is enough."""
        if (videos[0].parent / "trial.toml").exists():  # the page was opened again
            where = f"{videos[0].parent.resolve().name} has its trial.toml"
            self._tell(f"{where}: go on with the next step, in the list above.")
        else:
            self.make_trial(videos)

    def _show_list(self, *, head: bool = True) -> None:
        """Show the trials, a line each."""
        if head:  # else what is being chosen there stays
            self._show_head(len(self.session.states))
        shown = self.session.states[self._first : self._first + _PAGE]
        rows = [self._row(state) for state in shown]
        heads = [self._cell(t, strong=True) for t in ("trial", *DONE, "next")]
        grid = list_trials([heads, *rows] if rows else [])
        wrong = [self._cell(f"{s.name}: {s.wrong}", wrong=True) for s in shown if s.wrong]
        self._list.children = (grid, *wrong)

    def _show_head(self, n: int) -> None:
        """Show what can be done to the folder as a whole."""
        session = self.session
        said = f"{n} trial{'' if n == 1 else 's'}" if n else "no trial yet"
        head: list[Any] = [self._cell(f"{session.folder.resolve().name}: {said}", strong=True)]
        videos = session.videos()
        if videos:
            self._videos = video_choice(videos)
            text, act = "New trial of these videos", lambda: self.make_trial(self._videos.value)
            head += [self._videos, self._button(text, act)]
        if tracks := session.track_files():
            form = partial(TracksForm, tracks, session, begin=self._begin, show=self._open)
            act = partial(self._open, partial(form, button=self._button, room=lambda: self._room))
            film = "Look at the tracks here, and their gait"
            head.append(self._button(film if session.films() else "Gait of the tracks here", act))
        if sum(state.next_step == "track" for state in session.states) > 1:
            head.append(self._button("Track all that are started", self._track_all))
        head.append(self._button("Look again", self.look_again, icon="refresh"))
        if n > _PAGE:
            head += [self._button(f"{by:+d}", partial(self._turn, by)) for by in (-_PAGE, _PAGE)]
        self._head.children = tuple(head)

    def _turn(self, by: int) -> None:
        """Show another page of the list."""
        last = (len(self.session.states) - 1) // _PAGE * _PAGE
        self._first = min(max(0, self._first + by), last)
        self._show_list()

    def _row(self, state: TrialState) -> list[Any]:
        """Return the cells of one trial."""
        marks = [self._cell("✓" if word in state.done else "–") for word in DONE]
        nxt = self.session.next_step(state)
        steps = [nxt, *(step for step in state.steps if step != nxt)]
        buttons = [self._button(WORK_STEPS[nxt], partial(self.do, nxt, state.folder), main=True)]
        if "calibrate" in steps and "calibrated" not in state.done:
            steps.remove("calibrate")  # it is a button of its own until it is done
            text, act = WORK_STEPS["calibrate"], partial(self.do, "calibrate", state.folder)
            buttons.append(self._button(text, act))
        if len(steps) > 1:
            buttons.append(
                step_menu(steps[1:], lambda step: self._guard(lambda: self.do(step, state.folder)))
            )
        name = self._cell(self.session.title(state), wrap=True)
        return [name, *marks, widgets.HBox(buttons, layout=ROW)]

    def _start(self, state: TrialState, frame: int | None = None) -> Any:
        """Return the widget that makes the start, and the button that goes on."""
        trial = described(state)
        tool = (StickPoser if trial.is_jointed else ClickInitialiser)(
            trial, frame=frame, max_height=self._room
        )
        go_on = self._button("Track", lambda: self._track_started(state), main=True)
        return self._follow(state, Tool(tool, [go_on]))

    def _follow(self, state: TrialState, tool: Tool) -> Tool:
        """Let the list change as a tool finishes the start of a trial, or saves its tracks."""

        def changed() -> None:
            self.session.refresh_one(state.folder)
            self._show_list(head=False)

        return tool.follow(partial(self.session.marks, state), changed)

    def _describe(self, form: type[CalibrationForm | AlignmentForm], state: TrialState) -> Any:
        """Return a form that says more of a trial; its clicks come next."""

        def done(said: str = "calibrated.") -> None:
            self.look_again()
            self.do("start", state.folder)
            self._tell(f"{state.name}: {said}")

        return Tool(form(described(state), done=done, max_height=self._room), [])

    def _track_started(self, state: TrialState) -> None:
        """Track the trial that was just started."""
        self.session.refresh()
        if "started" not in self.session.state(state.folder).done:
            raise InputError("the start is not complete: click every point, or pose the animal.")
        self.do("track", state.folder)

    def _review(self, state: TrialState) -> Any:
        """Return the widget that reviews the tracks."""
        if state.films:
            then = partial(self._corrected, state)
            return review_of_trial(state, button=self._button, then=then, room=self._room)
        trial = described(state)
        reviewer = PoseReviewer if trial.is_jointed else TrackReviewer
        tracks, doubts = self.session.tracks_and_doubts(state)
        tool = reviewer(trial, tracks, max_height=self._room)
        self.session.has_looked(state)
        go_on = self._button("Save, and analyse the gait", lambda: self._reviewed(state), main=True)
        offers = Offers(
            self.session, state, tool, button=self._button, chosen=lambda: self._tell(""),
            use_frames=self._use_frames, click_also=self._click_also,
        )  # fmt: skip
        return self._follow(state, Tool(tool, [go_on, offers], doubts))

    def _use_frames(self, state: TrialState, frames: tuple[int, int]) -> None:
        """Track a part of the recording only."""
        if self.tool.tool.corrected.corrections:
            raise InputError(
                "corrections were made; take them back first, or write the frames into trial.toml "
                "yourself."
            )
        self.session.use_frames(state, frames)
        self.do("track", state.folder)

    def _click_also(self, state: TrialState, frame: int) -> None:
        """Open the clicks of a trial at the frame in which more of them help most."""
        self._open(lambda: self._start(state, frame))
        self._tell(
            f"Click the points that can be seen in frame {frame}, then Track. What was clicked "
            "before is kept."
        )

    def _reviewed(self, state: TrialState) -> None:
        """Save what was corrected, and go on to the gait."""
        if (made := self.tool.tool.corrected).corrections:
            made.save()
        self.do("gait", state.folder)

    def _corrected(self, state: TrialState, file: Path) -> None:
        """Go on to the gait with corrected tracks of another program."""
        self.session.use_tracks(state, file)
        self.do("gait", state.folder)

    def _results(self, state: TrialState) -> Any:
        """Return the results: figures to look through, the explorer of strides, and the report."""
        strides = self._button("Look through the strides", lambda: self._strides(state))
        write = lambda: partial(self._tell, self.session.report(state))  # noqa: E731
        report = self._button("Write the report", lambda: self._begin("Writing the report", write))
        figures, said = self.session.figures(state), self.session.remarks(state)
        return Tool(show_results(figures, said), [strides, report])

    def _strides(self, state: TrialState) -> None:
        """Open the explorer of strides."""
        path = results_folder(described(state)) / "event_edits.jsonl"
        again = self._button("Analyse the gait again", lambda: self.do("gait", state.folder))
        self._open(lambda: Tool(GaitExplorer(self.session.gait_tables(state), path), [again]))

    def _made(self, path: Path) -> None:
        """Go on to the start of a trial that was just made."""
        self.look_again()
        self._guard(lambda: self.do("start", path.parent))
        self._tell(f"Wrote {path}. Next: click every point, or pose the animal, then Track.")

    def _open(self, make: Callable[[], Any]) -> None:
        """Open a tool instead of what was open."""
        tool = make()  # may be refused: what is open stays then
        self._put_away()
        self.tool = tool
        self._desk.children = (tool,)
        self._tell("")
        self._around.bring()

    def _put_away(self) -> None:
        """Close the tool that is open."""
        tool, self.tool = self.tool, None
        self._desk.children = ()
        if tool is not None:
            tool.close()

    # --- work without a person ------------------------------------------------------------------

    def _track(self, state: TrialState) -> Callable[[], None]:
        """Track a trial; gives what to do then."""
        said = self.session.track(state, self.work.progress)

        def then() -> None:
            self.do("review", state.folder)
            self._tell(said)

        return then

    def _gait(self, state: TrialState) -> Callable[[], None]:
        """Analyse the gait of a trial; gives what to do then."""
        run = self.session.gait(state)

        def then() -> None:
            self.do("look", state.folder)
            self._tell("; ".join(run.text().splitlines()[:2]))

        return then

    def _track_all(self) -> None:
        """Track every trial that is started."""
        self._put_away()
        shown = partial(self._show_list, head=False)

        def work() -> Callable[[], None]:
            said = self.session.track_all(self.work.progress, shown)
            return lambda: self._tell(text_of(said))

        self._begin("tracking", work)

    def _begin(self, doing: str, work: Callable[[], Callable[[], None]]) -> None:
        """Do something off this thread, and then what it gives."""

        def guarded() -> Callable[[], None]:
            then = work()
            return lambda: self._guard(then)

        self._tell("")
        self.work.begin(doing, guarded)
        self._around.bring()

    @property
    def _room(self) -> int:
        """Height for pictures, CSS px, that leaves room for what is around them."""
        return min(max(_LEAST_BENCH_PX, (self._around.height or 900) - _AROUND_PX), 720)

    def _guard(self, act: Callable[[], object]) -> None:
        """Do something; say what is wrong where it cannot be done."""
        try:
            act()
        except (PawnbError, OSError) as error:
            self._tell(str(error), wrong=True)

    def _tell(self, text: str, *, wrong: bool = False) -> None:
        """Say something below the list."""
        self._told.value = text
        self._told.style.text_color = _WRONG_IN_BENCH[self._around.dark] if wrong else None

    def _button(
        self, text: str, act: Callable[[], object], *, icon: str = "", main: bool = False
    ) -> Any:
        """Return a button that does something, and says what is wrong where it cannot."""
        style = "primary" if main else ""
        button = widgets.Button(
            description=text, icon=icon, button_style=style, layout={"width": "auto"}
        )
        button.on_click(lambda _: self._guard(act))
        return button

    def _cell(self, text: str, *, wrong: bool = False, **how: bool) -> Any:
        """Return a text of the list; a label takes no HTML, whatever a trial is called."""
        return cell(text, _WRONG_IN_BENCH[self._around.dark] if wrong else None, **how)
