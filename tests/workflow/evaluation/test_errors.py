"""Counting errors on tracks whose mistakes were put there on purpose."""

from __future__ import annotations

import dataclasses

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pawnb.errors import InputError
from pawnb.schema import ORIGIN_CODE, make_tracks
from pawnb.workflow.evaluation.corrected_run import track_with_corrections
from pawnb.workflow.evaluation.errors import count_errors, limits_for_width, poisson_limit

N = 200
VIEWS, POINTS = ("cam1", "cam2"), ("FR", "HR")
TRUE = np.stack(
    [np.arange(N) * 2.0, 100 + 10 * np.sin(np.arange(N) / 8)], axis=-1
)  # the same path for every view and point, shifted below
SHIFT = np.array([[[0.0, 0.0], [50.0, 5.0]], [[7.0, 3.0], [90.0, 2.0]]])


def make_truth(hidden=()):
    """Every label visible but those of ``hidden``: (point, view or None, first, last)."""
    rows = []
    for v, view in enumerate(VIEWS):
        for p, point in enumerate(POINTS):
            for frame in range(N):
                gone = any(
                    point == q and view in (w or VIEWS) and first <= frame <= last
                    for q, w, first, last in hidden
                )
                rows.append((frame, view, point, *(TRUE[frame] + SHIFT[v, p]), int(not gone)))
    return pd.DataFrame(rows, columns=["frame", "view", "point", "u", "v", "visible"])


def make(wrong=(), *, offset=(0.0, 0.0), by=40.0):
    """Tracks that are right but for ``wrong``: (point, view or None, first, last)."""
    tracks = make_tracks(np.arange(N), POINTS, fps=250.0, views=VIEWS)
    for v, view in enumerate(VIEWS):
        for p, point in enumerate(POINTS):
            uv = TRUE + SHIFT[v, p] + np.asarray(offset)
            for q, w, first, last in wrong:
                if point == q and view in (w or VIEWS):
                    uv[first : last + 1, 0] += by
            tracks["image_position"][:, v, :, p, 0] = uv
            tracks["image_origin"][:, v, p, 0] = ORIGIN_CODE["measured"]
    return tracks


def kinds(report):
    return [tuple(row) for row in report.errors.itertuples(index=False)]


def test_perfect_tracks_have_no_errors():
    report = count_errors(make(), make_truth())
    assert (report.major, report.minor, report.n_frames, report.n_labels) == (0, 0, 200, 800)
    assert report.median_px == report.p95_px == report.share_wrong == 0.0
    assert np.isnan(report.share_hidden_bridged)


def test_minor_comes_back_by_itself_and_major_does_not():
    wrong = [("FR", None, 20, 24), ("HR", None, 150, N - 1), ("FR", None, 60, 110)]
    report = count_errors(make(wrong), make_truth())
    assert kinds(report) == [
        ("FR", 20, 24, "minor"),
        ("FR", 60, 110, "major"),
        ("HR", 150, 199, "major"),
    ]
    # per 1000 frames of all views together: 1 and 2 in 200 frames
    assert report.minor_per_1000 == 5.0
    assert report.major_per_1000 == 10.0
    # 5 + 51 + 50 frames of two views, of 800 labels
    assert report.share_wrong == 106 * 2 / 800


@pytest.mark.parametrize(("last", "kind"), [(44, "minor"), (45, "major")])
def test_an_error_as_long_as_a_stride_is_major(last, kind):
    report = count_errors(make([("FR", None, 20, last)]), make_truth(), recovery_frames=25)
    assert kinds(report) == [("FR", 20, last, kind)]


def test_wrong_at_the_last_frame_has_not_recovered():
    assert kinds(count_errors(make([("FR", None, 198, 199)]), make_truth())) == [
        ("FR", 198, 199, "major")
    ]
    assert kinds(count_errors(make([("FR", None, 198, 198)]), make_truth())) == [
        ("FR", 198, 198, "minor")
    ]


def test_one_error_per_point_whatever_the_number_of_views():
    one = count_errors(make([("FR", ["cam2"], 20, 24)]), make_truth())
    both = count_errors(make([("FR", None, 20, 24)]), make_truth())
    assert kinds(one) == kinds(both) == [("FR", 20, 24, "minor")]
    assert one.share_wrong == both.share_wrong / 2


