"""What the session of start points says: what to click next, and what is missing."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pawnb.widgets.start_marks import find_contradictions
from pawnb.widgets.start_points import MOUSE_PAWS
from pawnb.workflow.start.exchanged_clicks import tell_exchanged

if TYPE_CHECKING:
    from pawnb.widgets.start_session import StartSession


_MOST_TOLD = 8


def next_step(session: StartSession) -> str:
    """Say what to do next."""
    if session.current is None:
        return "All points are placed or marked as hidden. Drag a point to adjust it."
    if session.offered():
        return "Proposed points are dashed: drag those that are wrong, then accept all (Enter)."
    view, point = session.current
    more = f" ({MOUSE_PAWS[point]})" if point in MOUSE_PAWS else ""
    asked = f"Click {point}{more} in {view}, or"
    if any(f != session.frame and p == point for f, _, p in session.clicks):
        return f"{asked} leave it out here: it is clicked in another frame."
    return f"{asked} press H if it is hidden there."


def what_is_clicked(session: StartSession) -> str:
    """Say which frames have clicks; empty where no other frame than this one has."""
    frames = sorted({frame for frame, _, _ in session.clicks})
    if not set(frames) - {session.frame}:
        return ""
    told = ", ".join(map(str, frames[:_MOST_TOLD]))
    more = len(frames) - _MOST_TOLD
    return f"Clicked: frame{'s' if len(frames) > 1 else ''} {told}" + (
        f" and {more} more." if more > 0 else "."
    )


def what_contradicts(session: StartSession) -> str:
    """Say which clicks of this frame contradict those of the other views; empty where none do."""
    found = find_contradictions(session, session.frame)
    here = {(v, p): uv for (f, v, p), uv in session.clicks.items() if f == session.frame}
    told = [] if session.rig is None else tell_exchanged(session.rig, here)
    parts = [f"{text}." for text in told]
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
