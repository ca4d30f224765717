"""Names that become files and folders."""

from __future__ import annotations

import os
import shlex
import subprocess

import pytest

from pawnb.errors import InputError
from pawnb.files import as_word, child_folder, distinct_name, safe_name


@pytest.mark.parametrize(
    "name",
    ["../../escaped", "/escaped", "..", ".", "", "a/b", "a\\b", "..\\b", "C:x", "NUL",
     "con.txt", "a\0b", "a\nb", "x" * 300, "ends.", " "],
)  # fmt: skip
def test_names_that_lead_elsewhere_are_refused(tmp_path, name):
    with pytest.raises(InputError, match="the trial is called"):
        child_folder(tmp_path, name, what="the trial")


def test_plain_names_are_folders_in_the_folder(tmp_path):
    for name in ("m07", "m07-35cms.03", "Maus 7 µ", ".hidden", "..a"):
        assert child_folder(tmp_path / "none", name, what="the trial") == tmp_path / "none" / name


@pytest.mark.skipif(os.name == "nt", reason="links need rights there")
def test_a_link_that_leads_out_is_refused(tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "m07").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(InputError, match=r"leads to .*elsewhere"):
        child_folder(tmp_path / "out", "m07", what="the trial")
    # the folder itself may be one: a person has chosen it
    (tmp_path / "linked").symlink_to(tmp_path / "out")
    assert child_folder(tmp_path / "linked", "m08", what="the trial").parent.name == "linked"


def test_safe_names_are_short_and_have_no_signs_of_paths():
    assert safe_name("../a b.c") == "---a-b-c"
    long = [safe_name("ü" * 300 + end) for end in "ab"]
    assert all(len(name.encode()) <= 120 for name in long)
    assert long[0] != long[1]


def test_taken_names_are_numbered():
    assert distinct_name("a", set()) == "a"
    assert distinct_name("A", {"a", "a-2"}) == "A-3"


@pytest.mark.skipif(os.name == "nt", reason="needs a POSIX shell")
@pytest.mark.parametrize("path", ["plain/m07", "Versuch Mäuse 1", "it's $5", "a;b", 'say "x"'])
def test_a_shell_reads_a_path_as_one_word(path):
    """What is printed as the next command is copied into a shell."""
    found = subprocess.check_output(["sh", "-c", f"printf '%s|' {as_word(path)}"], text=True)
    assert found == f"{path}|"


def test_a_plain_path_is_typed_as_it_is():
    assert as_word("results/m07-03") == "results/m07-03"
    assert shlex.split(as_word("a b")) == ["a b"]
