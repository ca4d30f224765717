"""The diagrams of trackers: drawn from :mod:`method_stages` while the documentation is built.

A Sphinx extension: ``{stages} NAME`` becomes a drawing in the page itself (SVG). It takes colours
and fonts from the page, so it is as legible in the dark; no meaning hangs on a colour.
"""

from __future__ import annotations

import textwrap
from html import escape
from typing import Any

import method_stages
from docutils import nodes
from docutils.parsers.rst import Directive
from method_stages import DIAGRAMS, Diagram, Loop, Row, Stage

# px of the page
WIDTH = 740
COLUMN = (4, 520)
"""Left edge and width of the stages."""
SIDE = (562, 176)
"""Left edge and width of a stage on a way back."""
LANES = (552, 664)
"""Where ways back without a stage go up."""
GAP = 38
BETWEEN = 10
LINE = 17
PADDING = 9
LETTER = 6.4
"""Width of a letter of running text."""


def text(x: float, y: float, words: str, kind: str) -> str:
    """Return a line of text."""
    return f'<text x="{x:g}" y="{y:g}" class="{kind}">{escape(words)}</text>'


def arrow(points: list[tuple[float, float]], name: str, kind: str = "") -> str:
    """Return a line with a head at its last point."""
    line = " ".join(f"{x:g},{y:g}" for x, y in points)
    return f'<polyline points="{line}" class="arrow {kind}" marker-end="url(#{name}-head)"/>'


def class_name(paths: str) -> str:
    """Return the names of types without their modules."""
    return ", ".join(path.rpartition(".")[2] for path in paths.split(", "))


def lines_of(stage: Stage, width: float) -> list[tuple[str, str]]:
    """Return the lines of a box below its title, with their kinds."""
    lines = [(stage.module, "module")]
    letters = int((width - 2 * PADDING) / LETTER)
    lines += [(line, "does") for line in textwrap.wrap(stage.does, letters)]
    if stage.cites and width < COLUMN[1]:
        lines.append((stage.cites, "cites"))
    return lines


def height_of(stage: Stage, width: float) -> float:
    """Return the height of a box."""
    return LINE * (1 + len(lines_of(stage, width))) + 2 * PADDING


def box(stage: Stage, x: float, y: float, *, width: float, height: float) -> str:
    """Return a box with what it says."""
    rect = f'<rect x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" rx="6" class="box"/>'
    drawn = [rect, text(x + PADDING, y + PADDING + 13, stage.title, "title")]
    if stage.cites and width >= COLUMN[1]:
        drawn.append(text(x + width - PADDING, y + PADDING + 13, stage.cites, "cites end"))
    for i, (words, kind) in enumerate(lines_of(stage, width), 1):
        drawn.append(text(x + PADDING, y + PADDING + 13 + i * LINE, words, kind))
    return "".join(drawn)


def end_box(words: str, y: float) -> str:
    """Return what comes in or goes out."""
    x, width = COLUMN
    rect = (
        f'<rect x="{x + 80}" y="{y:g}" width="{width - 160}" height="28" rx="14" class="end-box"/>'
    )
    return rect + text(x + width / 2, y + 19, words, "title middle")


def columns(row: Row) -> tuple[list[float], float]:
    """Return the left edges of the boxes of a row, and their width."""
    n, (x, whole) = len(row.stages), COLUMN
    width = (whole - BETWEEN * (n - 1)) / n
    return [x + i * (width + BETWEEN) for i in range(n)], width


def way_back(loop: Loop, name: str, lane: int, *, middles: dict[str, float], alone: bool) -> str:
    """Return an arrow back, with the stage on its way."""
    right = COLUMN[0] + COLUMN[1]
    low, high = middles[loop.begin] + 12 * lane, middles[loop.end]
    if loop.through is None:
        x = LANES[lane]
        letters = int(((WIDTH if alone or lane else LANES[1]) - x - 10) / LETTER)
        words = [*textwrap.wrap(loop.says, letters), *filter(None, [class_name(loop.takes)])]
        drawn = [arrow([(right, low), (x, low), (x, high), (right, high)], name, "back")]
        y = (low + high) / 2 - LINE * (len(words) - 1) / 2
        for i, line in enumerate(words):
            kind = "type" if line == class_name(loop.takes) else "says"
            drawn.append(text(x + 8, y + i * LINE, line, kind))
        return "".join(drawn)
    x, width = SIDE
    middle, height = x + width / 2, height_of(loop.through, width)
    top = (low + high - height) / 2
    return "".join([
        arrow([(right, low), (middle, low), (middle, top + height)], name, "back"),
        box(loop.through, x, top, width=width, height=height),
        arrow([(middle, top), (middle, high), (right, high)], name, "back"),
        text(right + 8, high - 7, loop.says, "says"),
        text(right + 8, low + 17, class_name(loop.takes), "type"),
        text(middle + 8, (top + high) / 2 + 4, class_name(loop.gives), "type"),
    ])  # fmt: skip


