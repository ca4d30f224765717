"""Many trials, one process each, begun again where it stopped.

A trial whose results are whole, and were made from the same files with the same method and
settings, is skipped, and so is one that another process is tracking (``busy``). What fails is
collected and does not stop the others. Each trial is tracked by
:mod:`pawnb.workflow.batch.worker` in a process of its own, so that one that crashes or fills the
memory takes no other with it: on this machine, or where a scheduler's workers are
(:mod:`pawnb.workflow.batch.places`, :mod:`pawnb.workflow.batch.scheduler`).
"""

from __future__ import annotations

import contextlib
import json
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from pawnb.core.paws.tracker import DEFAULT
from pawnb.errors import InputError, InputWarning, PawnbError
from pawnb.files import child_folder
from pawnb.input_warnings import warn_of_input
from pawnb.schema import each_of
from pawnb.schema.arguments import checked_arguments
from pawnb.trial import Trial, load_trial
from pawnb.trial.file import find_too_deep, find_trial_files
from pawnb.workflow.batch.places import Places, Processes, TrialOutcome
from pawnb.workflow.batch.renamed import as_tracked_before, changed_words
from pawnb.workflow.batch.scheduler import Scheduler
from pawnb.workflow.interrupt import interruptible
from pawnb.workflow.provenance.manifest import MANIFEST, find_fault, known_files
from pawnb.workflow.provenance.record import trial_checksums, trial_fingerprint
from pawnb.workflow.provenance.results import RESULT_FILES, note_failure, results_folder
from pawnb.workflow.reviewing.quality import QUALITY_FILE, read_verdict
from pawnb.workflow.tracking.methods import settings_in_force, trial_tracker

_POLL_S = 0.05
_STATUSES = {
    "tracked": "tracked", "skipped": "skipped", "busy": "being done by another process",
    "failed": "failed", "stopped": "stopped",
}  # fmt: skip
"""What became of a trial, and the words for it in a count."""


@dataclass(frozen=True)
class BatchReport:
    """What became of every trial.

    Parameters
    ----------
    table : DataFrame
        trial (its path), out (folder of its results), status (``tracked``, ``skipped``,
        ``busy``: another process is tracking it, ``failed``, ``stopped``), said (one sentence)
        and verdict on the tracks (``good``, ``look``, ``failed``; empty where there are none),
        in the order given.
    """

    table: pd.DataFrame

    @property
    def failed(self) -> pd.DataFrame:
        """The rows of trials that failed."""
        return self.table[self.table["status"] == "failed"]

    @property
    def lost(self) -> pd.DataFrame:
        """The rows of trials whose tracks are there and failed."""
        return self.table[self.table["verdict"] == "failed"]

    def verdict(self) -> str:
        """Return how many failed and why, in one sentence."""
        said = "; ".join(
            f"{row.trial}: {str(row.said).rstrip('.')}" for row in self.failed.itertuples()
        )
        return f"{len(self.failed)} of {len(self.table)} trials failed: {said}."

    def text(self) -> str:
        """Return how many were tracked, skipped, failed and stopped, and how good tracks are."""
        done = self._counts("status", tuple(_STATUSES))
        tracks = self._counts("verdict", ("good", "look", "failed"))
        return f"{done}; tracks: {tracks}" if tracks else done

    def _counts(self, column: str, names: Sequence[str]) -> str:
        counts = self.table[column].value_counts()
        return ", ".join(
            f"{counts[name]} {_STATUSES.get(name, name)}" for name in names if name in counts
        )


@dataclass
class _Job:
    """One trial on its way."""

    path: Path
    number: int
    out: str | None = None
    status: str = "stopped"
    said: str = "not begun"
    verdict: str = ""


