"""Options that commands share, names that were meant, and completion in a real shell."""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess

import numpy as np
import pandas as pd
import pytest

from pawnb import cli
from pawnb.cli.arguments import build_parser
from pawnb.cli.completion import SHELLS, completion_script
from pawnb.cli.shared import of_results, print_json

TRIAL = (
    '[trial]\nkind = "tracks"\nname = "t"\nfps = 250.0\n[animal]\nid = "m"\n'
    '[tracks]\nfile = "none.csv"\n'
)


@pytest.fixture
def scored(tmp_path):
    """Six strides of two legs, scored by hand."""
    rows = [
        (leg, event, 0.2 * k + late)
        for leg in ("FR", "FL")
        for k in range(6)
        for event, late in (("TD", 0.0), ("LO", 0.12))
    ]
    path = tmp_path / "scored.csv"
    pd.DataFrame(rows, columns=["leg", "event", "time_s"]).to_csv(path, index=False)
    return path


@pytest.mark.parametrize(
    ("words", "hint"),
    [
        (["trak", "x"], "(did you mean 'track'?)"),
        (["gait", "x", "--figures", "mian"], "(did you mean 'main'?)"),
        (["gait", "x", "--figure-names", "x"], "unrecognized"),
        (
            ["check", "x", "--jsn"],
            "pawnb check: unrecognized arguments: --jsn (did you mean '--json'?)",
        ),
        (["completion", "bsh"], "(did you mean 'bash'?)"),
    ],
)
def test_a_near_name_is_suggested(capsys, words, hint):
    with pytest.raises(SystemExit) as caught:
        cli.main(words)
    err = capsys.readouterr().err
    assert (caught.value.code, err.count("\n")) == (2, 1)
    assert hint in err


def test_formats_and_settings_have_near_names_too(tmp_path, capsys, scored):
    (tmp_path / "p.csv").write_text("frame,FR_x,FR_y\n0,1,2\n1,2,3\n")
    convert = ["convert", str(tmp_path / "p.csv"), str(tmp_path / "x"), "--fps", "9"]
    assert cli.main([*convert, "--to", "deeplabcu"]) == 2
    assert "did you mean 'deeplabcut'" in capsys.readouterr().err
    assert cli.main(["gait", str(scored), "--set", "min_stance=1"]) == 2
    assert "did you mean 'min_stance_s'" in capsys.readouterr().err
    assert cli.main(["gait", str(scored), "--legs", "RF"]) == 2
    assert "did you mean 'FR'" in capsys.readouterr().err


def test_json_of_a_check_holds_what_the_words_say(tmp_path, capsys):
    (tmp_path / "trial.toml").write_text(TRIAL)
    assert cli.main(["check", str(tmp_path), "--json"]) == 2
    found = json.loads(capsys.readouterr().out)
    assert found["trial"] == "t"
    assert any("none.csv" in fault for fault in found["faults"])
    assert cli.main(["check", str(tmp_path), "-q", "--json"]) == 2
    assert json.loads(capsys.readouterr().out) == found


