"""A walk of 48 strides as DeepLabCut writes it, and what rows that somebody deleted do to it."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from pawnb.errors import InputError
from pawnb.gait import analyse
from pawnb.io.formats import read_any_tracks
from pawnb.workflow.gait.run import run_gait

FPS, STRIDE_HZ, N_STRIDES = 100.0, 4.0, 48
LEGS = {"FR": 0.0, "HR": 0.5, "FL": 0.5, "HL": 0.0}
N = round((N_STRIDES + 1) * FPS / STRIDE_HZ)


def write_walk(path, rows):
    """Feet that stand for 60 % of the stride and swing for 40 %, under a body that goes on."""
    t = np.arange(N) / FPS
    columns = []
    for i, phase in enumerate(LEGS.values()):
        cycle = (t * STRIDE_HZ + phase) % 1
        foot = np.where(cycle < 0.6, 20 - 40 * cycle / 0.6, -20 + 40 * (cycle - 0.6) / 0.4)
        columns += [500 + 267 * t + foot, np.full(N, 300.0 + 20 * i), np.full(N, 0.99)]
    names = [(p, c) for p in LEGS for c in ("x", "y", "likelihood")]
    head = [["scorer"] + ["net"] * 12, ["bodyparts"] + [p for p, _ in names],
            ["coords"] + [c for _, c in names]]  # fmt: skip
    body = [[i, *(column[i] for column in columns)] for i in rows]
    path.write_text("\n".join(",".join(map(str, row)) for row in head + body) + "\n")
    return path


def strides_of(path):
    tables = analyse(read_any_tracks(path, fps=FPS))
    return tables, tables.strides[tables.strides["leg"] == "HR"]


@pytest.mark.slow
def test_deleted_rows_do_not_shorten_the_recording(tmp_path):
    whole, strides = strides_of(write_walk(tmp_path / "whole.csv", range(N)))
    assert len(strides) == N_STRIDES
    end = (strides["start_s"] + strides["period_s"]).max()
    kept = [i for i in range(N) if not 500 <= i < 600]
    cut, left = strides_of(write_walk(tmp_path / "cut.csv", kept))
    # one second is gone, which is four strides and the one that is cut in two
    assert len(left) == N_STRIDES - 5
    assert (left["start_s"] + left["period_s"]).max() == pytest.approx(end, abs=1e-9)
    np.testing.assert_allclose(left["frequency_hz"], STRIDE_HZ, rtol=0.02)
    # the strides before and after are those of the whole recording, at the same times
    same = strides.merge(left.round({"start_s": 6}), on="leg").query(
        "abs(start_s_x-start_s_y)<0.01"
    )
    assert len(same) == len(left)
    rows = cut.dropped[cut.dropped["what"] == "frames"]
    assert rows[["start_s", "end_s"]].to_numpy().tolist() == [[5.0, 5.99]]
    assert rows["why"].tolist() == ["frames 500 to 599 are not in cut.csv"]
    assert not (whole.dropped["what"] == "frames").any()


def test_a_gap_short_enough_to_be_bridged_is_said_too(tmp_path):
    kept = [i for i in range(N) if i not in (500, 501)]
    tables, strides = strides_of(write_walk(tmp_path / "cut.csv", kept))
    assert len(strides) == N_STRIDES
    rows = tables.dropped[tables.dropped["what"] == "frames"]
    assert rows["why"].tolist() == ["frames 500 to 501 are not in cut.csv"]


def test_tracks_that_lack_frames_in_memory_say_so(tmp_path):
    tracks = read_any_tracks(write_walk(tmp_path / "whole.csv", range(N)), fps=FPS)
    tables = analyse(tracks.isel(time=[i for i in range(N) if not 500 <= i < 600]))
    rows = tables.dropped[tables.dropped["what"] == "frames"]
    assert rows["why"].tolist() == ["frames 500 to 599 are not in the tracks"]


@pytest.mark.slow
def test_the_command_writes_the_line(tmp_path):
    path = write_walk(tmp_path / "cut.csv", [i for i in range(N) if i != 700])
    run_gait([path], fps=FPS, figures="none", out=tmp_path / "out")
    dropped = pd.read_csv(tmp_path / "out" / "dropped.csv")
    (row,) = dropped[dropped["what"] == "frames"].to_dict("records")
    assert row["why"] == "frame 700 is not in cut.csv"
    assert row["start_s"] == row["end_s"] == 7.0


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ([0, 1, 2, 2, 3], "frame 2 is there twice"),
        ([0, 2, 1, 3], "frame 1 comes after frame 2; sort the rows"),
    ],
)
def test_frames_twice_or_out_of_order_are_refused(tmp_path, rows, message):
    with pytest.raises(InputError, match=message):
        run_gait([write_walk(tmp_path / "walk.csv", rows)], fps=FPS, figures="none")
