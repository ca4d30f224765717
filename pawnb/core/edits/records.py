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
    view, point : str
        Which point in which view.
    """

    frame: int
    view: str
    point: str


@dataclass(frozen=True, kw_only=True)
class Swap:
    """Two points were mistaken for one another from a frame on.

    Parameters
    ----------
    frame : int
        First frame in which they are exchanged.
    first, second : str
        The two points.
    view : str, optional
        The one view in which it happened; None for every view and the 3D points.
    """

    frame: int
    first: str
    second: str
    view: str | None = None


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
    """

    frame: int
    learn: bool = False


Edit: TypeAlias = Move | Accept | Hide | Swap | Pose | Retrack
Entry: TypeAlias = Edit | Step

EDIT_LINES: LineFormat[Edit] = LineFormat(
    {
        "move": Move,
        "accept": Accept,
        "hide": Hide,
        "swap": Swap,
        "pose": Pose,
        "retrack": Retrack,
    }
)
"""The lines of ``edits.jsonl``."""
