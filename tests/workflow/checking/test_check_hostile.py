"""Whatever the files of a trial hold, ``pawnb check`` says in sentences what is wrong with them."""

from __future__ import annotations

import random
import re
import warnings

import av
import numpy as np
import pytest

from pawnb.errors import PawnbError
from pawnb.synthetic.colour_video import H264VideoWriter
from pawnb.workflow.checking.check import check_trial

pytestmark = pytest.mark.slow

TRIAL = """[trial]
kind = "paws"
name = "t"
fps = 250.0
frames = [0, 3]
[animal]
id = "m"
body = ["nose"]
[treadmill]
belt_speed = "belt.csv"
[[views]]
name = "cam1"
video = "cam1.avi"
crop = [0, 0, 64, 48]
offset = 0
facing = 1
points = ["FR"]
[[views]]
name = "cam2"
video = "cam2.avi"
mirror = false
[calibration]
dlt = "DLTcoefs.csv"
unit = "mm"
forward = [1, 0, 0]
lens = "lenses.toml"
[start]
points = "start.csv"
[tracking]
noise = 2.0
"""
LENS = "matrix = [[90, 0, 32], [0, 90, 24], [0, 0, 1]]\ndistortion = [0.1, 0, 0, 0]\n"
# two cameras that look along +Y from 500 in front of the origin, 100 apart
DLT = "\n".join(
    f"{a},{b}"
    for a, b in zip(
        [0.18, 0.064, 0, 32, 0, 0.048, -0.18, 24, 0, 0.002, 0],
        [0.18, 0.064, 0, 14, 0, 0.048, -0.18, 24, 0, 0.002, 0],
        strict=True,
    )
)
FILES = {
    "trial.toml": TRIAL,
    "lenses.toml": f"[cam1]\n{LENS}[cam2]\n{LENS}",
    "DLTcoefs.csv": DLT + "\n",
    "start.csv": "frame,view,point,u,v\n0,cam1,FR,30,20\n0,cam2,FR,12,20\n",
    "belt.csv": "frame,speed\n0,300\n2,310\n",
}
WORDS = [
    b"nan", b"inf", b"-1", b"0", b"9e18", b"1e400", b"9" * 20, b"9" * 5000, b"", b"\0", b"[", b"{",
    b'"', b"true", b'"x"', b"[]", b"-0.0", b"1e-320", b"\xff\xfe", b"\xef\xbb\xbf", b";", b"\n",
    b"\r", b",", b'"../../x"', b'"/dev/zero"', b"0.5", b"2147483648", b"9223372036854775807",
    b"-9223372036854775808", b"0x10", b'"cam1"', b"=", b"#", b"1979-05-27", b"'''",
    b"[" * 5000, b"a" + b".a" * 5000,
]  # fmt: skip


@pytest.fixture
def trial(tmp_path):
    for name in ("cam1.avi", "cam2.avi"):
        with av.open(str(tmp_path / name), "w") as container:
            stream = container.add_stream("mjpeg", rate=50)
            stream.width, stream.height, stream.pix_fmt = 64, 48, "yuvj420p"
            for _ in range(3):
                frame = av.VideoFrame.from_ndarray(np.full((48, 64, 3), 90, np.uint8))
                container.mux(stream.encode(frame))
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    return tmp_path


def changed(data, rng):
    """A word put in the place of another, a line twice, a byte changed, or the end cut off."""
    kind = rng.randrange(6)
    if kind == 0:
        return data[: rng.randrange(len(data))]
    if kind == 1:
        lines = data.split(b"\n")
        lines.insert(rng.randrange(len(lines)), rng.choice(lines))
        return b"\n".join(lines)
    if kind == 2:
        at = rng.randrange(len(data))
        return data[:at] + bytes([rng.randrange(256)]) + data[at + 1 :]
    for _ in range(rng.choice([1, 1, 1, 3])):
        places = [m.span() for m in re.finditer(rb'[\w.\-]+|"[^"]*"|\[[^\]]*\]', data)]
        start, end = rng.choice(places or [(0, 0)])
        data = data[:start] + rng.choice(WORDS) + data[end:]
    return data


def test_the_trial_itself_is_sound(trial):
    assert check_trial(trial).faults == []


@pytest.mark.parametrize("name", FILES)
def test_no_file_of_a_trial_leads_to_another_error_or_warning(trial, name):
    rng = random.Random(name)  # noqa: S311
    faults = 0
    for number in range(30):
        (trial / name).write_bytes(changed(FILES[name].encode(), rng))
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            try:
                said = check_trial(trial).faults
            except PawnbError as error:
                said = [str(error)]
        faults += bool(said)
        assert all(len(line) < 3000 for line in said), number
    assert faults > 15


def test_a_film_that_is_cut_is_named(tmp_path):
    """A patterned square goes on by 1 px a picture; after picture 29 it is 90 px further on."""
    rng = np.random.default_rng(3)
    ground = rng.integers(60, 90, (60, 240, 3)).astype(np.uint8)
    animal = rng.integers(100, 230, (24, 30, 3)).astype(np.uint8)
    with H264VideoWriter(tmp_path / "side.mp4", size=(240, 60), fps=50, crf=20) as writer:
        for k in range(60):
            picture, at = ground.copy(), k + 90 * (k > 29)
            picture[20:44, at : at + 30] = animal
            writer.write(picture)
    (tmp_path / "trial.toml").write_text(
        '[trial]\nkind = "paws"\nname = "t"\nfps = 50.0\n[animal]\nid = "m"\n'
        '[[views]]\nname = "side"\nvideo = "side.mp4"\npoints = ["nose"]\n'
    )
    (said,) = (one for one in check_trial(tmp_path).doubts if "leaps" in one)
    assert "side.mp4 leaps from frame 29 to 30: the film is cut there" in said
