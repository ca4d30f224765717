"""Folders of results: whole, or known not to be, whatever happens while they are written."""

from __future__ import annotations

import errno
import hashlib
import json
import os
import signal
import subprocess
import sys
import warnings
from contextlib import contextmanager
from pathlib import Path

import pytest

from pawnb.errors import InputError, InputWarning
from pawnb.files import Listing, locked
from pawnb.workflow.provenance.manifest import (
    MANIFEST,
    PUT_ASIDE,
    find_fault,
    read_manifest,
    run_alone,
    writing_results,
)

TRACK = {"step": "track", "inputs": {"cam1.avi": "sha256:0"}}
GAIT = {"step": "gait", "inputs": {}}

posix = pytest.mark.skipif(os.name == "nt", reason="fork and signals of POSIX")


def write(folder, *, run="track", text="", names=("tracks.csv", "tracks.nc"), steps=None):
    """Write a run whose files say which it was."""
    folder.mkdir(exist_ok=True)
    steps = [TRACK if run == "track" else GAIT] if steps is None else steps
    with writing_results(folder, run=run, steps=steps) as staging:
        for name in names:
            (staging / name).parent.mkdir(exist_ok=True)
            (staging / name).write_text(f"{name} {text}")
    return folder


def content(folder):
    return {
        path.relative_to(folder).as_posix(): path.read_text()
        for path in folder.rglob("*")
        if path.is_file()
    }


def test_every_file_is_listed_with_its_checksum(tmp_path):
    out = write(tmp_path / "out", names=("a.csv", "figures/b.png"))
    document = json.loads((out / MANIFEST).read_text())
    assert document["steps"] == [TRACK]
    assert document["files"] == {
        name: {"run": "track", "sha256": hashlib.sha256((out / name).read_bytes()).hexdigest()}
        for name in ("a.csv", "figures/b.png")
    }
    assert sorted(content(out)) == ["a.csv", "figures/b.png", MANIFEST]
    assert find_fault(out, run="track") is None


def test_the_same_runs_give_the_same_bytes_wherever_and_in_whatever_order(tmp_path):
    one, two = tmp_path / "one", tmp_path / "two"
    write(one)
    write(one, run="gait", names=("strides.csv",))
    write(two, run="gait", names=("strides.csv",))
    write(two, text="first")
    write(two)
    assert content(one) == content(two)


def test_each_kind_of_run_keeps_what_the_other_wrote(tmp_path):
    out = write(tmp_path / "out")
    before = read_manifest(out).files_of("track")
    write(out, run="gait", names=("strides.csv", "figures/a.png"))
    known = read_manifest(out)
    assert known.files_of("track") == before
    assert known.steps == [TRACK, GAIT]
    assert find_fault(out, run="track") is None
    # and says nothing that is not so: a changed file is not taken for whole
    (out / "tracks.nc").write_text("other")
    write(out, run="gait", names=("strides.csv",))
    assert read_manifest(out).files_of("track") == before
    assert "(changed: tracks.nc)" in find_fault(out, run="track")
    assert find_fault(out, run="gait") is None


def test_files_of_the_run_before_that_are_not_made_again_go(tmp_path):
    out = write(tmp_path / "out", names=("tracks.nc", "points3d.csv", "pose.csv"))
    write(out, run="gait", names=("figures/a.png", "figures/b.png"))
    (out / "pose.csv").write_text("changed by hand")
    (out / "figures" / "own.png").write_text("of a person")
    with pytest.warns(InputWarning, match=r"pose\.csv was changed by hand .* not of these results"):
        write(out, names=("tracks.nc",))
    write(out, run="gait", names=("figures/b.png",))
    assert sorted(content(out)) == [
        "figures/b.png", "figures/own.png", "pose.csv", MANIFEST, "tracks.nc",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (lambda out: (out / "tracks.nc").unlink(), "missing: tracks.nc"),
        (lambda out: (out / "tracks.csv").write_text("1"), "changed: tracks.csv"),
        (lambda out: (out / MANIFEST).unlink(), "may not be whole"),
        (lambda out: (out / MANIFEST).write_text("[" * 10**5), "may not be whole"),
        (lambda out: (out / MANIFEST).write_text('{"steps": []}'), "lists no files"),
    ],
)
def test_what_is_wrong_is_one_sentence_with_a_remedy(tmp_path, spoil, said):
    out = write(tmp_path / "out")
    spoil(out)
    fault = find_fault(out, run="track")
    assert said in fault
    assert "run pawnb track again" in fault
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", ".* kept under other names", InputWarning)
        write(out)
    assert find_fault(out, run="track") is None


