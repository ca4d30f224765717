"""Bridging of gaps: a paw occluded among distractors, and one that stands or swings unseen."""

from dataclasses import replace

import numpy as np
import pytest
from pipeline_states import known_state

from pawnb.core.paws.offline.detection.colour.observations import Observations
from pawnb.core.paws.offline.gap_closing import gap_closing
from pawnb.core.paws.offline.gap_closing.gap_closing import close_gaps
from pawnb.core.paws.offline.projection import Projection
from pawnb.core.paws.offline.scene.motion_model import MotionModel
from pawnb.core.paws.offline.stride.cycle import Cycle
from pawnb.core.paws.offline.stride.duty_factor import DutyFactor
from pawnb.core.paws.offline.stride.swing import Swings

FLAT = Projection(None)
THICKNESS = np.array([8.0])
MANNER = MotionModel(
    acceleration=1.0, jerk=0.6, speed=12.0, substrate_velocity=np.zeros(2),
    axes=np.array([[1.0, 0.0], [0.0, -1.0]]), substrate=-1000.0, body_scale=150.0, paw_width=8.0,
)  # fmt: skip


def bridge(
    chosen,
    at,
    is_there,
    *,
    annotated=None,
    detection_probability=None,
    motion_model=MANNER,
    **state,
):
    """Bridge the gaps of points (n, P, 2) by detections (n, C, 2) of one view."""
    n, n_points = chosen.shape[:2]
    detection_probability = (
        np.ones(at.shape[:2]) if detection_probability is None else detection_probability
    )
    observations = Observations(
        at[:, None],
        np.repeat(at[:, None, None], n_points, axis=1),
        detection_probability[:, None],
        is_there[:, None],
    )
    annotated = np.zeros((n, n_points), bool) if annotated is None else annotated
    return close_gaps(
        known_state(chosen, annotated, **state),
        observations,
        geometry=FLAT,
        paw_width_px=THICKNESS,
        tracked_in_view=np.ones((n_points, 1), bool),
        motion_model=motion_model,
    )


def hidden_paw():
    """A paw in steady motion, occluded twice, while another path crosses its own."""
    rng = np.random.default_rng(8)
    t = np.arange(50.0)
    paw = np.column_stack([3.0 * t, 0.05 * (t - 25) ** 2])
    other = np.column_stack([80 - 0.5 * t, 40.0 - 1.2 * t])
    at = np.stack([other, paw + 0.3 * rng.normal(size=paw.shape)], axis=1)
    chosen = paw[:, None].copy()
    chosen[15:35] = np.nan
    is_there = np.ones((50, 2), bool)
    is_there[18:22, 1] = is_there[28:31, 1] = False
    # the detections that are there come first
    late = ~is_there[:, 1]
    assert is_there[late, 0].all()
    return chosen, at, is_there


def test_a_hidden_paw_is_found_again_beside_another_path():
    chosen, at, is_there = hidden_paw()
    bridged = bridge(chosen, at, is_there)
    np.testing.assert_array_equal(np.flatnonzero(bridged.is_open[:, 0]), np.arange(15, 35))
    expected = np.where(is_there[15:35, 1], 1, -1)
    np.testing.assert_array_equal(bridged.choice[15:35, 0, 0], expected)
    assert (bridged.choice[:15] == -1).all()


def test_the_certain_piece_that_follows_decides():
    t = np.arange(30.0)
    high = np.column_stack([2.0 * t, 0.06 * np.maximum(t - 10, 0) ** 2])
    low = high * [1.0, -1.0]
    at = np.stack([high, low], axis=1)
    for branch in (0, 1):
        chosen = at[:, branch : branch + 1].copy()
        chosen[8:22] = np.nan
        choice = bridge(chosen, at, np.ones((30, 2), bool)).choice[16:22, 0, 0]
        np.testing.assert_array_equal(choice, branch)


