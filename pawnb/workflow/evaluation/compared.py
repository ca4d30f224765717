"""What comparisons of methods on points and on poses share: trials, methods and settings."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pawnb.core.paws.tracker import AnyTracker, find_tracker, trackers
from pawnb.errors import InputError, did_you_mean
from pawnb.schema import each_of
from pawnb.trial import Trial, load_trial
from pawnb.workflow.tracking.methods import setting_names
from pawnb.workflow.tracking.published_names import refuse_published_names


def open_compared(
    trials: Sequence[Trial | str | Path],
    kind: str,
    *,
    methods: Sequence[str],
    settings: Mapping[str, Any] | None,
    truth: Path,
    or_else: str,
) -> tuple[list[Trial], dict[str, dict[str, Any]]]:
    """Open the trials of a comparison, and check all of it before the first is tracked.

    Parameters
    ----------
    trials : sequence of Trial, str or Path
        The trials.
    kind : str
        What kind they must be of.
    methods : sequence of str
        The methods that are compared.
    settings : mapping, optional
        Names, or ``method.name``, to values.
    truth : Path
        File of the truth in the folder of each trial.
    or_else : str
        What is said of a trial of another kind.

    Returns
    -------
    trials : list of Trial
        The trials.
    settings : dict
        Each method to its settings.

    Raises
    ------
    InputError
        If a trial has no truth, is of another kind, or two have the same name, or a method or a
        setting is unknown.
    """
    given = each_of(trials, what="trials", kinds=(str, os.PathLike, Trial))
    opened = [t if isinstance(t, Trial) else load_trial(t) for t in given]
    for trial in opened:
        trial.must_be(kind, or_else=or_else)
    _check_methods(opened, methods, known=tuple(trackers(kind)), truth=truth)
    return opened, settings_by_method(settings or {}, methods, kind=kind)


def settings_by_method(
    settings: Mapping[str, Any], methods: Sequence[str], *, kind: str = "paws"
) -> dict[str, dict[str, Any]]:
    """Sort settings by the methods that they are for.

    Parameters
    ----------
    settings : mapping
        Names, or ``method.name``, to values.
    methods : sequence of str
        The methods that are compared.
    kind : str
        The kind of trial that they are for.

    Returns
    -------
    dict
        Each method to its settings; those addressed to it go first.

    Raises
    ------
    InputError
        If a setting is for a method that is not compared, or none of them has it.
    """
    found: dict[str, dict[str, Any]] = {method: {} for method in methods}
    for word, value in settings.items():
        method, dot, name = word.partition(".")
        if not dot or any(method in find_tracker(kind, m).stages for m in methods):
            method, dot, name = "", "", word  # of any method; a stage is not a method
        if dot and method not in methods:
            raise InputError(
                f"setting {word!r} is for method {method!r}{did_you_mean(method, methods)}, which "
                f"is not compared; the methods are {', '.join(methods)}."
            )
        refuse_published_names([name], kind=kind)
        asked = [method] if dot else methods
        owners = [m for m in asked if _has_setting(find_tracker(kind, m), name)]
        if not owners:
            every = {n for m in asked for n in setting_names(m, kind=kind)}
            who = f"method {method}" if dot else "none of the methods compared"
            has = "has no setting" if dot else "has a setting"
            raise InputError(f"{who} {has} {name!r}{did_you_mean(name, sorted(every))}.")
        for owner in owners:
            if dot or f"{owner}.{name}" not in settings:
                found[owner][name] = value
    return found


def _has_setting(tracker: AnyTracker, name: str) -> bool:
    """Tell whether a tracker has a setting, or a stage whose parameter this is."""
    return name in setting_names(tracker.name, kind=tracker.kind) or (
        "." in name and name.partition(".")[0] in tracker.stages
    )


def _check_methods(
    trials: Sequence[Trial],
    methods: Sequence[str],
    *,
    known: Sequence[str],
    truth: Path,
) -> None:
    """Check that methods and truths are there, before the first trial is tracked.

    Parameters
    ----------
    trials : sequence of Trial
        The trials.
    methods, known : sequence of str
        The methods asked for, and those there are.
    truth : Path
        File of the truth in the folder of each trial.

    Raises
    ------
    InputError
        If a method is unknown, a trial has no truth, or two have the same name.
    """
    for method in each_of(methods, what="methods", kinds=(str,), one=False):
        if method not in known:
            raise InputError(
                f"unknown method {method!r}{did_you_mean(method, known)}; "
                f"expected {', '.join(known)}."
            )
    names = [trial.name for trial in trials]
    for trial in trials:
        if not (trial.folder / truth).is_file():
            raise InputError(
                f"trial {trial.name!r} has no {truth.as_posix()}; a comparison needs the truth: "
                "positions made by hand or those of pawnb demo."
            )
        if names.count(trial.name) > 1:
            raise InputError(f"two trials are named {trial.name!r}; give each its own name.")