def test_tables_of_a_person_are_kept_where_a_run_writes_some_of_that_name(tmp_path):
    """A lab's animals.csv beside the tracks of a mouse was written over, without a word."""
    (tmp_path / "animals.csv").write_text("animal,weight\nm01,20\n")
    (tmp_path / "same.csv").write_text("same.csv ")
    names = ("animals.csv", "same.csv", "strides.csv")
    with pytest.warns(InputWarning, match=r"names: animals\.csv as animals\.before\.csv\.$"):
        write(tmp_path, run="gait", names=names)
    assert (tmp_path / "animals.before.csv").read_text() == "animal,weight\nm01,20\n"
    assert (tmp_path / "animals.csv").read_text() == "animals.csv "
    before = content(tmp_path).keys()
    write(tmp_path, run="gait", names=names, text="again")  # files of a run are just replaced
    assert content(tmp_path).keys() == before
    (tmp_path / "strides.csv").write_text("changed in a spreadsheet")
    with pytest.warns(InputWarning, match=r"names: strides\.csv as strides\.before\.csv\.$"):
        write(tmp_path, run="gait", names=names)
    assert (tmp_path / "strides.before.csv").read_text() == "changed in a spreadsheet"


def test_gait_of_other_tracks_or_edits_is_told(tmp_path):
    out = write(tmp_path / "out")
    sums = {
        f"out/{name}": f"sha256:{hashlib.sha256((out / name).read_bytes()).hexdigest()}"
        for name in ("tracks.nc",)
    }
    write(out, run="gait", names=("strides.csv",), steps=[{"step": "gait", "inputs": sums}])
    assert find_fault(out, run="gait") is None
    (out / "event_edits.jsonl").write_text('{"edit": "undo"}\n')
    assert "event_edits.jsonl has changed" in find_fault(out, run="gait")
    (out / "event_edits.jsonl").unlink()
    write(out, text="again")
    assert "tracks.nc has changed since the gait was analysed" in find_fault(out, run="gait")
    assert find_fault(out, run="track") is None


@posix
@pytest.mark.slow
def test_killed_between_any_two_renames_the_folder_is_whole_or_says_that_it_is_not(tmp_path):
    """A run is killed at its first, second, ... rename; an earlier run and its gait are there."""
    old = {name: f"{name} old" for name in ("tracks.csv", "tracks.nc")}
    new = {name: f"{name} new" for name in ("pose.csv", "tracks.csv", "tracks.nc")}
    states = []
    for number in range(20):
        out = write(tmp_path / f"out{number}", text="old")
        write(out, run="gait", names=("strides.csv",))
        ended = _killed_at(number, lambda out=out: write(out, text="new", names=tuple(new)))
        found = {k: v for k, v in content(out).items() if k in new}
        whole = find_fault(out, run="track") is None
        # a file that was not there before changes nothing of what the old list says
        unmixed = found in (old, old | {"pose.csv": "pose.csv new"})
        assert whole == (unmixed or ended)
        assert not ended or found == new
        assert find_fault(out, run="gait") is None
        states.append(whole)
        write(out, text="new", names=tuple(new))
        assert {k: v for k, v in content(out).items() if k in new} == new
        assert find_fault(out, run="track") is None
        assert not [name for name in content(out) if ".pawnb" in name or name == PUT_ASIDE]
        if ended:
            break
    assert ended
    assert states.count(False) >= 2


