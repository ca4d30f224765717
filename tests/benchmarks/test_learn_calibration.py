"""How the weights of signs are learnt, from labels that were drawn by known ones."""

import numpy as np
import pandas as pd
import pytest
from scipy.special import expit

NOTHING = pd.DataFrame({"recording": [], "clip": [], "clicks": [], "point": [], "right": []})


def drawn(motion_weight, broken_weight, offset, n=4000):
    """Labels of two clips whose chance of being right follows from known weights."""
    rng = np.random.default_rng(0)
    motion, broken = rng.uniform(0, 3, n), rng.uniform(0, 5, n)
    chance = expit(motion_weight * motion + broken_weight * broken + offset)
    return pd.DataFrame({
        "recording": ["a", "b"] * (n // 2), "clip": ["a", "b"] * (n // 2),
        "clicks": 1, "point": 0, "ok": rng.random(n) < chance,
        "probability": 1.0, "motion_along": motion, "look": 0.0,
        "other_look": 0.0, "broken": broken, "name_share": 0.0, "usual_look": 0.0, "left_out": 0.0,
        "off_u": 0.0, "off_v": 0.0,
        "sd_px": 1.0, "extent": 100.0,
    })  # fmt: skip


def test_weights_that_made_labels_are_found(monkeypatch):
    import learn_calibration

    monkeypatch.setattr(learn_calibration, "CELL_WEIGHT", 2000.0)
    weights, offset = learn_calibration.learn(drawn(0.8, -0.5, 0.3), NOTHING)
    known = {"motion_along": 0.8, "broken": -0.5}
    expected = [known.get(sign, 0.0) for sign in learn_calibration.SIGNS]
    np.testing.assert_allclose(weights, expected, atol=0.12)
    assert offset == pytest.approx(0.3 - learn_calibration.STRICTER, abs=0.25)


def test_a_sign_never_counts_against_its_meaning():
    import learn_calibration

    weights, _ = learn_calibration.learn(drawn(-0.8, -0.5, 0.3), NOTHING)
    by_sign = dict(zip(learn_calibration.SIGNS, weights, strict=True))
    assert by_sign["motion_along"] == pytest.approx(0, abs=1e-9)
    assert by_sign["broken"] < -0.3


@pytest.mark.slow
def test_a_clip_is_judged_by_weights_of_the_others(capsys):
    """In one clip labels that flow reaches are right, in the other wrong."""
    import learn_calibration

    labels = drawn(0.0, 0.0, 0.0)
    labels["ok"] = (labels["motion_along"] > 1.5) == (labels["clip"] == "a")
    learn_calibration.report(labels, NOTHING)
    shown = capsys.readouterr().out.splitlines()
    auroc = [row.split("|")[8].strip() for row in shown[2:4]]
    # "b" teaches that motion says nothing, "a" that it says all: of "b" it says the opposite
    assert float(auroc[0]) == pytest.approx(0.5, abs=0.1)
    assert float(auroc[1]) == pytest.approx(0.0, abs=0.01)


def test_what_left_out_clicks_say_goes_to_marks_of_their_clip_and_point():
    """Where odds are even by signs: found, not found, and nothing left out."""
    import learn_calibration

    marks = drawn(0.0, 0.0, 0.0, n=6).assign(point=[0, 0, 1, 1, 2, 2])
    clicks = pd.DataFrame({
        "clip": "a", "clicks": 1, "point": [0, 1], "right": [True, False],
        **dict.fromkeys(learn_calibration.SIGNS, 0.0),
    })  # fmt: skip
    said = learn_calibration.heard(marks, clicks, np.zeros(len(learn_calibration.SIGNS)), 0.0)[
        "left_out"
    ]
    assert said[0] > 0.1
    assert said[2] < -0.1
    assert (said[[1, 3, 4, 5]] == 0).all()


@pytest.mark.slow
def test_clips_of_one_film_are_not_judged_by_each_other(capsys):
    """In "a", two clips of it, labels that flow reaches are right; in "b" they are wrong."""
    import learn_calibration

    labels = drawn(0.0, 0.0, 0.0)
    labels["ok"] = (labels["motion_along"] > 1.5) == (labels["recording"] == "a")
    first = (labels["recording"] == "a") & (np.arange(len(labels)) < 2000)
    labels["clip"] = labels["clip"].mask(first, "a2")
    learn_calibration.report(labels, NOTHING)
    shown = capsys.readouterr().out.splitlines()
    auroc = [float(row.split("|")[8]) for row in shown[2:4]]
    # "b" teaches that motion says nothing; the other clip of the film would say all
    assert auroc == pytest.approx([0.5, 0.5], abs=0.1)


def test_gain_of_doubt_is_counted_in_wrong_marks_and_drawn_over_recordings():
    """By hand: of 4 wrong marks 2 more are doubted and 1 less; a: 2 of 2, b: -1 of 2."""
    import learn_calibration

    labels = pd.DataFrame({"recording": list("aabbb"), "ok": [False] * 4 + [True]})
    now, before = (np.array(one, bool) for one in ([1, 1, 0, 0, 1], [0, 0, 1, 0, 0]))
    said = learn_calibration.gained(labels, now, before)
    assert said.endswith("25.0 in a hundred (-50.0 to 100.0)")
