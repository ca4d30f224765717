"""Film and contact sheet: the right frames, the marks at the right places, faults in words.

The tracks are put by the test: FR stands at one place of cam1 in all frames, and was placed by hand
in frame 12. Pictures to compare with are read from the files by the engine and made smaller by cv2.
"""

import av
import cv2
import numpy as np
import pytest

import pawnb
from pawnb.core.video import open_views
from pawnb.errors import InputError
from pawnb.schema import ORIGIN_CODE, make_tracks
from pawnb.workflow.export.marks import Marks
from pawnb.workflow.export.tiles import best_columns

AT, FRAMES = (200.0, 70.0), (10, 35)


@pytest.fixture(scope="module")
def tracks(rendered_trial):
    trial = pawnb.load_trial(rendered_trial)
    made = make_tracks(
        range(40), ["FR", "HR"], fps=trial.fps, views=[v.name for v in trial.views], unit="mm"
    )
    place = {"view": "cam1", "keypoint": "FR", "individual": "animal"}
    place["individual"] = made["individual"].to_numpy()[0]
    made["image_position"].loc[place] = np.array(AT)
    made["image_origin"].loc[place] = ORIGIN_CODE["measured"]
    made["image_origin"].loc[place | {"time": made["time"].to_numpy()[12]}] = ORIGIN_CODE["edited"]
    return made


def plain(trial, frame, size):
    """Return the picture of cam1 at a size, without any mark."""
    with open_views(pawnb.load_trial(trial)) as views:
        image = views.frame(frame)["cam1"].image()
    return cv2.resize(image, size, interpolation=cv2.INTER_AREA).astype(float)


@pytest.mark.slow
def test_a_film_shows_the_frames_asked_for_in_order_with_the_point(
    rendered_trial, tracks, tmp_path
):
    told = []
    path = pawnb.export_film(
        rendered_trial, tracks, tmp_path / "film.mp4", frames=FRAMES, views=["cam1"], width=400,
        trail=0, play_fps=10, progress=lambda done, total: told.append((done, total)),
    )  # fmt: skip
    with av.open(str(path)) as film:
        assert film.streams.video[0].average_rate == 10
        shown = [frame.to_ndarray(format="rgb24").astype(float) for frame in film.decode(video=0)]
    assert told == [(k, 25) for k in range(1, 26)]
    assert len(shown) == 25
    height, width = shown[0].shape[:2]
    assert (width, height % 2) == (400, 0)
    # far enough apart in time that the mouse has moved
    places = [0, 8, 16, 24]
    whole = [plain(rendered_trial, FRAMES[0] + k, (width, height)) for k in places]
    for place, k in enumerate(places):
        off = [np.abs(shown[k] - other)[20:-30].mean() for other in whole]
        assert np.argmin(off) == place
    with open_views(pawnb.load_trial(rendered_trial)) as views:
        scale = 400 / views.readers["cam1"].width
    u, v = (round((x + 0.5) * scale - 0.5) for x in AT)
    red, green, blue = Marks.of_tracks(tracks).colours[0]
    ring = shown[0][v, u - 8 : u - 5]
    assert np.abs(ring - [red, green, blue]).mean(axis=1).min() < 60


def test_a_sheet_marks_the_point_and_only_it(rendered_trial, tracks, tmp_path):
    gone = tracks.copy(deep=True)
    gone["image_position"].values[:] = np.nan
    sheets = []
    for name, some in (("with", tracks), ("without", gone)):
        path = pawnb.export_sheet(
            rendered_trial, some, tmp_path / f"{name}.png", frames=[11, 12], views=["cam1"],
            width=410, trail=0,
        )  # fmt: skip
        sheets.append(cv2.imread(str(path)).astype(int))
    changed = np.abs(sheets[0] - sheets[1]).max(axis=2) > 0
    half = changed.shape[0] // 2
    parts = [changed[:half], changed[half:]] if changed.shape[0] > 250 else np.hsplit(changed, 2)
    extents = []
    for part in parts:
        u = np.nonzero(part)[1]
        with open_views(pawnb.load_trial(rendered_trial)) as views:
            scale = 410 / views.readers["cam1"].width
        at = (np.array(AT) + 0.5) * scale - 0.5
        extents.append(at[0] - u.min())
        # the ring, and the name beside it
        assert at[0] - 14 <= u.min() < at[0] - 5
        assert u.max() < at[0] + 45
    assert extents[1] > extents[0] + 2  # placed by hand: a second ring


