"""Collisions: flags from frame to frame, the template's prediction, weights, jumps undone."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from pawnb.core.paws.layout import make_layout
from pawnb.core.paws.maghsoudi2019.collisions import Collisions
from pawnb.core.paws.maghsoudi2019.settings import Maghsoudi2019Settings
from pawnb.core.paws.maghsoudi2019.template import KindTemplate, StrideTemplate
from pawnb.core.paws.maghsoudi2019.tracker import track_maghsoudi2019
from pawnb.core.paws.request import TrackingRequest
from pawnb.errors import InputError
from pawnb.schema import ORIGIN_CODE

FPS = 250.0
PERIOD = 40.0
SHARE = np.arange(50) / 50
SETTINGS = Maghsoudi2019Settings(scale=0.4, min_paw_area_px=300)


def shape(phase):
    """A stride: u is the cosine, v lifts while u rises."""
    angle = 2 * np.pi * np.asarray(phase)
    return np.stack([np.cos(angle) / 2, -0.3 * np.maximum(np.sin(-angle), 0.0) ** 2], axis=-1)


TEMPLATE = StrideTemplate(
    {kind: KindTemplate(shape(SHARE), PERIOD / FPS, 10) for kind in ("front", "hind")}
)


@dataclasses.dataclass
class Places:
    """What is asked of a detection."""

    places: np.ndarray


def walk(scene, n=90, *, apart=45.0, amplitude=30.0):
    """Paths (n, V, P, 2) in both views; the paws are nearest every 40 frames."""
    t = np.arange(n)
    paths = np.empty((n, len(scene.names), 2, 2))
    for v in range(len(scene.names)):
        paths[:, v, 0] = [160 + apart / 2, 80] + amplitude * shape(t / PERIOD + 0.5)
        paths[:, v, 1] = [160 - apart / 2, 80] + amplitude * shape(t / PERIOD)
    return paths


def collisions_of(scene, *, settings=SETTINGS, facing=1, points=None):
    task = TrackingRequest(
        frames=(0, scene.n_frames),
        fps=FPS,
        rig=scene.rig,
        points_by_view=points or {},
        facing={"cam1": facing, "cam2": facing},
    )
    layout = make_layout(scene, scene.clicks(), task, settings=settings)
    return Collisions(layout, TEMPLATE, fps=FPS)


def test_the_flag_is_set_by_nearness_lasts_and_is_cleared_when_they_part(make_scene):
    """Collision_Threshold is 60 px of the paper's pictures: 24 px at a scale of 0.4."""
    scene = make_scene()
    collisions = collisions_of(scene)
    paths = walk(scene)
    gap = np.linalg.norm(paths[:, 0, 0] - paths[:, 0, 1], axis=-1)
    flagged = []
    for uv in paths:
        collisions.record(uv)
        flagged.append(collisions.is_colliding((0, 0)))
    # both views have the same paths, so nearness in one is nearness in the other
    expected = gap < 24.0
    assert expected[:20].any()
    # Start_Frame_Collision: 20 frames must have been tracked before the first
    expected[:20] = False
    assert expected[20:].any()
    assert not expected[20:].all()
    np.testing.assert_array_equal(flagged, expected)
    assert collisions.is_colliding((1, 1)) == expected[-1]


def detect(view, places):
    """Detections of the front paw, best first."""
    return {(view, 0): Places(np.asarray(places, dtype=float))}


def collide(scene, paths):
    """A run of paths up to the first frame of a collision; returns the run and that frame."""
    collisions = collisions_of(scene)
    gap = np.linalg.norm(paths[:, 0, 0] - paths[:, 0, 1], axis=-1)
    first = 20 + int(np.flatnonzero(gap[20:] < 24.0)[0])
    for uv in paths[: first + 1]:
        collisions.record(uv)
    return collisions, first


def step(collisions, true, found):
    """One frame in which the filter predicts what is true; returns predictions and verdicts."""
    centres = true.copy()
    collisions.predict(centres)
    uv = true.copy()
    uv[0, 0] = found[0]
    verdicts = collisions.resolve(detect(0, found), uv, centres=centres)
    for verdict in verdicts:
        if verdict.rank is None:
            uv[verdict.key] = verdict.place
        else:
            uv[verdict.key] = found[verdict.rank]
    collisions.record(uv)
    return centres, verdicts


