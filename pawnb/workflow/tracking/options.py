"""What :func:`pawnb.track` and :func:`pawnb.retrack` are asked for, whatever the kind of trial."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from pawnb.core.paws.tracker import DEFAULT
from pawnb.workflow.progress import Progress


@dataclass(frozen=True)
class TrackOptions:
    """What a run is asked for.

    Parameters
    ----------
    method, settings, start, frames, out, quick, progress, stop, command
        As for :func:`pawnb.track`.
    """

    method: str = DEFAULT
    settings: Mapping[str, Any] | None = None
    start: pd.DataFrame | None = None
    frames: tuple[int, int] | None = None
    out: str | Path | None = None
    quick: bool = False
    progress: Progress | None = None
    stop: Callable[[], bool] | None = None
    command: Sequence[str] | None = None


@dataclass(frozen=True)
class RetrackOptions:
    """What tracking again is asked for.

    Parameters
    ----------
    learn, out, progress, stop
        As for :func:`pawnb.retrack`.
    """

    learn: bool = False
    out: str | Path | None = None
    progress: Progress | None = None
    stop: Callable[[], bool] | None = None
