"""Joints in space as steps: each takes what is known and returns what is known after it.

Some frames show the ground, the animal's appearance and its proportions. With these each frame is
fitted alone, takes over the heights of the frames beside where that explains more, and is in the
end fitted with them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pawnb.arrays import FloatArray, IntArray
from pawnb.core import dlt
from pawnb.core.frame_checkpoint import KeptFrames
from pawnb.core.parallel import THREADS, Threads
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import ImageEvidence
from pawnb.core.pose.space.fitter import SpaceFitter
from pawnb.core.pose.space.frame import SpaceFrame, known_without_picture
from pawnb.core.pose.space.learn import learn_model
from pawnb.core.pose.space.parameters import IN_SPACE
from pawnb.errors import InputError

Fit = tuple[FloatArray, float]
"""The unknowns of a frame, and their cost."""


@dataclass(frozen=True, eq=False, kw_only=True)
class SpaceRecording:
    """What is given.

    Parameters
    ----------
    frames : tuple of SpaceFrame
        The frames.
    numbers : ndarray of int, shape (n,)
        Their frame numbers.
    learn, wanted : list of int
        Which of them the model is learnt from, and which are to be fitted.
    progress, stop, kept
        As for :func:`.place_in_space`.
    """

    frames: tuple[SpaceFrame, ...]
    numbers: IntArray
    learn: list[int]
    wanted: list[int]
    progress: Callable[[int, int], None] | None
    stop: Callable[[], bool] | None
    kept: KeptFrames

    @property
    def is_stopped(self) -> bool:
        """Whether work ends early."""
        return self.stop is not None and self.stop()

    def is_next(self, k: int, other: int) -> bool:
        """Return whether one of the frames is there and lies beside another in the recording."""
        there = 0 <= other < len(self.frames)
        return there and abs(int(self.numbers[other]) - int(self.numbers[k])) == 1


@dataclass(frozen=True, eq=False, kw_only=True)
class SpaceState:
    """What is known; each step returns a new one.

    Parameters
    ----------
    recording : SpaceRecording
        What is given.
    fitter : SpaceFitter
        The animal as far as it was learnt.
    x : ndarray, shape (n, unknowns)
        Body height and joints of every frame; see :mod:`.picture_kernels`.
    cost : ndarray, shape (n,)
        What they cost; infinite before a frame is fitted.
    passes : int
        Passes over all frames that were made.
    """

    recording: SpaceRecording
    fitter: SpaceFitter
    x: FloatArray
    cost: FloatArray
    passes: int = 1

    def evidence(self, k: int) -> ImageEvidence:
        """Return what the second view shows of a frame."""
        one = self.recording.frames[k]
        return self.fitter.image_evidence(one.image, one.box)

    def with_fits(self, fits: dict[int, Fit]) -> SpaceState:
        """Return the state with other fits of some frames."""
        x, cost = self.x.copy(), self.cost.copy()
        for k, fit in fits.items():
            x[k], cost[k] = fit
        return replace(self, x=x, cost=cost)


def run_space_pipeline(recording: SpaceRecording, fitter: SpaceFitter) -> SpaceState:
    """Find the joints of the animal in space.

    Parameters
    ----------
    recording : SpaceRecording
        What is given.
    fitter : SpaceFitter
        Of which nothing was learnt yet.

    Returns
    -------
    SpaceState
        With the fits of the frames that are wanted, as far as work was not stopped.

    Raises
    ------
    InputError
        If the second view does not show the animal.
    """
    state = learn(begin(recording, fitter))
    for step in (
        fit_alone,
        take_over_from_before,
        take_over_from_after,
        *[fit_with_neighbours] * IN_SPACE.settle,
    ):
        state = step(state)
        if recording.is_stopped:
            break
    return state


def n_passes() -> int:
    """Return the passes over all frames: read, alone, from either side, with those beside."""
    return 4 + IN_SPACE.settle


def begin(recording: SpaceRecording, fitter: SpaceFitter) -> SpaceState:
    """Find the ground: the lowest height that the animal reaches."""
    n, unknowns = len(recording.frames), 1 + 3 * recording.frames[0].places[..., 0].size
    state = SpaceState(
        recording=recording, fitter=fitter, x=np.zeros((n, unknowns)), cost=np.full(n, np.inf)
    )
    some = recording.learn
    ground = [fitter.ground_below(recording.frames[k], state.evidence(k)) for k in some]
    if not np.isfinite(ground).any():
        raise InputError(
            "the second view shows nothing that differs from its background; look at the "
            "background and the order of the views."
        )
    model = fitter.model.changed(ground=float(np.nanmedian(ground)))
    return replace(state, fitter=fitter.with_model(model))


def learn(state: SpaceState) -> SpaceState:
    """Learn appearance and proportions from some frames, which are fitted in turn."""
    some, first = state.recording.learn, state.fitter.model.layout
    state = state.with_fits({k: _alone(state, k) for k in some})
    for _ in range(2):
        samples = [(state.recording.frames[k], state.evidence(k), state.x[k]) for k in some]
        model = learn_model(state.fitter, samples, first)
        state = replace(state, fitter=state.fitter.with_model(model))
        state = state.with_fits({k: _alone(state, k) for k in some})
    return state


def fit_alone(state: SpaceState) -> SpaceState:
    """Fit each frame from even arches."""
    order = state.recording.wanted
    return _each(state, "alone", order, _alone, threads=THREADS)


def take_over_from_before(state: SpaceState) -> SpaceState:
    """Fit each frame from the heights of the one before, whose valley may be the right one."""
    order = state.recording.wanted
    return _each(state, "after the frame before", order, lambda now, k: _take_over(now, k, k - 1))


def take_over_from_after(state: SpaceState) -> SpaceState:
    """Fit each frame from the heights of the one after it."""
    order = state.recording.wanted[::-1]
    return _each(state, "after the next frame", order, lambda now, k: _take_over(now, k, k + 1))


def fit_with_neighbours(state: SpaceState) -> SpaceState:
    """Fit each frame with the heights of the frames beside, as they were before this step."""
    way = f"with the frames beside {state.passes - n_passes() + IN_SPACE.settle}"
    return _each(
        state, way, state.recording.wanted, lambda _, k: _with_neighbours(state, k), threads=THREADS
    )


def _each(
    state: SpaceState,
    name: str,
    order: Sequence[int],
    fit: Callable[[SpaceState, int], Fit],
    *,
    threads: int = 1,
) -> SpaceState:
    """Return the state after frames were fitted in an order, each by what is known until then.

    What an earlier run has found is taken from there. On several threads nothing is known of
    other frames' new fits.
    """
    recording, way = state.recording, f"in space, {name}"
    now = state.with_fits({})

    def one(k: int) -> bool:
        found = recording.kept.recall(way, int(recording.numbers[k]))
        if found is not None:
            now.x[k], now.cost[k] = found["x"], found["cost"]
        elif not recording.is_stopped:
            now.x[k], now.cost[k] = fit(now, k)
            return True
        return False

    with Threads(threads, thread_name_prefix="pawnb-space") as pool:
        for k, is_new in zip(order, pool.map(one, order), strict=True):
            if is_new:
                found = {"x": now.x[k], "cost": float(now.cost[k])}
                recording.kept.keep(way, int(recording.numbers[k]), found)
    n, passes = len(recording.frames), state.passes + 1
    if recording.progress is not None:
        recording.progress(passes * n, n_passes() * n)
    return replace(now, passes=passes)


def _alone(state: SpaceState, k: int) -> Fit:
    """Return a frame's fit from even arches."""
    fitter, one, image_evidence = state.fitter, state.recording.frames[k], state.evidence(k)
    known = known_without_picture(fitter.model, one, expected=None, expected_sd=1.0)
    start = fitter.guess(one, image_evidence)
    return fitter.refine(one, image_evidence, start, known=known, coarse=True)