def described(diagram: Diagram) -> str:
    """Return the diagram in words, for who does not see it."""
    said = [f"Comes in: {diagram.begins}."]
    for row in diagram.rows:
        for stage in row.stages:
            cites = f" ({stage.cites})" if stage.cites else ""
            said.append(f"{stage.title}{cites}, module {stage.module}: {stage.does}")
        said.append(f"Passes on {class_name(row.gives)}.")
    for loop in diagram.loops:
        stage = loop.through
        said.append(f"From {loop.begin} back to {loop.end}, {loop.says}.")
        if stage is not None:
            said.append(f"On the way {stage.title}, module {stage.module}: {stage.does}")
    return " ".join([*said, f"Goes out: {diagram.ends}."])


def draw(name: str, diagram: Diagram) -> str:
    """Return a diagram as SVG.

    Parameters
    ----------
    name : str
        Unique on the page.
    diagram : Diagram
        What is drawn.

    Returns
    -------
    str
        HTML, with the diagram in words for who does not see it.
    """
    middle, y = COLUMN[0] + COLUMN[1] / 2, 30.0
    drawn, middles, leave = [end_box(diagram.begins, 2)], {}, [middle]
    given = ""
    for row in diagram.rows:
        edges, width = columns(row)
        height = max(height_of(stage, width) for stage in row.stages)
        enter = [x + width / 2 for x in edges]
        for x in enter if len(enter) >= len(leave) else leave:
            drawn.append(arrow([(x, y), (x, y + GAP - 2)], name))
        drawn.append(text(middle + 9, y + GAP / 2 + 3, given, "type"))
        y += GAP
        for stage, x in zip(row.stages, edges, strict=True):
            drawn.append(box(stage, x, y, width=width, height=height))
            middles[stage.title] = y + height / 2
        y, leave, given = y + height, enter, class_name(row.gives)
    drawn.append(arrow([(middle, y), (middle, y + GAP - 2)], name))
    drawn.append(text(middle + 9, y + GAP / 2 + 3, given, "type"))
    drawn.append(end_box(diagram.ends, y + GAP))
    for lane, loop in enumerate(diagram.loops):
        alone = len(diagram.loops) == 1
        drawn.append(way_back(loop, name, lane, middles=middles, alone=alone))
    head = (
        f'<marker id="{name}-head" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="8" '
        f'markerHeight="8" orient="auto"><path d="M0,0 L8,4 L0,8 z" class="head"/></marker>'
    )
    return (
        f'<div class="diagram"><svg viewBox="0 0 {WIDTH} {y + GAP + 30:g}" role="img" '
        f'aria-labelledby="{name}-title {name}-words"><title id="{name}-title">'
        f'{escape(diagram.title)}</title><desc id="{name}-words">{escape(described(diagram))}'
        f"</desc><defs>{head}</defs>{''.join(drawn)}</svg></div>\n"
    )


class Stages(Directive):
    """``{stages} NAME``: the diagram of a tracker, and from where its modules are named."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Return the drawing."""
        name = self.arguments[0]
        if name not in DIAGRAMS:
            raise self.error(f"there is no diagram {name!r}; there are {', '.join(DIAGRAMS)}.")
        env = self.state.document.settings.env
        for source in (__file__, method_stages.__file__):
            env.note_dependency(source)
        diagram = DIAGRAMS[name]
        where = nodes.paragraph("", "Modules in ")
        where += nodes.literal("", diagram.package)
        where += nodes.Text("; beside the arrows, the type that is passed on.")
        return [nodes.raw("", draw(name, diagram), format="html"), where]


def setup(app: Any) -> dict[str, bool]:
    """Register the extension."""
    app.add_directive("stages", Stages)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
