"""Spots of TrackMate, laid out as files that users published have them."""

from itertools import pairwise

import numpy as np
import pytest

from pawnb.errors import InputError, InputWarning
from pawnb.io import read_any_tracks, read_trackmate, recognise_format

N = 8
SPOTS = {0: [(5.5 + i, 20.25) for i in range(N)], 3: [(50.0 - i, 21.5 + i) for i in range(N)]}
HEADS = (
    "LABEL,ID,TRACK_ID,QUALITY,POSITION_X,POSITION_Y,POSITION_Z,POSITION_T,FRAME,RADIUS",
    "Label,Spot ID,Track ID,Quality,X,Y,Z,T,Frame,Radius",
    "Label,Spot ID,Track ID,Quality,X,Y,Z,T,Frame,R",
)


def rows():
    """Number, track, frame, x and y of each spot, frame by frame; one has no track."""
    found = [(10 * t + i, t, i + 2, *SPOTS[t][i]) for i in range(N) for t in SPOTS]
    return [*found, (999, None, 4, 70.0, 70.0)]


def table(path, *, unit="pixel", heads=4):
    lines = list(HEADS[: min(heads, 3)])
    if heads == 4:
        lines.append(f",,,(quality),({unit}),({unit}),({unit}),(sec),,({unit})")
    for number, track, frame, x, y in rows():
        own = "" if track is None else track
        lines.append(f"ID{number},{number},{own},1.0,{x},{y},0.0,{frame * 0.04},{frame},5.0")
    path.write_text("\n".join(lines) + "\n")
    return path


def project(path, *, unit="pixel", names=("Track_0", "hind paw"), kept=(0, 3)):
    lines = ['<?xml version="1.0" encoding="UTF-8"?>', '<TrackMate version="7.11.1">',
             f'<Model spatialunits="{unit}" timeunits="sec">', "<AllSpots>"]  # fmt: skip
    for frame in range(2, 2 + N):
        lines.append(f'<SpotsInFrame frame="{frame}">')
        lines += [f'<Spot ID="{number}" name="ID{number}" QUALITY="-1.0" POSITION_T="0.1" '
                  f'FRAME="{frame}" POSITION_Z="0.0" POSITION_X="{x}" POSITION_Y="{y}" />'
                  for number, _, at, x, y in rows() if at == frame]  # fmt: skip
        lines.append("</SpotsInFrame>")
    lines += ["</AllSpots>", "<AllTracks>"]
    for name, track in zip(names, SPOTS, strict=True):
        lines.append(f'<Track name="{name}" TRACK_ID="{track}">')
        ids = [10 * track + i for i in range(N)]
        lines += [f'<Edge SPOT_SOURCE_ID="{a}" SPOT_TARGET_ID="{b}" LINK_COST="-1.0" />'
                  for a, b in pairwise(ids)]  # fmt: skip
        lines.append("</Track>")
    lines += ["</AllTracks>", "<FilteredTracks>", *(f'<TrackID TRACK_ID="{t}" />' for t in kept),
              "</FilteredTracks>", "</Model>", "</TrackMate>"]  # fmt: skip
    path.write_text("\n".join(lines) + "\n")
    return path


def exported(path, *, unit="pixel"):
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<Tracks nTracks="2" spaceUnits="{unit}" frameInterval="0.04" timeUnits="sec">',
    ]
    for track in SPOTS.values():
        lines.append(f'<particle nSpots="{N}">')
        lines += [f'<detection t="{i + 2}" x="{x}" y="{y}" z="0.0" />'
                  for i, (x, y) in enumerate(track)]  # fmt: skip
        lines.append("</particle>")
    path.write_text("\n".join([*lines, "</Tracks>"]) + "\n")
    return path


def check(tracks, names, *, unit="px", scale=1.0):
    assert tracks["keypoint"].values.tolist() == list(names)
    assert tracks["frame"].values.tolist() == list(range(2, 2 + N))
    assert tracks.attrs["units"] == unit
    place = tracks["position"].to_numpy()[..., 0]
    for k, track in enumerate(SPOTS.values()):
        np.testing.assert_allclose(place[:, :, k], np.array(track) * scale)


