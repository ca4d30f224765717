"""Where paws swing: a made walk whose truth is known, its swings occluded as they begin.

Forward a swing is the polynomial of least jerk from rest to rest (Flash and Hogan 1985), upwards
a half wave of the sine: of another family than what is fitted.
"""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as rules
from hypothesis import strategies as st

from pawnb.core.paws.offline.scene.motion_model import MotionModel
from pawnb.core.paws.offline.smoothing.smoother import smooth
from pawnb.core.paws.offline.stride.duty_factor import DutyFactor
from pawnb.core.paws.offline.stride.stance import Stance, Substrate
from pawnb.core.paws.offline.stride.swing import Swings, learn_swings

FPS, STRIDE, SHARE = 250.0, 50.0, 0.6
THICKNESS, HEIGHT = 3.0, 5.0
DRIFT = np.array([-1.2, 0.1, 0.05])
KINDS = ["front", "front"]
HIDDEN = 0.45
RHYTHM = DutyFactor(share=np.full(2, SHARE), sd=np.full(2, 0.02), stride=STRIDE, spread=2.0)


def motion_model(axes=None):
    axes = np.eye(3) if axes is None else axes
    return MotionModel(
        acceleration=0.3,
        jerk=0.2,
        speed=12.0 * 40.0 / FPS,
        substrate_velocity=DRIFT[: len(axes)],
        axes=axes,
        substrate=0.0,
        body_scale=40.0,
        paw_width=THICKNESS,
    )


@dataclass(frozen=True)
class Walk:
    """Two paws side by side, half a stride apart.

    Parameters
    ----------
    truth : ndarray, shape (n, 2, 3)
        Where they are.
    x, weight : ndarray
        Smoothed tracks, and what is seen of them.
    stances : list
        When they stand.
    times : list
        Lift-off and landing of every swing of each paw, also of those seen in part.
    """

    truth: np.ndarray
    x: np.ndarray
    weight: np.ndarray
    stances: list
    times: list

    @property
    def hidden(self):
        return self.weight == 0.0


def walk(*, strides=4, seed=0, hidden=HIDDEN, noise=0.1, lifted=HEIGHT):
    """Return a walk, which begins and ends with a swing of the first paw."""
    rng = np.random.default_rng(seed)
    n = round(strides * STRIDE) + 10
    t = np.arange(n, dtype=float)
    truth, x, weight = np.zeros((n, 2, 3)), np.zeros((n, 2, 3)), np.ones((n, 2))
    stances, times = [], []
    for p, late in enumerate((15.0, 15.0 - 0.5 * STRIDE)):
        land = late + STRIDE * np.arange(-1, strides + 2) + rng.normal(size=strides + 3)
        lift = land + SHARE * STRIDE + 0.5 * rng.normal(size=len(land))
        # on the ground of frame 0 each stands where it is when it lands
        at = -DRIFT[0] * land
        still = np.zeros((n, 3))
        still[:, 1] = (1.0, -1.0)[p] * 8.0
        still[:, 0] = at[np.clip(np.searchsorted(land, t, side="right") - 1, 0, None)]
        for k, (begin, end) in enumerate(zip(lift[:-1], land[1:], strict=True)):
            s = (t - begin) / (end - begin)
            on = (s > 0.0) & (s < 1.0)
            s = s[on]
            still[on, 0] = at[k] + (at[k + 1] - at[k]) * (10 * s**3 - 15 * s**4 + 6 * s**5)
            up = lifted * np.sin(np.pi * s)
            still[on, 2] = up
            weight[np.flatnonzero(on)[s < hidden], p] = 0.0
        truth[:, p] = still + t[:, None] * DRIFT
        seen = truth[:, p] + noise * rng.normal(size=(n, 3))
        information = weight[:, p, None, None] * np.eye(3) / 0.3**2
        x[:, p] = smooth(information, weight[:, p, None] * seen / 0.3**2, np.full(n, 0.04))[0]
        origin = np.column_stack([at, np.full(len(at), still[0, 1]), 0 * at])
        origin[:, 1] = (1.0, -1.0)[p] * 8.0
        edges = zip(land, lift, origin, strict=True)
        # it is near where it stands for half a frame more at either end
        whole = [
            Stance(max(int(np.ceil(a - 0.5)), 0), min(int(b + 0.5) + 1, n), o) for a, b, o in edges
        ]
        stances.append([one for one in whole if one.first < one.stop and one.stop > 0])
        times.append(list(zip(lift[:-1], land[1:], strict=True)))
    return Walk(truth, x, weight, stances, times)


