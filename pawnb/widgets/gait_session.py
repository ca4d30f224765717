"""State of the GaitExplorer: what is shown and picked, and the corrections made."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pawnb.errors import InputError
from pawnb.gait import GaitTables
from pawnb.gait.cycles import HEIGHT, LEG_ANGLE, POSITION, LegSignals
from pawnb.gait.events.event_edits import (
    AddEvent,
    DeleteEvent,
    EventEdit,
    EventEdits,
    ExcludeStride,
    MoveEvent,
    describe_edit,
    describe_left_out,
)
from pawnb.gait.legs import sort_legs

_JUST_AFTER_S = 1e-6
EVENT_KINDS = (("AEP", "PEP"), ("TD", "LO"))
"""Events of the extremes of a leg, and of its contact."""
_ALL = EVENT_KINDS[0] + EVENT_KINDS[1]
_SIGNALS = (LEG_ANGLE, POSITION, HEIGHT)


class GaitSession:
    """An analysis that a person looks through and corrects; works without a browser.

    Parameters
    ----------
    tables : GaitTables
        The analysis; it is not modified.
    path : str or Path, optional
        ``event_edits.jsonl``, where corrections are kept.

    Attributes
    ----------
    edits : EventEdits
        The corrections, and the tables with them.
    trials : tuple of (animal, trial)
        What can be shown.
    trial : tuple of str
        Animal and trial that are shown.
    legs : tuple of str
        Legs that are shown.
    pair : tuple of str
        Leg and reference whose phase is shown.
    stride : tuple of (leg, start_s), optional
        The stride that is picked.
    event : tuple of (leg, event, time_s), optional
        The event that is picked.
    place_s : float, optional
        Where an event can be added: where the signal was picked beside all events.

    Raises
    ------
    InputError
        If there is no event, or the corrections cannot be read.
    """

    def __init__(self, tables: GaitTables, path: str | Path | None = None) -> None:
        self.edits = EventEdits(tables, path)
        known = tables.events[["animal", "trial"]].drop_duplicates().astype(str)
        if known.empty:
            raise InputError("this analysis has no events; there is nothing to look at.")
        self.trials = tuple((animal, trial) for animal, trial in known.to_numpy().tolist())
        self.stride: tuple[str, float] | None = None
        self.event: tuple[str, str, float] | None = None
        self.place_s: float | None = None
        self._found, self._kept = tables, path is not None
        self._missed = ""
        self.show(*self.trials[0])

    @property
    def tables(self) -> GaitTables:
        """The tables with every correction in force."""
        return self.edits.tables

    def show(self, animal: str, trial: str) -> None:
        """Show another trial, all its legs and its first pair; raises InputError if unknown."""
        if (animal, trial) not in self.trials:
            raise InputError(f"there is no trial {trial!r} of animal {animal!r}.")
        self.trial = (animal, trial)
        self.all_legs = tuple(sort_legs(self._of_trial(self._found.events)["leg"]))
        self.legs = self.all_legs
        pairs = self._of_trial(self._found.phases)[["leg", "reference"]].drop_duplicates()
        own = [(str(leg), str(reference)) for leg, reference in pairs.to_numpy().tolist()]
        self.pairs: tuple[tuple[str, str], ...] = tuple(own)
        self.pair = self.pairs[0] if self.pairs else (self.all_legs[0], self.all_legs[-1])
        self._leg = self.pair[0]
        self.stride = self.event = self.place_s = None
        self._missed = ""

    def show_legs(self, legs: Sequence[str]) -> None:
        """Show some of the legs, in anatomical order; raises InputError for none or unknown."""
        odd = [leg for leg in legs if leg not in self.all_legs]
        if odd or not legs:
            raise InputError(f"no leg {odd[0]!r}." if odd else "choose at least one leg.")
        self.legs = tuple(sort_legs(legs))

    def show_pair(self, leg: str, reference: str) -> None:
        """Show the phases of another pair; raises InputError where it has none."""
        if (leg, reference) not in self.pairs:
            raise InputError(f"the phase of {leg} to {reference} was not measured.")
        before = self.shown_leg
        self.pair, self._leg = (leg, reference), leg
        if self.shown_leg != before:  # what is picked is of a signal that is no longer shown
            self.event = self.place_s = None

    def _of_trial(self, table: pd.DataFrame) -> pd.DataFrame:
        """Return the rows of the trial that is shown."""
        animal, trial = self.trial
        own = table[(table["animal"] == animal) & (table["trial"] == trial)]
        return own.reset_index(drop=True)

    @property
    def events(self) -> pd.DataFrame:
        """Events of the legs that are shown."""
        own = self._of_trial(self.tables.events)
        return own[own["leg"].isin(self.legs)].reset_index(drop=True)

    @property
    def leg_events(self) -> pd.DataFrame:
        """Events of :attr:`shown_leg`."""
        own = self._of_trial(self.tables.events)
        return own[own["leg"] == self.shown_leg].reset_index(drop=True)

    @property
    def span_s(self) -> tuple[float, float]:
        """Time of the first and last event that was found in the trial, s."""
        times = self._of_trial(self._found.events)["time_s"]
        return float(times.min()), float(times.max())

    @property
    def strides(self) -> pd.DataFrame:
        """Strides of the trial."""
        return self._of_trial(self.tables.strides)

    @property
    def phases(self) -> pd.DataFrame:
        """Phases of the pair that is shown."""
        own = self._of_trial(self.tables.phases)
        leg, reference = self.pair
        return own[(own["leg"] == leg) & (own["reference"] == reference)].reset_index(drop=True)

    @property
    def dropped(self) -> pd.DataFrame:
        """What was dropped of the trial."""
        return self._of_trial(self.tables.dropped)

    def signal(self) -> LegSignals | None:
        """Return the leg angle, else the position, of the leg of :attr:`shown_leg`."""
        own = {
            one.signal: one
            for one in self.tables.signals
            if (one.animal, one.trial) == self.trial and self.shown_leg in one.legs
        }
        return next((own[kind] for kind in _SIGNALS if kind in own), None)

    @property
    def shown_leg(self) -> str:
        """The leg whose signal is shown: that of the stride picked, else the one clicked last."""
        return self.stride[0] if self.stride is not None else self._leg

    def pick(self, leg: str, time_s: float) -> tuple[str, float] | None:
        """Pick the stride of a leg at a time; None where there is none that counts."""
        row = self._stride_at(leg, time_s)
        self.stride = None if row is None else (leg, float(row["start_s"]))
        self.event, self.place_s, self._leg = None, None, leg
        self._missed = "" if row is not None else self._why_none(leg, time_s)
        return self.stride

    def _why_none(self, leg: str, time_s: float) -> str:
        """Say why a leg has no stride at a time."""
        own = self.dropped
        own = own[(own["leg"] == leg) & (own["what"] == "stride")]
        inside = (own["start_s"] <= time_s) & (time_s < own["end_s"])
        why = own.loc[inside, "why"].astype(str).tolist()
        if not why:
            return f"{leg} has no whole stride at {time_s:.3f} s"
        return f"this stride of {leg} does not count: {why[0]}"

    def _stride_at(self, leg: str, time_s: float) -> dict[str, Any] | None:
        """Return the stride of a leg that holds a time."""
        own = self.strides
        own = own[own["leg"] == leg]
        inside = (own["start_s"] <= time_s) & (time_s < own["start_s"] + own["period_s"])
        found = own[inside].to_dict("records")
        return {str(k): v for k, v in found[0].items()} if found else None

    def picked(self) -> dict[str, Any] | None:
        """Return the stride that is picked, with its measures."""
        if self.stride is None:
            return None
        return self._stride_at(self.stride[0], self.stride[1] + _JUST_AFTER_S)

    def picked_phases(self) -> list[float]:
        """Return the phases of the pair that the picked stride gives.

        Those of the leg's events within it, if it is one of the reference; the phase of its own
        beginning, if it is one of the leg.
        """
        stride = self.picked()
        if stride is None or stride["leg"] not in self.pair:
            return []
        own, (_, reference) = self.phases, self.pair
        if stride["leg"] == reference:
            return own.loc[own["stride"] == stride["stride"], "phase"].astype(float).tolist()
        base = self.strides
        base = base[base["leg"] == reference][["stride", "start_s", "period_s"]]
        both = own.merge(base, on="stride")
        at = both["start_s"] + both["phase"] * both["period_s"]
        return (
            both.loc[(at - stride["start_s"]).abs() < _JUST_AFTER_S, "phase"].astype(float).tolist()
        )

    def kinds(self) -> tuple[tuple[str, str], ...]:
        """Return the kinds of events that :attr:`shown_leg` has: extremes, contact, or both."""
        known = set(self.leg_events["event"])
        return tuple(pair for pair in EVENT_KINDS if known & set(pair))

    def pick_event(
        self, time_s: float, *, within_s: float, kinds: Sequence[str] = _ALL
    ) -> tuple[str, str, float] | None:
        """Pick the event of :attr:`shown_leg` nearest to a time; None if none is within reach.

        Parameters
        ----------
        time_s : float
            The time, s.
        within_s : float
            How near an event must be, s.
        kinds : sequence of str
            Which events may be picked.

        Returns
        -------
        tuple or None
            Leg, event and time (s).
        """
        own = self.leg_events
        own = own[own["event"].isin(kinds)]
        away = np.abs(own["time_s"].to_numpy(dtype=float) - time_s)
        self.event, self.place_s, self._missed = None, float(time_s), ""
        if len(away) and away.min() <= within_s:
            self.place_s = None
            row = own.iloc[int(away.argmin())]
            self.event = (str(row["leg"]), str(row["event"]), float(row["time_s"]))
        return self.event

    def move_event(self, to_s: float) -> None:
        """Move the event that is picked; raises InputError where none is or it does not fit."""
        leg, event, time_s = self._needed_event()
        animal, trial = self.trial
        self.edits.apply(
            MoveEvent(
                animal=animal, trial=trial, leg=leg, event=event, time_s=time_s, to_s=float(to_s)
            )
        )
        self.event = (leg, event, float(to_s))
        if self.stride == (leg, time_s):
            self.stride = (leg, float(to_s))
        self._keep_stride()

    def step_event(self, samples: int) -> None:
        """Move the event that is picked by some samples of its signal."""
        _, _, time_s = self._needed_event()
        signal = self.signal()
        if signal is None:
            raise InputError("this leg has no signal; an event is moved in it.")
        step_s = float(np.median(np.diff(signal.time_s)))
        self.move_event(time_s + samples * step_s)

    def add_event(self, event: str) -> None:
        """Add an event of :attr:`shown_leg` where the signal was picked.

        Parameters
        ----------
        event : str
            AEP, PEP, TD or LO.

        Raises
        ------
        InputError
            If no place was picked, or the leg can have no such event there.
        """
        if self.place_s is None:
            raise InputError("pick a place first: click in the signal where there is no event.")
        (animal, trial), leg, time_s = self.trial, self.shown_leg, self.place_s
        self.edits.apply(AddEvent(animal=animal, trial=trial, leg=leg, event=event, time_s=time_s))
        self.event, self.place_s = (leg, event, time_s), None
        self._keep_stride()

    def delete_event(self) -> None:
        """Delete the event that is picked; raises InputError where none is."""
        leg, event, time_s = self._needed_event()
        animal, trial = self.trial
        self.edits.apply(
            DeleteEvent(animal=animal, trial=trial, leg=leg, event=event, time_s=time_s)
        )
        self.event = None
        self._keep_stride()

    def exclude_stride(self, reason: str) -> None:
        """Exclude the stride that is picked; raises InputError without one or without reason."""
        if self.stride is None:
            raise InputError("pick a stride first: click it in the gait diagram.")
        animal, trial = self.trial
        leg, start_s = self.stride
        self.edits.apply(
            ExcludeStride(animal=animal, trial=trial, leg=leg, start_s=start_s, reason=reason)
        )
        self.stride = self.event = None
        self._missed = ""

    def undo(self) -> None:
        """Take the last correction back; raises InputError where there is none."""
        done = self.edits.active[-1:]
        self.edits.undo()
        self._after_step("taken back", done)

    def redo(self) -> None:
        """Make the last undone correction again; raises InputError where there is none."""
        self.edits.redo()
        self._after_step("made again", self.edits.active[-1:])

    def _after_step(self, what: str, done: Sequence[EventEdit]) -> None:
        """Say which correction was taken back or made again: it may be of a trial not shown."""
        self.event = self.place_s = None
        self._keep_stride()
        self._missed = f"{what}: {describe_edit(done[0])}"

    def _needed_event(self) -> tuple[str, str, float]:
        """Return the event that is picked."""
        if self.event is None:
            raise InputError("pick an event first: click it in the signal of the leg.")
        return self.event

    def _keep_stride(self) -> None:
        """Let go of a picked stride that is no more."""
        self._missed = ""
        found = self.picked()
        if self.stride is not None and (
            found is None or abs(float(found["start_s"]) - self.stride[1]) > _JUST_AFTER_S
        ):
            self.stride = None

    def text(self) -> str:
        """Say what is picked, and how many corrections there are."""
        n = len(self.edits.active)
        said = [f"{n} correction{'s' * (n != 1)}"]
        if n and not self._kept:
            said.append("kept nowhere, as no file was given: GaitExplorer(gait, file)")
        if self.edits.left_out:
            said.append(f"left out, as they fit no event: {describe_left_out(self.edits.left_out)}")
        if (stride := self.picked()) is not None:
            said.append(
                f"{stride['leg']}, stride {stride['stride']}: from {stride['start_s']:.3f} s, "
                f"period {stride['period_s']:.3f} s, duty factor {stride['duty_factor']:.2f}"
            )
        if self.event is not None:
            said.append(f"{self.event[1]} of {self.event[0]} at {self.event[2]:.3f} s")
        if self.place_s is not None:
            said.append(f"no event of {self.shown_leg} at {self.place_s:.3f} s: one can be added")
        said += [note.rstrip(".") for note in self.edits.notes]
        return "; ".join([*said, self._missed] if self._missed else said) + "."
