"""Notebooks are stored without outputs, in the format that Jupyter reads."""

import json
import re

import pytest
from notebook_runs import NOTEBOOKS

every_notebook = pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.name)


@every_notebook
def test_stored_without_outputs(path):
    notebook = json.loads(path.read_text(encoding="utf-8"))
    assert notebook["nbformat"] == 4
    assert any(cell["cell_type"] == "code" for cell in notebook["cells"])
    for cell in notebook["cells"]:
        assert not cell.get("outputs")
        assert cell.get("execution_count") is None


@every_notebook
def test_what_a_person_corrects_reaches_the_cells_below(path):
    """Tracks, events and a cut-off are taken from the widget, not from before it."""
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    sources = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    for number, source in enumerate(sources):
        below = "\n".join(sources[number + 1 :])
        if re.search(r"widgets\.(Track|Pose)Reviewer\(", source):
            assert "reviewer = " in source
            analysed = set(re.findall(r"\b(?:analyse|leg_angles)\(([\w.]+)", below))
            assert analysed == {"reviewer.tracks"}
        if re.search(r"widgets\.(Gait|Residual)Explorer\(", source):
            assert re.search(r"= explorer\.(tables|cutoff_hz)\b", below)


@pytest.mark.slow
@every_notebook
def test_stored_in_the_format(path):
    import nbformat  # takes seconds to import

    nbformat.validate(nbformat.read(path, as_version=4))
