"""What DeepLabCut 3 writes for an animal that it did not find."""

import numpy as np
import pandas as pd
import pytest

from pawnb.io import read_deeplabcut, write_deeplabcut


@pytest.mark.parametrize("filled", [-1.0, 0.0])
@pytest.mark.parametrize("ending", [".csv", ".h5"])
def test_an_animal_that_was_filled_up_is_missing(tmp_path, filled, ending):
    """-1: ``PadOutputs(pad_value=-1)`` of its postprocessor.py; 0: ``create_df_from_prediction`` of
    its analyze_videos.py. As points these -1 came out of a conversion, with no likelihood to tell
    them by."""
    columns = pd.MultiIndex.from_product(
        [["superanimal_quadruped_hrnet_w32"], ["animal_0", "animal_1"],
         ["front_left_paw", "back_left_paw"], ["x", "y", "likelihood"]],
        names=["scorer", "individuals", "bodyparts", "coords"],
    )  # fmt: skip
    values = np.full((3, 2, 2, 3), 0.5)
    values[..., :2] = np.arange(24.0).reshape(3, 2, 2, 2)  # the first point lies at (0, 1)
    values[1, 0] = filled
    values[:, 1] = filled
    values[2, 0, 0] = (0.0, 0.0, 0.4)  # found, in the corner
    table = pd.DataFrame(values.reshape(3, -1), columns=columns)
    path = tmp_path / f"m1{ending}"
    if ending == ".csv":
        table.to_csv(path)
    else:
        pytest.importorskip("tables")
        table.to_hdf(path, key="df_with_missing", format="table")
    tracks = read_deeplabcut(path, fps=100.0)
    seen = np.isfinite(tracks["position"].to_numpy()).all(axis=1)  # time, point, animal
    assert seen[..., 0].tolist() == [[True, True], [False, False], [True, True]]
    assert not seen[..., 1].any()
    assert tracks["confidence"].to_numpy()[1, 0, 0] == 0.0


@pytest.mark.parametrize("ending", [".csv", ".h5"])
def test_points_that_are_there_once_are_written_back_as_they_were(tmp_path, ending):
    """DeepLabCut's unique bodyparts are those of an animal 'single'; each animal got columns of
    them, and 'single' columns of the paws."""
    who = [("m1", "FR"), ("m1", "HR"), ("m2", "FR"), ("m2", "HR"), ("single", "box")]
    columns = pd.MultiIndex.from_tuples(
        [("net", *one, coord) for one in who for coord in ("x", "y", "likelihood")],
        names=["scorer", "individuals", "bodyparts", "coords"],
    )
    values = np.random.default_rng(1).uniform(0.1, 0.9, (4, len(columns)))
    values[:, 3:6] = np.nan  # m1 HR, which was never found
    table = pd.DataFrame(values, columns=columns)
    if ending == ".csv":
        table.to_csv(tmp_path / "m.csv")
    else:
        pytest.importorskip("tables")
        table.to_hdf(tmp_path / "m.h5", key="df_with_missing", format="table")
    tracks = read_deeplabcut(tmp_path / f"m{ending}", fps=100.0)
    path = write_deeplabcut(tracks, tmp_path / f"again{ending}")
    if ending == ".csv":
        again = pd.read_csv(path, header=[0, 1, 2, 3], index_col=0)
    else:
        again = pd.read_hdf(path)
    assert again.columns.tolist() == table.columns.tolist()
    expected = values.copy()
    expected[:, 5] = again.to_numpy()[:, 5]
    np.testing.assert_array_equal(again.to_numpy(), expected)
    called = tracks.assign_coords(keypoint=["FL", "HL", "crate"])
    write_deeplabcut(called, tmp_path / "b.csv")
    assert read_deeplabcut(tmp_path / "b.csv", fps=100.0)["keypoint"].to_numpy().tolist() == [
        "FL", "HL", "crate",
    ]  # fmt: skip
