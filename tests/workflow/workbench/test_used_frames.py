"""Frames to use are written into ``trial.toml``; everything else there stays as it was."""

import sys
from pathlib import Path

import pytest

from pawnb import InputError, load_trial
from pawnb.workflow.workbench.used_frames import write_frames

sys.path.append(str(Path(__file__).resolve().parents[2] / "widgets"))
import small_trial as scene

WRITTEN = """# mine
[trial]
kind = "paws"   # of a mouse
name = "run"
fps = 250.0
{frames}
[animal]
id = "m1"

[[views]]
name = "cam1"
video = "cam1.avi"
points = ["FR"]
"""


@pytest.fixture
def folder(tmp_path):
    scene.write_trial(tmp_path / "run")
    return tmp_path / "run"


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("", "frames = [3, 9]\n"),
        ("frames = [0, 40]  # all\n", "frames = [3, 9]  # all\n"),
    ],
)
def test_only_the_frames_change(folder, before, after):
    path = folder / "trial.toml"
    path.write_text(WRITTEN.format(frames=before))
    assert write_frames(load_trial(path), (3, 9)).frames == (3, 9)
    assert load_trial(path).frames == (3, 9)
    old = WRITTEN.format(frames="").splitlines()
    left = [line for line in path.read_text().splitlines() if "frames" not in line]
    assert [line for line in left if line] == [line for line in old if line]
    assert after in path.read_text()


def test_what_is_written_otherwise_is_left(folder):
    path = folder / "trial.toml"
    text = WRITTEN.format(frames="frames = [\n  0,\n  40,\n]\n")
    path.write_text(text)
    with pytest.raises(InputError, match=r"write frames = \[3, 9\] there yourself"):
        write_frames(load_trial(path), (3, 9))
    assert path.read_text() == text
