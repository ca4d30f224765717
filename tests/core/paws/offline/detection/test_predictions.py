"""Another program's predictions: which are right, and what they weigh as evidence."""

from __future__ import annotations

import numpy as np
import pytest

from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.detection.predictions import (
    judge_predictions,
    predictions_as_detections,
)

SIZE = (640, 480)
NOISE_PX = 2.0


def walk(n=400):
    """Four paws that swing over 60 px, in pairs that meet, as a trotting animal's do."""
    t, phase = np.arange(n)[:, None] / 40.0, np.array([0.0, 0.5, 0.5, 0.0])
    u = np.array([200.0, 205.0, 330.0, 335.0]) + 30 * np.sin(2 * np.pi * (t + phase))
    v = np.array([300.0, 288.0, 300.0, 288.0]) + 0 * t
    return np.stack([u, v], axis=2)


def predicted(rng, uv):
    """Predictions with noise and a high likelihood."""
    found = uv + NOISE_PX * rng.standard_normal(uv.shape)
    return found, 1 - np.abs(0.02 * rng.standard_normal(uv.shape[:2]))


def clicks(uv, *rows):
    return Annotations({row: dict(enumerate(uv[row])) for row in rows})


def swap(found, wrong, rng, share):
    """Swap left and right for stretches of 5 to 30 frames."""
    n = len(found)
    while wrong.mean() < share:
        begin, pair = rng.integers(1, n - 30), rng.integers(2) * 2
        stop = begin + rng.integers(5, 31)
        if not wrong[begin - 1 : stop + 1, pair].any():
            found[begin:stop, [pair, pair + 1]] = found[begin:stop, [pair + 1, pair]]
            wrong[begin:stop, pair : pair + 2] = True


def throw(found, wrong, rng, share):
    """Throw single predictions anywhere about the animal."""
    thrown = (rng.uniform(size=wrong.shape) < share) & ~wrong
    found[thrown] = rng.uniform((150, 250), (400, 350), (thrown.sum(), 2))
    wrong |= thrown


@pytest.mark.parametrize("swapped", [0.0, 0.1])
@pytest.mark.parametrize("thrown", [0.0, 0.05])
def test_the_share_of_errors_is_found(swapped, thrown):
    """Likelihoods say nothing here: steps and two clicked frames do."""
    said, made = [], []
    for seed in range(3):
        rng = np.random.default_rng(seed)
        uv = walk()
        found, likelihood = predicted(rng, uv)
        wrong = np.zeros(likelihood.shape, bool)
        swap(found, wrong, rng, swapped)
        throw(found, wrong, rng, thrown)
        quality = judge_predictions(found, likelihood, clicks(uv, 0, 200), size=SIZE)
        said.append(1 - quality.right.mean())
        far = np.linalg.norm(found - uv, axis=2) > 5 * NOISE_PX
        made.append(far.mean())
        assert quality.right[~far].mean() > 0.96
        if far.any():
            assert quality.right[far].mean() < 0.35
    assert np.mean(said) == pytest.approx(np.mean(made), abs=0.03)


@pytest.mark.slow
def test_probabilities_mean_what_they_say():
    """Of predictions that are said to be right with p, a share of p is."""
    p, right = [], []
    for seed in range(6):
        rng = np.random.default_rng(seed)
        uv = walk()
        found, likelihood = predicted(rng, uv)
        wrong = np.zeros(likelihood.shape, bool)
        swap(found, wrong, rng, 0.1)
        throw(found, wrong, rng, 0.05)
        quality = judge_predictions(found, likelihood, clicks(uv, 100), size=SIZE)
        p.append(quality.right)
        right.append(np.linalg.norm(found - uv, axis=2) < 5 * NOISE_PX)
    p, right = np.ravel(p), np.ravel(right)
    for low, high in ((0, 0.1), (0.9, 1.01)):
        here = (p >= low) & (p < high)
        assert right[here].mean() == pytest.approx(p[here].mean(), abs=0.07)
    # Brier score: that of the overall share is p (1 - p), about 0.13
    assert np.mean((p - right) ** 2) < 0.5 * right.mean() * (1 - right.mean())


