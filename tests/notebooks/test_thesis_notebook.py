"""The notebook of the thesis' tables runs from top to bottom without a person."""

import re

import pytest
from notebook_runs import FOLDER, execute, printed, shown


@pytest.mark.slow
def test_thesis_notebook_says_what_is_recovered(tmp_path):
    notebook = execute(FOLDER / "06_thesis_tables.ipynb", tmp_path)
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
