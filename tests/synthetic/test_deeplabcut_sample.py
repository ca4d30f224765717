"""The sample of DeepLabCut tracks is read as such, and its truth is recovered."""

import re

import numpy as np
import pandas as pd
import pytest

from pawnb.errors import InputError
from pawnb.gait import analyse
from pawnb.io.formats import read_any_tracks, recognise_format
from pawnb.synthetic.deeplabcut_sample import BELT_PX_S, FPS, write_deeplabcut_sample


@pytest.mark.slow
def test_truth_is_recovered_from_the_csv(tmp_path):
    paths = write_deeplabcut_sample(tmp_path, animals=2)
    truth = pd.read_csv(tmp_path / "truth.csv").set_index("animal")
    for path in paths:
        assert recognise_format(path) == "deeplabcut"
        tables = analyse(read_any_tracks(path, fps=FPS))
        own = truth.loc[path.stem.removesuffix("DLC")]  # as the animal is read from the name
        assert tables.strides["period_s"].mean() == pytest.approx(own["period_s"], rel=0.01)
        contact = tables.strides["contact_duty_factor"].mean()
        assert contact == pytest.approx(own["contact_duty_factor"], abs=0.06)
        lags = tables.phase_summary.set_index(["leg", "reference"])["mean"]
        for leg, reference in (("FL", "FR"), ("HL", "HR"), ("FR", "HR")):
            expected = (own[f"phase_{leg}"] - own[f"phase_{reference}"]) % 1.0
            off = (lags[leg, reference] - expected + 0.5) % 1.0 - 0.5
            assert abs(off) < 0.02
        # no belt speed was given: it is told from the feet in stance
        (told,) = [
            n for note in tables.notes for n in re.findall(r"belt speed about (\S+) px/s", note)
        ]
        assert float(told) == pytest.approx(BELT_PX_S, rel=0.03)


def test_the_same_seed_gives_the_same_bytes(tmp_path):
    one = write_deeplabcut_sample(tmp_path / "a", animals=1)[0].read_bytes()
    assert write_deeplabcut_sample(tmp_path / "b", animals=1)[0].read_bytes() == one
    assert write_deeplabcut_sample(tmp_path / "c", animals=1, seed=1)[0].read_bytes() != one
    with pytest.raises(InputError, match="at least one animal"):
        write_deeplabcut_sample(tmp_path, animals=0)


def test_lost_points_have_a_low_likelihood(tmp_path):
    tracks = read_any_tracks(write_deeplabcut_sample(tmp_path, animals=1)[0], fps=FPS)
    across = tracks["position"].sel(keypoint="snout", space="y").to_numpy().ravel()
    sure = tracks["confidence"].sel(keypoint="snout").to_numpy().ravel()
    jumps = np.abs(across - np.median(across)) > 15
    assert (sure[jumps] < 0.5).all()
