"""Refining of tracks: a made-up swing of least jerk, seen by three cameras, and its gap."""

from dataclasses import replace

import numpy as np
import pytest

from pawnb.core.paws.offline.detection.colour.observations import Observations
from pawnb.core.paws.offline.gap_closing.state import GapClosing
from pawnb.core.paws.offline.projection import Projection
from pawnb.core.paws.offline.scene.motion_model import MotionModel
from pawnb.core.paws.offline.smoothing.forward_backward_distance import (
    forward_backward_distance,
    leave_one_out,
)
from pawnb.core.paws.offline.smoothing.refinement import MeasurementModel, deviations, refine
from pawnb.core.paws.offline.stride.cycle import Cycle
from pawnb.core.paws.offline.stride.stance import Substrate
from pawnb.core.paws.offline.stride.swing import Swings

THICKNESS_PX = np.array([8.0, 8.0, 8.0])
THICKNESS = 2.0
LINEAR = np.zeros((11, 3))
LINEAR[:8] = np.array(
    [[4, 0, 0, 9, 0, 0, -4, 7], [0, 4, 0, -5, 0, 0, -4, 2], [2.8, -2.8, 0, 0, 0, 0, -4, 1]]
).T
RIG = Projection(LINEAR)
N = 60
SIGMA_PX = 0.12 * 8.0


def swing(seed=0):
    """Two paws: one swings from 20 to 40 (Flash & Hogan 1985, equation 2), the other stands."""
    rng = np.random.default_rng(seed)
    s = np.clip((np.arange(N) - 20) / 20.0, 0.0, 1.0)
    ahead = 10 * s**3 - 15 * s**4 + 6 * s**5
    one = np.column_stack([30.0 * ahead, np.full(N, 4.0), 2.0 * s * (1 - s)])
    two = np.column_stack([np.full(N, 60.0), np.full(N, -4.0), np.zeros(N)])
    return np.stack([one, two], axis=1), rng


def measurement(**options):
    return MeasurementModel(
        **{"geometry": RIG, "paw_width_px": THICKNESS_PX, "paw_width": THICKNESS,
           "jerk": 0.2, "unsure": np.zeros(2), **options},
    )  # fmt: skip


def see(truth, rng, *, hidden=(), detection_probability=1.0, noise=SIGMA_PX):
    """Detections of both paws in every view, with noise, none of the first where it is occluded."""
    uv = RIG.project(truth).transpose(0, 2, 1, 3) + noise * rng.normal(size=(N, 3, 2, 2))
    for t in hidden:
        uv[t, :, 0] = uv[t, :, 1]
    is_there = np.ones((N, 3, 2), bool)
    is_there[list(hidden), :, 1] = False
    at = np.repeat(uv[:, None], 2, axis=1)
    return Observations(uv, at, np.full((N, 3, 2), detection_probability), is_there)


def solve(
    truth, observations, *, hidden=(), certain=None, negative_log_odds=0.0, cycle=None, **options
):
    start = truth.copy()
    start[list(hidden), 0] = np.nan
    is_open = np.zeros((N, 2), bool)
    is_open[list(hidden), 0] = True
    certain = np.full((N, 2, 3, 2), np.nan) if certain is None else certain
    gap_closing = GapClosing(
        is_open, np.full((N, 2, 3), -1), np.full((N, 2, 3, 2), negative_log_odds)
    )
    return refine(
        start,
        observations,
        gap_closing,
        certain=certain,
        measurement=measurement(**options),
        cycle=cycle,
    )


def test_a_gap_in_a_swing_of_least_jerk_is_bridged():
    truth, rng = swing()
    gap = range(26, 35)
    smoothed = solve(truth, see(truth, rng, hidden=gap), hidden=gap)
    away = np.linalg.norm(smoothed.x - truth, axis=-1)
    # the swing covers 30, of which 19 lie in the gap
    assert np.ptp(truth[gap, 0, 0]) > 15
    assert away[gap, 0].max() < 1.5
    assert np.delete(away[:, 0], gap).max() < 0.6
    assert away[:, 1].max() < 0.5
    assert np.isnan(smoothed.measured[gap, 0]).all()
    assert np.isfinite(smoothed.measured[:, 1]).all()
    # where nothing was seen it says so
    assert smoothed.sd[30, 0, 0] > 2 * smoothed.sd[10, 0, 0]


