"""The check of an installation: it passes here, and what is broken is found."""

from __future__ import annotations

import json

import pytest

from pawnb.cli import main
from pawnb.workflow.checking import reference_values
from pawnb.workflow.checking import selfcheck as module


def test_every_reference_value_is_reproduced(capsys):
    # the values stand with their sources in reference_values
    assert main(["selfcheck", "--values-only"]) == 0
    said = capsys.readouterr().out.splitlines()
    assert len(said) == len(reference_values.REFERENCE_VALUES) + 1
    assert all(line.startswith("ok") for line in said[:-1])


def test_what_is_broken_is_found(monkeypatch, capsys):
    # a filter that takes a tenth off everything
    monkeypatch.setattr(
        reference_values, "butterworth_lowpass", lambda x, *, cutoff_hz, fs_hz: 0.9 * x
    )
    assert main(["selfcheck", "--values-only", "--json"]) == 3
    found = json.loads(capsys.readouterr().out)
    wrong = [one["what"] for one in found["findings"] if not one["right"]]
    assert wrong == ["amplitude at the filter's cut-off"]
    assert found["right"] is False


@pytest.mark.slow
def test_trials_of_each_kind_are_tracked_and_analysed():
    found = module.selfcheck()
    assert found.right, found.text()
    assert len(found.findings) == len(reference_values.REFERENCE_VALUES) + 4
