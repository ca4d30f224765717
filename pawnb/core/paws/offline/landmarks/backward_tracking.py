"""Landmarks before they are placed: followed backwards, as forwards after."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from pawnb.core.paws.layout import Placement, Views
from pawnb.core.paws.offline.landmarks.template_tracking import TemplateTracker


def track_backwards(
    views: Views,
    follower: TemplateTracker,
    begin: int,
    *,
    progress: Callable[[int, int], None] | None = None,
    stop: Callable[[], bool] | None = None,
) -> bool:
    """Follow every landmark backwards from where each view first has it placed.

    Parameters
    ----------
    views : Views
        The opened views.
    follower : TemplateTracker
        Landmarks that were followed forwards; what is found is written into it.
    begin : int
        The frame that it was begun with.
    progress : callable, optional
        ``progress(done, total)`` after each frame, those followed forwards among them.
    stop : callable, optional
        Asked before each frame.

    Returns
    -------
    bool
        False if stopped: nothing is known then of the frames before.
    """
    n = len(follower.uv)
    placed = {t: here for t, here in follower.placed.items() if t < begin + n}
    first = _first_placed(placed)
    last = max(first.values(), default=begin)
    if last == begin:
        return True
    back = TemplateTracker(follower.layout, placed)
    for frame, pictures in views.frames(last, begin - 1, step=-1, partly=True):
        if stop is not None and stop():
            return False
        back.step(frame, pictures)
        if progress is not None and frame < last:
            progress(n + last - frame, n + last - begin)
    for key, frame in first.items():
        for row in range(frame - begin):
            follower.uv[row][key] = back.uv[last - begin - row][key]
            follower.likeness[row][key] = back.likeness[last - begin - row][key]
    return True


def frames_back(placed: Mapping[int, Sequence[Placement]], begin: int) -> int:
    """Return how many frames :func:`track_backwards` goes back through to frame ``begin``."""
    return max(_first_placed(placed).values(), default=begin) - begin


def _first_placed(placed: Mapping[int, Sequence[Placement]]) -> dict[tuple[int, int], int]:
    """Return the first frame in which each view has each landmark placed."""
    first: dict[tuple[int, int], int] = {}
    for frame in sorted(placed):
        for place in placed[frame]:
            first.setdefault((place.view, place.point), frame)
    return first
