"""The notebook of poses runs from top to bottom without a person."""

import pytest
from notebook_runs import FOLDER, execute, printed, shown


@pytest.mark.slow
def test_spider_notebook_goes_from_video_to_leg_angles(tmp_path):
    """The synthetic spider; the cells of the real one say that it is not there."""
    notebook = execute(FOLDER / "02_spider_pose.ipynb", tmp_path, PAWNB_TEST_DATA=str(tmp_path))
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
    notebook = execute(FOLDER / "02_spider_pose.ipynb", tmp_path, PAWNB_TEST_DATA=str(home))
    text = printed(notebook)
    median = float(text.split("joints and tips: median ")[1].split(" px")[0])
    assert median < 3.0  # the lines are drawn to about 2 px
    assert shown(notebook, "image/png") == 5
