"""The belt's speed as a number or a table: interpolated by hand, and what is refused."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from pawnb.errors import InputError
from pawnb.gait.analysis.stated_belt import belt_on_grid
from pawnb.gait.locomotion.grid import Grid

GRID = Grid(time_s=np.arange(5) / 100.0, frame=np.arange(5.0), fs_hz=100.0)
TABLE = pd.DataFrame({"frame": [4, 0, 2], "speed": [30.0, 10.0, 20.0]})


@pytest.mark.parametrize(
    "table",
    [
        TABLE,
        TABLE.astype({"frame": "Int64", "speed": "Float64"}),
        TABLE.astype(str),
        TABLE.astype(object),
        TABLE.set_axis([7, 7, 7]).assign(note="x"),
    ],
)
def test_a_table_of_any_types_in_any_order_gives_the_same_speeds(table):
    before = table.copy()
    assert belt_on_grid(table, None, GRID).tolist() == [10.0, 15.0, 20.0, 25.0, 30.0]
    pd.testing.assert_frame_equal(table, before)


@pytest.mark.parametrize("speed", [240, 240.0, np.int64(240), np.float32(240)])
def test_a_number_is_the_speed_at_every_sample(speed):
    assert belt_on_grid(speed, None, GRID).tolist() == [240.0] * 5


@pytest.mark.parametrize(
    ("stated", "message"),
    [
        # two speeds of one frame: the line between frames would lead through either
        (pd.concat([TABLE, TABLE.assign(speed=0.0)]), r"frame 0 is there twice; keep one"),
        (TABLE.assign(frame=[4, np.nan, 0]), r"a frame is no number; give each row its frame"),
        (TABLE.assign(frame=["4", "zero", "2"]), r"expected numbers in frame and speed"),
        (TABLE.assign(speed=[30.0, np.nan, 1.0]), r"a speed is not a finite number"),
        (TABLE.iloc[:0], r"frames none; expected all from 0 to 4"),
        ([240.0] * 5, r"expected a number in unit per second, or a table with the columns frame"),
        (np.full(5, 240.0), r"expected a number in unit per second"),
        (pd.Series([240.0] * 5), r"expected a number in unit per second"),
        (True, r"belt_speed is True; expected a number"),
        ("240", r"belt_speed is '240'; expected a number"),
    ],
)
def test_what_says_no_speed_is_refused(stated, message):
    with pytest.raises(InputError, match=message):
        belt_on_grid(stated, None, GRID)
