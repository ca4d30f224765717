"""The hidden Markov model of one point against all of its paths, and carried by flow."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from pawnb.core.paws.offline.association.forward_backward import smooth_posterior
from pawnb.core.paws.offline.parameters import AssociationParameters


def no_flow(n, h, w):
    return np.zeros((n - 1, h, w, 2), np.float32)


def transition(h, w, parameters):
    """Probability of a place (row) given that before (column), by filters of SciPy."""

    def spread(sd):
        # the picture is repeated as in a mirror, so that no probability is lost at the edge
        along_x, along_y = (
            gaussian_filter1d(np.eye(k), sd, axis=0, mode="reflect") for k in (w, h)
        )
        return np.kron(along_y, along_x)

    return (1 - parameters.far) * spread(parameters.near_sd) + parameters.far * spread(
        parameters.far_sd
    )


@pytest.mark.parametrize("sds", [(0.5, 2.5), (0.4, 0.9)])
def test_without_flow_it_is_the_sum_over_all_paths(sds):
    """Of three frames of 3 x 3 places there are 729 paths; their products are added up."""
    parameters = AssociationParameters(lost=0.0, near_sd=sds[0], far_sd=sds[1])
    random = np.random.default_rng(3)
    likelihood = random.uniform(0.01, 5, (3, 3, 3)).astype(np.float32)
    prior = random.uniform(0.1, 1, (3, 3)).astype(np.float32)
    prior /= prior.sum()
    flow = no_flow(3, 3, 3)
    found = smooth_posterior(likelihood, flow, flow, prior=prior, parameters=parameters).mass

    step = transition(3, 3, parameters)
    np.testing.assert_allclose(step.sum(axis=0), 1, rtol=1e-9)
    looks = likelihood.reshape(3, 9).astype(float)
    expected = np.zeros((3, 9))
    for path in itertools.product(range(9), repeat=3):
        a, b, c = path
        weight = prior.ravel()[a] * looks[0, a] * step[b, a] * looks[1, b] * step[c, b]
        weight *= looks[2, c]
        for t, place in enumerate(path):
            expected[t, place] += weight
    expected /= expected.sum(axis=1, keepdims=True)
    np.testing.assert_allclose(found.reshape(3, 9), expected, rtol=2e-4)


def test_every_frame_sums_to_one_and_one_frame_is_the_rule_of_bayes():
    random = np.random.default_rng(0)
    likelihood = random.uniform(0.1, 3, (6, 8, 11)).astype(np.float32)
    prior = np.full((8, 11), 1 / 88, np.float32)
    flow = random.normal(0, 2, (5, 8, 11, 2)).astype(np.float32)
    parameters = AssociationParameters()
    found = smooth_posterior(likelihood, flow, -flow, prior=prior, parameters=parameters).mass
    np.testing.assert_allclose(found.sum(axis=(1, 2)), 1, rtol=1e-4)
    alone = smooth_posterior(
        likelihood[:1], flow[:0], flow[:0], prior=prior, parameters=parameters
    ).mass
    np.testing.assert_allclose(alone[0], likelihood[0] / likelihood[0].sum(), rtol=1e-4)


@pytest.mark.parametrize("seen", [0, 4])
def test_what_is_seen_once_is_carried_by_flow_to_later_and_earlier_frames(seen):
    """Two places right and one down in each frame, seen at (11, 7) in one frame only."""
    n, h, w = 5, 18, 30
    flow = np.broadcast_to(np.float32([2, 1]), (n - 1, h, w, 2))
    likelihood = np.ones((n, h, w), np.float32)
    likelihood[seen, 7, 11] = 1e6
    prior = np.full((h, w), 1 / (h * w), np.float32)
    parameters = AssociationParameters(lost=1e-6)
    found = smooth_posterior(likelihood, flow, -flow, prior=prior, parameters=parameters).mass
    for t in range(n):
        y, x = np.unravel_index(found[t].argmax(), (h, w))
        assert (x, y) == (11 + 2 * (t - seen), 7 + (t - seen))


def test_a_point_that_was_lost_is_found_anywhere():
    """30 places from one frame to the next: likelier than to stay, if it may be lost.

    The path that jumps weighs 1e4² 3e3² 1e-3 / 240, the one that stays 1e4².
    """
    likelihood = np.ones((4, 6, 40), np.float32)
    likelihood[:2, 3, 5], likelihood[2:, 3, 35] = 1e4, 3e3
    prior = np.full((6, 40), 1 / 240, np.float32)
    flow = no_flow(4, 6, 40)
    at = {}
    for lost in (0.0, 1e-3):
        parameters = AssociationParameters(lost=lost, near_sd=0.3, far=0.01, far_sd=1.0)
        found = smooth_posterior(likelihood, flow, flow, prior=prior, parameters=parameters).mass
        at[lost] = [int(m.argmax()) % 40 for m in found]
    assert at == {0.0: [5, 5, 5, 5], 1e-3: [5, 5, 35, 35]}


def test_what_came_before_and_what_comes_after_agree_or_exclude_each_other():
    """Seen at (8, 6) first and last; or last 22 places further, where it cannot be so soon."""
    n, h, w = 5, 12, 40
    prior = np.full((h, w), 1 / (h * w), np.float32)
    flow = no_flow(n, h, w)
    middle = {}
    for end in (8, 30):
        likelihood = np.ones((n, h, w), np.float32)
        likelihood[0, 6, 8] = likelihood[-1, 6, end] = 1e6
        parameters = AssociationParameters(lost=1e-6)
        found = smooth_posterior(likelihood, flow, flow, prior=prior, parameters=parameters)
        assert found.agreement.shape == (n,)
        assert found.agreement[-1] == 1  # nothing comes after the last
        middle[end] = found.agreement[2]
    assert middle[8] > 0.95
    assert middle[30] < 0.1