def test_crossing_the_paw_by_chance_is_no_recovery():
    """Right for four frames in between: still one error of 60 frames, so major."""
    wrong = [("FR", None, 20, 50), ("FR", None, 55, 80)]
    assert kinds(count_errors(make(wrong), make_truth())) == [("FR", 20, 80, "major")]
    apart = [("FR", None, 20, 30), ("FR", None, 36, 40)]
    assert kinds(count_errors(make(apart), make_truth())) == [
        ("FR", 20, 30, "minor"),
        ("FR", 36, 40, "minor"),
    ]


def test_hidden_frames_are_neither_wrong_nor_right():
    truth = make_truth([("FR", None, 30, 60)])
    report = count_errors(make([("FR", None, 30, 60)]), truth)
    assert kinds(report) == []
    assert report.n_hidden == 62
    assert report.share_hidden_bridged == 0.0
    # hidden in one view only, the other one still tells
    truth = make_truth([("FR", ["cam1"], 30, 60)])
    assert kinds(count_errors(make([("FR", None, 30, 60)]), truth)) == [("FR", 30, 60, "major")]
    # hidden frames do not count towards recovery: 3 right, 31 hidden, 1 right, then wrong
    truth = make_truth([("FR", None, 30, 60)])
    wrong = [("FR", None, 20, 26), ("FR", None, 62, 63)]
    assert kinds(count_errors(make(wrong), truth)) == [("FR", 20, 63, "major")]


def test_bridged_means_within_ten_pixels_of_the_hidden_point():
    truth = make_truth([("FR", None, 30, 39), ("HR", None, 30, 39)])
    near = count_errors(make([("FR", None, 30, 39)], by=9.0), truth)
    far = count_errors(make([("FR", None, 30, 39)], by=11.0), truth)
    assert near.share_hidden_bridged == 1.0
    assert far.share_hidden_bridged == 0.5


def test_missing_labels_are_wrong():
    tracks = make()
    tracks["image_position"][50:54, 0, :, 0, 0] = np.nan
    report = count_errors(tracks, make_truth())
    assert kinds(report) == [("FR", 50, 53, "minor")]
    assert report.share_missing == 4 / 800
    # no distance is made up for them
    assert report.p95_px == 0.0
    assert len(report.distances_px) == 796


def test_distances_with_and_without_the_constant_offset():
    report = count_errors(make(offset=(6.0, 8.0)), make_truth())
    assert report.median_px == pytest.approx(10.0)
    assert report.p95_px == pytest.approx(10.0)
    np.testing.assert_allclose(report.distances_px, 10.0)
    assert report.median_px_centred == pytest.approx(0.0, abs=1e-9)
    lost = count_errors(make([("FR", None, 10, 199)], offset=(6.0, 8.0)), make_truth())
    # 760 of 1600 half frames are lost; the offset is that of the right ones
    assert lost.p95_px_centred == pytest.approx(40.0)
    assert lost.median_px_centred == pytest.approx(0.0, abs=1e-9)


@pytest.mark.slow
@given(st.floats(0.5, 60.0), st.integers(0, N - 1))
def test_threshold_is_a_sharp_limit(threshold, frame):
    just = make([("FR", None, frame, frame)], by=threshold * 0.999)
    over = make([("FR", None, frame, frame)], by=threshold * 1.001)
    assert kinds(count_errors(just, make_truth(), threshold_px=threshold)) == []
    assert len(kinds(count_errors(over, make_truth(), threshold_px=threshold))) == 1


def test_views_judge_the_points_they_track():
    tracks = make()
    tracks["image_position"][:, 1, :, 0, 0] = np.nan
    assert count_errors(tracks, make_truth()).n_labels == 600
    # unless it is said that they should have
    own = {"cam1": POINTS, "cam2": POINTS}
    report = count_errors(tracks, make_truth(), points_by_view=own)
    assert report.n_labels == 800
    assert kinds(report) == [("FR", 0, 199, "major")]


def test_tracks_made_by_hand_will_do_as_truth():
    """No column visible: every row with a position counts; frames need not all be there."""
    truth = make_truth().drop(columns="visible")
    truth = truth[truth["frame"].isin([10, 50, 120])]
    report = count_errors(make([("HR", None, 40, 60)]), truth)
    assert report.n_frames == 3
    assert report.n_labels == 12
    assert kinds(report) == [("HR", 50, 50, "minor")]


