"""Results of other inputs in the folder where those of a run go by default."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pawnb.errors import InputWarning
from pawnb.gait.events.event_edits import EVENT_EDITS_FILE
from pawnb.input_warnings import warn_of_input
from pawnb.workflow.provenance.manifest import read_manifest

_INPUTS_NAMED = 3
"""Inputs that are named in a warning."""


def other_inputs(folder: Path, step: Mapping[str, Any]) -> list[str]:
    """Return the inputs whose gait a folder holds, where it is that of others altogether.

    Parameters
    ----------
    folder : Path
        Where results go.
    step : mapping
        The record of the run that writes there.

    Returns
    -------
    list of str
        Their labels in the record; none where an input is the same, as when a run is made again.
    """
    manifest = read_manifest(folder)
    held = [] if manifest is None else manifest.steps_of("gait")
    known = dict.fromkeys(label for one in held for label in one.get("inputs", {}))
    names = [label for label in known if not label.endswith(EVENT_EDITS_FILE)]
    return names if not {*names} & {*step["inputs"]} else []


def tell_replaced(folder: Path, names: Sequence[str]) -> None:
    """Warn that results of other inputs were replaced, if there were any.

    Parameters
    ----------
    folder : Path
        Where they were.
    names : sequence of str
        As :func:`other_inputs` gives them.
    """
    if names:
        named = ", ".join(names[:_INPUTS_NAMED])
        more = " ..." if len(names) > _INPUTS_NAMED else ""
        warn_of_input(
            f"{folder}: the gait of {named}{more} was here and is replaced; with a folder for each "
            "(--out) both stay.",
            InputWarning,
            stacklevel=4,
        )