def learn(made, **options):
    """Learn the swings of a walk."""
    known = {
        "substrate": Substrate(np.zeros(2), DRIFT, np.zeros((2, 3)), motion_model()),
        "duty_factor": RHYTHM,
        "kinds": KINDS,
        "fps": FPS,
        "certain": np.ones(made.weight.shape, bool),
        **options,
    }
    return learn_swings(made.x, made.weight, made.stances, **known)


def same(found, expected, *, atol=1e-6):
    """Assert that swings are the same."""
    for name in ("place", "sd", "jerk_mean"):
        np.testing.assert_allclose(getattr(found, name), getattr(expected, name), atol=atol)
    np.testing.assert_allclose(found.lift_offs, expected.lift_offs, atol=atol)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_hidden_swings_are_near_the_truth_and_nearer_than_smoothed(seed):
    made = walk(seed=seed)
    swings = learn(made)
    told = made.hidden & np.isfinite(swings.place[..., 0])
    # as good as all that is occluded is told: what is not is at either end of a swing
    assert told.sum() > 0.9 * made.hidden.sum() > 60
    off, smoothed = (
        np.sqrt(np.mean(np.sum((at - made.truth)[told] ** 2, axis=-1)))
        for at in (swings.place, made.x)
    )
    assert off < 0.25 * THICKNESS
    assert off < 0.6 * smoothed


@pytest.mark.slow
def test_the_stated_sd_of_places_and_lift_offs_is_honest():
    error, late = [], []
    for seed in range(8):
        made = walk(seed=seed)
        rng = np.random.default_rng(seed)
        # nobody saw when they lifted off: that is told two frames too early or too late
        stances = [[replace(one, stop=one.stop + int(rng.integers(-2, 3))) for one in mine[:-1]]
                   for mine in made.stances]  # fmt: skip
        for mine, whole in zip(stances, made.stances, strict=True):
            mine.append(whole[-1])
        swings = learn(replace(made, stances=stances))
        error.append(((swings.place - made.truth) / swings.sd)[made.hidden])
        for p, lift, sd in swings.lift_offs:
            nearest = min((begin - lift for begin, _ in made.times[p]), key=abs)
            late.append(nearest / sd)
    error = np.concatenate(error)
    assert np.sqrt(np.nanmean(error**2)) < 1.2
    # but they are not just wide; to the side all go alike, which is not taken for granted
    assert (np.sqrt(np.nanmean(error[:, [0, 2]] ** 2, axis=0)) > 0.25).all()
    assert np.nanmax(swings.sd[..., 1]) < 0.3 * THICKNESS
    assert 0.5 < np.sqrt(np.mean(np.square(late))) < 1.5


@pytest.mark.slow
def test_lift_offs_are_found_by_what_is_seen_later():
    made = walk(seed=11)
    late = [[replace(one, stop=one.stop + 4) for one in mine] for mine in made.stances]
    lift_offs = learn(replace(made, stances=late), duty_factor=None).lift_offs
    assert len(lift_offs) == sum(len(mine) - 1 for mine in late) > 6
    for p, lift, sd in lift_offs:
        assert min(abs(begin - lift) for begin, _ in made.times[p]) < 1.5
        assert sd < 1.0