def _take_over(state: SpaceState, k: int, other: int) -> Fit:
    """Return a frame's fit from the heights of another beside, if that explains more."""
    before = state.x[k], float(state.cost[k])
    if not state.recording.is_next(k, other):
        return before
    fitter, one, image_evidence = state.fitter, state.recording.frames[k], state.evidence(k)
    known = known_without_picture(fitter.model, one, expected=None, expected_sd=1.0)
    found = fitter.refine(one, image_evidence, _moved(state, other, k), known=known)
    return found if found[1] < before[1] else before


def _moved(state: SpaceState, other: int, k: int) -> FloatArray:
    """Return the unknowns of one frame moved to where the first view has another."""
    lines, frames = state.fitter.model.lines, state.recording.frames
    joints = state.x[other, 1:].reshape(*frames[k].places.shape[:2], 3)
    slid = dlt.project(lines.coefs, joints)[..., 0, :] - frames[other].places
    moved = lines.at(frames[k].places + slid, lines.height(joints))
    return np.concatenate([state.x[other, :1], np.nan_to_num(moved).ravel()])


def _with_neighbours(state: SpaceState, k: int) -> Fit:
    """Return a frame's fit with the heights of the frames beside."""
    one, image_evidence = state.recording.frames[k], state.evidence(k)
    model = state.fitter.model
    step = model.settings.height_step_share * model.span
    expected = heights_beside(state, k)
    known = known_without_picture(model, one, expected=expected, expected_sd=step)
    return state.fitter.refine(one, image_evidence, state.x[k], known=known)


def heights_beside(state: SpaceState, k: int) -> FloatArray | None:
    """Return the heights between those in the frames beside; None where one is missing.

    Parameters
    ----------
    state : SpaceState
        What is known.
    k : int
        Which frame.

    Returns
    -------
    ndarray, shape (1 + joints,), or None
        Of body and joints.
    """
    beside = [j for j in (k - 1, k + 1) if state.recording.is_next(k, j)]
    if len(beside) < 2:
        return None
    lines = state.fitter.model.lines

    def heights(x: FloatArray) -> FloatArray:
        return np.concatenate([x[:1], lines.height(x[1:].reshape(-1, 3))])

    return np.asarray(np.mean([heights(state.x[j]) for j in beside], axis=0))
