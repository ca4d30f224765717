"""The stride frequency from which cut-off and shortest times follow, in tracks that jitter."""

from __future__ import annotations

import re

import numpy as np
import pytest
from walking import Walk

from pawnb.gait import analyse


@pytest.mark.slow
@pytest.mark.parametrize(
    ("fps", "period", "share"),
    [(250.0, 0.25, 0.0), (250.0, 0.25, 0.08), (250.0, 0.25, 0.1), (500.0, 0.1, 0.08)],
)
@pytest.mark.parametrize("duty", [0.4, 0.6])
def test_jitter_of_a_tenth_of_a_stride_makes_no_strides(fps, period, share, duty):
    """Counted in unfiltered tracks, jitter set the cut-off so high that it made all the strides."""
    walk = Walk(period=period, duty=duty)
    noise = share * walk.speed * period
    tables = analyse(walk.tracks(fps=fps, duration=5.0, noise=noise, treadmill=False))
    median = tables.strides.groupby("leg")["period_s"].median()
    np.testing.assert_allclose(median, period, rtol=0.06)  # the walk's own period
    assert len(tables.strides) == pytest.approx(4 * (5.0 / period - 1.5), rel=0.1)
    (cutoff,) = re.findall("low-pass ([0-9.]+) Hz", "\n".join(tables.notes))
    assert float(cutoff) == pytest.approx(10.0 / period, rel=0.15)  # ten times the frequency
    # jitter goes with the picture, and was taken for a belt that carries the feet: no speed
    assert tables.strides["speed"].mean() == pytest.approx(walk.speed, rel=0.01)