def test_swings_before_the_first_and_after_the_last_stance_are_told_by_the_rhythm():
    made = walk(seed=12)
    first, last = (
        slice(0, made.stances[0][0].first - 1), slice(made.stances[0][-1].stop + 1, None),
    )  # fmt: skip
    told, untold = learn(made), learn(made, duty_factor=None)
    for frames in (first, last):
        assert np.isfinite(told.place[frames, 0]).all()
        assert np.isnan(untold.place[frames, 0]).all()
        away = np.linalg.norm(told.place[frames, 0] - made.truth[frames, 0], axis=-1)
        assert away.max() < 0.5 * THICKNESS
    # the last swing of the recording is occluded for most of it
    assert made.hidden[last, 0].any()
    # when a paw stood as the recording began, it is not known what was before
    assert made.stances[1][0].first == 0
    assert np.isnan(told.place[: made.stances[1][0].stop - 1, 1]).all()
    assert sorted({p for p, lift, _ in told.lift_offs if lift < 0}) == [0]


def test_what_is_not_certain_hardly_bends_a_swing_whose_end_is_not_known():
    made = walk(seed=12)
    last = slice(made.stances[0][-1].stop + 1, None)
    made.x[last, 0] += [0.0, 0.0, -1.5 * THICKNESS]
    made.weight[last, 0] = 1.0
    certain = np.ones(made.weight.shape, bool)
    certain[last, 0] = False
    doubted, believed = (
        np.abs(learn(made, certain=is_certain).place[last, 0, 2] - made.truth[last, 0, 2]).max()
        for is_certain in (certain, np.ones_like(certain))
    )
    assert doubted < 0.7 * believed
    # between two stances what follows tells as much, as long as it lands for certain
    whole = slice(made.stances[0][1].stop + 1, made.stances[0][2].first - 5)
    certain[whole, 0] = False
    same_there = learn(made, certain=certain).place[whole, 0]
    certain[whole, 0] = True
    np.testing.assert_allclose(same_there, learn(made, certain=certain).place[whole, 0])


def test_left_and_right_may_be_mirrored():
    made = walk(seed=13)
    swings = learn(made)
    mirror = np.array([1.0, -1.0, 1.0])
    stances = [[replace(one, origin=one.origin * mirror) for one in mine] for mine in made.stances]
    # the drift has a part to the side
    substrate = Substrate(np.zeros(2), DRIFT * mirror, np.zeros((2, 3)), motion_model())
    turned = learn(replace(made, x=made.x * mirror, stances=stances), substrate=substrate)
    expected = replace(swings, place=swings.place * mirror, jerk_mean=swings.jerk_mean * mirror)
    same(turned, expected)
    # which of them comes first does not matter
    swapped = learn(
        replace(made, x=made.x[:, ::-1], weight=made.weight[:, ::-1], stances=made.stances[::-1])
    )
    for name in ("place", "sd", "jerk_mean"):
        np.testing.assert_allclose(
            getattr(swapped, name)[:, ::-1], getattr(swings, name), atol=1e-6
        )


angles = st.floats(-3.0, 3.0)
MADE = walk(strides=3, seed=14)


@rules(max_examples=5)
@given(angles, angles, st.tuples(*3 * [st.floats(-300.0, 300.0)]))
def test_axes_and_origin_do_not_matter(yaw, pitch, moved):
    turn = np.array([[np.cos(yaw), np.sin(yaw), 0], [-np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]])
    turn = turn @ np.array(
        [[np.cos(pitch), 0, np.sin(pitch)], [0, 1, 0], [-np.sin(pitch), 0, np.cos(pitch)]]
    )
    stances = [
        [replace(one, origin=one.origin @ turn + moved) for one in mine] for mine in MADE.stances
    ]
    made = replace(MADE, x=MADE.x @ turn + moved, stances=stances)
    substrate = Substrate(np.zeros(2), DRIFT @ turn, np.zeros((2, 3)), motion_model(turn))
    swings = learn(MADE)
    expected = replace(swings, place=swings.place @ turn + moved, jerk_mean=swings.jerk_mean @ turn)
    same(learn(made, substrate=substrate), expected, atol=1e-5)


