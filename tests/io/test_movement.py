"""movement reads our file and we read its, in both spellings of its dimensions.

movement writes a log into HOME, replaces ``warnings.showwarning`` and changes options of
xarray when it is imported; the fixture keeps all of that away from other tests.
"""

from __future__ import annotations

import importlib
import warnings

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from pawnb.errors import InputError, InputWarning
from pawnb.io.formats import load_tracks
from pawnb.io.movement import from_movement, is_movement, to_movement, write_movement
from pawnb.io.native import read_tracks, write_tracks
from pawnb.schema import ORIGIN_CODE, absent_frames, make_tracks


@pytest.fixture(scope="module")
def movement(tmp_path_factory):
    """The installed movement (seconds to import), imported with HOME in a temporary folder."""
    options = {"keep_attrs": xr.get_options()["keep_attrs"],
               "display_expand_data": xr.get_options()["display_expand_data"]}  # fmt: skip
    with pytest.MonkeyPatch.context() as patch, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        home = tmp_path_factory.mktemp("home")
        for name in ("HOME", "USERPROFILE", "XDG_CACHE_HOME"):
            patch.setenv(name, str(home))
        module = pytest.importorskip("movement")
        for part in ("filtering", "io.load_poses", "kinematics", "validators.datasets"):
            importlib.import_module(f"movement.{part}")
        yield module
        module.utils.logging.logger.remove()
    xr.set_options(**options)


def spellings(movement):
    """Return how this release names keypoints and individuals, and how it does not."""
    names = movement.validators.datasets.ValidPosesInputs.DIM_NAMES
    return ("plural", "singular") if "keypoints" in names else ("singular", "plural")


def example(n=40):
    """Two points that move on parabolas in space, 250 frames a second; FL is lost in frame 5."""
    tracks = make_tracks(
        np.arange(100, 100 + n), ["FR", "FL"], fps=250.0, views=["cam1"], unit="mm"
    )
    t = tracks["time"].to_numpy()
    xyz = np.stack([np.c_[350 * t, 5 + 0 * t, 40 * t**2], np.c_[-10 * t, t, 3 * t**2]], axis=2)
    tracks["position"].to_numpy()[..., 0] = xyz
    tracks["confidence"].to_numpy()[:] = 0.9
    tracks["origin"].to_numpy()[:] = ORIGIN_CODE["measured"]
    tracks["position"].to_numpy()[5, :, 1] = np.nan
    tracks["origin"].to_numpy()[5, 1] = ORIGIN_CODE["missing"]
    tracks["confidence"].to_numpy()[5, 1] = 0.0
    return tracks


# --- with movement itself -----------------------------------------------------------------------


@pytest.mark.slow
def test_movement_accepts_our_file(movement, tmp_path):
    tracks = example()
    path = write_tracks(tracks, tmp_path / "tracks.nc")
    dims = spellings(movement)[0]
    dataset = to_movement(xr.load_dataset(path, engine="h5netcdf"), dims=dims)
    movement.validators.datasets.ValidPosesInputs.validate(dataset)
    velocity = movement.kinematics.compute_velocity(dataset["position"])
    expected = np.gradient(tracks["position"].to_numpy(), tracks["time"].to_numpy(), axis=0)
    np.testing.assert_allclose(velocity.to_numpy(), expected, rtol=1e-6)
    # FR runs at 350 mm/s along x by construction
    np.testing.assert_allclose(velocity.to_numpy()[:, 0, 0, 0], 350.0, rtol=1e-6)
    confident = movement.filtering.filter_by_confidence(
        dataset["position"], dataset["confidence"], threshold=0.95
    )
    assert np.isnan(confident).all()
    whole = movement.filtering.interpolate_over_time(dataset["position"])
    assert np.isfinite(whole).all()


@pytest.mark.slow
def test_movement_refuses_what_it_cannot_read(movement):
    # the perturbed twin of the test above: its validation does look
    other = to_movement(example(), dims=spellings(movement)[1])
    with pytest.raises(ValueError, match=r"(?i)dim"):
        movement.validators.datasets.ValidPosesInputs.validate(other)


