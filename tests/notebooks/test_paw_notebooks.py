"""The notebooks of paws run from top to bottom without a person."""

import pytest
from notebook_runs import FOLDER, execute, printed, shown


@pytest.mark.slow
def test_quickstart_goes_from_video_to_gait_diagram(tmp_path):
    notebook = execute(FOLDER / "00_quickstart.ipynb", tmp_path)
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
        FOLDER / "01_real_mouse_two_views.ipynb", tmp_path, PAWNB_TEST_DATA=str(home)
    )
    # the aim for this clip: every marked paw within 12 px
    assert "15 of 15 marked paws are within 12 px" in printed(notebook)
    assert shown(notebook, "image/png") == 2


@pytest.mark.slow
def test_real_mouse_notebook_says_so_where_there_is_no_clip(tmp_path):
    notebook = execute(
        FOLDER / "01_real_mouse_two_views.ipynb",
        tmp_path,
        PAWNB_TEST_DATA=str(tmp_path),
    )
    assert "Set PAWNB_TEST_DATA to run this notebook" in printed(notebook)
    assert shown(notebook, "image/png") == 0
