"""Many trials, one process each, begun again where it stopped."""

from __future__ import annotations

import os
import shutil
import threading
from pathlib import Path

import pytest

from pawnb.cli import main
from pawnb.errors import InputError, InputWarning
from pawnb.files import locked
from pawnb.io.native import read_tracks
from pawnb.schema import ORIGIN_CODE, add_provenance, make_tracks
from pawnb.trial import load_trial
from pawnb.workflow.batch import run as batch_module
from pawnb.workflow.batch.places import Processes, TrialOutcome
from pawnb.workflow.batch.run import batch, find_trials, is_tracked
from pawnb.workflow.provenance.manifest import MANIFEST, PUT_ASIDE, writing_results
from pawnb.workflow.provenance.record import (
    build_step,
    file_checksum,
    trial_checksums,
    trial_fingerprint,
)
from pawnb.workflow.provenance.results import write_track_results
from pawnb.workflow.tracking.methods import settings_in_force
from pawnb.workflow.tracking.track import track
from pawnb.workflow.workbench.states import state_of

pytestmark = pytest.mark.slow  # scenes are rendered and tracked

QUICK = {"choose_path": False}


def test_failures_are_collected_and_what_is_done_is_skipped(trials, monkeypatch):
    lines = []
    done = batch([trials], settings=QUICK, workers=2, report=lines.append)
    assert done.table["status"].tolist() == ["tracked", "tracked", "failed"]
    assert len(lines) == 3
    assert "spider.avi" in done.failed["said"].item()
    assert done.verdict().startswith("1 of 3 trials failed: ")
    assert "\n" not in done.verdict()
    assert done.table["verdict"].tolist() == ["good", "good", ""]
    assert done.text() == "2 tracked, 1 failed; tracks: 2 good"
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
    assert again.table["verdict"].tolist() == ["good", "good"]  # as quality.json says
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


def test_a_batch_says_of_which_trials_the_gait_is_to_be_analysed_again(small_spider):
    out = small_spider / "results"
    tracks = make_tracks(range(5), ["L1"], fps=125.0, views=["top"], space=("x", "y"))
    write_track_results(add_provenance(tracks, step="track", settings={}, inputs={}), out)
    read = {"results/tracks.nc": file_checksum(out / "tracks.nc")}
    with writing_results(out, run="gait", steps=[{"step": "gait", "inputs": read}]) as staging:
        (staging / "strides.csv").write_text("leg\n")
    (row,) = batch(small_spider, settings=QUICK).table.itertuples()
    assert row.status == "tracked"
    assert "tracks.nc has changed since the gait was analysed; run pawnb gait again" in row.said


def test_unfinished_results_are_not_skipped(small_spider):
    out = small_spider / "results"
    asked = []
    track(small_spider, settings=QUICK, out=out, stop=lambda: asked.append(1) or len(asked) > 12)
    assert not is_tracked(load_trial(small_spider), out, method="pawnb", settings=QUICK)


@pytest.mark.parametrize("name", ["../../escaped", "/escaped", "..", "a/b", "a\\\\b", "NUL"])
def test_names_that_lead_out_of_the_folder_are_refused(small_spider, tmp_path, name):
    toml = small_spider / "trial.toml"
    lines = toml.read_text().splitlines()
    lines = [f'name = "{name}"' if line.startswith('name = "spider-') else line for line in lines]
    toml.write_text("\n".join(lines))
    before = sorted(tmp_path.rglob("*"))
    done = batch([small_spider], settings=QUICK, out=tmp_path / "x" / "out")
    assert done.table["status"].tolist() == ["failed"]
    assert "which cannot be the name of a folder in" in done.table["said"][0]
    assert sorted(tmp_path.rglob("*")) == before


def test_a_run_killed_between_two_files_is_not_taken_for_tracked(small_spider, tmp_path):
    """Two runs of one trial; the second is cut off after its nth file."""
    trial = load_trial(small_spider)
    step = build_step(
        "track",
        command=None,
        inputs=trial_checksums(trial),
        settings=settings_in_force(trial, method="pawnb", settings=QUICK),
        method="pawnb",
        complete=True,
        trial=trial_fingerprint(trial),
    )
    runs = []
    for name, u in (("old", 1.0), ("new", 2.0)):
        tracks = make_tracks(range(5), ["L1"], fps=trial.fps, views=["top"], space=("x", "y"))
        tracks["image_position"][:] = u
        tracks["image_origin"][:] = ORIGIN_CODE["measured"]
        tracks = add_provenance(tracks, **step)
        with writing_results(tmp_path, run="track", steps=[step]) as staging:
            shutil.copytree(
                write_track_results(tracks, tmp_path / name), staging, dirs_exist_ok=True
            )
            (staging / "pose.csv").write_text(name)  # of a jointed animal
            (staging / MANIFEST).unlink()
        runs.append({path.name: path.read_bytes() for path in tmp_path.glob("*.*")})
        assert is_tracked(trial, tmp_path, method="pawnb", settings=QUICK)
    old, new = runs
    changed = [name for name in sorted(old) if old[name] != new[name]]
    assert {"pose.csv", "tracks.csv", "tracks.nc"} <= set(changed)
    for number in range(1, len(changed)):
        for name in changed:
            (tmp_path / name).write_bytes((new if name in changed[:number] else old)[name])
        # whatever of the list of files is there
        for kept in (old, new):
            (tmp_path / MANIFEST).write_bytes(kept[MANIFEST])
            assert not is_tracked(trial, tmp_path, method="pawnb", settings=QUICK)
            (tmp_path / MANIFEST).rename(tmp_path / PUT_ASIDE)
            assert not is_tracked(trial, tmp_path, method="pawnb", settings=QUICK)