@pytest.mark.parametrize(
    ("write", "name", "names"),
    [(table, "spots.csv", ("Track_0", "Track_3")), (project, "m1.xml", ("Track_0", "hind paw")),
     (exported, "m1_Tracks.xml", ("Track_0", "Track_1"))],
)  # fmt: skip
@pytest.mark.parametrize(
    ("said", "unit"), [("pixel", "px"), ("pixels", "px"), ("micron", "um"), ("mm", "mm")]
)
def test_spots_of_tracks_are_read_in_the_unit_that_is_said(
    tmp_path, write, name, names, said, unit
):
    path = write(tmp_path / name, unit=said)
    assert recognise_format(path) == "trackmate"
    check(read_any_tracks(path, fps=250.0), names, unit=unit)


def test_sleap_io_reads_the_same_of_a_table(tmp_path):
    """sleap-io 0.9.5, the reader of another program."""
    sleap_io = pytest.importorskip("sleap_io")
    if not hasattr(sleap_io, "load_trackmate"):
        pytest.skip("this sleap-io reads no TrackMate")
    path = table(tmp_path / "spots.csv")
    tracks = read_trackmate(path, fps=250.0)
    frames = tracks["frame"].values.tolist()
    place = tracks["position"].to_numpy()[..., 0]
    theirs = sleap_io.load_trackmate(path)
    assert sorted(one.frame_idx for one in theirs) == frames
    for labelled in theirs:
        row = place[frames.index(labelled.frame_idx)]
        names = tracks["keypoint"].values.tolist()
        for spot in labelled.centroids:
            if spot.track is not None:
                assert row[:, names.index(spot.track.name)].tolist() == [spot.x, spot.y]


def test_lengths_are_brought_to_the_unit_that_is_asked_for(tmp_path):
    path = table(tmp_path / "spots.csv", unit="micron")
    check(read_trackmate(path, fps=250.0, unit="mm"), ("Track_0", "Track_3"), unit="mm",
          scale=1e-3)  # fmt: skip
    with pytest.raises(InputError, match=r"positions are in 'px', and 'mm' is asked for"):
        read_trackmate(table(tmp_path / "spots.csv"), fps=250.0, unit="mm")


@pytest.mark.parametrize("heads", [1, 3])
def test_a_table_without_units_is_said(tmp_path, heads):
    path = table(tmp_path / "spots.csv", heads=heads)
    with pytest.warns(InputWarning, match=r"spots.csv: it says no unit, and lengths are called px"):
        check(read_trackmate(path, fps=250.0), ("Track_0", "Track_3"))
    check(read_trackmate(path, fps=250.0, unit="cm"), ("Track_0", "Track_3"), unit="cm")


def test_tracks_that_were_filtered_away_are_left_out(tmp_path):
    tracks = read_trackmate(project(tmp_path / "m1.xml", kept=(3,)), fps=250.0)
    assert tracks["keypoint"].values.tolist() == ["hind paw"]


@pytest.mark.parametrize(
    ("write", "old", "new", "message"),
    [
        (table, "ID31,31,3", "ID31,31,0", "point 'Track_0' has 2 places in frame 3"),
        (table, ",50.0,", ",far,", "'far'; expected a number"),
        (project, '"hind paw"', '"Track_0"', "two tracks are called 'Track_0'"),
        (project, 'Spot ID="31"', 'Spot ID="77"', "spot 31 of hind paw is not there"),
        (project, "Model", "Module", "no Model in it"),
        (exported, 'x="5.5"', 'x=""', "x: ''; expected a number"),
        (exported, "particle", "part", None),
    ],
)
def test_what_is_wrong_is_one_sentence(tmp_path, write, old, new, message):
    path = write(tmp_path / "m1.txt")
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    with pytest.raises(InputError, match=rf"^m1.txt: .*{message or 'no point'}"):
        read_trackmate(path, fps=250.0)
