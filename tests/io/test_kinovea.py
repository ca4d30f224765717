"""Trajectories of Kinovea, laid out as its source and published files of users have them."""

import re

import numpy as np
import pytest

from pawnb.errors import InputError, InputWarning
from pawnb.io import read_any_tracks, read_kinovea, recognise_format
from pawnb.workflow.gait.sources import read_source

N = 30
PLACE = {
    "FR": np.column_stack([300 + 4.25 * np.arange(N), 200 - 2.5 * np.sin(np.arange(N))]).round(2),
    "patte arrière": np.column_stack([250 + 4.5 * np.arange(N), np.full(N, 205.25)]),
}


def kva(path, *, version="2.0", rate="200", each=512, first=1024, relative=False, label=False):
    """As MetadataSerializer.cs and DrawingTrack.cs of Kinovea 2023.1 write it, or, with relative
    times and integers, 0.8.15 did; the name is an attribute, or that of the label before."""
    lines = ['<?xml version="1.0" encoding="utf-8"?>', "<KinoveaVideoAnalysis>",
             f"  <FormatVersion>{version}</FormatVersion>",
             "  <Producer>Kinovea.2023.1.2</Producer>", "  <ImageSize>640;480</ImageSize>",
             f"  <AverageTimeStampsPerFrame>{each}</AverageTimeStampsPerFrame>",
             f"  <CaptureFramerate>{rate}</CaptureFramerate>",
             f"  <FirstTimeStamp>{first}</FirstTimeStamp>", "  <Tracks>"]  # fmt: skip
    for begin, (name, place) in enumerate(PLACE.items(), start=3):  # trajectories begin apart
        named = "" if label else f' id="a" name="{name}"'
        lines += [f"    <Track{named}>",
                  f"      <TimePosition>{first + begin * each}</TimePosition>",
                  f'      <TrackPointList Count="{N}">']  # fmt: skip
        for i, (x, y) in enumerate(place):
            stamp = i * each if relative else first + (begin + i) * each
            lines.append(f"        <TrackPoint>{x + 0.5:.7g};{y + 0.5:.7g};{stamp}</TrackPoint>")
        lines += ["      </TrackPointList>", f'      <MainLabel Text="{name}" />', "    </Track>"]
    lines += ["  </Tracks>", "  <Trackability />", "</KinoveaVideoAnalysis>"]
    path.write_bytes(b"\xef\xbb\xbf" + "\r\n".join(lines).encode())
    return path


def comma(value):
    return f"{value:.2f}".replace(".", ",")


def gnuplot(path, *, time=lambda i: f"{i / 200:.3f}", named=True, word=comma):
    """As ExporterTXTTrajectory.cs writes it; older ones name no trajectory."""
    lines = ["#Kinovea Trajectory data export", "#T X Y", ""]
    for name, place in PLACE.items():
        lines += [f"# {name}"] if named else []
        lines += [f"{time(i)} {word(x)} {word(240 - y)} " for i, (x, y) in enumerate(place)]
        lines.append("")
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


def table(path, *, mark=";", word=comma):
    """As ExporterCSV.cs writes it: the second trajectory begins two frames later."""
    names = [f"{name}/0/{axis}" for name in PLACE for axis in "XY"]
    lines = [mark.join(f'"{name}"' for name in ("Time", *names))]
    for i in range(N + 2):
        cells = [word(1000 * i / 200)]
        for begin, place in zip((0, 2), PLACE.values(), strict=True):
            inside = 0 <= i - begin < N
            x, y = place[i - begin] if inside else (0, 0)
            cells += [word(x), word(240 - y)] if inside else ["", ""]
        lines.append(mark.join(f'"{cell}"' if cell else "" for cell in cells))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize("how", [{}, {"relative": True}, {"label": True}])
def test_a_kva_is_read_in_pixels_with_its_frames(tmp_path, how):
    path = kva(tmp_path / "m1.kva", **how)
    assert recognise_format(path) == "kinovea"
    tracks = read_any_tracks(path, fps=200.0, unit="mm")  # whatever is asked for, it is in px
    assert tracks["keypoint"].values.tolist() == list(PLACE)
    assert tracks["frame"].values.tolist() == list(range(3, N + 4))
    assert tracks.attrs["units"] == "px"
    place = tracks["position"].to_numpy()[..., 0]
    np.testing.assert_allclose(place[:N, :, 0], PLACE["FR"], atol=1e-4)
    np.testing.assert_allclose(place[1:, :, 1], PLACE["patte arrière"], atol=1e-4)
    assert np.isnan(place[N:, :, 0]).all()
    assert np.isnan(place[0, :, 1]).all()