@pytest.mark.parametrize("forward", [[1.0, 0.0, 0.0], [0.6, 0.8, 0.0]])
def test_a_hidden_paw_that_lifts_off_goes_up_at_once_and_forward_little_by_little(forward):
    """It stands to frame 20, then goes up by 1.2 a frame, and forward as in a swing of least jerk.

    It is occluded from frame 16 to 28.
    """
    axes = np.array([forward, [-forward[1], forward[0], 0.0], [0.0, 0.0, 1.0]])
    off = np.clip(np.arange(N) - 20.5, 0.0, 19.5)
    s = off / 19.5
    truth, rng = swing(3)
    ahead = 30.0 * (10 * s**3 - 15 * s**4 + 6 * s**5)
    up = 1.2 * off * (1.0 - s)
    truth[:, 0] = ahead[:, None] * axes[0] + up[:, None] * axes[2]
    hidden = range(16, 29)
    observations = see(truth, rng, hidden=hidden)
    held = np.full(truth.shape, np.nan)
    held[16:21, 0] = truth[16:21, 0]
    motion_model = MotionModel(
        acceleration=0.3,
        jerk=0.2,
        speed=2.0,
        substrate_velocity=np.zeros(3),
        axes=axes,
        substrate=0.0,
        body_scale=40.0,
        paw_width=THICKNESS,
    )
    substrate = Substrate(np.zeros(2), np.zeros(3), np.tile(1.2 * axes[2], (2, 1)), motion_model)
    start, is_open = truth.copy(), np.zeros((N, 2), bool)
    start[list(hidden), 0], is_open[list(hidden), 0] = np.nan, True
    choice, negative_log_odds = np.full((N, 2, 3), -1), np.full((N, 2, 3, 2), 30.0)
    certain = np.full((N, 2, 3, 2), np.nan)
    told, untold = (
        refine(
            start,
            observations,
            GapClosing(is_open, choice, negative_log_odds, held, lift_offs, substrate),
            certain=certain,
            measurement=measurement(),
        )
        for lift_offs in ([(0, 20)], [])
    )
    away = [found.x[hidden, 0] - truth[hidden, 0] for found in (told, untold)]
    np.testing.assert_allclose(away[0], 0.0, atol=0.5 * THICKNESS)
    assert np.abs(away[1]).max() > 0.5 * THICKNESS
    # how fast it goes up is not known before; to the front and to the side it does not jump
    np.testing.assert_allclose(told.sd[..., :2], untold.sd[..., :2], rtol=0.02)
    assert told.sd[22, 0, 2] > 1.2 * untold.sd[22, 0, 2]


def arched(*, hidden, swings=None, lift_offs=()):
    """Solve a swing that also goes up as a half wave of the sine, seen without noise.

    ``swings`` makes those that are known, of the truth and its third differences.
    """
    truth, rng = swing(4)
    s = np.clip((np.arange(N) - 20) / 20.0, 0.0, 1.0)
    truth[:, 0, 2] = 6.0 * np.sin(np.pi * s)
    jerk_mean = np.full(truth.shape, np.nan)
    jerk_mean[1:-2] = np.diff(truth, 3, axis=0)
    motion_model = MotionModel(
        acceleration=0.3,
        jerk=0.2,
        speed=2.0,
        substrate_velocity=np.zeros(3),
        axes=np.eye(3),
        substrate=0.0,
        body_scale=40.0,
        paw_width=THICKNESS,
    )
    substrate = Substrate(np.zeros(2), np.zeros(3), np.zeros((2, 3)), motion_model)
    start, is_open = truth.copy(), np.zeros((N, 2), bool)
    start[list(hidden), 0], is_open[list(hidden), 0] = np.nan, True
    gap_closing = GapClosing(
        is_open,
        np.full((N, 2, 3), -1),
        np.full((N, 2, 3, 2), 30.0),
        None,
        list(lift_offs),
        substrate,
    )
    known = None if swings is None else swings(truth, jerk_mean)
    observations, certain = see(truth, rng, hidden=hidden, noise=0.0), np.full((N, 2, 3, 2), np.nan)
    smoothed = refine(
        start, observations, gap_closing, certain=certain, measurement=measurement(), swings=known
    )
    return smoothed, truth