@checked_arguments
def batch(
    trials: str | Path | Sequence[str | Path],
    *,
    method: str | None = None,
    settings: Mapping[str, Any] | None = None,
    out: str | Path | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    report: Callable[[str], None] | None = None,
    command: Sequence[str] | None = None,
) -> BatchReport:
    """Track many trials of any kind, each in a process of its own.

    Parameters
    ----------
    trials : str, Path, or sequence of them
        ``trial.toml`` files, folders that hold one, or folders of such folders, such as one
        folder an animal.
    method : str, optional
        Method of the tracker; default that of each kind of trial.
    settings : mapping, optional
        Settings of the tracker, as for :func:`pawnb.track`.
    out : str or Path, optional
        Folder for a folder of results for each trial, by its name; default ``results`` beside
        each trial.
    workers : int, optional
        How many trials at once on this machine; default 1.
    scheduler : str, optional
        Address of a Dask scheduler, whose workers then track: as many trials at once as they
        have threads. They must reach trials and results under the same paths.
    report : callable, optional
        Told a line about each trial as it ends.
    command : sequence of str, optional
        The command line, for the provenance.

    Returns
    -------
    BatchReport
        What became of each. An interrupt (Ctrl-C) stops the trials under way, which keep what
        is done, and leaves the others; run it again to go on.

    Raises
    ------
    InputError
        If there is no trial, ``workers`` is below 1 or given beside ``scheduler``, or no
        scheduler answers.

    Examples
    --------
    >>> report = pawnb.batch(["sample"], out="batch")
    >>> len(report.failed)
    0
    """
    if workers is not None and scheduler is not None:
        raise InputError(
            "workers and scheduler were both given; a scheduler has its own workers: leave one out."
        )
    if workers is not None and workers < 1:
        raise InputError(f"workers is {workers}; expected 1 or more.")
    jobs = [_Job(path, number) for number, path in enumerate(find_trials(trials), start=1)]
    tell = report if report is not None else lambda _line: None
    asked = {"method": method, "settings": dict(settings or {}), "command": list(command or ())}
    places: Places = Processes(workers or 1) if scheduler is None else Scheduler(scheduler)
    with contextlib.closing(places):
        _work(jobs, places, asked, out=out, tell=tell)
    rows = [(str(job.path), job.out or "", job.status, job.said, job.verdict) for job in jobs]
    columns = ["trial", "out", "status", "said", "verdict"]
    return BatchReport(pd.DataFrame(rows, columns=columns))


def _work(
    jobs: Sequence[_Job],
    places: Places,
    asked: Mapping[str, Any],
    *,
    out: str | Path | None,
    tell: Callable[[str], None],
) -> None:
    """Track every job where there is room, until all are done or an interrupt stops them."""
    folders: dict[Path, Path] = {}
    waiting, running = deque(jobs), dict[int, _Job]()
    busy: list[_Job] | None = []  # looked at once more when all others are done
    with interruptible() as stopped:
        while (waiting and not stopped()) or running:
            while waiting and not stopped() and places.has_room():
                job = waiting.popleft()
                order = _order(job, asked, out, folders)
                if order is None:
                    tell(_line(job, len(jobs)))
                else:
                    places.begin(job.number, order)
                    running[job.number] = job
            if stopped():
                places.stop()
            for number, answer in places.ended().items():
                job = running.pop(number)
                job.status, job.said, job.verdict = answer
                if job.status == "failed" and job.out is not None:
                    _note(job)
                if job.status == "busy" and busy is not None:
                    busy.append(job)
                else:
                    tell(_line(job, len(jobs)))
            if busy and not waiting and not running:
                waiting, busy = deque(busy), None
            if running or waiting:
                places.wait(_POLL_S)


def _note(job: _Job) -> None:
    """Leave word of a failure with the trial, for who looks at it after the batch has ended."""
    with contextlib.suppress(PawnbError, OSError):  # the report says it in any case
        note_failure(str(job.out), job.said)


def find_trials(trials: str | Path | Sequence[str | Path]) -> list[Path]:
    """Return the folders or files of trials; a folder without one stands for those below it.

    Parameters
    ----------
    trials : str, Path, or sequence of them
        As for :func:`batch`.

    Returns
    -------
    list of Path
        Each once, in the order given.

    Warns
    -----
    InputWarning
        If trials lie deeper in a folder than is looked.

    Raises
    ------
    InputError
        If a folder holds no trial, or nothing is named.
    """
    found: dict[Path, Path] = {}

    def each() -> Iterator[Path]:
        for path in map(Path, each_of(trials, what="trials")):
            is_trial = not path.is_dir() or (path / "trial.toml").exists()
            inner = [] if is_trial else find_trial_files(path)
            if path.is_dir() and not is_trial and (deeper := find_too_deep(path)):
                warn_of_input(_say_deeper(path, deeper), InputWarning, stacklevel=4)
            yield from [toml.parent for toml in inner] or [path]

    for path in each():
        toml = path / "trial.toml" if path.is_dir() else path
        found.setdefault(toml.resolve(), path)
    if not found:
        raise InputError("no trials; name trial.toml files or the folders that hold them.")
    return list(found.values())