@pytest.mark.parametrize(("stop", "taken"), [(22, 1), (30, 0)])
def test_where_nothing_follows_the_cycle_decides_between_what_fits_nearly_alike(stop, taken):
    # the paw stands, and detections lie to either side of it, one of them a little nearer
    at = np.tile([[0.0, 0.65], [0.0, -0.6]], (30, 1, 1))
    chosen = np.zeros((30, 1, 2))
    chosen[8:stop] = np.nan
    cycle = Cycle(at[:, :1], np.full((30, 1, 2), 0.5), np.zeros(30), np.eye(2), 20.0)
    for observed, expected in ((None, 1), (cycle, taken)):
        choice = bridge(chosen, at, np.ones((30, 2), bool), cycle=observed).choice
        np.testing.assert_array_equal(choice[12:18, 0, 0], expected)


@pytest.mark.parametrize(("stop", "taken"), [(14, 0), (30, 1)])
def test_the_cycle_decides_alone_only_where_nothing_follows(stop, taken):
    # the paw stands, and the cycle expects it where there is another detection, on the same paw
    at = np.tile([[0.0, 0.0], [0.0, 6.0]], (30, 1, 1))
    chosen = at[:, :1].copy()
    chosen[8:stop] = np.nan
    cycle = Cycle(at[:, 1:], np.full((30, 1, 2), 0.5), np.zeros(30), np.eye(2), 20.0)
    choice = bridge(chosen, at, np.ones((30, 2), bool), cycle=cycle).choice
    np.testing.assert_array_equal(choice[11:13, 0, 0], taken)


def test_a_candidate_that_another_point_explains_is_left_to_it():
    # two standing points: the first is occluded, and the second's detection is within its reach
    chosen = np.zeros((24, 2, 2))
    chosen[:, 1, 0] = 4.0
    chosen[8:16, 0] = np.nan
    at = chosen[:, 1:].copy()
    there = np.ones((24, 1), bool)
    assert (bridge(chosen, at, there).choice[:, 0] == -1).all()
    # alone it would be taken for the first
    assert (bridge(chosen[:, :1], at, there).choice[9:15, 0] == 0).any()


def test_what_looks_poor_is_left_for_what_looks_good():
    chosen = np.zeros((20, 1, 2))
    chosen[6:14] = np.nan
    at = np.tile([[0.8, 0.0], [-0.8, 0.0]], (20, 1, 1))
    for good in (0, 1):
        detection_probability = np.full((20, 2), 0.1)
        detection_probability[:, good] = 0.9
        choice = bridge(
            chosen, at, np.ones((20, 2), bool), detection_probability=detection_probability
        ).choice[6:14, 0, 0]
        np.testing.assert_array_equal(choice, good)


def test_a_gap_at_the_start_is_told_as_its_mirror_image_in_time_at_the_end():
    """Reversed in time, an animal that walks the other way: its last frames become the first."""
    chosen, at, is_there = hidden_paw()
    chosen[20:] = np.nan
    is_there[:22] = True
    at[:, 0, 1] -= 40.0
    annotated = np.zeros((50, 1), bool)
    annotated[5] = True
    motion_model = replace(MANNER, substrate_velocity=np.array([-0.3, 0.0]))
    end = bridge(chosen, at, is_there, annotated=annotated, motion_model=motion_model)
    turned = replace(
        motion_model,
        substrate_velocity=-motion_model.substrate_velocity,
        axes=motion_model.axes * [[-1.0], [1.0]],
    )
    start = bridge(
        chosen[::-1], at[::-1], is_there[::-1], annotated=annotated[::-1], motion_model=turned
    )
    np.testing.assert_array_equal(start.choice, end.choice[::-1])
    np.testing.assert_array_equal(start.is_open, end.is_open[::-1])
    # the paw is followed there, not only left out alike
    assert (start.choice[:30, 0, 0] == np.where(is_there[:19:-1, 1], 1, -1)).mean() > 0.8


