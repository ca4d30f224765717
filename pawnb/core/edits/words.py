"""Corrections in words, for a status line."""

from __future__ import annotations

from pawnb.core.edits.records import (
    Accept,
    Delete,
    Edit,
    Hide,
    Interpolate,
    Move,
    Pose,
    Retrack,
    Swap,
)


def describe_edit(edit: Edit) -> str:
    """Say in words what a correction was.

    Parameters
    ----------
    edit : Edit
        The correction.

    Returns
    -------
    str
        For instance ``"FR in cam1 moved in frame 12"``.
    """
    match edit:
        case Move():
            return f"{edit.point} in {edit.view} moved in frame {edit.frame}"
        case Accept():
            return f"{edit.point} in {edit.view} accepted in frame {edit.frame}"
        case Hide():
            return f"{edit.point}{_view(edit)} marked as not visible {_frames(edit)}"
        case Delete():
            return f"{edit.point}{_view(edit)} deleted {_frames(edit)}"
        case Interpolate():
            return f"{edit.point}{_view(edit)} interpolated {_frames(edit)}"
        case Swap():
            when = f"from frame {edit.frame} on" if edit.stop is None else _frames(edit)
            return f"{edit.first} and {edit.second} exchanged{_view(edit)} {when}"
        case Pose():
            return f"posed in frame {edit.frame}"
        case Retrack():
            learnt = ", colours learnt there" if edit.learn else ""
            when = f"from frame {edit.frame} on" if edit.stop is None else _frames(edit)
            return f"tracked again {when}{learnt}"


def _view(edit: Hide | Delete | Interpolate | Swap) -> str:
    """Return the one view that was meant, in words."""
    return "" if edit.view is None else f" in {edit.view}"


def _frames(edit: Hide | Delete | Interpolate | Swap | Retrack) -> str:
    """Return the frames that were meant, in words."""
    since = edit.since if isinstance(edit, Retrack) else None
    first = edit.frame if since is None else since
    if edit.stop is None or edit.stop == first + 1:
        return f"in frame {first}"
    return f"in frames {first} to {edit.stop - 1}"
