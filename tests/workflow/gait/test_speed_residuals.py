"""Residuals against speed: what was added to a line comes out again."""

from __future__ import annotations

import numpy as np
import pandas as pd

from pawnb.workflow.gait.speed_residuals import RESIDUAL_COLUMNS, speed_residuals


def strides(speeds, offsets):
    """Two strides a trial; frequency is 2 + 0.01 speed and what was added to it."""
    rows = [
        {"animal": f"m{k}", "trial": "t", "speed": speed, "duty_factor": 0.5,
         "frequency_hz": 2 + 0.01 * speed + offset + wobble}
        for k, (speed, offset) in enumerate(zip(speeds, offsets, strict=True))
        for wobble in (-0.1, 0.1)
    ]  # fmt: skip
    return pd.DataFrame(rows)


def test_what_was_added_is_left_over():
    # offsets with mean 0 and no correlation with speed: least squares leaves them whole
    speeds, offsets = np.array([100.0, 200.0, 300.0, 400.0]), np.array([0.3, -0.3, -0.3, 0.3])
    found = speed_residuals(strides(speeds, offsets))
    assert tuple(found) == RESIDUAL_COLUMNS
    assert set(found["measure"]) == {"frequency_hz"}  # a duty factor that never varies has none
    np.testing.assert_allclose(found["residual"], offsets, atol=1e-12)
    np.testing.assert_allclose(found["expected"], 2 + 0.01 * speeds, atol=1e-12)
    np.testing.assert_allclose(found["value"], found["expected"] + found["residual"])
    assert (found["n_trials"] == 4).all()


def test_too_few_speeds_give_none():
    assert speed_residuals(strides([100.0, 200.0, 300.0, 300.0], np.zeros(4))).empty
    assert speed_residuals(strides([100.0] * 5, np.arange(5.0))).empty
    assert speed_residuals(strides([np.nan] * 5, np.arange(5.0))).empty
    rounded = np.nextafter(300.0, 301.0) + np.arange(5) * 1e-13
    assert len(set(rounded)) > 3  # a belt of one speed, but for rounding
    assert speed_residuals(strides(rounded, np.arange(5.0))).empty