@pytest.mark.slow
def test_we_read_what_movement_saves(movement, tmp_path):
    rng = np.random.default_rng(0)
    position = rng.normal(size=(20, 2, 3, 2))
    position[4, :, 1, 0] = np.nan
    confidence = rng.random((20, 3, 2))
    dataset = movement.io.load_poses.from_numpy(
        position, confidence, individual_names=["a", "b"], keypoint_names=["nose", "FR", "FL"],
        fps=50.0,
    )  # fmt: skip
    dataset.attrs["source_software"] = "numpy"
    dataset.to_netcdf(tmp_path / "m.nc", engine="h5netcdf")
    tracks = read_tracks(tmp_path / "m.nc")
    np.testing.assert_array_equal(tracks["position"], position)
    np.testing.assert_array_equal(tracks["frame"], np.arange(20))
    assert tracks["keypoint"].to_numpy().tolist() == ["nose", "FR", "FL"]
    assert tracks["individual"].to_numpy().tolist() == ["a", "b"]
    missing = tracks["origin"].to_numpy() == ORIGIN_CODE["missing"]
    assert np.argwhere(missing).tolist() == [[4, 1, 0]]
    np.testing.assert_array_equal(tracks["confidence"].to_numpy()[~missing], confidence[~missing])
    assert (tracks["confidence"].to_numpy()[missing] == 0).all()
    assert tracks.attrs["source_software"] == "numpy"
    write_tracks(tracks, tmp_path / "tracks.nc")
    xr.testing.assert_identical(read_tracks(tmp_path / "tracks.nc"), tracks)


@pytest.mark.slow
def test_deeplabcut_through_movement(movement, real_data, tmp_path):
    # the same clip as csv and h5 must give the same tracks; read here from its csv
    file = real_data("mouse-openfield-dlc") / "raw_clip1DLC.csv"
    dataset = movement.io.load_poses.from_dlc_file(file, fps=60.0).isel(time=slice(0, 200))
    dataset.attrs = {k: str(v) if k == "source_file" else v for k, v in dataset.attrs.items()}
    dataset.to_netcdf(tmp_path / "dlc.nc", engine="h5netcdf")
    tracks = read_tracks(tmp_path / "dlc.nc")
    raw = pd.read_csv(file, skiprows=3, header=None, nrows=200).to_numpy()[:, 1:].reshape(200, 6, 3)
    np.testing.assert_allclose(
        tracks["position"].to_numpy()[..., 0], raw[..., :2].transpose(0, 2, 1)
    )
    np.testing.assert_allclose(tracks["confidence"].to_numpy()[..., 0], raw[..., 2])
    assert tracks["keypoint"].to_numpy()[1] == "Front Paw R"
    assert tracks.attrs["fps"] == 60.0
    np.testing.assert_array_equal(tracks["frame"], np.arange(200))


# --- both spellings, without it -------------------------------------------------------------------


@pytest.mark.parametrize("dims", ["plural", "singular"])
def test_tracks_survive_a_journey_through_movement(dims, tmp_path):
    tracks = example()
    dataset = to_movement(tracks, dims=dims)
    s = "s" if dims == "plural" else ""
    assert dataset["position"].dims == ("time", "space", f"keypoint{s}", f"individual{s}")
    assert tracks["position"].dims == ("time", "space", "keypoint", "individual")
    xr.testing.assert_identical(from_movement(dataset), tracks)
    dataset.to_netcdf(tmp_path / "m.nc", engine="h5netcdf")
    xr.testing.assert_identical(read_tracks(tmp_path / "m.nc"), tracks)


@pytest.mark.parametrize("unit", ["cm", "m"])
def test_the_unit_of_places_in_space_is_written(tmp_path, unit):
    tracks = make_tracks(np.arange(3), ["FR"], fps=50.0, unit=unit)
    tracks["position"].data[:] = 1.25
    tracks["origin"].data[:] = ORIGIN_CODE["measured"]
    again = read_tracks(write_movement(tracks, tmp_path / "poses.nc"))
    assert again.attrs["units"] == unit
    np.testing.assert_array_equal(again["position"], tracks["position"])


