"""Tracks that do not fit the film of their trial: how both were made is known."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from pawnb.trial import load_trial
from pawnb.workflow.checking.check import check_trial
from pawnb.workflow.conversion.film_of_tracks import doubt_film_of_tracks
from pawnb.workflow.conversion.foreign_tracks import read_foreign_tracks
from pawnb.workflow.gait.run import run_gait

WIDTH, HEIGHT, N, FPS = 160, 120, 80, 25


@pytest.fixture(scope="module")
def film(tmp_path_factory):
    path = tmp_path_factory.mktemp("film") / "clip.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), FPS, (WIDTH, HEIGHT))
    for i in range(N):
        writer.write(np.full((HEIGHT, WIDTH, 3), i, np.uint8))
    writer.release()
    return path


def write_trial(folder, film, frames, *, fps=FPS, more="", view="", zoom=1.0, sure=1.0):
    """Feet that step to and fro in the film, as DeepLabCut writes them, and their trial."""
    head = [["scorer"], ["bodyparts"], ["coords"]]
    for point in ("FR", "HR", "FL", "HL"):
        for coord in ("x", "y", "likelihood"):
            for row, cell in zip(head, ("DLC_net", point, coord), strict=True):
                row.append(cell)
    rows = []
    for frame in frames:
        cells = [str(frame)]
        for k in range(4):
            u = zoom * (40.0 + 25.0 * (k % 2) + 12.0 * np.sin(0.8 * frame + 1.5 * k))
            cells += [f"{u:.2f}", f"{zoom * (90.0 + k):.2f}", str(sure)]
        rows.append(cells)
    (folder / "clipDLC.csv").write_text("\n".join(",".join(row) for row in [*head, *rows]) + "\n")
    (folder / "trial.toml").write_text(
        f'[trial]\nkind = "tracks"\nname = "t"\nfps = {fps}\n{more}\n[animal]\nid = "m"\n'
        f'[[views]]\nname = "side"\nvideo = "{film.as_posix()}"\n{view}\n'
        '[tracks]\nfile = "clipDLC.csv"\n'
    )
    return load_trial(folder)


def doubts(*args, **options):
    trial = write_trial(*args, **options)
    return doubt_film_of_tracks(trial, read_foreign_tracks(trial))


def test_tracks_of_the_film_are_not_doubted(film, tmp_path):
    assert doubts(tmp_path, film, range(N)) == []
    assert doubts(tmp_path, film, range(N + 3)) == []  # frames that the container promises
    assert doubts(tmp_path, film, range(20, 50)) == []  # numbered as in the film
    assert doubts(tmp_path, film, range(40), more="frames = [0, 40]") == []
    assert doubts(tmp_path, tmp_path / "absent.avi", range(40)) == []


def test_every_second_picture_numbered_anew_is_told_with_the_rate_that_is_right(film, tmp_path):
    (said,) = doubts(tmp_path, film, range(N // 2))
    assert said.startswith("clipDLC.csv: frames 0 to 39, and the film of view 'side' has 80. Where")
    assert "only one picture in 2 was tracked" in said
    assert "fps = 12.5 is right" in said
    assert "frames = [0, 40] below [trial]" in said


def test_more_frames_than_the_film_has_and_those_from_1_are_told(film, tmp_path):
    (said,) = doubts(tmp_path, film, range(N + 40))
    assert "frames up to 119, and the film of view 'side' has 80: the tracks are of another" in said
    (said,) = doubts(tmp_path, film, range(1, N + 1))
    assert "frames 1 to 80, and the film of view 'side' has 80, 0 to 79" in said


def test_frames_of_a_film_that_began_at_another_time_are_those_of_its_own_file(film, tmp_path):
    def of_one_view(frames):
        write_trial(tmp_path, film, frames, view="offset = 10")
        words = (tmp_path / "trial.toml").read_text()
        words = words.replace('file = "clipDLC.csv"', 'file = { side = "clipDLC.csv" }')
        (tmp_path / "trial.toml").write_text(words)
        trial = load_trial(tmp_path)
        return doubt_film_of_tracks(trial, read_foreign_tracks(trial))

    assert of_one_view(range(N)) == []
    (said,) = of_one_view(range(1, N + 1))
    assert said.startswith("clipDLC.csv: frames 1 to 80, and the film of view 'side' has 80, 0 to")


def test_places_outside_of_the_pictures_are_told(film, tmp_path):
    (said,) = doubts(tmp_path, film, range(N), zoom=2.0)
    assert "100% of the places lie outside of the pictures of view 'side', which have 160 x" in said
    # the tracks must be in the pixels of the crop, and are in those of the whole picture
    (said,) = doubts(tmp_path, film, range(N), view="crop = [0, 60, 160, 120]")
    assert "which have 160 x 60 px" in said
    assert doubts(tmp_path, film, range(N), zoom=2.0, sure=0.1) == []
    scaled = "[calibration]\npx_per_unit = 4.0\nunit = 'mm'"
    assert doubts(tmp_path, film, range(N), view=scaled) == []
    assert len(doubts(tmp_path, film, range(N), view=scaled, zoom=2.0)) == 1


def test_a_film_that_is_faster_than_fps_is_told(film, tmp_path):
    (said,) = doubts(tmp_path, film, range(N), fps=10)
    assert said.startswith("side: the file says 25 frames/s, but fps is 10")


def test_check_and_gait_both_say_it(film, tmp_path):
    trial = write_trial(tmp_path, film, range(N // 2))
    assert any("one picture in 2" in doubt for doubt in check_trial(trial).doubts)
    run = run_gait(tmp_path, figures="none")
    assert any("one picture in 2" in note for note in run.tables.notes)
