"""Evidence that is kept: the same tracks as from scratch, and never that of something else."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pandas as pd
import pytest

from pawnb.core.paws.offline import learnt_run, pipeline
from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.detection.evidence import Detections
from pawnb.core.paws.offline.learnt_run import track_learnt
from pawnb.core.paws.offline.parameters import OfflineParameters, SceneParameters
from pawnb.core.paws.offline.reuse.kept_evidence import GONE_ON_FROM, KeptStacks, fits, same_size
from pawnb.core.paws.offline.reuse.point_evidence import PointEvidence
from pawnb.core.paws.offline.reuse.retracking import TRUST, after_correction
from pawnb.core.paws.request import TrackingRequest
from pawnb.schema import ORIGIN_CODE

N = 24
POINTS = ("FR", "HR")
SCENE = SceneParameters(extent=90.0, spacing=4)
QUICK = OfflineParameters(
    scene=SCENE,
    appearance=dataclasses.replace(
        OfflineParameters().appearance, networks=1, copies=2, epochs=8, folds=1
    ),
)


def way():
    """Two patches that swing against each other, (N, 2 points, 2) px."""
    swing = 18 * np.sin(2 * np.pi * np.arange(N) / 30)
    return np.stack(
        [np.stack([x + s * swing, np.full(N, 70.0)], -1) for x, s in ((110, 1), (50, -1))], axis=1
    )


def film(make_texture, seed=0):
    """Textured squares of 13 px over a smooth ground."""
    pictures = np.repeat(make_texture(110, 160, seed=seed, low=60, high=110)[None], N, axis=0)
    for i in range(len(POINTS)):
        patch = make_texture(13, 13, seed=5 + i, low=0, high=255)
        for picture, (u, v) in zip(pictures, way()[:, i].round().astype(int), strict=True):
            picture[v - 6 : v + 7, u - 6 : u + 7] = patch
    return pictures


def clicks(frames):
    rows = [(t, "side", p, *way()[t, i]) for t in frames for i, p in enumerate(POINTS)]
    return pd.DataFrame(rows, columns=["frame", "view", "point", "u", "v"])


def run(views, start, *, parameters=QUICK, frames=(0, N), **kept):
    task = TrackingRequest(frames=frames, fps=100.0, points_by_view={"side": POINTS})
    return track_learnt(views, start, task, parameters=parameters, **kept)


def positions(tracks):
    uv = tracks["image_position"].isel(view=0, individual=0)
    return uv.transpose("time", "keypoint", "image_space").to_numpy()


class Counted:
    """Views that count how many frames are read of them."""

    def __init__(self, views):
        self._views, self.read = views, 0

    def __getattr__(self, name):
        return getattr(self._views, name)

    def frames(self, *args, **kept):
        for item in self._views.frames(*args, **kept):
            self.read += 1
            yield item


@pytest.fixture(scope="module")
def pictures(make_texture):
    return film(make_texture)


@pytest.fixture
def views(array_views, pictures):
    return Counted(array_views({"side": pictures}))


@pytest.mark.slow
def test_with_kept_evidence_nothing_is_read_and_tracks_are_as_from_scratch(views):
    stacks = KeptStacks()
    first = run(views, clicks([2]), stacks=stacks)
    assert views.read == N
    more = clicks([2, 12])
    kept = run(views, more, looked=clicks([2]), stacks=stacks)
    assert views.read == N
    scratch = run(views, more, looked=clicks([2]))
    assert views.read == 2 * N
    np.testing.assert_allclose(positions(kept), positions(scratch), atol=0.05)
    np.testing.assert_allclose(kept["image_confidence"], scratch["image_confidence"], atol=0.05)
    assert np.abs(positions(kept) - positions(first)).max() > 1e-6  # the click was learnt from


@pytest.mark.slow
@pytest.mark.parametrize(
    "other",
    [
        {"parameters": dataclasses.replace(QUICK, scene=dataclasses.replace(SCENE, margin=0.6))},
        {"frames": (0, N - 1)},
        {"start": clicks([2]).assign(u=[105.0, 70.0])},  # a smaller animal
    ],
)
def test_evidence_of_other_settings_frames_or_clicks_is_not_used(views, other):
    stacks = KeptStacks()
    run(views, clicks([2]), stacks=stacks)
    read = views.read
    asked = {"start": clicks([2]), **other}
    found = run(views, stacks=stacks, **asked)
    assert views.read > read
    np.testing.assert_allclose(positions(found), positions(run(views, **asked)), atol=0.05)


def test_views_of_another_name_have_evidence_of_their_own(make_stack):
    stacks, stack = KeptStacks(), make_stack(np.zeros((4, 60, 90), np.uint8))
    kept = {"frames": (0, 4), "parameters": SCENE}
    stacks.keep(["side"], [stack], **kept)
    nothing = [Annotations({})]
    assert stacks.find(["side"], nothing, **kept) == [stack]
    assert stacks.find(["below"], nothing, **kept) is None
    assert stacks.find(["side"], nothing, frames=(1, 5), parameters=SCENE) is None


def test_evidence_of_points_is_kept_with_its_stacks_and_for_the_same_request(make_stack):
    stack = make_stack(np.zeros((4, 60, 90), np.uint8))
    none = Detections(*(np.empty(0, int),) * 2, np.empty((0, 2)), *(np.empty(0),) * 2)
    looks = {0: np.ones((4, 15, 22), np.float32)}
    evidence = PointEvidence(0, 4, Annotations({}), none, none, looks, {0: (0, 4)})
    stacks = KeptStacks(most_bytes=60_000)  # stack and flow have 50400 bytes, looks 2640
    stacks.keep(["side"], [stack], frames=(0, 4), parameters=SCENE)
    stacks.keep_evidence([stack], "these points", {"side": evidence})
    assert list(stacks.evidence([stack], "these points")) == ["side"]
    assert not stacks.evidence([stack], "other points")
    assert not stacks.evidence([dataclasses.replace(stack)], "these points")
    stacks.keep(["side"], [stack], frames=(0, 4), parameters=SCENE)  # read anew
    assert not stacks.evidence([stack], "these points")
    many = {p: np.ones((4, 15, 22), np.float32) for p in range(5)}
    stacks.keep_evidence([stack], "many", {"side": dataclasses.replace(evidence, looks=many)})
    assert not stacks.evidence([stack], "many")  # no room for it, but for the pictures
    assert stacks.find(["side"], [Annotations({})], frames=(0, 4), parameters=SCENE) == [stack]


def test_no_more_is_kept_than_there_is_room_for(make_stack):
    stack = make_stack(np.zeros((4, 60, 90), np.uint8))  # 21600 bytes, and flow of 28800
    stacks = KeptStacks(most_bytes=120_000)
    for begin in (0, 4, 8):
        stacks.keep(["side"], [stack], frames=(begin, begin + 4), parameters=SCENE)
    found = [
        stacks.find(["side"], [Annotations({})], frames=(b, b + 4), parameters=SCENE) is not None
        for b in (0, 4, 8)
    ]
    assert found == [False, True, True]


@pytest.mark.parametrize(
    ("at", "ends", "expected"),
    [
        ([[22, 30], [78, 30]], ((False, False), (False, False)), True),
        ([[5, 30], [63, 30]], ((False, False), (False, False)), False),  # 0.35 of 60 px are 21
        ([[5, 30], [63, 30]], ((True, False), (False, False)), True),
        ([[25, 30], [83, 30]], ((True, False), (False, False)), False),
        ([[14, 30], [86, 30]], ((True, True), (True, True)), True),  # 72 of 60 px, stretched
        ([[10, 30], [90, 30]], ((True, True), (True, True)), True),  # 80 of 60 px
        ([[30, 30], [38, 30]], ((True, True), (True, True)), False),
    ],
)
def test_clicks_fit_well_within_pictures_of_their_scale(make_stack, at, ends, expected):
    stack = dataclasses.replace(make_stack(np.zeros((2, 60, 100), np.uint8)), ends=ends)
    places = {point: np.array(uv, float) for point, uv in enumerate(at)}
    assert fits(stack, Annotations({1: places})) == expected


def corrected(tracks, frame, point, uv):
    tracks = tracks.copy(deep=True)
    here = {"time": frame, "view": 0, "individual": 0, "keypoint": POINTS.index(point)}
    tracks["image_position"][here] = np.asarray(uv)
    tracks["image_origin"][here] = ORIGIN_CODE["edited"]
    return tracks


@pytest.mark.slow
def test_frames_up_to_the_next_click_of_the_point_are_tracked_again(views):
    tracks = run(views, clicks([2, 20]))
    placed = corrected(tracks, 8, "FR", (100.0, 60.0))
    assert after_correction(placed, 8, ["FR"]).frames == (8, 21)
    assert after_correction(placed, 2, ["FR", "HR"]).frames == (2, 21)
    assert after_correction(placed, 20, ["FR"]).frames == (20, N)


@pytest.mark.slow
@pytest.mark.parametrize("kept", [True, False])
def test_what_is_tracked_again_passes_through_the_correction(views, kept, monkeypatch):
    stacks, start = KeptStacks(), clicks([2, 20])
    tracks = run(views, start, stacks=stacks)
    assert tracks.attrs[TRUST] == QUICK.appearance.trust
    placed = corrected(tracks, 8, "FR", way()[8, 0] + [0.0, 6.0])
    again = after_correction(placed, 8, ["FR"])
    more = pd.concat([start, pd.DataFrame([(8, "side", "FR", *(way()[8, 0] + [0.0, 6.0]))],
                                          columns=start.columns)])  # fmt: skip
    read, looked_at, maps = views.read, [], pipeline.appearance_maps

    def look(*args, rows, points, **rest):
        looked_at.append((list(points), rows))
        return maps(*args, rows=rows, points=points, **rest)

    monkeypatch.setattr(pipeline, "appearance_maps", look)
    found = run(views, more, looked=start, stacks=stacks if kept else None, again=again)
    # once, in its frames only, and for the other point where nothing is kept of it
    assert looked_at == [([0] if kept else [0, 1], range(8, 21))]
    assert views.read == (read if kept else read + N)
    uv = positions(found)
    np.testing.assert_allclose(uv[8, 0], way()[8, 0] + [0.0, 6.0], atol=1e-9)
    rows = np.isfinite(uv[:, 0, 0])
    assert rows[8:21].all()
    assert not rows[list(range(2)) + list(range(3, 8)) + list(range(21, N))].any()
    off = np.linalg.norm(uv[9:21, 1] - way()[9:21, 1], axis=-1)
    assert np.nanmax(off) < 4  # the other point is followed on


@pytest.mark.slow
def test_a_correction_that_was_taken_back_is_not_known_any_more(views, monkeypatch):
    stacks, start = KeptStacks(), clicks([2, 20])
    tracks = run(views, start, stacks=stacks)
    at = way()[8, 0] + [0.0, 6.0]
    more = pd.concat([start, pd.DataFrame([(8, "side", "FR", *at)], columns=start.columns)])
    again = after_correction(corrected(tracks, 8, "FR", at), 8, ["FR"])
    run(views, more, looked=start, stacks=stacks, again=again)
    looked_for, maps = [], pipeline.appearance_maps
    monkeypatch.setattr(
        pipeline, "appearance_maps",
        lambda *args, points, **rest: looked_for.append(list(points))
        or maps(*args, points=points, **rest),
    )  # fmt: skip
    undone = after_correction(corrected(tracks, 8, "HR", way()[8, 1]), 8, ["HR"])
    other = pd.DataFrame([(8, "side", "HR", *way()[8, 1])], columns=start.columns)
    found = run(views, pd.concat([start, other]), looked=start, stacks=stacks, again=undone)
    assert looked_for == [[0, 1]]  # both: the one is placed, the other is not any more
    off = np.linalg.norm(positions(found)[8:21] - way()[8:21], axis=-1)
    assert np.nanmax(off) < 4


@pytest.mark.slow
def test_added_clicks_go_on_from_the_last_run(views):
    """Frames beyond the clicks on either side stay as they were, to the last digit."""
    stacks = KeptStacks()
    first = run(views, clicks([2, 12]), stacks=stacks)
    read = views.read
    more = run(views, clicks([2, 7, 12]), stacks=stacks)
    assert views.read == read
    uv, old = positions(more), positions(first)
    outside = [*range(2), *range(13, N)]
    np.testing.assert_array_equal(uv[outside], old[outside])
    np.testing.assert_allclose(uv[7], way()[7], atol=1e-9)
    assert np.abs(uv[3:12] - old[3:12]).max() > 1e-6
    assert np.linalg.norm(uv - way(), axis=-1).max() < 4
    (before,) = json.loads(more.attrs[GONE_ON_FROM])
    assert pd.DataFrame(before).equals(clicks([2, 12]))
    moved = clicks([2, 7, 12]).assign(v=lambda c: c["v"] + 1.0)
    assert json.loads(run(views, moved, stacks=stacks).attrs[GONE_ON_FROM]) == []


@pytest.mark.slow
def test_clicks_that_the_pictures_do_not_show_have_others_read_and_all_tracked(views, monkeypatch):
    """What the last run has learnt serves, so that nothing is weighed by leaving clicks out."""
    stacks = KeptStacks()
    first = run(views, clicks([2, 12]), stacks=stacks)
    read = views.read
    higher = clicks([7]).assign(
        v=lambda c: c["v"] - 35.0
    )  # the pictures end 52 px above the points
    monkeypatch.setattr(learnt_run, "weigh", None)
    more = run(views, pd.concat([clicks([2]), higher, clicks([12])]), stacks=stacks)
    assert views.read == read + N
    assert json.loads(more.attrs[GONE_ON_FROM]) == [clicks([2, 12]).to_dict(orient="records")]
    uv, old = positions(more), positions(first)
    np.testing.assert_allclose(uv[7], way()[7] - [0.0, 35.0], atol=1e-9)
    assert np.abs(uv[13:] - old[13:]).max() > 1e-6  # beyond the click after it, too
    assert more.attrs[TRUST] == first.attrs[TRUST]


@pytest.mark.parametrize(
    ("longest", "expected"),
    # 1.75 times 40 px are 70
    [(40.0, True), (69.0, True), (71.0, False), (23.0, True), (22.0, False)],
)
def test_an_animal_of_another_size_is_begun_anew(longest, expected):
    def of_length(px):
        return Annotations({0: {0: np.zeros(2), 1: np.array([px, 0.0])}})

    alone, nothing = Annotations({0: {0: np.zeros(2)}}), Annotations({})
    assert same_size([of_length(40.0), alone], [of_length(longest), alone]) == expected
    assert same_size([of_length(40.0), nothing], [of_length(40.0), nothing])
    assert not same_size([of_length(40.0), nothing], [of_length(40.0), alone])  # a view more
