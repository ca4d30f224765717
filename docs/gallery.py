"""The gallery: every figure is drawn while the documentation is built.

A Sphinx extension. What is drawn is the example of each ``plot_...`` function of
:mod:`pawnb.figures`: it is run after the example of the package, and shown below its picture.
"""

from __future__ import annotations

import doctest
from pathlib import Path
from typing import Any

import matplotlib as mpl

FOLDER = "_generated"
TITLES = {"Bland altman": "Bland-Altman", "Paths 3d": "Paths in space"}
HEAD = """# Gallery

Each figure is drawn by the code below it while this page is built, from a study of synthetic
spiders without pictures, or from a few numbers. All go on from

```python
{setup}```

Every figure is two functions: `build_..._table` makes the numbers, `plot_...` draws them. Sizes,
fonts and colours are set once with {{func}}`pawnb.figures.set_style`.
"""


def source_of(doc: str) -> str:
    """Return the code of the examples in a docstring."""
    return "".join(example.source for example in doctest.DocTestParser().get_examples(doc))


def draw_gallery(folder: Path) -> None:
    """Draw every figure into a folder, and write the page that shows them.

    Parameters
    ----------
    folder : Path
        Where ``gallery.md`` and the pictures are written; made where it is not there.
    """
    mpl.use("Agg")
    import matplotlib.pyplot as plt

    from pawnb import figures

    folder.mkdir(parents=True, exist_ok=True)
    setup = source_of(figures.__doc__ or "")
    made: dict[str, Any] = {}
    exec(setup, made)  # noqa: S102  (the package's own example)
    page = [HEAD.format(setup=setup)]
    for name in figures.__all__:
        if not name.startswith("plot_"):
            continue
        doc = getattr(figures, name).__doc__ or ""
        code = source_of(doc)
        exec(code, dict(made))  # noqa: S102
        with figures.style(dpi=130.0):
            plt.gcf().savefig(folder / f"{name}.png")
        plt.close("all")
        title = name.removeprefix("plot_").replace("_", " ").capitalize()
        title = TITLES.get(title, title)
        said = doc.strip().splitlines()[0]
        page.append(
            f"## {title}\n\n{said} See {{func}}`pawnb.figures.{name}`.\n\n"
            f"![{title}]({name}.png)\n\n```python\n{code}```\n"
        )
    (folder / "gallery.md").write_text("\n".join(page), encoding="utf-8")


def _before_reading(app: Any, _config: Any) -> None:
    draw_gallery(Path(app.srcdir) / FOLDER)


def setup(app: Any) -> dict[str, bool]:
    """Register the extension."""
    app.connect("config-inited", _before_reading)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