def test_the_unit_of_space_does_not_matter():
    unit = 25.4
    stances = [[replace(one, origin=unit * one.origin) for one in mine] for mine in MADE.stances]
    coarse = replace(motion_model(), body_scale=unit * 40.0, paw_width=unit * THICKNESS)
    substrate = Substrate(np.zeros(2), unit * DRIFT, np.zeros((2, 3)), coarse)
    found = learn(replace(MADE, x=unit * MADE.x, stances=stances), substrate=substrate)
    swings = learn(MADE)
    expected = Swings(
        unit * swings.place, unit * swings.sd, unit * swings.jerk_mean, swings.lift_offs
    )
    same(found, expected, atol=1e-5)


@pytest.mark.parametrize("later", [7, 40])
def test_a_recording_that_begins_sooner_tells_the_same(later):
    made = walk(seed=15)
    room = ((later, 0), (0, 0), (0, 0))
    x = np.pad(made.x, room, mode="edge")
    stances = [
        [Stance(one.first + later, one.stop + later, one.origin - later * DRIFT) for one in mine]
        for mine in made.stances
    ]
    # what stood as the recording began might have landed then
    stances[1], first = stances[1][1:], made.stances[1][1:]
    moved = learn(replace(made, x=x, weight=np.pad(made.weight, room[:2]), stances=stances))
    swings = learn(replace(made, stances=[made.stances[0], first]))
    shifted = tuple((p, lift + later, sd) for p, lift, sd in swings.lift_offs)
    same(
        Swings(moved.place[later:], moved.sd[later:], moved.jerk_mean[later:], moved.lift_offs),
        replace(swings, lift_offs=shifted),
    )


def test_places_bend_as_the_truth_does_until_they_land():
    made = walk(seed=16, noise=0.0)
    swings = learn(made)
    jerk_mean = np.full(made.truth.shape, np.nan)
    jerk_mean[1:-2] = np.diff(made.truth, 3, axis=0)
    for p, lift, _ in swings.lift_offs:
        if lift < 0 or lift > 180:
            continue
        land = min(end for begin, end in made.times[p] if end > lift + 5)
        inside = np.arange(int(lift) + 2, int(lift + 0.75 * (land - lift)))
        np.testing.assert_allclose(swings.jerk_mean[inside, p], jerk_mean[inside, p], atol=0.08)
        assert np.isfinite(swings.jerk_mean[int(lift), p]).all()
        assert np.isnan(swings.jerk_mean[int(land) + 2, p]).all()
        # it goes up at once: of the speed of the sine, half is gained from frame to frame
        kick = swings.jerk_mean[int(lift) - 1 : int(lift) + 2, p, 2].max()
        assert kick > 0.25 * np.pi * HEIGHT / (land - lift)


def test_too_few_swings_or_too_short_ones_tell_nothing():
    made = walk(seed=17)
    kinds = ["front", "hind"]
    few = [made.stances[0][:3], made.stances[1]]
    assert len(few[0]) == 3
    swings = learn(replace(made, stances=few), kinds=kinds)
    assert np.isnan(swings.place[:, 0]).all()
    assert {p for p, _, _ in swings.lift_offs} == {1}
    # with those of the other paw there are enough
    both = learn(replace(made, stances=few))
    assert np.isfinite(both.place[:, 0]).any()
    # paws that tread on the spot, and an animal that goes backwards
    for share in (0.0, -1.0):
        stances = [
            [replace(one, origin=one.origin * [share, 1.0, 1.0]) for one in mine]
            for mine in made.stances
        ]
        assert learn(replace(made, stances=stances)).lift_offs == ()


