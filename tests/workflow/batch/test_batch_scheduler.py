"""A batch on the workers of a Dask scheduler: a cluster of this machine, listening on TCP."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import threading
import time

import pytest

from pawnb.cli import main
from pawnb.errors import InputError
from pawnb.io.native import read_tracks
from pawnb.trial import load_trial
from pawnb.workflow.batch import run as batch_module
from pawnb.workflow.batch.run import batch, is_tracked
from pawnb.workflow.tracking.track import track

QUICK = {"choose_path": False}


@pytest.fixture
def cluster():
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, protocol="tcp", dashboard_address=None
    ) as cluster:
        yield cluster


@pytest.mark.slow
def test_trials_are_tracked_by_the_workers_as_on_one_machine(trials, cluster, monkeypatch):
    """From a folder of its own, so that relative paths must become absolute on the way."""
    monkeypatch.chdir(trials)
    lines = []
    done = batch(
        ["a", "b", "broken"],
        settings=QUICK,
        scheduler=cluster.scheduler_address,
        report=lines.append,
    )
    assert done.table["status"].tolist() == ["tracked", "tracked", "failed"]
    assert len(lines) == 3
    assert "spider.avi" in done.failed["said"].item()
    alone = track(trials / "a", settings=QUICK)
    found = read_tracks(trials / "a" / "results" / "tracks.nc")
    assert found.drop_attrs().identical(alone.drop_attrs())
    again = batch(["a", "b"], settings=QUICK, scheduler=cluster.scheduler_address)
    assert again.table["status"].tolist() == ["skipped", "skipped"]


@pytest.mark.slow
def test_an_interrupt_stops_the_workers_and_takes_back_what_waits(trials, cluster, monkeypatch):
    stop = threading.Event()

    class Interrupted:
        def __enter__(self):
            return stop.is_set

        def __exit__(self, *_error):
            return None

    monkeypatch.setattr(batch_module, "interruptible", Interrupted)
    threading.Timer(1.0, stop.set).start()
    done = batch([trials / "a", trials / "b"], scheduler=cluster.scheduler_address)
    assert done.table["status"].tolist() == ["stopped", "stopped"]
    assert done.table["said"][1] == "not begun"
    assert not is_tracked(load_trial(trials / "a"), trials / "a" / "results", method="pawnb")


@pytest.mark.slow
def test_trials_wait_for_a_worker_and_are_taken_back(trials, monkeypatch):
    distributed = pytest.importorskip("distributed")
    asked = []

    class Interrupted:
        def __enter__(self):
            return lambda: asked.append(1) or len(asked) > 20

        def __exit__(self, *_error):
            return None

    monkeypatch.setattr(batch_module, "interruptible", Interrupted)
    with distributed.LocalCluster(
        n_workers=0, processes=False, protocol="tcp", dashboard_address=None
    ) as empty:
        done = batch([trials / "a"], scheduler=empty.scheduler_address)
    assert done.table["status"].tolist() == ["stopped"]
    assert done.table["said"][0] == "not begun"


@contextlib.contextmanager
def processes(folder, workers):
    """A scheduler and workers of one thread each, every one a process that can be killed."""
    file = folder / "scheduler.json"
    common = ["--scheduler-file", str(file), "--no-dashboard"]
    started = []

    def start(module, *options):
        command = [sys.executable, "-m", f"distributed.cli.{module}", *common, *options]
        started.append(subprocess.Popen(command, stderr=subprocess.DEVNULL))
        return started[-1]

    try:
        scheduler = start("dask_scheduler", "--host", "127.0.0.1", "--port", "0")
        # it is there before it is written
        while not file.exists() or not file.read_text().rstrip().endswith("}"):
            time.sleep(0.1)
        own = [start("dask_worker", "--nthreads", "1", "--no-nanny") for _ in range(workers)]
        yield json.loads(file.read_text())["address"], scheduler, own
    finally:
        for process in started:
            process.kill()
            process.wait()


def kill_once_begun(process, folder, results):
    """Kill a process as soon as one of the trials is being tracked."""

    def wait():
        while not any((folder / name / results).exists() for name in ("a", "b")):
            time.sleep(0.05)
        os.kill(process.pid, signal.SIGKILL)

    thread = threading.Thread(target=wait, daemon=True)
    thread.start()
    return thread


def whole_or_absent(folder):
    trial = load_trial(folder)
    results = folder / "results"
    return (
        is_tracked(trial, results, method="pawnb", settings=QUICK)
        or not (results / "provenance.json").exists()
    )


@pytest.mark.slow
def test_where_the_scheduler_is_killed_every_trial_has_a_line(trials, tmp_path, monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr("pawnb.workflow.batch.scheduler._CONNECT_S", 3.0)
    named = [trials / name for name in ("a", "b", "broken")]
    with processes(tmp_path, workers=1) as (address, scheduler, _):
        kill_once_begun(scheduler, trials, "results")
        done = batch(named, settings=QUICK, scheduler=address)
    assert len(done.table) == 3
    assert done.table["status"].tolist() == ["failed"] * 3
    assert done.table["said"].str.contains("no longer answers").tolist() == [True, True, True]
    assert all(whole_or_absent(trials / name) for name in ("a", "b"))
    again = batch(named[:2], settings=QUICK)
    assert set(again.table["status"]) <= {"tracked", "skipped"}


@pytest.mark.slow
def test_where_a_worker_is_killed_another_takes_its_trial(trials, tmp_path):
    pytest.importorskip("distributed")
    with processes(tmp_path, workers=1) as (address, _, workers):
        killed = kill_once_begun(workers[0], trials, "results")

        def replace():
            killed.join()
            command = [sys.executable, "-m", "distributed.cli.dask_worker", address,
                       "--nthreads", "1", "--no-nanny", "--no-dashboard"]  # fmt: skip
            workers.append(subprocess.Popen(command, stderr=subprocess.DEVNULL))

        threading.Thread(target=replace, daemon=True).start()
        try:
            done = batch([trials / "a", trials / "b"], settings=QUICK, scheduler=address)
        finally:
            workers[-1].kill()
            workers[-1].wait()
    assert done.table["status"].tolist() == ["tracked", "tracked"]
    assert all(whole_or_absent(trials / name) for name in ("a", "b"))


def test_one_sentence_where_there_is_no_scheduler(trials, monkeypatch):
    with pytest.raises(InputError, match="leave one out"):
        batch([trials / "a"], workers=2, scheduler="tcp://127.0.0.1:8786")
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InputError, match=r"pip install \"pawnb\[scheduler\]\""):
        batch([trials / "a"], scheduler="tcp://127.0.0.1:8786")


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "localhost"])
def test_an_address_without_a_scheduler_is_named(trials, address, monkeypatch, capsys):
    pytest.importorskip("distributed")
    monkeypatch.setattr("pawnb.workflow.batch.scheduler._CONNECT_S", 0.2)
    assert main(["batch", str(trials / "a"), "--scheduler", address]) == 2
    err = capsys.readouterr().err
    assert f"no Dask scheduler answers at '{address}'" in err
