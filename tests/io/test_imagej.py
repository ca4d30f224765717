"""Points of ImageJ's Manual Tracking and MTrackJ, as the source and the author describe them."""

import numpy as np
import pytest

from pawnb.errors import InputError, InputWarning
from pawnb.io import read_any_tracks, read_manual_tracking, read_mtrackj, recognise_format

N = 10
PAWS = {1: [(100 + 7 * i, 50 - i % 3) for i in range(N)], 2: [(60 + 6 * i, 55) for i in range(N)]}


def manual(path, *, mark="\t", encoding="utf-8", first=(1, 4)):
    """As MTrack_.java fills its table and ImageJ saves it; the second track begins at slice 4."""
    lines = [mark.join((" ", "Track n°", "Slice n°", "X", "Y", "Distance", "Velocity",
                        "Pixel Value"))]  # fmt: skip
    for track, begin in zip(PAWS, first, strict=True):
        for i, (x, y) in enumerate(PAWS[track]):
            cells = (len(lines), track, begin + i, x, y, "-1.000", "-1.000", 120)
            lines.append(mark.join(map(str, cells)))
    path.write_bytes(("\n".join(lines) + "\n").encode(encoding))
    return path


def mdf(path, *, slices=False, clusters=(1, 1)):
    """As imagescience.org/meijering/software/mtrackj/format describes it: ``Point ID x y z t c``,
    x and y from 0 on, z, t and c from 1; the second track begins at frame 4."""
    lines = ["MTrackJ 1.5.1 Data File", "Displaying true true true 1 2 0 4 100 10",
             "Assembly 1 FF0000"]  # fmt: skip
    for k, (track, begin) in enumerate(zip(PAWS, (1, 4), strict=True)):
        if k == 0 or clusters[1] != clusters[0]:
            lines.append(f"Cluster {clusters[k]} FF0000")
        lines.append(f"Track {1 if clusters[1] != clusters[0] else track} FF0000 true")
        for i, (x, y) in enumerate(PAWS[track]):
            z, t = (begin + i, 1) if slices else (1, begin + i)
            lines.append(f"Point {i + 1} {x:.1f} {y:.1f} {z:.1f} {t:.1f} 1.0")
    path.write_text("\n".join([*lines, "End of MTrackJ Data File"]) + "\n")
    return path


def check(tracks, names=("track1", "track2")):
    assert tracks["keypoint"].values.tolist() == list(names)
    assert tracks["frame"].values.tolist() == list(range(N + 3))
    assert tracks.attrs["units"] == "px"
    place = tracks["position"].to_numpy()[..., 0]
    assert place[:N, :, 0].tolist() == [list(xy) for xy in PAWS[1]]
    assert place[3:, :, 1].tolist() == [list(xy) for xy in PAWS[2]]
    assert np.isnan(place[N:, :, 0]).all()
    assert np.isnan(place[:3, :, 1]).all()


@pytest.mark.parametrize(
    ("mark", "encoding"), [("\t", "utf-8"), (",", "utf-8"), ("\t", "cp1252"), (",", "cp1252")]
)
def test_manual_tracking_counts_slices_from_1(tmp_path, mark, encoding):
    path = manual(tmp_path / "Results from m1.xls", mark=mark, encoding=encoding)
    assert recognise_format(path) == "manual-tracking"
    check(read_any_tracks(path, fps=250.0))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("\tX\t", "\tU\t", "no columns Track n°"),
        ("\t107\t", "\t?\t", r"line 3: '\?'; expected a number"),
        ("\n2\t1\t2\t", "\n2\t1\t1\t", "point 'track1' has 2 places in frame 0"),
        ("\n2\t1\t2\t", "\n2\t1\t1.5\t", "1.5 is no number of a frame"),
        ("\t50\t-1.000\t-1.000\t120\n2", "\n2", "line 2 has 4 of 8 cells"),
    ],
)
def test_what_is_wrong_with_manual_tracking_is_one_sentence(tmp_path, old, new, message):
    path = manual(tmp_path / "results.xls")
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(InputError, match=rf"^results.xls: .*{message}"):
        read_manual_tracking(path, fps=250.0)


def test_mtrackj_counts_frames_from_1(tmp_path):
    path = mdf(tmp_path / "m1.mdf")
    assert recognise_format(path) == "mtrackj"
    check(read_any_tracks(path, fps=250.0))


def test_tracks_of_several_clusters_are_told_apart(tmp_path):
    check(read_mtrackj(mdf(tmp_path / "m1.mdf", clusters=(1, 2)), fps=250.0),
          ("cluster1 track1", "cluster2 track1"))  # fmt: skip


def test_a_film_that_was_opened_as_slices_is_read_and_said(tmp_path):
    with pytest.warns(InputWarning, match=r"m1.mdf: all points have time 1, .* taken for frames"):
        check(read_mtrackj(mdf(tmp_path / "m1.mdf", slices=True), fps=250.0))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("Point 2 107.0 49.0 1.0 2.0 1.0", "Point 2 107.0 49.0", "line 7 is no point of a track"),
        ("Track 1 FF0000 true\n", "", "line 5 is no point of a track"),
        ("Track 2", "Track 1", "track 1 is there twice"),
        ("107.0", "far", "line 7: 'far'; expected a number"),
    ],
)
def test_what_is_wrong_with_a_mdf_is_one_sentence(tmp_path, old, new, message):
    path = mdf(tmp_path / "m1.mdf")
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(InputError, match=rf"^m1.mdf: .*{message}"):
        read_mtrackj(path, fps=250.0)


def test_a_mdf_without_points_is_said(tmp_path):
    path = tmp_path / "m1.mdf"
    path.write_text("MTrackJ 1.5.1 Data File\nAssembly 1\nCluster 1\nTrack 1\n")
    with pytest.raises(InputError, match=r"m1.mdf: no point that was digitised"):
        read_mtrackj(path, fps=250.0)