def of_first(truth, jerk_mean, *, first=20, stop=40):
    """Return swings that tell where the first paw is in some frames, and how it bends there.

    That is told a little before it lifts off, and not where it lands.
    """
    place, third = np.full(truth.shape, np.nan), np.full(truth.shape, np.nan)
    place[first:stop, 0] = truth[first:stop, 0]
    third[first - 3 : stop - 2, 0] = jerk_mean[first - 3 : stop - 2, 0]
    return Swings(place, np.where(np.isnan(place), np.nan, 0.3), third, ())


def test_the_track_of_a_hidden_stretch_bends_as_the_arc_does():
    hidden = range(16, 31)
    plain, truth = arched(hidden=hidden)
    told, _ = arched(hidden=hidden, swings=of_first)
    # of least jerk it goes up too early
    off, untold = (np.abs(of.x - truth)[hidden, 0].max() for of in (told, plain))
    assert off < 0.1 * THICKNESS < 0.3 * THICKNESS < untold
    # where nothing is seen it bends as the arc does, as it lifts off as well, but for what its
    # ends ask
    inside = slice(hidden[0], hidden[-2])
    jerk_mean, third, smoothed = (
        np.diff(x[:, 0], 3, axis=0)[inside] for x in (truth, told.x, plain.x)
    )
    assert jerk_mean.max() > 0.9
    np.testing.assert_allclose(third, jerk_mean, atol=0.05)
    assert np.abs(smoothed - jerk_mean).max() > 0.5
    # it is surer then, and where it is seen hardly anything changes
    assert (told.sd[22:28, 0] < 0.8 * plain.sd[22:28, 0]).all()
    np.testing.assert_allclose(told.x[:10, 0], plain.x[:10, 0], atol=0.1)
    np.testing.assert_allclose(told.x[40:, 0], plain.x[40:, 0], atol=0.2)
    np.testing.assert_array_equal(told.x[:, 1], plain.x[:, 1])


def test_a_swing_that_is_seen_no_more_ends_near_its_arc():
    """Nothing follows frame 30, so that bends alone leave the end to how it was begun."""
    hidden = range(30, N)

    def ahead(truth, jerk_mean):
        return of_first(truth + np.array([8.0, 0.0, 0.0]), jerk_mean, first=20, stop=N)

    def bends(truth, jerk_mean):
        return replace(of_first(truth, jerk_mean, stop=N), place=np.full(truth.shape, np.nan))

    (told, truth), (plain, _), (off, _) = (
        arched(hidden=hidden, swings=swings)
        for swings in (lambda *of: of_first(*of, stop=N), bends, ahead)
    )
    away, untold = (np.abs(of.x - truth)[hidden, 0].max() for of in (told, plain))
    assert away < 0.5 * untold
    # it goes to where the arc is, but little where the paw is still seen
    assert (off.x - told.x)[-1, 0, 0] == pytest.approx(8.0, abs=0.5)
    np.testing.assert_allclose(off.x[:28, 0], told.x[:28, 0], atol=0.1 * THICKNESS)
    np.testing.assert_array_equal(told.x[:, 1], plain.x[:, 1])


