"""A figure or a table made again from what it carries, and compared with what it was."""

from __future__ import annotations

import json
import shlex
import tempfile
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from pawnb import figures
from pawnb.core.edits.log import replay
from pawnb.core.paws.offline.reuse.kept_evidence import GONE_ON_FROM
from pawnb.core.video import open_views
from pawnb.errors import InputError, PawnbError
from pawnb.input_warnings import hearing_input_warnings
from pawnb.schema import Tracks, add_provenance
from pawnb.schema.arguments import checked_arguments
from pawnb.trial import Trial, load_trial
from pawnb.workflow.evaluation.compare import draw_comparison
from pawnb.workflow.gait.drawing.draw_figure import STEP, redraw
from pawnb.workflow.gait.request import ASKED, GaitRequest, TakenOver
from pawnb.workflow.gait.run import carry_out
from pawnb.workflow.provenance.find_inputs import find_inputs, places_of
from pawnb.workflow.provenance.manifest import MANIFEST, read_manifest
from pawnb.workflow.provenance.recipes import FIGURE_ENDINGS, Recipe, read_recipe
from pawnb.workflow.provenance.record import package_versions, trial_fingerprint, trial_inputs
from pawnb.workflow.provenance.report.index_page import INDEX_FILE
from pawnb.workflow.provenance.results import provenance_steps, write_track_results
from pawnb.workflow.provenance.same_content import tell_difference, tell_versions
from pawnb.workflow.tracking.kept_candidates import new_session
from pawnb.workflow.tracking.track import retrack, track
from pawnb.workflow.tracking.trial_views import trial_rig

EXIT_DIFFERS = 3
_MOST_SHOWN = 4
_EDITS = "edits.jsonl"


@dataclass(frozen=True)
class Reproduction:
    """What came of making a file again.

    Parameters
    ----------
    path : Path
        The file.
    difference : str or None
        In what the new one differs; None where it is the same, byte for byte.
    versions : str or None
        Which packages have other versions than those it was made with.
    fault : str or None
        Why it could not be made again.
    """

    path: Path
    difference: str | None
    versions: str | None
    fault: str | None = None

    @property
    def identical(self) -> bool:
        """Whether it was made again, and every byte is the same."""
        return self.difference is None and self.fault is None

    def text(self) -> str:
        """Return what was found, in one line."""
        if self.fault is not None:
            return f"{self.path}: not made again"
        if self.difference is None:
            return f"{self.path}: identical"
        why = f" (made with {self.versions})" if self.versions else ""
        return f"{self.path}: differs: {self.difference}{why}"


@checked_arguments
def reproduce(path: str | Path, *, inputs: str | Path | None = None) -> Reproduction:
    """Make a figure or a table again from what it carries, and say whether it is the same.

    The inputs are found by their names in the folders about the file and told by their checksums;
    corrections made by hand are made again. Nothing is written but in a temporary folder.

    Parameters
    ----------
    path : str or Path
        A figure (png, svg, pdf), wherever it lies, or any file that a ``provenance.json`` lists:
        tables of ``pawnb gait``, tracks and their tables of ``pawnb track``, which is then done
        again.
    inputs : str or Path, optional
        Folder to look for the inputs in; default the folder of the file, and those it lies in.

    Returns
    -------
    Reproduction
        Whether it is identical, and if not, in what it differs.

    Raises
    ------
    InputError
        If the file carries no recipe, or one of its inputs has changed or is not there.

    Examples
    --------
    >>> run = pawnb.run_gait("sample/results", figures="none")
    >>> pawnb.reproduce("sample/results/strides.csv").identical
    True
    """
    (found,) = reproduce_all([path], inputs=inputs)
    if found.fault is not None:
        raise InputError(found.fault)
    return found


def reproduce_all(
    paths: Sequence[str | Path], *, inputs: str | Path | None = None
) -> list[Reproduction]:
    """Make files again; those of one run together, which takes no longer than one.

    Parameters
    ----------
    paths : sequence of str or Path
        The files.
    inputs : str or Path, optional
        As for :func:`reproduce`.

    Returns
    -------
    list of Reproduction
        What came of each, in their order; of those that cannot be made again, why.
    """
    found: dict[Path, Reproduction] = {}
    for run in _runs(map(Path, paths), found):
        try:
            found |= _make(run, inputs)
        except PawnbError as error:
            found |= {path: _not_made(path, error) for path, _ in run}
    return [found[Path(path)] for path in paths]


