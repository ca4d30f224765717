"""Every notebook runs from top to bottom without a person, and is stored without outputs."""

from __future__ import annotations

import os
import re
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

import pawnb
from pawnb.gait.event_edits import EventEdits, ExcludeStride
from pawnb.synthetic import simulate_spider_study

ROOT = Path(__file__).resolve().parents[1]
NOTEBOOKS = sorted((ROOT / "notebooks").glob("*.ipynb"))


def execute(path, folder, **environment):
    """Run a notebook with ``folder`` as its working folder; return it with its outputs."""
    notebook = nbformat.read(path, as_version=4)
    client = NotebookClient(
        notebook, timeout=600, kernel_name="python3", resources={"metadata": {"path": str(folder)}}
    )
    with client.setup_kernel(env={**os.environ, **environment}):
        for number, cell in enumerate(notebook.cells):
            client.execute_cell(cell, number)
    return notebook


def printed(notebook):
    """Return the text of all outputs of a notebook."""
    outputs = [o for cell in notebook.cells for o in cell.get("outputs", [])]
    return "\n".join(o.get("text", "") or o.get("data", {}).get("text/plain", "") for o in outputs)


def shown(notebook, mime):
    """Count the outputs of a kind."""
    outputs = [o for cell in notebook.cells for o in cell.get("outputs", [])]
    return sum(mime in o.get("data", {}) for o in outputs)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.name)
def test_stored_without_outputs(path):
    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    for cell in notebook.cells:
        assert not cell.get("outputs")
        assert cell.get("execution_count") is None


@pytest.mark.slow
def test_quickstart_goes_from_video_to_gait_diagram(tmp_path):
    notebook = execute(ROOT / "notebooks" / "00_quickstart.ipynb", tmp_path)
    text = printed(notebook)
    assert "DLT of 4 views, unit mm" in text
    assert "median distance" in text
    assert shown(notebook, "application/vnd.jupyter.widget-view+json") >= 2
    assert shown(notebook, "image/png") == 2
    results = tmp_path / "sample" / "paws" / "results"
    assert (results / "tracks.nc").exists()


@pytest.mark.slow
def test_real_mouse_notebook_runs_on_the_real_clip(tmp_path, real_data):
    home = real_data("mouse-side-bottom").parent.resolve()
    notebook = execute(
        ROOT / "notebooks" / "01_real_mouse_two_views.ipynb", tmp_path, PAWNB_TEST_DATA=str(home)
    )
    # the aim for this clip: every marked paw within 12 px
    assert "15 of 15 marked paws are within 12 px" in printed(notebook)
    assert shown(notebook, "image/png") == 2


def test_real_mouse_notebook_says_so_where_there_is_no_clip(tmp_path):
    notebook = execute(
        ROOT / "notebooks" / "01_real_mouse_two_views.ipynb",
        tmp_path,
        PAWNB_TEST_DATA=str(tmp_path),
    )
    assert "Set PAWNB_TEST_DATA to run this notebook" in printed(notebook)
    assert shown(notebook, "image/png") == 0


@pytest.mark.slow
def test_spider_notebook_goes_from_video_to_leg_angles(tmp_path):
    """The synthetic spider; the cells of the real one say that it is not there."""
    notebook = execute(
        ROOT / "notebooks" / "02_spider_pose.ipynb", tmp_path, PAWNB_TEST_DATA=str(tmp_path)
    )
    text = printed(notebook)
    assert "species dolomedes: 8 legs, 43 degrees of freedom" in text
    assert "Set PAWNB_TEST_DATA to run this part" in text
    body = float(text.split("body: median distance ")[1].split(" px")[0])
    assert body < 1.0
    assert shown(notebook, "application/vnd.jupyter.widget-view+json") >= 1
    assert shown(notebook, "image/png") == 4
    results = tmp_path / "sample" / "spider" / "results"
    assert (results / "pose.csv").exists()


