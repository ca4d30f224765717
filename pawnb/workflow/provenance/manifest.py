"""What a folder of results holds, and whether it is whole.

``provenance.json`` lists every file that a run wrote, with its SHA-256. A run makes its files in
a hidden folder beside them; when all are there it puts the list aside (as
``provenance.unfinished.json``), moves the files to their places, and writes the new list last. So
a run that ends early changes nothing, and one that is killed while it moves its files leaves a
folder that says so.

Runs of several kinds may share a folder: each kind (tracking, gait) replaces its own files, and
leaves the others and their records as they are.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from pawnb.errors import InputError, InputWarning
from pawnb.files import (
    Listing,
    check_file,
    check_replaceable,
    child_folder,
    keep_copy,
    locked,
    read_text,
    staged,
    staged_files,
)
from pawnb.gait.events.event_edits import EVENT_EDITS_FILE
from pawnb.input_warnings import warn_of_input
from pawnb.workflow.provenance.labels import is_labelled
from pawnb.workflow.provenance.record import provenance_text

RunKind = Literal["track", "gait"]
RUN_KINDS: tuple[RunKind, ...] = ("track", "gait")

MANIFEST = "provenance.json"
PUT_ASIDE = "provenance.unfinished.json"
"""The list of before, while files are moved; it is there afterwards only if a run was killed."""

_OWN = "before"
"""In the name of the copy of a file that is not a run's: ``animals.before.csv``."""
_BUSY = "wait until it has ended, or choose another folder with --out"


@dataclass(frozen=True)
class Manifest:
    """What ``provenance.json`` says.

    Parameters
    ----------
    steps : list of dict
        Records of :func:`pawnb.workflow.provenance.record.build_step`, oldest first.
    files : dict
        The files by their names in the folder: ``sha256`` and ``run``, the kind that wrote it.
    """

    steps: list[dict[str, Any]]
    files: dict[str, dict[str, str]]

    def files_of(self, run: RunKind) -> dict[str, str]:
        """Return the checksums of the files that a kind of run wrote, by name."""
        return {name: file["sha256"] for name, file in self.files.items() if file["run"] == run}

    def steps_of(self, run: RunKind) -> list[dict[str, Any]]:
        """Return the steps of a kind of run."""
        return [step for step in self.steps if (step.get("step") == "gait") == (run == "gait")]


@contextmanager
def writing_results(
    folder: str | Path, *, run: RunKind, steps: Sequence[Mapping[str, Any]]
) -> Iterator[Path]:
    """Write the results of a run, all or none of them.

    Files that the last run of this kind left and this one does not write are removed where they
    are as it wrote them; of others a warning says that they stay.

    Parameters
    ----------
    folder : str or Path
        The folder; it must exist.
    run : {"track", "gait"}
        Kind of run.
    steps : sequence of mapping
        Its steps, oldest first.

    Yields
    ------
    Path
        Where to write: what is there when the block ends goes to ``folder`` under the same names.

    Raises
    ------
    InputError
        If another run writes there, or a file cannot be written.
    """
    folder = Path(folder)
    with run_alone(folder), staged(folder, elsewhere="another folder with --out") as staging:
        yield staging
        _move_in(folder, staging, run, steps)


@contextmanager
def run_alone(folder: Path) -> Iterator[None]:
    """Keep other runs out of a folder of results; :func:`writing_results` may follow within.

    Raises
    ------
    InputError
        If another run writes there, or a file of the last one is held open by another program:
        a run of hours should not end with that.
    """
    with locked(folder, remedy=_BUSY):
        check_replaceable(folder / name for name in known_files(folder).files)
        yield


def read_manifest(folder: str | Path, *, name: str = MANIFEST) -> Manifest | None:
    """Read what a folder of results should hold.

    Parameters
    ----------
    folder : str or Path
        The folder.
    name : str
        The file.

    Returns
    -------
    Manifest or None
        None where there is no such file, or it is damaged.
    """
    try:
        document = json.loads(read_text(Path(folder) / name, expected="a manifest"))
        files = document.get("files", {})
        named = all({"sha256", "run"} <= set(file) for file in files.values())
        steps = [step for step in document["steps"] if isinstance(step, dict)]
    except (OSError, ValueError, RecursionError, TypeError, KeyError, AttributeError):
        return None
    return Manifest(steps, files) if named else None


def known_files(folder: Path) -> Manifest:
    """Return what is known of a folder, also after a run was killed in it."""
    return read_manifest(folder) or read_manifest(folder, name=PUT_ASIDE) or Manifest([], {})