@pytest.mark.slow
def test_json_of_a_gait_analysis_and_its_record(scored, capsys):
    words = ["gait", str(scored), "--figures", "none", "--out", str(scored.parent / "out")]
    assert cli.main([*words, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["n_animals"], found["n_strides"]) == (1, 10)
    assert "strides.csv" in found["files"]
    assert found["phase_summary"][0]["ci_low"] is None  # one animal
    first = (scored.parent / "out" / "provenance.json").read_bytes()
    assert cli.main([*words, "-q"]) == 0
    assert capsys.readouterr() == ("", "")
    assert (scored.parent / "out" / "provenance.json").read_bytes() == first


def test_quiet_says_errors_only_and_verbose_where_they_arose(capsys):
    assert cli.main(["check", "nowhere", "-q"]) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert cli.main(["check", "nowhere", "-v"]) == 2
    assert "Traceback" in capsys.readouterr().err


def test_flags_may_stand_before_the_command(tmp_path, capsys):
    (tmp_path / "trial.toml").write_text(TRIAL)
    assert cli.main(["-q", "check", "nowhere"]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert cli.main(["--verbose", "check", "nowhere"]) == 2
    assert "Traceback" in capsys.readouterr().err
    assert cli.main(["--json", "check", str(tmp_path)]) == 2
    assert json.loads(capsys.readouterr().out)["trial"] == "t"
    with pytest.raises(SystemExit):
        cli.main(["-v", "-q", "check", "nowhere"])
    assert "not allowed with argument" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        cli.main(["-v"])
    assert "required: COMMAND" in capsys.readouterr().err


def test_how_much_is_said_is_no_part_of_the_record():
    assert of_results(["gait", "x", "-q", "--json", "--fps", "9"]) == ["gait", "x", "--fps", "9"]


def test_tables_become_rows_and_missing_values_null(capsys):
    print_json(table=pd.DataFrame({"x": [0.1 + 0.2, np.nan], "n": [1, 2]}), name="ü")
    said = capsys.readouterr().out
    assert json.loads(said) == {
        "table": [{"x": 0.1 + 0.2, "n": 1}, {"x": None, "n": 2}], "name": "ü",
    }  # fmt: skip


def _commands():
    actions = build_parser()._actions
    return next(a for a in actions if isinstance(a, argparse._SubParsersAction)).choices


def test_every_command_is_completed_in_every_shell():
    for shell in SHELLS:
        script = completion_script(shell, _commands())
        assert all(name in script for name in _commands())
        assert "--figures" in script


@pytest.mark.skipif(shutil.which("bash") is None, reason="no bash")
def test_bash_completes_commands_and_options():
    code = completion_script("bash", _commands()) + (
        "COMP_WORDS=(pawnb rep); COMP_CWORD=1; _pawnb; echo ${COMPREPLY[@]}\n"
        "COMP_WORDS=(pawnb gait x --fi); COMP_CWORD=3; _pawnb; echo ${COMPREPLY[@]}\n"
        "COMP_WORDS=(pawnb -v rep); COMP_CWORD=2; _pawnb; echo ${COMPREPLY[@]}\n"
        "COMP_WORDS=(pawnb -v gait x --fi); COMP_CWORD=4; _pawnb; echo ${COMPREPLY[@]}\n"
    )
    done = subprocess.run(["bash", "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == ["reproduce report", "--figures"] * 2


def test_a_leg_is_one_point_and_a_point_one_leg(tmp_path, capsys):
    """One of two was lost without a word."""
    rows = "".join(f"{i},{i},2,3,4\n" for i in range(5))
    (tmp_path / "p.csv").write_text("frame,a_x,a_y,b_x,b_y\n" + rows)
    convert = ["convert", str(tmp_path / "p.csv"), str(tmp_path / "x.nc"), "--to", "pawnb"]
    convert += ["--fps", "9", "--legs"]
    assert cli.main([*convert, "FR=a", "FR=b"]) == 2
    assert "--legs: leg 'FR' is there twice" in capsys.readouterr().err
    assert cli.main([*convert, "FR=a", "FL=a"]) == 2
    assert "two legs are the one point 'a'; name another" in capsys.readouterr().err
    assert cli.main([*convert, "FR=a", "FL=b"]) == 0


def test_where_to_write_is_said_in_one_way_by_every_command():
    (commands,) = (a for a in build_parser()._actions if isinstance(a, argparse._SubParsersAction))
    outs = {
        name: action.option_strings
        for name, parser in commands.choices.items()
        for action in parser._actions
        if {"-o", "--out"} & set(action.option_strings)
    }
    assert {"track", "gait", "report", "batch", "calibrate"} <= set(outs)
    assert {tuple(names) for names in outs.values()} == {("-o", "--out")}