def test_a_stranger_is_not_told_before_it_was_first_seen():
    chosen, at, is_there = hidden_paw()
    chosen[:20] = np.nan
    assert (bridge(chosen, at, is_there).choice[:20] == -1).all()


def test_before_the_first_frame_no_paw_goes_back_faster_than_the_ground():
    """Told backwards, speeds are still those of the animal: what rushes backwards is no paw."""
    t = np.arange(30.0)
    substrate = np.column_stack([-2.0 * t, 0 * t])
    at = np.stack([substrate, substrate * [3.0, 1.0] + [40.0, 0.0]], axis=1)
    chosen = substrate[:, None].copy()
    chosen[:10] = np.nan
    annotated = np.zeros((30, 1), bool)
    annotated[20] = True
    motion_model = replace(MANNER, substrate_velocity=np.array([-2.0, 0.0]))
    choice = bridge(
        chosen, at, np.ones((30, 2), bool), annotated=annotated, motion_model=motion_model
    ).choice
    np.testing.assert_array_equal(choice[:10, 0, 0], 0)


def test_a_paw_that_was_clicked_once_has_come_with_the_ground():
    """One frame tells no speed: before it a paw was rather where the ground had it, ahead."""
    since = np.arange(12.0) - 8.0
    with_ground = np.column_stack([-2.0 * since, 0 * since])
    at = np.stack([-with_ground, with_ground], axis=1)
    chosen = np.full((12, 1, 2), np.nan)
    chosen[8, 0] = 0.0
    annotated = np.isfinite(chosen[..., 0])
    motion_model = replace(MANNER, substrate_velocity=np.array([-2.0, 0.0]))
    is_there = np.ones((12, 2), bool)
    choice = bridge(chosen, at, is_there, annotated=annotated, motion_model=motion_model).choice[
        :, 0, 0
    ]
    np.testing.assert_array_equal(choice[:6], 1)


def covered_paw():
    """A paw stands on moving ground, covered by one that lands beside it, and swings at frame 30.

    It is not seen from frame 22 to 38; a poor looking wrist rides above it until it swings.
    """
    t = np.arange(60.0)
    s = np.clip((t - 30.5) / 16.0, 0.0, 1.0)
    paw = np.column_stack([200.0 - 3.0 * t, 100.0 - 40.0 * np.sin(np.pi * s)])
    paw[:, 0] += 120.0 * (s - np.sin(2 * np.pi * s) / (2 * np.pi))
    other = np.column_stack([207.0 - 3.0 * t, np.full(60, 101.0)])
    other[:20] += np.column_stack([-12.0 * (20.0 - t[:20]), -3.0 * (20.0 - t[:20])])
    wrist = paw + np.array([1.0, -11.0])
    at = np.stack([other, paw, wrist], axis=1)
    is_there = np.ones((60, 3), bool)
    is_there[:20, 2] = is_there[31:, 2] = False
    hidden = (t >= 22) & (t < 39)
    # what is not there comes last
    at[hidden] = at[hidden][:, [0, 2, 1]]
    is_there[hidden] = np.column_stack([np.ones(17), t[hidden] <= 30, np.zeros(17)]).astype(bool)
    detection_probability = np.where(at == wrist[:, None], 0.1, 1.0).min(axis=-1)
    chosen = np.stack([paw, other], axis=1)
    chosen[hidden, 0] = np.nan
    return paw, chosen, at, is_there, detection_probability


def test_a_covered_paw_stands_until_it_lifts_off():
    paw, chosen, at, is_there, detection_probability = covered_paw()
    motion_model = replace(MANNER, substrate_velocity=np.array([-3.0, 0.0]))
    bridged = bridge(
        chosen, at, is_there, detection_probability=detection_probability, motion_model=motion_model
    )
    standing = np.flatnonzero(np.isfinite(bridged.held[:, 0, 0]))
    assert standing[0] == 22
    # nothing shows when it lifts off, but for the wrist that is gone then
    assert 29 <= standing[-1] <= 32
    first = standing[standing <= 30]
    np.testing.assert_allclose(bridged.held[first, 0], paw[first], atol=0.5)
    assert (bridged.choice[first, 0] < 0).all()
    assert (0, standing[-1]) in bridged.lift_offs
    assert np.isnan(bridged.held[:, 1]).all()