def test_the_template_takes_over_where_none_of_the_best_superpixels_is_the_paw(make_scene):
    """It is fitted to the frames before the collision, and stays right while all is wrong."""
    scene = make_scene()
    paths = walk(scene)
    collisions, first = collide(scene, paths)
    for frame in range(first + 1, first + 8):
        true = paths[frame]
        # all that is found is far ahead: 0.4 of 24 px is where a step ends
        centres, (verdict,) = step(collisions, true, true[0, 0] + [[25, 0], [30, 5], [26, 9]])
        assert (verdict.key, verdict.rank) == ((0, 0), None)
        assert np.linalg.norm(verdict.place - true[0, 0]) < 4.0, frame
        if frame > first + 1:
            np.testing.assert_allclose(centres[0, 0], verdict.place)
        np.testing.assert_array_equal(centres[0, 1], true[0, 1])  # the hind paw is seen
    # found again where the template has it: the filter predicts from then on
    true = paths[first + 8]
    _, verdicts = step(collisions, true, true[0, 0] + [[1, 0], [30, 5], [26, 9]])
    assert verdicts == []
    centres, _ = step(collisions, paths[first + 9], paths[first + 9, 0, 0][None])
    np.testing.assert_array_equal(centres, paths[first + 9])


def test_to_the_letter_the_template_predicts_both_paws_until_they_part(make_scene):
    """Algorithm 3, lines 7 to 11: with the flag set the spline is where both are looked for."""
    scene = make_scene()
    paths = walk(scene)
    gap = np.linalg.norm(paths[:, 0, 0] - paths[:, 0, 1], axis=-1)
    settings = dataclasses.replace(SETTINGS, template_predicts="always")
    collisions = collisions_of(scene, settings=settings)
    by_template = []
    for frame, uv in enumerate(paths):
        # the filter is off by 3 px, as it is where a paw turns
        filtered = uv + np.array([3.0, 0.0])
        centres = filtered.copy()
        collisions.predict(centres)
        by_template.append((centres != filtered).any(axis=-1).all())
        assert by_template[-1] == (centres != filtered).any()
        if by_template[-1]:
            assert np.linalg.norm(centres - uv, axis=-1).max() < 4.0, frame
        # nothing that is found is refused, however far off
        far = detect(0, [uv[0, 0] + [40.0, 0.0]])
        assert collisions.resolve(far, uv, centres=centres) == []
        collisions.record(uv)
    # a frame after the paws have come near, from the 20th on, to a frame after they have parted
    expected = np.concatenate([[False], gap[:-1] < 24.0])
    expected[:21] = False
    assert expected.any()
    np.testing.assert_array_equal(by_template, expected)


def test_a_paw_that_is_seen_keeps_the_filters_prediction_and_its_best_superpixel(make_scene):
    scene = make_scene()
    paths = walk(scene)
    collisions, first = collide(scene, paths)
    true = paths[first + 1]
    centres, verdicts = step(collisions, true, true[0, 0] + [[2, 1], [30, 0]])
    np.testing.assert_array_equal(centres, true)
    assert verdicts == []
    # the best one is not it, the second is
    true = paths[first + 2]
    _, (verdict,) = step(collisions, true, true[0, 0] + [[25, 0], [1, 1], [3, 3]])
    assert verdict.rank == 1


def test_the_other_paws_superpixel_is_not_taken(make_scene):
    """Both paws were found on the hind paw, which is nearer to where that is to be."""
    scene = make_scene()
    paths = walk(scene)
    collisions, first = collide(scene, paths)
    true = paths[first + 1]
    centres = true.copy()
    centres[0, 0] = true[0, 1] + [5.0, 0.0]
    collisions.predict(centres)
    collisions._expected[0, 0] = centres[0, 0]  # the template, too, has it there
    uv = true.copy()
    uv[0, 0] = true[0, 1] + [1.0, 0.0]
    (verdict,) = collisions.resolve(detect(0, [uv[0, 0]]), uv, centres=centres)
    assert verdict.rank is None
    # where the front paw itself is as near, it is its own
    uv[0, 1] = true[0, 1] + [6.0, 0.0]
    uv[0, 0] = centres[0, 0] + [0.5, 0.0]
    verdicts = collisions.resolve(detect(0, [uv[0, 0]]), uv, centres=centres)
    assert verdicts == []


def test_a_fit_that_misses_a_paw_still_seen_is_given_up(make_scene):
    scene = make_scene()
    paths = walk(scene)
    # 0.3 of 24 px is more than the template may be off in the first frames
    for off, kept in ((6.0, True), (9.0, False)):
        collisions, first = collide(scene, paths)
        here = paths[first + 1].copy()
        collisions.predict(here.copy())
        expected = collisions._expected[0, 0]
        here[:, 0] = expected + np.array([off, 0.0])
        collisions.record(here)
        assert ((0, 0, 1) in collisions.flags) == kept


def test_history_of_a_kept_stretch_sets_no_flag(make_scene):
    scene = make_scene()
    collisions = collisions_of(scene)
    for uv in walk(scene)[:38]:
        collisions.remember(uv)
    assert not collisions.flags
    collisions.record(walk(scene)[38])
    assert collisions.flags  # and it is enough to fit the template to


