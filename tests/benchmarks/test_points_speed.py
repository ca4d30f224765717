"""The table of times: one row is written anew, the others stay."""

from __future__ import annotations

from pathlib import Path

import pytest

TABLE = Path(__file__).parents[2] / "docs" / "accuracy" / "speed.csv"


@pytest.mark.slow  # importing the renderer
def test_a_row_takes_the_place_of_that_of_its_command(tmp_path):
    import points_speed

    path = tmp_path / "speed.csv"
    path.write_bytes(TABLE.read_bytes())
    lines = path.read_text().splitlines()
    command = "`python benchmarks/points_speed.py --frames 300 --scale 1`"
    (at,) = [i for i, line in enumerate(lines) if command in line]
    points_speed.put_into(path, {"what": "w", "result": "1, and 2", "command": command})
    new = path.read_text().splitlines()
    assert new[at] == f'w,"1, and 2",{command}'
    assert [*new[:at], *new[at + 1 :]] == [*lines[:at], *lines[at + 1 :]]
    points_speed.put_into(path, {"what": "w", "result": "3", "command": "another"})
    assert path.read_text().splitlines() == [*new, "w,3,another"]
