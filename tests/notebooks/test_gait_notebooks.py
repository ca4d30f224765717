"""The notebooks of gait and signals run from top to bottom without a person."""

import re

import pytest
from notebook_runs import FOLDER, WIDGET, execute, plain_pictures, printed, shown

import pawnb
from pawnb.gait.events.event_edits import EventEdits, ExcludeStride
from pawnb.synthetic import simulate_spider_study


@pytest.mark.slow
def test_foreign_tracks_notebook_recovers_the_truth_of_its_sample(tmp_path):
    notebook = execute(FOLDER / "04_from_deeplabcut.ipynb", tmp_path)
    text = printed(notebook)
    assert "FR is 'forepaw_R'" in text
    error = float(re.search(r"largest error of the period: ([0-9.]+)%", text)[1])
    assert error < 1.0
    assert shown(notebook, "image/png") == 2
    assert (tmp_path / "results" / "deeplabcut" / "strides.csv").exists()
    assert "phases.pdf: identical" in text


@pytest.mark.slow
def test_residual_notebook_draws_and_warns(tmp_path):
    notebook = execute(FOLDER / "05_residual_analysis.ipynb", tmp_path)
    text = printed(notebook)
    assert "An estimate, not a measurement" in text
    assert re.search(r"residual: [0-9.]+ Hz", text)
    assert shown(notebook, WIDGET) == 1
    # three figures, and the widget as a picture
    assert len(plain_pictures(notebook)) == 4
    assert shown(notebook, "image/png") == 3


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
    notebook = execute(FOLDER / "03_gait_statistics.ipynb", tmp_path)
    text = printed(notebook)
    found = re.search(r"largest difference of (\d+) mean phases from the truth: ([0-9.]+)", text)
    assert int(found[1]) == 16
    assert float(found[2]) < 0.02
    strides = re.search(r"(\d+) strides of 6", text)
    corrected = re.search(r"corrections: 1; strides: (\d+)", text)
    assert int(corrected[1]) == int(strides[1]) - 1
    assert shown(notebook, "application/vnd.jupyter.widget-view+json") == 1
    assert shown(notebook, "image/png") == 3
