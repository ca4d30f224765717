"""Corrections of events as frozen records, which are the lines of ``event_edits.jsonl``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from pawnb.io.journal import LineFormat, Step

EVENT_EDITS_FILE = "event_edits.jsonl"


@dataclass(frozen=True, kw_only=True)
class MoveEvent:
    """The event was at another time.

    Parameters
    ----------
    animal, trial, leg, event : str
        Which event: AEP, PEP, TD or LO of a leg.
    time_s : float
        Where it stands now.
    to_s : float
        Where it belongs.
    fps : float, optional
        Frames a second by which these times were counted; the same frames have other times once
        the frame rate of the recording is mended.
    beside_s : float, optional
        When the nearest other event of the kind was, as the correction was made: so that this is
        not taken for it once events are found anew.
    """

    animal: str
    trial: str
    leg: str
    event: str
    time_s: float
    to_s: float
    fps: float | None = None
    beside_s: float | None = None


@dataclass(frozen=True, kw_only=True)
class DeleteEvent:
    """There was no such event; fields as those of :class:`MoveEvent`."""

    animal: str
    trial: str
    leg: str
    event: str
    time_s: float
    fps: float | None = None
    beside_s: float | None = None


@dataclass(frozen=True, kw_only=True)
class AddEvent:
    """There was such an event that was not found; fields as those of :class:`MoveEvent`."""

    animal: str
    trial: str
    leg: str
    event: str
    time_s: float
    fps: float | None = None
    beside_s: float | None = None


@dataclass(frozen=True, kw_only=True)
class ExcludeStride:
    """A stride that shall not count.

    Parameters
    ----------
    animal, trial, leg : str
        Whose stride.
    start_s : float
        When it begins.
    reason : str
        Why; it stands in the table of what was dropped.
    fps, beside_s : float, optional
        As of :class:`MoveEvent`; of the events that begin strides.
    """

    animal: str
    trial: str
    leg: str
    start_s: float
    reason: str
    fps: float | None = None
    beside_s: float | None = None


EventEdit: TypeAlias = MoveEvent | DeleteEvent | AddEvent | ExcludeStride
Entry: TypeAlias = EventEdit | Step

EVENT_EDIT_LINES: LineFormat[EventEdit] = LineFormat(
    {"move": MoveEvent, "delete": DeleteEvent, "add": AddEvent, "exclude": ExcludeStride}
)
"""The lines of ``event_edits.jsonl``."""
