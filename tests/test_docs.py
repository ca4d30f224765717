"""The documentation names what is there, and says what was measured."""

from __future__ import annotations

import csv
import dataclasses
import pkgutil
import re
from pathlib import Path

import pandas as pd
import pytest

import pawnb
from pawnb.core.paws.maghsoudi2019.settings import PUBLISHED_NAMES as PAW_NAMES
from pawnb.core.paws.maghsoudi2019.settings import Maghsoudi2019Settings
from pawnb.core.pose.pullar2009.settings import PUBLISHED_NAMES as POSE_NAMES
from pawnb.core.pose.pullar2009.settings import Pullar2009Settings
from pawnb.gait.events.event_edits import ExcludeStride

ROOT = Path(__file__).resolve().parents[1]
METHODS = (ROOT / "docs" / "published_methods.md").read_text(encoding="utf-8")
PAWS, POSES, GAIT = re.split("## Poses|## Gait", METHODS)


def rows(text):
    """Return (paper's name, our names, default) of each row of the tables."""
    cells = [line.strip("|").split("|") for line in text.splitlines() if line.startswith("| ")]
    return [
        (name.strip(), re.findall(r"`(\w+)`", ours), default.strip())
        for name, ours, default, _ in cells
        if "`" in ours
    ]


@pytest.mark.parametrize(
    ("text", "settings"), [(PAWS, Maghsoudi2019Settings), (POSES, Pullar2009Settings)]
)
def test_the_papers_names_stand_beside_settings_that_exist(text, settings):
    known = {field.name: field.default for field in dataclasses.fields(settings)}
    found = rows(text)
    assert len(found) > 7
    for _, names, default in found:
        assert set(names) <= set(known), names
        # numbers in the table are the defaults
        said = [float(word) for word in re.findall(r"(?<![\w./])\d+(?![\w./])", default)]
        value = known[names[0]]
        if isinstance(value, bool) or value is None or not said:
            continue
        own = value if isinstance(value, tuple) else [known[name] for name in names]
        assert said == [float(x) for x in own], names


@pytest.mark.parametrize(("text", "names"), [(PAWS, PAW_NAMES), (POSES, POSE_NAMES)])
def test_names_that_are_hinted_at_are_those_of_the_table(text, names):
    found = rows(text)
    for theirs, ours in names.items():
        assert any(theirs in re.split(r"[ ,()]+", row) and ours in own for row, own, _ in found)


def test_the_thesis_equations_tables_and_figures_stand_beside_calls_that_exist():
    """Pullar (2009): Eq. 3.18 to 3.26, Tables 4.1 to 4.6 and 5.1, Figs. 4.1 to 4.19 and 5.1."""
    calls = re.findall(r"`(pawnb(?:\.\w+)+)`", GAIT)
    assert len(calls) > 40
    for call in calls:
        assert callable(pkgutil.resolve_name(call)), call
    lines = [line.strip("|").split("|") for line in GAIT.splitlines() if line.startswith("| ")]
    said = " ".join(name for name, *_ in lines)
    numbers = {}
    for kind in ("Eq", "Table", "Fig"):
        lists = re.findall(rf"{kind}s?\.? ((?:\d\.\d+|, | to )+)", said)
        ranges = re.findall(r"(\d)\.(\d+)(?: to \d\.(\d+))?", "; ".join(lists))
        numbers[kind] = {
            f"{chapter}.{number}"
            for chapter, first, last in ranges
            for number in range(int(first), int(last or first) + 1)
        }
    assert numbers["Eq"] == {f"3.{k}" for k in range(18, 27)}
    assert numbers["Table"] == {"4.1", "4.2", "4.3", "4.4", "4.5", "4.6", "5.1"}
    assert numbers["Fig"] >= {f"4.{k}" for k in range(1, 20)} | {"3.10", "3.11", "5.1"}


def test_section_3_2_of_the_2019_paper_is_complete():
    """Its list of key parameters."""
    named = {name for name, _, _ in rows(PAWS)}
    assert named >= {
        "NumSLIC", "Collision_Threshold", "Start_Frame_Collision", "PawXWindowSize",
        "PawYWindowSize", "Weights_F", "Weights_H",
    }  # fmt: skip


