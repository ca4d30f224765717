"""Bars of progress: where somebody sees them, and nowhere else."""

import sys
from types import SimpleNamespace

import ipykernel  # noqa: F401  that both are imported does not make a notebook
import IPython  # noqa: F401
import pytest

from pawnb.workflow import progress


def test_no_bar_where_nobody_looks(capsys, monkeypatch):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: False, raising=False)
    assert progress._make_bar("tracking", "frame") is None
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize(("shell", "expected"), [(None, False), (SimpleNamespace(kernel=1), True)])
def test_a_notebook_is_where_a_kernel_runs(monkeypatch, shell, expected):
    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace(get_ipython=lambda: shell))
    assert progress._in_notebook() is expected