@pytest.mark.parametrize("share", [0.45, 0.7])
def test_where_nothing_tells_it_a_paw_lifts_off_in_its_rhythm(share):
    _, chosen, at, is_there, detection_probability = covered_paw()
    is_there[22:39, 1:] = False  # no wrist either
    # it stands from frame 8 on, and again from where the swing ends
    chosen[:8, 0] = np.nan
    chosen[48:, 0] = chosen[48, 0] + np.arange(12.0)[:, None] * [-3.0, 0.0]
    duty_factor = DutyFactor(np.full(2, share), np.full(2, 0.005), 40.0, 2.0)
    motion_model = replace(MANNER, substrate_velocity=np.array([-3.0, 0.0]))
    bridged = bridge(
        chosen,
        at,
        is_there,
        detection_probability=detection_probability,
        motion_model=motion_model,
        duty_factor=duty_factor,
    )
    now, following = bridged.stances[0]
    assert abs(now.stop - (8 + share * (following.first - 8))) <= 0.5
    without = bridge(
        chosen, at, is_there, detection_probability=detection_probability, motion_model=motion_model
    ).stances[0][0]
    assert abs(without.stop - now.stop) > 1


def test_a_path_that_is_lost_as_its_paw_seems_to_lift_off_is_told_anew():
    paw, chosen, at, is_there, detection_probability = covered_paw()
    # the paw that lands beside draws the last two certain places to itself
    chosen[20:22, 0] = chosen[20:22, 1]
    motion_model = replace(MANNER, substrate_velocity=np.array([-3.0, 0.0]))
    bridged = bridge(
        chosen, at, is_there, detection_probability=detection_probability, motion_model=motion_model
    )
    assert bridged.is_open[20:39, 0].all()
    assert not bridged.is_open[:20, 0].any()
    np.testing.assert_allclose(bridged.held[20:28, 0], paw[20:28], atol=0.5)


def arc(place, *, sd=0.5, lift_offs=()):
    """Return swings on which the first point is at ``place`` (n, 2), the others nowhere."""
    observed = np.full((len(place), 2, 2), np.nan)
    observed[:, 0] = place
    return Swings(observed, np.where(np.isnan(observed), np.nan, sd), observed + np.nan, lift_offs)


@pytest.mark.parametrize("stop", [22, 30])
@pytest.mark.parametrize("expected", [0, 1])
def test_the_arc_decides_between_what_fits_nearly_alike(stop, expected):
    # the paw stands, and detections lie to either side of it, one of them a little nearer
    at = np.tile([[0.0, 1.15], [0.0, -1.1]], (30, 1, 1))
    chosen = np.zeros((30, 1, 2))
    chosen[8:stop] = np.nan
    is_there = np.ones((30, 2), bool)
    plain = bridge(chosen, at, is_there).choice
    np.testing.assert_array_equal(plain[12:18, 0, 0], 1)
    place = np.full((30, 2), np.nan)
    place[8:22] = at[8:22, expected]
    choice = bridge(chosen, at, is_there, swings=arc(place)).choice
    np.testing.assert_array_equal(choice[12:18, 0, 0], expected)


def test_each_point_is_expected_on_its_own_arc():
    at = np.tile([[0.0, 1.15], [0.0, -1.1], [40.0, 0.0]], (30, 1, 1))
    chosen = np.zeros((30, 2, 2))
    chosen[:, 0] = at[:, 2]
    chosen[8:22, 1] = np.nan
    for expected in (0, 1):
        swings = arc(at[:, 2])
        swings.place[8:22, 1], swings.sd[8:22, 1] = at[8:22, expected], 0.5
        choice = bridge(chosen, at, np.ones((30, 3), bool), swings=swings).choice
        np.testing.assert_array_equal(choice[12:18, 1, 0], expected)