def test_likelihood_is_believed_where_it_tells_errors():
    rng = np.random.default_rng(0)
    uv = walk()
    found, likelihood = predicted(rng, uv)
    wrong = np.zeros(likelihood.shape, bool)
    throw(found, wrong, rng, 0.1)
    likelihood[wrong] = rng.uniform(0.05, 0.5, wrong.sum())
    quality = judge_predictions(found, likelihood, clicks(uv, 0), size=SIZE)
    wrong &= np.linalg.norm(found - uv, axis=2) > 5 * NOISE_PX
    assert np.mean(quality.right[wrong] < 0.5) > 0.95
    assert np.mean(quality.right[likelihood > 0.9] > 0.5) > 0.99


def test_clicks_disprove_a_program_that_is_always_on_another_paw():
    """Nothing jumps and every likelihood is high: only clicks tell."""
    rng = np.random.default_rng(0)
    uv = walk()
    found, likelihood = predicted(rng, uv)
    found[:, [0, 1]] = found[:, [1, 0]]
    quality = judge_predictions(found, likelihood, clicks(uv, 10, 110, 210, 310), size=SIZE)
    assert quality.right[:, :2].mean() < 0.1
    assert quality.right[:, 2:].mean() > 0.98


def test_sd_is_that_of_the_residuals_at_clicks():
    rng = np.random.default_rng(0)
    uv = walk()
    found = uv + 6.0 * rng.standard_normal(uv.shape)
    likelihood = np.ones(uv.shape[:2])
    many = judge_predictions(found, likelihood, clicks(uv, *range(0, 400, 10)), size=SIZE)
    assert many.sd_px == pytest.approx(6.0, rel=0.15)
    exact = judge_predictions(uv, likelihood, clicks(uv, *range(0, 400, 10)), size=SIZE)
    # a floor of 0.01 of the animal's extent: the paws are up to about 180 px apart
    assert 0.01 * 130 < exact.sd_px < 0.01 * 200


def test_log_odds_are_those_of_the_formula():
    rng = np.random.default_rng(0)
    uv = walk()
    found, likelihood = predicted(rng, uv)
    quality = judge_predictions(found, likelihood, clicks(uv, 0), size=SIZE)
    made = predictions_as_detections(found, likelihood, clicks(uv, 0), size=SIZE)
    assert len(made.row) == uv[..., 0].size
    right = np.minimum(quality.right[made.row, made.point], 0.98)
    ratio = 1 + right / (1 - right) * quality.extent_px**2 / (2 * np.pi * quality.sd_px**2)
    weighed = ratio ** (1 / quality.stays_wrong)
    np.testing.assert_allclose(1 + np.exp(made.log_odds), weighed, rtol=1e-9)
    np.testing.assert_array_equal(made.uv, found[made.row, made.point])


def test_what_has_no_likelihood_or_position_carries_nothing():
    rng = np.random.default_rng(0)
    uv = walk(50)
    found, likelihood = predicted(rng, uv)
    likelihood[10:20, 0] = 0.001
    found[30:35, 1] = np.nan
    made = predictions_as_detections(found, likelihood, clicks(uv, 0), size=SIZE)
    assert not np.isin(made.row[made.point == 0], np.arange(10, 20)).any()
    assert not np.isin(made.row[made.point == 1], np.arange(30, 35)).any()
    assert len(made.row) == 4 * 50 - 10 - 5
    nothing = predictions_as_detections(
        np.full(uv.shape, np.nan), likelihood, clicks(uv, 0), size=SIZE
    )
    assert len(nothing.row) == 0


def test_one_point_clicked_once_will_do():
    """Without two points there is no extent; lengths then go by the picture."""
    uv = walk(50)[:, :1]
    made = predictions_as_detections(uv, np.ones((50, 1)), clicks(uv, 0), size=SIZE)
    assert len(made.row) == 50
    assert np.isfinite(made.log_odds).all()
