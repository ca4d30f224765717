"""What was asked of a gait analysis, and how it stands in the record of the run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pawnb.workflow.gait.save_figures import Which

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
class Again:
    """What a run takes over when results are made again, for their record to be the same.

    Parameters
    ----------
    labels : mapping
        Every input, to what the record calls it.
    edits : tuple of Path
        Corrections of events that were in force; others are left alone.
    command : str or None
        The command line on record.
    only : str, optional
        Name of the one figure to draw; None draws those of the request.
    """

    labels: Mapping[Path, str] = field(default_factory=dict)
    edits: tuple[Path, ...] = ()
    command: str | None = None
    only: str | None = None