def test_corrections_by_hand_are_not_overwritten(trials):
    results = trials / "a" / "results"
    results.mkdir()
    (results / "edits.jsonl").write_text("{}\n")
    done = batch([trials / "a"], settings=QUICK)
    assert done.table["status"].tolist() == ["failed"]
    assert "holds corrections made by hand" in done.table["said"][0]
    assert sorted(path.name for path in results.iterdir()) == ["edits.jsonl"]


def test_results_in_one_folder_have_the_names_of_the_trials(trials, tmp_path):
    out = tmp_path / "out"
    toml = trials / "b" / "trial.toml"
    toml.write_text(toml.read_text().replace('name = "b-', 'name = "a-'))
    done = batch([trials / "a", trials / "b"], settings=QUICK, out=out)
    assert done.table["status"].tolist() == ["tracked", "failed"]
    assert "would overwrite those of" in done.failed["said"].item()
    assert [path.name for path in out.iterdir()] == ["a-normal-still-01"]


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
    said = "its process ended with status -9: it was killed, as the system does where memory runs"
    assert done.failed["said"].item().startswith(said)
    # the list of the workbench says it, until the trial is tracked
    wrong = "tracking failed when it was tried last: its process ended with status -9"
    assert state_of(trials / "a").wrong.startswith(wrong)
    assert state_of(trials / "a").next_step == "track"
    assert state_of(trials / "b").wrong == ""
    monkeypatch.undo()
    assert batch([trials / "a"], settings=QUICK).table["status"].tolist() == ["tracked"]
    assert state_of(trials / "a").wrong == ""


def test_a_trial_that_another_process_is_tracking_is_no_failure(trials, capsys):
    """Two runs of pawnb batch on one study: the second counted such trials as failed."""
    results = trials / "a" / "results"
    results.mkdir()
    with locked(results, remedy="wait"):
        assert main(["batch", str(trials / "a")]) == 0
    out, err = capsys.readouterr()
    assert f"process {os.getpid()} of this machine is writing here" in out
    assert out.splitlines()[1:] == ["1 being done by another process"]
    assert err == ""
    assert list(results.iterdir()) == []  # no word of a failure


def test_who_was_busy_is_tried_once_more_when_all_others_are_done(trials, monkeypatch):
    began, answers = [], {"a": ["busy", "tracked"], "b": ["busy", "busy"], "c": ["tracked"]}

    class Answering:
        def __init__(self, _workers):
            self.left = {}

        def has_room(self):
            return not self.left

        def begin(self, number, order):
            began.append(Path(order["trial"]).name)
            self.left[number] = TrialOutcome(answers[began[-1]].pop(0), "said")

        def ended(self):
            left, self.left = self.left, {}
            return left

        def wait(self, _at_most_s):
            pass

        def close(self):
            pass

    monkeypatch.setattr(batch_module, "Processes", Answering)
    shutil.copytree(trials / "b", trials / "c")
    lines = []
    done = batch([trials / name for name in "abc"], settings=QUICK, report=lines.append)
    assert began == ["a", "b", "c", "a", "b"]
    assert done.table["status"].tolist() == ["tracked", "busy", "tracked"]
    assert done.text() == "2 tracked, 1 being done by another process"
    assert len(lines) == 3
    assert not len(done.failed)


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


def test_a_folder_an_animal_is_looked_into_as_well(tmp_path):
    """A pilot trial beside the folders of animals was tracked alone, and nothing said so."""
    for name in ("pilot", "m07/day 1", "m07/day2", "lesion/m08/day1", ".trash/old"):
        (tmp_path / name).mkdir(parents=True)
        (tmp_path / name / "trial.toml").write_text("")
    found = [path.relative_to(tmp_path).as_posix() for path in find_trials(tmp_path)]
    assert found == ["lesion/m08/day1", "m07/day 1", "m07/day2", "pilot"]
    assert find_trials(tmp_path / "pilot") == [tmp_path / "pilot"]


def test_trials_that_lie_too_deep_are_named(tmp_path):
    """They were left out without a word beside others that were found."""
    for name in ("site/group/m1/day1", "m2"):
        (tmp_path / name).mkdir(parents=True)
        (tmp_path / name / "trial.toml").touch()
    with pytest.warns(InputWarning, match=r"a trial lies too deep in it and is left out, such as"):
        assert find_trials(tmp_path) == [tmp_path / "m2"]
    assert find_trials(tmp_path / "site") == [tmp_path / "site" / "group" / "m1" / "day1"]


def test_the_command_ends_with_status_2_and_a_sentence_each(trials, capsys):
    (trials / "a" / "start_pose.csv").unlink()
    assert main(["batch", str(trials / "a"), str(trials / "broken")]) == 2
    out, err = capsys.readouterr()
    assert len(out.splitlines()) == 3
    assert "2 of 2 trials failed" in err
    assert "start_pose.csv: no such file" in err
