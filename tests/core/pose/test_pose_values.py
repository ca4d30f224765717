"""Objects of the pose trackers come complete: nobody writes into one from outside."""

from __future__ import annotations

import ast
import inspect
from pathlib import Path

import pawnb.core.pose

OWN_STATE = {
    "fit/rendering/canvas.py": "Canvas.of_shape",  # room to paint on grows
    "fit/steps.py": "Steps",  # counts what is done
    "fit/learning/body_equations.py": "BodyEquations.add",  # sums over frames
    "pullar2009/tracker.py": "_Tracker._fit_lengths",  # the method of the paper
}
"""What changes itself, in a method of its own."""


def assignments(tree):
    """Yield where attributes are assigned: in which function, and of which object."""

    def walk(node, inside):
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            inside = (*inside, node.name)
        targets = [] if not isinstance(node, ast.Assign) else node.targets
        if isinstance(node, (ast.AugAssign, ast.AnnAssign)):
            targets = [node.target]
        for target in targets:
            for one in getattr(target, "elts", [target]):
                if isinstance(one, ast.Attribute):
                    yield inside, ast.unparse(one.value), one.attr
        if isinstance(node, ast.Call) and ast.unparse(node.func).endswith("setattr"):
            yield inside, ast.unparse(node.args[0]), ast.unparse(node.args[1])
        for child in ast.iter_child_nodes(node):
            yield from walk(child, inside)

    yield from walk(tree, ())


def from_outside(source):
    """Return assignments to attributes of other objects, and of ``self`` where it is made."""
    found = []
    for inside, owner, name in assignments(ast.parse(source)):
        is_made_there = inside[-1:] in (("__init__",), ("__post_init__",))
        is_own_copy = inside[-1:] and inside[-1].startswith("with_") and owner != "self"
        if not (owner == "self" and is_made_there) and not is_own_copy:
            found.append((".".join(inside), owner, name))
    return found


def test_an_assignment_from_outside_is_seen():
    source = """
def learn(fitter):
    fitter.layout = 1
    fitter.a.b, other = 2, 3
class Count:
    def __init__(self):
        self.n = 0
    def one(self):
        self.n += 1
    def with_more(self):
        new = copy(self)
        new.n = 3
        return new
"""
    assert from_outside(source) == [
        ("learn", "fitter", "layout"),
        ("learn", "fitter.a", "b"),
        ("Count.one", "self", "n"),
    ]


def test_nothing_is_filled_in_from_outside():
    folder = Path(inspect.getfile(pawnb.core.pose)).parent
    wrong = []
    for path in sorted(folder.rglob("*.py")):
        name = path.relative_to(folder).as_posix()
        own = OWN_STATE.get(name, "-")
        for function, owner, attribute in from_outside(path.read_text(encoding="utf-8")):
            if owner != "self" or not function.startswith(own):
                wrong.append(f"{name}: {function} writes {owner}.{attribute}")
    assert wrong == []