def tell_not_made(found: Sequence[Reproduction]) -> str | None:
    """Say which files could not be made again, and why.

    Parameters
    ----------
    found : sequence of Reproduction
        What came of files.

    Returns
    -------
    str or None
        One sentence; None where all were made.
    """
    by_reason: dict[str, list[str]] = {}
    for one in found:
        if one.fault is not None:
            reason = one.fault.removeprefix(f"{one.path}: ").rstrip(".")
            by_reason.setdefault(reason, []).append(one.path.name)
    if len(found) == 1 or not by_reason:
        return found[0].fault if by_reason else None
    said = [
        ", ".join(names[:_MOST_SHOWN])
        + (f" and {len(names) - _MOST_SHOWN} more" if len(names) > _MOST_SHOWN else "")
        + f": {reason}"
        for reason, names in by_reason.items()
    ]
    n = sum(map(len, by_reason.values()))
    return f"{n} of {len(found)} files could not be made again: {'; '.join(said)}."


def _runs(
    paths: Iterable[Path], refused: dict[Path, Reproduction]
) -> list[list[tuple[Path, Recipe]]]:
    """Return files with their recipes, those of one run together; add those without to refused."""
    together: dict[tuple[str, str], list[tuple[Path, Recipe]]] = {}
    tables: dict[str, list[tuple[Path, Recipe]]] = {}
    for path in paths:
        try:
            recipe = _known_recipe(path)
        except PawnbError as error:
            refused[path] = _not_made(path, error)
            continue
        step, style = (json.dumps(own, sort_keys=True) for own in (recipe.step, recipe.style))
        if path.suffix.lower() in FIGURE_ENDINGS:
            together.setdefault((step, style), []).append((path, recipe))
        else:
            tables.setdefault(step, []).append((path, recipe))
    # a table has no style: it is made with figures of its run, where there are any
    for step, own_tables in tables.items():
        key = next((key for key in together if key[0] == step), (step, ""))
        together.setdefault(key, []).extend(own_tables)
    return list(together.values())


def _known_recipe(path: Path) -> Recipe:
    """Return how a file was made, if this version can do it again."""
    recipe = read_recipe(path)
    if recipe.kind not in _MAKERS:
        raise InputError(f"{path}: made by {recipe.kind!r}, which this version cannot do again.")
    return recipe


def _not_made(path: Path, error: PawnbError) -> Reproduction:
    """Return that a file cannot be made again, and why."""
    return Reproduction(path, None, None, fault=str(error))


def made_files(folder: str | Path) -> list[Path]:
    """Return what can be made again of a folder: all that its list names, else its figures.

    Parameters
    ----------
    folder : str or Path
        A folder of results, or one of figures.

    Returns
    -------
    list of Path
        Their paths, sorted; of a folder of figures without those of inner folders.

    Raises
    ------
    InputError
        If there is nothing.
    """
    folder = Path(folder)
    manifest = read_manifest(folder)
    if manifest is None:
        found = [path for path in folder.iterdir() if path.suffix.lower() in FIGURE_ENDINGS]
    else:
        found = [folder / name for name in manifest.files]
    if not found:
        raise InputError(f"{folder}: holds no figure and no {MANIFEST}; name files to make again.")
    return sorted(found)


class _Task(NamedTuple):
    """What is to be made again: by which record, which files, with inputs where, to where."""

    step: dict[str, Any]
    names: tuple[str, ...]
    places: list[Path]
    path: Path
    out: Path


def _make(files: list[tuple[Path, Recipe]], inputs: str | Path | None) -> dict[Path, Reproduction]:
    """Make files of one run again and compare each."""
    path, recipe = files[0]
    other = tell_versions(recipe.step.get("versions", {}), package_versions())
    found = {}
    with tempfile.TemporaryDirectory(prefix="pawnb-") as folder:
        # the run itself has told its warnings
        with hearing_input_warnings(str, shown=False), figures.style(**recipe.style):
            names = tuple(own.name for _, own in files)
            task = _Task(recipe.step, names, places_of(path, inputs), path, Path(folder))
            _MAKERS[recipe.kind](task)
        for file, own in files:
            made = Path(folder) / own.name
            gone = f"{own.name} is not made any more from these inputs"
            found[file] = Reproduction(
                file, tell_difference(file, made) if made.exists() else gone, other
            )
    return found


def _make_gait(task: _Task) -> None:
    """Analyse the gait again."""
    step = task.step
    if not {"given", "edits", *ASKED} <= set(step):
        raise InputError(
            f"{task.path}: made by a version of pawnb that did not keep all that is needed to make "
            "it again; run pawnb gait anew."
        )
    found = find_inputs(step["inputs"], task.places, of=task.path)
    asked = {name: step[name] for name in ASKED}
    settings = asked.pop("set")
    figures_of = [name for name in task.names if name.startswith("figures/")]
    # notes hold the warnings of all that was drawn, and the index shows it
    if not figures_of and not {"notes.csv", INDEX_FILE} & set(task.names):
        asked["figures"] = "none"
    drawn = {Path(name).stem for name in figures_of}
    every = {"notes.csv", INDEX_FILE, "figures/not_drawn.csv"} & set(task.names)
    given = [found[label] for label in step["given"]]
    request = GaitRequest(inputs=given, settings=settings, **asked)
    again = TakenOver(
        labels={file: label for label, file in found.items()},
        edits=tuple(found[label] for label in step["edits"]),
        command=step["command"],
        only=None if every else drawn,
    )
    carry_out(request, out=task.out, again=again)


