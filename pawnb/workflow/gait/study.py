"""A study: which trials of which animals, in which groups and conditions, with what covariates."""

from __future__ import annotations

import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pawnb.errors import InputError, InputWarning, did_you_mean
from pawnb.files import read_toml
from pawnb.input_warnings import warn_of_input
from pawnb.io.recognise import find_format
from pawnb.io.tables import read_cells, read_column_names
from pawnb.schema import shown
from pawnb.workflow.gait.species import Species, species_of

SECTIONS = ("study", "gait", "legs", "animals", "trials", "species")
COMPARED = ("group", "condition")
_OF_TRIAL = ("file", "animal", "name", "group", "condition", "fps", "gait")
_STUDY_COLUMNS = ("file", "animal", "name", "group", "condition")
_OTHER_TEXT = (".tsv", ".txt", ".tab")
_SETTING = "gait."
_STUDY_NEEDS = "every trial needs file = ... and animal = ..."


@dataclass(frozen=True, kw_only=True)
class StudyTrial:
    """One trial of a study.

    Parameters
    ----------
    path : Path
        What is analysed: a trial, results, tracks, or events scored by hand.
    animal : str
        Id of its animal.
    name : str, optional
        Name of the trial; default that which the file has.
    group, condition : str, optional
        To which it belongs.
    fps : float, optional
        Frames per second, for a file that does not say.
    settings : mapping
        Settings of the gait analysis of this trial.
    fields : mapping
        Covariates of the animal and of the trial: ``mass_g``, ``body_length``, age, sex.
    """

    path: Path
    animal: str
    name: str | None = None
    group: str | None = None
    condition: str | None = None
    fps: float | None = None
    settings: Mapping[str, Any] = field(default_factory=dict)
    fields: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Study:
    """What a study says.

    Parameters
    ----------
    path : Path
        Its file.
    trials : tuple of StudyTrial
        The trials, in their order.
    compare : {"group", "condition"}
        What is compared.
    settings : mapping
        Settings of the gait analysis of all trials.
    legs : mapping
        Names of legs to names of points, of all trials.
    species : tuple of Species
        Tables of other species beside which the animals are drawn.
    """

    path: Path
    trials: tuple[StudyTrial, ...]
    compare: str = "group"
    settings: Mapping[str, Any] = field(default_factory=dict)
    legs: Mapping[str, str] = field(default_factory=dict)
    species: tuple[Species, ...] = ()


def tell_if_meant_as_study(path: Path) -> None:
    """Refuse a table that names animals and is neither tracks, events nor a study.

    Raises
    ------
    InputError
        Which column a study lacks, or that its name ends in another way than ``.csv``.
    """
    if path.suffix.lower() not in (".csv", *_OTHER_TEXT) or find_format(path) is not None:
        return
    names = read_column_names(path, expected="a csv table")
    if path.suffix.lower() != ".csv":
        if {"file", "animal"} <= set(names):
            raise InputError(
                f"{path}: a study is a .csv; call it {path.stem}.csv (tabs between the cells are "
                "understood)."
            )
        return
    events = {"leg", "event", "frame"} & set(names)
    as_study = "animal" in [name.lower() for name in names]
    if as_study and not {"file", "animal"} <= set(names) and not events:
        raise InputError(
            f"{path}: no tracks. A study needs the columns 'file' (of each trial's tracks) and "
            f"'animal'; found {', '.join(names)}."
        )


def is_study(path: str | Path) -> bool:
    """Say whether a file is a study: a TOML with ``[[trials]]``, or a csv with file and animal.

    Parameters
    ----------
    path : str or Path
        A file or a folder.

    Returns
    -------
    bool
        False for whatever else, also where nothing is there.
    """
    path = Path(path)
    if not path.is_file():
        return False
    try:
        if path.suffix.lower() == ".toml":
            return "trials" in read_toml(path)
        if path.suffix.lower() == ".csv":
            return {"file", "animal"} <= set(read_column_names(path, expected="a csv table"))
    except InputError:
        return False  # whoever reads it next says what is wrong with it
    return False


