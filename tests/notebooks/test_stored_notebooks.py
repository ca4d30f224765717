"""Notebooks are stored without outputs, in the format that Jupyter reads."""

import json

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


@pytest.mark.slow
@every_notebook
def test_stored_in_the_format(path):
    import nbformat  # takes seconds to import

    nbformat.validate(nbformat.read(path, as_version=4))