def poses(dims=("keypoints", "individuals"), *, time=None, **attrs):
    """A poses dataset as movement makes it: 4 frames, 2 points, 1 animal."""
    time = np.arange(4) / 50 if time is None else time
    return xr.Dataset(
        {"position": (("time", "space", *dims), np.arange(16.0).reshape(4, 2, 2, 1))},
        coords={"time": time, "space": ["x", "y"], dims[0]: ["FR", "FL"], dims[1]: ["id_0"]},
        attrs={"ds_type": "poses", "fps": 50.0, "time_unit": "seconds", **attrs},
    )


@pytest.mark.parametrize("dims", [("keypoints", "individuals"), ("keypoint", "individual")])
def test_both_spellings_are_read(dims):
    dataset = poses(dims)
    assert is_movement(dataset)
    tracks = from_movement(dataset)
    np.testing.assert_array_equal(tracks["position"], dataset["position"])
    assert (tracks["origin"] == ORIGIN_CODE["measured"]).all()
    assert np.isnan(tracks["confidence"]).all()  # not given, so not invented
    assert not is_movement(tracks)


def test_times_become_frames():
    seconds = from_movement(poses(time=np.array([0.2, 0.22, 0.24, 0.3])))
    assert seconds["frame"].to_numpy().tolist() == [10, 11, 12, 13, 14, 15]
    # the frames between 0.24 s and 0.3 s are not in the dataset
    assert (seconds["origin"].to_numpy()[3:5] == ORIGIN_CODE["missing"]).all()
    assert absent_frames(seconds) == [(13, 14, "this dataset")]
    frames = from_movement(poses(time=np.array([3, 4, 5, 6]), time_unit="frames"))
    assert frames["frame"].to_numpy().tolist() == [3, 4, 5, 6]
    np.testing.assert_allclose(frames["time"], [0.06, 0.08, 0.1, 0.12])
    with pytest.raises(InputError, match=r"^d: times fall between frames at 50 frames per second"):
        from_movement(poses(time=np.array([0, 0.02, 0.05, 0.08])), where="d")


def test_a_frame_rate_must_come_from_somewhere():
    dataset = poses(time=np.arange(4), time_unit="frames")
    del dataset.attrs["fps"]
    with pytest.raises(InputError, match=r"^d: no frame rate; give fps"):
        from_movement(dataset, where="d")
    assert from_movement(dataset, fps=200.0).attrs["fps"] == 200.0


def test_several_views_become_image_positions():
    views = xr.concat([poses(), poses() + 100], dim="view").assign_coords(view=["l", "r"])
    views.attrs = poses().attrs
    tracks = from_movement(views)
    np.testing.assert_array_equal(
        tracks["image_position"].sel(view="r"), poses()["position"].to_numpy() + 100
    )
    assert (tracks["image_origin"] == ORIGIN_CODE["measured"]).all()
    assert (tracks["origin"] == ORIGIN_CODE["missing"]).all()


def test_the_log_of_movement_is_kept():
    tracks = from_movement(poses(log='[{"operation": "savgol_filter"}]'))
    assert "savgol_filter" in tracks.attrs["provenance"]


def test_what_holds_no_poses_is_refused():
    with pytest.raises(InputError, match=r"^d: not a poses dataset"):
        from_movement(poses(ds_type="bboxes"), where="d")
    with pytest.raises(InputError, match=r"^d: position has dimensions \('time', 'space', 'indi"):
        from_movement(poses().isel(keypoints=0, drop=True), where="d")
    with pytest.raises(InputError, match="expected 'plural' or 'singular'"):
        to_movement(example(), dims="both")


def bare(dims=("x", "y"), *, time=None, **attrs):
    """A dataset as movement makes it: point FR along x = frame, y = -frame."""
    n = np.arange(4.0)
    values = {"x": n, "y": -n, "z": 0 * n}
    return xr.Dataset(
        {"position": (("time", "space", "keypoints", "individuals"),
                      np.stack([values[d] for d in dims], axis=1)[:, :, None, None])},
        coords={"time": n / 100.0 if time is None else time, "space": list(dims),
                "keypoints": ["FR"], "individuals": ["m1"]},
        attrs={"ds_type": "poses", "fps": 100.0, **attrs},
    )  # fmt: skip


