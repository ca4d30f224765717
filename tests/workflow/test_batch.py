"""Many trials, one process each, begun again where it stopped."""

from __future__ import annotations

import threading

import pytest

from pawnb.cli import main
from pawnb.errors import InputError
from pawnb.io.native import read_tracks
from pawnb.schema import add_provenance
from pawnb.trial import load_trial
from pawnb.workflow import batch as batch_module
from pawnb.workflow.batch import batch, find_trials, is_tracked
from pawnb.workflow.batch_places import Processes
from pawnb.workflow.results import write_track_results
from pawnb.workflow.track import track

QUICK = {"choose_path": False}


def test_failures_are_collected_and_what_is_done_is_skipped(trials, monkeypatch):
    lines = []
    done = batch([trials], settings=QUICK, workers=2, report=lines.append)
    assert done.table["status"].tolist() == ["tracked", "tracked", "failed"]
    assert len(lines) == 3
    assert "spider.avi" in done.failed["said"].item()
    assert done.verdict().startswith("1 of 3 trials failed: ")
    assert "\n" not in done.verdict()
    assert done.text() == "2 tracked, 1 failed"
    alone = track(trials / "a", settings=QUICK)
    assert (
        read_tracks(trials / "a" / "results" / "tracks.nc")
        .drop_attrs()
        .identical(alone.drop_attrs())
    )
    began = []
    monkeypatch.setattr(Processes, "begin", lambda _self, _number, order: began.append(order))
    again = batch([trials / "a", trials / "b"], settings=QUICK)
    assert again.table["status"].tolist() == ["skipped", "skipped"]
    assert began == []


def test_only_just_the_same_work_is_skipped(small_spider):
    """Whole results of the same files, settings and trial; corrections do not count against it."""
    out = small_spider / "results"
    trial = load_trial(small_spider)
    tracks = track(trial, settings=QUICK, out=out)

    def skipped(**options):
        return is_tracked(
            load_trial(small_spider), out, **{"method": "pawnb", "settings": QUICK, **options}
        )

    assert skipped()
    assert not skipped(settings={})
    with pytest.raises(InputError, match="unknown method"):
        skipped(method="slic-3d")
    corrected = add_provenance(tracks, step="retrack", settings={}, inputs={})
    write_track_results(corrected, out)
    assert skipped()
    toml = small_spider / "trial.toml"
    text = toml.read_text()
    toml.write_text(text.replace("fps = 125.0", "fps = 120.0"))
    assert not skipped()
    toml.write_text(text)
    assert skipped()
    start = small_spider / "start_pose.csv"
    before = start.read_text()
    start.write_text(before.replace("10,", "11,", 1))
    assert not skipped()
    start.write_text(before)
    assert skipped()
    (out / "pose.csv").unlink()
    assert not skipped()


def test_unfinished_results_are_not_skipped(small_spider):
    out = small_spider / "results"
    asked = []
    track(small_spider, settings=QUICK, out=out, stop=lambda: asked.append(1) or len(asked) > 12)
    assert not is_tracked(load_trial(small_spider), out, method="pawnb", settings=QUICK)


def test_corrections_by_hand_are_not_overwritten(trials):
    results = trials / "a" / "results"
    results.mkdir()
    (results / "edits.jsonl").write_text("{}\n")
    done = batch([trials / "a"], settings=QUICK)
    assert done.table["status"].tolist() == ["failed"]
    assert "holds corrections made by hand" in done.table["said"][0]
    assert sorted(path.name for path in results.iterdir()) == ["edits.jsonl"]


@pytest.mark.slow
def test_results_in_one_folder_have_the_names_of_the_trials(trials, tmp_path):
    out = tmp_path / "out"
    toml = trials / "b" / "trial.toml"
    toml.write_text(toml.read_text().replace('name = "b-', 'name = "a-'))
    done = batch([trials / "a", trials / "b"], settings=QUICK, out=out)
    assert done.table["status"].tolist() == ["tracked", "failed"]
    assert "would overwrite those of" in done.failed["said"].item()
    assert [path.name for path in out.iterdir()] == ["a-normal-still-01"]


@pytest.mark.slow
def test_a_process_that_dies_takes_no_other_with_it(trials, monkeypatch):
    """The interpreter itself ends while the first is tracked."""
    original = Processes.begin

    def begin(self, number, order):
        original(self, number, order)
        if number == 1:
            self._running[number].kill()

    monkeypatch.setattr(Processes, "begin", begin)
    done = batch([trials / "a", trials / "b"], settings=QUICK)
    assert done.table["status"].tolist() == ["failed", "tracked"]
    assert done.failed["said"].item().startswith("its process ended with status -9")


@pytest.mark.slow
def test_an_interrupt_stops_what_is_under_way_and_leaves_the_rest(trials, monkeypatch):
    stop = threading.Event()

    class Interrupted:
        def __enter__(self):
            return stop.is_set

        def __exit__(self, *_error):
            return None

    monkeypatch.setattr(batch_module, "interruptible", Interrupted)
    threading.Timer(0.5, stop.set).start()
    done = batch([trials / "a", trials / "b"])
    assert done.table["status"].tolist() == ["stopped", "stopped"]
    assert done.table["said"][1] == "not begun"
    assert not is_tracked(load_trial(trials / "a"), trials / "a" / "results", method="pawnb")


def test_trials_are_found_in_folders_and_counted_once(trials):
    names = [path.name for path in find_trials([trials / "b" / "trial.toml", trials, trials / "a"])]
    assert names == ["trial.toml", "a", "broken"]
    with pytest.raises(InputError, match="no trials"):
        find_trials([])
    with pytest.raises(InputError, match="workers is 0"):
        batch([trials], workers=0)


@pytest.mark.slow
def test_the_command_ends_with_status_2_and_a_sentence_each(trials, capsys):
    (trials / "a" / "start_pose.csv").unlink()
    assert main(["batch", str(trials / "a"), str(trials / "broken")]) == 2
    out, err = capsys.readouterr()
    assert len(out.splitlines()) == 3
    assert "2 of 2 trials failed" in err
    assert "start_pose.csv: no such file" in err
