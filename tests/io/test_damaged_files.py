"""Whatever is wrong with a file of tracks, one sentence says so: no other error comes out."""

from __future__ import annotations

import importlib.util
import os
import warnings

import h5py
import numpy as np
import pytest
from foreign_files import FPS, POINTS, WRITERS, write_analysis_h5, write_dlc_csv, write_wide
from scipy.io import savemat

from pawnb.errors import CalibrationError, InputError
from pawnb.io.coefs import read_coefs
from pawnb.io.formats import read_any_tracks, write_any_tracks
from pawnb.io.native import read_tracks, write_tracks
from pawnb.io.tables import read_cells
from pawnb.schema import make_tracks
from pawnb.workflow.gait.sources import read_source


def through(kind, program):
    """Return a writer that makes a file of one format out of one of another."""
    name, write = WRITERS[kind]

    def convert(path, frames):
        source = write(path.with_name(f"source_{name}"), frames)
        tracks = read_any_tracks(source, fps=FPS)
        return write_any_tracks(tracks, path, program=program, heights_px=[480])[0]

    return convert


def write_mat(path, frames):
    savemat(path, {"final_tracks": np.random.default_rng(0).uniform(0, 99, (3, 5, len(frames)))},
            do_compression=True)  # fmt: skip
    return path


def write_nwb(path, frames):
    """The layout of ndx-pose by h5py."""
    with h5py.File(path, "w") as file:
        file.attrs["nwb_version"] = "2.8.0"
        pose = file.create_group("processing/behavior/PoseEstimation")
        pose.attrs["neurodata_type"] = "PoseEstimation"
        for point in POINTS:
            series = pose.create_group(point)
            series.attrs["neurodata_type"] = "PoseEstimationSeries"
            series["data"] = np.random.default_rng(0).uniform(0, 99, (len(frames), 2))
            series["data"].attrs["unit"] = "pixels"
            series["confidence"] = np.full(len(frames), 0.9)
            series["timestamps"] = np.array(frames) / FPS
        file["general/subject/subject_id"] = "m1"
    return path


FORMATS = {
    **WRITERS,
    "sleap h5": ("clip.analysis.h5", write_analysis_h5),
    "sleap csv": ("clip.csv", through("sleap slp", "sleap")),
    "collected csv": ("CollectedData_x.csv", through("deeplabcut csv", "collected")),
    "collected h5": ("CollectedData_x.h5", through("deeplabcut csv", "collected")),
    "deeplabcut fixed": ("clip.h5", through("deeplabcut csv", "deeplabcut")),
    "dltdv sparse": ("clip_xypts.tsv", through("dltdv views", "dltdv")),
    "argus": ("clip-xypts.csv", through("dltdv views", "argus")),
    "argus space": ("clip-xyzpts.csv", through("dltdv space", "argus-3d")),
    "locomouse": ("clip.mat", write_mat),
    "nwb": ("clip.nwb", write_nwb),
}
if importlib.util.find_spec("c3d"):
    FORMATS["c3d"] = ("clip.c3d", through("dltdv space", "c3d"))
ENDINGS = (".csv", ".h5", ".slp", ".nc")


def damaged(data: bytes, seed: int) -> bytes:
    """Return a file cut short, with wrong bytes, with a stretch of noise, or with other digits."""
    rng = np.random.default_rng(seed)
    out = bytearray(data)
    way = seed % 4
    if way == 0:
        del out[int(rng.integers(len(out))) :]
    elif way == 1:
        for at in rng.integers(0, len(out), 6):
            out[at] = rng.integers(256)
    elif way == 2:
        at = int(rng.integers(len(out)))
        out[at : at + 60] = rng.integers(0, 256, 60).astype(np.uint8).tobytes()
    else:
        for at in rng.integers(0, len(out), 12):
            out[at] = rng.choice(list(b'0123456789,.-eE\n";x'))
    return bytes(out)