def test_positions_in_space_without_a_unit_are_no_pixels_and_that_is_said(tmp_path):
    with pytest.warns(InputWarning, match="taken to be in mm"):
        assert from_movement(bare("xyz")).attrs["units"] == "mm"
    assert from_movement(bare("xyz", units="cm")).attrs["units"] == "cm"
    assert from_movement(bare("xy")).attrs["units"] == "px"
    bare("xyz").to_netcdf(tmp_path / "poses.nc", engine="h5netcdf")
    assert load_tracks(tmp_path / "poses.nc", unit="m").attrs["units"] == "m"
    assert read_tracks(tmp_path / "poses.nc", unit="m").attrs["units"] == "m"


def test_axes_are_read_by_their_names_and_not_by_their_order():
    # a point at x = frame is there in whichever order an array of pictures has its axes
    tracks = from_movement(bare("yx"))
    assert tracks["space"].to_numpy().tolist() == ["x", "y"]
    assert tracks["position"].to_numpy()[:, 0].ravel().tolist() == [0.0, 1.0, 2.0, 3.0]


def test_an_animal_that_was_selected_is_read_without_its_dimension():
    one = bare().isel(individuals=0)
    assert from_movement(one)["individual"].to_numpy().tolist() == ["m1"]
    assert from_movement(one.drop_vars("individuals"))["individual"].to_numpy().tolist() == [
        "animal"
    ]


def test_whole_times_are_frames_where_the_unit_of_time_was_lost():
    lost = bare(time=np.arange(4))
    assert from_movement(lost)["frame"].to_numpy().tolist() == [0, 1, 2, 3]
    assert from_movement(bare())["frame"].to_numpy().tolist() == [0, 1, 2, 3]


def test_a_unit_of_time_that_movement_has_not_is_refused():
    with pytest.raises(InputError, match=r"time_unit is 'milliseconds'; expected 'seconds' or"):
        from_movement(bare(time=np.arange(4) * 10.0, time_unit="milliseconds"))


def test_lengths_whose_unit_is_said_are_brought_to_the_one_given():
    dataset = bare("xyz", units="cm")
    tracks = from_movement(dataset, unit="mm")
    assert tracks.attrs["units"] == "mm"
    in_cm = from_movement(dataset)["position"]
    assert np.isfinite(in_cm).any()
    np.testing.assert_allclose(tracks["position"], 10.0 * in_cm)


def test_the_rate_that_is_given_goes_before_that_of_a_film_that_plays_slowed_down():
    # filmed with 250 frames a second, kept by movement with the 25 or 24 of its video
    for said in (25.0, 24.0):
        slow = bare(time=np.arange(4) / said, fps=said)
        with pytest.warns(InputWarning, match=f"says {said:g} frames .* fps is given as 250"):
            tracks = from_movement(slow, fps=250.0, where="d")
        assert tracks["frame"].to_numpy().tolist() == [0, 1, 2, 3]
        assert tracks["time"].to_numpy().tolist() == [0.0, 0.004, 0.008, 0.012]
        assert tracks["position"].to_numpy()[:, 0].ravel().tolist() == [0.0, 1.0, 2.0, 3.0]


def test_axes_that_are_neither_a_picture_nor_space_are_refused():
    # of a dataset in space, ds.sel(space=["x", "z"]) was a picture in px, whose v points down
    with pytest.raises(InputError, match=r"^d: axes are x, z; expected x and y of a picture, or"):
        from_movement(bare("xz"), where="d")


def test_times_of_the_clock_of_a_session_begin_with_frame_0():
    late = bare(time=np.arange(4) / 100.0 + 12.3456)
    assert from_movement(late)["frame"].to_numpy().tolist() == [0, 1, 2, 3]
    gap = bare(time=np.array([0.0, 0.01, 0.03, 0.04]) + 12.3456)
    assert from_movement(gap)["frame"].to_numpy().tolist() == [0, 1, 2, 3, 4]
    with pytest.raises(InputError, match="times fall between frames at 100 frames per second"):
        from_movement(bare(time=np.array([0.0, 0.01, 0.025, 0.03]) + 12.3456))