@pytest.mark.parametrize("each", [2, 3])
def test_frames_that_last_no_whole_number_of_time_stamps_are_counted_rightly(tmp_path, each):
    """240 frames a second in 600 time stamps a second: 2.5 each, and the file says 2 or 3."""
    path = kva(tmp_path / "m1.kva", rate="240", each=each, first=0)
    text = path.read_text(encoding="utf-8-sig")
    stamp = re.compile(r";(\d+)</TrackPoint>")
    text = stamp.sub(lambda m: f";{round(int(m[1]) / each * 2.5)}</TrackPoint>", text)
    path.write_text(text, encoding="utf-8")
    tracks = read_kinovea(path, fps=240.0)
    assert tracks["frame"].values.tolist() == list(range(3, N + 4))
    np.testing.assert_allclose(tracks["position"].to_numpy()[:N, :, 0, 0], PLACE["FR"], atol=1e-4)


@pytest.mark.parametrize("kept", [(0, 1, 3), (0, 4, 5, 11), (2,)])
def test_few_frames_that_were_tracked_keep_their_numbers(tmp_path, kept):
    points = "".join(f"<TrackPoint>1;2;{512 * i}</TrackPoint>" for i in kept)
    path = tmp_path / "m1.kva"
    path.write_text(
        "<KinoveaVideoAnalysis><FormatVersion>2.0</FormatVersion><AverageTimeStampsPerFrame>512"
        '</AverageTimeStampsPerFrame><Tracks><Track name="FR"><TrackPointList>'
        f"{points}</TrackPointList></Track></Tracks></KinoveaVideoAnalysis>"
    )
    tracks = read_kinovea(path, fps=200.0)
    seen = np.isfinite(tracks["position"].to_numpy()[:, 0, 0, 0])
    assert tuple(tracks["frame"].values[seen]) == kept


def test_every_second_frame_that_was_tracked_keeps_its_number(tmp_path):
    path = kva(tmp_path / "m1.kva", first=0)
    text = path.read_text(encoding="utf-8-sig")
    stamp = re.compile(r";(\d+)</TrackPoint>")
    path.write_text(stamp.sub(lambda m: f";{2 * int(m[1])}</TrackPoint>", text), encoding="utf-8")
    frames = read_kinovea(path, fps=200.0)["frame"].values
    assert (frames[0], frames[-1]) == (6, 2 * (N + 3))


def test_another_rate_than_that_of_a_kva_is_said(tmp_path):
    with pytest.warns(InputWarning, match=r"says 25 frames per second, and fps is given as 200"):
        read_kinovea(kva(tmp_path / "m1.kva", rate="25"), fps=200.0)


@pytest.mark.parametrize("named", [True, False])
def test_the_text_is_read_with_decimal_commas_and_y_upwards(tmp_path, named):
    path = gnuplot(tmp_path / "m1.txt", named=named)
    assert recognise_format(path) == "kinovea"
    with pytest.warns(InputWarning, match=r"m1.txt: it says no unit, .* px, with y upwards"):
        tracks = read_kinovea(path, fps=200.0)
    assert tracks["keypoint"].values.tolist() == (list(PLACE) if named else ["track1", "track2"])
    assert tracks["frame"].values.tolist() == list(range(N))
    for k, place in enumerate(PLACE.values()):
        np.testing.assert_allclose(
            tracks["position"].to_numpy()[:, :, k, 0], place - [0, 240], atol=1e-9
        )


@pytest.mark.parametrize(
    "time",
    [lambda i: f"0:00:05:{i // 2:02d}" if i % 2 == 0 else f"0:00:05:{i // 2:02d}5",
     lambda i: str(i), lambda i: f"{5 * i}", lambda i: f"{5000 * i}"],
)  # fmt: skip
def test_times_of_any_format_of_kinovea_give_the_frames(tmp_path, time):
    tracks = read_kinovea(gnuplot(tmp_path / "m1.txt", time=time), fps=200.0, unit="cm")
    assert (np.diff(tracks["frame"].values) == 1).all()
    assert len(tracks["frame"]) == N
    assert tracks.attrs["units"] == "cm"