def refusal(read, path, **options):
    """Return the sentence by which a file is refused, or "" where it is read."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            read(path, **options)
        except InputError as error:
            return str(error)
    return ""


@pytest.mark.parametrize("kind", sorted(FORMATS))
def test_a_damaged_file_is_read_or_one_sentence(tmp_path, kind):
    name, write = FORMATS[kind]
    whole = write(tmp_path / name, list(range(12))).read_bytes()
    path = tmp_path / f"damaged_{name}"
    sentences = []
    for seed in range(60 if path.suffix == ".csv" else 40):
        path.write_bytes(damaged(whole, seed))
        sentences.append(refusal(read_any_tracks, path, fps=FPS, heights_px=[480]))
    refused = [sentence for sentence in sentences if sentence]
    assert len(refused) > 10
    assert all(path.name in sentence and "\n" not in sentence for sentence in refused)


@pytest.mark.slow
def test_a_damaged_record_of_ours_is_read_or_one_sentence(tmp_path):
    tracks = make_tracks(range(8), POINTS, fps=FPS, views=["cam1"])
    whole = write_tracks(tracks, tmp_path / "tracks.nc").read_bytes()
    path = tmp_path / "damaged.nc"
    sentences = []
    for seed in range(40):
        path.write_bytes(damaged(whole, seed))
        sentences.append(refusal(read_tracks, path))
    assert any(sentences)
    assert not any("\n" in sentence for sentence in sentences)


def test_a_broken_heap_of_texts_is_not_read_for_ever(tmp_path):
    # HDF5 itself never comes back from an object of size 0, nor soon from a text of 4 GB
    tracks = make_tracks(range(8), POINTS, fps=FPS)
    whole = write_tracks(tracks, tmp_path / "tracks.nc").read_bytes()
    heap = whole.index(b"GCOL")
    first = int.from_bytes(whole[heap + 24 : heap + 32], "little")
    second = heap + 32 + (first + 7) // 8 * 8
    (tmp_path / "a.nc").write_bytes(whole[:second] + bytes(16) + whole[second + 16 :])
    with pytest.raises(InputError, match=r"a.nc: damaged, a heap of texts at byte \d+ is broken"):
        read_tracks(tmp_path / "a.nc")
    with h5py.File(tmp_path / "tracks.nc") as file:
        at = file["keypoint"].id.get_offset()
    (tmp_path / "b.nc").write_bytes(whole[: at + 3] + b"\xff" + whole[at + 4 :])
    with pytest.raises(InputError, match=r"b.nc: damaged, a text in 'keypoint' is longer than"):
        read_tracks(tmp_path / "b.nc")


@pytest.mark.parametrize("ending", ENDINGS)
@pytest.mark.parametrize("kind", ["pipe", "device", "folder", "empty", "nothing"])
def test_what_is_no_file_is_not_waited_for(tmp_path, ending, kind):
    path = tmp_path / f"clip{ending}"
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "device":
        path.symlink_to("/dev/zero")
    elif kind == "folder":
        path.mkdir()
    elif kind == "empty":
        path.write_bytes(b"")
    for read in (lambda: read_any_tracks(path, fps=FPS), lambda: read_source(path, fps=FPS)):
        with pytest.raises(InputError) as caught:
            read()
        assert "\n" not in str(caught.value)
        if kind == "pipe":
            assert "a named pipe; expected" in str(caught.value)
        if kind == "device":
            assert "a device; expected" in str(caught.value)


def test_a_table_of_a_terabyte_is_not_read(tmp_path):
    with (tmp_path / "points.csv").open("wb") as file:
        file.write(b"frame,FR_x,FR_y\n")
        file.truncate(2**40)
    with pytest.raises(InputError, match="1 TB large; expected"):
        read_any_tracks(tmp_path / "points.csv", fps=FPS)


# --- cells ----------------------------------------------------------------------------------------


def change(path, old, new):
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    return path


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("105,51.25", "here,51.25", r"^c.csv: line 9, FR x is 'here'; expected a number"),
        ("105,51.25", "inf,51.25", r"^c.csv: line 9, FR x is 'inf'; expected a number"),
        ("105,51.25", "1e999,51.25", r"^c.csv: line 9, FR x is 'inf'; expected a number"),
        ("105,51.25", "51.25", r"^c.csv: line 9 has 6 cells; expected 7"),
        ("105,51.25", "105,51.25,1", r"^c.csv: line 9 has 8 cells; expected 7"),
        (
            "bodyparts,FR,FR,FR,HR,HR,HR",
            "bodyparts,FR,FR,FR,FR,FR,FR",
            "FR x is there twice",
        ),
        ("x,y,likelihood,x", "x,y,likelihood,q", "column HR q; expected coords x, y, z"),
        ("\n5,", "\nlabeled-data/v/img5.png,", "the frame is the picture .*, as in labels for"),
        ("bodyparts,FR", "bodyparts,", "column y of point '' is missing"),
    ],
)
def test_a_cell_of_deeplabcut_that_is_wrong_is_named(tmp_path, old, new, message):
    path = write_dlc_csv(tmp_path / "c.csv", range(8))
    old = old.replace("105,51.25", "105.0,51.25")
    new = new.replace("105,51.25", "105.0,51.25")
    with pytest.raises(InputError, match=message):
        read_any_tracks(change(path, old, new), fps=FPS)


@pytest.mark.parametrize("kind", ["deeplabcut csv", "wide table", "tracks.csv", "anipose"])
def test_a_byte_order_mark_is_no_part_of_a_name(tmp_path, kind):
    name, write = WRITERS[kind]
    path = write(tmp_path / name, range(6))
    plain = read_any_tracks(path, fps=FPS)
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes().replace(b"\n", b"\r\n"))
    assert read_any_tracks(path, fps=FPS).equals(plain)


@pytest.mark.parametrize("kind", ["deeplabcut csv", "wide table", "tracks.csv", "anipose"])
@pytest.mark.parametrize(("mark", "decimal"), [(";", ","), (";", "."), ("\t", ","), ("\t", ".")])
@pytest.mark.parametrize("first", ["", "sep={}\n"])
def test_tables_of_spreadsheets_of_other_regions_hold_the_same(
    tmp_path, kind, mark, decimal, first
):
    name, write = WRITERS[kind]
    path = write(tmp_path / name, range(6))
    plain = read_any_tracks(path, fps=FPS)
    text = path.read_text().replace(".", "§").replace(",", mark).replace("§", decimal)
    path.write_bytes((first.format(mark) + text).replace("\n", "\r\n").encode())
    assert read_any_tracks(path, fps=FPS).equals(plain)
    assert read_source(path, fps=FPS).tracks.equals(plain)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("frame;FR_x;FR_y\n0;1.5;2\n1;2,5;2\n", r"1\.5 in line 2 and 2,5; .* semicolons"),
        ("frame\tFR_x\tFR_y\n0\t1,500\t2\n", "such as 1,500, which may be thousands or decimals"),
        ("frame;FR_x;FR_y\n0;1.234,5;2\n", r"column 'FR_x' is '1\.234,5'; expected a number"),
    ],
)
def test_a_decimal_mark_that_is_not_told_is_refused(tmp_path, text, message):
    (tmp_path / "points.csv").write_text(text)
    with pytest.raises(InputError, match=message):
        read_any_tracks(tmp_path / "points.csv", fps=FPS)


@pytest.mark.parametrize("word", ["inf", "-inf", "1e999", "Infinity"])
def test_infinite_places_are_refused(tmp_path, word):
    path = change(write_wide(tmp_path / "points.csv", range(6)), "103.0", word)
    with pytest.raises(InputError, match=r"line 5, column 'FR_x' is .*; expected a num"):
        read_any_tracks(path, fps=FPS)
    path = write_analysis_h5(tmp_path / "a.h5", range(6))
    with h5py.File(path, "a") as file:
        file["tracks"][0, 0, 1, 3] = float(word)
    with pytest.raises(InputError, match=r"a.h5: frame 3, point 'HR' is at infinity"):
        read_any_tracks(path, fps=FPS)


def test_points_of_one_name_are_refused(tmp_path):
    path = change(write_wide(tmp_path / "points.csv", range(6)), "HR_x,HR_y", "FR_x,FR_y")
    with pytest.raises(InputError, match=r"points.csv: column 'FR_x' is there twice"):
        read_any_tracks(path, fps=FPS)
    path = write_analysis_h5(tmp_path / "a.h5", range(6))
    with h5py.File(path, "a") as file:
        file["node_names"][1] = b"FR"
    with pytest.raises(InputError, match=r"a.h5: point 'FR' is there twice"):
        read_any_tracks(path, fps=FPS)


def test_a_table_cut_short_is_said(tmp_path):
    path = write_wide(tmp_path / "points.csv", range(6))
    path.write_text(path.read_text()[:-12])
    with pytest.raises(InputError, match=r"the last line has 4 of 5 cells, no end: the"):
        read_any_tracks(path, fps=FPS)


def test_a_row_with_a_cell_too_many_is_not_shifted(tmp_path):
    # pandas takes the first column as an index then, and every value moves by one
    (tmp_path / "points.csv").write_text("frame,FR_x,FR_y\n0,1,2,\n1,2,3,\n")
    with pytest.raises(InputError, match=r"points.csv: line 2 has 4 cells, more than"):
        read_any_tracks(tmp_path / "points.csv", fps=FPS)
    (tmp_path / "points.csv").write_text("frame,FR_x,FR_y,\n0,1,2,\n1,2,3,\n")
    assert list(read_cells(tmp_path / "points.csv", ())) == ["frame", "FR_x", "FR_y"]


@pytest.mark.parametrize(
    ("cell", "message"),
    [("9e18", "row 4, column 2 is 9e.18; no camera has"), ("1e999", "expected a number"),
     ("x", "row 4, column 2 is 'x'")],
)  # fmt: skip
def test_a_coefficient_that_no_camera_has_is_refused(tmp_path, cell, message):
    rows = [["1.5", "2.5"] for _ in range(11)]
    rows[3][1] = cell
    (tmp_path / "DLTcoefs.csv").write_text("\n".join(",".join(row) for row in rows) + "\n")
    with pytest.raises(CalibrationError, match=message):
        read_coefs(tmp_path / "DLTcoefs.csv", ["a", "b"])
    (tmp_path / "DLTcoefs.csv").write_text("1,5;2.5\n" * 11)
    with pytest.raises(CalibrationError, match="which of the two is the decimal mark is not told"):
        read_coefs(tmp_path / "DLTcoefs.csv", ["a", "b"])
    (tmp_path / "DLTcoefs.csv").write_text("1,5;2,5\n" * 11)
    assert read_coefs(tmp_path / "DLTcoefs.csv", ["a", "b"])[3].tolist() == [1.5, 2.5]


@pytest.mark.parametrize(
    ("change_file", "message"),
    [
        (lambda f: f["instances"].__setitem__(slice(1, 2), f["instances"][:1]), "two instances of"),
        (lambda f: f.__delitem__("pred_points"), "no array pred_points"),
        (lambda f: f["metadata"].attrs.__setitem__("json", "{" * 9999), "no JSON"),
        (lambda f: f["metadata"].attrs.__setitem__("json", "{}"), "does not name the nodes"),
        (lambda f: f["metadata"].attrs.__setitem__("format_id", 3.5), "newer than is read here"),
        (lambda f: f["frames"].__setitem__("video", [0, 1, 0, 0]), "labels of 2 videos"),
    ],
)
def test_a_sleap_file_that_cannot_be_used_says_why(tmp_path, change_file, message):
    name, write = WRITERS["sleap slp"]
    path = write(tmp_path / name, range(4))
    with h5py.File(path, "a") as file:
        change_file(file)
    with pytest.raises(InputError, match=message):
        read_any_tracks(path, fps=FPS)


def test_old_sleap_files_count_from_the_corner_of_a_pixel(tmp_path):
    # sleap-io, io/slp.py: before format 1.1 the top-left corner of a pixel was (0, 0)
    name, write = WRITERS["sleap slp"]
    path = write(tmp_path / name, range(4))
    new = read_any_tracks(path, fps=FPS)
    with h5py.File(path, "a") as file:
        file["metadata"].attrs["format_id"] = 1.0
    old = read_any_tracks(path, fps=FPS)
    np.testing.assert_allclose(old["position"], new["position"] - 0.5)


def test_predictions_of_two_scorers_in_one_table_are_told_apart(tmp_path):
    (tmp_path / "two.csv").write_text(
        "scorer,netA,netA,netA,netB,netB,netB\nbodyparts,FR,FR,FR,FR,FR,FR\n"
        "coords,x,y,likelihood,x,y,likelihood\n0,1,2,1,3,4,1\n"
    )
    with pytest.raises(InputError, match=r"FR x is there twice; keep the columns of one scorer, "):
        read_any_tracks(tmp_path / "two.csv", fps=100.0)
