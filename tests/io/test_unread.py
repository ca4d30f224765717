"""Files of programs that are not read are named, with the way to one that is."""

import re
import zipfile

import h5py
import numpy as np
import pandas as pd
import pytest
from scipy.io import savemat

from pawnb.errors import InputError
from pawnb.io import read_any_tracks, recognise_format
from pawnb.workflow.gait.sources import read_source

# the beginnings of files as these programs write them
TEXTS = {
    "clip_keypoints.json": ('{"version":1.3,"people":[{"pose_keypoints_2d":[1.0]}]}', "OpenPose"),
    "mmpose.json": ('{"meta_info":{},"instance_info":[{"frame_id":1}]}', "MMPose"),
    "ls.json": ('[{"data": {}, "annotations": [{"result": []}]}]', "Label Studio, .*; write its"),
    "coco.json": ('{"images": [{"file_name": "a.png"}], "annotations": []}', "COCO.*--from coco"),
    # FormMultiTrajectoryAnalysis.cs and CSVHelper.cs of Kinovea; a spreadsheet of a user
    "kinematics.csv": ('"Time (ms)","FR","HR"\n"0","1.0","2.0"\n', "kinematics.*name its .kva"),
    "kinovea.xml": (
        '<?xml version="1.0" encoding="utf-8"?><?mso-application progid="Excel.Sheet"?><Workbook>',
        "as Kinovea exports for Excel.*name the .kva",
    ),
    "tracker.txt": ("\tmass_A\t\nt\tv\t\n0.0\t1.2\t\n", "Tracker without x and y"),
    "edges.csv": ("LABEL,TRACK_ID,SPOT_SOURCE_ID,SPOT_TARGET_ID\n", "TrackMate.*table of spots"),
    "results.csv": (" ,Area,Mean,Min,Max,X,Y,Slice\n1,0,9,9,9,5,6,1\n", "ImageJ.*Manual Tracking"),
    "ik.mot": ("Coordinates\nversion=1\nnRows=2\ninDegrees=yes\nendheader\ntime\n", "trc"),
    "points.csv": ("frame_idx,node,x,y,track\n0,FR,1,2,m1\n", 'format="sleap"'),
    "videos.csv": ("frame_idx,video_path,inst0.track,inst0.FR.x\n0,a.mp4,m1,1\n", "laid out by"),
    "frames.csv": ("frame_idx,inst0.track,inst0.FR.x,inst0.FR.y\n0,m1,1,2\n", 'format="sleap"'),
    # simba 5.6.1, idtracker.ai 6, TRex 1.9, ImageJ 1.54, keypoint-moseq 0.4, B-SOiD 1.5.1,
    # aniposelib 0.8
    "idtracker.json": ('{"trajectories": [[[1.0, 2.0]]]}', "idtracker.ai.* needs its feet"),
    "fish0.csv": ("frame,time,X#wcentroid (cm),Y#wcentroid (cm),poseX0\n0,0,1,2,3\n", "TRex"),
    "moseq.csv": ("syllable,centroid x,centroid y,heading\n0,1,1,0\n", "keypoint-moseq.*tracks"),
    "motive.csv": ("Format Version,1.23,Take Name,T1\n\n,Type,Marker\n", "Motive.* export .c3d"),
    "a_xyzres.csv": ("pt1_dltres,pt2_dltres\n1.0,1.0\n", "DLTdv.* name the xypts"),
    "a_offsets.csv": ("cam1_offset,cam2_offset\n0,0\n", "DLTdv.* name the xypts"),
    "simba.csv": (
        ",IMPORTED_POSE,IMPORTED_POSE\n,IMPORTED_POSE,IMPORTED_POSE\n,FR_x,FR_y\n0,1,2\n",
        "SimBA.*outlier_corrected",
    ),
    "long.csv": ("frame,bodypart,x,y\n0,FR,1.0,2.0\n", "a row for each point.*table.pivot"),
    # predict3D.py and predict2D.py of JARVIS-HybridNet: create_header
    "data3D.csv": (
        "FR,FR,FR,FR,HR,HR,HR,HR\nx,y,z,confidence,x,y,z,confidence\n1,2,3,1,4,5,6,1\n",
        "JARVIS.*header=",
    ),
    "data2D.csv": ("FR,FR,FR\nx,y,confidence\n1,2,1\n", "JARVIS.*index_label='frame'"),
    "bsoid.csv": (",B-SOiD labels\n0,0\n", "B-SOiD.*name the tracks"),
    "calibration.toml": ('[cam_0]\nname = "cam0"\nsize = [ 800, 600,]\n', "TOML.*calibration"),
    "idtracker.csv": ("time,x1,y1,x2,y2\n0.0,1,2,3,4\n", "idtracker.ai.* needs its feet"),
}


@pytest.mark.parametrize("name", TEXTS)
def test_a_text_of_another_program_is_named(tmp_path, name):
    text, message = TEXTS[name]
    (tmp_path / name).write_text(text)
    with pytest.raises(InputError, match=rf"^{name}: .*, not read here; ") as caught:
        recognise_format(tmp_path / name)
    assert caught.match(message)
    assert "\n" not in str(caught.value)


