"""Running notebooks without a person; a file of tests for each few, as they take minutes."""

from __future__ import annotations

import os
import re
from pathlib import Path

from traitlets.config import Config

FOLDER = Path(__file__).resolve().parents[2] / "notebooks"
WIDGET = "application/vnd.jupyter.widget-view+json"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))


def execute(path, folder, changes=None, **environment):
    """Run a notebook with ``folder`` as its working folder; return it with its outputs.

    ``changes``: what a person writes in place of what stands in the first cell of code.
    """
    # they take seconds to import: whoever collects tests does without
    import nbformat
    from nbclient import NotebookClient

    notebook = nbformat.read(path, as_version=4)
    first = next(cell for cell in notebook.cells if cell.cell_type == "code")
    for old, new in (changes or {}).items():
        assert first.source.count(old) == 1, old
        first.source = first.source.replace(old, new)
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
    """Count the outputs of a kind; the plain picture of a widget is no picture of its own."""
    outputs = [o.get("data", {}) for cell in notebook.cells for o in cell.get("outputs", [])]
    return sum(mime in data and (mime == WIDGET or WIDGET not in data) for data in outputs)


def plain_pictures(notebook):
    """Convert a notebook that was run, as a viewer without a kernel shows it; return its pictures.

    By nbconvert, with JavaScript's outputs left out: each output that is left is text or a picture.
    """
    from nbconvert import HTMLExporter  # takes seconds to import

    plain = {"NbConvertBase": {"display_data_priority": ["image/png", "text/html", "text/plain"]}}
    page, _ = HTMLExporter(config=Config(plain)).from_notebook_node(notebook)
    return re.findall(r'<img[^>]* src="data:image/png;base64,([^"]+)"', page.replace("\n", ""))
