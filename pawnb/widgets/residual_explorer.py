"""ResidualExplorer: drag the cut-off and see residual, signal and derivatives move."""

from __future__ import annotations

from typing import Any

import ipywidgets as widgets
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from pawnb.widgets.plot_canvas import make_canvas
from pawnb.widgets.residual_session import ResidualSession

_RAW, _SMOOTH, _HAND = "0.6", "#0072B2", "#D55E00"
_PANELS = ("position", "velocity", "acceleration")


class ResidualExplorer(widgets.VBox):  # type: ignore[misc]
    """Choose the cut-off of the filter by eye, with the methods' choices beside it.

    Drag the slider, or press and drag the upright line in the residual curve: the filtered
    signal, its velocity and its acceleration follow. Grey is without a filter.

    Parameters
    ----------
    signals : pandas.DataFrame
        One column a signal, all in one unit; NaN where missing.
    fs_hz : float
        Sampling rate, in Hz.
    unit : str
        Unit of the signals, for the axes.
    order : int
        Order of the Butterworth filter, both passes together.

    Attributes
    ----------
    session : ResidualSession
        The state; ``session.cutoff_hz`` is the cut-off in the hand.
    cutoff_hz : float
        The same.

    Raises
    ------
    InputError
        If there is no signal, or the rate or order cannot be.
    """

    def __init__(
        self, signals: pd.DataFrame, *, fs_hz: float, unit: str = "", order: int = 4
    ) -> None:
        super().__init__()
        self.session = ResidualSession(signals, fs_hz=fs_hz, order=order)
        self._unit, self._dragging = unit, False
        self._figure = Figure(figsize=(9.0, 5.0), layout="constrained")
        self._canvas = make_canvas(self._figure)
        self._choice = widgets.Dropdown(options=self.session.names, description="signal")
        self._slider = widgets.FloatSlider(
            value=self.session.cutoff_hz,
            min=self.fs_step,
            max=self.session.highest_hz,
            step=self.fs_step,
            description="cut-off (Hz)",
            readout_format=".2f",
            continuous_update=True,
            layout=widgets.Layout(width="32em"),
        )
        self._told = widgets.Label(value=self.session.text())
        self._draw_all()
        self._choice.observe(self._on_signal, names="value")
        self._slider.observe(self._on_slider, names="value")
        for name, handler in (
            ("button_press_event", self._on_press),
            ("motion_notify_event", self._on_move),
            ("button_release_event", self._on_release),
        ):
            self._canvas.mpl_connect(name, handler)
        controls = widgets.HBox([self._choice, self._slider])
        self.children = (controls, self._told, self._canvas)

    @property
    def fs_step(self) -> float:
        """Smallest cut-off and step of the slider, Hz."""
        return self.session.fs_hz / 1000.0

    @property
    def cutoff_hz(self) -> float:
        """The cut-off in the hand, Hz."""
        return self.session.cutoff_hz

    def _draw_all(self) -> None:
        """Draw the residual curve and the three panels anew, for the signal that is shown."""
        session, unit = self.session, f" ({self._unit})" if self._unit else ""
        self._figure.clear()
        grid = self._figure.add_gridspec(3, 2, width_ratios=[1.0, 1.6])
        self._curve = self._figure.add_subplot(grid[:, 0])
        found = session.residuals()
        self._curve.plot(found.curve["cutoff_hz"], found.curve["residual"], color="k")
        self._curve.axhline(found.noise_rms, color=_SMOOTH, linestyle="--", linewidth=1)
        self._line = self._curve.axvline(session.cutoff_hz, color=_HAND, linewidth=2)
        self._curve.set(xlabel="Cut-off (Hz)", ylabel=f"Residual, RMS{unit}")
        high = np.nanpercentile(found.curve["residual"], 90)
        self._curve.set_ylim(0, 3.0 * float(high) or 1.0)
        self._smooth: dict[str, Any] = {}
        for row, (name, before) in enumerate(zip(_PANELS, session.raw(), strict=True)):
            ax = self._figure.add_subplot(grid[row, 1])
            ax.plot(session.time_s, before, color=_RAW, linewidth=0.8)
            (self._smooth[name],) = ax.plot(session.time_s, before, color=_SMOOTH, linewidth=1.2)
            ax.set_ylabel(name)
        ax.set_xlabel("Time (s)")
        self._show_cutoff()

    def _show_cutoff(self) -> None:
        """Move the line and the filtered curves to the cut-off in the hand."""
        self._line.set_xdata([self.session.cutoff_hz] * 2)
        for name, values in self.session.smoothed()._asdict().items():
            self._smooth[name].set_ydata(values)
        self._told.value = self.session.text()
        self._canvas.draw_idle()

    def _on_signal(self, change: dict[str, Any]) -> None:
        """Show another signal."""
        self.session.show(change["new"])
        self._slider.max = self.session.highest_hz
        self._draw_all()

    def _on_slider(self, change: dict[str, Any]) -> None:
        """Take the slider's cut-off."""
        self.session.set_cutoff(change["new"])
        self._show_cutoff()

    def _on_press(self, event: Any) -> None:
        """Begin to drag where the residual curve is pressed."""
        self._dragging = event.inaxes is self._curve
        self._on_move(event)

    def _on_move(self, event: Any) -> None:
        """Take the cut-off under the pointer while dragging; the slider follows."""
        if self._dragging and event.inaxes is self._curve and event.xdata is not None:
            self._slider.value = self.session.set_cutoff(float(event.xdata))

    def _on_release(self, _event: Any) -> None:
        """Stop dragging."""
        self._dragging = False