def test_spreadsheets_and_arrays_are_named(tmp_path):
    with zipfile.ZipFile(tmp_path / "AutoGaita.xlsx", "w") as file:
        file.writestr("xl/workbook.xml", "<workbook/>")
    np.savez(tmp_path / "fish0.npz", X=np.zeros(3))
    np.save(tmp_path / "trajectories.npy", np.zeros((3, 1, 2)))
    (tmp_path / "clip.pickle").write_bytes(b"\x80\x04\x95\x00")
    told = {
        "AutoGaita.xlsx": "a spreadsheet", "fish0.npz": "TRex", "trajectories.npy": "NumPy",
        "clip.pickle": "may run programs",
    }  # fmt: skip
    for name, message in told.items():
        with pytest.raises(InputError, match=f"{name}: .*{message}.*, not read here; .* csv"):
            recognise_format(tmp_path / name)
    with pytest.raises(InputError, match=r"; of DeepLabCut, name the \.h5 or \.csv of the same vi"):
        recognise_format(tmp_path / "clip.pickle")


@pytest.mark.parametrize(
    ("names", "message"),
    [(("poseest/points",), "JABS.*--from jabs"), (("trajectories",), "idtracker.ai"),
     (("annotations", "skeleton"), "DeepPoseKit"), (("a/syllable",), "keypoint-moseq")],
)  # fmt: skip
def test_hdf5_of_another_program_is_named(tmp_path, names, message):
    with h5py.File(tmp_path / "clip.h5", "w") as file:
        for name in names:
            file[name] = np.zeros(3)
    with pytest.raises(InputError, match=message):
        recognise_format(tmp_path / "clip.h5")


def test_a_mat_of_another_program_is_told_the_way(tmp_path):
    savemat(tmp_path / "save_data_AVG.mat", {"pred": np.zeros((3, 1, 3, 6))})  # of DANNCE
    with pytest.raises(InputError, match=r"no final_tracks in it; .*DANNCE .*write its points as"):
        read_any_tracks(tmp_path / "save_data_AVG.mat", fps=100.0)


def test_tables_of_binary_kinds_say_how_they_become_csv(tmp_path):
    for name, begin, by in (("a.parquet", b"PAR1", "parquet"), ("a.feather", b"ARROW1", "feather")):
        (tmp_path / name).write_bytes(begin + b"\0" * 20)
        with pytest.raises(InputError, match=rf"not read here; .*pandas.read_{by}\(FILE\)"):
            recognise_format(tmp_path / name)
    with zipfile.ZipFile(tmp_path / "ktk.zip", "w") as file:
        file.writestr("data.json", "{}")
    with pytest.raises(InputError, match="a zip archive, not read here; unpack it"):
        recognise_format(tmp_path / "ktk.zip")
    with zipfile.ZipFile(tmp_path / "m1.trz", "w") as file:
        file.writestr("m1.trk", "<object/>")
    with pytest.raises(InputError, match=r"Tracker with its film \(.trz\), not .* name the .trk"):
        recognise_format(tmp_path / "m1.trz")


def test_a_folder_of_zarr_is_named(tmp_path):
    (tmp_path / "poses.zarr").mkdir()
    (tmp_path / "poses.zarr" / "zarr.json").write_text("{}")  # zarr 3; .zgroup before
    for read in (recognise_format, read_source):
        with pytest.raises(InputError, match=r"Zarr, not read here; .*to_netcdf"):
            read(tmp_path / "poses.zarr")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("time,knee,hip\n0,1,2\n", r"\(its columns are time, knee, hip\)"),
        ("time,FR_x,FR_y\n0,1,2\n", "time, FR_x, FR_y: add a column frame that counts from 0"),
        ("frame,左前足_x,左前足_y\n0,1,2\n".encode("gbk"), "not text in UTF-8; save it as UTF-8"),
    ],
)
def test_what_was_found_is_said_where_no_program_is_known(tmp_path, text, said):
    path = tmp_path / "points.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(InputError, match=f"not tracks that are read here .*{said}"):
        recognise_format(path)


def test_tables_of_pandas_by_other_names(tmp_path):
    """pandas 3.1: a table of DeepLabCut's is one under any key; a plain one is named."""
    pytest.importorskip("tables")
    columns = pd.MultiIndex.from_product(
        [["DLC"], ["FR", "HR"], ["x", "y", "likelihood"]], names=["scorer", "bodyparts", "coords"]
    )
    table = pd.DataFrame(np.arange(12.0).reshape(2, 6), columns=columns)
    for layout in ("fixed", "table"):
        path = tmp_path / f"{layout}.h5"
        table.to_hdf(path, key="tracks_of_m1", format=layout)
        assert recognise_format(path) == "deeplabcut"
        read = read_any_tracks(path, fps=100.0)
        assert read["position"].sel(keypoint="HR").to_numpy().ravel().tolist() == [3, 4, 9, 10]
    pd.DataFrame({"frame": [0], "FR_x": [1.0]}).to_hdf(tmp_path / "plain.h5", key="df")
    with pytest.raises(InputError, match=r"tables of pandas \(df\), not read here; .*read_hdf"):
        recognise_format(tmp_path / "plain.h5")


def test_a_table_with_a_row_for_each_point_is_spread_as_the_message_says(tmp_path):
    table = pd.DataFrame(
        {"frame": [0, 0, 1, 1], "bodypart": ["FR", "HR"] * 2, "x": [1, 2, 3, 4], "y": [5, 6, 7, 8]}
    )
    table.to_csv(tmp_path / "long.csv", index=False)
    with pytest.raises(InputError, match="a row for each point") as caught:
        recognise_format(tmp_path / "long.csv")
    lines = re.search(r"by pandas: (.*)\.$", str(caught.value))[1]
    lines = lines.replace("<names of points>", "'bodypart'").replace(
        "'points.csv'", repr(str(tmp_path / "points.csv"))
    )
    exec(lines, {"table": table})  # noqa: S102  (what the message says)
    place = read_any_tracks(tmp_path / "points.csv", fps=100.0)["position"]
    assert place.sel(keypoint="HR").to_numpy()[:, :, 0].tolist() == [[2, 6], [4, 8]]
