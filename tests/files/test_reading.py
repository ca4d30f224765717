"""Whatever a person names as a file is refused in one sentence, at once, where it is none."""

import os
import socket
import time

import pytest

from pawnb.errors import CalibrationError, InputError
from pawnb.files import check_file, parse_toml, read_bytes, read_text, read_toml


def test_a_regular_file_is_read(tmp_path):
    file = tmp_path / "a.csv"
    file.write_bytes(b"\xef\xbb\xbfa,b\r\n1,2\r\n")
    assert check_file(file) == file
    assert read_bytes(file) == b"\xef\xbb\xbfa,b\r\n1,2\r\n"
    assert read_text(file) == "a,b\n1,2\n"


@pytest.mark.skipif(os.name == "nt", reason="pipes and sockets of POSIX")
def test_what_is_no_file_is_refused_at_once(tmp_path):
    pipe, loop, way = tmp_path / "pipe", tmp_path / "loop", tmp_path / "socket"
    os.mkfifo(pipe)
    loop.symlink_to(loop)
    with socket.socket(socket.AF_UNIX) as bound:
        bound.bind(str(way))
        named = {
            "a named pipe": pipe,
            "a device": "/dev/zero",
            "a folder": tmp_path,
            "a socket": way,
            "no such file": tmp_path / "none.csv",
            "cannot be read": loop,
        }
        begun = time.monotonic()
        for word, path in named.items():
            for read in (check_file, read_bytes, read_text, read_toml):
                with pytest.raises(InputError, match=word) as caught:
                    read(path, expected="a csv of clicks")
                assert "a csv of clicks" in str(caught.value)
        assert time.monotonic() - begun < 1
    for path in ("a\0b", "x" * 5000, tmp_path / "none" / "deep.csv", ""):
        with pytest.raises(InputError):
            read_text(path)


def test_the_error_is_of_the_kind_asked_for_and_knows_near_names(tmp_path):
    (tmp_path / "DLTcoefs.csv").touch()
    with pytest.raises(CalibrationError, match=r"did you mean .DLTcoefs\.csv"):
        check_file(tmp_path / "DLTcoef.csv", error=CalibrationError)


@pytest.mark.skipif(os.name == "nt", reason="a sparse file takes a terabyte there")
def test_too_large_a_file_is_refused_before_it_is_read(tmp_path):
    file = tmp_path / "large"
    with file.open("wb") as out:
        out.truncate(2**40)  # a sparse file: it takes no room on the disk
    with pytest.raises(InputError, match=r"1 TB large; expected .* of at most 1 GB"):
        read_bytes(file)
    with pytest.raises(InputError, match="of at most 1 MB"):
        read_toml(file)


@pytest.mark.skipif(not os.path.exists("/proc/self/maps"), reason="Linux only")  # noqa: PTH110
def test_a_file_that_hides_its_size_is_read_up_to_the_limit():
    with pytest.raises(InputError, match="larger than"):
        read_bytes("/proc/self/maps", most_bytes=10)


def test_text_of_another_encoding_names_the_line(tmp_path):
    file = tmp_path / "a.csv"
    file.write_bytes("frame\n1\nµ\n".encode("latin-1"))
    with pytest.raises(InputError, match="line 3 is not text in UTF-8"):
        read_text(file)


@pytest.mark.parametrize(
    "text",
    [
        "a = " + "[" * 100_000,
        "a = " + "{a = " * 100_000,
        "a" + ".a" * 250_000 + " = 1",
        "[" + "a . " * 200_000 + "a]",
        "[" + "'a b'.\"c\"." * 50_000 + "a]",
        "".join(f"[{'a.' * 15}x{i}]\n" for i in range(5000)) + "[" + "a." * 15 + "x0.y.z]",
        "a = " + "9" * 900_000,
        "a = 0x" + "f" * 900_000,
        "a" * 1_000_000,
        '"' * 1_000_000,
        "a = 2021-13-40",
        "a = '\0'",
    ],
    ids=range(12),
)
def test_hostile_settings_are_one_short_sentence_soon(text):
    begun = time.monotonic()
    with pytest.raises(InputError) as caught:
        parse_toml(text, where="trial.toml")
    assert time.monotonic() - begun < 5
    assert str(caught.value).startswith("trial.toml: ")
    assert len(str(caught.value)) < 300


def test_sound_settings_are_read():
    text = 'a.b.c = [0.1, 0.2, 1.5e-3]\n[[views]]\nvideo = "../../x.y.z/cam.1.2.avi"\nn = -1\n'
    assert parse_toml(text, where="x") == {
        "a": {"b": {"c": [0.1, 0.2, 0.0015]}},
        "views": [{"video": "../../x.y.z/cam.1.2.avi", "n": -1}],
    }


@pytest.mark.skipif(os.name == "nt", reason="there a backslash leads into a folder")
def test_a_path_written_on_windows_is_told_how_to_write_it(tmp_path):
    with pytest.raises(InputError, match=r"write / for \\ in paths, which every system"):
        check_file(tmp_path / r"films\cam1.avi")
    with pytest.raises(InputError, match=r"mend that line \(in paths write / for \\\)\.$"):
        parse_toml('video = "films\\cam1.avi"\n', where="trial.toml")


def test_what_backslashes_become_in_quotes_is_shown_and_told(tmp_path):
    """As in ``video = "..\trials\new.avi"``, where TOML reads a tab and a line break."""
    document = parse_toml('video = "..\\trials\\new.avi"\n', where="trial.toml")
    assert document["video"] == "..\trials\new.avi"
    with pytest.raises(InputError, match=r"\.\.\\trials\\new\.avi.*write / for \\"):
        check_file(tmp_path / document["video"])
    for typed in (r"C:\Users\me\cam1.avi", r"films\cam1.avi", r"D:\xray\cam1.avi"):
        with pytest.raises(InputError, match=r"mend that line \(in paths write / for \\\)\.$"):
            parse_toml(f'fps = 250\nvideo = "{typed}"\n', where="trial.toml")
