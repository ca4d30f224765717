"""The phase summary on a page: animals first, then strides, no table wider than paper."""

from __future__ import annotations

import re

import numpy as np
import pandas as pd

from pawnb.workflow.provenance.report.phase_words import phase_tables

SUMMARY = {
    "leg": "FL", "reference": "FR", "n": 48, "n_animals": 4, "mean": 0.48312, "ci_low": 0.9334,
    "ci_high": 0.0333, "r": 0.9858, "circular_sd": 0.0269, "rayleigh_z": 3.9, "rayleigh_p": 0.0013,
    "pattern": "anti-phase", "mean_strides": 0.4823, "ci_low_strides": 0.4719,
    "ci_high_strides": 0.4919, "r_strides": 0.9773, "circular_sd_strides": 0.0341,
    "rayleigh_z_strides": 45.8, "rayleigh_p_strides": 9.6e-41, "pattern_strides": "anti-phase",
    "moore_r": 1.2, "moore_p": 0.003, "r_low": 0.7424, "r_high": 0.9939,
}  # fmt: skip


def rows_of(html):
    """The cells of each row of a table, heads first."""
    return [
        [re.sub(r"<[^>]*>", "", cell) for cell in re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", row)]
        for row in re.findall(r"<tr>(.*?)</tr>", html)
    ]


def test_animals_and_strides_have_a_table_each():
    said, animals, said_too, strides = phase_tables(pd.DataFrame([SUMMARY]))
    assert "Each animal counts once." in said
    assert "as if strides were independent" in said_too
    head, row = rows_of(animals)
    assert dict(zip(head, row, strict=True)) == {
        "leg to reference": "FL to FR", "animals": "4",
        "mean phase (95 % interval)": "0.483 (0.933 to 0.033)",  # wraps past 1
        "r (95 % interval)": "0.986 (0.742 to 0.994)", "circular SD": "0.0269", "Rayleigh z": "3.9",
        "Rayleigh p": "0.0013", "Moore r": "1.2", "Moore p": "0.003", "pattern": "anti-phase",
    }  # fmt: skip
    head, row = rows_of(strides)
    found = dict(zip(head, row, strict=True))
    assert found["strides"] == "48"
    assert found["mean phase (95 % interval)"] == "0.482 (0.472 to 0.492)"
    assert found["r (95 % interval)"] == "0.977"  # no interval is known
    assert (found["Rayleigh z"], found["Rayleigh p"]) == ("45.8", "9.6e-41")
    assert "Moore r" not in found


def test_one_animal_has_no_interval_and_no_test():
    blank = dict.fromkeys(("ci_low", "ci_high", "rayleigh_z", "rayleigh_p", "moore_r", "moore_p"))
    alone = pd.DataFrame([SUMMARY | blank | {"n_animals": 1, "r_low": np.nan, "r_high": np.nan}])
    head, row = rows_of(phase_tables(alone)[1])
    assert dict(zip(head, row, strict=True))["mean phase (95 % interval)"] == "0.483"
    assert "Rayleigh p" not in head