def find_fault(folder: str | Path, *, run: RunKind) -> str | None:
    """Say what keeps a folder from holding whole results of a kind of run.

    Parameters
    ----------
    folder : str or Path
        The folder.
    run : {"track", "gait"}
        Kind of run.

    Returns
    -------
    str or None
        One sentence with the remedy; None where every file is as that run wrote it.
    """
    folder = Path(folder)
    again = f"run pawnb {run} again"
    manifest, before = read_manifest(folder), read_manifest(folder, name=PUT_ASIDE)
    known = manifest or before
    if known is None:
        return f"{folder}: no {MANIFEST} says what belongs here, so it may not be whole; {again}."
    files = known.files_of(run)
    changed = [name for name, sha256 in files.items() if _sha256(folder / name) != sha256]
    if manifest is None and (changed or not files):
        return (
            f"{folder}: the last run was ended while it wrote, so that files of two runs may be "
            f"mixed; {again}."
        )
    if not files:
        return f"{folder}: {MANIFEST} lists no files of pawnb {run}; if there are any, {again}."
    if changed:
        gone = [name for name in changed if not (folder / name).exists()]
        what = f"{'missing' if gone else 'changed'}: {', '.join((gone or changed)[:3])}"
        return (
            f"{folder}: not as pawnb {run} left it ({what}); {again}, or go on if that was meant."
        )
    return _made_before(folder, known, run, again=again)


def _made_before(folder: Path, known: Manifest, run: RunKind, *, again: str) -> str | None:
    """Say that what a run read here has changed since, where it has."""
    if run == "track":
        return None  # of other files than its results
    read = {EVENT_EDITS_FILE: ""}  # made since then where no run has read it
    for step in known.steps_of(run):
        for label, checksum in step.get("inputs", {}).items():
            name = label.rpartition("/")[2]
            if is_labelled(folder.resolve() / name, label):
                read[name] = checksum.removeprefix("sha256:")
    for name, checksum in read.items():
        if (folder / name).exists() and _sha256(folder / name) != checksum:
            return f"{folder}: {name} has changed since the gait was analysed; {again}."
    return None


def _move_in(folder: Path, staging: Path, run: RunKind, steps: Sequence[Mapping[str, Any]]) -> None:
    """Move what a run made to its place, and say last what is there."""
    before = known_files(folder)
    made = {name: _sha256(staging / name) for name in staged_files(staging)}
    sums = {name: sha256 for name, sha256 in made.items() if sha256 is not None}
    for name in sums:
        if len(parts := Path(name).parts) > 1:
            child_folder(folder, parts[0], what="the folder of figures").mkdir(exist_ok=True)
        if (folder / name).is_dir():
            raise InputError(f"{folder / name}: a folder; a file of that name belongs there.")
    own_copies = _copies_of_own(folder, sums)
    files = {name: file for name, file in before.files.items() if file["run"] != run}
    files |= {name: {"run": run, "sha256": sha256} for name, sha256 in sums.items()}
    other: RunKind = "gait" if run == "track" else "track"
    own, others = [dict(step) for step in steps], before.steps_of(other)
    manifest = Manifest([*own, *others] if run == "track" else [*others, *own], files)
    others_of_before = {n: sha for n, sha in before.files_of(run).items() if n not in sums}
    now = {name: _sha256(folder / name) for name in others_of_before}
    gone = [name for name, sha256 in others_of_before.items() if now[name] == sha256]
    Listing(folder, MANIFEST, PUT_ASIDE).replace(
        staging, sums, gone=gone, listing=_text(manifest).encode(),
        empty=_text(Manifest([], {})).encode(),
    )  # fmt: skip
    if own_copies:
        said = ", ".join(f"{name} as {copy}" for name, copy in own_copies.items())
        warn_of_input(
            f"{folder}: files that lay here and were not as a run of pawnb wrote them are kept "
            f"under other names: {said}.", InputWarning, stacklevel=4,
        )  # fmt: skip
    if kept := [name for name in others_of_before if now[name] is not None and name not in gone]:
        verb = "was" if len(kept) == 1 else "were"
        warn_of_input(
            f"{folder}: {', '.join(kept)} {verb} changed by hand after an earlier run, and this "
            "run writes no such file: kept, but not of these results; take it away or give it "
            "another name.", InputWarning, stacklevel=4,
        )  # fmt: skip


def _copies_of_own(folder: Path, sums: Mapping[str, str]) -> dict[str, str]:
    """Keep copies of files that a run will write over and a person has made or changed.

    Results of a file lie beside it by default, where a lab's own animals.csv may be.
    """
    manifest = read_manifest(folder)
    if manifest is None and (folder / PUT_ASIDE).exists():
        return {}  # a run was killed here: whose files are whose is not known
    listed = {} if manifest is None else manifest.files
    now = {name: sha256 for name in sums if (sha256 := _sha256(folder / name)) is not None}
    return {
        name: keep_copy(folder / name, _OWN).relative_to(folder).as_posix()
        for name, sha256 in now.items()
        if sha256 not in (sums[name], listed.get(name, {}).get("sha256"))
        and (folder / name).stat().st_size  # nothing is lost with an empty one
    }


def _text(manifest: Manifest) -> str:
    """Return a manifest as the text of its file."""
    return provenance_text(manifest.steps, files=manifest.files)


def _sha256(path: Path) -> str | None:
    """Return the SHA-256 of a file; None where there is none."""
    try:
        with check_file(path).open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except (OSError, InputError):
        return None
