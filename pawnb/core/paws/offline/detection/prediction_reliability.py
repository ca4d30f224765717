"""When another program is right: a hidden Markov chain for each point.

A program is right about a point, astray (somewhere else in each frame), elsewhere (on another
point for a while, where it moves as smoothly as on its own), or mistaken: it calls another point
by this name throughout, which clicks alone can tell. What is seen of it:

- its likelihood, by :data:`LIKELIHOOD_EDGES`;
- how far its prediction steps, beside how far it mostly does, by :data:`STEP_EDGES`, and whether
  it exchanges places with another point;
- how far it lies from a click, where there is one.

How often each is seen in each state, and how often the state changes, is estimated in the
recording by expectation-maximisation (Baum et al. 1970) with pseudo-counts, as clicks are few.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pawnb.arrays import FloatArray, IntArray
from pawnb.core.paws.offline.detection.parameters import PREDICTIONS

LIKELIHOOD_EDGES = (0.1, 0.3, 0.6, 0.9, 0.97)
"""Definition: likelihoods between these are one kind; ``PREDICTIONS.counts_of_likelihoods`` are of
these kinds."""
STEP_EDGES = (1.0, 2.0, 3.0)
"""Definition: steps between these are one kind, in steps that are mostly not reached;
``PREDICTIONS.counts_of_steps`` are of these kinds."""
EXCHANGE = len(STEP_EDGES) + 1
"""Definition: a further kind of step: places are exchanged with another point."""
UNKNOWN_STATE = EXCHANGE + 1
"""Definition: another one: there is nothing to step from."""

RIGHT_STATE, ASTRAY, ELSEWHERE, MISTAKEN = 0, 1, 2, 3
"""Definition: numbers of the states."""

_STEP_OF = np.array([[0, 1, 2, 2], [1, 1, 1, 1], [2, 1, 0, 2], [2, 1, 2, 0]])
"""Definition: which counts of steps go with which change of state."""


@dataclass
class Rates:
    """Probabilities of the chain.

    Parameters
    ----------
    change : ndarray, shape (4, 4)
        Of the next state.
    likelihoods : ndarray, shape (3, kinds)
        Of each kind of likelihood in each state.
    steps : ndarray, shape (3, kinds)
        Of each kind of step, by ``_STEP_OF``.
    """

    change: FloatArray
    likelihoods: FloatArray
    steps: FloatArray

    @property
    def stays_wrong(self) -> float:
        """Mean number of frames for which the program stays elsewhere, at least 1."""
        return float(max(1 / (1 - self.change[ELSEWHERE, ELSEWHERE]), 1.0))

    def with_steps(self) -> FloatArray:
        """Return the probability of the next state and of a step, (kinds, from, to)."""
        steps = np.concatenate([self.steps[_STEP_OF], np.ones((4, 4, 1))], axis=2)
        return self.change * steps.transpose(2, 0, 1)


def estimate_rates(kinds: IntArray, state: FloatArray, pairs: FloatArray) -> Rates:
    """Return the rates that fit what was found, with the pseudo-counts.

    Parameters
    ----------
    kinds : ndarray of int, shape (n, P)
        Kinds of likelihood; -1 where nothing is predicted.
    state : ndarray, shape (n, P, 4)
        Probability of each state.
    pairs : ndarray, shape (kinds of step + 1, 4, 4)
        Expected number of each step with each change of state.

    Returns
    -------
    Rates
        The rates.
    """
    change, likelihoods, steps = _counts()
    change += pairs.sum(axis=0)
    seen = kinds >= 0
    for one in (RIGHT_STATE, ASTRAY, ELSEWHERE, MISTAKEN):
        likelihoods[one % MISTAKEN] += np.bincount(
            kinds[seen], weights=state[seen, one], minlength=likelihoods.shape[1]
        )
    for of in range(len(steps)):
        steps[of] += pairs[:UNKNOWN_STATE, of == _STEP_OF].sum(axis=1)
    return Rates(*(a / a.sum(axis=1, keepdims=True) for a in (change, likelihoods, steps)))


def first_rates() -> Rates:
    """Return the rates before the recording is looked at."""
    return Rates(*(a / a.sum(axis=1, keepdims=True) for a in _counts()))


def _counts() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the pseudo-counts of changes, likelihoods and steps."""
    return (
        np.array(PREDICTIONS.counts_of_changes),
        np.array(PREDICTIONS.counts_of_likelihoods),
        np.array(PREDICTIONS.counts_of_steps),
    )


def smooth_states(
    kinds: IntArray, steps: IntArray, *, at_clicks: FloatArray, rates: Rates
) -> tuple[FloatArray, FloatArray]:
    """Return the probability of each state, given the whole recording.

    Likelihoods of neighbouring frames are alike: while the program may be elsewhere, each counts
    for one in as many frames as it stays there.

    Parameters
    ----------
    kinds : ndarray of int, shape (n, P)
        Kinds of likelihood; -1 where nothing is predicted.
    steps : ndarray of int, shape (n, P)
        Kinds of step from the prediction before.
    at_clicks : ndarray, shape (n, P)
        How much likelier the distance from the click is where the program is right than where
        it is not; 1 where there is no click.
    rates : Rates
        The chain.

    Returns
    -------
    state : ndarray, shape (n, P, 4)
        Probabilities.
    pairs : ndarray, shape (kinds of step + 1, 4, 4)
        Expected number of each step with each change of state.
    """
    n, n_points = kinds.shape
    counts = np.array([1.0, 1.0, 1.0 / rates.stays_wrong, 1.0])
    relative = (
        rates.likelihoods[[RIGHT_STATE, ASTRAY, ELSEWHERE, RIGHT_STATE]]
        / rates.likelihoods[RIGHT_STATE]
    )
    seen = (relative ** counts[:, None])[:, kinds].transpose(1, 2, 0)
    seen = np.where((kinds >= 0)[..., None], seen, 1.0)
    seen[..., RIGHT_STATE] *= at_clicks
    change = rates.with_steps()[steps]
    ahead, back = np.empty((n, n_points, 4)), np.ones((n, n_points, 4))
    ahead[0] = _to_one(np.array(PREDICTIONS.at_first) * seen[0])
    for t in range(1, n):
        ahead[t] = _to_one(np.matmul(ahead[t - 1][:, None], change[t])[:, 0] * seen[t])
    for t in range(n - 2, -1, -1):
        to_come = seen[t + 1] * back[t + 1]
        back[t] = _to_one(np.matmul(change[t + 1], to_come[..., None])[..., 0])
    both = ahead[:-1, ..., None] * change[1:] * (seen[1:] * back[1:])[..., None, :]
    both /= np.maximum(both.sum(axis=(2, 3), keepdims=True), 1e-300)
    pairs = np.stack([both[steps[1:] == kind].sum(axis=0) for kind in range(UNKNOWN_STATE + 1)])
    return _to_one(ahead * back), pairs


def _to_one(mass: FloatArray) -> FloatArray:
    """Return what sums to 1 for each point."""
    return mass / np.maximum(mass.sum(axis=-1, keepdims=True), 1e-300)
