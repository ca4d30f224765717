"""What :func:`pawnb.track` and :func:`pawnb.retrack` are asked for, whatever the kind of trial."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pawnb.core.paws.tracker import DEFAULT
from pawnb.errors import InputError
from pawnb.schema import shown
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

    def __post_init__(self) -> None:
        if not isinstance(self.method, str):
            raise InputError(f"method is {shown(self.method)}; expected its name.")
        if self.settings is not None and not isinstance(self.settings, Mapping):
            raise InputError(
                f"settings are {shown(self.settings)}; expected names and values, as "
                "{name: value}."
            )
        span = self.frames
        ends = [*span] if isinstance(span, Sequence | np.ndarray) else []
        whole = all(isinstance(one, int | np.integer) for one in ends)
        if span is not None and not (whole and len(ends) == 2):
            raise InputError(
                f"frames is {shown(span)}; expected the first and one past the last, as (0, 1000)."
            )


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
