"""Two filmed views of one swinging spot, one film started some frames earlier."""

import cv2
import numpy as np
import pytest

from pawnb.core.video import open_views
from pawnb.trial import load_trial
from pawnb.workflow.checking.check import check_trial
from pawnb.workflow.tracking.unsynchronised import doubt_synchronisation, may_be_unsynchronised

N = 120


def film(path, late, n=N):
    """A spot that steps from place to place at times of its own, on a grey ground with noise."""
    rng, noise = np.random.default_rng(3), np.random.default_rng(late + 10)
    at = np.cumsum(rng.choice([0.0, 0.0, 0.0, 0.0, 9.0], N + 10)) % 120.0
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), 100.0, (160, 60), False)
    for place in at[5 - late : 5 - late + n]:
        grey = noise.normal(90.0, 1.0, (60, 160))
        grey[20:40, int(place) + 10 : int(place) + 30] = 200.0
        writer.write(np.clip(grey, 0, 255).astype(np.uint8))
    writer.release()


def filmed(folder, *, offset=0, late=0, points="FR"):
    """Return a trial of both views."""
    film(folder / "side.avi", 0)
    film(folder / "top.avi", late)
    (folder / "trial.toml").write_text(
        '[trial]\nkind = "paws"\nname = "t"\nfps = 100.0\n'
        '[[views]]\nname = "side"\nvideo = "side.avi"\npoints = ["FR"]\n'
        f'[[views]]\nname = "top"\nvideo = "top.avi"\npoints = ["{points}"]\noffset = {offset}\n'
    )
    return load_trial(folder)


@pytest.mark.parametrize(("offset", "late"), [(0, 2), (3, 0), (0, -1)])
def test_an_offset_that_is_wrong_is_said_with_the_right_one(tmp_path, offset, late):
    trial = filmed(tmp_path, offset=offset, late=late)
    (said,) = [one for one in check_trial(trial).doubts if one.startswith("what moves in view")]
    assert f"set offset = {late} of view top (now {offset})" in said


@pytest.mark.parametrize(("offset", "late", "points"), [(0, 0, "FR"), (2, 2, "FR"), (0, 2, "FL")])
def test_synchronised_films_or_of_other_legs_are_not_doubted(tmp_path, offset, late, points):
    trial = filmed(tmp_path, offset=offset, late=late, points=points)
    with open_views(trial) as views:
        assert doubt_synchronisation(trial, views, start=0, stop=views.n_frames) == []


def test_tracking_looks_only_where_films_need_not_have_been_started_together(tmp_path):
    for name, offset, expected in (("plain", 0, False), ("offset", 2, True)):
        (tmp_path / name).mkdir()
        trial = filmed(tmp_path / name, offset=offset)
        with open_views(trial) as views:
            assert may_be_unsynchronised(trial, views) is expected
    film(tmp_path / "plain" / "top.avi", 0, n=N - 2)
    trial = load_trial(tmp_path / "plain")
    with open_views(trial) as views:
        assert may_be_unsynchronised(trial, views)
