"""The plots of the GaitExplorer: gait diagram, signal, phases and strides, drawn from its state.

The axes are made once and stay where they are: what the pointer is over is then never in doubt,
and picking something only moves the marks that lie over the plots.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.patheffects import withStroke

from pawnb import figures
from pawnb.figures.style import OKABE_ITO, colour_legs
from pawnb.widgets.gait_session import EVENT_KINDS, GaitSession
from pawnb.widgets.plot_theme import SCREEN_PT, on_screen, shortened

_TICK_LETTERS, _NAME_LETTERS = 7, 11
"""Most letters of a leg's name beside its row and elsewhere: more would run into other plots."""
_PICKED = OKABE_ITO["yellow"]
"""The stride that is picked is yellow with a black edge: no leg has that colour."""
_EVENT = OKABE_ITO["vermillion"]
"""The event that is picked, on the yellow of its stride."""
_LINE = OKABE_ITO["blue"]
_DASHES: dict[str, Any] = {"AEP": "-", "PEP": "--", "TD": "-.", "LO": ":"}
"""The figures' own 7 pt are for paper; on a screen at 100 dots per inch that is too small."""
_EDGED = [withStroke(linewidth=5.0, foreground="black")]


class GaitPanels:
    """Four plots of a session in one figure.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        Where to draw; 10 x 6.4 inches suit it.
    session : GaitSession
        What to draw.

    Attributes
    ----------
    diagram, signal, rose, strides : matplotlib.axes.Axes
        Gait diagram; signal and events of one leg, below it on the same time; phases of the
        pair; period and duty factor of the leg's strides.
    rows : list of str
        Legs of the diagram, from the top.
    span_s : tuple of float
        The stretch of time that is shown.
    """

    def __init__(self, figure: Figure, session: GaitSession) -> None:
        self.session = session
        self.rows: list[str] = []
        self._marks: list[Artist] = []
        self.event_line: Line2D | None = None
        with on_screen():
            grid = figure.add_gridspec(
                1, 2, width_ratios=[2.9, 1.0], left=0.065, right=0.965, bottom=0.11, top=0.885,
                wspace=0.2,
            )  # fmt: skip
            left = grid[0].subgridspec(2, 1, hspace=0.5)
            # the words below the rose are as high on a small screen as on a large one
            right = grid[1].subgridspec(2, 1, hspace=0.62, height_ratios=[1.2, 1.0])
            self.diagram: Axes = figure.add_subplot(left[0])
            self.signal: Axes = figure.add_subplot(left[1], sharex=self.diagram)
            self.rose: Any = figure.add_subplot(right[0], projection="polar")
            self.strides: Axes = figure.add_subplot(right[1])
        self.span_s = session.span_s

    def draw(self) -> None:
        """Draw everything anew: another trial, pair or set of legs, or a correction."""
        with on_screen():
            self._draw_diagram()
            self._draw_rose()
        self.draw_leg()

    def draw_leg(self) -> None:
        """Draw what belongs to the leg that is shown, and the marks."""
        with on_screen():
            self._draw_signal()
            self._draw_strides()
        self.show_span(self.span_s)
        self.mark()

    def show_span(self, span_s: tuple[float, float]) -> None:
        """Show a stretch of time, s."""
        self.span_s = span_s
        self.diagram.set_xlim(*span_s)

    def mark(self) -> None:
        """Mark the stride and the event that are picked, in every plot."""
        for artist in self._marks:
            if artist.axes is not None:
                artist.remove()
        self._marks, self.event_line = [], None
        if (stride := self.session.picked()) is not None:
            self._mark_stride(stride)
        if (event := self.session.event) is not None:
            low, high = self.share_of(event[1])
            self.event_line = self.signal.axvline(
                event[2], low, high, color=_EVENT, linewidth=3.0, zorder=5
            )
            self._marks.append(self.event_line)
        if (place_s := self.session.place_s) is not None:
            line = self.signal.axvline(
                place_s, color=_EVENT, linewidth=1.5, linestyle=":", zorder=5
            )
            self._marks.append(line)

    def _mark_stride(self, stride: dict[str, Any]) -> None:
        """Mark one stride in every plot."""
        start, period = stride["start_s"], stride["period_s"]
        if stride["leg"] in self.rows:
            row = self.rows.index(stride["leg"])
            for look in ({"facecolor": _PICKED, "zorder": 0.5}, {"fill": False, "zorder": 4}):
                frame = Rectangle(
                    (start, row - 0.46), period, 0.92, edgecolor="black", linewidth=1.8, **look
                )
                self._marks.append(self.diagram.add_patch(frame))
        span = self.signal.axvspan(start, start + period, facecolor=_PICKED, alpha=0.45, zorder=0.5)
        self._marks.append(span)
        for phase in self.session.picked_phases():
            at = 2.0 * math.pi * phase
            self._marks += self.rose.plot(
                [at, at], [0.0, 1.0], color=_PICKED, linewidth=3.0, path_effects=_EDGED
            )
        if math.isfinite(stride["duty_factor"]):
            self._marks += self.strides.plot(
                period, stride["duty_factor"], "o", markersize=9, markerfacecolor=_PICKED,
                markeredgecolor="black", zorder=5,
            )  # fmt: skip

    def _draw_diagram(self) -> None:
        """Draw the gait diagram; strides that do not count are crossed."""
        ax, events = self.diagram, self.session.events
        ax.clear()
        self.rows = []
        if events.empty:
            _say(ax, "no events of these legs")
            return
        dropped = self.session.dropped
        table = figures.build_gait_diagram_table(events, dropped=dropped)
        figures.plot_gait_diagram(table, ax=ax)
        self.rows = list(dict.fromkeys(table["leg"]))
        named = [shortened(leg, _TICK_LETTERS) for leg in self.rows]
        ax.set_yticks(range(len(self.rows)), named)
        if max(map(len, named), default=0) > _TICK_LETTERS // 2:
            ax.set_ylabel("")  # names take its place
        own = dropped[(dropped["what"] == "stride") & dropped["leg"].isin(self.rows)]
        for leg, start, end in own[["leg", "start_s", "end_s"]].itertuples(index=False):
            ax.add_patch(
                Rectangle(
                    (start, self.rows.index(leg) - 0.42), end - start, 0.84,
                    facecolor=(1.0, 1.0, 1.0, 0.6), edgecolor="0.25", hatch="xxx",
                    linewidth=0.6, zorder=3,
                )
            )  # fmt: skip
        if len(own):
            ax.set_title("crossed: stride does not count", loc="left", fontsize=SCREEN_PT - 1.0)
        ax.set_xlabel("")

    def _draw_signal(self) -> None:
        """Draw the signal of a leg with its events."""
        session, ax = self.session, self.signal
        ax.clear()
        leg, signal = session.shown_leg, session.signal()
        named = shortened(leg, _NAME_LETTERS)
        if signal is not None:
            column = signal.samples[:, signal.legs.index(leg)]
            ax.plot(signal.time_s, column, color=self._leg_colour(), linewidth=1.3)
            ax.set_ylabel(f"{named}: {signal.signal} ({signal.unit})")
        else:
            ax.set_ylabel(f"{named}: events")
            ax.set_yticks([])
        known: list[str] = []
        for name, own in session.leg_events.groupby("event", sort=False):
            known.append(str(name))
            low, high = self.share_of(str(name))
            for time_s in own["time_s"]:
                ax.axvline(time_s, low, high, linestyle=_DASHES[str(name)], color="0.3",
                           linewidth=1.1)  # fmt: skip
        keys = [Line2D([], [], color="0.3", linestyle=dash, linewidth=1.1, label=name)
                for name, dash in _DASHES.items() if name in known]  # fmt: skip
        ax.legend(handles=keys, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=4,
                  borderaxespad=0.2, handlelength=3.0)  # fmt: skip
        if len(session.kinds()) > 1:
            ax.axhline(sum(ax.get_ylim()) / 2.0, color="0.8", linewidth=0.6, zorder=0.6)
        ax.set_xlabel("Time (s)")

    def share_of(self, event: str) -> tuple[float, float]:
        """Return the part of the signal's height where a kind of event stands.

        Contact is near the extremes in time: with both kinds, extremes are above.
        """
        if len(self.session.kinds()) < 2:
            return 0.0, 1.0
        return (0.5, 1.0) if event in EVENT_KINDS[0] else (0.0, 0.5)

    def kinds_at(self, height: float) -> list[str]:
        """Return the kinds of events that stand at a height of the signal's axis."""
        low, high = self.signal.get_ylim()
        share = (height - low) / (high - low)
        names = (name for pair in self.session.kinds() for name in pair)
        return [n for n in names if self.share_of(n)[0] <= share <= self.share_of(n)[1]]

    def _draw_rose(self) -> None:
        """Draw the phases of the pair."""
        phases = self.session.phases
        self.rose.clear()
        if phases.empty:
            self.rose.set_axis_off()
            self.rose.set_title("no phases")
            return
        self.rose.set_axis_on()
        figures.plot_phase_rose(figures.build_phase_rose_table(phases), ax=self.rose)
        leg, other = (shortened(name, _NAME_LETTERS) for name in self.session.pair)
        self.rose.set_title(f"{leg} relative to {other}", pad=8.0)

    def _draw_strides(self) -> None:
        """Draw period and duty factor of every stride of the leg."""
        ax, own = self.strides, self.leg_points()
        ax.clear()
        ax.plot(
            own["period_s"], own["duty_factor"], "o", markersize=5, color=self._leg_colour(),
            alpha=0.8,
        )  # fmt: skip
        ax.margins(0.12)
        for axis, values in (("x", own["period_s"]), ("y", own["duty_factor"])):
            _at_least(ax, axis, 0.05 * float(values.mean()) if len(own) else 1.0)
        ax.locator_params(nbins=4)
        leg = shortened(self.session.shown_leg, _NAME_LETTERS)
        ax.set(xlabel=f"Period of {leg} (s)", ylabel="Duty factor")
        if own.empty:
            _say(ax, "none")

    def _leg_colour(self) -> str:
        """Return the colour that the leg has in the gait diagram; blue where it has no row."""
        return colour_legs(self.rows).get(self.session.shown_leg, _LINE)

    def leg_points(self) -> pd.DataFrame:
        """Return the strides of the leg that is shown, those with a duty factor."""
        own = self.session.strides
        own = own[(own["leg"] == self.session.shown_leg) & np.isfinite(own["duty_factor"])]
        return own.reset_index(drop=True)

    def nearest_stride(self, x: float, y: float) -> float | None:
        """Return the beginning of the stride whose point is within 12 px of a place (px)."""
        own = self.leg_points()
        if own.empty:
            return None
        at = self.strides.transData.transform(own[["period_s", "duty_factor"]].to_numpy(float))
        away = np.hypot(*(at - (x, y)).T)
        nearest = int(away.argmin())
        return float(own["start_s"].iloc[nearest]) if away[nearest] <= 12.0 else None


def _at_least(ax: Axes, axis: str, width: float) -> None:
    """Widen an axis about its middle, where equal strides leave it nearly no width."""
    low, high = getattr(ax, f"get_{axis}lim")()
    if high - low < width:
        middle = (low + high) / 2.0
        getattr(ax, f"set_{axis}lim")(middle - width / 2.0, middle + width / 2.0)


def _say(ax: Axes, text: str) -> None:
    """Write one line in the middle of empty axes."""
    ax.text(0.5, 0.5, text, transform=ax.transAxes, ha="center", va="center")