@pytest.mark.slow
def test_spider_notebook_runs_on_the_real_spider(tmp_path, real_data):
    home = real_data("spider-nephila").parent.resolve()
    notebook = execute(
        ROOT / "notebooks" / "02_spider_pose.ipynb", tmp_path, PAWNB_TEST_DATA=str(home)
    )
    text = printed(notebook)
    median = float(text.split("joints and tips: median ")[1].split(" px")[0])
    assert median < 3.0  # the lines are drawn to about 2 px
    assert shown(notebook, "image/png") == 5


@pytest.mark.slow
def test_foreign_tracks_notebook_recovers_the_truth_of_its_sample(tmp_path):
    notebook = execute(ROOT / "notebooks" / "04_from_deeplabcut.ipynb", tmp_path)
    text = printed(notebook)
    assert "FR is 'forepaw_R'" in text
    error = float(re.search(r"largest error of the period: ([0-9.]+)%", text)[1])
    assert error < 1.0
    assert shown(notebook, "image/png") == 2
    assert (tmp_path / "results" / "deeplabcut" / "strides.csv").exists()


@pytest.mark.slow
def test_residual_notebook_draws_and_warns(tmp_path):
    notebook = execute(ROOT / "notebooks" / "05_residual_analysis.ipynb", tmp_path)
    text = printed(notebook)
    assert "An estimate, not a measurement" in text
    assert re.search(r"residual: [0-9.]+ Hz", text)
    assert shown(notebook, "image/png") == 3


@pytest.mark.slow
def test_thesis_notebook_says_what_is_recovered(tmp_path):
    notebook = execute(ROOT / "notebooks" / "06_thesis_tables.ipynb", tmp_path)
    text = printed(notebook)
    said = re.findall(r"^(.+?): (NOT recovered|recovered)\. ", text, flags=re.MULTILINE)
    assert len(said) == 16
    # 125 frames a second are few for swings of 6 frames, and the extremes of noisy angles are
    # those with the worst noise; all else must be recovered
    hard = {"Means of Table 4.5's measures", "Fig. 4.10", "Figs. 4.13, 4.14", "Table 4.6"}
    assert {what for what, verdict in said if verdict == "NOT recovered"} <= hard
    intervals = re.search(r"by design: (\d+) of (\d+) intervals hold the true exponent", text)
    assert int(intervals[2]) == 24
    off = float(re.search(r"16 pairs are off by ([0-9.]+) cycles at most", text)[1])
    assert 0.0 < off < 0.01
    assert shown(notebook, "image/png") == 19


@pytest.mark.slow
def test_statistics_notebook_recovers_the_phases_of_its_spiders(tmp_path):
    # a correction of an earlier day: the first stride of the first run does not count
    run = simulate_spider_study(animals=6, trials=2).runs[0]
    found = pawnb.gait.analyse(run.tracks(), trial=run.trial)
    stride = found.strides.iloc[0]
    (tmp_path / "results").mkdir()
    EventEdits(found, tmp_path / "results" / "event_edits.jsonl").apply(
        ExcludeStride(
            animal=stride["animal"], trial=stride["trial"], leg=stride["leg"],
            start_s=stride["start_s"], reason="stumbled",
        )
    )  # fmt: skip
    notebook = execute(ROOT / "notebooks" / "03_gait_statistics.ipynb", tmp_path)
    text = printed(notebook)
    found = re.search(r"largest difference of (\d+) mean phases from the truth: ([0-9.]+)", text)
    assert int(found[1]) == 16
    assert float(found[2]) < 0.02
    strides = re.search(r"(\d+) strides of 6", text)
    corrected = re.search(r"corrections: 1; strides: (\d+)", text)
    assert int(corrected[1]) == int(strides[1]) - 1
    assert shown(notebook, "application/vnd.jupyter.widget-view+json") == 1
    assert shown(notebook, "image/png") == 3
