"""Evidence of an earlier run, kept in memory: pictures in the body's frame, with their flow.

When clicks are added or corrected only what they change is worked out again: appearance of the
points that were placed (:mod:`.point_evidence`) and the association of places. What takes longest,
decoding and optical flow, depends on clicks only by the body's frame, and that of earlier clicks
serves while later ones lie well within it. Where they do not, pictures are read anew; what was
learnt of the points still serves, if the animal is of the same size.
"""

from __future__ import annotations

import operator
import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.parameters import RUN, SceneParameters
from pawnb.core.paws.offline.reuse.point_evidence import PointEvidence
from pawnb.core.paws.offline.scene.stack import BodyStack
from pawnb.schema import Tracks

GONE_ON_FROM = "gone_on_from_clicks"
"""Attribute of tracks: the clicks of the runs that this one has gone on from, as JSON."""
MOST_BYTES = 1.2e9
"""Resource: stacks of one recording, and what its points were found by, are kept up to so much:
about 1200 frames of a view, or 300 of four."""


@dataclass(frozen=True)
class RunBefore:
    """The last run on a recording, to go on from.

    Parameters
    ----------
    asked : str
        Of what, and how, beside its clicks.
    starts : tuple of DataFrame
        Its clicks, after those of the runs that it has gone on from itself.
    tracks : Tracks
        What it found.
    """

    asked: str
    starts: tuple[pd.DataFrame, ...]
    tracks: Tracks


@dataclass(frozen=True)
class _Kept:
    """Stacks of a window, and what its points were found by.

    Parameters
    ----------
    stacks : list of BodyStack
        Of each view.
    asked : str or None
        Of what points, and how, beside their clicks; None where no evidence is kept.
    evidence : mapping
        View to what was found there.
    """

    stacks: list[BodyStack]
    asked: str | None = None
    evidence: Mapping[str, PointEvidence] = field(default_factory=dict)

    @property
    def nbytes(self) -> int:
        """Bytes of memory."""
        return sum(own.nbytes for own in self.evidence.values()) + sum(
            array.nbytes
            for stack in self.stacks
            for array in (stack.grey, stack.colour, stack.forward, stack.backward)
            if array is not None
        )


