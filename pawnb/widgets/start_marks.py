"""What is drawn over the pictures while the start points are clicked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np

from pawnb.core.rig import Rig
from pawnb.workflow.start.exchanged_clicks import MAX_CLICK_RESIDUAL_PX

FAR_PX = MAX_CLICK_RESIDUAL_PX
"""Clicks further from where the other views put their point contradict them: as in
:func:`pawnb.check`."""

Slot = tuple[int, str, str]
"""Frame, view and point."""


class Clicked(Protocol):
    """What is asked of a :class:`pawnb.widgets.start_session.StartSession`."""

    rig: Rig | None
    sizes: dict[str, tuple[int, int]]
    colours: dict[str, str]
    points_by_view: dict[str, tuple[str, ...]]
    current: tuple[str, str] | None
    proposed: dict[Slot, tuple[float, float]]

    @property
    def frame(self) -> int:
        """The frame looked at."""

    @property
    def clicks(self) -> Mapping[Slot, tuple[float, float]]:
        """Every click."""

    @property
    def hidden(self) -> frozenset[Slot]:
        """Every point marked as hidden."""

    def asked_in(self, view: str) -> str | None:
        """Return the point that a click in a view places."""


def draw_view(session: Clicked, frame: int, view: str) -> dict[str, Any]:
    """Return what is drawn over one view: the clicks, and where other views put each point.

    Parameters
    ----------
    session : StartSession
        The clicks.
    frame : int
        Frame number.
    view : str
        The view.

    Returns
    -------
    dict
        points, hollow, lines, chips, guides and what is asked for; see ``frame_canvas.Overlay``.
    """
    clicks = session.clicks
    points, hollow, lines, chips = [], [], [], []
    guides = {}
    for point in session.points_by_view[view]:
        colour = session.colours[point]
        slot = (frame, view, point)
        uv = clicks.get(slot)
        if uv is not None:
            points.append({"id": point, "u": uv[0], "v": uv[1], "colour": colour})
        elif slot in session.proposed and slot not in session.hidden:
            u, v = session.proposed[slot]
            mark = {"id": point, "u": u, "v": v, "colour": colour, "origin": "predicted"}
            points.append(mark)  # drawn dashed
        guide = find_guide(session, frame, view=view, point=point)
        if guide is not None:
            guides[point] = guide
        if guide is not None and len(guide) == 1:
            hollow.append({"id": point, "u": guide[0][0], "v": guide[0][1], "colour": colour})
        elif guide is not None and session.current is not None and session.current[1] == point:
            lines.append({"at": guide, "colour": colour, "dash": True})
        chips.append({"id": point, "colour": colour} | _chip(session, slot, uv, guide))
    told = {"points": points, "hollow": hollow, "lines": lines, "chips": chips}
    asks = session.asked_in(view) if frame == session.frame else None
    return told | {"asks": asks, "guides": guides, "limit_px": FAR_PX, "residuals": True}


def _chip(
    session: Clicked,
    slot: Slot,
    uv: tuple[float, float] | None,
    guide: Sequence[Sequence[float]] | None,
) -> dict[str, str]:
    """Return state and title of a point's button."""
    if uv is not None:
        state, words = "done", f"clicked at ({uv[0]:.1f}, {uv[1]:.1f})"
        if guide is not None:
            words += f", {distance_px(uv, guide):.1f} px from where the other views put it"
    elif slot in session.hidden:
        state, words = "hidden", "hidden here"
    elif slot in session.proposed:
        state, words = "predicted", "proposed, not accepted yet"
    else:
        state, words = "open", "not clicked yet"
    return {"state": state, "title": f"{slot[2]}: {words}"}


def find_contradictions(session: Clicked, frame: int) -> list[tuple[str, str, float]]:
    """Return the clicks that are far from where the other views put their point.

    Parameters
    ----------
    session : StartSession
        The clicks.
    frame : int
        Frame number.

    Returns
    -------
    list of (view, point, px)
        One for each point, in the view where it is farthest off, the worst first.
    """
    worst: dict[str, tuple[str, str, float]] = {}
    for (at, view, point), uv in session.clicks.items():
        guide = find_guide(session, frame, view=view, point=point) if at == frame else None
        off = 0.0 if guide is None else distance_px(uv, guide)
        if off > FAR_PX and off > worst.get(point, ("", "", 0.0))[2]:
            worst[point] = (view, point, off)
    return sorted(worst.values(), key=lambda found: -found[2])


def distance_px(uv: Sequence[float], guide: Sequence[Sequence[float]]) -> float:
    """Return how far a click is from where the other views put its point, a place or a line."""
    start, away = np.array(guide[0]), np.array(uv) - guide[0]
    if len(guide) == 1:
        return float(np.hypot(*away))
    along = np.array(guide[1]) - start
    return float(abs(along[0] * away[1] - along[1] * away[0]) / np.hypot(*along))


def find_guide(session: Clicked, frame: int, *, view: str, point: str) -> list[list[float]] | None:
    """Return where the clicks in other views say a point is.

    Parameters
    ----------
    session : StartSession
        The clicks.
    frame : int
        Frame number.
    view, point : str
        Which point in which view.

    Returns
    -------
    list of [u, v] or None
        One position from two or more other views; the two ends of the epipolar line
        from one; None without a calibration or a click in another view.
    """
    if session.rig is None or view not in session.rig.names:
        return None
    others = {
        v: uv for (f, v, p), uv in session.clicks.items()
        if f == frame and p == point and v != view and v in session.rig.names
    }  # fmt: skip
    if not others:
        return None
    if len(others) == 1:
        (name, uv), = others.items()  # fmt: skip
        guide = session.rig.epipolar_line(name, uv, view, size=session.sizes[view])
    else:
        seen = session.rig.subset(others)
        xyz = seen.triangulate(np.array(list(others.values()))).xyz
        guide = session.rig.project(xyz)[None, session.rig.names.index(view)]
    if not np.isfinite(guide).all():
        return None
    return np.round(guide, 2).tolist()