def test_corrections_are_made_where_major_errors_begin():
    """A tracker that loses FR 30 frames after each start, and HR once for 3 frames."""
    truth = make_truth()
    calls = []

    def retrack(tracks, frame):
        calls.append(frame)
        uv = tracks["image_position"][frame, 0, :, 0, 0].to_numpy()
        np.testing.assert_allclose(uv, TRUE[frame] + SHIFT[0, 0])
        assert (tracks["image_origin"][frame, :, 0, 0] == ORIGIN_CODE["edited"]).all()
        assert not (tracks["image_origin"][frame, :, 1, 0] == ORIGIN_CODE["edited"]).any()
        again = tracks.copy(deep=True)
        whole = make([("FR", None, frame + 30, N - 1), ("HR", None, 50, 52)])
        again["image_position"][frame:] = whole["image_position"][frame:]
        return again

    first = make([("FR", None, 30, N - 1), ("HR", None, 50, 52)])
    run = track_with_corrections(first, truth, retrack)
    assert calls == [30, 60, 90, 120, 150, 180]
    assert run.interventions["frame"].tolist() == calls
    assert run.interventions["point"].tolist() == ["FR"] * 6
    assert run.interventions_per_1000 == 30.0
    assert (run.report.major, run.report.minor) == (0, 1)
    # the first tracks are as they were
    assert count_errors(first, truth).major == 1


def test_corrections_stop_at_the_limit_and_where_they_do_not_help():
    truth = make_truth()
    bad = make([("FR", None, 30, N - 1)])
    run = track_with_corrections(bad, truth, lambda tracks, frame: bad)
    assert run.interventions["frame"].tolist() == [30]
    assert run.report.major == 1

    def worse(tracks, frame):
        lost = make([("FR", None, frame + 1, N - 1)])
        lost["image_position"][: frame + 1] = tracks["image_position"][: frame + 1]
        return lost

    limited = track_with_corrections(bad, truth, worse, max_interventions=4)
    assert limited.interventions["frame"].tolist() == [30, 31, 32, 33]


def test_hidden_views_are_not_corrected_with_what_nobody_can_see():
    truth = make_truth([("FR", ["cam2"], 30, 40)])
    seen = []

    def retrack(tracks, frame):
        seen.append(tracks["image_origin"][frame, :, 0, 0].to_numpy().tolist())
        return make()

    track_with_corrections(make([("FR", None, 30, N - 1)]), truth, retrack)
    assert seen == [[ORIGIN_CODE["edited"], ORIGIN_CODE["missing"]]]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            lambda t: t.assign(point="paw"),
            "tracks and truth share no visible point; compare the names of views and points and "
            "the frames of both.",
        ),
        (
            lambda t: t.assign(visible=0),
            "tracks and truth share no visible point; compare the names of views and points and "
            "the frames of both.",
        ),
        (
            lambda t: t.drop(columns="u"),
            "the truth: column 'u' is missing; expected frame, view, point, u, v, found frame, "
            "view, point, v, visible.",
        ),
    ],
)
def test_truth_that_does_not_fit_is_refused(change, message):
    with pytest.raises(InputError) as error:
        count_errors(make(), change(make_truth()))
    assert str(error.value) == message


def test_limits_must_be_above_zero():
    with pytest.raises(InputError) as error:
        count_errors(make(), make_truth(), threshold_px=0.0)
    assert str(error.value) == "threshold_px is 0.0; expected a number above 0."


def test_report_is_frozen():
    report = count_errors(make(), make_truth())
    with pytest.raises(dataclasses.FrozenInstanceError):
        report.major = 0


def test_the_report_names_limits_and_offsets():
    wrong = [("FR", None, 50, 90)]
    report = count_errors(make(wrong, offset=(3.0, 4.0)), make_truth())
    said = report.text()
    assert "major errors 1 (5.0 per 1000 frames, 95 % limit 27.9), minor 0 (0.0 per 1000" in said
    # a track that is off by the same step everywhere is off by nothing once that is removed
    assert "median distance 5.00 px" in said
    assert "with the constant offset of each track removed 0.00 px" in said
    assert "no hidden labels" in said


@pytest.mark.parametrize(("count", "most"), [(0, 3.689), (1, 5.572), (3, 8.767), (10, 18.390)])
def test_limits_of_counts_are_those_of_the_tables(count, most):
    """Two-sided 95 % limits of a Poisson count: Garwood 1936, as in Ulm 1990, table 1."""
    assert poisson_limit(count) == pytest.approx(most, abs=2e-3)


def test_limits_go_with_the_width_of_the_pictures():
    # half and a quarter of the length of a hind paw: 20 and 10 px of 2048
    assert limits_for_width(512) == (5.0, 2.5)
