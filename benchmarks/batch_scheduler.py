"""A batch on a Dask cluster: how much two workers gain, and what a queue of 10,000 trials costs.

Run it from the project's root, on a machine with at least two cores that does nothing else:

    python benchmarks/batch_scheduler.py                  # both, four minutes
    python benchmarks/batch_scheduler.py --only queue
    python benchmarks/batch_scheduler.py --out docs/accuracy/speed.csv    # and put them there

Scheduler and workers are processes of their own on this machine (``dask scheduler``, ``dask
worker --nthreads 1``), which talk through TCP as on a cluster.

*workers* tracks ``--trials`` rendered trials by one worker and by two, in turn, ``--turns`` times,
each time into a new folder of results, and compares the shortest times. Each worker is bound to a
core, as Slurm binds it (``cores=1``): a trial that has the machine to itself decodes on several.

*queue* hands ``--queued`` trials, each with a description of its own, to two workers that answer
at once instead of tracking: what is left is what queueing itself costs, in time a trial and in
memory of batch and scheduler.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import psutil
from points_speed import put_into

from pawnb.synthetic import render_mouse_trial
from pawnb.workflow.batch import scheduler as scheduler_module
from pawnb.workflow.batch.run import BatchReport, batch

MB = 2**20
ONE_THREAD = {**os.environ, **dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")}


def link_trials(one: Path, folder: Path, number: int) -> None:
    """Make so many trials of one: each has its own description and name, and the same files."""
    text = (one / "trial.toml").read_text()
    others = [path for path in one.iterdir() if path.name != "trial.toml"]
    for k in range(number):
        place = folder / f"t{k:05d}"
        place.mkdir(parents=True)
        (place / "trial.toml").write_text(text.replace('name = "', f'name = "t{k:05d}-', 1))
        for path in others:
            (place / path.name).symlink_to(path)


@contextlib.contextmanager
def cluster(workers: int) -> Iterator[tuple[str, psutil.Process]]:
    """Give the address of a scheduler with so many workers of one thread, and its process."""
    with tempfile.TemporaryDirectory() as folder, contextlib.ExitStack() as stack:
        file = Path(folder) / "scheduler.json"
        common = ["--scheduler-file", str(file), "--no-dashboard"]

        def start(module: str, *options: str) -> subprocess.Popen[bytes]:
            command = [sys.executable, "-m", f"distributed.cli.{module}", *common, *options]
            process = subprocess.Popen(command, stderr=subprocess.DEVNULL, env=ONE_THREAD)
            stack.callback(process.wait)
            stack.callback(process.kill)
            return process

        scheduler = start("dask_scheduler", "--host", "127.0.0.1", "--port", "0")
        # it is there before it is written
        while not file.exists() or not file.read_text().rstrip().endswith("}"):
            time.sleep(0.1)
        for number in range(workers):
            worker = start("dask_worker", "--nthreads", "1", "--no-nanny")
            if hasattr(psutil.Process, "cpu_affinity"):  # what it starts inherits it
                psutil.Process(worker.pid).cpu_affinity([number % (os.cpu_count() or 1)])
        address = json.loads(file.read_text())["address"]
        import distributed

        with distributed.Client(address) as client:
            client.wait_for_workers(workers)
        yield address, psutil.Process(scheduler.pid)


def need(report: BatchReport, status: str) -> None:
    """End where a trial is not what it should be: the times would mean nothing."""
    if set(report.table["status"]) != {status}:
        raise SystemExit(report.verdict() if len(report.failed) else report.text())


def gain(folder: Path, *, trials: int, frames: int, turns: int) -> dict[str, str]:
    """Return a row on what a second worker gains."""
    render_mouse_trial(folder / "one", frames=frames, scale=0.5)
    link_trials(folder / "one", folder / "trials", trials)
    took: dict[int, list[float]] = {1: [], 2: []}
    with cluster(1) as (one, _), cluster(2) as (two, _):
        # what is compiled once on a machine is compiled now
        need(batch(folder / "one", out=folder / "first", scheduler=two), "tracked")
        for turn in range(turns):
            for n, address in ((1, one), (2, two)):
                begun = time.perf_counter()
                out = folder / f"results-{turn}-{n}"
                need(batch(folder / "trials", out=out, scheduler=address), "tracked")
                took[n].append(time.perf_counter() - begun)
                print(f"  turn {turn + 1}, {n} workers: {took[n][-1]:.1f} s, load "
                      f"{os.getloadavg()[0]:.1f}", flush=True)  # fmt: skip
    alone, both = min(took[1]), min(took[2])
    return {
        "what": f"a batch of {trials} trials on a Dask cluster, two workers against one",
        "result": f"{alone / both:.2f} times as fast (best of {turns} turns: {alone:.1f} and "
        f"{both:.1f} s; each worker bound to one of {os.cpu_count()} cores, load "
        f"{os.getloadavg()[0]:.0f})",
        "command": "`python benchmarks/batch_scheduler.py --only workers`",
    }


def cpu_s(*processes: psutil.Process) -> list[float]:
    """Return the processor time of processes, in s."""
    return [sum(process.cpu_times()[:2]) for process in processes]


def answer_at_once(order: dict[str, Any], stop_name: str) -> tuple[str, str, str]:
    """Stand for tracking on a worker, which asks whether to stop before it begins."""
    import distributed

    if distributed.Event(stop_name).is_set():
        return "stopped", "", ""
    return "tracked", f"{order['out']}", "good"


def queue(folder: Path, *, queued: int) -> dict[str, str]:
    """Return a row on what queueing costs."""
    render_mouse_trial(folder / "small", frames=12, scale=0.2)
    link_trials(folder / "small", folder / "queued", queued)
    scheduler_module.track_on_worker = answer_at_once
    me, said = psutil.Process(), []
    with cluster(2) as (address, scheduler):
        begun, cpu = time.perf_counter(), cpu_s(me, scheduler)

        def tell(_line: str) -> None:
            said.append(1)
            if len(said) in (queued // 10, queued):
                rss = [process.memory_info().rss / MB for process in (me, scheduler)]
                sizes.append(rss)
                print(f"  {len(said)} trials: {time.perf_counter() - begun:.1f} s, batch "
                      f"{rss[0]:.0f} MB, scheduler {rss[1]:.0f} MB", flush=True)  # fmt: skip

        sizes: list[list[float]] = []
        need(
            batch(folder / "queued", out=folder / "out", scheduler=address, report=tell), "tracked"
        )
        ms = 1000 * (time.perf_counter() - begun) / queued
        own, its = (1000 * (now - then) / queued for now, then in
                    zip(cpu_s(me, scheduler), cpu, strict=True))  # fmt: skip
    early, late = sizes
    return {
        "what": f"{queued:,} trials queued on a Dask cluster whose two workers answer at once",
        "result": f"{own:.1f} ms of processor time a trial of `pawnb batch`, {its:.1f} of the "
        f"scheduler ({ms:.1f} ms by the clock, load {os.getloadavg()[0]:.0f} on {os.cpu_count()} "
        f"cores); memory of `pawnb batch` {early[0]:.0f} MB after the first tenth and "
        f"{late[0]:.0f} MB at the end, of the scheduler {early[1]:.0f} and {late[1]:.0f} MB",
        "command": "`python benchmarks/batch_scheduler.py --only queue`",
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--only", choices=["workers", "queue"], help="one of the two")
    parser.add_argument("--trials", type=int, default=6, help="to track (%(default)s)")
    parser.add_argument("--frames", type=int, default=300, help="of each (%(default)s)")
    parser.add_argument("--turns", type=int, default=2, help="of each way (%(default)s)")
    parser.add_argument("--queued", type=int, default=10_000, help="trials (%(default)s)")
    parser.add_argument("--out", type=Path, metavar="SPEED.csv", help="put it into this table")
    asked = parser.parse_args()
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        if asked.only != "queue":
            size = {"trials": asked.trials, "frames": asked.frames, "turns": asked.turns}
            rows.append(gain(Path(folder), **size))
        if asked.only != "workers":
            rows.append(queue(Path(folder), queued=asked.queued))
    for row in rows:
        print(f"{row['what']}: {row['result']}")
        if asked.out:
            put_into(asked.out, row)


if __name__ == "__main__":
    main()
