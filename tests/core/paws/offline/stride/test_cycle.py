"""The stride learnt from made-up motion: length, phase, curves and how sure they are."""

import numpy as np
import pytest

from pawnb.core.paws.offline.association.network_flow.priors.positional_prior import follow_body
from pawnb.core.paws.offline.stride.cycle import learn_cycle

STRIDE, NOISE, SPAN = 31.3, 0.5, 40.0
LAGS = np.array([0.0, 0.5, 0.45, 0.95])
N = 420


def curve(phase, point):
    """A saw-toothed closed curve, forward, across and up, of one point at some phases."""
    a = 2 * np.pi * (phase + LAGS[point])
    return np.stack(
        [
            (12.0 + point) * np.cos(a) + 3.0 * np.sin(2 * a),
            1.5 * np.sin(a + 0.4),
            3.0 * np.maximum(np.sin(a), 0.0) ** 2,
        ],
        axis=-1,
    )


def motion(*, seed=0, stride=STRIDE):
    """Tracks, truth, body, phase: the stride's length wanders and the body drifts."""
    rng = np.random.default_rng(seed)
    t = np.arange(N)
    phase = t / stride + 0.15 * np.sin(2 * np.pi * t / 170.0)
    body = np.column_stack([0.02 * t + 5 * np.sin(t / 90.0), 0.5 * np.cos(t / 120.0), 0 * t])
    home = np.array([[0, 8, 0], [SPAN, 8, 0], [0, -8, 0], [SPAN, -8, 0]]) - [SPAN / 2, 0, 0]
    truth = np.stack([curve(phase, p) for p in range(4)], axis=1) + home + body[:, None]
    x = truth + NOISE * rng.normal(size=truth.shape)
    x[rng.random((N, 4)) < 0.15] = np.nan
    return x, truth, body, phase


def learn(x, body, **options):
    return learn_cycle(
        x, body, **{"axes": np.eye(3), "frames": (15.0, 200.0), "noise": NOISE,
                    "trust": np.ones(x.shape[:2]), **options},
    )  # fmt: skip


def swap(x, first, stop):
    """Confuse the two front points, and the two hind points, for a while."""
    x[first:stop] = x[first:stop][:, [2, 3, 0, 1]]


@pytest.mark.parametrize("seed", [0, 1])
def test_stride_phase_and_curves_come_out_despite_swapped_pieces(seed):
    x, truth, body, phase = motion(seed=seed)
    swap(x, 100, 112)
    swap(x, 300, 309)
    cycle = learn(x, body)
    assert cycle.stride == pytest.approx(STRIDE, rel=0.03)
    # phases count from an origin of their own
    lag = np.abs(cycle.phase - phase - np.median(cycle.phase - phase))
    assert np.median(lag) < 0.01
    # more beside swapped tracklets, and at the ends, where half of every window is missing
    assert lag.max() < 0.08
    away = np.abs(cycle.mean - truth)
    assert np.median(away) < NOISE
    assert np.percentile(away, 98) < 2.5
    # the excursion is 25 to 30, so that is a small part of it
    assert np.ptp(truth[:, 0, 0] - body[:, 0]) > 23


def test_what_is_hidden_through_part_of_every_stride_is_expected_there():
    x, truth, body, phase = motion(seed=3)
    hidden = np.abs((phase + 0.3) % 1.0 - 0.5) < 0.1
    x[hidden, 1] = np.nan
    cycle = learn(x, body)
    away = np.linalg.norm(cycle.mean - truth, axis=-1)
    assert np.median(away[hidden, 1]) < 3.0
    # and the expectation is less sure there than where the point was seen
    assert np.median(cycle.sd[hidden, 1]) > 1.1 * np.median(cycle.sd[~hidden, 1])


def test_squares_are_calibrated():
    squares = []
    for seed in range(4):
        x, _, body, _ = motion(seed=10 + seed)
        cycle = learn(x, body)
        # what it was not learnt from: other noise on the same motion
        again, _, _, _ = motion(seed=50 + seed)
        squares += [cycle.square(np.arange(N), p, again[:, p]) / 3 for p in range(4)]
    mean = np.nanmean(squares)
    # no surer than it is; the noise counts twice (as the spread of what was seen and as the
    # least standard deviation), so about half is the least that is expected
    assert 0.4 < mean < 1.1
    assert np.nanpercentile(squares, 99) < 5.0


def test_the_square_is_that_of_the_distances_along_the_axes():
    x, _, body, _ = motion()
    turn = np.array([[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.0]])
    plain, turned = learn(x, body), learn(x @ turn, body @ turn, axes=turn)
    np.testing.assert_allclose(turned.mean @ turn.T, plain.mean, atol=1e-6)
    np.testing.assert_allclose(turned.sd, plain.sd, rtol=1e-6)
    at = plain.mean[7, 2] + plain.sd[7, 2] * [1.0, 2.0, -3.0]
    assert plain.square(7, 2, at) == pytest.approx(1 + 4 + 9)
    assert turned.square(7, 2, at @ turn) == pytest.approx(1 + 4 + 9)


def test_less_trusted_tracks_count_less():
    x, truth, body, _ = motion(seed=4)
    trust = np.ones(x.shape[:2])
    wrong = np.arange(N) % 100 < 40
    x[wrong, 0] += [0.0, 0.0, 6.0]
    trust[wrong, 0] = 0.0
    away = np.abs(learn(x, body, trust=trust).mean - truth)[:, 0, 2]
    assert np.median(away) < NOISE
    believed = np.abs(learn(x, body).mean - truth)[:, 0, 2]
    assert np.median(believed) > 2 * np.median(away)


def test_a_standing_animal_has_no_cycle():
    x, truth, body, _ = motion()
    standing = body[:, None] + truth[:1] + NOISE * np.random.default_rng(1).normal(size=x.shape)
    assert learn(standing, body) is None


def test_a_recording_too_short_has_no_cycle():
    x, _, body, _ = motion(stride=60.0)
    # the phase wanders by a third of a stride, so nominal lengths are not exact
    assert learn(x[:240], body[:240]) is not None
    assert learn(x[:150], body[:150]) is None
    assert learn(x[:40], body[:40]) is None


@pytest.mark.parametrize("end", [slice(0, 12), slice(N - 12, N)])
def test_where_points_are_expected_at_the_ends_does_not_hang_on_how_the_body_was_followed(end):
    """Half of the window over which the body is averaged is missing there, so it moves with the
    stride by about a third of a step."""
    away, off = [], []
    for seed in range(3):
        x, truth, body, _ = motion(seed=20 + seed)
        points = [0, 1, 3]
        followed = follow_body(x[:, points], round(2 * STRIDE))
        home = np.median(followed - body, axis=0)
        off.append(np.abs(followed - body - home)[end, 0])
        cycle = learn(x[:, points], followed)
        away.append(np.abs(cycle.mean - truth[:, points])[end, :, 0])
    assert np.mean(off) > 2.5 * NOISE
    assert np.mean(away) < 0.6 * np.mean(off)
