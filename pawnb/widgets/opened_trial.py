"""The trial of a widget, which stays open while the notebook goes to other folders."""

from __future__ import annotations

import dataclasses
from pathlib import Path

from pawnb.trial import Trial, load_trial


def open_trial(trial: Trial | str | Path) -> Trial:
    """Return a trial whose files are found wherever the notebook goes (``%cd``, ``os.chdir``)."""
    trial = trial if isinstance(trial, Trial) else load_trial(trial)
    return dataclasses.replace(trial, folder=trial.folder.absolute())
