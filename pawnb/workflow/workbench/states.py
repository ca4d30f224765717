"""How far each trial of a folder is, what is wrong in words, and what comes next."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from pawnb.core.edits.log import EDIT_LINES, say_unsaved
from pawnb.errors import InputError, PawnbError
from pawnb.io.journal import read_journal
from pawnb.io.native import read_tracks
from pawnb.trial import Trial, load_trial
from pawnb.trial.file import find_trial_files
from pawnb.workflow.checking.check import check_trial
from pawnb.workflow.kinds import kind_of
from pawnb.workflow.provenance.manifest import find_fault, known_files
from pawnb.workflow.provenance.results import failure_of, results_folder
from pawnb.workflow.reviewing.foreign import CORRECTED
from pawnb.workflow.workbench.films import films_of_tracks

Step = Literal["mend", "calibrate", "align", "start", "track", "review", "gait", "look"]
WORK_STEPS: dict[Step, str] = {
    "mend": "What to mend",
    "calibrate": "Calibrate",
    "align": "Align the films",
    "start": "Click the start",
    "track": "Track",
    "review": "Review",
    "gait": "Analyse the gait",
    "look": "Look at the results",
}
"""What can come next, and what its button says."""
DONE = ("described", "calibrated", "started", "tracked", "reviewed", "analysed")
"""What a trial can be, in the order of the work."""


@dataclass(frozen=True)
class TrialState:
    """How far one trial is.

    Parameters
    ----------
    folder : Path
        The folder of its ``trial.toml``.
    name : str
        What it is called.
    done : frozenset of str
        Which of :data:`DONE` it is.
    wrong : str
        Why it cannot be worked on, or what was left half done, in words; empty where all is well.
    trial : Trial, optional
        Its description, where that can be read.
    is_unsaved : bool
        Whether corrections were made in a review that the tracks lack.
    films : tuple of Path
        Of tracks that another program made: on what they can be looked at.
    """

    folder: Path
    name: str
    done: frozenset[str]
    wrong: str = ""
    trial: Trial | None = None
    is_unsaved: bool = False
    films: tuple[Path, ...] = ()

    @property
    def next_step(self) -> Step:
        """What comes next."""
        if self.trial is None:
            return "mend"
        if self.trial.is_tracked_elsewhere:
            return "look" if "analysed" in self.done else "gait"
        steps: tuple[tuple[str, Step], ...] = (
            ("started", "start"), ("tracked", "track"), ("reviewed", "review"),
            ("analysed", "gait"),
        )  # fmt: skip
        return next((step for word, step in steps if word not in self.done), "look")

    @property
    def steps(self) -> tuple[Step, ...]:
        """Everything that can be done now, what comes next first."""
        if self.trial is None:
            return ("mend",)
        can: list[Step] = [self.next_step, *(("review",) if self.films else ())]
        if not self.trial.is_tracked_elsewhere:
            can += ["start", "calibrate"]
            if len({view.video for view in self.trial.views}) > 1:
                can.append("align")
            if "started" in self.done:
                can.append("track")
            if "tracked" in self.done:
                can += ["review", "gait"]
        if "analysed" in self.done:
            can.append("look")
        return tuple(dict.fromkeys([*can, "mend"]))


def state_of(folder: str | Path) -> TrialState:
    """Say how far a trial is, by what lies beside its ``trial.toml``; opens no video.

    Parameters
    ----------
    folder : str or Path
        The folder, or its ``trial.toml``.

    Returns
    -------
    TrialState
        What is done, and what comes next.
    """
    path = Path(folder)
    path = path.parent if path.name == "trial.toml" else path
    try:
        trial = load_trial(path)
    except PawnbError as error:
        return TrialState(path, path.resolve().name, frozenset(), str(error))
    done, wrong = {"described"}, ""
    calibration = trial.calibration
    if calibration is not None:
        file = calibration.of_views
        if file is None:  # a unit alone is none
            done |= {"calibrated"} if calibration.px_per_unit is not None else set()
        elif trial.path(file).exists():
            done.add("calibrated")
        else:
            wrong = f"{trial.path(file)}: no such file; check [calibration]."
    for view in trial.views:
        if not any(mark in view.video for mark in "*?[") and not trial.path(view.video).exists():
            wrong = f"{trial.path(view.video)}: no such video."
    if trial.is_tracked_elsewhere or kind_of(trial).is_started(trial):
        done.add("started")
    results = results_folder(trial)
    if not wrong and not trial.is_tracked_elsewhere and (why := failure_of(results)):
        wrong = f"tracking failed when it was tried last: {why}"
    if trial.is_tracked_elsewhere or (results / "tracks.nc").exists():
        done.add("tracked")
    unsaved = "" if trial.is_tracked_elsewhere else _unsaved(results)
    if _is_corrected(trial) or (_has_edits(results / "edits.jsonl") and not unsaved):
        done.add("reviewed")
    analysed = known_files(results).files_of("gait") and find_fault(results, run="gait") is None
    if analysed and not unsaved:
        done.add("analysed")
    films = films_of_tracks(trial) if trial.is_tracked_elsewhere else ()
    return TrialState(
        path, trial.name, frozenset(done), wrong or unsaved, trial, bool(unsaved), films
    )


def find_states(folder: str | Path) -> list[TrialState]:
    """Return how far each trial in a folder is, itself among them, in the order of their names.

    Parameters
    ----------
    folder : str or Path
        The folder; trials lie in it, in its folders or in theirs.

    Returns
    -------
    list of TrialState
        Empty where there is none.

    Raises
    ------
    InputError
        If there is no such folder.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise InputError(f"{folder}: no such folder.")
    return [state_of(file) for file in find_trial_files(folder)]


def what_is_wrong(state: TrialState) -> list[str]:
    """Look at everything a trial names, and say what is to be mended or looks wrong.

    Parameters
    ----------
    state : TrialState
        The trial.

    Returns
    -------
    list of str
        One finding each; what must be mended first comes first.
    """
    if state.trial is None:
        return [state.wrong]
    report = check_trial(state.trial)
    return [*report.faults, *report.doubts]


def _is_corrected(trial: Trial) -> bool:
    """Whether tracks that another program made are those that a review has saved."""
    return any(Path(file).name.startswith(CORRECTED) for file in trial.track_files)


def _unsaved(results: Path) -> str:
    """Say how many corrections were made in a review that the tracks lack; empty where none."""
    file, tracks = results / "edits.jsonl", results / "tracks.nc"
    if not (file.exists() and tracks.exists()):
        return ""
    try:
        return say_unsaved(read_tracks(tracks), file)
    except PawnbError:
        return ""  # opening the review says what is wrong with either


def _has_edits(path: Path) -> bool:
    """Whether a person has corrected or accepted anything."""
    try:
        return bool(read_journal(path, EDIT_LINES)[0])
    except PawnbError:
        return True  # there is something, and opening the review says what
