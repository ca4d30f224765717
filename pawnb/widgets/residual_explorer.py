"""ResidualExplorer: drag the cut-off and see residual, signal and derivatives move."""

from __future__ import annotations

import math
from typing import Any

import ipywidgets as widgets
import numpy as np
import traitlets
from matplotlib.figure import Figure

from pawnb.errors import InputError
from pawnb.figures.style import OKABE_ITO
from pawnb.gait.residuals.cutoffs import Signals
from pawnb.widgets.plain import Plain, picture_of_figure
from pawnb.widgets.plot_canvas import alone, make_canvas
from pawnb.widgets.plot_theme import fit_figure, on_screen, set_theme
from pawnb.widgets.residual_session import ResidualSession
from pawnb.widgets.surroundings import Surroundings

_RAW, _SMOOTH, _HAND = "0.7", OKABE_ITO["blue"], OKABE_ITO["vermillion"]
_PANELS = {"position": "", "velocity": "/s", "acceleration": "/s²"}
_CUTOFF_MARKS = {
    "residual": ("residual analysis", "o"),
    "gcv": ("cross-validation", "s"),
    "autocorrelation": ("whiteness", "^"),
}
"""Names of the methods in words, and their marks on the curve."""
_RESIDUAL_SIZE_PX, _BESIDE_RESIDUAL_PX = (1000, 540), 310
"""Size of the plots before a page shows them, which is their greatest height; and height of the
window that buttons and menus take."""
_TYPED_DIGITS = 3
"""Decimal places of the cut-off in the box where one can be typed."""
_ROOM = 1.6
"""Height of a panel in ranges of its filtered signal: noise of derivatives would fill it else."""


