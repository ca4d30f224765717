"""Files of SLEAP as sleap-io writes them, compared with what sleap-io reads of them."""

from __future__ import annotations

import warnings

import h5py
import numpy as np
import pytest

from pawnb import load_tracks
from pawnb.errors import InputError, InputWarning
from pawnb.io.formats import write_any_tracks

FPS = 100.0


@pytest.mark.slow
@pytest.mark.parametrize("own", [0, 1])
def test_points_of_a_slp_have_the_names_of_their_own_skeleton(tmp_path, own):
    """Where a project held a second skeleton, its names were taken: FR came out as HL."""
    sio = pytest.importorskip("sleap_io")
    skeletons = [sio.Skeleton(nodes=["FR", "HR"]), sio.Skeleton(nodes=["HL", "FL"], name="b")]
    video = sio.Video(filename="clip.mp4", open_backend=False)
    instance = sio.PredictedInstance.from_numpy(np.eye(2), skeleton=skeletons[own], score=0.5)
    frame = sio.LabeledFrame(video=video, frame_idx=0, instances=[instance])
    labels = sio.Labels([frame], videos=[video], skeletons=skeletons)
    sio.save_slp(labels, str(tmp_path / "a.slp"), embed=False, verbose=False)
    theirs = sio.load_slp(str(tmp_path / "a.slp"), open_videos=False)[0].instances[0].skeleton
    tracks = load_tracks(tmp_path / "a.slp", fps=FPS)
    assert tracks["keypoint"].to_numpy().tolist() == [node.name for node in theirs.nodes]
    other = sio.PredictedInstance.from_numpy(np.eye(2), skeleton=skeletons[1 - own], score=0.5)
    labels.append(sio.LabeledFrame(video=video, frame_idx=1, instances=[other]))
    sio.save_slp(labels, str(tmp_path / "b.slp"), embed=False, verbose=False)
    with pytest.raises(InputError, match=r"b.slp: labels of 2 skeletons; keep those of one in SL"):
        load_tracks(tmp_path / "b.slp", fps=FPS)


def test_the_film_and_the_edges_of_an_analysis_file_are_written_back(tmp_path):
    """As those of a .slp: a corrected file had none."""
    with h5py.File(
        tmp_path / "a.analysis.h5", "w"
    ) as file:  # names and shapes as of sleap-io 0.9.5
        file["tracks"] = np.arange(18.0).reshape(1, 2, 3, 3)
        file["node_names"], file["track_names"] = [b"FR", b"tail", b"nose"], [b"mouse"]
        file["edge_names"] = [[b"nose", b"tail"], [b"tail", b"FR"]]
        file["edge_inds"], file["video_path"] = [[2, 1], [1, 0]], "films/clip.mp4"
    tracks = load_tracks(tmp_path / "a.analysis.h5", fps=FPS)
    (path,) = write_any_tracks(tracks, tmp_path / "b.analysis.h5")
    with h5py.File(tmp_path / "a.analysis.h5") as was, h5py.File(path) as now:
        for name in ("tracks", "edge_names", "edge_inds", "video_path"):
            np.testing.assert_array_equal(now[name][()], was[name][()])


@pytest.mark.slow
def test_sleap_io_reads_the_film_and_the_edges_of_an_analysis_file(tmp_path):
    sio = pytest.importorskip("sleap_io")
    skeleton = sio.Skeleton(nodes=["FR", "tail", "nose"], edges=[("nose", "tail"), ("tail", "FR")])
    video = sio.Video(filename="films/clip.mp4", open_backend=False)
    instance = sio.PredictedInstance.from_numpy(np.eye(3)[:, :2], skeleton=skeleton, score=0.5)
    frame = sio.LabeledFrame(video=video, frame_idx=2, instances=[instance])
    labels = sio.Labels([frame], videos=[video], skeletons=[skeleton])
    sio.save_analysis_h5(labels, tmp_path / "a.analysis.h5")
    tracks = load_tracks(tmp_path / "a.analysis.h5", fps=FPS)
    (path,) = write_any_tracks(tracks, tmp_path / "b.analysis.h5")
    again = sio.load_analysis_h5(path)
    assert again.video.filename == "films/clip.mp4"
    assert again.skeleton.edge_names == skeleton.edge_names
    assert again[0].frame_idx == 2


def table(path, frames, parts):
    """Write rows of one animal with these columns of its point."""
    rows = [
        f",{i},1.0," + ",".join("0.9" if p == "score" else "5.5" for p in parts) for i in frames
    ]
    head = "track,frame_idx,instance.score," + ",".join(f"FR.{part}" for part in parts)
    path.write_text("\n".join([head, *rows]) + "\n")
    return path


def test_a_csv_of_sleap_io_that_may_go_on_in_another_video_is_said(tmp_path):
    # sleap-io 0.9.5 writes columns in alphabetical order, all videos one after the other, and
    # none of their names; SLEAP itself (x, y, score) writes a file a video
    frames = [*range(10), *range(40, 50)]
    path = table(tmp_path / "two.csv", frames, ("score", "x", "y"))
    with pytest.warns(InputWarning, match=r"two.csv: no row from frame 10 to 39. sleap-io writes"):
        assert load_tracks(path, fps=FPS).sizes["time"] == 50
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        load_tracks(table(tmp_path / "own.csv", frames, ("x", "y", "score")), fps=FPS)
        load_tracks(table(tmp_path / "lost.csv", [0, 1, 9], ("score", "x", "y")), fps=FPS)
