"""Animals, groups and gait settings that change after tracking: no track is made again for them."""

from __future__ import annotations

import json

import pytest

from pawnb.io.native import read_tracks
from pawnb.workflow.batch.run import batch
from pawnb.workflow.gait.sources import read_source
from pawnb.workflow.provenance.manifest import find_fault
from pawnb.workflow.provenance.reproduce import reproduce

pytestmark = pytest.mark.slow  # a scene is tracked

QUICK = {"choose_path": False}


def change(toml, **fields):
    """Write other fields of the animal."""
    text = toml.read_text()
    lines = [one for one in text.splitlines() if not one.startswith(("id =", "group ="))]
    new = [f'{name} = "{value}"' for name, value in fields.items()]
    at = lines.index("[animal]") + 1
    toml.write_text("\n".join([*lines[:at], *new, *lines[at:]]) + "\n")


def test_a_study_that_is_unblinded_is_not_tracked_again(small_spider, tmp_path):
    """All was tracked again; where corrections lay, the trial failed, and --out kept old groups."""
    toml, out = small_spider / "trial.toml", tmp_path / "out"
    (first,) = batch(small_spider, settings=QUICK, out=out).table.itertuples()
    assert first.status == "tracked"
    folder = tmp_path / "out" / json.loads(_trial(first.out))["trial"]["name"]
    before = read_tracks(folder / "tracks.nc")
    (folder / "edits.jsonl").write_text("")  # a review was opened
    change(toml, id="m07", group="lesion")
    with toml.open("a") as file:
        file.write("[gait]\nmin_stance_s = 0.02\n")
    (row,) = batch(small_spider, settings=QUICK, out=out).table.itertuples()
    assert (row.status, row.verdict) == ("skipped", first.verdict)
    assert "the animal and the settings of gait brought to what the trial says now" in row.said
    source = read_source(folder)
    assert source.animals == ("m07",)
    assert source.trial.animal.group == "lesion"
    assert source.settings == {"min_stance_s": 0.02}
    now = read_tracks(folder / "tracks.nc")
    assert now["individual"].item() == "m07"
    assert (
        now.drop_attrs()
        .drop_vars("individual")
        .identical(before.drop_attrs().drop_vars("individual"))
    )
    assert find_fault(folder, run="track") is None
    (row,) = batch(small_spider, settings=QUICK, out=out).table.itertuples()
    assert (row.status, row.said) == ("skipped", f"tracked already, {folder}")
    (folder / "edits.jsonl").unlink()
    # the very bytes that tracking it under its new name gives
    assert reproduce(folder / "tracks.nc", inputs=small_spider).identical


def test_what_shapes_tracks_is_still_tracked_again(small_spider):
    toml = small_spider / "trial.toml"
    assert batch(small_spider, settings=QUICK).table["status"].item() == "tracked"
    change(toml, id="m07")
    toml.write_text(toml.read_text().replace("fps = 125.0", "fps = 120.0"))
    assert batch(small_spider, settings=QUICK).table["status"].item() == "tracked"


def _trial(out):
    return read_tracks(f"{out}/tracks.nc").attrs["trial"]