class ResidualExplorer(Plain, widgets.VBox):  # type: ignore[misc]
    """Choose the cut-off of the filter by eye, with the methods' choices beside it.

    Drag the slider, or press and drag the upright line in the residual curve: the filtered
    signal, its velocity and its acceleration follow. Grey is without a filter; where it is far
    larger than what is left of it, it is cut at the edge of its panel. A button takes the
    cut-off of a method.

    Parameters
    ----------
    signals : pandas.DataFrame, pandas.Series, ndarray or list
        One column a signal, all in one unit; NaN where missing. A series, an array (n,) or (n, k)
        and a list of numbers will do.
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
        The same, in Hz; can be set, observed, and linked to another widget.

    Raises
    ------
    InputError
        If there is no signal, or the rate or order cannot be.
    """

    cutoff_hz = traitlets.Float().tag(sync=True)

    def __init__(self, signals: Signals, *, fs_hz: float, unit: str = "", order: int = 4) -> None:
        self.session = ResidualSession(signals, fs_hz=fs_hz, order=order)
        super().__init__(cutoff_hz=self.session.cutoff_hz)
        self._unit, self._dragging = unit, False
        self._figure = Figure(
            figsize=(_RESIDUAL_SIZE_PX[0] / 100, _RESIDUAL_SIZE_PX[1] / 100), dpi=100
        )
        self._around = Surroundings()
        self._canvas = make_canvas(self._figure)
        self._choice = widgets.Dropdown(options=self.session.names, description="signal")
        self._slider = widgets.FloatSlider(
            value=self.session.cutoff_hz, min=self.session.lowest_hz, max=self.session.highest_hz,
            step=self.fs_step, description="cut-off (Hz)", readout=False, continuous_update=True,
            layout={"width": "28em"},
        )  # fmt: skip
        self._number = widgets.BoundedFloatText(
            value=round(self.session.cutoff_hz, _TYPED_DIGITS),
            min=self.session.lowest_hz, max=self.session.highest_hz, step=None,
            layout={"width": "7em"},
        )  # fmt: skip
        self._told = widgets.Label()
        self._told.add_class("pawnb-wrap")
        self._takers = widgets.HBox(layout={"flex_flow": "row wrap"})
        self._draw_all()
        self._choice.observe(self._on_signal, names="value")
        self._slider.observe(self._on_slider, names="value")
        self._number.observe(self._on_number, names="value")
        self.observe(self._on_cutoff, names="cutoff_hz")
        for name, handler in (
            ("button_press_event", self._on_press),
            ("motion_notify_event", self._on_move),
            ("button_release_event", self._on_release),
        ):
            self._canvas.mpl_connect(name, handler)
        self._around.observe(self._on_room, names=["width", "height"])
        self._around.observe(lambda _: self._draw_all(), names="dark")
        controls = widgets.HBox(
            [self._choice, self._slider, self._number], layout={"flex_flow": "row wrap"}
        )
        self.children = (self._around, controls, self._takers, self._told, self._canvas)

    @alone
    def plain_picture(self) -> bytes:
        """Return the plots as PNG."""
        return picture_of_figure(self._figure)

    @property
    def fs_step(self) -> float:
        """Step of the slider, Hz; what is typed, dragged or taken from a method is exact."""
        return self.session.fs_hz / 1000.0

    @traitlets.validate("cutoff_hz")
    def _cutoff_of_the_filter(self, proposal: Any) -> float:
        """Refuse a cut-off that the filter cannot have."""
        given, highest = float(proposal["value"]), self.session.highest_hz
        if not 0.0 < given <= highest * (1 + 1e-9):
            raise InputError(f"cutoff_hz is {given:g}; expected above 0, at most {highest:.4g} Hz.")
        return given

    @alone
    def _draw_all(self) -> None:
        """Draw the residual curve and the three panels anew, for the signal that is shown."""
        self._figure.clear()
        with on_screen():
            grid = self._figure.add_gridspec(
                3, 2, width_ratios=[1.0, 1.6], left=0.075, right=0.985, bottom=0.1, top=0.92,
                wspace=0.24, hspace=0.16,
            )  # fmt: skip
            self._draw_curve(grid)
            self._draw_motion(grid)
        self._offer_methods()
        self._show_cutoff()

    def _draw_curve(self, grid: Any) -> None:
        """Draw the residual curve, what the methods choose on it, and the line of the hand."""
        session, found = self.session, self.session.residuals()
        self._curve = ax = self._figure.add_subplot(grid[:, 0])
        cutoff, residual = (found.curve[name].to_numpy() for name in ("cutoff_hz", "residual"))
        ax.plot(cutoff, residual, color="black")
        seen = residual[np.isfinite(residual)]
        highest = float(seen.max()) if len(seen) else 0.0
        top = 3.0 * float(np.percentile(seen, 90)) if len(seen) else 0.0
        if found.noise_rms > 0.0:  # not where no noise line was found
            top = 4.0 * found.noise_rms
            slope = np.polyfit(cutoff, found.curve["noise_line"], 1)[0]
            ax.plot([0.0, cutoff[-1]], [found.noise_rms, found.noise_rms + slope * cutoff[-1]],
                    color=_SMOOTH, linestyle="--", linewidth=1, label="noise line")  # fmt: skip
            ax.axhline(found.noise_rms, color=_SMOOTH, linestyle=":", linewidth=1,
                       label="its height at 0 Hz")  # fmt: skip
        for name, (chosen, _) in session.chosen().items():
            words, marker = _CUTOFF_MARKS[name]
            if math.isfinite(chosen):
                ax.plot(chosen, np.interp(chosen, cutoff, residual), marker, color="white",
                        markeredgecolor="black", label=words, zorder=4)  # fmt: skip
        self._line = ax.axvline(session.cutoff_hz, color=_HAND, linewidth=2, label="in your hand")
        ax.set(xlabel="Cut-off (Hz)", ylabel=f"Residual, RMS{self._in('')}")
        ax.set_xlim(0.0, session.highest_hz)
        ax.set_ylim(0.0, min(top, 1.05 * highest) or 1.0)
        # short numbers leave room for the label beside them
        ax.ticklabel_format(axis="y", style="sci", scilimits=(-2, 4))
        ax.legend(loc="upper right")

    def _draw_motion(self, grid: Any) -> None:
        """Draw the signal and its derivatives, without a filter and with it."""
        session = self.session
        self._smooth: dict[str, Any] = {}
        first = None
        for row, ((name, per), before) in enumerate(
            zip(_PANELS.items(), session.raw(), strict=True)
        ):
            ax = self._figure.add_subplot(grid[row, 1], sharex=first)
            first = first or ax
            ax.plot(session.time_s, before, color=_RAW, linewidth=0.8, label="no filter")
            (self._smooth[name],) = ax.plot(
                session.time_s, before, color=_SMOOTH, linewidth=1.3, label="filtered"
            )
            if row:
                _show_range(ax, getattr(session.smoothed(), name))
            ax.set_ylabel(f"{name}{self._in(per)}")
            ax.tick_params(labelbottom=row == len(_PANELS) - 1)
        ax.set_xlabel("Time (s)")
        ax.set_xlim(session.time_s[0], session.time_s[-1])
        self._figure.axes[1].legend(
            loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.2
        )
        self._figure.align_ylabels(self._figure.axes[1:])

    def _in(self, per: str) -> str:
        """Return the unit of a derivative in brackets; nothing where the unit is not known."""
        return f" ({self._unit}{per})" if self._unit else ""

    def _offer_methods(self) -> None:
        """Make a button for the cut-off of each method; its reason shows under the pointer."""
        buttons = []
        for name, (chosen, reason) in self.session.chosen().items():
            known = math.isfinite(chosen)
            said = f"{chosen:.2f} Hz" if known else "none found"
            button = widgets.Button(
                description=f"{_CUTOFF_MARKS[name][0]}: {said}", tooltip=reason, disabled=not known,
                layout={"width": "auto", "min_width": "16em"},
            )  # fmt: skip
            button.on_click(lambda _, hz=chosen: setattr(self, "cutoff_hz", hz))
            buttons.append(button)
        self._takers.children = (widgets.Label("take the cut-off of"), *buttons)

    @alone
    def _show_cutoff(self) -> None:
        """Move the line and the filtered curves to the cut-off in the hand."""
        self._line.set_xdata([self.session.cutoff_hz] * 2)
        for name, values in self.session.smoothed()._asdict().items():
            line = self._smooth[name]
            line.set_ydata(values)
            low, high = line.axes.get_ylim()
            seen = values[np.isfinite(values)]
            if len(seen) and not low <= seen.min() <= seen.max() <= high:
                _show_range(line.axes, values)
        self._told.value = self.session.text()
        set_theme(self._figure, dark=self._around.dark)
        self._canvas.draw_idle()

    @alone
    def _on_room(self, _change: dict[str, Any]) -> None:
        """Fit the plots into the page."""
        room = (self._around.width, self._around.height)
        fit_figure(
            self._figure, room=room, highest_px=_RESIDUAL_SIZE_PX[1], beside_px=_BESIDE_RESIDUAL_PX
        )

    def _on_signal(self, change: dict[str, Any]) -> None:
        """Show another signal."""
        self.session.show(change["new"])
        self._draw_all()

    def _on_slider(self, change: dict[str, Any]) -> None:
        """Take the slider's cut-off, unless a browser only brought it to a step of the slider."""
        if abs(change["new"] - self.cutoff_hz) > 0.501 * self.fs_step:
            self.cutoff_hz = self.session.set_cutoff(change["new"])

    def _on_number(self, change: dict[str, Any]) -> None:
        """Take the cut-off that was typed; the one in the hand is shown rounded."""
        if not math.isclose(change["new"], round(self.cutoff_hz, _TYPED_DIGITS), rel_tol=1e-9):
            self.cutoff_hz = self.session.set_cutoff(change["new"])

    def _on_cutoff(self, change: dict[str, Any]) -> None:
        """Show the cut-off that was taken, by whomever."""
        taken = self.session.set_cutoff(change["new"])
        self.cutoff_hz = taken  # at least the lowest
        self._slider.value, self._number.value = taken, round(taken, _TYPED_DIGITS)
        self._show_cutoff()

    def _on_press(self, event: Any) -> None:
        """Begin to drag where the residual curve is pressed."""
        self._dragging = event.inaxes is self._curve
        self._on_move(event)

    def _on_move(self, event: Any) -> None:
        """Take the cut-off under the pointer while dragging; the slider follows."""
        if self._dragging and event.inaxes is self._curve and event.xdata is not None:
            self.cutoff_hz = self.session.set_cutoff(float(event.xdata))

    def _on_release(self, _event: Any) -> None:
        """Stop dragging."""
        self._dragging = False


def _show_range(ax: Any, values: np.ndarray) -> None:
    """Give a panel the height of its filtered signal, and some room."""
    if not np.isfinite(values).any():
        return
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    room = (_ROOM - 1.0) / 2.0 * (high - low)
    if room > 0.0:
        ax.set_ylim(low - room, high + room)
