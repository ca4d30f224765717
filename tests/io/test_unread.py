"""Files of programs that are not read are named, with the way to one that is."""

import zipfile

import h5py
import numpy as np
import pytest
from scipy.io import savemat

from pawnb.errors import InputError
from pawnb.io import read_any_tracks, recognise_format

# the beginnings of files as these programs write them
TEXTS = {
    "clip_keypoints.json": ('{"version":1.3,"people":[{"pose_keypoints_2d":[1.0]}]}', "OpenPose"),
    "mmpose.json": ('{"meta_info":{},"instance_info":[{"frame_id":1}]}', "MMPose"),
    "ls.json": ('[{"data": {}, "annotations": [{"result": []}]}]', "Label Studio, .*; write its"),
    "coco.json": ('{"images": [{"file_name": "a.png"}], "annotations": []}', "COCO.*--from coco"),
    "clip.kva": ('<?xml version="1.0"?>\n<KinoveaVideoAnalysis>\n', "Kinovea"),
    "kinovea.csv": ('Time (ms),"Trajectory 1/0/X","Trajectory 1/0/Y"\n0,1.0,2.0\n', "Kinovea"),
    "clip.trk": ('<?xml version="1.0"?>\n<object class="org.opensourcephysics.x">\n', "Tracker"),
    "tracker.txt": ("\tmass_A\t\nt\tx\ty\t\n0.0\t1.2\t-3.4\t\n", "a table of Tracker"),
    "trackmate.xml": ('<?xml version="1.0"?>\n<TrackMate version="7.11.1">\n', "TrackMate"),
    # POSITION_X, POSITION_Y and POSITION_Z looked like DLTdv's
    "spots.csv": (
        "LABEL,ID,TRACK_ID,QUALITY,POSITION_X,POSITION_Y,POSITION_Z,FRAME\nLabel,,,,,,,\n",
        "TrackMate",
    ),
    "ik.mot": ("Coordinates\nversion=1\nnRows=2\ninDegrees=yes\nendheader\ntime\n", "trc"),
    "points.csv": ("frame_idx,node,x,y,track\n0,FR,1,2,m1\n", 'format="sleap"'),
    "frames.csv": ("frame_idx,inst0.track,inst0.FR.x,inst0.FR.y\n0,m1,1,2\n", 'format="sleap"'),
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