def test_a_correction_has_the_template_fitted_anew(make_scene):
    scene = make_scene()
    paths = walk(scene)
    for step_px, kept in ((1.0, True), (30.0, False)):
        collisions = collisions_of(scene)
        for uv in paths[:41]:
            collisions.record(uv)
        old = collisions.flags[0, 0, 1]
        collisions.reset((0, 0), paths[40, 0, 0] + [step_px, 0.0])
        new = collisions.flags.get((0, 0, 1))
        # 30 px is no step of a paw: what was found before was wrong
        assert (new is not None) == kept
        assert new is not old
        assert collisions.is_colliding((1, 0))  # the other view goes on


def test_weights_are_those_of_algorithm_4(make_scene):
    """Worked from the paper: Weights_F [2,0,4,2,2,0,1,4] and Weights_H [2,0,4,1,2,0,2,4]."""
    scene = make_scene()
    for adjust in (True, False):
        collisions = collisions_of(
            scene, settings=dataclasses.replace(SETTINGS, adjust_weights=adjust)
        )
        assert collisions.weights((0, 0)) == (2, 0, 4, 2, 2, 0, 1, 4)
        for uv in walk(scene)[:41]:
            collisions.record(uv)
        assert collisions.is_colliding((0, 0))
        front = (3, 0, 4, 1, 2, 0, 0, 4) if adjust else (2, 0, 4, 2, 2, 0, 1, 4)
        hind = (2, 0, 6, 1, 2, 0, 2, 4) if adjust else (2, 0, 4, 1, 2, 0, 2, 4)
        assert collisions.weights((0, 0)) == front
        assert collisions.weights((0, 1)) == hind


def test_front_and_hind_paw_of_one_side_only(make_scene):
    """FR with HR and FL with HL; a view that does not know its direction has no pair."""
    scene = make_scene(("FR", "HR", "FL", "HL"))
    assert collisions_of(scene).pairs == ((0, 0, 1), (0, 2, 3), (1, 0, 1), (1, 2, 3))
    own = {"cam1": ("FR", "HR"), "cam2": ("FL", "HL")}
    clicks = scene.clicks(
        leave_out=[("cam1", "FL"), ("cam1", "HL"), ("cam2", "FR"), ("cam2", "HR")]
    )
    facing = {"cam1": 1, "cam2": 0}
    task = TrackingRequest(frames=(0, 1), fps=FPS, points_by_view=own, facing=facing)
    layout = make_layout(scene, clicks, task, settings=SETTINGS)
    assert Collisions(layout, TEMPLATE, fps=FPS).pairs == ((0, 0, 1),)
    alone = make_scene(("front", "hindleft"))
    assert collisions_of(alone).pairs == ((0, 0, 1), (1, 0, 1))


def jump_scene(make_scene, facing=1):
    """A run in collision, and a true place of the front paw that cam1 has lost by a jump."""
    scene = make_scene()
    collisions = collisions_of(scene, facing=facing)
    for uv in walk(scene)[:41]:
        collisions.record(uv)
    true = scene.uv[10].copy()
    return collisions, true


def test_a_jump_is_undone_by_direction_and_reprojection_error(make_scene):
    collisions, true = jump_scene(make_scene)
    found = true.copy()
    found[0, 0] += [30, -20]  # far off the line of sight of cam2
    last = true - [3.0, 0.0]
    behind, right = true[0, 0] - [4.0, 0.0], true[0, 0] + [0.5, 0.5]
    detections = {
        (0, 0): Places(np.array([found[0, 0], behind, right])),
        (1, 0): Places(np.array([found[1, 0], found[1, 0] + [9, 9]])),
    }
    (undone,) = collisions.undo_jumps(detections, found, last_uv=last)
    assert (undone.key, undone.rank) == ((0, 0), 2)
    # without a significant error nothing is done
    assert collisions.undo_jumps(detections, true, last_uv=last) == []


def test_only_forwards_and_the_second_time_only_between_the_last_place_and_the_best(make_scene):
    """Algorithm 3, lines 31 to 35; u grows forwards where the animal faces right."""
    for facing in (1, -1):
        collisions, true = jump_scene(make_scene, facing)
        found = true.copy()
        found[0, 0] += [facing * 30, -20]
        last = true - [facing * 3.0, 0.0]
        backwards = true[0, 0] - [facing * 4.0, 0.0]
        beyond = true[0, 0] + [facing * 31.0, 0.0]
        between = true[0, 0] + [facing * 2.0, 0.0]

        def undo(*places, collisions=collisions, found=found, last=last):
            detections = {(0, 0): Places(np.array([found[0, 0], *places]))}
            undone = collisions.undo_jumps(detections, found, last_uv=last)
            return [one.rank for one in undone]

        assert undo(backwards) == []
        assert undo(beyond, backwards) == [1]  # the first time
        assert undo(beyond, backwards) == []
        assert undo(beyond, between) == [2]