def read_study(path: str | Path) -> Study:
    """Read a study.

    Parameters
    ----------
    path : str or Path
        ``study.toml``: ``[study] compare``, ``[gait]`` settings, ``[legs]``, ``[[animals]]`` with
        ``id`` and any fields, ``[[trials]]`` with ``file``, ``animal`` and, where they apply,
        ``name``, ``group``, ``condition``, ``fps``, ``gait = {...}`` and any fields, and
        ``[[species]]`` with ``file``, ``name``, ``group``, ``without``. Or a csv with
        a row a trial and these as columns, settings as ``gait.cutoff_hz``. Paths are relative to
        the study's folder.

    Returns
    -------
    Study
        The study.

    Warns
    -----
    InputWarning
        If an animal has no trial.

    Raises
    ------
    InputError
        If it cannot be read, names an animal or a trial twice, or has a part that is not known.
    """
    path = Path(path)
    study = _from_csv(path) if path.suffix.lower() == ".csv" else _from_toml(path)
    if not study.trials:
        raise InputError(f"{path}: no trial; {_STUDY_NEEDS}.")
    files = [trial.path.resolve() for trial in study.trials]
    for k, trial in enumerate(study.trials):
        if files[k] in files[:k]:
            raise InputError(f"{path}: {trial.path.name} is there twice; name each trial once.")
    return study


def _from_toml(path: Path) -> Study:
    """Read a study.toml."""
    document = read_toml(path, expected="a study")
    for name in document:
        if name not in SECTIONS:
            raise InputError(
                f"{path}: unknown section [{name}]{did_you_mean(name, SECTIONS)}; expected "
                f"{', '.join(SECTIONS)}."
            )
    head = _section(document, "study", path)
    compare = head.pop("compare", None)
    if head:
        name = next(iter(head))
        raise InputError(
            f"{path}: [study] has an unknown field {name!r}{did_you_mean(name, ['compare'])}; "
            "known is compare."
        )
    animals = {}
    for animal in _rows(document, "animals", path):
        own = str(animal.pop("id", ""))
        if not own or own in animals:
            raise InputError(f"{path}: [[animals]] id {own!r}: expected an id of its own for each.")
        animals[own] = animal
    trials = [_trial(row, path, animals) for row in _rows(document, "trials", path)]
    filmed = {trial.animal for trial in trials}
    if idle := [animal for animal in animals if animal not in filmed]:
        warn_of_input(
            f"{path.name}: {', '.join(idle)} of [[animals]] have no trial in [[trials]], and count "
            "nowhere.", InputWarning, stacklevel=4,
        )  # fmt: skip
    legs = _section(document, "legs", path)
    if not all(isinstance(point, str) for point in legs.values()):
        raise InputError(f'{path}: [legs] is {shown(legs)}; expected leg = "name in the file".')
    return Study(
        path=path, trials=tuple(trials), settings=_section(document, "gait", path), legs=legs,
        compare=_compared(compare, trials, path),
        species=tuple(species_of(row, path) for row in _rows(document, "species", path)),
    )  # fmt: skip


def _from_csv(path: Path) -> Study:
    """Read a study from a csv, a row a trial."""
    cells = read_cells(path, ("file", "animal"))
    trials = []
    for line, row in enumerate(cells.to_dict(orient="records"), start=2):
        own = {str(n): c if n in _STUDY_COLUMNS else _plain(c) for n, c in row.items() if c != ""}
        if not own:
            continue  # as spreadsheets leave them below a table
        if lacking := [name for name in ("file", "animal") if name not in own]:
            raise InputError(f"{path}: line {line}: {lacking[0]} is empty; {_STUDY_NEEDS}.")
        named = [name for name in own if name.startswith(_SETTING)]
        settings = {name.removeprefix(_SETTING): own.pop(name) for name in named}
        trials.append(_trial({**own, "gait": settings}, path, {}))
    return Study(path=path, trials=tuple(trials), compare=_compared(None, trials, path))