def _say_deeper(path: Path, folders: Sequence[Path]) -> str:
    """Say that trials lie too deep in a folder to be found."""
    n = len(folders)
    what = "a trial lies" if n == 1 else f"{n} trials lie"
    return (
        f"{path}: {what} too deep in it and {'is' if n == 1 else 'are'} left out, such as "
        f"{folders[0]}; name {folders[0].parent} and the like, too."
    )


def is_tracked(
    trial: Trial, out: str | Path, *, method: str, settings: Mapping[str, Any] | None = None
) -> bool:
    """Say whether a trial's results are whole and just what tracking it would make anew.

    Parameters
    ----------
    trial : Trial
        The trial.
    out : str or Path
        Folder of its results.
    method : str
        Method of the tracker.
    settings : mapping, optional
        Settings that go before those of the trial.

    Returns
    -------
    bool
        True where every file is as the last run wrote it, and that had the same method, settings,
        trial and checksums of every input. Corrections made since do not count against it.

    Raises
    ------
    InputError
        If the trial, or a setting, cannot be used.
    """
    chosen = settings_in_force(trial, method=method, settings=settings)
    more = trial_tracker(trial, method).more_files
    step = _tracked_before(Path(out), {*RESULT_FILES, *more})
    if step is None or not step.get("complete") or step["method"] != method:
        return False
    # as they come back from JSON
    same = step["settings"] == json.loads(json.dumps(chosen))
    same = same and step.get("trial") == trial_fingerprint(trial)
    return same and step["inputs"] == trial_checksums(trial)


def tracked_already(
    trial: Trial, out: Path, *, method: str, settings: Mapping[str, Any] | None
) -> TrialOutcome | None:
    """Return what to say of a trial that need not be tracked; None where it is to be tracked.

    Parameters
    ----------
    trial, out, method, settings
        As for :func:`is_tracked`.

    Returns
    -------
    TrialOutcome or None
        ``skipped``, with the verdict of before. None where results have to be described anew, too.

    Raises
    ------
    InputError
        As for :func:`is_tracked`; if corrections lie there that were made to other tracks.
    """
    if described_otherwise(trial, out, method=method, settings=settings):
        return None  # the worker describes the results anew
    if is_tracked(trial, out, method=method, settings=settings):
        return TrialOutcome("skipped", f"tracked already, {out}", read_verdict(out))
    if (out / "edits.jsonl").exists():
        raise InputError(
            f"{out} holds corrections made by hand to tracks of other files or settings; "
            "choose another folder with --out, or move them."
        )
    return None


def described_otherwise(
    trial: Trial, out: Path, *, method: str, settings: Mapping[str, Any] | None
) -> str:
    """Say in what the description alone differs from that of the results.

    Parameters
    ----------
    trial, out, method, settings
        As for :func:`is_tracked`.

    Returns
    -------
    str
        Words; empty where nothing differs, or more than the name, animal, group and gait do.
    """
    said = changed_words(trial, out)
    then = as_tracked_before(trial, out) if said else None
    if then is None or not is_tracked(then, out, method=method, settings=settings):
        return ""
    return said


def _tracked_before(out: Path, files: set[str]) -> dict[str, Any] | None:
    """Return the record of the last tracking in whole results, or None."""
    known = known_files(out)
    listed = {*known.files, MANIFEST}
    # results of an earlier version, perhaps corrected since, are without a verdict
    if not listed.issuperset(files - {QUALITY_FILE}) or find_fault(out, run="track") is not None:
        return None
    made = [step for step in known.steps_of("track") if step["step"] == "track"]
    return made[-1] if made else None


def _order(
    job: _Job, asked: Mapping[str, Any], out: str | Path | None, folders: dict[Path, Path]
) -> dict[str, Any] | None:
    """Return what a worker is to do for a job; None, and the reason, where there is nothing."""
    try:
        trial = load_trial(job.path)
        method = asked["method"] or DEFAULT
        folder = results_folder(
            trial, None if out is None else child_folder(out, trial.name, what="the trial")
        )
        job.out = str(folder)
        first = folders.setdefault(folder.resolve(), job.path)
        if first != job.path:
            raise InputError(f"its results would overwrite those of {first}; rename one of them.")
        done = tracked_already(trial, folder, method=method, settings=asked["settings"])
        if done is not None:
            job.status, job.said, job.verdict = done
            return None
    except PawnbError as error:
        job.status, job.said = "failed", str(error)
        return None
    return {**asked, "trial": str(job.path), "method": method, "out": job.out}


def _line(job: _Job, total: int) -> str:
    """Return one line about a trial that ended."""
    return f"{job.number}/{total} {job.path}: {job.status}: {job.said}"
