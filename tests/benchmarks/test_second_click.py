"""The comparison of frames for a further click, on rows worked out by hand."""

import numpy as np
import pandas as pd
import pytest


def rows(after):
    """Three frames of a clip, each clicked before once: what is right after each of the others."""
    pairs = [(a, b) for a in (10, 20, 30) for b in (10, 20, 30) if a != b]
    table = pd.DataFrame(pairs, columns=["clicked", "frame"])
    table["after"] = [float(after[frozenset(pair)]) for pair in pairs]
    return table.assign(clip="a", clicked=table["clicked"].astype(str))


def test_correlation_and_what_choosing_gains():
    from second_click import correlation_and_lift

    score = np.array([[1.0, 2.0, 3.0], [5.0, 5.0, 0.0]])
    right = np.array([[50.0, 90.0, 70.0], [80.0, 60.0, 40.0]])
    both, lift = correlation_and_lift(score, right)
    # ranks 1 2 3 and 1 3 2: 1 - 6 * 2 / (3 * 8) = 0.5; 2.5 2.5 1 and 3 2 1: 1.5 / sqrt(1.5 * 2)
    assert both == pytest.approx((0.5 + 1.5 / np.sqrt(3.0)) / 2)
    # 70 is the mean; of the two that tie either may be chosen, 70 on average where the mean is 60
    assert lift == pytest.approx((0.0 + 10.0) / 2)
    assert correlation_and_lift(np.ones((1, 3)), right[:1]) == (0.0, 0.0)


def test_by_chance_frames_are_exchanged_and_pairs_stay_what_they_are():
    from second_click import exchanged

    found = rows({frozenset((10, 20)): 1, frozenset((10, 30)): 2, frozenset((20, 30)): 3})
    seen = set()
    for seed in range(40):
        mixed = exchanged(found, np.random.default_rng(seed))
        after = mixed.set_index(["clicked", "frame"])["after"]
        for a, b in ((10, 20), (10, 30), (20, 30)):  # a pair has one value, whichever came first
            assert after[str(a), b] == after[str(b), a]
        assert sorted(mixed["after"]) == sorted(found["after"])
        seen.add(tuple(mixed["after"]))
    assert len(seen) == 6  # all orders of three frames


def test_the_frame_named_beside_all_and_the_best():
    from second_click import by_clip

    found = rows({frozenset((10, 20)): 60, frozenset((10, 30)): 80, frozenset((20, 30)): 100})
    found = found.assign(before=50.0, gain=[2.0, 1.0, 1.0, 2.0, 0.0, 0.0])
    # named: 60 after 10, 100 after 20, and either of 80 and 100 after 30
    table = by_clip(found).set_index("clip").loc["a"]
    assert table.tolist() == ["50", "83", "80", "93"]


@pytest.mark.slow
def test_scores_know_what_was_clicked(tmp_path):
    from second_click import known_before

    from pawnb.schema import ORIGIN_CODE, add_provenance, make_tracks
    from pawnb.workflow.provenance.results import write_track_results

    (tmp_path / "trial.toml").write_text(
        '[trial]\nkind = "paws"\nname = "t"\nfps = 10.0\n[animal]\nid = "m"\n'
        '[[views]]\nname = "side"\nvideo = "side.avi"\npoints = ["FR", "HR"]\n'
    )
    tracks = make_tracks(range(100, 107), ("FR", "HR"), fps=10.0, views=["side"], space=("x", "y"))
    step = np.array([10, 10, 10, 10, 10, 20, 40])  # px from one point to the other
    for name in ("image_position", "position"):
        tracks[name][:] = 0.0
        tracks[name][..., 0, 1, 0] = step[:, None] if name == "image_position" else step
    tracks["image_origin"][:] = ORIGIN_CODE["measured"]
    tracks["image_origin"][3, :, 0] = ORIGIN_CODE["predicted"]
    start = [{"frame": 102, "view": "side", "point": p, "u": 0.0, "v": 0.0} for p in ("FR", "HR")]
    tracks = add_provenance(
        tracks, step="track", method="pawnb", settings={}, inputs={}, start=start
    )
    write_track_results(tracks, tmp_path / "results")
    known = known_before(tmp_path)
    assert known.index.tolist() == list(range(100, 107))
    assert known["time"].tolist() == [2, 1, 0, 1, 2, 3, 4]
    # of 104: 103 to 106 are 1, 2, 3 and 4 frames from 102, and 1, 0, 1 and 2 from 104
    assert known.loc[104, "medians"] == 0 + 2 + 2 + 2
    # points are half their distance from their mean, and the usual half is 5 px
    assert known["pose"].tolist() == pytest.approx([0, 0, 0, 0, 0, 1, 3])
    assert known.loc[105, "pose medians"] == pytest.approx(1 + (3 - 2))
    assert known["seen"].tolist() == [2, 2, 2, 1, 2, 2, 2]
