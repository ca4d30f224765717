"""The reference: a page a package, written from what the package says is public.

A Sphinx extension. Functions and classes that a package lists get a section each, modules that it
lists one with all their public members.
"""

from __future__ import annotations

import importlib
import inspect
from pathlib import Path
from types import ModuleType
from typing import Any

from pawnb.core.parameters import defaults_of
from pawnb.core.paws.tracker import trackers

FOLDER = "_generated/reference"
PACKAGES = (
    "pawnb", "pawnb.gait", "pawnb.figures", "pawnb.io", "pawnb.widgets", "pawnb.signals",
    "pawnb.trial", "pawnb.schema", "pawnb.synthetic", "pawnb.workflow", "pawnb.core.dlt",
)  # fmt: skip


def write_reference(folder: Path) -> None:
    """Write ``index.rst`` and a page a package into a folder.

    Parameters
    ----------
    folder : Path
        Made where it is not there.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for name, page in pages().items():
        (folder / f"{name}.rst").write_text(page, encoding="utf-8")
    index = [*heading("Reference", "="), ".. toctree::", "   :maxdepth: 1", ""]
    index += [f"   {name}" for name in (*PACKAGES, "parameters")]
    (folder / "index.rst").write_text("\n".join(index) + "\n", encoding="utf-8")


def pages() -> dict[str, str]:
    """Return the page of each package, in reStructuredText.

    Returns
    -------
    dict
        Name of the package to its page. What several packages list is on the first page only.
    """
    shown: set[int] = set()
    found = {}
    for name in PACKAGES:
        package = importlib.import_module(name)
        public = [(n, getattr(package, n)) for n in sorted(package.__all__)]
        named = [
            (n, item)
            for n, item in public
            if (inspect.isfunction(item) or inspect.isclass(item)) and id(item) not in shown
        ]
        shown |= {id(item) for _, item in named}
        lines = [*heading(name, "="), f".. automodule:: {name}", "   :no-members:", ""]
        lines += [f".. currentmodule:: {name}", "", ".. autosummary::", ""]
        lines += [f"   {n}" for n, _ in named]
        for n, item in named:
            lines += ["", *heading(n, "-")]
            kind = "class" if inspect.isclass(item) else "function"
            lines += [f".. auto{kind}:: {n}", *(["   :members:"] if kind == "class" else [])]
        modules = {item.__name__ for _, item in public if isinstance(item, ModuleType)}
        for module in sorted(modules) if name != "pawnb" else ():
            lines += ["", *heading(module, "-"), f".. automodule:: {module}"]
            lines += ["   :members:"]
        found[name] = "\n".join(lines) + "\n"
    return found | {"parameters": parameters_page()}


def parameters_page() -> str:
    """Return the page of what can be set in the stages of the trackers.

    Returns
    -------
    str
        reStructuredText: a section a stage, its dataclass with unit and evidence of each value.
    """
    lines = [*heading("Parameters of the stages of trackers", "=")]
    lines += ["Set as ``--set STAGE.NAME=VALUE``, or under ``[tracking.STAGE]`` in ``trial.toml``."]
    for kind in ("paws", "pose"):
        # a stage that several methods share is said once
        for stage in dict.fromkeys(
            s for tracker in trackers(kind).values() for s in tracker.stages
        ):
            own = type(defaults_of(stage))
            lines += ["", *heading(f"{stage} (kind {kind})", "-")]
            lines += [f".. autoclass:: {own.__module__}.{own.__qualname__}"]
    return "\n".join(lines) + "\n"


def heading(text: str, sign: str) -> list[str]:
    """Return the lines of a heading."""
    return [text, sign * len(text), ""]


def _before_reading(app: Any, _config: Any) -> None:
    write_reference(Path(app.srcdir) / FOLDER)


def setup(app: Any) -> dict[str, bool]:
    """Register the extension; pages must be there before autosummary looks for them."""
    app.connect("config-inited", _before_reading)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