def test_a_film_takes_a_range_as_the_sheet_and_the_page_do(rendered_trial, tracks, tmp_path):
    path = pawnb.export_film(
        rendered_trial,
        tracks,
        tmp_path / "film.mp4",
        frames=range(10, 12),
        views=["cam1"],
        width=80,
    )
    with av.open(str(path)) as film:
        assert len(list(film.decode(video=0))) == 2


def test_a_sheet_takes_evenly_spaced_frames_by_itself(rendered_trial, tracks, tmp_path):
    path = pawnb.export_sheet(rendered_trial, tracks, tmp_path / "s.png", width=160)
    assert cv2.imread(str(path)).shape[1] > 3 * 160


def test_faults_are_said_in_a_sentence_and_leave_no_file(rendered_trial, tracks, tmp_path):
    film, sheet = tmp_path / "a.mp4", tmp_path / "a.png"
    with pytest.raises(InputError, match=r"^a\.avi: a film is written as \.mp4; give it that"):
        pawnb.export_film(rendered_trial, tracks, tmp_path / "a.avi")
    with pytest.raises(InputError, match=r"^frames are 30 to 41; expected a part of 0 to 40, the"):
        pawnb.export_film(rendered_trial, tracks, film, frames=(30, 41))
    for several in ((1, 2, 3), range(0, 40, 5)):
        with pytest.raises(InputError, match=r"^frames are [38] numbers; a film shows frames that"):
            pawnb.export_film(rendered_trial, tracks, film, frames=several)
    with pytest.raises(InputError, match=r"^no view 'cam9'.*; there are cam1, cam2, cam3, cam4\.$"):
        pawnb.export_film(rendered_trial, tracks, film, views=["cam9"])
    with pytest.raises(InputError, match=r"^play_fps is 0; expected 0\.1 to 1000 frames a second"):
        pawnb.export_film(rendered_trial, tracks, film, play_fps=0)
    with pytest.raises(InputError, match=r"^width is 9; expected 64 to 8192 px\.$"):
        pawnb.export_sheet(rendered_trial, tracks, sheet, width=9)
    with pytest.raises(InputError, match=r"^frames are \[40\]; expected some of 0 to 39\.$"):
        pawnb.export_sheet(rendered_trial, tracks, sheet, frames=[40])
    with pytest.raises(InputError, match=r"^a\.jpg: a contact sheet is written as \.png"):
        pawnb.export_sheet(rendered_trial, tracks, tmp_path / "a.jpg")
    bare = tracks.drop_vars(["image_position", "image_origin", "image_confidence"])
    with pytest.raises(InputError, match=r"^these tracks are not those of one animal with posit"):
        pawnb.export_sheet(rendered_trial, bare, sheet)
    assert list(tmp_path.iterdir()) == []


def test_legs_of_a_jointed_animal_are_chains_from_the_body_outwards():
    points = ["body", "L1", "R1", "L1.BC", "L1.CF", "R1.BC"]
    tracks = make_tracks(range(2), points, fps=10.0, views=["top"], unit="px", space=("x", "y"))
    marks = Marks.of_tracks(tracks)
    assert [[points[p] for p in chain] for chain in marks.chains] == [
        ["L1.BC", "L1.CF", "L1"], ["R1.BC", "R1"],
    ]  # fmt: skip
    assert marks.colours[1] == marks.colours[3] == marks.colours[4] != marks.colours[2]


def test_four_wide_views_stand_in_two_columns_and_two_below_one_another():
    assert best_columns([(2048, 700)] * 4) == 2
    assert best_columns([(2048, 700)] * 2) == 1
    assert best_columns([(300, 700)] * 2) == 2


def test_names_in_any_script_are_written_and_stay_in_the_picture():
    points = ["<img src=x onerror=alert(1)>", "ж" * 60, "אב"]
    tracks = make_tracks(range(1), points, fps=10.0, views=["top"], unit="px", space=("x", "y"))
    tracks["image_position"].values[0, 0, :, :, 0] = [[5, 90, 95], [5, 50, 95]]
    image = np.zeros((100, 100, 3), np.uint8)
    Marks.of_tracks(tracks).draw(image, "top", 0, scale=1.0)
    assert image.any()
