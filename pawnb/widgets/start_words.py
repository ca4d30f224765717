"""What the session of start points says: what to click next, and what is missing."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pawnb.io.start import MAX_FRAMES
from pawnb.widgets.start_marks import find_contradictions
from pawnb.widgets.start_points import MOUSE_PAWS

if TYPE_CHECKING:
    from pawnb.widgets.start_session import StartSession


def next_step(session: StartSession) -> str:
    """Say what to do next."""
    clicked = {frame for frame, _, _ in session.clicks}
    others = sorted(clicked - {session.frame})
    if session.frame not in clicked and len(others) == MAX_FRAMES:
        return f"Frames {others[0]} and {others[1]} have the clicks; go there to change them."
    if session.frame not in clicked and others:
        return (
            f"Frame {others[0]} has the clicks. Clicking the points here too is optional: two "
            "frames give the tracker the first velocities."
        )
    if session.current is None:
        return "All points are placed or marked as hidden. Drag a point to adjust it."
    if session.offered():
        return "Proposed points are dashed: drag those that are wrong, then accept all (Enter)."
    view, point = session.current
    more = f" ({MOUSE_PAWS[point]})" if point in MOUSE_PAWS else ""
    return f"Click {point}{more} in {view}, or press H if it is hidden there."


def what_contradicts(session: StartSession) -> str:
    """Say which clicks of this frame contradict those of the other views; empty where none do."""
    found = find_contradictions(session, session.frame)
    parts = []
    for view, point, off in found:
        others = [v for f, v, p in session.clicks if (f, p) == (session.frame, point) and v != view]
        parts.append(
            f"{point} in {view} is {off:.0f} px from where {' and '.join(others)} "
            f"{'put' if len(others) > 1 else 'puts'} it: one of these clicks is on another point."
        )
    return " ".join(parts)


def what_is_missing(session: StartSession) -> str:
    """Say what a tracker would still lack, or that nothing is missing."""
    nowhere, alone = [], []
    offered = dict.fromkeys(point for _, _, point in session.offered())
    for point in session.points:
        views = {v for _, v, p in session.clicks if p == point}
        tracked = [v for v, points in session.points_by_view.items() if point in points]
        if not views and point not in offered:
            nowhere.append(point)
        elif len(views) == 1 and len(tracked) > 1 and session.rig is not None:
            alone.append(f"{point} ({views.pop()})")
    parts = []
    if offered:
        parts.append(f"Not accepted yet: {', '.join(offered)}.")
    if nowhere:
        parts.append(f"Not clicked in any view yet: {', '.join(nowhere)}.")
    if alone:
        parts.append(f"Clicked in one view only, two are needed in 3D: {', '.join(alone)}.")
    return " ".join(parts) or "Nothing is missing."
