"""What the workbench knows and does; works without a browser."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import pandas as pd

from pawnb.errors import InputError, PawnbError
from pawnb.files import is_copy
from pawnb.gait import GaitTables, analyse
from pawnb.io.formats import TABLE, recognise_format
from pawnb.schema import Tracks
from pawnb.trial import Trial
from pawnb.widgets.calibration_points import CLICK_FILE
from pawnb.widgets.calibration_wand import WAND_FILE
from pawnb.workflow.conversion.foreign_tracks import read_foreign_tracks
from pawnb.workflow.gait.run import GaitRun, run_gait
from pawnb.workflow.gait.sources import recording_name
from pawnb.workflow.kinds import kind_of
from pawnb.workflow.provenance.mended_trial import as_described_now
from pawnb.workflow.provenance.notes import noted_warnings
from pawnb.workflow.provenance.report.report import REPORT_FILE, write_report
from pawnb.workflow.provenance.results import (
    RESULTS_FOLDER,
    note_failure,
    read_result_tracks,
    results_folder,
    tracking_notes,
)
from pawnb.workflow.reviewing.foreign import CORRECTED
from pawnb.workflow.reviewing.quality import assess_quality
from pawnb.workflow.reviewing.suggest import suggest_frames
from pawnb.workflow.tracking.track import track
from pawnb.workflow.workbench.films import find_videos, is_tracks_file
from pawnb.workflow.workbench.states import (
    Step,
    TrialState,
    find_states,
    state_of,
    what_is_wrong,
)
from pawnb.workflow.workbench.used_frames import write_frames, write_tracks_file

Progress = Callable[..., None]
_TRACK_ENDINGS = frozenset(ending for one in TABLE for ending in one.endings)
"""Of files that other programs keep tracks in."""
_CLICK_FILES = ("start.csv", CLICK_FILE, WAND_FILE)
"""What a person clicked has the columns of tracks."""
_RESULTS_OF_TRACKS = f"{RESULTS_FOLDER}_of_tracks"
"""Folder of results of files of tracks that lie beside a trial."""


class WorkbenchSession:
    """The trials of a folder, how far each is, and the steps that need no person.

    Parameters
    ----------
    folder : str or Path
        The folder.

    Attributes
    ----------
    folder : Path
        The folder.
    states : list of TrialState
        How far each trial is, as of the last :meth:`refresh`.
    stop : threading.Event
        Set it to end what is being tracked.

    Raises
    ------
    InputError
        If there is no such folder.
    """

    def __init__(self, folder: str | Path) -> None:
        self.folder = Path(folder).absolute()  # a notebook may go to another folder meanwhile
        self.stop = threading.Event()
        self._reviewed: set[Path] = set()
        self.states: list[TrialState] = []
        self.refresh()

    def refresh(self) -> list[TrialState]:
        """Look again how far each trial is."""
        self.states = find_states(self.folder)
        return self.states

    def refresh_one(self, folder: Path) -> None:
        """Look again how far the trial of a folder is, and no other."""
        self.states = [state_of(s.folder) if s.folder == folder else s for s in self.states]

    @staticmethod
    def marks(state: TrialState) -> tuple[object, ...]:
        """Return what changes as a tool finishes the start of a trial, or saves its tracks."""
        trial = described(state)
        if trial.is_tracked_elsewhere:
            return ()
        tracks = results_folder(trial) / "tracks.nc"
        saved = tracks.stat().st_mtime_ns if tracks.exists() else None
        return kind_of(trial).is_started(trial), saved

    def state(self, folder: Path) -> TrialState:
        """Return how far the trial of a folder is; raises InputError if there is none."""
        for state in self.states:
            if state.folder.resolve() == folder.resolve():
                return state
        raise InputError(f"{folder}: no trial there; look again.")

    def next_step(self, state: TrialState) -> Step:
        """Return what comes next: a review in which all was right counts as well."""
        step = state.next_step
        if step == "review" and state.folder in self._reviewed and not state.is_unsaved:
            return "look" if "analysed" in state.done else "gait"
        return step

    def title(self, state: TrialState) -> str:
        """Return what a trial is called in the list: with its folder where others are called so."""
        alone = [other.name for other in self.states].count(state.name) == 1
        return state.name if alone else f"{state.name} ({state.folder.name})"

    def has_looked(self, state: TrialState) -> None:
        """Remember that a person has opened the review of a trial."""
        self._reviewed.add(state.folder)

    def videos(self) -> list[Path]:
        """Return the videos of the folder that no trial there names."""
        taken = {
            state.trial.path(view.video).resolve()
            for state in self.states
            if state.trial is not None
            for view in state.trial.views
        }
        return [video for video in find_videos(self.folder) if video.resolve() not in taken]

    def track_files(self) -> list[Path]:
        """Return the files of the folder itself with tracks that no trial there names."""
        taken = {
            trial.path(name).resolve()
            for trial in (state.trial for state in self.states)
            if trial is not None
            for name in (*trial.track_files, trial.start_file(), trial.start_pose_file())
            if name is not None
        }
        found = []
        for path in sorted(self.folder.iterdir()):
            if path.suffix.lower() not in _TRACK_ENDINGS or path.name in _CLICK_FILES:
                continue
            if is_copy(path, "before"):  # clicks as they were before they were changed
                continue
            if path.resolve() in taken:
                continue
            if is_tracks_file(path):
                found.append(path)
        return found

    def films(self) -> list[Path]:
        """Return every video of the folder."""
        return find_videos(self.folder)

    @staticmethod
    def one_a_recording(files: Sequence[Path]) -> list[Path]:
        """Return the first file of each recording, corrected ones before others.

        Programs write several of one.
        """
        order = sorted(files, key=lambda path: (not path.name.startswith(CORRECTED), path.name))
        first = {recording_name(path, recognise_format(path)): path for path in reversed(order)}
        return [path for path in files if path in first.values()]

    def gait_of_tracks(self, files: Sequence[Path], fps: float, **asked: Any) -> GaitRun:
        """Analyse the gait in files of tracks; results go into the folder.

        Those of a trial that lies in the folder itself are left alone.

        Parameters
        ----------
        files : sequence of Path
            The files.
        fps : float
            Frames a second.
        **asked
            animals, groups and legs, as for :func:`pawnb.run_gait`.

        Returns
        -------
        GaitRun
            What was written.
        """
        is_trial = (self.folder / "trial.toml").exists()
        out = self.folder / (_RESULTS_OF_TRACKS if is_trial else RESULTS_FOLDER)
        return run_gait(list(files), fps=fps, figures="main", out=out, **asked)

    def track(self, state: TrialState, progress: Progress | None = None) -> str:
        """Track a trial; returns the verdict in words.

        Parameters
        ----------
        state : TrialState
            The trial.
        progress : callable, optional
            ``progress(done, total, doing)``.

        Returns
        -------
        str
            What was found.

        Raises
        ------
        InputError
            If it cannot be tracked, or was stopped.
        """
        trial = described(state)
        self.stop.clear()
        out = results_folder(trial)
        try:
            tracks = track(trial, out=out, progress=progress, stop=self.stop.is_set)
        except (PawnbError, OSError) as error:
            with suppress(PawnbError, OSError):  # that it failed is said in any case
                note_failure(out, str(error))
            raise
        if self.stop.is_set():
            raise InputError("tracking was stopped; press Track again to go on.")
        return (
            f"{state.name}: tracked {tracks.sizes['time']} frames, {assess_quality(tracks).line()}"
        )

    def track_all(
        self, progress: Progress | None = None, one_is_done: Callable[[], None] | None = None
    ) -> list[str]:
        """Track every trial that is started and not tracked; returns a line for each.

        Parameters
        ----------
        progress : callable, optional
            ``progress(done, total, doing)``.
        one_is_done : callable, optional
            Called as each trial is done, or has failed; ``states`` knows it then.

        Returns
        -------
        list of str
            The verdict of each, or why it could not be tracked.
        """
        self.stop.clear()
        said = []
        waiting = [s for s in self.refresh() if s.next_step == "track"]
        for k, state in enumerate(waiting, start=1):
            if self.stop.is_set():
                break
            try:
                said.append(self.track(state, _of_list(progress, f"{k} of {len(waiting)}", state)))
            except (PawnbError, OSError) as error:
                said.append(f"{state.name}: {error}")
            self.refresh()
            if one_is_done is not None:
                one_is_done()
        return said

    def gait(self, state: TrialState) -> GaitRun:
        """Analyse the gait of a trial, and write tables and the main figures."""
        return run_gait([described(state).folder], figures="main")

    def report(self, state: TrialState) -> str:
        """Write one page on the gait of a trial, ``report.html`` beside it; says where it is."""
        path = write_report(state.folder, out=state.folder / REPORT_FILE)
        return f"{state.name}: wrote {path}. A double click on it in the list of files opens it."

    def tracks(self, state: TrialState) -> Tracks:
        """Return the tracks of a trial, those made elsewhere as well."""
        trial = described(state)
        if trial.is_tracked_elsewhere:
            return read_foreign_tracks(trial)
        return as_described_now(read_result_tracks(results_folder(trial) / "tracks.nc"), trial)

    def tracks_and_doubts(self, state: TrialState) -> tuple[Tracks, list[str]]:
        """Return the tracks of a trial, and what was warned of.

        Parameters
        ----------
        state : TrialState
            The trial.

        Returns
        -------
        tracks : xarray.Dataset
            Its tracks.
        doubts : list of str
            What the trial says otherwise now, then what tracking has warned of.
        """
        with noted_warnings() as since:
            tracks = self.tracks(state)
        return tracks, [*since, *(note.what for note in tracking_notes(tracks))]

    def gait_tables(self, state: TrialState) -> GaitTables:
        """Return the analysis of a trial, to look through its strides."""
        return analyse(self.tracks(state), trial=described(state))

    def quality(self, state: TrialState) -> str:
        """Return the verdict on the tracks of a trial, in words."""
        path = results_folder(described(state)) / "tracks.nc"
        return assess_quality(read_result_tracks(path)).line() if path.exists() else ""

    def remarks(self, state: TrialState) -> list[str]:
        """Return the verdict on the tracks of a trial, then what its analysis says of it."""
        told = self.quality(state)
        return [*([f"Tracks: {told}."] if told else []), *self.notes(state)]

    def notes(self, state: TrialState) -> list[str]:
        """Return what the analysis of a trial says of the trial as a whole, a line each."""
        path = results_folder(described(state)) / "notes.csv"
        if not path.exists():
            return []
        told = pd.read_csv(path, keep_default_na=False, dtype=str)
        whole = told[told["rows"] == ""]
        return [
            ": ".join(filter(None, row)) for row in whole[["where", "what"]].to_numpy().tolist()
        ]

    def frame_to_click(self, state: TrialState, tracks: Tracks) -> int | None:
        """Return the frame whose clicks would help most; None where the tracks are good.

        Parameters
        ----------
        state : TrialState
            The trial.
        tracks : xarray.Dataset
            Its tracks.

        Returns
        -------
        int or None
            The frame; None as well where tracks were made elsewhere, or are of a jointed animal.
        """
        trial = described(state)
        if not _is_clicked(trial):
            return None
        quality = assess_quality(tracks)
        if quality.verdict == "good" and not quality.poor_points:
            return None
        named = suggest_frames(trial, tracks, n=1)["frame"]
        return int(named.iloc[0]) if len(named) else None

    def frames_to_use(self, state: TrialState, tracks: Tracks) -> tuple[int, int] | None:
        """Return the frames whose verdict would be better than that of all; None without such.

        Parameters
        ----------
        state : TrialState
            The trial.
        tracks : xarray.Dataset
            Its tracks.

        Returns
        -------
        tuple of int or None
            The first frame and one past the last; None as well where tracks were made elsewhere,
            or are of a jointed animal.
        """
        usable = assess_quality(tracks).usable if _is_clicked(described(state)) else None
        return None if usable is None else (usable.first, usable.stop)

    def use_frames(self, state: TrialState, frames: tuple[int, int]) -> None:
        """Write into ``trial.toml`` which frames are used."""
        write_frames(described(state), frames)
        self.refresh()

    def use_tracks(self, state: TrialState, file: Path) -> None:
        """Write into ``trial.toml`` that corrected tracks, beside those before, are used."""
        trial = described(state)
        if trial.tracks_file is not None and trial.path(trial.tracks_file) != file:
            write_tracks_file(trial, Path(trial.tracks_file).with_name(file.name).as_posix())
            self.refresh()

    def figures(self, state: TrialState) -> list[Path]:
        """Return the pictures of a trial's results: gait diagrams, then by their names."""
        found = (results_folder(described(state)) / "figures").rglob("*.png")
        return sorted(found, key=lambda path: (not path.name.startswith("gait_diagram"), path))

    def wrong(self, state: TrialState) -> list[str]:
        """Say what is to be mended or looks wrong."""
        return what_is_wrong(state)


def _of_list(progress: Progress | None, place: str, state: TrialState) -> Progress | None:
    """Return a progress that says which trial of the list it is of."""
    if progress is None:
        return None

    def told(done: int, total: int, doing: str = "tracking") -> None:
        progress(done, total, f"{state.name} ({place}), {doing or 'tracking'}")

    return told


def _is_clicked(trial: Trial) -> bool:
    """Tell whether a trial is tracked here, from clicked points."""
    return not (trial.is_jointed or trial.is_tracked_elsewhere)


def text_of(findings: Sequence[str]) -> str:
    """Return findings as one text for a line of the page."""
    return "; ".join(finding.rstrip(".") for finding in findings) + "." if findings else ""


def described(state: TrialState) -> Trial:
    """Return the description of a trial; raises InputError where that cannot be read."""
    if state.trial is None:
        raise InputError(state.wrong)
    return state.trial