def _trial(
    row: Mapping[str, Any], path: Path, animals: Mapping[str, Mapping[str, Any]]
) -> StudyTrial:
    """Return one trial of a study."""
    file, animal = str(row.get("file", "")), str(row.get("animal", ""))
    if not file or not animal:
        raise InputError(f"{path}: a trial is {shown(dict(row))}; {_STUDY_NEEDS}.")
    if animals and animal not in animals:
        raise InputError(
            f"{path}: {file} is of animal {animal!r}{did_you_mean(animal, animals)}, which "
            f"[[animals]] does not have; there are {', '.join(animals)}."
        )
    known = {**animals.get(animal, {}), **row}
    fps = known.get("fps")
    if fps is not None and (isinstance(fps, bool) or not isinstance(fps, int | float)):
        raise InputError(f"{path}: {file}: fps is {shown(fps)}; expected a number.")
    settings = known.get("gait", {})
    if not isinstance(settings, dict):
        raise InputError(f"{path}: {file}: gait is {shown(settings)}; expected {{ name = value }}.")
    words = {n: str(known[n]) for n in ("name", "group", "condition") if n in known}
    fields = {name: value for name, value in known.items() if name not in _OF_TRIAL}
    for name, value in fields.items():
        meant = name.strip().casefold()
        if meant in _OF_TRIAL:
            raise InputError(f"{path}: {name!r} would not be read; write {meant!r}.")
        if isinstance(value, dict | list):
            hint = did_you_mean(name, _OF_TRIAL)
            if name == "legs":
                hint = " (legs have a section of their own, [legs])"
            raise InputError(
                f"{path}: {file}: {name} is {shown(value)}{hint}; expected a number or a word."
            )
    return StudyTrial(
        path=_as_on_disk(path.parent / file),
        animal=animal,
        fps=fps,
        settings=settings,
        fields=fields,
        **words,
    )


def _as_on_disk(path: Path) -> Path:
    """Return a path as it is on the disk, where letters such as ä may be written as two signs."""
    if path.exists() or not path.parent.is_dir():
        return path
    wanted = unicodedata.normalize("NFC", path.name)
    same = (
        one for one in path.parent.iterdir() if wanted == unicodedata.normalize("NFC", one.name)
    )
    return next(same, path)


def _compared(asked: Any, trials: list[StudyTrial], path: Path) -> str:
    """Return what is compared: groups where there are any, else conditions."""
    if asked is None:
        grouped = any(trial.group is not None for trial in trials)
        conditioned = any(trial.condition is not None for trial in trials)
        return "condition" if conditioned and not grouped else "group"
    if asked not in COMPARED:
        raise InputError(
            f"{path}: [study] compare is {shown(asked)}{did_you_mean(str(asked), COMPARED)}; "
            "expected 'group' or 'condition'."
        )
    return str(asked)


def _section(document: Mapping[str, Any], name: str, path: Path) -> dict[str, Any]:
    """Return a copy of a section."""
    section = document.get(name, {})
    if not isinstance(section, dict):
        raise InputError(f"{path}: [{name}] is {shown(section)}; expected a section with fields.")
    return dict(section)


def _rows(document: Mapping[str, Any], name: str, path: Path) -> list[dict[str, Any]]:
    """Return copies of sections that may be there often."""
    rows = document.get(name, [])
    if not (isinstance(rows, list) and all(isinstance(row, dict) for row in rows)):
        raise InputError(f"{path}: {name} is {shown(rows)}; write each under [[{name}]].")
    return [dict(row) for row in rows]


def _plain(cell: str) -> Any:
    """Return a cell as a number where it is one."""
    try:
        return float(cell) if not cell.isdigit() else int(cell)
    except ValueError:
        return cell