class KeptStacks:
    """Stacks of one recording, and the last run on it; may be used from several threads.

    Parameters
    ----------
    most_bytes : float
        How much is kept; the oldest are let go.
    """

    def __init__(self, most_bytes: float = MOST_BYTES) -> None:
        self._most_bytes = most_bytes
        self._stacks: dict[tuple[object, ...], _Kept] = {}
        self._lock = threading.Lock()
        self._run: RunBefore | None = None

    def run_before(self, asked: str) -> RunBefore | None:
        """Return the last run, if it was asked for the same."""
        run = self._run
        return run if run is not None and run.asked == asked else None

    def keep_run(self, run: RunBefore) -> None:
        """Keep a run, a few hundred bytes a frame, in place of the one before it."""
        if self._most_bytes > 0:
            self._run = run

    def forget(self) -> None:
        """Keep nothing: a run from all clicks does not depend on what was done before it."""
        with self._lock:
            self._stacks.clear()
            self._run = None

    def find(
        self,
        names: Sequence[str],
        annotations: Sequence[Annotations],
        *,
        frames: tuple[int, int],
        parameters: SceneParameters,
    ) -> list[BodyStack] | None:
        """Return the stacks of some views, or None where there are none that fit.

        Parameters
        ----------
        names : sequence of str
            The views.
        annotations : sequence of Annotations
            What is placed in each of them.
        frames : tuple of int
            First frame and one past the last.
        parameters : SceneParameters
            What the stacks were to be made with.

        Returns
        -------
        list of BodyStack or None
            The stacks.
        """
        with self._lock:
            kept = self._stacks.get((*names, frames, parameters))
        if kept is None or not all(map(fits, kept.stacks, annotations)):
            return None
        return kept.stacks

    def keep(
        self,
        names: Sequence[str],
        stacks: list[BodyStack],
        *,
        frames: tuple[int, int],
        parameters: SceneParameters,
    ) -> None:
        """Keep the stacks of some views; arguments as for :meth:`find`.

        Parameters
        ----------
        names : sequence of str
            The views.
        stacks : list of BodyStack
            Their stacks.
        frames : tuple of int
            First frame and one past the last.
        parameters : SceneParameters
            What they were made with.
        """
        with self._lock:
            self._stacks.pop((*names, frames, parameters), None)
            self._stacks[*names, frames, parameters] = _Kept(stacks)
            while self._is_full():
                del self._stacks[next(iter(self._stacks))]

    def evidence(self, stacks: Sequence[BodyStack], asked: str) -> Mapping[str, PointEvidence]:
        """Return what the points were found by in some stacks, view by view, if it is kept.

        Parameters
        ----------
        stacks : sequence of BodyStack
            Stacks of one window.
        asked : str
            Of what points, and how, beside their clicks.
        """
        with self._lock:
            key = self._key_of(stacks)
            kept = None if key is None else self._stacks[key]
        return {} if kept is None or kept.asked != asked else kept.evidence

    def keep_evidence(
        self, stacks: Sequence[BodyStack], asked: str, found: Mapping[str, PointEvidence]
    ) -> None:
        """Keep what the points were found by, beside their stacks, if these are kept and it fits.

        Parameters
        ----------
        stacks, asked
            As for :meth:`evidence`.
        found : mapping
            View to what was found there.
        """
        with self._lock:
            key = self._key_of(stacks)
            if key is None:
                return
            kept = self._stacks[key]
            now = {view: own.compact() for view, own in found.items()}
            if kept.asked == asked:
                before = kept.evidence
                now = {view: before[view].updated(own) for view, own in now.items()}
            self._stacks[key] = _Kept(kept.stacks, asked, now)
            if self._is_full():  # pictures take longer to be had again
                self._stacks[key] = _Kept(kept.stacks)

    def _key_of(self, stacks: Sequence[BodyStack]) -> tuple[object, ...] | None:
        """Return under what just these stacks are kept, if they are."""
        for key, kept in self._stacks.items():
            if len(kept.stacks) == len(stacks) and all(map(operator.is_, kept.stacks, stacks)):
                return key
        return None

    def _is_full(self) -> bool:
        return sum(kept.nbytes for kept in self._stacks.values()) > self._most_bytes


def same_size(before: Sequence[Annotations], now: Sequence[Annotations]) -> bool:
    """Tell whether clicks show an animal of about the size that earlier ones did, in each view.

    Parameters
    ----------
    before, now : sequence of Annotations
        What is placed in each view.
    """
    for old, new in zip(before, now, strict=True):
        if new.rows and not old.rows:
            return False
        small, large = sorted((old.extent(), new.extent()))
        if large > RUN.kept_extent * small:  # false where one of them is not known
            return False
    return True


def fits(stack: BodyStack, annotations: Annotations) -> bool:
    """Tell whether a stack serves for clicks, too, for which it was not made.

    Parameters
    ----------
    stack : BodyStack
        Pictures in the body's frame.
    annotations : Annotations
        What is placed in its view.
    """
    extent = annotations.extent()
    if (
        np.isfinite(extent)
        and not 1 / RUN.kept_extent <= extent / stack.extent_px <= RUN.kept_extent
    ):
        return False
    size = np.array(stack.grey.shape[:0:-1])
    inside = RUN.kept_inside * stack.extent_px * stack.scale
    # where the picture itself ends there is no more to be seen
    low = np.where(stack.ends[0], 0.0, inside)
    high = np.where(stack.ends[1], size, size - inside)
    for here in annotations.moved(stack.to_body).places.values():
        for xy in here.values():
            if not ((low <= xy) & (xy <= high)).all():
                return False
    return True
