"""Settings of the documentation: ``python -m sphinx -W -b html docs docs/_build``.

Nothing is fetched from the network, neither by the build nor by the pages it makes.
"""

from __future__ import annotations

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

import pawnb  # noqa: E402

project = "pawnb"
author = "pawnb developers"
copyright = "pawnb developers"  # noqa: A001  (the name that Sphinx reads)
version = release = pawnb.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "numpydoc",
    "diagrams",
    "gallery",
    "reference",
]
exclude_patterns = ["_build", "accuracy/README.md"]

html_theme = "furo"
html_title = f"pawnb {release}"
html_static_path = ["_static"]
html_css_files = ["pawnb.css"]
html_copy_source = False

myst_enable_extensions = ["colon_fence", "deflist"]
myst_heading_anchors = 3
# pages of the repository that are included say where a file is, not how it is linked
suppress_warnings = ["myst.xref_missing"]

autosummary_generate = False
autodoc_member_order = "bysource"
autodoc_typehints = "none"
numpydoc_show_class_members = False
add_module_names = False
toc_object_entries = False
