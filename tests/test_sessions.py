"""The three short sessions of the guide: run as they stand, they print what the page shows."""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import pawnb

PAGE = Path(__file__).resolve().parents[1] / "docs" / "guide" / "sessions.md"
SESSIONS = dict(
    re.findall(r"^## (.+?)\n(.*?)(?=^## |\Z)", PAGE.read_text(encoding="utf-8"), re.S | re.M)
)
MOST_LINES = 10
NUMBER = re.compile(r"-?\d+\.\d+")


def parts_of(title):
    """Return the code of a session, and what the page says it prints."""
    body = SESSIONS[title]
    (code,) = re.findall(r"```python\n(.*?)```", body, re.S)
    (said,) = re.findall(r"```text\n(.*?)```", body, re.S)
    return code, said


def run(title):
    """Run a session in the working folder; return its names and what it printed."""
    code, said = parts_of(title)
    names, out = {}, io.StringIO()
    with contextlib.redirect_stdout(out):
        exec(code, names)  # noqa: S102  (the page's own lines)
    return names, out.getvalue(), said


def check_printed(printed, said, *, relative):
    """Words are the same, numbers about as many."""
    assert NUMBER.sub("#", printed).split() == NUMBER.sub("#", said).split()
    numbers = [[float(x) for x in NUMBER.findall(text)] for text in (printed, said)]
    np.testing.assert_allclose(*numbers, rtol=relative, atol=0.011)


@pytest.mark.parametrize("title", SESSIONS)
def test_sessions_are_short(title):
    code, _ = parts_of(title)
    assert len([line for line in code.splitlines() if line.strip()]) <= MOST_LINES


def test_there_are_three():
    assert len(SESSIONS) == 3


def test_a_wrong_number_or_word_is_seen():
    check_printed("a 1.00\n", " a 1.01\n", relative=0.0)
    for other in ("a 1.02", "b 1.00", "a 1.00 2.00"):
        with pytest.raises(AssertionError):
            check_printed("a 1.00", other, relative=0.0)


@pytest.mark.slow
def test_three_animals_from_deeplabcut(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    pawnb.synthetic.write_deeplabcut_sample(".", animals=3)
    names, printed, said = run("Three animals from DeepLabCut")
    check_printed(printed, said, relative=0.0)
    # the phases that the sample was made with lie in the intervals
    truth = pd.read_csv("truth.csv")
    for row in names["pairs"].itertuples():
        late = truth[f"phase_{row.leg}"] - truth[f"phase_{row.reference}"]
        true = np.angle(np.exp(2j * np.pi * late).mean()) / (2 * np.pi)
        assert (true - row.ci_low) % 1.0 <= (row.ci_high - row.ci_low) % 1.0
    assert Path("results/index.html").is_file()


@pytest.mark.slow
def test_own_video_of_two_cameras(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    pawnb.synthetic.render_mouse_trial(
        "my_mouse", frames=80, scale=0.22, settings={"n_views": 2, "fps": 100.0}
    )
    names, printed, said = run("Your own video of two cameras")
    check_printed(printed, said, relative=0.15)  # trackers get better
    events = pd.read_csv("my_mouse/truth/events.csv")
    true = events[events["event"] == "AEP"].groupby("leg")["time_s"].diff().mean()
    found = names["gait"].strides["period_s"].mean()
    np.testing.assert_allclose(found, true, rtol=0.05)


@pytest.mark.slow
def test_the_cut_off_of_a_filter(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    pawnb.synthetic.write_deeplabcut_sample(".", animals=1)
    names, printed, said = run("The cut-off of a filter")
    check_printed(printed, said, relative=0.0)
    # the sample has a noise of 1.5 px
    np.testing.assert_allclose(names["found"]["noise_rms"].dropna(), 1.5, rtol=0.1)
    assert pawnb.reproduce("residual.pdf").identical