def _make_tracks(task: _Task) -> None:
    """Track again, and make the corrections of before again."""
    step = task.step
    trial = _find_trial(step, task.places, task.path)
    paths = map(Path, trial_inputs(trial))
    known = {one.name if one.is_absolute() else one.as_posix() for one in paths}
    if not set(step["inputs"]) <= known:
        raise InputError(f"{task.path}: its trial names other files now than it was made of.")
    find_inputs(step["inputs"], [trial.folder.absolute()], of=task.path)
    started = {trial.start_file(), trial.start_pose_file()} & set(step["inputs"])
    command = step.get("command")
    last = None if started else pd.DataFrame(step["start"])
    with new_session():
        # clicks that were added go on from what earlier ones gave
        for start in [*map(pd.DataFrame, step.get(GONE_ON_FROM, [])), last]:
            tracks = track(
                trial,
                method=step["method"],
                settings=step["settings"],
                start=start,
                frames=(step["frames"][0], step["frames"][1]),
                quick=True,
                command=None if command is None else shlex.split(command),
            )
    with open_views(trial) as views:
        rig = trial_rig(trial, views, method=step["method"])
    later = step.get("later", [])
    if any(one["step"] == "edit" for one in later):
        edits = task.path.absolute().parent / _EDITS
        scale = trial.calibration.px_per_unit if trial.calibration is not None else None

        def tracker(present: Any, frame: int, **options: Any) -> Any:
            return retrack(trial, present, frame, **options)

        tracks = replay(tracks, edits, rig=rig, px_per_unit=scale, retrack=tracker)
    write_track_results(_as_reviewed(tracks, later), task.out, rig=rig)


def _as_reviewed(tracks: Tracks, later: list[dict[str, Any]]) -> Tracks:
    """Return tracks with the record of their review: how often they were saved, and its minutes.

    Corrections are made again in one go, and nobody's minutes are: where the same corrections are
    in force in the end, and all else is recorded alike, the record is that of the review.
    """
    made = provenance_steps(tracks)
    if any(_split(made[1:])[k] != _split(later)[k] for k in ("edit", "other")):
        return tracks
    tracks = tracks.assign_attrs(provenance="{}")
    for step in [made[0], *later]:
        tracks = add_provenance(tracks, **step)
    return tracks


def _split(steps: list[dict[str, Any]]) -> dict[str, list[dict[str, Any]]]:
    """Return the corrections in force after steps, and the steps that are no part of a review."""
    return {
        "edit": [one for one in steps if one["step"] == "edit"][-1:],
        "other": [one for one in steps if one["step"] not in ("edit", "review")],
    }


def _find_trial(step: dict[str, Any], places: list[Path], path: Path) -> Trial:
    """Return the trial that a record is about."""
    other = None
    for place in places:
        file = place / "trial.toml"
        if file.is_file():
            trial = load_trial(file)
            if trial_fingerprint(trial) == step["trial"]:
                return trial
            other = other or file
    if other is not None:
        raise InputError(
            f"{other} has changed since {path.name} was made, so that cannot be made again; put "
            "the trial from then back, or track it anew."
        )
    raise InputError(
        f"the trial.toml of which {path.name} was made is not there; name its folder with --inputs."
    )


def _make_comparison(task: _Task) -> None:
    """Draw the comparison of methods again from its tables."""
    found = find_inputs(task.step["inputs"], task.places, of=task.path)
    draw_comparison(list(found.values()), task.out / "figures", settings=task.step["settings"],
                    labels=found)  # fmt: skip


def _make_drawing(task: _Task) -> None:
    """Draw a figure of one's own again from its tables."""
    step = task.step
    found = find_inputs(step["inputs"], task.places, of=task.path)
    files = {name: found[label] for name, label in step["tables"].items()}
    for name in {Path(one).stem for one in task.names}:
        (task.out / "figures").mkdir(exist_ok=True)
        redraw({**step, "name": name}, files, task.out / "figures")


_MAKERS: dict[str, Callable[[_Task], None]] = {
    "gait": _make_gait, "track": _make_tracks, "compare": _make_comparison,
    STEP: _make_drawing,
}  # fmt: skip