def test_an_arc_that_is_late_does_not_bend_what_is_seen():
    def late(truth, jerk_mean):
        return of_first(np.roll(truth, 2, axis=0), np.roll(jerk_mean, 2, axis=0), first=22, stop=42)

    plain, truth = arched(hidden=())
    told, _ = arched(hidden=(), swings=late)
    assert np.abs(np.roll(truth, 2, axis=0) - truth)[10:50].max() > THICKNESS
    assert np.abs(told.x - truth).max() < 0.3 * THICKNESS
    # and it is not said to be surer
    np.testing.assert_allclose(told.sd, plain.sd, rtol=0.05)


def test_it_is_surer_on_its_arc_but_not_before_it_lifts_off_nor_how_it_does():
    def bends(truth, jerk_mean):
        return replace(of_first(truth, jerk_mean), place=np.full(truth.shape, np.nan))

    hidden = range(12, 31)
    plain, told, only_bent, lifted = (
        arched(hidden=hidden, swings=swings, lift_offs=lift_offs)[0].sd[hidden, 0]
        for swings, lift_offs in (
            (None, ()), (of_first, ()), (bends, ()), (of_first, [(0, 22)]),
        )
    )  # fmt: skip
    np.testing.assert_allclose(only_bent, plain, rtol=0.01)
    assert (told[8:-4] < 0.9 * plain[8:-4]).all()
    # what is told of the lift-off itself stays as unsure as it was
    assert (lifted[8:14] > 1.05 * told[8:14]).all()


def test_frames_that_no_arc_tells_are_smoothed_as_before():
    hidden = range(20, 31)
    plain, _ = arched(hidden=hidden)
    # it is known how it stands, long before it is occluded
    told, _ = arched(hidden=hidden, swings=lambda *of: of_first(*of, first=10, stop=12))
    np.testing.assert_allclose(told.x, plain.x, atol=1e-9)
    np.testing.assert_allclose(told.sd, plain.sd, rtol=1e-9)


def test_the_stated_sd_is_honest():
    inside = []
    gap = range(27, 33)
    for seed in range(12):
        truth, rng = swing(seed)
        smoothed = solve(truth, see(truth, rng, hidden=gap), hidden=gap)
        inside.append(np.abs(smoothed.x - truth) < 1.96 * smoothed.sd)
    inside = np.array(inside)
    # it allows for errors that are alike from frame to frame, of which there are none here
    assert inside.mean() > 0.94
    assert inside[:, gap, 0].mean() > 0.85
    # but it is not just wide: a paw width is 2
    assert np.median(smoothed.sd) < 0.3


def test_wrong_candidates_beside_the_track_are_left_out():
    truth, rng = swing()
    observations = see(truth, rng)
    observations.at[5:9, :, 1, 0] += [0.0, 12.0]
    smoothed = solve(truth, observations)
    assert np.isnan(smoothed.measured[5:9, 0, 1]).all()
    assert np.isfinite(smoothed.measured[5:9, 0, [0, 2]]).all()
    assert np.linalg.norm(smoothed.x - truth, axis=-1)[5:9, 0].max() < 0.5


@pytest.mark.parametrize(("negative_log_odds", "is_taken"), [(0.0, True), (4.0, False)])
def test_in_a_gap_a_candidate_farther_off_is_taken_unless_much_speaks_against_it(
    negative_log_odds, is_taken
):
    truth, rng = swing()
    # a manoeuvre, which is not of least jerk: the bridge leads past it
    gap = range(24, 36)
    truth[gap, 0, 2] += 3.0 * np.sin(np.linspace(0.0, np.pi, len(gap) + 2))[1:-1]
    observations = see(truth, rng, hidden=[t for t in gap if t != 29])
    smoothed = solve(truth, observations, hidden=gap, negative_log_odds=negative_log_odds)
    assert np.isfinite(smoothed.measured[29, 0, :, 0]).all() == is_taken
    away = np.linalg.norm(smoothed.x - truth, axis=-1)[29, 0]
    assert away < 0.8 if is_taken else away > 2.0


