"""What was done, with what, to what: the record that every result carries.

The record holds no time of day and no absolute path, so that the same inputs and
versions give the same bytes.
"""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import importlib.metadata
import json
import platform
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pawnb.errors import InputError
from pawnb.trial import Trial, trial_document

_PACKAGES = ("pawnb", "numpy", "scipy", "pandas", "xarray", "scikit-image", "scikit-learn",
             "statsmodels", "numba", "opencv-python-headless", "av", "astropy",
             "matplotlib")  # fmt: skip


def package_versions() -> dict[str, str]:
    """Return the versions of Python and of the packages that shape a result."""
    return dict(_versions())


@functools.cache
def _versions() -> Mapping[str, str]:
    """Return them as a session found them first: to look for all takes 0.1 s."""
    versions = {"python": platform.python_version()}
    for name in _PACKAGES:
        try:
            versions[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            versions[name] = "not installed"
    from pawnb.core.paws.offline.detection.evidence import ENTRY_POINTS  # slow to import

    # packages that offer kinds of evidence shape tracks by being installed
    for entry in importlib.metadata.entry_points(group=ENTRY_POINTS):
        if entry.dist is not None:
            versions[entry.dist.name] = entry.dist.version
    return versions


def file_checksum(path: str | Path) -> str:
    """Return the SHA-256 of a file, a folder of files, or the files of a glob.

    Parameters
    ----------
    path : str or Path
        A file; a folder, for the files directly in it; or a glob. Of several files
        the names and contents are hashed in the order of their names.

    Returns
    -------
    str
        ``"sha256:..."``.

    Raises
    ------
    InputError
        If there is no such file.
    """
    path = Path(path)
    if path.is_dir():
        files = sorted(item for item in path.iterdir() if item.is_file())
    elif path.is_file():
        files = [path]
    else:
        found = path.parent.glob(path.name) if path.parent.is_dir() else ()
        files = sorted(item for item in found if item.is_file())  # a pipe would never end
    if not files:
        raise InputError(f"{path}: no such file; check the path in the trial.")
    states = [(file, file.stat()) for file in files]
    return _checksum(tuple((file, state.st_size, state.st_mtime_ns) for file, state in states))


@functools.lru_cache(maxsize=256)
def _checksum(files: tuple[tuple[Path, int, int], ...]) -> str:
    """Return the checksum of files, read once as long as size and time of change stay."""
    digest = hashlib.sha256()
    for file, _, _ in files:
        if len(files) > 1:
            digest.update(file.name.encode())
        with file.open("rb") as stream:
            while block := stream.read(1 << 20):
                digest.update(block)
    return "sha256:" + digest.hexdigest()


def trial_inputs(trial: Trial, *, start: bool = True) -> list[str]:
    """Return the paths, relative to the trial's folder, of the files that a trial names.

    Parameters
    ----------
    trial : Trial
        The trial.
    start : bool
        Whether the start clicks count: not where they were given otherwise.

    Returns
    -------
    list of str
        Videos, backgrounds, species file, calibration, start, tracks, predictions, weights, belt
        speed.
    """
    paths = [view.video for view in trial.views]
    paths += [view.background for view in trial.views if view.background]
    species = trial.animal.species
    if trial.is_jointed and species and trial.path(species).is_file():
        paths.append(species)
    if trial.calibration is not None:
        paths += [p for p in (trial.calibration.of_views, trial.calibration.lens) if p]
    if start:
        paths += [p for p in (trial.start_file(), trial.start_pose_file()) if p]
    paths += trial.track_files
    paths += trial.detections.values()
    paths += [trial.point_tracker] if trial.point_tracker else []
    if isinstance(trial.belt_speed, str):
        paths.append(trial.belt_speed)
    return list(dict.fromkeys(paths))


def trial_checksums(trial: Trial, *, start: bool = True) -> dict[str, str]:
    """Return the checksum of every file the trial names, by its name in the trial.

    Parameters
    ----------
    trial : Trial
        The trial.
    start : bool
        As for :func:`trial_inputs`.

    Returns
    -------
    dict
        ``"sha256:..."`` by name.
    """
    sums = {}
    for path in trial_inputs(trial, start=start):
        sums[name_on_record(path)] = file_checksum(trial.path(path))
    return sums


def name_on_record(path: str) -> str:
    """Return what records call a file that a trial names: no absolute path stands in them."""
    return Path(path).name if Path(path).is_absolute() else path


def film_sizes(trial: Trial) -> dict[str, int]:
    """Return how many bytes each film of a trial has, by its name there.

    Of films of other sizes it is known without reading them that they are others, whatever clocks
    say of when they were written.

    Parameters
    ----------
    trial : Trial
        The trial.

    Returns
    -------
    dict
        Bytes by name; views of single pictures are left out.
    """
    films = {view.video: trial.path(view.video) for view in trial.views}
    return {
        name_on_record(name): film.stat().st_size for name, film in films.items() if film.is_file()
    }


def trial_fingerprint(trial: Trial) -> str:
    """Return a checksum of what a trial says: all but its settings of tracker and gait.

    Parameters
    ----------
    trial : Trial
        The trial.

    Returns
    -------
    str
        ``"sha256:..."``; the same wherever the trial's folder lies.
    """
    document = trial_document(dataclasses.replace(trial, tracking={}, gait={}))
    text = json.dumps(_without_folders(document), sort_keys=True)
    return "sha256:" + hashlib.sha256(text.encode()).hexdigest()


def _without_folders(value: Any) -> Any:
    """Return plain values in which absolute paths are cut to their last part."""
    if isinstance(value, dict):
        return {name: _without_folders(item) for name, item in value.items()}
    if isinstance(value, list):
        return [_without_folders(item) for item in value]
    return Path(value).name if isinstance(value, str) and Path(value).is_absolute() else value


def plain_command(argv: Sequence[str]) -> str:
    """Return a command line without ``--out``, its absolute paths cut to their last part.

    Where results were written shapes none of them: the same inputs give the same bytes in
    any folder.
    """
    words = []
    skip = False
    for word in argv:
        name, equals, value = word.partition("=")
        if skip or name == "--out":
            skip = not skip and not equals
            continue
        if equals and Path(value).is_absolute():
            word = f"{name}={Path(value).name}"
        elif Path(word).is_absolute():
            word = Path(word).name
        words.append(f'"{word}"' if " " in word else word)
    return " ".join(words)


def build_step(
    name: str,
    *,
    command: Sequence[str] | None,
    inputs: Mapping[str, str],
    settings: Mapping[str, Any],
    **more: Any,
) -> dict[str, Any]:
    """Return the record of one step: what was done, with what, to what.

    Parameters
    ----------
    name : str
        ``track``, ``retrack``, ``gait``.
    command : sequence of str, optional
        The command line, or None when called from Python.
    inputs : mapping
        Checksums by name of input.
    settings : mapping
        Every setting that was in force.
    **more
        Further entries that can be written as JSON, such as the method, or under
        ``sources`` the steps that made the inputs.

    Returns
    -------
    dict
        Keys ``step``, ``command``, ``versions``, ``inputs``, ``settings`` and those of ``more``.
    """
    return {
        "step": name,
        "command": None if command is None else plain_command(command),
        "versions": package_versions(),
        "inputs": dict(sorted(inputs.items())),
        "settings": dict(settings),
        **more,
    }


def provenance_text(
    steps: Sequence[Mapping[str, Any]], *, files: Mapping[str, Mapping[str, str]]
) -> str:
    """Return the text of ``provenance.json``; the same content gives the same bytes.

    Parameters
    ----------
    steps : sequence of mapping
        Records of :func:`build_step`, oldest first.
    files : mapping
        What is known of each file that was written, by its name; see
        :class:`pawnb.workflow.provenance.manifest.Manifest`.

    Returns
    -------
    str
        JSON.
    """
    document = {"files": dict(files), "steps": [dict(step) for step in steps]}
    return json.dumps(document, indent=1, sort_keys=True) + "\n"