@pytest.mark.parametrize(("mark", "word"), [(";", comma), (",", str)])
def test_the_csv_is_read_and_what_was_not_tracked_is_missing(tmp_path, mark, word):
    path = table(tmp_path / "m1.csv", mark=mark, word=word)
    assert recognise_format(path) == "kinovea"
    tracks = read_any_tracks(path, fps=200.0, unit="cm")
    assert tracks["keypoint"].values.tolist() == list(PLACE)
    place = tracks["position"].to_numpy()[..., 0]
    np.testing.assert_allclose(place[:N, :, 0], PLACE["FR"] - [0, 240], atol=1e-9)
    np.testing.assert_allclose(place[2:, :, 1], PLACE["patte arrière"] - [0, 240], atol=1e-9)
    assert np.isnan(place[:2, :, 1]).all()


def test_several_points_of_an_object_are_numbered(tmp_path):
    path = tmp_path / "m1.txt"
    path.write_text("#Kinovea Trajectory data export\n#T X Y\n\n# knee\n0 1 2 3 4\n5 1 2 3 4\n")
    tracks = read_kinovea(path, fps=200.0, unit="cm")
    assert tracks["keypoint"].values.tolist() == ["knee 1", "knee 2"]
    assert tracks["position"].to_numpy()[0, :, 1, 0].tolist() == [3, -4]


def test_a_trajectory_without_a_point_is_left_out(tmp_path):
    path = tmp_path / "m1.txt"
    path.write_text("#Kinovea Trajectory data export\n#T X Y\n\n# FR\n\n# HR\n0 1 2\n5 2 3\n")
    tracks = read_kinovea(path, fps=200.0, unit="cm")
    assert tracks["keypoint"].values.tolist() == ["HR"]


def test_a_file_goes_straight_to_the_gait(tmp_path):
    source = read_source(kva(tmp_path / "m1.kva"), fps=200.0)
    assert source.trial.name == "m1"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("FormatVersion>2.0", "FormatVersion>1.5"), r"before 0.8.16; open it"),
        (("Frame>512", "Frame>0"), r"AverageTimeStampsPerFrame is 0"),
        (("300.5;200.5;2560", "300.5;200.5"), "a TrackPoint without x;y;time"),
        (("300.5;200.5;2560", "300.5;nan;2560"), "a TrackPoint: 'nan'; expected a number"),
        (('"patte arrière">', '"FR">'), "two trajectories are called 'FR'"),
        (("3072</TrackPoint>", "2560</TrackPoint>"), "point 'FR' has 2 places in frame 3"),
        (("Tracks>", "Chronos>"), "no trajectory in it; track the feet"),
    ],
)
def test_what_is_wrong_with_a_kva_is_one_sentence(tmp_path, change, message):
    path = kva(tmp_path / "m1.kva")
    text = path.read_text(encoding="utf-8-sig")
    assert change[0] in text
    path.write_text(text.replace(*change), encoding="utf-8")
    with pytest.raises(InputError, match=rf"^m1.kva: .*{message}") as caught:
        read_kinovea(path, fps=200.0)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("row", "message"),
    [("0,1 5", "row without time, x and y"), ("0,1 5 x", r"line 5: 'x'; expected a number")],
)
def test_a_damaged_text_is_refused(tmp_path, row, message):
    path = tmp_path / "m1.txt"
    path.write_text(f"#Kinovea Trajectory data export\n#T X Y\n\n# FR\n{row}\n")
    with pytest.raises(InputError, match=re.compile(message)):
        read_kinovea(path, fps=200.0, unit="cm")


@pytest.mark.parametrize("cell", ["100,25 px", "100,25px", "3.5 cm"])
def test_lengths_with_their_unit_behind_them_are_refused_with_what_to_do(tmp_path, cell):
    path = tmp_path / "clip.txt"
    path.write_text(f"#Kinovea Trajectory data export\n#T X Y\n\n# FR\n0 {cell} -3\n")
    unit = cell[-2:]
    with pytest.raises(InputError, match=rf"line 5: '{cell}'; .* bare numbers: take '{unit}' away"):
        read_kinovea(path, fps=200.0)


def test_time_codes_of_a_csv_are_read_as_those_of_the_text(tmp_path):
    """Hundredths of seconds at 25 frames a second: 0, 4, 8 ..."""
    rows = [f"0:00:01:{4 * i:02d},{10 + i},-5" for i in range(5)]
    (tmp_path / "clip.csv").write_text("\n".join(["Time,FR/0/X,FR/0/Y", *rows]) + "\n")
    tracks = read_kinovea(tmp_path / "clip.csv", fps=25.0, unit="mm")
    assert np.diff(tracks["frame"].to_numpy()).tolist() == [1, 1, 1, 1]
    assert tracks["position"].to_numpy()[:, 0].ravel().tolist() == [10.0, 11.0, 12.0, 13.0, 14.0]