def test_a_stride_after_its_collision_a_jump_is_looked_for_no_more(make_scene):
    collisions, true = jump_scene(make_scene)
    found = true.copy()
    found[0, 0] += [30, -20]
    detections = {(0, 0): Places(np.array([found[0, 0], true[0, 0]]))}
    far = walk(make_scene())[20]
    for _ in range(45):
        collisions.record(far)
    assert collisions.undo_jumps(detections, found, last_uv=true - [3.0, 0.0]) == []


def crossing_scene(make_scene, n=110):
    """Two discs that walk in strides; when nearest, the front one is hidden for 10 frames."""
    scene = make_scene(n_frames=n)
    t = np.arange(n)
    # 2 px a mm; nothing drifts
    for p, (x, phase) in enumerate([(14.0, 0.5), (-14.0, 0.0)]):
        path = 19.0 * shape(t / PERIOD + phase)
        scene.xyz[:, p] = np.stack([x + path[:, 0], np.zeros(n), -5 - path[:, 1]], axis=-1)
    scene.uv = np.swapaxes(scene.rig.project(scene.xyz), 1, 2)
    gap = np.linalg.norm(scene.uv[:, 0, 0] - scene.uv[:, 0, 1], axis=-1)
    hidden = [i for i in range(25, n) if gap[i] < 20]
    scene.hidden = {(i, view, "FR") for i in hidden for view in scene.names}
    return scene, gap, ~np.isin(t, hidden)


def run(scene, *, method="paper", **options):
    asked = {"rig": scene.rig, "frames": (0, scene.n_frames), **options}
    task = TrackingRequest(fps=FPS, unit="mm", **asked)
    return track_maghsoudi2019(scene, scene.clicks(), task, settings=SETTINGS, method=method)


def image_path(tracks):
    return np.swapaxes(tracks["image_position"].isel(individual=0).to_numpy(), 2, 3)


@pytest.mark.slow
def test_the_template_brings_a_hidden_paw_through_a_collision(make_scene):
    """Without it the tracker takes the other paw, and stays with it."""
    scene, gap, seen = crossing_scene(make_scene)
    assert (~seen).sum() >= 10
    tracks = run(scene)
    away = np.linalg.norm(image_path(tracks) - scene.uv, axis=-1)
    # discs of 6 px radius
    assert away[seen].max() < 8.0
    origin = tracks["image_origin"].isel(individual=0).to_numpy()
    through = np.isin(origin[:, 0, 0], [ORIGIN_CODE["resolved"], ORIGIN_CODE["predicted"]])
    assert 5 < through.sum() < 60
    assert (gap[through] < 35).all()
    # where it is hidden in both views, nothing of it is called measured in space
    lost = (origin[:, :, 0] == ORIGIN_CODE["predicted"]).all(axis=1)
    assert lost.any()
    assert (tracks["origin"].to_numpy()[lost, 0, 0] == ORIGIN_CODE["predicted"]).all()
    plain = run(scene, method="slic-3d")
    assert not (plain["image_origin"] == ORIGIN_CODE["resolved"]).any()
    lost = np.linalg.norm(image_path(plain) - scene.uv, axis=-1)[seen, :, 0] > 10
    assert lost.mean() > 0.2


@pytest.mark.slow
def test_each_view_by_itself_and_space_afterwards(make_scene):
    """slic-2d finds what a run without a rig finds, and has the 3D positions of it."""
    scene, _, _ = crossing_scene(make_scene, n=50)
    scene.hidden = {(i, "cam1", "FR") for i in range(5, 25)}
    flat = run(scene, method="slic-2d")
    blind = run(scene, method="slic-3d", rig=None)
    found = image_path(flat)
    np.testing.assert_array_equal(found, image_path(blind))
    assert flat.sizes["space"] == 3
    solved = scene.rig.triangulate(np.swapaxes(found, 1, 2)).xyz
    measured = flat["origin"].isel(individual=0).to_numpy() == ORIGIN_CODE["measured"]
    assert measured.mean() > 0.5
    position = np.swapaxes(flat["position"].isel(individual=0).to_numpy(), 1, 2)
    np.testing.assert_allclose(position[measured], solved[measured])
    # and the prediction in space does find something else here
    assert not np.array_equal(found, image_path(run(scene, method="slic-3d")), equal_nan=True)
    with pytest.raises(InputError, match="unknown method 'slic-4d'; expected slic-2d, slic-3d"):
        run(scene, method="slic-4d")
