"""What is drawn over the pictures while the start points are clicked."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np

from pawnb.core.rig import Rig

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
    def clicks(self) -> Mapping[Slot, tuple[float, float]]:
        """Every click."""

    @property
    def hidden(self) -> frozenset[Slot]:
        """Every point marked as hidden."""


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
        points, hollow, lines and chips; see ``frame_canvas.Overlay``.
    """
    clicks = session.clicks
    points, hollow, lines, chips = [], [], [], []
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
        if guide is not None and len(guide) == 1:
            hollow.append({"id": point, "u": guide[0][0], "v": guide[0][1], "colour": colour})
        elif guide is not None and session.current is not None and session.current[1] == point:
            lines.append({"at": guide, "colour": colour, "dash": True})
        state = "done" if uv else "hidden" if slot in session.hidden else "open"
        if state == "open" and slot in session.proposed:
            state = "predicted"
        words = {
            "done": "" if uv is None else f"clicked at ({uv[0]:.1f}, {uv[1]:.1f})",
            "hidden": "hidden here",
            "open": "not clicked yet",
            "predicted": "proposed, not accepted yet",
        }[state]
        title = f"{point}: {words}"
        chips.append({"id": point, "state": state, "title": title, "colour": colour})
    return {"points": points, "hollow": hollow, "lines": lines, "chips": chips}


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