PAGES = [
    "README.md",
    "CONTRIBUTING.md",
    "CHANGELOG.md",
    *sorted(
        str(path.relative_to(ROOT))
        for path in (ROOT / "docs").rglob("*")
        if path.suffix in (".md", ".csv") and not {"_build", "_generated"} & set(path.parts)
    ),
]
README = (ROOT / "README.md").read_text(encoding="utf-8")
ACCURACY = ROOT / "docs" / "accuracy"


@pytest.mark.parametrize("page", PAGES)
def test_files_that_are_named_are_there(page):
    text = (ROOT / page).read_text(encoding="utf-8")
    named = re.findall(r"`((?:docs|benchmarks|pawnb)/[\w/.]+)`", text)
    named += re.findall(r"python (benchmarks/\w+\.py)", text)
    named += re.findall(r"\]\((docs/[\w/.]+)\)", text)
    for name in named:
        assert (ROOT / name).exists(), name


def test_readme_is_short_and_gives_the_two_commands():
    assert len(README.split()) <= 500
    lines = README.splitlines()
    assert "python -m pip install -e . && pawnb lab" in lines
    # .ci/run takes this line from here and runs it
    assert lines.count('python -m pip install -e ".[test]" && python -m pytest') == 1


def code_of(heading):
    """Return the Python below a heading of the README."""
    return re.search(rf"## {heading}\n.*?```python\n(.*?)```", README, re.S).group(1)


@pytest.mark.slow
def test_readme_goes_from_deeplabcut_to_phases(tmp_path, monkeypatch):
    import matplotlib.pyplot as plt

    monkeypatch.chdir(tmp_path)
    pawnb.synthetic.write_deeplabcut_sample(".", animals=3)
    made = {}
    exec(code_of("From DeepLabCut"), made)  # noqa: S102  (the README's own lines)
    assert made["gait"].strides["animal"].nunique() == 3
    plt.close("all")


