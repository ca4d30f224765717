"""The workbench on one page of JupyterLab: ``pawnb open``."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pawnb.errors import InputError
from pawnb.files import as_word, read_text, write_whole
from pawnb.trial.file import VIDEO_ENDINGS
from pawnb.workflow.lab import lab_command, run_lab
from pawnb.workflow.workbench.films import is_tracks_file

PAGE = "workbench.ipynb"
_MARK = "pawnb_workbench"
_EXTENSIONS = Path(__file__).resolve().parent / "labextensions"


def write_page(paths: Sequence[str | Path] = ()) -> Path:
    """Write the page of a folder, a trial, or some videos.

    Parameters
    ----------
    paths : sequence of str or Path
        One folder, one trial (its folder or ``trial.toml``), or video files; default the current
        folder.

    Returns
    -------
    Path
        ``workbench.ipynb`` in that folder, or beside the first video.

    Raises
    ------
    InputError
        If a path is not there, they are of several kinds, or there is a notebook of that name
        that was not made here.
    """
    folder, videos = _what(paths)
    path = folder / PAGE
    if path.exists() and not _is_ours(path):
        raise InputError(
            f"{path}: another notebook has the name of the page, and is left as it is; rename it."
        )
    more = f", videos={_listed(videos, folder)}" if videos else ""
    call = f'pawnb.Workbench("."{more})'
    cell: dict[str, Any] = {
        "cell_type": "code", "id": "workbench", "source": f"import pawnb\n{call}", "outputs": [],
        "execution_count": None, "metadata": {"jupyter": {"source_hidden": True}},
    }  # fmt: skip
    kernel = {"name": "python3", "display_name": "Python 3", "language": "python"}
    document = {
        "nbformat": 4, "nbformat_minor": 5, "cells": [cell],
        "metadata": {"kernelspec": kernel, _MARK: True},
    }  # fmt: skip
    return write_whole(path, (json.dumps(document, indent=1) + "\n").encode())


def page_command(
    paths: Sequence[str | Path] = (), *, browser: bool = True, port: int | None = None
) -> list[str]:
    """Write the page, and return the command that opens JupyterLab on it.

    Parameters
    ----------
    paths : sequence of str or Path
        As for :func:`write_page`.
    browser, port
        As for :func:`pawnb.workflow.lab.lab_command`.

    Returns
    -------
    list of str
        The words of the command.

    Raises
    ------
    InputError
        As :func:`write_page` and :func:`pawnb.workflow.lab.lab_command`.
    """
    page = write_page(paths)
    words = lab_command(page, browser=browser, port=port)
    place = f"/lab/tree/{page.name}"
    words = [word.replace(place, f"/doc/tree/{page.name}") for word in words]
    return [*words, f"--LabApp.extra_labextensions_path={_EXTENSIONS}"]


def open_page(
    paths: Sequence[str | Path] = (), *, browser: bool = True, port: int | None = None
) -> None:
    """Open the workbench in JupyterLab until that is stopped.

    Parameters
    ----------
    paths, browser, port
        As for :func:`page_command`.

    Raises
    ------
    InputError
        As :func:`page_command`, or if JupyterLab could not start.
    """
    run_lab(page_command(paths, browser=browser, port=port))


def _what(paths: Sequence[str | Path]) -> tuple[Path, list[Path]]:
    """Return the folder of the page, and the videos that were named."""
    named = [Path(path) for path in paths] or [Path()]
    for path in named:
        if not path.exists():
            raise InputError(f"{path}: no such folder, trial or video.")
    if len(named) == 1 and (named[0].is_dir() or named[0].name == "trial.toml"):
        return (named[0] if named[0].is_dir() else named[0].parent), []
    odd = [path for path in named if path.suffix.lower() not in VIDEO_ENDINGS]
    if odd:
        said = "name one folder, one trial, or the videos of one recording"
        if is_tracks_file(odd[0]):
            where = as_word(odd[0].parent)
            said = f"tracks are shown by pawnb open {where}, on the film beside them"
        raise InputError(f"{odd[0]}: no video; {said}.")
    return named[0].parent, named


def _listed(videos: Sequence[Path], folder: Path) -> str:
    """Return videos as a Python list, relative to the page where that can be said."""
    try:
        return repr([Path(os.path.relpath(video, folder)).as_posix() for video in videos])
    except ValueError:  # one is on another drive
        return repr([video.resolve().as_posix() for video in videos])


def _is_ours(path: Path) -> bool:
    """Whether a notebook was made here."""
    try:
        document = json.loads(read_text(path, expected="a notebook"))
    except (ValueError, InputError):
        return False
    return isinstance(document, dict) and bool(document.get("metadata", {}).get(_MARK))
