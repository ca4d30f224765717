"""The record of what was done names every input and nothing of the machine."""

from __future__ import annotations

import hashlib
import json

import pytest

from pawnb.errors import InputError
from pawnb.schema import make_tracks
from pawnb.trial import Animal, Calibration, Trial, View
from pawnb.workflow.provenance import record as provenance
from pawnb.workflow.provenance.results import provenance_steps


def test_checksum_is_sha256_of_the_file(tmp_path):
    (tmp_path / "a.bin").write_bytes(b"abc")
    # FIPS 180-2, appendix B.1: SHA-256 of "abc"
    known = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
    assert provenance.file_checksum(tmp_path / "a.bin") == "sha256:" + known


def test_checksum_of_pictures_changes_with_any_of_them(tmp_path):
    folder = tmp_path / "frames"
    folder.mkdir()
    for number in range(3):
        (folder / f"f{number}.png").write_bytes(bytes([number]))
    first = provenance.file_checksum(folder)
    assert first == provenance.file_checksum(folder / "f*.png")
    (folder / "f1.png").write_bytes(b"other")
    assert provenance.file_checksum(folder) != first
    (folder / "f1.png").write_bytes(bytes([1]))
    (folder / "f1.png").rename(folder / "f9.png")
    assert provenance.file_checksum(folder) != first


def test_missing_input_is_named(tmp_path):
    with pytest.raises(InputError, match=r"cam1\.avi: no such file; check the path in the trial"):
        provenance.file_checksum(tmp_path / "cam1.avi")


def test_every_file_of_a_trial_is_listed_once(tmp_path):
    for name in ("a.avi", "dlt.csv", "start.csv", "belt.csv"):
        (tmp_path / name).write_text(name)
    trial = Trial(
        kind="paws",
        name="t",
        fps=100,
        animal=Animal(id="a"),
        folder=tmp_path,
        belt_speed="belt.csv",
        views=(View(name="top", video="a.avi"), View(name="side", video="a.avi")),
        calibration=Calibration(dlt="dlt.csv"),
        start_points="start.csv",
    )
    sums = provenance.trial_checksums(trial)
    assert list(sums) == ["a.avi", "dlt.csv", "start.csv", "belt.csv"]
    assert sums["belt.csv"] == "sha256:" + hashlib.sha256(b"belt.csv").hexdigest()


def test_no_absolute_path_is_kept(tmp_path):
    record = provenance.build_step(
        "track",
        command=["pawnb", "track", str(tmp_path / "m 1"), "--set", f"a={tmp_path}/b"],
        inputs={"b": "2", "a": "1"},
        settings={"median_px": 5},
        method="paper",
    )
    assert record["command"] == 'pawnb track "m 1" --set a=b'
    assert str(tmp_path) not in json.dumps(record)
    assert record["versions"]["pawnb"]
    assert record["method"] == "paper"
    files = {"a.csv": {"run": "track", "sha256": "0"}}
    text = provenance.provenance_text([record], files=files)
    assert json.loads(text) == {"files": files, "steps": [record]}


@pytest.mark.parametrize("out", [["--out", "a b"], ["--out=a"], []])
def test_where_results_are_written_changes_no_byte_of_them(out):
    command = ["pawnb", "gait", "m1", *out, "--legs", "FR"]
    assert provenance.plain_command(command) == "pawnb gait m1 --legs FR"


@pytest.mark.parametrize("text", ["[", "[" * 10**5, "[]", '{"steps": 1}', '{"steps": [1]}', "1"])
def test_a_record_that_is_none_is_one_sentence(text):
    tracks = make_tracks(range(2), ["FR"], fps=250.0)
    assert provenance_steps(tracks) == []
    with pytest.raises(InputError, match="is not a record of steps"):
        provenance_steps(tracks.assign_attrs(provenance=text))
    del tracks.attrs["provenance"]
    assert provenance_steps(tracks) == []


def test_packages_that_offer_evidence_are_among_the_versions(tmp_path, monkeypatch):
    """A package as pip installs it, with an entry point as it writes it."""
    info = tmp_path / "otherkind-0.3.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: otherkind\nVersion: 0.3\n")
    (info / "entry_points.txt").write_text("[pawnb.evidence]\nnet = otherkind:Net\n")
    assert "otherkind" not in provenance.package_versions()
    monkeypatch.syspath_prepend(tmp_path)
    provenance._versions.cache_clear()
    try:
        assert provenance.package_versions()["otherkind"] == "0.3"
    finally:
        provenance._versions.cache_clear()
