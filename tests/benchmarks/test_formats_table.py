"""The table of formats is made by one command; rows whose libraries come with pawnb are exact."""

from __future__ import annotations

import importlib
import sys

import pandas as pd
import pytest


@pytest.mark.slow
def test_rows_are_printed_and_written(tmp_path, monkeypatch, capsys):
    formats = importlib.import_module("formats")
    out = tmp_path / "formats.csv"
    for word, n in (
        ("csv", 9),
        ("mayacam", 1),
        ("yaml", 1),
        ("coefs", 3),
        ("xyzpts", 3),
        ("mat", 1),
    ):
        monkeypatch.setattr(sys, "argv", ["formats.py", "--only", word, "--out", str(out)])
        assert formats.main() == 0
        table = pd.read_csv(out, dtype=str)
        assert len(table) >= n, word
        for row in table.itertuples():
            for cell in (row.read, row.written):
                if not cell.startswith("no "):  # a library that is not installed
                    # DLTdv 8 writes five digits of a coefficient
                    most = 5e-3 if row.format == "DLTdv 8 DLTcoefs" else 1e-4
                    most = 0.13 if row.format == "Argus xypts" else most  # half precision
                    assert float(cell.split()[0]) < most, row
    assert "largest error, px or mm" in capsys.readouterr().out