def watched(monkeypatch):
    """Return a list that will hold what is expected in each stretch that is told."""
    expected, close = [], gap_closing.run_mht

    def tell_and_note(*args):
        expected.extend(one for one in args if isinstance(one, gap_closing.ExpectedPositions))
        return close(*args)

    monkeypatch.setattr(gap_closing, "run_mht", tell_and_note)
    return expected


def expectations(monkeypatch, stop, *, first=8):
    """Return places and variances that are expected of a paw that is occluded from a frame on."""
    expected = watched(monkeypatch)
    chosen = np.zeros((30, 1, 2))
    chosen[first:stop] = np.nan
    annotated = np.zeros((30, 1), bool)
    annotated[25] = True
    place = np.column_stack([np.arange(30.0), np.zeros(30)])
    place[12:15] = np.nan
    nothing = np.zeros((30, 1, 2)), np.zeros((30, 1), bool)
    # certain places lie off this arc by far: they are placed by hand
    bridge(
        chosen,
        *nothing,
        annotated=annotated | np.isfinite(chosen[..., 0]),
        swings=arc(place, sd=0.4),
    )
    (one,) = expected
    assert np.isnan(one.at[0]).all()  # there is no cycle
    observed = np.isfinite(one.at[1]).all(axis=-1)
    return list(zip(one.at[1, observed], one.variance[1, observed], strict=True))


def test_a_paw_is_expected_on_its_arc_in_hidden_frames(monkeypatch):
    between, last = (expectations(monkeypatch, stop) for stop in (20, 30))
    # in frames that are occluded, and of which the arc tells
    np.testing.assert_array_equal([at[0] for at, _ in between], [8, 9, 10, 11, *range(15, 20)])
    np.testing.assert_array_equal([at[0] for at, _ in last], [8, 9, 10, 11, *range(15, 30)])
    # frames err alike, so each says less than its standard deviation would
    (first, second), (third, _) = between[0][1], last[0][1]
    assert first == second == third > 0.4**2
    # told backwards in time, no paw is on the way to where its swing leads
    assert expectations(monkeypatch, 8, first=0) == []


def test_aside_of_its_arc_a_paw_is_expected_less_surely(monkeypatch):
    """In space, where all directions are told alike by the arc, and axes are turned."""
    turn = np.array([[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.0]])
    seen = watched(monkeypatch)
    lines = np.zeros((11, 2))
    lines[[0, 6], 0] = lines[[1, 6], 1] = 1.0
    chosen = np.zeros((30, 1, 3))
    place = chosen.copy()
    chosen[8:20] = np.nan
    nothing = np.zeros((30, 2, 1, 2))
    observations = Observations(
        nothing, nothing[:, None], np.ones((30, 2, 1)), np.zeros((30, 2, 1), bool)
    )
    motion_model = replace(MANNER, substrate_velocity=np.zeros(3), axes=turn)
    close_gaps(
        known_state(chosen, np.zeros((30, 1), bool), swings=Swings(place, place + 0.4, place, ())),
        observations,
        geometry=Projection(lines),
        paw_width_px=np.array([8.0, 8.0]),
        tracked_in_view=np.ones((1, 2), bool),
        motion_model=motion_model,
    )
    (expected,) = seen
    np.testing.assert_array_equal(expected.axes[1], turn)
    assert np.isfinite(expected.at[1]).all(axis=-1).sum() == 12
    for forward, aside, up in expected.variance[1, :12]:
        assert forward == up
        # by more than half a paw width, which is 8
        assert aside - up > 4.0**2


