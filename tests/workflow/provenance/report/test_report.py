"""The index of a run and the report of a study: what a reader sees, and nothing a name could do."""

from __future__ import annotations

import dataclasses
import html.parser
import json
import os
import re
from pathlib import Path
from urllib.parse import unquote

import numpy as np
import pandas as pd
import pytest
from PIL import Image

from pawnb.cli import main
from pawnb.figures.measure_heat_map import say_measure
from pawnb.gait import analyse_events
from pawnb.gait.cycles import LegSignals
from pawnb.schema import ORIGIN_CODE, make_tracks
from pawnb.workflow.gait.run import run_gait
from pawnb.workflow.provenance.report.html import page, table
from pawnb.workflow.provenance.report.index_page import index_page, note_lines
from pawnb.workflow.provenance.report.methods_text import count_dropped, methods_paragraphs
from pawnb.workflow.provenance.report.report import _by_group, _by_leg, write_report
from pawnb.workflow.provenance.report.tracking_text import tracking_sentences
from pawnb.workflow.provenance.report.words import figure_order

HOSTILE = "<img src=x onerror=alert(1)>&'\""
HOSTILE_FILE = "rose #1 &'%.png" if os.name == "nt" else "rose #1 &'\"%.png"


class Reader(html.parser.HTMLParser):
    """What a browser would make of a page: tags, links, and the text."""

    def __init__(self, source: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.named: list[str] = []
        self.said: list[str] = []
        self.feed(source)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        own = dict(attrs)
        self.named += [own[name] or "" for name in ("src", "href") if name in own]
        assert not [name for name in own if name.startswith("on")]

    def handle_data(self, data: str) -> None:
        self.said.append(data)


def events(animals=("m1", "m2"), groups=False):
    """A foot lands every 0.2 s and lifts 0.12 s later; left legs half a stride later."""
    return pd.DataFrame(
        [
            {"animal": animal, "trial": "t1", "leg": leg, "event": event,
             "time_s": 0.2 * k + late + 0.1 * leg.endswith("L")}
            | ({"group": animal} if groups else {})
            for animal in animals
            for leg in ("FR", "FL")
            for k in range(6)
            for event, late in (("TD", 0.0), ("LO", 0.12))
        ]
    )  # fmt: skip


def test_no_name_becomes_html():
    found = Reader(page(HOSTILE, [table(pd.DataFrame({HOSTILE: [HOSTILE, None]}))]))
    assert "img" not in found.tags
    assert found.said.count(HOSTILE) == 4  # title, heading, column, cell


def test_the_index_names_every_file_and_links_within_its_folder(tmp_path):
    files = [tmp_path / "strides.csv", tmp_path / "figures" / HOSTILE_FILE]
    files[1].parent.mkdir()
    Image.new("RGB", (20, 10)).save(files[1])
    notes = pd.DataFrame([[HOSTILE, "was guessed", "1-3"]], columns=["where", "what", "rows"])
    source = index_page(files, tmp_path, notes=notes, paragraphs=["Six strides."])
    found = Reader(source)
    assert {unquote(name) for name in found.named} == {
        "./strides.csv", "./provenance.json", f"./figures/{HOSTILE_FILE}",
    }  # fmt: skip
    assert f"{HOSTILE}, rows 1-3: was guessed" in found.said
    # whoever is sent the folder finds here how to check it
    assert "pawnb reproduce . --inputs FOLDER" in " ".join(found.said)
    assert source.index("was guessed") < source.index("Six strides") < source.index("strides.csv")


def test_figures_of_all_animals_stand_before_those_of_trials():
    names = ["figures/gait_diagram_a", "figures/phase_rose", "figures/estimation_speed", "odd"]
    ordered = sorted(names, key=figure_order)
    assert ordered == [names[2], names[1], names[0], names[3]]


def test_notes_without_a_place_are_sentences():
    notes = pd.DataFrame([[None, "what", None]], columns=["where", "what", "rows"])
    assert note_lines(notes) == ["what"]


def test_the_methods_count_what_the_tables_hold():
    tables = analyse_events(events())
    step = {
        "settings": {"cutoff_hz": None}, "versions": {"pawnb": "1", "python": "3"},
        "settings_of_trials": {"m1, t1": {"min_stance_s": 0.02}}, "sources": {},
    }  # fmt: skip
    text = "\n".join(methods_paragraphs(tables, {}, step=step))
    assert "2 trials of 2 animals: 20 strides (FR 10, FL 10), 10 of each animal." in text
    assert "m1, t1: min_stance_s 0.02" in text
    assert "Butterworth" not in text  # nothing was smoothed


def test_the_methods_say_what_was_in_force_and_whose_strides_they_are():
    """As a reviewer asks: cut-offs, gaps and confidence in force, settings by hand, n by group."""
    notes = [
        f"t{k}: FR (position): about 3 strides a second; low-pass {hz} Hz, gaps bridged up to "
        f"{gap} s, stance at least 0.03 s."
        for k, (hz, gap) in enumerate([(33.9, 0.0295), (27.4, 0.0365)])
    ] + ["t0: positions with a confidence below 0.6 count as missing."]
    position = LegSignals(
        animal="m1", trial="t0", legs=("FR",), time_s=np.arange(9) / 100, samples=np.zeros((9, 1))
    )
    tables = dataclasses.replace(analyse_events(events()), notes=tuple(notes), signals=(position,))
    step = {
        "settings": {"cutoff_hz": None, "min_stance_s": 0.03, "bouts": True},
        "versions": {"pawnb": "1", "python": "3"}, "sources": {},
    }  # fmt: skip
    groups = {"m1": "b", "m2": "a"}
    every = {"strides": tables.strides.assign(group=tables.strides["animal"].map(groups))}
    tracks = make_tracks(range(10), ["FR"], fps=200.0)
    tracks.attrs["source_software"] = "DeepLabCut"
    text = "\n".join(methods_paragraphs(tables, every, step=step, tracked=[tracks]))
    assert "stride frequency of each trial (27.4 to 33.9 Hz)" in text
    assert "Gaps were bridged up to 0.0295 to 0.0365 s." in text
    assert "confidence was below 0.6." in text
    assert "Settings by hand: min_stance_s 0.03." in text
    assert "Groups: a 1 animal, 10 strides; b 1 animal, 10 strides." in text
    assert "Nat. Neurosci. 21: 1281-1289" in text


def test_reasons_that_differ_in_numbers_only_are_one_line():
    why = ["not tracked for 11 frames; gaps are bridged up to 0.03 s",
           "not tracked for 7 frames; gaps are bridged up to 0.03 s", "no AEP of L1 in stride 3",
           "no AEP of L2 in stride 4",
           "not tracked for 1 frame; gaps are bridged up to 0.03 s"]  # fmt: skip
    dropped = pd.DataFrame({"animal": "m1", "what": "track", "why": why})
    counted = count_dropped(dropped, ["what", "why"])
    assert counted.to_numpy().tolist() == [
        ["track", "not tracked for 1 to 11 frames; gaps are bridged up to 0.03 s", 3],
        ["track", "no AEP of L1 in a stride", 1],
        ["track", "no AEP of L2 in a stride", 1],
    ]


@pytest.mark.slow
def test_results_of_an_analysis_are_no_study(tmp_path, capsys):
    """Their events alone would tell no filter, and hardly a drop."""
    events().to_csv(tmp_path / "scored.csv", index=False)
    run_gait(tmp_path / "scored.csv", out=tmp_path / "g", figures="none", command=["pawnb", "gait"])
    assert main(["report", str(tmp_path / "g"), "-o", str(tmp_path / "r.html")]) == 2
    assert "holds the results of an analysis (pawnb gait) and not" in capsys.readouterr().err
    assert not (tmp_path / "r.html").exists()


def test_one_animal_has_no_statistics_over_animals():
    step = {
        "settings": {"cutoff_hz": None}, "versions": {"pawnb": "1", "python": "3"}, "sources": {},
    }  # fmt: skip
    tables = analyse_events(events(animals=("m1",)))
    every = {"phase_summary": tables.phase_summary}
    text = "\n".join(methods_paragraphs(tables, every, step=step))
    assert "one animal only" in text
    assert "Rayleigh" not in text
    both = analyse_events(events())
    text = "\n".join(methods_paragraphs(both, {"phase_summary": both.phase_summary}, step=step))
    assert text.count("Rayleigh") == 2  # the test, and its source


def test_methods_name_only_tests_that_were_made():
    """With one animal in a group there is none: 'compared by none', and Holm's p, was said."""
    step = {
        "settings": {"cutoff_hz": None}, "versions": {"pawnb": "1", "python": "3"}, "sources": {},
    }  # fmt: skip
    tables = analyse_events(events())
    groups = pd.DataFrame({"method": ["none", "none"], "design": "unpaired"})
    text = "\n".join(methods_paragraphs(tables, {"groups": groups}, step=step))
    assert "compared by" not in text
    assert "Holm" not in text
    assert "Differences between groups are described and not tested" in text
    some = groups.assign(method=["none", "Welch's t, 5.4 df"])
    text = "\n".join(methods_paragraphs(tables, {"groups": some}, step=step))
    assert "Groups were compared by Welch's t test of the means of animals. " in text
    assert text.count("Holm") == 2  # the method, and its source


def test_the_methods_say_how_points_were_tracked():
    own = make_tracks(range(10), ["FR", "FL"], fps=200.0)
    own["origin"][:] = ORIGIN_CODE["measured"]
    own["origin"][3, 0, 0] = ORIGIN_CODE["edited"]
    own["origin"][5:, 1, 0] = ORIGIN_CODE["missing"]
    other = own.copy()
    other.attrs = own.attrs | {"source_software": "DeepLabCut", "fps": 500.0}
    text = tracking_sentences([own, other])
    assert "20 frames at 200 to 500 frames a second by pawnb, DeepLabCut" in text
    assert "1 of 15 labels were placed by hand" in text  # those of DeepLabCut do not say
    assert tracking_sentences([]) == ""


def test_differences_of_groups_stand_in_a_line_with_both_kinds_of_p():
    row = {"measure": "duty factor", "leg": "all", "reference": np.nan, "group_a": "ctl",
           "group_b": "cut", "n_animals_a": 2, "n_animals_b": 3, "mean_a": 0.6472, "mean_b": 0.7037,
           "difference": 0.0565, "ci_low": 0.03797, "ci_high": 0.07503, "p": 0.0055,
           "p_adjusted": 0.0055, "p_all_measures": 0.0715}  # fmt: skip
    phase = row | {"measure": "phase", "leg": "FR", "reference": "HR", "ci_low": np.nan}
    made = _by_group(pd.DataFrame([row, phase]))
    assert made.iloc[0].tolist() == [
        "duty factor", "ctl 0.6472 (2); cut 0.7037 (3)", "0.0565 (0.03797 to 0.07503)", "0.0055",
        "0.0055", "0.0715",
    ]  # fmt: skip
    assert made.iloc[1, [0, 2]].tolist() == ["phase FR to HR", "0.0565"]


def test_measures_stand_by_leg_with_their_units():
    values = pd.DataFrame(
        [["FR", say_measure("stride_length", unit="mm"), 60.04, 55.0, 65.0],
         ["FL", say_measure("stride_length", unit="mm"), 61.0, np.nan, np.nan],
         ["FR", say_measure("speed", unit="mm"), 300.0, np.nan, np.nan],
         ["FL", say_measure("swing_s", unit="mm"), np.nan, np.nan, np.nan]],
        columns=["leg", "measure", "mean", "ci_low", "ci_high"],
    )  # fmt: skip
    found = _by_leg(values)
    assert found.columns.tolist() == ["measure", "FR", "FL"]
    assert found.to_numpy().tolist() == [
        ["stride length (mm)", "60.04 (55 to 65)", "61"], ["speed (mm/s)", "300", ""],
    ]  # fmt: skip
    assert say_measure("swing_s", unit="mm") == "swing (s)"
    assert say_measure("stride_length") == "stride length"


def test_what_was_left_out_is_counted_whichever_stride_it_was():
    why = ["no AEP of R2 within stride 3 of R4", "no AEP of R2 within stride 11 of R4", "too long"]
    dropped = pd.DataFrame({"what": ["phase", "phase", "stride"], "why": why})
    found = count_dropped(dropped, ["what", "why"])
    assert found.to_numpy().tolist() == [
        ["phase", "no AEP of R2 within a stride of R4", 2], ["stride", "too long", 1],
    ]  # fmt: skip


@pytest.mark.slow
def test_a_run_has_an_index_and_its_methods(tmp_path):
    events().to_csv(tmp_path / "scored.csv", index=False)
    run = run_gait(tmp_path / "scored.csv", figures="main", out=tmp_path / "out")
    found = Reader((run.out / "index.html").read_text())
    named = {unquote(name).removeprefix("./") for name in found.named}
    written = {path.relative_to(run.out).as_posix() for path in run.files}
    assert named | {"index.html"} >= written
    assert all((run.out / name).exists() for name in named)
    assert "20 strides" in (run.out / "methods.txt").read_text()
    manifest = json.loads((run.out / "provenance.json").read_text())
    assert {"index.html", "methods.txt"} <= set(manifest["files"])


@pytest.mark.slow
def test_the_report_stands_alone(tmp_path, capsys):
    events((*"ab", HOSTILE), groups=True).to_csv(tmp_path / "scored.csv", index=False)
    target = tmp_path / "r.html"
    assert main(["report", str(tmp_path / "scored.csv"), "-o", str(target)]) == 0
    source = target.read_text()
    found = Reader(source)
    assert found.named
    assert all(name.startswith("data:image/png;base64,") for name in found.named)
    assert not re.search(r"https?://", source)
    assert str(tmp_path) not in source
    assert "Gait of 3 animals" in found.said
    assert {"Methods", "What was left out", "Notes", "Tables", "Figures"} <= set(found.said)
    assert sorted(path.name for path in Path(tmp_path).iterdir()) == ["r.html", "scored.csv"]


@pytest.mark.slow
def test_names_that_look_like_numbers_or_like_nothing_stay_names(tmp_path):
    """Animal 01 is not animal 1, and a group may be called NA."""
    rows = events(("01", "1", "NA", "nan"), groups=True)
    rows["group"] = rows["group"].map({"01": "NA", "1": "NA", "NA": "1.0", "nan": "1.0"})
    rows.to_csv(tmp_path / "scored.csv", index=False)
    said = Reader(write_report(tmp_path / "scored.csv").read_text()).said
    counted = said[said.index("Animals and strides") :][: said.index("Methods")]
    for name in ("01", "1", "NA", "nan", "1.0"):
        assert name in counted
    assert any("NA" in words and "1.0" in words and "(2)" in words for words in said)
