"""What was asked of a gait analysis, and how it stands in the record of the run."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pawnb.gait import GaitTables
from pawnb.workflow.gait.drawing.save_figures import Which
from pawnb.workflow.gait.sources import GaitSource
from pawnb.workflow.gait.study import Study
from pawnb.workflow.provenance.labels import label_inputs
from pawnb.workflow.provenance.record import build_step, file_checksum
from pawnb.workflow.provenance.results import (
    provenance_steps,
)

Legs = Sequence[str] | Mapping[str, str]
"""Legs to use, or names of legs to names of points."""

ASKED = ("fps", "legs", "event_names", "animals", "groups", "figures", "set")
"""What the record of a run keeps of a request, beside its inputs; ``set`` are the settings that
were given by hand, which are not all that were in force."""


@dataclass(frozen=True, kw_only=True)
class GaitRequest:
    """What :func:`pawnb.run_gait` was asked for; its parameters of the same names."""

    inputs: str | Path | Sequence[str | Path]
    fps: float | None = None
    legs: Legs | None = None
    event_names: Mapping[str, str] | None = None
    animals: Sequence[str] | None = None
    groups: Sequence[str] | None = None
    settings: Mapping[str, Any] | None = None
    figures: Which = "all"

    def plain(self) -> dict[str, Any]:
        """Return :data:`ASKED` as plain values, None where nothing was asked for."""
        legs = self.legs
        return {
            "fps": self.fps,
            "legs": dict(legs) if isinstance(legs, Mapping) else list(legs) if legs else None,
            "event_names": dict(self.event_names) if self.event_names else None,
            "animals": list(self.animals) if self.animals else None,
            "groups": list(self.groups) if self.groups else None,
            "figures": self.figures,
            "set": dict(self.settings) if self.settings else {},
        }


@dataclass(frozen=True, kw_only=True)
class TakenOver:
    """What a run takes over when results are made again, for their record to be the same.

    Parameters
    ----------
    labels : mapping
        Every input, to what the record calls it.
    edits : tuple of Path
        Corrections of events that were in force; others are left alone.
    command : str or None
        The command line on record.
    only : collection of str, optional
        Names of the figures to draw; None draws those of the request.
    """

    labels: Mapping[Path, str] = field(default_factory=dict)
    edits: tuple[Path, ...] = ()
    command: str | None = None
    only: Collection[str] | None = None


def record_of(
    request: GaitRequest,
    sources: Sequence[GaitSource],
    edits: Sequence[Path],
    *,
    tables: GaitTables,
    study: Study | None,
    command: Sequence[str] | None,
    again: TakenOver | None,
) -> dict[str, Any]:
    """Return the record of a run: all that is needed to make its files again.

    Parameters
    ----------
    request : GaitRequest
        What was asked for.
    sources : sequence of GaitSource
        What was analysed.
    edits : sequence of Path
        Corrections of events that were in force.
    tables : GaitTables
        What was found.
    study : Study, optional
        The study that named the sources.
    command : sequence of str, optional
        The command line.
    again : TakenOver, optional
        What is taken over from a run that is made again.

    Returns
    -------
    dict
        The step for the provenance.
    """
    given = [source.given for source in sources] if study is None else [study.path]
    inputs = [*given, *(f for s in sources for f in (s.given, s.path, *s.further)), *edits]
    inputs += [one.path for one in study.species] if study is not None else []
    labels = label_inputs(inputs)
    if again is not None:
        known = {path.absolute(): label for path, label in again.labels.items()}
        labels |= {path: known[path.absolute()] for path in inputs if path.absolute() in known}
    step = build_step(
        "gait",
        command=command,
        inputs={labels[path]: file_checksum(path) for path in inputs},
        settings=dataclasses.asdict(tables.settings),
        settings_of_trials=_own_settings(tables),
        given=[labels[path] for path in given],
        edits=[labels[path] for path in edits],
        **request.plain(),
        sources={
            labels[source.path]: provenance_steps(source.tracks)
            for source in sources
            if source.tracks is not None
        },
    )
    return step if again is None else step | {"command": again.command}


def _own_settings(tables: GaitTables) -> dict[str, dict[str, Any]]:
    """Return the settings that single trials have of their own, by animal and trial."""
    common = dataclasses.asdict(tables.settings)
    found = {}
    for basis in tables.bases:
        own = dataclasses.asdict(basis.settings)
        changed = {name: value for name, value in own.items() if value != common[name]}
        if changed:
            found[f"{basis.who['animal']}, {basis.who['trial']}"] = changed
    return found