def test_where_a_stance_was_missed_there_is_no_swing():
    made = walk(strides=5, seed=19)
    missed = made.stances[0][2]
    stances = [[one for one in made.stances[0] if one is not missed], made.stances[1]]
    swings = learn(replace(made, stances=stances))
    around = slice(made.stances[0][1].stop, made.stances[0][3].first)
    assert around.start < missed.first < missed.stop < around.stop
    assert np.isnan(swings.place[around, 0]).all()
    # others are told as before
    all_told = learn(made)
    before = slice(made.stances[0][0].stop, made.stances[0][1].first)
    np.testing.assert_allclose(swings.place[before, 0], all_told.place[before, 0], atol=0.3)


@pytest.mark.parametrize("n", [1, 5])
def test_a_few_frames_tell_nothing_and_are_no_reason_to_fail(n):
    short = Walk(MADE.truth[:n], MADE.x[:n], MADE.weight[:n], [[], []], [])
    assert learn(short).lift_offs == ()
    stood = replace(short, stances=[[Stance(0, n, np.zeros(3))], [Stance(n - 1, n, np.zeros(3))]])
    assert np.isnan(learn(stood).place).all()


def test_a_paw_that_was_never_seen_harms_no_other():
    """Its places may not be known at all, and its pair is then as a paw without one."""
    nobody = np.full((len(MADE.x), 1, 3), np.nan)
    three = replace(
        MADE, x=np.concatenate([MADE.x, nobody], axis=1), stances=[*MADE.stances, []],
        weight=np.pad(MADE.weight, ((0, 0), (0, 1))),
    )  # fmt: skip
    duty_factor = DutyFactor(np.full(3, SHARE), np.full(3, 0.02), STRIDE, 2.0)
    for kinds in (["front", "front", "hind"], ["hind", "front", "front"]):
        swings = learn(three, kinds=kinds, duty_factor=duty_factor)
        assert np.isnan(swings.place[:, 2]).all()
        expected = learn(MADE, kinds=kinds[:2])
        same(replace(swings, place=swings.place[:, :2], sd=swings.sd[:, :2],
                     jerk_mean=swings.jerk_mean[:, :2]), expected)  # fmt: skip


def test_frames_that_were_never_placed_count_as_unseen():
    """In the middle of swings, so that how well it is known when they end stays as it was."""
    x, weight = MADE.x.copy(), MADE.weight.copy()
    for p, times in enumerate(MADE.times):
        for lift, land in times:
            middle = slice(max(int(lift) + 11, 0), max(int(land) - 4, 0))
            x[middle, p], weight[middle, p] = np.nan, 0.0
    unseen = learn(replace(MADE, weight=weight))
    same(learn(replace(MADE, x=x)), unseen)
    assert np.nanmax(np.abs(unseen.place - learn(MADE).place)) > 0.1


def test_a_single_view_tells_swings_forward_and_up():
    made = walk(seed=18)
    stances = [[replace(one, origin=one.origin[[0, 2]] * [1.0, -1.0]) for one in mine]
               for mine in made.stances]  # fmt: skip
    axes = np.array([[1.0, 0.0], [0.0, -1.0]])
    substrate_velocity = DRIFT[[0, 2]] * [1.0, -1.0]
    substrate = Substrate(np.zeros(2), substrate_velocity, np.zeros((2, 2)), motion_model(axes))
    flat = replace(made, x=made.x[..., [0, 2]] * [1.0, -1.0], stances=stances)
    swings, whole = learn(flat, substrate=substrate), learn(made)
    # nothing to the side is fitted, so all else is the same
    np.testing.assert_allclose(swings.place * [1.0, -1.0], whole.place[..., [0, 2]], atol=1e-6)
    np.testing.assert_allclose(swings.sd, whole.sd[..., [0, 2]], atol=1e-6)
    np.testing.assert_allclose(swings.lift_offs, whole.lift_offs, atol=1e-6)
