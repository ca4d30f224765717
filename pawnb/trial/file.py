"""``trial.toml`` in and out."""

from __future__ import annotations

import os
from pathlib import Path

import tomli_w

from pawnb.errors import InputError
from pawnb.files import read_toml, write_whole
from pawnb.schema import shown
from pawnb.schema.arguments import checked_arguments
from pawnb.trial.description import Trial
from pawnb.trial.document import trial_document, trial_from_document

VIDEO_ENDINGS = (
    ".avi", ".mp4", ".mov", ".mkv", ".m4v", ".mpg", ".mpeg", ".wmv", ".webm", ".mts", ".cine",
)  # fmt: skip


_DEEPEST = 3
"""Folders below a folder of studies in which a trial may lie, such as group, animal and day: a
limit, so that a home folder named by mistake is not searched to its ends."""


def find_trial_files(folder: str | Path) -> list[Path]:
    """Return every ``trial.toml`` in a folder, in its folders, in theirs and in those of these.

    Parameters
    ----------
    folder : str or Path
        The folder; those whose name begins with a dot are passed over.

    Returns
    -------
    list of Path
        The files in the order of their names; empty where there is none.
    """
    folder = Path(folder)
    found: list[Path] = []
    for depth in range(_DEEPEST + 1):
        found += folder.glob("/".join([*["*"] * depth, "trial.toml"]))
    hidden = (file for file in found if any(p[0] == "." for p in file.relative_to(folder).parts))
    return sorted(set(found).difference(hidden))


def find_too_deep(folder: str | Path) -> list[Path]:
    """Return folders of trials that lie one folder deeper than :func:`find_trial_files` looks.

    Parameters
    ----------
    folder : str or Path
        The folder.

    Returns
    -------
    list of Path
        The folders in the order of their names; empty where there is none.
    """
    folder = Path(folder)
    found = folder.glob("/".join([*["*"] * (_DEEPEST + 1), "trial.toml"]))
    return sorted(
        file.parent for file in found if all(p[0] != "." for p in file.relative_to(folder).parts)
    )


@checked_arguments
def load_trial(path: str | Path) -> Trial:
    """Read ``trial.toml``.

    Parameters
    ----------
    path : str or Path
        The file, or the folder that holds it.

    Returns
    -------
    Trial
        The checked description.

    Raises
    ------
    InputError
        If the file is missing, is a video or is not TOML, if a section or field is unknown or has
        the wrong type, or if a required one (such as ``fps``) is missing.

    Examples
    --------
    >>> trial = pawnb.load_trial("sample")
    >>> trial.fps > 0, len(trial.views)
    (True, 4)
    """
    expected = "a trial.toml or the folder that holds one"
    if not isinstance(path, str | os.PathLike):
        raise InputError(f"the trial is {shown(path)}; expected the path of {expected}.")
    path = Path(path)
    if path.is_dir():
        path = path / "trial.toml"
    if path.suffix.lower() in VIDEO_ENDINGS and path.is_file():
        raise InputError(
            f"{path}: a video, not a trial; expected {expected}: make one of videos by `pawnb new "
            "VIDEO ...`, or by clicks with `pawnb open VIDEO ...`."
        )
    try:
        document = read_toml(path, expected=expected)
    except InputError:
        if path.suffix == ".toml" or not path.is_file():
            raise
        raise InputError(
            f"{path}: this is no trial.toml; expected {expected}. Tracks of another program go "
            "straight to the gait (pawnb gait, pawnb.run_gait), or are named in a trial.toml of "
            "kind 'tracks', below [tracks]."
        ) from None
    return trial_from_document(document, where=str(path), folder=path.parent)


@checked_arguments
def save_trial(trial: Trial, path: str | Path) -> Path:
    """Write a Trial as TOML so that :func:`load_trial` gives it back.

    Parameters
    ----------
    trial : Trial
        What to write; its paths stay relative to the file's folder.
    path : str or Path
        The file to write.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        If the file cannot be written.

    Examples
    --------
    >>> from dataclasses import replace
    >>> path = pawnb.save_trial(replace(trial, name="another"), "sample/another.toml")
    >>> pawnb.load_trial(path).name
    'another'
    """
    return write_whole(path, tomli_w.dumps(trial_document(trial)).encode())