def test_where_a_point_is_seen_again_its_cycle_says_little():
    truth, rng = swing()
    gap = range(26, 35)
    lies = Cycle(truth + 5.0, np.full_like(truth, 1.0), np.zeros(N), np.eye(3), 40.0)
    observations = see(truth, rng, hidden=gap)
    gap_closing, told = (solve(truth, observations, hidden=gap, cycle=one) for one in (None, lies))
    moved = np.linalg.norm(told.x - gap_closing.x, axis=-1)[:, 0]
    assert moved[list(gap)].max() > 0.1
    assert moved.max() < 0.1 * np.linalg.norm(lies.mean - truth, axis=-1)[0, 0]
    # nothing follows the last frames but what the cycle says
    end = range(50, N)
    observations = see(truth, rng, hidden=end)
    told = solve(truth, observations, hidden=end, cycle=lies)
    assert np.linalg.norm(told.x[-1, 0] - lies.mean[-1, 0]) < 2.5


def test_what_is_placed_by_hand_stays():
    truth, rng = swing()
    certain = np.full((N, 2, 3, 2), np.nan)
    placed = truth[12, 1] + [0.3, 0.0, 0.0]
    certain[12, 1] = RIG.project(placed)
    smoothed = solve(truth, see(truth, rng), certain=certain)
    np.testing.assert_array_equal(smoothed.measured[12, 1], certain[12, 1])
    np.testing.assert_allclose(smoothed.detection_probability[12, 1], 1.0)
    # a click is surer than a detection, so the track leans towards it
    assert smoothed.x[12, 1, 0] - truth[12, 1, 0] > 0.06


def test_every_candidate_is_given_to_one_point_only():
    truth, rng = swing()
    truth[:, 1] = truth[:, 0] + [0.0, 0.4, 0.0]
    observations = see(truth, rng)
    observations.is_there[:, :, 1] = False
    smoothed = solve(truth, observations)
    both = np.isfinite(smoothed.measured[..., 0]).all(axis=1)
    assert not both.any()
    assert np.isfinite(smoothed.measured[..., 0]).any(axis=1).mean() > 0.9


@pytest.mark.parametrize("unsure", [0.0, 0.3])
def test_unsure_offsets_widen_every_sd_alike(unsure):
    truth, rng = swing()
    observations = see(truth, rng)
    plain = solve(truth, observations)
    wide = solve(truth, observations, unsure=np.full(2, unsure))
    more = wide.sd**2 - plain.sd**2
    np.testing.assert_allclose(more, (unsure * THICKNESS) ** 2, atol=1e-9)


def test_it_says_what_it_was_smoothed_from():
    """Where a track goes over to another place, passes from both sides are apart."""
    truth, rng = swing(4)
    truth[30:, 1, 0] += 4.0 * THICKNESS
    smoothed = solve(truth, see(truth, rng))
    apart = forward_backward_distance(smoothed.equations)
    assert abs(int(np.nanargmax(apart[:, 1])) - 29.5) < 2
    assert np.nanmax(apart[:, 1]) > 2 * np.nanmax(apart[:, 0])
    # what all other frames say of a frame is about where it is, and less sure
    x, spread = leave_one_out(smoothed.x, smoothed.equations)
    assert np.linalg.norm(x - truth, axis=-1)[:, 0].max() < 0.5 * THICKNESS
    assert np.linalg.norm(x - smoothed.x, axis=-1)[3:-3].max() > 0
    diagonal = [np.einsum("npii->npi", part) for part in (spread, smoothed.equations.covariance)]
    assert (diagonal[0] > diagonal[1]).all()


def test_deviations_of_candidates():
    found = deviations(np.array([[[1.0, 0.5], [1.0, 0.1], [0.3, 0.6]]]), measurement())
    # 0.12 of 8 px, over how good it is, 0.3 at least
    expected = 0.96 * np.array([[1.0, 2.0], [1.0, 1 / 0.3], [1 / 0.3, 1 / 0.6]])
    np.testing.assert_allclose(found[0], expected)
