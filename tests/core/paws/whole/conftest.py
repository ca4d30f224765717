"""Loops of this package, called one by one."""

import sys

import pytest

from pawnb.core.compiled import Compiled

PACKAGE = "pawnb.core.paws.whole."


@pytest.fixture(params=["as written", pytest.param("compiled", marks=pytest.mark.slow)])
def steps_of_loops(request, monkeypatch):
    """Let Python run loops that only compiled code calls; slow tests compile them, too.

    By themselves they take seconds to compile; as parts of what calls them they are compiled
    in any case, and tested so.
    """
    if request.param == "compiled":
        return
    modules = [module for name, module in sys.modules.items() if name.startswith(PACKAGE)]
    for module in (*modules, request.module):
        for name, value in list(vars(module).items()):
            if isinstance(value, Compiled):
                monkeypatch.setattr(module, name, value.__wrapped__)
