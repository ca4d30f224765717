"""Corrections of tracks as frozen records, which are the lines of ``edits.jsonl``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from pawnb.io.journal import LineFormat, Step


@dataclass(frozen=True, kw_only=True)
class Move:
    """The point is here.

    Parameters
    ----------
    frame : int
        Frame number.
    view, point : str
        Which point in which view.
    u, v : float
        Its position in px of the view.
    """

    frame: int
    view: str
    point: str
    u: float
    v: float


@dataclass(frozen=True, kw_only=True)
class Accept:
    """The point is right as it is; a person says so, and the position is written down.

    Parameters
    ----------
    frame : int
        Frame number.
    view, point : str
        Which point in which view.
    u, v : float
        The position that was accepted, in px of the view.
    """

    frame: int
    view: str
    point: str
    u: float
    v: float


@dataclass(frozen=True, kw_only=True)
class Hide:
    """The point cannot be seen here.

    Parameters
    ----------
    frame : int
        Frame number.
    view : str or None
        In which view; None for every view.
    point : str
        Which point.
    stop : int, optional
        One past the last frame, where it cannot be seen over a stretch.
    """

    frame: int
    view: str | None
    point: str
    stop: int | None = None


@dataclass(frozen=True, kw_only=True)
class Delete:
    """What was tracked of a point over a stretch is wrong; tracking again may find it.

    Parameters
    ----------
    frame, stop : int
        First frame, and one past the last.
    point : str
        Which point.
    view : str, optional
        The one view in which it is deleted; None for every view.
    """

    frame: int
    stop: int
    point: str
    view: str | None = None


@dataclass(frozen=True, kw_only=True)
class Interpolate:
    """Over a stretch the point lies on a smooth path between what is known around it.

    What was placed by hand within the stretch stays, and the path leads through it.

    Parameters
    ----------
    frame, stop : int
        First frame, and one past the last.
    point : str
        Which point.
    view : str, optional
        The one view in which that is done; None for every view.
    """

    frame: int
    stop: int
    point: str
    view: str | None = None


@dataclass(frozen=True, kw_only=True)
class Swap:
    """Two points were mistaken for one another from a frame on, or over a stretch.

    Parameters
    ----------
    frame : int
        First frame in which they are exchanged.
    first, second : str
        The two points.
    view : str, optional
        The one view in which it happened; None for every view and the 3D points.
    stop : int, optional
        One past the last frame in which they are exchanged; None to the end.
    """

    frame: int
    first: str
    second: str
    view: str | None = None
    stop: int | None = None


@dataclass(frozen=True, kw_only=True)
class Pose:
    """The jointed animal stands like this.

    Parameters
    ----------
    frame : int
        Frame number.
    pose : dict of str to float
        The columns of ``pose.csv`` that describe a pose: x, y, heading, the joints, scale and
        projected lengths; see :func:`pawnb.core.pose.corrected.pose_values`.
    """

    frame: int
    pose: dict[str, float]


@dataclass(frozen=True, kw_only=True)
class Retrack:
    """The trial was tracked again from a frame on, every state of the tracker reset.

    Parameters
    ----------
    frame : int
        The frame it was started from.
    learn : bool
        Whether the colours of the corrected points were learnt anew there.
    since, stop : int, optional
        First frame that was taken over from it, and one past the last; None for all.
    """

    frame: int
    learn: bool = False
    since: int | None = None
    stop: int | None = None


Edit: TypeAlias = Move | Accept | Hide | Delete | Interpolate | Swap | Pose | Retrack
Entry: TypeAlias = Edit | Step

EDIT_LINES: LineFormat[Edit] = LineFormat(
    {
        "move": Move,
        "accept": Accept,
        "hide": Hide,
        "delete": Delete,
        "interpolate": Interpolate,
        "swap": Swap,
        "pose": Pose,
        "retrack": Retrack,
    }
)
"""The lines of ``edits.jsonl``."""
