"""Results of other inputs that a run replaces are named, and those of the same are not."""

from __future__ import annotations

import warnings

import pandas as pd
import pytest

from pawnb.errors import InputWarning
from pawnb.synthetic import write_deeplabcut_sample
from pawnb.workflow.gait.run import run_gait


def said_of(path, **options):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        run = run_gait(path, fps=200.0, figures="none", **options)
    return run, [str(w.message) for w in caught if issubclass(w.category, InputWarning)]


@pytest.mark.slow
def test_a_second_recording_beside_the_first_says_what_it_replaces(tmp_path):
    one, two = write_deeplabcut_sample(tmp_path, animals=2)
    run, said = said_of(one)
    assert run.out == tmp_path
    assert said == []
    _, said = said_of(one)  # made again
    assert said == []
    _, said = said_of(two, out=tmp_path / "two")
    assert said == []
    assert {*pd.read_csv(tmp_path / "strides.csv")["animal"]} == {"m01"}
    _, said = said_of(two)
    (told,) = said
    one = f"{tmp_path.name}/m01DLC.csv"
    assert told.startswith(f"{tmp_path}: the gait of {one} was here and is replaced; with a")
    assert {*pd.read_csv(tmp_path / "strides.csv")["animal"]} == {"m02"}
