"""How legs move is learnt, and fills in what a frame does not show."""

import numpy as np

from pawnb.core.pose.fit.sequence.leg_motion import first_motion, learn_motion, motion_messages


def walk(rng, covariance, n):
    """Return numbers of a leg whose second differences have a covariance."""
    root = np.linalg.cholesky(covariance)
    return np.cumsum(np.cumsum(rng.normal(size=(n, len(root))) @ root.T, axis=0), axis=0)


def test_the_covariance_of_second_differences_is_found_also_among_leaps():
    rng = np.random.default_rng(0)
    true = np.array([[0.01, 0.008], [0.008, 0.01]])
    legs = [walk(rng, true, 800) for _ in range(2)]
    clean = learn_motion(legs, first_motion(1))
    legs[0][::40] += 3.0
    leaps = learn_motion(legs, first_motion(1))
    plain = np.cov(np.diff(legs[0], 2, axis=0).T)
    for found in (clean, leaps):
        # Student's t gives less weight to the tails of the normal distribution, too
        assert 0.6 < found[0, 0] / true[0, 0] < 1.6
        correlation = found[0, 1] / np.sqrt(found[0, 0] * found[1, 1])
        assert 0.7 < correlation < 0.9
    assert plain[0, 0] > 20 * true[0, 0]


def test_two_frames_teach_nothing():
    known = first_motion(2)
    np.testing.assert_array_equal(learn_motion([np.zeros((2, 4))], known), known)


def test_hidden_frames_are_filled_in_by_a_cubic():
    """The least second differences between fixed ends have no fourth: a cubic is kept as it is."""
    t = np.arange(20.0)
    leg = np.column_stack([1e-3 * (t - 9) ** 3, 0.02 * t**2])
    precision = np.tile(1e8 * np.eye(2), (20, 1, 1))
    precision[8:11] = 0.0
    around, pull = motion_messages(precision, (precision @ leg[..., None])[..., 0], first_motion(1))
    np.testing.assert_allclose(around[8:11], leg[8:11], atol=1e-3)
    # the middle of what is hidden is least sure
    assert pull[9, 0, 0] < pull[8, 0, 0] < pull[3, 0, 0]


def test_what_is_seen_of_a_leg_says_where_its_hidden_part_is():
    rng = np.random.default_rng(1)
    motion = np.array([[0.01, 0.0099], [0.0099, 0.01]])
    leg = walk(rng, motion, 40)
    precision = np.tile(1e8 * np.eye(2), (40, 1, 1))
    precision[18:23, 1, 1] = 0.0
    vector = (precision @ leg[..., None])[..., 0]
    together, pull = motion_messages(precision, vector, motion)
    own = precision + pull
    both = np.linalg.solve(own, (vector + (pull @ together[..., None])[..., 0])[..., None])
    alone, _ = motion_messages(precision, vector, np.diag(np.diag(motion)))
    wrong = np.abs(both[18:23, 1, 0] - leg[18:23, 1]).max()
    assert wrong < 0.5 * np.abs(alone[18:23, 1] - leg[18:23, 1]).max()