@pytest.mark.slow
def test_readme_goes_from_video_to_a_gait_diagram(tmp_path, monkeypatch):
    import matplotlib.pyplot as plt

    monkeypatch.chdir(tmp_path)
    pawnb.sample_trial("m07-35cms-03", frames=60, scale=0.2)
    made = {}
    exec(code_of("From video"), made)  # noqa: S102
    assert sorted(made["table"]["leg"].unique()) == ["FL", "FR", "HL", "HR"]
    assert (tmp_path / "m07-35cms-03" / "results" / "tracks.nc").exists()  # as pawnb gait wants it
    plt.close("all")


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:Passing unrecognized arguments:DeprecationWarning")  # ipympl
def test_getting_started_keeps_all_where_the_commands_look_for_it(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    pawnb.sample_trial("m07-35cms-03", frames=150, scale=0.2)
    page = (ROOT / "docs" / "getting_started.md").read_text(encoding="utf-8")
    lines = re.search(r"```python\n(.*?)```", page, re.S)[1]
    made = {}
    opened = "explorer = pawnb.widgets.GaitExplorer"
    exec(lines.replace("pawnb.widgets.GaitExplorer", opened), made)  # noqa: S102
    assert [path.name for path in tmp_path.iterdir()] == ["m07-35cms-03"]
    stride = made["gait"].strides.iloc[0]
    made["explorer"].session.edits.apply(
        ExcludeStride(
            animal=stride["animal"], trial=stride["trial"], leg=stride["leg"],
            start_s=stride["start_s"], reason="stumbled",
        )
    )  # fmt: skip
    run = pawnb.run_gait("m07-35cms-03", figures="none")  # as pawnb gait does
    assert len(run.tables.strides) == len(made["gait"].strides) - 1


@pytest.mark.slow
def test_the_figures_of_the_guide_are_drawn_and_made_again(tmp_path, monkeypatch, capsys):
    import matplotlib.pyplot as plt

    monkeypatch.chdir(tmp_path)
    page = (ROOT / "docs" / "guide" / "figures.md").read_text(encoding="utf-8")
    study = pawnb.synthetic.simulate_spider_study(animals=2, trials=1)
    runs = [pawnb.gait.analyse(run.tracks(), trial=run.trial) for run in study.runs]
    made = {"gait": pawnb.gait.pool(runs)}
    drawn, kept, styled = re.findall(r"```python\n(.*?)```", page, re.S)
    exec(drawn + kept, made)  # noqa: S102  (the page's own lines)
    assert capsys.readouterr().out.strip() in kept
    with pawnb.figures.style():  # what is set is set back
        exec("from pawnb import figures\n" + styled.replace("set_style", "style"), {})  # noqa: S102
    plt.close("all")


@pytest.mark.parametrize("path", sorted(ACCURACY.glob("*.csv")), ids=lambda path: path.stem)
def test_tables_of_accuracy_are_whole_and_shown(path):
    head, *rows_ = csv.reader(path.read_text(encoding="utf-8").splitlines())
    assert rows_
    assert {len(row) for row in rows_} == {len(head)}
    assert all(cell.strip() for row in rows_ for cell in row)
    shown = re.compile(rf":file: (\.\./)?accuracy/{re.escape(path.name)}$", re.M)
    pages = [*(ROOT / "docs").glob("*.md"), *(ROOT / "docs" / "guide").glob("*.md")]
    assert any(shown.search(page.read_text(encoding="utf-8")) for page in pages)


def real_clips():
    """Return the table of real clips: the clips, and the rows that are means of them."""
    table = pd.read_csv(ACCURACY / "real_clips.csv", index_col="clip")
    is_mean = table.index.str.startswith("mean")
    return table[~is_mean], table[is_mean]


def test_means_of_real_clips_are_those_of_their_rows():
    clips, means = real_clips()
    assert "mean" in means.index
    for name, row in means.iterrows():
        gone = [clip for clip in clips.index if name == f"mean without {clip}"]
        # cells are rounded, and so is what is made of them
        assert (clips.drop(index=gone).mean() - row).abs().max() <= 1.0, name


def test_the_readmes_lines_on_accuracy_are_those_of_the_tables():
    said = " ".join(README.split("## How good it is")[1].split("## ")[0].split())
    clips, means = real_clips()
    pawnb_, lk, csrt = (
        [int(means.loc["mean", f"{clicks}: {who}"]) for clicks in (1, 2, 3)]
        for who in ("pawnb", "LK", "CSRT")
    )
    one, two, three = pawnb_
    assert f"{one} % of marks are right from one clicked frame, {two} % from two, {three} %" in said
    assert "Lucas-Kanade " + ", ".join(map(str, lk)) in said
    assert "CSRT " + ", ".join(map(str, csrt)) in said
    ones = clips["1: pawnb"]
    assert f"is a {ones.idxmin().split('_')[0]}: {ones.min()} %" in said
    page = " ".join((ROOT / "docs" / "accuracy.md").read_text(encoding="utf-8").split())
    right, of = re.search(r"is right in (\d+) of the (\d+) cells", page).groups()
    assert f"right in {right} of {of} cases" in said
    paws = (ACCURACY / "paws.csv").read_text(encoding="utf-8")
    frames, errors = re.search(r"([\d,]+) frames with (\d+) errors", paws).groups()
    assert f"{frames} frames: no paw lost, {errors} short mistakes" in said
    statistics = (ACCURACY / "statistics.csv").read_text(encoding="utf-8")
    holds = re.search(r"holds the truth in ([\d.]+ to [\d.]+ %)", statistics).group(1)
    assert f"hold the true mean phase in {holds}" in said
    assert re.search(r"strides as animals: (\d+ to \d+ %)", statistics).group(1) in said


def test_citation_is_that_of_this_version():
    """Keys that version 1.2.0 of the Citation File Format asks for, and ours."""
    import yaml

    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert {"cff-version", "message", "title", "authors"} <= set(cited)
    assert cited["cff-version"] == "1.2.0"
    assert str(cited["version"]) == pawnb.__version__
    assert cited["license"] == "BSD-3-Clause"
    for person in [*cited["authors"], *(a for r in cited["references"] for a in r["authors"])]:
        assert "name" in person or {"family-names", "given-names"} <= set(person)


def test_change_log_has_the_usual_sections():
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert re.findall(r"^### (\w+)$", text, re.M)[:3] == ["Added", "Changed", "Fixed"]
    assert pawnb.__version__ in text
    assert "whole/" not in text, "a user's words: no names of inner modules"
