"""Running notebooks without a person; a file of tests for each few, as they take minutes."""

from __future__ import annotations

import os
from pathlib import Path

FOLDER = Path(__file__).resolve().parents[2] / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))


def execute(path, folder, **environment):
    """Run a notebook with ``folder`` as its working folder; return it with its outputs."""
    # they take seconds to import: whoever collects tests does without
    import nbformat
    from nbclient import NotebookClient

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