@pytest.mark.slow
@posix
def test_killed_in_a_new_folder_it_says_so(tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    faults = []
    while not _killed_at(len(faults), lambda: write(out)):
        faults.append(find_fault(out, run="track"))
        for path in out.iterdir():
            path.unlink() if path.is_file() else [*map(Path.unlink, path.iterdir()), path.rmdir()]
    assert len(faults) > 3
    assert all(faults)
    assert any("was ended while it wrote" in fault for fault in faults)


def _killed_at(number, run):
    """Run in a process that kills itself at its nth rename; say whether it came to its end."""
    child = os.fork()
    if child == 0:
        renames = iter(range(10**6))
        rename = os.replace

        def kill_or_rename(*args, **options):
            if next(renames) == number:
                os.kill(os.getpid(), signal.SIGKILL)
            rename(*args, **options)

        os.replace = os.rename = kill_or_rename
        run()
        os._exit(0)
    return os.waitpid(child, 0)[1] == 0


def _fail_half_way(out, run):
    with writing_results(out, run=run, steps=[]) as staging:
        (staging / "tracks.csv").write_text("new")
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def test_an_error_while_files_are_made_changes_nothing(tmp_path):
    out = write(tmp_path / "out", text="old")
    before = content(out)
    for run in ("track", "gait"):
        with pytest.raises(InputError, match=r"out: cannot be written .No space left"):
            _fail_half_way(out, run)
    assert content(out) == before
    assert find_fault(out, run="track") is None


@contextmanager
def held_open(path, monkeypatch):
    """Hold a file open as a spreadsheet does; only Windows then lets nothing take its place."""
    if os.name == "nt":
        with path.open("rb"):
            yield
        return
    replace = os.replace

    def refuse(source, target):
        if Path(target) == path:
            raise PermissionError(errno.EACCES, "The process cannot access the file")
        replace(source, target)

    with monkeypatch.context() as patch:
        patch.setattr("os.replace", refuse)
        yield


def test_a_file_that_another_program_holds_open_is_named_before_anything_changes(
    tmp_path, monkeypatch
):
    out = write(tmp_path / "out", text="old")
    before = content(out)
    said = r"tracks\.nc: cannot be replaced .*close it in other programs, such as a spreadsheet"
    with held_open(out / "tracks.nc", monkeypatch):
        # while files are moved, and before a run that may take hours
        with pytest.raises(InputError, match=said), run_alone(out):
            pytest.fail("the run begins")
        with pytest.raises(InputError, match=said), writing_results(out, run="track", steps=[]):
            pytest.fail("the run begins")
        listing = Listing(out, MANIFEST, PUT_ASIDE)
        (tmp_path / "staging").mkdir()
        (tmp_path / "staging" / "tracks.csv").write_text("new")
        with pytest.raises(InputError, match=said):
            listing.replace(
                tmp_path / "staging", ["tracks.csv"], gone=["tracks.nc"], listing=b"", empty=b""
            )
    assert content(out) == before
    assert find_fault(out, run="track") is None
    assert content(write(out, text="new")) != before


def test_messages_name_the_folder_that_was_asked_for(tmp_path):
    out = write(tmp_path / "out")
    (out / "a.csv").mkdir()
    with pytest.raises(InputError, match=r"out.a\.csv: a folder") as caught:
        write(out, names=("a.csv",))
    assert ".pawnb" not in str(caught.value)
    assert find_fault(out, run="track") is None


@pytest.mark.skipif(os.name == "nt", reason="links need rights there")
def test_a_folder_of_figures_that_leads_elsewhere_is_refused(tmp_path):
    out = write(tmp_path / "out")
    (tmp_path / "elsewhere").mkdir()
    (out / "figures").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(InputError, match=r"leads to .*elsewhere"):
        write(out, run="gait", names=("figures/a.png",))
    assert list((tmp_path / "elsewhere").iterdir()) == []


@pytest.mark.slow
def test_a_second_run_is_refused_while_one_writes(tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    code = (
        "import sys\nfrom pathlib import Path\n"
        "from pawnb.workflow.provenance.manifest import run_alone\n"
        "with run_alone(Path(sys.argv[1])):\n    print(flush=True)\n    sys.stdin.read()\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", code, str(out)], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as process:
        process.stdout.readline()
        with pytest.raises(InputError, match=rf"process {process.pid} .*another folder with --out"):
            write(out)
        process.communicate()
    write(out)
    with locked(out, remedy="wait"):  # within a run that holds the folder already
        write(out)
    assert find_fault(out, run="track") is None
