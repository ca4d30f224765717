"""State of the ResidualExplorer: signals, the cut-off in the hand, what it does to each."""

from __future__ import annotations

import math

import numpy as np

from pawnb.errors import InputError, did_you_mean
from pawnb.gait.residuals import (
    CUTOFF_METHODS,
    POOLED,
    ResidualAnalysis,
    analyse_residuals,
    compare_cutoffs,
    named_signals,
    residual_cutoffs,
)
from pawnb.gait.residuals.cutoffs import Signals, say_unlike
from pawnb.gait.residuals.residual_analysis import analyse_what_is_there
from pawnb.signals import SmoothedMotion, differentiate, smooth_motion


class ResidualSession:
    """Signals, and the cut-off that a person tries on them; works without a browser.

    Parameters
    ----------
    signals : pandas.DataFrame, pandas.Series, ndarray or list
        One column a signal, all in one unit; NaN where missing. A series, an array (n,) or (n, k)
        and a list of numbers will do.
    fs_hz : float
        Sampling rate, in Hz.
    order : int
        Order of the Butterworth filter, both passes together.

    Attributes
    ----------
    names : tuple of str
        Names of the signals.
    name : str
        The one that is shown.
    cutoff_hz : float
        The cut-off in the hand; at first that of residual analysis over all signals, or of the
        next method that has one, or else so high that next to nothing is taken away.
    begun_by : str
        The method that the first cut-off came from; empty where none had one.
    lowest_hz, highest_hz : float
        Lowest and highest cut-off that can be taken into the hand.
    choices : pandas.DataFrame
        What three methods would choose, see :func:`pawnb.gait.residuals.compare_cutoffs`.

    Raises
    ------
    InputError
        If there is no signal, none has 20 samples without a gap, or the rate or order cannot be.
    """

    def __init__(self, signals: Signals, *, fs_hz: float, order: int = 4) -> None:
        table = named_signals(signals)
        self._signals, self.fs_hz, self.order = table, fs_hz, order
        self.names = tuple(str(name) for name in table)
        self.choices = compare_cutoffs(table, fs_hz=fs_hz, order=order)
        if not self.choices["n_samples"].any():
            analyse_residuals(table.to_numpy(), fs_hz=fs_hz, order=order)  # says why it cannot
        self.name = self.names[0]
        self._found: dict[str, ResidualAnalysis] = {}
        tried_hz = residual_cutoffs(fs_hz, order=order)
        self.lowest_hz = float(tried_hz[0])
        self.highest_hz = float(np.nanmax([tried_hz[-1], *self.choices["cutoff_hz"]]))
        self.begun_by, self.cutoff_hz = self._first_choice()
        self._begun_hz, self._unlike = self.cutoff_hz, self._say_unlike()

    def _say_unlike(self) -> str:
        """Name the signals that the first cut-off, of all signals pooled, does not suit."""
        own = self.choices[
            (self.choices["method"] == self.begun_by) & (self.choices["signal"] != POOLED)
        ]
        if len(own) < 2:
            return ""
        by_name = dict(zip(own["signal"], own["cutoff_hz"], strict=True))
        return say_unlike(by_name, self.cutoff_hz)

    def _first_choice(self) -> tuple[str, float]:
        """Return the first method that has a cut-off over all signals, and the cut-off."""
        wanted = POOLED if len(self.names) > 1 else self.names[0]
        own = self.choices[self.choices["signal"] == wanted].dropna(subset=["cutoff_hz"])
        if len(own):
            return str(own["method"].iloc[0]), float(own["cutoff_hz"].iloc[0])
        return "", self.highest_hz

    def show(self, name: str) -> None:
        """Show another signal; raises InputError for an unknown one."""
        if name not in self.names:
            raise InputError(
                f"no signal {name!r}{did_you_mean(name, self.names)}; there are "
                f"{', '.join(self.names)}."
            )
        self.name = name

    def set_cutoff(self, cutoff_hz: float) -> float:
        """Take another cut-off into the hand, within what the filter can do; return it."""
        if not math.isfinite(cutoff_hz):
            raise InputError(f"cutoff_hz is {cutoff_hz}; expected a number.")
        self.cutoff_hz = float(np.clip(cutoff_hz, self.lowest_hz, self.highest_hz))
        return self.cutoff_hz

    @property
    def signal(self) -> np.ndarray:
        """The signal that is shown, shape (n,)."""
        return self._signals[self.name].to_numpy(dtype=float)

    @property
    def time_s(self) -> np.ndarray:
        """Times of its samples."""
        return np.arange(len(self.signal)) / self.fs_hz

    def residuals(self) -> ResidualAnalysis:
        """Return the residual curve of the signal that is shown; NaN where it is hardly seen."""
        if self.name not in self._found:
            found = analyse_what_is_there(self.signal, fs_hz=self.fs_hz, order=self.order)
            self._found[self.name] = found
        return self._found[self.name]

    def smoothed(self) -> SmoothedMotion:
        """Return position, velocity and acceleration with the cut-off in the hand."""
        return smooth_motion(
            self.signal, fs_hz=self.fs_hz, cutoff_hz=self.cutoff_hz, order=self.order
        )

    def raw(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return position, velocity and acceleration without a filter."""
        x, dt = self.signal, 1.0 / self.fs_hz
        return x, differentiate(x, dt=dt), differentiate(x, dt=dt, order=2)

    def chosen(self) -> dict[str, tuple[float, str]]:
        """Return cut-off (Hz; NaN for none) and reason of each method for the signal shown."""
        own = self.choices[self.choices["signal"] == self.name]
        return {
            str(row["method"]): (float(row["cutoff_hz"]), str(row["reason"]))
            for row in own.to_dict("records")
        }

    def text(self) -> str:
        """Say which cut-off is in the hand, and which methods have none, and why."""
        told = [f"{self.name}: cut-off {self.cutoff_hz:.2f} Hz."]
        if self.cutoff_hz == self._begun_hz and self.begun_by != CUTOFF_METHODS[0]:
            told.append(
                f"It is that of {self.begun_by}, as residual analysis has none."
                if self.begun_by
                else "No method has one; at this cut-off next to nothing is taken away."
            )
        if self.cutoff_hz == self._begun_hz and self._unlike:
            told.append(f"But {self._unlike}.")
        told += [
            f"{method}: {reason}"
            for method, (cutoff_hz, reason) in self.chosen().items()
            if not math.isfinite(cutoff_hz)
        ]
        return " ".join(told)