def test_an_arc_far_from_all_that_is_seen_does_not_decide():
    """It may be of a stance that was wrong: the path goes on to where it is seen again."""
    chosen, at, is_there = hidden_paw()
    observed = bridge(chosen, at, is_there).choice
    far = np.full((50, 2), np.nan)
    far[15:35] = at[15:35, 1] + [0.0, 60.0]
    found = bridge(chosen, at, is_there, swings=arc(far)).choice
    np.testing.assert_array_equal(found, observed)
    # nor does an arc that says nothing of these frames
    nothing = np.full((50, 2), np.nan)
    np.testing.assert_array_equal(
        bridge(chosen, at, is_there, swings=arc(nothing)).choice, observed
    )


def test_a_certain_place_off_the_arc_is_chosen_again():
    chosen, at, is_there = hidden_paw()
    chosen = at[:, 1:].copy()
    # the path was drawn to another place for a while
    at[38:44, 0] = chosen[38:44, 0] + [0.0, 20.0]
    chosen[38:44, 0] = at[38:44, 0]
    is_there = np.ones((50, 2), bool)
    assert not bridge(chosen, at, is_there).is_open.any()
    bridged = bridge(chosen, at, is_there, swings=arc(at[:, 1]))
    np.testing.assert_array_equal(np.flatnonzero(bridged.is_open[:, 0]), np.arange(38, 44))
    np.testing.assert_array_equal(bridged.choice[38:44, 0, 0], 1)


@pytest.mark.parametrize("liftoff_velocity", [24.6, 27.4, 34.0])
def test_a_hidden_paw_lifts_off_when_its_swing_begins(liftoff_velocity):
    _, chosen, at, is_there, detection_probability = covered_paw()
    is_there[22:39, 1:] = False  # no wrist either
    # by its rhythm it were due at another time
    duty_factor = DutyFactor(np.full(2, 0.6), np.full(2, 0.005), 40.0, 2.0)
    motion_model = replace(MANNER, substrate_velocity=np.array([-3.0, 0.0]))
    swings = arc(np.full((60, 2), np.nan), lift_offs=((0, liftoff_velocity, 0.3),))
    bridged = bridge(
        chosen,
        at,
        is_there,
        detection_probability=detection_probability,
        motion_model=motion_model,
        duty_factor=duty_factor,
        swings=swings,
    )
    now = bridged.stances[0][0]
    assert abs(now.stop - 0.5 - liftoff_velocity) <= 0.6
    assert (0, now.stop - 1) in bridged.lift_offs
    # of another point it says nothing
    swings = replace(swings, lift_offs=((1, liftoff_velocity, 0.3),))
    observed = bridge(
        chosen,
        at,
        is_there,
        detection_probability=detection_probability,
        motion_model=motion_model,
        swings=swings,
    )
    plain = bridge(
        chosen, at, is_there, detection_probability=detection_probability, motion_model=motion_model
    )
    assert observed.lift_offs == plain.lift_offs


def test_where_nothing_follows_a_paw_stands_until_its_swing_begins():
    paw, chosen, at, is_there, detection_probability = covered_paw()
    is_there[22:39, 1:] = False
    chosen[22:, 0] = np.nan
    motion_model = replace(MANNER, substrate_velocity=np.array([-3.0, 0.0]))
    state = {"detection_probability": detection_probability, "motion_model": motion_model}
    # when it lifts off is left open if nothing tells
    assert np.isnan(bridge(chosen, at, is_there, **state).held[:, 0]).all()
    place = np.full((60, 2), np.nan)
    place[31:46] = paw[31:46]
    bridged = bridge(chosen, at, is_there, swings=arc(place, lift_offs=((0, 30.5, 0.5),)), **state)
    standing = np.flatnonzero(np.isfinite(bridged.held[:, 0, 0]))
    np.testing.assert_array_equal(standing, np.arange(22, standing[-1] + 1))
    assert abs(standing[-1] - 30) <= 1
    np.testing.assert_allclose(bridged.held[22:30, 0], paw[22:30], atol=0.5)
    # and it is taken up where it comes out, not the one that it was occluded by
    np.testing.assert_array_equal(bridged.choice[40:46, 0, 0], 1)
