"""Where points usually are: the body that they are told from."""

import numpy as np

from pawnb.core.paws.offline.association.network_flow.priors.positional_prior import follow_body


def test_a_point_that_was_never_seen_tells_nothing_about_the_body():
    t = np.arange(60.0)
    x = np.full((60, 3, 2), np.nan)
    x[:, 0] = np.column_stack([100.0 + 2.0 * t, 0.0 * t])
    x[:, 1] = x[:, 0] - [40.0, 10.0]
    x[20:30, 1] = np.nan  # occluded for a while
    # half way between the two that were seen; an average over 11 frames of a straight
    # line is its middle, away from the ends
    body = follow_body(x, 11)
    middle = np.column_stack([80.0 + 2.0 * t, np.full(60, -5.0)])
    np.testing.assert_allclose(body[5:-5], middle[5:-5], atol=1e-9)
    assert np.isfinite(body).all()
