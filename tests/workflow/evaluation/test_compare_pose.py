"""Methods on a jointed animal: the measures are those of evaluating each method's tracks."""

from __future__ import annotations

import dataclasses

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from pawnb.errors import InputError
from pawnb.trial import load_trial
from pawnb.workflow.evaluation import compare_pose
from pawnb.workflow.evaluation.compare import compare_methods
from pawnb.workflow.evaluation.compare_pose import (
    POSE_COMPARISON_COLUMNS,
    POSE_SUMMARY_COLUMNS,
    compare_pose_methods,
)
from pawnb.workflow.tracking.track import track


@pytest.fixture(scope="module")
def tracked(rendered_spider):
    return track(rendered_spider, frames=(10, 14), progress=lambda done, total: None)


@pytest.mark.slow
def test_each_method_has_the_errors_of_its_tracks(tracked, rendered_spider, tmp_path, monkeypatch):
    """Method "paper" is given tracks that are 3 px to the right and 4 px down: 5 px off."""

    def shifted(_trial, *, method, **_):
        off = xr.DataArray([3.0, 4.0], dims="image_space") if method == "paper" else 0.0
        moved = (tracked["image_position"] + off).transpose(*tracked["image_position"].dims)
        return tracked.assign(image_position=moved)

    monkeypatch.setattr(compare_pose, "track", shifted)
    two = [
        dataclasses.replace(load_trial(rendered_spider), name=name, folder=rendered_spider)
        for name in ("a", "b")
    ]
    made = compare_pose_methods(two, out=tmp_path)
    assert tuple(pd.read_csv(tmp_path / "comparison.csv").columns) == POSE_COMPARISON_COLUMNS
    assert tuple(pd.read_csv(tmp_path / "comparison_summary.csv").columns) == POSE_SUMMARY_COLUMNS
    rows = made.summary.set_index(["method", "measure"])
    assert rows.loc[("pawnb", "body error, RMS"), "mean"] < 1.0
    # what the first method is off by stays within those 5 px
    assert rows.loc[("paper", "body error, RMS"), "mean"] == pytest.approx(5.0, abs=1.0)
    assert rows.loc[("paper", "body error, RMS"), "n_trials"] == 2
    assert rows.loc[("paper", "body error, RMS"), "sd"] == pytest.approx(0.0, abs=1e-9)
    assert rows.loc[("pawnb", "frames"), "mean"] == 4
    assert np.isfinite(rows.loc[("pawnb", "time"), "mean"])
    assert "paper: 2 trials" in made.text()


def test_kinds_are_not_mixed_and_settings_are_known(rendered_spider, small_trial):
    with pytest.raises(InputError, match="is of kind 'paws', others are of kind 'pose'; compare"):
        compare_pose_methods([rendered_spider, small_trial])
    with pytest.raises(InputError, match="is of kind 'pose'; expected kind 'paws', or every trial"):
        compare_methods([rendered_spider])
    with pytest.raises(InputError, match=r"unknown method 'slic-3d'; expected pawnb, paper\."):
        compare_pose_methods([rendered_spider], methods=["slic-3d"])
    with pytest.raises(
        InputError, match=r"method paper has no setting 'isin' \(did you mean 'ising'"
    ):
        compare_pose_methods([rendered_spider], settings={"paper.isin": 1})
